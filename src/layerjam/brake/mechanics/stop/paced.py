"""Stop of a mass at constant vacuum by sheets whose friction grows with their speed (ours).

Friction is S(x, u) = c (L2 - x) G(u), with x the slip, u its rate, and G the brake's speed law. For
a fan it is c (L2 - x) G(u) R(x, G(u)), with R its factor at the friction coefficient of that speed.
The enclosure's force E(x) does not depend on speed. Mass M, spring k (rope and brake) and brake are
in series,

k (z - x) = S(x, u) + E(x), M v' = M g - k (z - x), z' = v, x' = u,

so that u follows the force without a jump: it starts at zero when the force reaches S(0, 0), and
nothing snaps. It is integrated by a Rosenbrock method, which is also fast for a weak dependence on
speed, at a relative tolerance of 1e-7 per step.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import map_leaves, put, repeat_while, xp
from layerjam.brake.mechanics.enclosure import EnclosureLaw
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.roots import false_position
from layerjam.brake.mechanics.slip_effects import (
    Sheets,
    friction_force,
    friction_tangent,
    log_slope,
    scale_friction,
)
from layerjam.brake.mechanics.speed_effects import brake_growth, growth_slope, rest_speed
from layerjam.brake.mechanics.stick_slip.slide_step import hermite_range
from layerjam.brake.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    STOPPED,
    Setup,
    Stop,
    positive_root,
)
from layerjam.brake.mechanics.stop.rosenbrock import rosenbrock

TOLERANCE = 1e-7
"""Relative error tolerance of a step."""
COARSE = 1e-5
"""Tolerance of a second run, from which the error of the first is estimated."""
MAX_STEPS = 5_000
"""Largest number of steps, including rejected ones."""
STILL = 1e-9
"""Speed of a creeping mass, relative to its highest, below which it counts as at rest."""
BEGIN = 1e-4
"""Time after the onset in which a series replaces the integration, relative to its time scale."""
MOVING = -2
ROWS = 4000
"""Number of stored steps of a motion."""
COLUMNS = 6
"""Columns of a motion: time, slip, speed, pace of the slip, frictional heat, force."""


class PacedProblem(NamedTuple):
    """Constants of one stop; arrays of the same shape."""

    setup: Setup
    """Setup with the friction c [N/m] at the law's test speed, and the onset at rest."""
    overlap: Any
    travel: Any
    gravity: Any
    brake: Brake
    shapes: tuple[Any, ...]
    """Effects of the slip on the friction at the test speed."""


class Run(NamedTuple):
    """State of the integration."""

    time: Any
    state: Any
    """Shape (4, ...): slip [m], speed of mass and of slip [m/s], heat of the sheets [J]."""
    step: Any
    """Next step [s]; after the end of the run, the step that contains the end."""
    peak: Any
    code: Any
    attempts: Any
    count: Any
    """Number of rows in the table."""
    table: Any


def _sliding_sheets(pace: Any, case: PacedProblem) -> Sheets:
    """Return the sheets' friction while they slide at a pace [m/s]."""
    sheets: Sheets = scale_friction(
        Sheets(case.setup.c, case.overlap, case.shapes), brake_growth(pace, case.brake)
    )
    return sheets


def paced_force(state: Any, case: PacedProblem) -> Any:
    """Return the force [N] in spring and brake."""
    slip, _, pace, _ = state
    return friction_force(slip, _sliding_sheets(pace, case)) + case.setup.enclosure.force(slip)


def _enclosure_slope(slip: Any, enclosure: EnclosureLaw) -> Any:
    """Return the slope of the enclosure's force versus slip [N/m]."""
    spread = enclosure.root / (2 * xp.sqrt(xp.where(slip > 0, slip, 1.0)))
    return xp.where(slip < enclosure.saturation, spread, enclosure.stiffness / enclosure.reach)


def state_rates(state: Any, case: PacedProblem) -> Any:
    """Return the rates of slip, speed, pace and heat."""
    slip, speed, pace, _ = state
    setup, sheets = case.setup, _sliding_sheets(pace, case)
    inside = xp.minimum(slip, case.overlap * (1 - 1e-9))
    slope = growth_slope(pace, case.brake) * log_slope(inside, sheets)
    falls = friction_tangent(slip, sheets).c - _enclosure_slope(slip, setup.enclosure)
    pull = setup.k * (speed - pace) + falls * pace
    slows = case.gravity - paced_force(state, case) / setup.mass
    rubs = friction_force(inside, sheets) * pace
    return xp.stack([pace, slows, pull / slope, rubs])


