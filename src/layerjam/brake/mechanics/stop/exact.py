"""Exact stop of a mass by the brake at constant vacuum (paper, section III-E).

The mass hangs on a spring k (rope and brake in series) and on the brake, which slips by s once the
force has reached Y(0). The kinetic energy at slip s, K(s), follows from work and energy in closed
form, and the travel is its first root. In w = sqrt(s) it is a quartic, smooth at the start.
"""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import choose, freeze, repeat_while, xp
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt
from layerjam.brake.mechanics.roots import newton_root
from layerjam.brake.mechanics.slip_effects import friction_force, scale_friction
from layerjam.brake.mechanics.speed_effects import brake_growth, depends_on_speed, has_speed_effects
from layerjam.brake.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    Quartic,
    Stop,
    bracket_root,
    curvature_step,
    guess_root,
    make_setup,
    make_stop,
    polish_root,
    quartic_slope,
    quartic_value,
)
from layerjam.brake.mechanics.stop.energy_curve import (
    Mass,
    energy_left,
    make_curve,
    mass_energy,
    sliding_time,
    solve_stop,
)
from layerjam.brake.mechanics.stop.paced import (
    Course,
    PacedProblem,
    new_case,
    paced_course,
    paced_stop,
)

__all__ = ["BOTTOMED_OUT", "NEVER_SLID", "NOT_A_CASE", "SNAPS", "STOPPED"]
__all__ += ["Stop", "speed_at_slip", "stop", "time_at_slip"]
STEPS, MOST_STEPS = 3, 8
"""Number of curvature steps that every case takes, and at most."""
SETTLED = 1e-5
"""Relative size of the last step of the root search below which the next one has no effect."""


