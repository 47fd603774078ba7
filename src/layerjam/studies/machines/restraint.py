"""Identical brakes in a strap that restrains a body, simulated in time.

The strap is an elastic element that slips, with the force k (u - S), where u is its payout and S
the total slip of all brakes in a chain. The force of a brake falls after its peak. In a chain, the
brakes therefore slip one after another, each to the end of its travel, where an end stop of webbing
carries the load. The order does not matter for identical brakes. At a payout that exceeds all
earlier ones, the slip is the closed form of a slow pull (mechanics, section 2). Below that payout
the strap is elastic, and it can only pull. When all travel is used up, end stops hold the strap.
The slip of the other brakes in a chain before their peak (0.19 mm each at full vacuum) is ignored.

If friction grows with the sliding speed (a brake with a speed law), identical brakes in a chain
share its slip evenly, and nothing snaps: force k (u - S) = R(S/s, S'/s). s is the number of brakes
in series and R the sliding force of all chains at a slip and a speed. A difference in slip or
friction between two brakes in a chain grows with the slip x of each as (L2/(L2 - x))^(1/n), n the
law's exponent.

The same applies to rotation with a lever arm: payout = lever * angle, mass = inertia / lever^2.
"""

from typing import Any, NamedTuple

import numpy as np
import pandas

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import derivative, leaves, map_leaves, repeat_while, scan, xp
from layerjam.brake.mechanics.effects import require_linear
from layerjam.brake.mechanics.enclosure import EnclosureLaw, check_modulus, make_enclosure
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.law import compiled, law
from layerjam.brake.mechanics.speed_effects import (
    brake_growth,
    growth_slope,
    has_speed_effects,
    remove_idle_speed_law,
    rest_speed,
)
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.studies.machines.scenario import Array, Scenario

ROOMS = (256, 4096)
"""Numbers of cases (lanes) computed at once; smaller batches are padded."""
NEWTON = 60
SETTLED = 1e-11
"""Size of the last step of a converged search, relative to the slip in one time step."""
LITTLE = 1e-9
"""Smallest slip per time step [m] that the search assumes."""


class Strap(NamedTuple):
    """Constants of a strap with all its chains; the fields broadcast."""

    stiffness: Any
    """Stiffness k of the stuck brakes and the webbing in series [N/m]."""
    onset: Any
    """Force at which an unused brake at rest slides, N c L2 [N]; infinite if nothing slides."""
    fall: Any
    """Fall of friction with slip, N c [N/m]; with a speed law, at the law's test speed."""
    sleeve: EnclosureLaw
    travel: Any
    """Usable travel of one brake [m]."""
    series: Any
    paced_brake: Brake | None = None
    """One brake if its friction depends on the speed, else None."""


@law
def make_strap(parallel: Any, series: Any, vacuum: Any, webbing: Any, brake: Brake) -> Strap:
    """Return `parallel` chains of `series` identical brakes at a vacuum [Pa] with webbing [N/m].

    The arguments broadcast. The strap is valid while its stiffness exceeds the fall of friction, k
    > N c; see `can_snap`. A speed law of the brake is included.
    """
    check_modulus(brake)
    every = xp.broadcast_arrays(parallel, series, vacuum, webbing)
    parallel, series, vacuum, webbing = every
    sheets = brake.sheets
    fall = parallel * friction_per_contact(vacuum, brake)
    sleeve = make_enclosure(
        parallel * brake.enclosure.modulus * sheets.width * brake.enclosure.wall,
        parallel * brake.film.friction_on_silicone * sheets.width * vacuum,
        (sheets.free_left + sheets.overlap + sheets.free_right) / 2 + 0 * parallel,
    )
    compliance = series / (parallel * working_stiffness(brake))
    travel = sheets.usable_travel + 0 * parallel
    onset = fall * sheets.overlap * brake_growth(0.0, brake)
    paced_brake = brake if has_speed_effects(brake) else None
    return Strap(1 / (compliance + 1 / webbing), onset, fall, sleeve, travel, series, paced_brake)


def make_limiter(force: Any, stiffness: Any, travel: Any = xp.inf) -> Strap:
    """Return a load limiter: elastic up to a force [N], then constant in force over `travel` [m].

    With an infinite force, it is plain webbing.
    """
    force, stiffness, travel = xp.broadcast_arrays(
        *(xp.asarray(a, xp.float64) for a in (force, stiffness, travel))
    )
    zero = xp.zeros_like(force)
    none = EnclosureLaw(zero, zero, zero + 1.0, zero, zero + xp.inf)
    return Strap(stiffness, force, zero, none, travel, zero + 1.0)