def _first_moment(case: PacedProblem, arrival: Any) -> tuple[Any, Any]:
    """Return the time since the onset [s] and the state shortly after it: u = a t, x = a t^2/2.

    The factor a solves S'(0) a + e sqrt(a/2) = k v, with S' the derivative with respect to speed.
    """
    setup, still = case.setup, rest_speed(case.brake)
    rise = log_slope(xp.zeros_like(arrival), _sliding_sheets(0.0, case))
    slope = growth_slope(0.0, case.brake) * rise
    root = setup.enclosure.root / xp.sqrt(2.0)
    push = setup.k * arrival
    a = (2 * push / (root + xp.sqrt(root**2 + 4 * slope * push))) ** 2
    time = BEGIN * xp.minimum(still, arrival) / a
    speed = arrival + (case.gravity - setup.onset / setup.mass) * time
    slip = a * time**2 / 2
    return time, xp.stack([slip, speed, a * time, setup.onset * slip])


def _try_step(run: Run, case: PacedProblem, greatest: Any, tolerance: Any) -> Run:
    """Take one step if its error allows it; `_finish_run` takes the step that contains the end."""
    new, errors = rosenbrock(lambda y: state_rates(y, case), run.state, run.step)
    slip, speed, pace, _ = run.state
    error = xp.maximum(
        xp.abs(errors[0]) / (xp.abs(slip) + 1e-6 * case.overlap),
        xp.maximum(
            xp.abs(errors[1]) / (xp.abs(speed) + 1e-3 * greatest),
            xp.abs(errors[2]) / (rest_speed(case.brake) + xp.abs(pace)),
        ),
    )
    error = error / tolerance
    fine = (error <= 1) & (new[2] >= 0)
    going = run.code == MOVING
    ends = fine & ((new[1] <= 0) | (new[0] >= case.travel))
    creeps = fine & (new[1] <= STILL * greatest)
    accepts = going & fine & ~ends
    before, after = paced_force(run.state, case), paced_force(new, case)
    swing = (before, _force_rate(run.state, case), after, _force_rate(new, case))
    highest = hermite_range(run.step, *swing)[0]
    factor = xp.clip(0.9 * xp.where(error > 0, error, 1e-9) ** -0.25, 0.2, 5.0)
    factor = xp.where(xp.isfinite(error), factor, 0.2)
    # a step with a negative pace is too long, whatever its error estimate
    factor = xp.where(fine, factor, xp.minimum(factor, 0.5))
    code = xp.where(ends | creeps, STOPPED, MOVING)
    return Run(
        time=xp.where(accepts, run.time + run.step, run.time),
        state=xp.where(accepts, new, run.state),
        step=xp.where(going & ~ends, run.step * factor, run.step),
        peak=xp.where(accepts, xp.maximum(run.peak, highest), run.peak),
        code=xp.where(going, code, run.code),
        attempts=run.attempts + 1,
        count=run.count + accepts,
        table=_add_row(run, accepts, xp.stack([run.time + run.step, *new, after])),
    )


def _add_row(run: Run, accepts: Any, row: Any) -> Any:
    """Return the table with one more row if `accepts`.

    The table's last row receives discarded values.
    """
    if run.table is None:
        return None
    end = run.table.shape[0] - 1
    place = xp.where(accepts, xp.minimum(run.count, end), end)
    return put(run.table, place, row)


def _force_rate(state: Any, case: PacedProblem) -> Any:
    """Return the rate of the force [N/s]: k (v - u)."""
    return case.setup.k * (state[1] - state[2])


