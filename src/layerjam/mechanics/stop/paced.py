"""A mass stopped at constant vacuum by sheets whose friction grows with their speed (ours).

Friction is S(x, u) = c (L2 - x) G(u), x the slip, u its rate, G the brake's speed law; that of a
fan is c (L2 - x) G(u) R(x, G(u)), with its factor R at the friction coefficient of that speed. The
enclosure's force E(x) does not depend on speed. Mass M, spring k (rope and brake in series) and
brake are in series,

    k (z - x) = S(x, u) + E(x),    M v' = M g - k (z - x),    z' = v,    x' = u,

so that u follows the force without a jump: it starts at zero when the force reaches S(0, 0), and
nothing snaps. Integrated by a Rosenbrock method that a weak dependence does not slow down, at a
relative tolerance of 1e-7 a step.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.enclosure import (
    EnclosureLaw,
    backbone,
    backbone_dissipated,
    backbone_stored,
)
from layerjam.mechanics.fan import Fan, Sheets, grown, rise_with_friction, tangent
from layerjam.mechanics.fan import force_of as friction_of
from layerjam.mechanics.friction import growth
from layerjam.mechanics.roots import false_position
from layerjam.mechanics.stick_slip.slide_step import hermite_range
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    STOPPED,
    Setup,
    Stop,
    root_of,
)
from layerjam.mechanics.stop.rosenbrock import rosenbrock

TOLERANCE = 1e-7
"""Of a step, relative."""
COARSE = 1e-5
"""Of the steps of a second run, which shows what the first may be off."""
MOST = 5_000
"""Steps, tried ones among them."""
STILL = 1e-9
"""Speed of a mass that only creeps on, over its greatest: it counts as standing."""
BEGIN = 1e-4
"""How far the first moment of sliding is followed by its series, over its time scale."""
MOVING = -2
ROWS = 4000
"""Steps of a course that are kept."""
COLUMNS = 6
"""Of a course: time, slip, speed, pace of the slip, friction's heat, force."""


class Paced(NamedTuple):
    """Constants of one stop; arrays of one shape."""

    at: Setup
    """With the friction c [N/m] at the law's test speed, and the onset at rest."""
    overlap: Any
    travel: Any
    gravity: Any
    law: SpeedLaw
    fan: Fan | None
    """At the test speed."""


class Run(NamedTuple):
    """Where it has got to."""

    time: Any
    now: Any
    """Shape (4, ...): slip [m], speed of mass and of slip [m/s], heat of the sheets [J]."""
    step: Any
    """The next one [s]; once the run is over, the one that holds its end."""
    peak: Any
    code: Any
    tried: Any
    count: Any
    """Rows of the table."""
    table: Any


def _sheets(pace: Any, of: Paced) -> Sheets:
    """What the sheets resist with while they slide at a pace [m/s]."""
    made: Sheets = grown(Sheets(of.at.c, of.overlap, of.fan), growth(pace, of.law))
    return made


def force_of(now: Any, of: Paced) -> Any:
    """Force [N] in spring and brake."""
    slip, _, pace, _ = now
    return friction_of(slip, _sheets(pace, of)) + backbone(slip, of.at.enclosure)


def _stiffening(slip: Any, enclosure: EnclosureLaw) -> Any:
    """How the enclosure's force grows with slip [N/m]."""
    spread = enclosure.root / (2 * jnp.sqrt(jnp.where(slip > 0, slip, 1.0)))
    return jnp.where(slip < enclosure.saturation, spread, enclosure.stiffness / enclosure.reach)


def rates_of(now: Any, of: Paced) -> Any:
    """How slip, speed, pace and heat change, a second."""
    slip, speed, pace, _ = now
    law, at, sheets = of.law, of.at, _sheets(pace, of)
    inside = jnp.minimum(slip, of.overlap * (1 - 1e-9))
    slope = law.power / (law.rest_speed + pace) * rise_with_friction(inside, sheets)
    falls = tangent(slip, sheets).c - _stiffening(slip, at.enclosure)
    pull = at.k * (speed - pace) + falls * pace
    slows = of.gravity - force_of(now, of) / at.mass
    rubs = friction_of(inside, sheets) * pace
    return jnp.stack([pace, slows, pull / slope, rubs])