def least_stiffness(strap: Strap) -> Any:
    """Return the stiffness of the strap [N/m] below which its brakes may snap.

    Because friction falls by onset/L2 per metre, a strap of stiffness k slides steadily only if the
    onset is at most k L2. It is zero if friction grows with speed, which keeps slip steady on any
    spring.
    """
    return strap.fall if strap.paced_brake is None else 0.0 * strap.fall


def can_snap(strap: Strap) -> Any:
    """Return whether the strap is so soft that its brakes may snap."""
    return strap.stiffness <= least_stiffness(strap)


def chain_slip(payout: Any, before: Any, strap: Strap) -> Any:
    """Return the slip [m] of a chain at a payout [m], which is at least the earlier slip `before`.

    A call uses at most one brake's travel; the next call continues with the next brake. In a strap
    that snaps, a brake uses up its travel instantly.
    """
    finite = xp.where(xp.isfinite(strap.travel), strap.travel, 1.0)
    used = xp.where(xp.isfinite(strap.travel), xp.floor(before / finite * (1 + 1e-12)), 0.0)
    base = xp.where(used > 0, used * finite, 0.0)
    drive = strap.stiffness * (payout - base) - strap.onset
    drive = xp.where(xp.isfinite(drive), drive, -1.0)
    soft = can_snap(strap)
    slip = strap.sleeve.find_slip(drive, xp.where(soft, 1.0, strap.stiffness - strap.fall))
    slip = xp.minimum(xp.where(soft & (drive > 0), strap.travel, slip), strap.travel)
    return xp.where(used >= strap.series, before, xp.maximum(before, base + slip))


def paced_slip(brake: Brake, payout: Any, before: Any, pace: Any, dt: Any, strap: Strap) -> Any:
    """Return `chain_slip` if friction grows with speed: the slip [m] after a step of `dt` [s].

    `pace` [m/s] is the chain's mean slip speed in the previous step, which has the same length. The
    final speed is that of a parabola through the two steps, which is second-order in time.
    """
    series, end = strap.series, strap.series * strap.travel

    def excess(slip: Any) -> Any:
        speed = xp.maximum((1.5 * (slip - before) / dt - pace / 2) / series, 0.0)
        slip_of_one = slip / series
        friction = strap.fall * xp.maximum(brake.sheets.overlap - slip_of_one, 0.0)
        sheets = friction * brake_growth(speed, brake)
        return sheets + strap.sleeve.force(slip_of_one) - strap.stiffness * (payout - slip)

    slides = (excess(before) < 0) & (before < end)
    high = xp.where(slides, xp.maximum(payout, before), before)
    guess = xp.where(pace > 0, before + pace * dt, before + (high - before) / 8)

    def is_going(state: tuple[Any, Any, Any, Any, Any]) -> Any:
        turn, *_, is_moving = state
        return (turn < NEWTON) & xp.any(is_moving)

    def newton(state: tuple[Any, Any, Any, Any, Any]) -> tuple[Any, Any, Any, Any, Any]:
        turn, low, high, slip, _ = state
        force_excess, slope = excess(slip), derivative(excess, slip)
        low, high = xp.where(force_excess < 0, slip, low), xp.where(force_excess < 0, high, slip)
        newton_slip = slip - force_excess / xp.where(slope > 0, slope, 1.0)
        inside = (slope > 0) & (newton_slip >= low) & (newton_slip <= high)
        new = xp.where(inside, newton_slip, (low + high) / 2)
        is_moving = xp.abs(new - slip) > SETTLED * xp.maximum(new - before, LITTLE)
        return turn + 1, low, high, new, slides & is_moving

    start = xp.clip(guess, before, high)
    solution = repeat_while(is_going, newton, (xp.array(0), before, high, start, slides))[3]
    return xp.where(slides, xp.minimum(solution, end), before)


def difference_growth(slip: Any, speed: float, series: Any, brake: Brake) -> float:
    """Return the growth factor of a difference between two brakes in a chain at its `slip` [m].

    To first order, without the enclosure, it is (L2/(L2 - x))^(1/n), with x the slip of each and n
    the exponent of the friction at their `speed` [m/s].
    """
    exponent = growth_slope(speed, brake) * (rest_speed(brake) + speed)
    left = 1 - slip / series / brake.sheets.overlap
    return float(left ** (-1 / exponent)) if left > 0 else float("inf")


