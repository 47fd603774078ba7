"""Exact stop of a mass by the brake at constant vacuum (paper, section III-E).

The mass hangs on a spring k (rope and brake in series) and on the brake, which slips by s once the
force has reached Y(0). The kinetic energy at slip s, K(s), follows from work and energy in closed
form, and the travel is its first root. In w = sqrt(s) it is a quartic, smooth at the start.
"""

from typing import Any

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.enclosure import enclosure_law
from layerjam.mechanics.fan import fan_force, scale_friction
from layerjam.mechanics.friction import growth, sheet_law
from layerjam.mechanics.law import keep_if, law, safe_sqrt
from layerjam.mechanics.roots import newton_root
from layerjam.mechanics.stop.algebra import (
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
from layerjam.mechanics.stop.curve import Mass, make_curve, mass_energy, sliding_time, solve_stop
from layerjam.mechanics.stop.paced import Course, PacedProblem, new_case, paced_course, paced_stop

__all__ = ["BOTTOMED_OUT", "NEVER_SLID", "NOT_A_CASE", "SNAPS", "STOPPED"]
__all__ += ["Stop", "speed_at_slip", "stop", "time_at_slip"]
SETTLED = 1e-5
"""Relative size of the last step of the root search below which the next one has no effect."""


def paced_setup(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake, law: SpeedLaw
) -> PacedProblem:
    """Return the constants of a stop with a speed law; sliding starts at the friction at rest."""
    sheets, enclosure = sheet_law(vacuum, brake), enclosure_law(vacuum, brake)
    rest_friction = fan_force(0.0, scale_friction(sheets, growth(0.0, law))) / sheets.overlap
    case = make_setup(mass, speed, rest_friction, sheets.overlap, enclosure, spring, gravity)
    case = case._replace(c=sheets.c + jnp.zeros_like(rest_friction))
    return new_case(case, gravity, sheets.fan, brake, law)


def _first_root(energy: Quartic, low: Any, high: Any) -> Any:
    """Return sqrt of the slip in [low, high] at which the falling kinetic energy is zero.

    It takes three curvature steps from the root without an enclosure. If any case has not settled,
    Newton steps limited to the bracket follow for all cases.
    """
    before = guess_root(energy, low, high)
    for _ in range(2):
        before = curvature_step(energy, before, low, high)
    root = curvature_step(energy, before, low, high)
    has_settled = jnp.all(~(jnp.abs(root - before) > SETTLED * high))

    def rising(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        return -quartic_value(energy, state[0]), -quartic_slope(energy, state[0]), None

    return jax.lax.cond(
        has_settled, lambda: root, lambda: newton_root(rising, (low + high) / 2, low, high)
    )


@law
def stop(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Stop a mass [kg] that arrives with `speed` [m/s] on a taut rope, at a vacuum [Pa].

    `spring` [N/m] is rope and brake in series, `gravity` [m/s^2] acts along the pull (0 for a
    horizontal one); all broadcast. The result is exact: closed-form work, and its first root. A
    speed law of a power above 0 is integrated (see `paced_stop`) and has no reverse derivative. The
    work of a hyperelastic enclosure is a quadrature; NOT_A_CASE if it is stretched too far.
    """
    result = _solve(mass, speed, vacuum, spring, gravity, brake)
    law = brake.speed_law
    if law is None:
        return result
    shape = jnp.shape(result.slip)
    arrays = (jnp.broadcast_to(a, shape) for a in (mass, speed, vacuum, spring, gravity))
    mass, speed, vacuum, spring, gravity = arrays
    paced_result = paced_stop(paced_setup(mass, speed, vacuum, spring, gravity, brake, law), speed)
    fine = result.outcome != NOT_A_CASE
    is_paced = (law.power > 0) & fine
    values = [jnp.where(is_paced, *pair) for pair in zip(paced_result, result, strict=True)]
    return _keep_cases(Stop(*values), True)


def _keep_cases(end: Stop, fine: Any) -> Stop:
    """Return the stops that are valid, otherwise NOT_A_CASE and NaN."""
    outcome = jnp.where(fine, end.outcome, NOT_A_CASE)
    return Stop(*(keep_if(outcome != NOT_A_CASE, x) for x in end))._replace(outcome=outcome)


def _solve(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Return the stop with a friction that does not depend on speed."""
    mass, speed, vacuum, spring, gravity = jnp.broadcast_arrays(
        mass, speed, vacuum, spring, gravity
    )
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    curve, travel = make_curve(vacuum, brake), brake.sheets.usable_travel
    if not curve.is_quartic:
        # outside its domain the search would meet NaN, so it gets a dummy case
        mass, speed, vacuum, spring, gravity = (
            jnp.where(fine, x, 1.0) for x in (mass, speed, vacuum, spring, gravity)
        )
        end = solve_stop(make_curve(vacuum, brake), travel, Mass(mass, speed, spring, gravity))
        return _keep_cases(end, fine & (end.peak_force >= 0))
    case = curve.make_setup(Mass(mass, speed, spring, gravity))
    bracket = bracket_root(case, travel + jnp.zeros_like(case.kinetic))
    # the search is not differentiated, but the polishing step carries the gradient of the root
    energy, low, high = jax.lax.stop_gradient((bracket.energy, bracket.low, bracket.high))
    root = _first_root(energy, low, high)
    root = polish_root(bracket.energy, root, jax.lax.stop_gradient(quartic_slope(energy, root)))
    end = make_stop(case, bracket, root)
    return _keep_cases(end, fine & (case.onset + case.enclosure.root >= 0))


@law
def stop_course(
    law: SpeedLaw, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> tuple[Any, Course]:
    """Return the time of the onset [s] and the motion after it, for one stop with a speed law."""
    case = paced_setup(mass, speed, vacuum, spring, gravity, brake, law)
    return _elastic_time(mass, speed, gravity, spring, case.setup.onset, True), paced_course(
        case, speed
    )


def _elastic_time(mass: Any, speed: Any, gravity: Any, spring: Any, force: Any, slides: Any) -> Any:
    """Return the time [s] until the brake begins to slide, or else to the first standstill."""
    omega = jnp.sqrt(spring / mass)
    sag, swing = gravity / omega**2, speed / omega
    size = jnp.sqrt(sag**2 + swing**2)
    size = jnp.where(size > 0, size, 1.0)
    phase = jnp.arctan2(sag, swing)
    onset = jnp.arcsin(jnp.clip((force / spring - sag) / size, -1, 1))
    return (jnp.where(slides, onset, jnp.pi / 2) + phase) / omega


@law
def speed_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the speed of the mass [m/s] at a slip [m] of the brake; NaN past its standstill.

    Also NaN with a speed law, which has no closed form.
    """
    curve, load = make_curve(vacuum, brake), Mass(mass, speed, spring, gravity)
    left = mass_energy(curve.point_at(curve.enclosure.find_place(slip)), load)
    size = load.arrival_energy + load.weight * slip
    # rounding may put a standstill on either side of zero
    pace = safe_sqrt(jnp.where(left < -1e-9 * size, left, jnp.maximum(left, 0.0)) * 2 / mass)
    return keep_if(is_speed_independent(brake), pace)


def is_speed_independent(brake: Brake) -> Any:
    """Return whether friction is the same at every speed."""
    return jnp.asarray(True if brake.speed_law is None else brake.speed_law.power == 0)


@law
def time_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the time [s] from the taut rope until the brake has slipped by `slip` [m].

    It is NaN beyond the standstill. The elastic part has a closed form. The sliding part is a Gauss
    quadrature of dz/v in pieces, divided where the mass is slowest or fastest and where the
    enclosure saturates.
    """
    arrays = jnp.broadcast_arrays(slip, mass, speed, vacuum, spring, gravity)
    slip, mass, speed, vacuum, spring, gravity = arrays
    curve, load = make_curve(vacuum, brake), Mass(mass, speed, spring, gravity)
    onset, weight = curve.point_at(0.0 * slip).force, load.weight
    slip = slip + 0.0 * onset
    slides = weight + jnp.sqrt(weight**2 + spring * mass * speed**2) > onset
    start = _elastic_time(mass, speed, gravity, spring, onset, slides)
    return keep_if(is_speed_independent(brake), start + sliding_time(slip, curve, load))