def _begun(of: Paced, arrival: Any) -> tuple[Any, Any]:
    """Time since the onset [s] and state a moment after it: u = a t, x = a t^2/2.

    There S'(0) a + e sqrt(a/2) = k v, S' that over the speed.
    """
    at, law = of.at, of.law
    rise = rise_with_friction(jnp.zeros_like(arrival), _sheets(0.0, of))
    slope = law.power / law.rest_speed * rise
    root = at.enclosure.root / jnp.sqrt(2.0)
    push = at.k * arrival
    a = (2 * push / (root + jnp.sqrt(root**2 + 4 * slope * push))) ** 2
    time = BEGIN * jnp.minimum(law.rest_speed, arrival) / a
    speed = arrival + (of.gravity - at.onset / at.mass) * time
    slip = a * time**2 / 2
    return time, jnp.stack([slip, speed, a * time, at.onset * slip])


def _attempt(run: Run, of: Paced, greatest: Any, tolerance: Any) -> Run:
    """One step, taken if its error allows it; the one that holds the end is left to `_ended`."""
    new, off = rosenbrock(lambda y: rates_of(y, of), run.now, run.step)
    slip, speed, pace, _ = run.now
    error = jnp.maximum(
        jnp.abs(off[0]) / (jnp.abs(slip) + 1e-6 * of.overlap),
        jnp.maximum(
            jnp.abs(off[1]) / (jnp.abs(speed) + 1e-3 * greatest),
            jnp.abs(off[2]) / (of.law.rest_speed + jnp.abs(pace)),
        ),
    )
    error = error / tolerance
    fine = (error <= 1) & (new[2] >= 0)
    going = run.code == MOVING
    ends = fine & ((new[1] <= 0) | (new[0] >= of.travel))
    creeps = fine & (new[1] <= STILL * greatest)
    taken = going & fine & ~ends
    before, after = force_of(run.now, of), force_of(new, of)
    swing = (before, _loading(run.now, of), after, _loading(new, of))
    highest = hermite_range(run.step, *swing)[0]
    factor = jnp.clip(0.9 * jnp.where(error > 0, error, 1e-9) ** -0.25, 0.2, 5.0)
    factor = jnp.where(jnp.isfinite(error), factor, 0.2)
    # a step with a negative pace is too long whatever its error says
    factor = jnp.where(fine, factor, jnp.minimum(factor, 0.5))
    code = jnp.where(ends | creeps, STOPPED, MOVING)
    return Run(
        time=jnp.where(taken, run.time + run.step, run.time),
        now=jnp.where(taken, new, run.now),
        step=jnp.where(going & ~ends, run.step * factor, run.step),
        peak=jnp.where(taken, jnp.maximum(run.peak, highest), run.peak),
        code=jnp.where(going, code, run.code),
        tried=run.tried + 1,
        count=run.count + taken,
        table=_written(run, taken, jnp.stack([run.time + run.step, *new, after])),
    )


def _written(run: Run, taken: Any, row: Any) -> Any:
    """The table with one more row where there is one; its last row takes what is not to be kept."""
    if run.table is None:
        return None
    end = run.table.shape[0] - 1
    place = jnp.where(taken, jnp.minimum(run.count, end), end)
    return jax.lax.dynamic_update_slice(run.table, row[None], (place, 0))


def _loading(now: Any, of: Paced) -> Any:
    """How the force changes [N/s]: k (v - u)."""
    return of.at.k * (now[1] - now[2])


def _ended(run: Run, of: Paced) -> Run:
    """Go to the standstill or end of travel that the next step holds."""

    def after(h: Any) -> Any:
        return rosenbrock(lambda y: rates_of(y, of), run.now, h).after

    def spent(h: Any) -> Any:
        """Return what a step has used up of speed or travel, less all of it; as a share."""
        new = jnp.where(h > 0, after(h), run.now)
        return jnp.maximum(-new[1] / run.now[1], (new[0] - of.travel) / of.travel)

    zero = jnp.zeros_like(run.step)
    found = false_position(spent, zero, run.step, 1e-13, 62)
    # a creeping mass has no end in its next step
    ends = found.is_met
    last = jnp.where(ends, found.best, 0.0)
    now = jnp.where(ends, after(found.best), run.now)
    used = ends & (now[0] >= of.travel * (1 - 1e-12)) & (now[1] > 0)
    swing = (force_of(run.now, of), _loading(run.now, of), force_of(now, of), _loading(now, of))
    highest = hermite_range(last, *swing)[0]
    slip, speed = jnp.where(used, of.travel, now[0]), jnp.where(used, now[1], 0.0)
    return run._replace(
        time=run.time + last,
        now=now.at[0].set(slip).at[1].set(speed),
        peak=jnp.maximum(run.peak, jnp.where(ends, highest, run.peak)),
        code=jnp.where(run.code == MOVING, NOT_A_CASE, jnp.where(used, BOTTOMED_OUT, STOPPED)),
    )