def tension(payout: Any, slip: Any, strap: Strap) -> Any:
    """Return the force [N] of the strap, which can only pull."""
    return xp.maximum(strap.stiffness * (payout - slip), 0.0)


class Body(NamedTuple):
    """The restrained body: mass [kg], payout per displacement, slack [m], initial speed [m/s]."""

    mass: Any
    ratio: Any = 1.0
    slack: Any = 0.0
    speed: Any = 0.0


class Ride(NamedTuple):
    """State of a restrained body at one time, or versus time in arrays of shape (N, ...)."""

    time: Any
    way: Any
    """Travel of the body relative to its mount [m]."""
    speed: Any
    acceleration: Any
    """Relative acceleration [m/s^2]."""
    force: Any
    """Tension of the strap [N]; its effect on the body is multiplied by `ratio`."""
    slip: Any
    """Slip of a chain [m]."""
    heat: Any
    """Work of the strap's slip [J]: heat and the energy stored in the enclosures."""
    put_in: Any
    """Work done by the drive on the body [J]."""
    pace: Any = None
    """Mean slip speed of a chain in the last step [m/s]; None if there is no speed law."""


class Extremes(NamedTuple):
    """Maximum values of the simulated cases, final speed and slip; arrays in the cases' shape."""

    way: Any
    force: Any
    held: Any
    """Acceleration of the body due to the restraint alone [m/s^2]."""
    acceleration: Any
    """Magnitude of the acceleration due to drive and restraint together [m/s^2]."""
    end_speed: Any
    """Final speed, with its sign [m/s]."""
    slip: Any
    """Final slip [m]."""


def _start_ride(drive: Any, body: Body, strap: Strap) -> Ride:
    lanes = xp.broadcast_shapes(*(xp.shape(a) for a in leaves((drive, body, strap))))
    zero = xp.zeros(lanes)
    initial = xp.zeros(()), zero, zero + body.speed, zero + drive, zero, zero, zero, zero
    return Ride(*initial, pace=None if strap.paced_brake is None else zero)


def _advance_ride(ride_now: Ride, drive: Any, dt: Any, body: Body, strap: Strap) -> Ride:
    """Return the state after a velocity Verlet step; without a speed law, the slip is exact."""
    half = ride_now.speed + ride_now.acceleration * dt / 2
    travel_ = ride_now.way + half * dt
    payout = body.ratio * travel_ - body.slack
    if strap.paced_brake is None:
        slip, pace = chain_slip(payout, ride_now.slip, strap), None
    else:
        slip = paced_slip(strap.paced_brake, payout, ride_now.slip, ride_now.pace, dt, strap)
        pace = (slip - ride_now.slip) / dt
    force = tension(payout, slip, strap)
    push = drive - body.ratio * force / body.mass
    before = ride_now.acceleration + body.ratio * ride_now.force / body.mass
    heat = ride_now.heat + (force + ride_now.force) / 2 * (slip - ride_now.slip)
    put_in = ride_now.put_in + body.mass * (before + drive) / 2 * (travel_ - ride_now.way)
    return Ride(
        ride_now.time + dt, travel_, half + push * dt / 2, push, force, slip, heat, put_in, pace
    )


@compiled
def _scan_ride(drive: Any, dt: Any, body: Body, strap: Strap) -> tuple[Ride, Ride]:
    def advance(ride_now: Ride, push: Any) -> tuple[Ride, Ride]:
        new = _advance_ride(ride_now, push, dt, body, strap)
        return new, new

    start = _start_ride(drive[0], body, strap)
    return start, scan(advance, start, drive[1:])[1]


@compiled
def _scan_extremes(drive: Any, dt: Any, body: Body, strap: Strap) -> Extremes:
    def advance(state: tuple[Ride, Extremes], push: Any) -> tuple[tuple[Ride, Extremes], None]:
        ride_now, extremes_ = state
        new = _advance_ride(ride_now, push, dt, body, strap)
        restraint, push = body.ratio * new.force / body.mass, xp.abs(new.acceleration)
        values = new.way, new.force, restraint, push
        extremes_ = Extremes._make([*map(xp.maximum, extremes_[:4], values), new.speed, new.slip])
        return (new, extremes_), None

    start = _start_ride(drive[0], body, strap)
    zero = xp.zeros_like(start.way)
    first = Extremes(zero, zero, zero, xp.abs(start.acceleration), start.speed, zero)
    return scan(advance, (start, first), drive[1:])[0][1]