def paced_setup(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> PacedProblem:
    """Return the constants of a stop with a speed law; sliding starts at the friction at rest."""
    sheets, enclosure = sheet_law(vacuum, brake), enclosure_law(vacuum, brake)
    at_rest = scale_friction(sheets, brake_growth(0.0, brake))
    rest_friction = friction_force(0.0, at_rest) / sheets.overlap
    case = make_setup(mass, speed, rest_friction, sheets.overlap, enclosure, spring, gravity)
    case = case._replace(c=sheets.c + xp.zeros_like(rest_friction))
    return new_case(case, gravity, sheets.shapes, brake)


def first_root(energy: Quartic, low: Any, high: Any) -> Any:
    """Return the place in [low, high] at which the falling kinetic energy is zero; no gradient.

    It takes curvature steps from the root without an enclosure, each case until it has settled.
    Newton steps limited to the bracket follow for those that have not.
    """
    energy, low, high = freeze((energy, low, high))

    def is_open(size: Any) -> Any:
        return size > SETTLED * high

    def step(state: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        root, size, count = state
        goes_on, new = is_open(size), curvature_step(energy, root, low, high)
        return xp.where(goes_on, new, root), xp.where(goes_on, abs(new - root), size), count + 1

    def is_unfinished(state: tuple[Any, Any, Any]) -> Any:
        _, size, count = state
        return (count < MOST_STEPS) & xp.any(is_open(size))

    def rising(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        return -quartic_value(energy, state[0]), -quartic_slope(energy, state[0]), None

    before = root = guess_root(energy, low, high)
    for _ in range(STEPS):
        before, root = root, curvature_step(energy, root, low, high)
    root, size, _ = repeat_while(is_unfinished, step, (root, abs(root - before), STEPS))
    needs_search = is_open(size)

    def search() -> Any:
        return xp.where(needs_search, newton_root(rising, (low + high) / 2, low, high), root)

    return choose(xp.any(needs_search), search, lambda: root)


@law(of_points=True)
def stop(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Stop a mass [kg] that arrives with `speed` [m/s] on a taut rope, at a vacuum [Pa].

    `spring` [N/m] is rope and brake in series, `gravity` [m/s^2] acts along the pull (0 for a
    horizontal one); all broadcast. The result is exact: closed-form work, and its first root. A
    speed law of a power above 0 is integrated (see `paced_stop`) and has no reverse derivative. The
    work of a hyperelastic enclosure is a quadrature; NOT_A_CASE if it is stretched too far.
    """
    result = _solve(mass, speed, vacuum, spring, gravity, brake)
    if not has_speed_effects(brake):
        return result
    shape = xp.shape(result.slip)
    arrays = (xp.broadcast_to(a, shape) for a in (mass, speed, vacuum, spring, gravity))
    mass, speed, vacuum, spring, gravity = arrays
    paced_result = paced_stop(paced_setup(mass, speed, vacuum, spring, gravity, brake), speed)
    is_valid = result.outcome != NOT_A_CASE
    is_paced = depends_on_speed(brake) & is_valid
    values = [xp.where(is_paced, *pair) for pair in zip(paced_result, result, strict=True)]
    return _keep_cases(Stop(*values), True)


def _keep_cases(end: Stop, is_valid: Any) -> Stop:
    """Return the stops that are valid, otherwise NOT_A_CASE and NaN."""
    outcome = xp.where(is_valid, end.outcome, NOT_A_CASE)
    return Stop(*(keep_if(outcome != NOT_A_CASE, x) for x in end))._replace(outcome=outcome)


def _solve(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Return the stop with a friction that does not depend on speed."""
    mass, speed, vacuum, spring, gravity = xp.broadcast_arrays(mass, speed, vacuum, spring, gravity)
    is_valid = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    curve, travel = make_curve(vacuum, brake), brake.sheets.usable_travel
    if not curve.is_quartic:
        # replace invalid cases by a dummy, because the search would meet NaN
        mass, speed, vacuum, spring, gravity = (
            xp.where(is_valid, x, 1.0) for x in (mass, speed, vacuum, spring, gravity)
        )
        curve, load = make_curve(vacuum, brake), Mass(mass, speed, spring, gravity)
        start = mass_energy(curve.point_at(xp.zeros_like(mass)), load)
        end = solve_stop(curve, travel, load)
        return _keep_cases(end, is_valid & (end.peak_force >= 0) & xp.isfinite(start))
    case = curve.make_setup(Mass(mass, speed, spring, gravity))
    bracket = bracket_root(case, travel + xp.zeros_like(case.kinetic))
    # the search is not differentiated, but the polishing step carries the gradient of the root
    root = first_root(bracket.energy, bracket.low, bracket.high)
    slope = freeze(quartic_slope(bracket.energy, root))
    root = polish_root(bracket.energy, root, slope)
    end = make_stop(case, bracket, root)
    is_valid = is_valid & xp.isfinite(case.kinetic) & (case.onset + case.enclosure.root >= 0)
    return _keep_cases(end, is_valid)


@law
def stop_course(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> tuple[Any, Course]:
    """Return the time of the onset [s] and the motion after it, for one stop with a speed law."""
    case = paced_setup(mass, speed, vacuum, spring, gravity, brake)
    return _elastic_time(mass, speed, gravity, spring, case.setup.onset, True), paced_course(
        case, speed
    )


def _elastic_time(mass: Any, speed: Any, gravity: Any, spring: Any, force: Any, slides: Any) -> Any:
    """Return the time [s] until the brake begins to slide, or else to the first standstill."""
    omega = xp.sqrt(spring / mass)
    sag, swing = gravity / omega**2, speed / omega
    size = xp.sqrt(sag**2 + swing**2)
    size = xp.where(size > 0, size, 1.0)
    phase = xp.arctan2(sag, swing)
    onset = xp.arcsin(xp.clip((force / spring - sag) / size, -1, 1))
    return (xp.where(slides, onset, xp.pi / 2) + phase) / omega


@law
def speed_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the speed of the mass [m/s] at a slip [m] of the brake; NaN past its standstill.

    Also NaN with a speed law, which has no closed form.
    """
    arrays = xp.broadcast_arrays(slip, mass, speed, vacuum, spring, gravity)
    slip, mass, speed, vacuum, spring, gravity = arrays
    energy = energy_left(slip, make_curve(vacuum, brake), Mass(mass, speed, spring, gravity))
    return keep_if(~xp.asarray(depends_on_speed(brake)), safe_sqrt(energy * 2 / mass))


@law
def time_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the time [s] from the taut rope until the brake has slipped by `slip` [m].

    It is NaN beyond the first standstill or the snap. If the brake never slides, it is the time of
    the standstill on the spring for a slip of zero, and NaN above. The elastic part has a closed
    form. The sliding part is a Gauss quadrature of dz/v in pieces, divided where the mass is
    slowest or fastest and where the enclosure saturates.
    """
    arrays = xp.broadcast_arrays(slip, mass, speed, vacuum, spring, gravity)
    slip, mass, speed, vacuum, spring, gravity = arrays
    curve, load = make_curve(vacuum, brake), Mass(mass, speed, spring, gravity)
    onset, weight = curve.point_at(0.0 * slip).force, load.weight
    slip = slip + 0.0 * onset
    is_sliding = weight + xp.sqrt(weight**2 + spring * mass * speed**2) > onset
    start = _elastic_time(mass, speed, gravity, spring, onset, is_sliding)
    is_met = (slip == 0) | (is_sliding & (energy_left(slip, curve, load) >= 0))
    time = start + sliding_time(slip, curve, load)
    return keep_if(is_met & ~xp.asarray(depends_on_speed(brake)), time)