def slide_on(of: Paced, speed: Any, rows: int = 0, tolerance: float = TOLERANCE) -> tuple[Run, Run]:
    """From the onset to the first standstill or the end of travel: before its last step, and there.

    `speed` [m/s] is that on arrival. With `rows` the states of one stop are kept in a table.
    """
    arrival = root_of(2 * of.at.kinetic / of.at.mass)
    moves = arrival > 0
    time, now = _begun(of, jnp.where(moves, arrival, 1.0))
    greatest = jnp.maximum(jnp.maximum(speed, arrival), 1e-9)
    zero = jnp.zeros_like(time)
    first = Run(
        time=time,
        now=now,
        step=time,
        peak=zero + of.at.onset,
        code=jnp.where(moves, MOVING, STOPPED),
        tried=jnp.asarray(0),
        count=jnp.zeros(jnp.shape(time), int),
        table=jnp.zeros((rows + 1, COLUMNS)) if rows else None,
    )

    def going(run: Run) -> Any:
        return (run.tried < MOST) & jnp.any(run.code == MOVING)

    run = jax.lax.while_loop(going, lambda run: _attempt(run, of, greatest, tolerance), first)
    return run, _ended(run, of)


def paced_stop(of: Paced, speed: Any) -> Stop:
    """How the stop went; the elastic part, and a mass that never slides, in closed form."""
    at = of.at
    elastic = at.weight + root_of(at.weight**2 + 2 * at.k * at.arriving)
    slides = elastic > at.onset
    end = slide_on(of, speed)[1]
    slip, pace, _, rubbed = end.now
    enclosure = at.enclosure
    slip = jnp.where(slides, slip, 0.0)
    force = jnp.where(slides, force_of(end.now, of), elastic)
    return Stop(
        slip=slip,
        peak_force=jnp.where(slides, jnp.maximum(end.peak, force), elastic),
        end_speed=jnp.where(slides, pace, 0.0),
        heat=jnp.where(slides, rubbed, 0.0) + backbone_dissipated(slip, enclosure),
        stored=force**2 / (2 * at.k) + backbone_stored(slip, enclosure),
        outcome=jnp.where(slides, end.code, NEVER_SLID),
    )


class Course(NamedTuple):
    """A stop in time, from the onset of sliding; rows of time, slip, speed, pace, heat, force."""

    rows: Any
    """Shape (`ROWS` + 1, 6), of which `count` count."""
    count: Any
    end: Any
    """The last row, shape (6,): the standstill or the end of travel."""
    coarse: Any
    """The same after steps a hundred times less exact."""


def paced_course(of: Paced, speed: Any) -> Course:
    """The states of one stop, and what a second run with coarse steps gives."""
    run, last = slide_on(of, speed, ROWS)
    rough = slide_on(of, speed, tolerance=COARSE)[1]
    end, coarse = (jnp.stack([r.time, *r.now, force_of(r.now, of)]) for r in (last, rough))
    return Course(run.table, run.count, end, coarse)


def paced_of(at: Setup, gravity: Any, fan: Fan | None, brake: Brake, law: SpeedLaw) -> Paced:
    """The constants of a stop, all of one shape; `at` has the onset at rest."""
    shape = jnp.shape(at.kinetic)
    safe = SpeedLaw(
        power=jnp.where(law.power > 0, law.power, 1.0),  # type: ignore[arg-type]
        test_speed=law.test_speed,
        rest_speed=law.rest_speed,
    )
    whole = Paced(at, brake.sheets.overlap, brake.sheets.usable_travel, gravity, safe, fan)
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, shape), whole)