def simulate_ride(drive: Any, dt: float, body: Body, strap: Strap) -> Ride:
    """Simulate a body under a drive [m/s^2], shape (N,), in steps of `dt` [s].

    The method is second-order in time. `drive` is the body's relative acceleration if unrestrained.
    """
    start, rows = _scan_ride(np.asarray(drive, float), np.float64(dt), _to_doubles(body), strap)
    return map_leaves(lambda a, b: np.concatenate([np.asarray(a)[None], b]), start, rows)


def simulate_extremes(drive: Any, dt: float, body: Body, strap: Strap) -> Extremes:
    """Return the maximum values of many cases; body and strap may have arrays of shape (B,)."""
    case = (_to_doubles(body), strap)
    wide = np.broadcast_arrays(*leaves(case))
    shape, count = wide[0].shape, wide[0].size
    # use few array sizes, so that little is compiled
    room = next((size for size in ROOMS if count <= size), -(-count // ROOMS[-1]) * ROOMS[-1])
    lanes = iter([np.pad(a.ravel(), (0, room - count), mode="edge") for a in wide])
    case = map_leaves(lambda _: next(lanes), case)
    padded_extremes = _scan_extremes(np.asarray(drive, float), np.float64(dt), *case)
    return Extremes(*(np.asarray(a)[:count].reshape(shape) for a in padded_extremes))


def _to_doubles(body: Body) -> Body:
    return Body(*(np.asarray(a, np.float64) for a in body))


COARSE = 4
"""Interval, in steps of the drive, between the samples that a search uses."""


class Trial(NamedTuple):
    """A body that a drive [m/s^2], in steps of `dt` [s], throws into brakes with webbing [N/m]."""

    scenario: Scenario
    body: Body
    webbing: float
    drive: Array
    dt: float

    def strap(self, **instead: Any) -> Strap:
        """Return the scenario's strap, with some of its values replaced by `instead`."""
        brakes = self.scenario.brakes
        brake = require_linear(remove_idle_speed_law(self.scenario.brake.brake), "the restraint")
        settings = {"parallel": brakes.parallel, "series": brakes.series, "vacuum": brakes.vacuum}
        strap: Strap = make_strap(**(settings | {"webbing": self.webbing} | instead), brake=brake)
        return strap

    def run_grid(self, **grid: Any) -> pandas.DataFrame:
        """Return one row for each combination of `webbing`, `series`, `parallel` and `vacuum`.

        The scenario's own values are the defaults. The other columns are those of Extremes, the
        `count` of brakes, `mass` [kg], `as_built` (the existing webbing), `sound` (the brakes do
        not snap) and `stops` (the body stops with travel left).
        """
        brakes = self.scenario.brakes
        axes = {
            "webbing": self.webbing,
            "series": brakes.series,
            "parallel": brakes.parallel,
            "vacuum": brakes.vacuum,
        } | grid
        mesh = np.meshgrid(*axes.values(), indexing="ij")
        lanes = dict(zip(axes, (axis.ravel() for axis in mesh), strict=True))
        strap = self.strap(**lanes)
        peaks = simulate_extremes(self.drive[::COARSE], COARSE * self.dt, self.body, strap)
        rows = pandas.DataFrame(lanes | peaks._asdict())
        rows["count"] = rows.series * rows.parallel
        rows["mass"] = rows["count"] * self.scenario.mass
        rows["as_built"] = rows.webbing == self.webbing
        rows["sound"] = ~np.asarray(can_snap(strap))
        left = rows.slip < rows.series * self.scenario.brake.brake.sheets.usable_travel * (1 - 1e-9)
        rows["stops"] = (rows.end_speed <= 0) & left
        return rows


def best_row(rows: pandas.DataFrame, *order: str) -> dict[str, Any]:
    """Return the row with the smallest values in columns `order`; IndexError for no rows."""
    row: dict[str, Any] = rows.sort_values(list(order)).to_dict("records")[0]
    return row


strap_of, limiter_of, snaps = make_strap, make_limiter, can_snap  # former names
ride, extremes = simulate_ride, simulate_extremes  # former names