def _finish_run(run: Run, case: PacedProblem) -> Run:
    """Advance to the standstill or end of travel within the next step."""

    def state_after(h: Any) -> Any:
        return rosenbrock(lambda y: state_rates(y, case), run.state, h).after

    def used_fraction(h: Any) -> Any:
        """Return the fraction of speed or travel that a step has used up, minus one."""
        new = xp.where(h > 0, state_after(h), run.state)
        return xp.maximum(-new[1] / run.state[1], (new[0] - case.travel) / case.travel)

    zero = xp.zeros_like(run.step)
    root = false_position(used_fraction, zero, run.step, 1e-13, 62)
    # a creeping mass does not stop within the next step
    ends = root.is_met
    last = xp.where(ends, root.best, 0.0)
    state = xp.where(ends, state_after(root.best), run.state)
    used = ends & (state[0] >= case.travel * (1 - 1e-12)) & (state[1] > 0)
    swing = (
        paced_force(run.state, case),
        _force_rate(run.state, case),
        paced_force(state, case),
        _force_rate(state, case),
    )
    highest = hermite_range(last, *swing)[0]
    slip, speed = xp.where(used, case.travel, state[0]), xp.where(used, state[1], 0.0)
    return run._replace(
        time=run.time + last,
        state=put(put(state, 0, slip), 1, speed),
        peak=xp.maximum(run.peak, xp.where(ends, highest, run.peak)),
        code=xp.where(run.code == MOVING, NOT_A_CASE, xp.where(used, BOTTOMED_OUT, STOPPED)),
    )


def run_slide(
    case: PacedProblem, speed: Any, rows: int = 0, tolerance: float = TOLERANCE
) -> tuple[Run, Run]:
    """Integrate to the standstill or end of travel; return the runs before and after the last step.

    `speed` [m/s] is that on arrival. With `rows` the states of one stop are kept in a table.
    """
    arrival = positive_root(2 * case.setup.kinetic / case.setup.mass)
    moves = arrival > 0
    time, state = _first_moment(case, xp.where(moves, arrival, 1.0))
    greatest = xp.maximum(xp.maximum(speed, arrival), 1e-9)
    zero = xp.zeros_like(time)
    first = Run(
        time=time,
        state=state,
        step=time,
        peak=zero + case.setup.onset,
        code=xp.where(moves, MOVING, STOPPED),
        attempts=xp.asarray(0),
        count=xp.zeros(xp.shape(time), int),
        table=xp.zeros((rows + 1, COLUMNS)) if rows else None,
    )

    def is_moving(run: Run) -> Any:
        return (run.attempts < MAX_STEPS) & xp.any(run.code == MOVING)

    run = repeat_while(is_moving, lambda r: _try_step(r, case, greatest, tolerance), first)
    return run, _finish_run(run, case)


@compiled
def paced_stop(case: PacedProblem, speed: Any) -> Stop:
    """Return the outcome; the elastic part, and a mass that never slides, are in closed form."""
    setup = case.setup
    elastic = setup.weight + positive_root(setup.weight**2 + 2 * setup.k * setup.arriving)
    slides = elastic > setup.onset
    end = run_slide(case, speed)[1]
    slip, pace, _, sheet_heat = end.state
    enclosure = setup.enclosure
    slip = xp.where(slides, slip, 0.0)
    force = xp.where(slides, paced_force(end.state, case), elastic)
    return Stop(
        slip=slip,
        peak_force=xp.where(slides, xp.maximum(end.peak, force), elastic),
        end_speed=xp.where(slides, pace, 0.0),
        heat=xp.where(slides, sheet_heat, 0.0) + enclosure.heat(slip),
        stored=force**2 / (2 * setup.k) + enclosure.stored_energy(slip),
        outcome=xp.where(slides, end.code, NEVER_SLID),
    )


class Course(NamedTuple):
    """A stop in time from the onset of sliding; rows of time, slip, speed, pace, heat, force."""

    rows: Any
    """Shape (`ROWS` + 1, 6), of which `count` are valid."""
    count: Any
    end: Any
    """The last row, shape (6,): the standstill or the end of travel."""
    coarse: Any
    """The last row of a run with a tolerance a hundred times larger."""


@compiled
def paced_course(case: PacedProblem, speed: Any) -> Course:
    """Return the states of one stop, and the result of a second run with coarse steps."""
    run, last = run_slide(case, speed, ROWS)
    rough = run_slide(case, speed, tolerance=COARSE)[1]
    end, coarse = (xp.stack([r.time, *r.state, paced_force(r.state, case)]) for r in (last, rough))
    return Course(run.table, run.count, end, coarse)


def new_case(setup: Setup, gravity: Any, shapes: tuple[Any, ...], brake: Brake) -> PacedProblem:
    """Return the constants of a stop, all of the same shape; `setup` has the onset at rest."""
    shape = xp.shape(setup.kinetic)
    sheets = brake.sheets
    case = PacedProblem(setup, sheets.overlap, sheets.usable_travel, gravity, brake, shapes)
    return map_leaves(lambda leaf: xp.broadcast_to(leaf, shape), case)
