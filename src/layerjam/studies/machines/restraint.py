"""Equal brakes in a strap that holds a mass, in time: a body thrown against its restraint.

The strap is an elastic line that slips: force k (u - S), with u its payout and S the slip of all
brakes of a chain together. Brakes fall off behind their peak, so that in a chain they slip one
after the other, each to the end of its travel, where a stop of webbing takes over; which one
begins makes no difference to the force of equal ones. The slip at a payout never reached before is
the closed form of a slow pull (mechanics, section 2); back from it the strap is elastic, and it
only pulls. Behind the last travel the strap holds on its stops. What the other brakes of a chain
slip before their peak (0.19 mm each at full vacuum) is left out.

Where friction grows with the sliding speed (a brake with a speed law) equal brakes of a chain share
its slip evenly, and nothing snaps: force k (u - S) = R(S/s, S'/s) with s brakes in a row and R the
sliding force of all chains at a slip and a speed. A difference between two brakes of a chain, of
slip or of friction, grows with the slip x of each as (L2/(L2 - x))^(1/n), n the law's power.

In turning the same holds with a lever: payout = lever * angle, mass = inertia / lever^2.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pandas

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.enclosure import EnclosureLaw, backbone, enclosure_of, one_modulus
from layerjam.mechanics.fan import straight
from layerjam.mechanics.friction import friction_per_contact, growth, growth_of
from layerjam.mechanics.law import law
from layerjam.mechanics.pull import rising_root
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import counted
from layerjam.studies.machines.scenario import Array, Scenario

ROOMS = (256, 4096)
"""Lanes that are marched at once; numbers in between are filled up."""
NEWTON = 60
SETTLED = 1e-11
"""Last step of a search, over what the strap slips in a step of the march, at which it ends."""
LITTLE = 1e-9
"""Slip in a step [m] below which that is taken for it."""


class Strap(NamedTuple):
    """A strap's constants, all chains together; leaves broadcast."""

    stiffness: Any
    """k of brakes, stuck, and webbing in series [N/m]."""
    onset: Any
    """Force at which a fresh brake begins to slide, N c L2 [N]; infinite where nothing slides."""
    fall: Any
    """N c [N/m], with a speed law at its test speed; the onset is that at rest."""
    sleeve: EnclosureLaw
    travel: Any
    """Usable travel of one brake [m]."""
    series: Any
    law: SpeedLaw | None = None
    overlap: Any = None
    """Of one brake [m]; None without a speed law."""


@law
def strap_of(parallel: Any, series: Any, vacuum: Any, webbing: Any, brake: Brake) -> Strap:
    """`parallel` chains of `series` equal brakes at a vacuum [Pa] behind webbing [N/m]; broadcasts.

    Valid while the strap is stiffer than the friction falls, k > N c; `snaps` tells. A speed law of
    the brake counts.
    """
    one_modulus(brake)
    every = jnp.broadcast_arrays(parallel, series, vacuum, webbing)
    parallel, series, vacuum, webbing = every
    sheets = brake.sheets
    fall = parallel * friction_per_contact(vacuum, brake)
    sleeve = enclosure_of(
        parallel * brake.enclosure.modulus * sheets.width * brake.enclosure.wall,
        parallel * brake.film.friction_on_silicone * sheets.width * vacuum,
        (sheets.free_left + sheets.overlap + sheets.free_right) / 2 + 0 * parallel,
    )
    own = series / (parallel * working_stiffness(brake))
    travel = sheets.usable_travel + 0 * parallel
    onset = fall * sheets.overlap * growth_of(0.0, brake)
    overlap = None if brake.speed_law is None else sheets.overlap + 0 * parallel
    stiffness, law = 1 / (own + 1 / webbing), brake.speed_law
    return Strap(stiffness, onset, fall, sleeve, travel, series, law, overlap)


def limiter_of(force: Any, stiffness: Any, travel: Any = jnp.inf) -> Strap:
    """A load limiter: elastic up to a force [N], which it then keeps over its travel [m].

    With an infinite force it is plain webbing.
    """
    force, stiffness, travel = jnp.broadcast_arrays(
        *(jnp.asarray(a, jnp.float64) for a in (force, stiffness, travel))
    )
    zero = jnp.zeros_like(force)
    none = EnclosureLaw(zero, zero, zero + 1.0, zero, zero + jnp.inf)
    return Strap(stiffness, force, zero, none, travel, zero + 1.0)


def least_stiffness(strap: Strap) -> Any:
    """Stiffness of the strap [N/m] at which brakes in it may snap: as much as its friction falls.

    As friction falls by onset/L2 a metre, a strap of stiffness k slides steadily up to k L2 only.
    Zero where friction grows with speed, which holds any spring.
    """
    return strap.fall if strap.law is None else 0.0 * strap.fall


def snaps(strap: Strap) -> Any:
    """Whether the strap is so soft that brakes in it may snap."""
    return strap.stiffness <= least_stiffness(strap)


def drawn(payout: Any, slipped: Any, strap: Strap) -> Any:
    """Slip [m] of a chain at a payout [m], having slipped by `slipped` before: never less.

    At most one brake's travel is used up in a call; the next begins with the next one. A strap that
    snaps runs through a travel at once.
    """
    finite = jnp.where(jnp.isfinite(strap.travel), strap.travel, 1.0)
    used = jnp.where(jnp.isfinite(strap.travel), jnp.floor(slipped / finite * (1 + 1e-12)), 0.0)
    base = jnp.where(used > 0, used * finite, 0.0)
    drive = strap.stiffness * (payout - base) - strap.onset
    drive = jnp.where(jnp.isfinite(drive), drive, -1.0)
    soft = snaps(strap)
    slip = rising_root(drive, jnp.where(soft, 1.0, strap.stiffness - strap.fall), strap.sleeve)
    slip = jnp.minimum(jnp.where(soft & (drive > 0), strap.travel, slip), strap.travel)
    return jnp.where(used >= strap.series, slipped, jnp.maximum(slipped, base + slip))


def paced(law: SpeedLaw, payout: Any, slipped: Any, pace: Any, dt: Any, strap: Strap) -> Any:
    """`drawn` where friction grows with speed: slip [m] of a chain a step of `dt` [s] later.

    `pace` [m/s] is the chain's mean speed of slip in the step before, as long. That at the end is
    the one of a parabola through the two steps: second order in time.
    """
    series, end = strap.series, strap.series * strap.travel

    def excess(slip: Any) -> Any:
        speed = jnp.maximum((1.5 * (slip - slipped) / dt - pace / 2) / series, 0.0)
        each = slip / series
        sheets = strap.fall * jnp.maximum(strap.overlap - each, 0.0) * growth(speed, law)
        return sheets + backbone(each, strap.sleeve) - strap.stiffness * (payout - slip)

    slides = (excess(slipped) < 0) & (slipped < end)
    high = jnp.where(slides, jnp.maximum(payout, slipped), slipped)
    guess = jnp.where(pace > 0, slipped + pace * dt, slipped + (high - slipped) / 8)

    def going(state: tuple[Any, Any, Any, Any, Any]) -> Any:
        turn, *_, moved = state
        return (turn < NEWTON) & jnp.any(moved)

    def newton(state: tuple[Any, Any, Any, Any, Any]) -> tuple[Any, Any, Any, Any, Any]:
        turn, low, high, slip, _ = state
        here, slope = jax.jvp(excess, (slip,), (jnp.ones_like(slip),))
        low, high = jnp.where(here < 0, slip, low), jnp.where(here < 0, high, slip)
        near = slip - here / jnp.where(slope > 0, slope, 1.0)
        inside = (slope > 0) & (near >= low) & (near <= high)
        new = jnp.where(inside, near, (low + high) / 2)
        moved = jnp.abs(new - slip) > SETTLED * jnp.maximum(new - slipped, LITTLE)
        return turn + 1, low, high, new, slides & moved

    start = jnp.clip(guess, slipped, high)
    found = jax.lax.while_loop(going, newton, (jnp.array(0), slipped, high, start, slides))[3]
    return jnp.where(slides, jnp.minimum(found, end), slipped)


def gathered(law: SpeedLaw, slip: Any, series: Any, brake: Brake) -> float:
    """How many times a difference between two brakes of a chain has grown at its `slip` [m].

    In first order, with its speed law: (L2/(L2 - x))^(1/n), x the slip of each, the enclosure
    left out.
    """
    left = 1 - slip / series / brake.sheets.overlap
    return float(left ** (-1 / law.power)) if left > 0 else float("inf")


def tension(payout: Any, slipped: Any, strap: Strap) -> Any:
    """Force of the strap [N]: it only pulls."""
    return jnp.maximum(strap.stiffness * (payout - slipped), 0.0)


class Body(NamedTuple):
    """What is held: mass [kg], payout per way of the body, slack of the strap [m], start [m/s]."""

    mass: Any
    ratio: Any = 1.0
    slack: Any = 0.0
    speed: Any = 0.0


class Ride(NamedTuple):
    """A ride at one moment, or in time: arrays of shape (N, ...)."""

    time: Any
    way: Any
    """Of the body relative to what it is strapped to [m]."""
    speed: Any
    acceleration: Any
    """Relative [m/s^2]."""
    force: Any
    """Tension of the strap [N]; on the body it acts `ratio` times."""
    slip: Any
    """Of a chain [m]."""
    heat: Any
    """Work of the strap in slipping [J]: heat, and what stays in the enclosures."""
    put_in: Any
    """Work of the drive on the body [J]."""
    pace: Any = None
    """Mean speed of a chain's slip in the last step [m/s]; None where it does not count."""


class Extremes(NamedTuple):
    """Greatest values of rides, and the last slip; arrays of the lanes' shape."""

    way: Any
    force: Any
    held: Any
    """What the restraint alone gives the body [m/s^2]."""
    acceleration: Any
    """Size of drive and restraint together [m/s^2]."""
    end_speed: Any
    """The last, with its sign [m/s]."""
    slip: Any
    """The last [m]."""


def _start(drive: Any, body: Body, strap: Strap) -> Ride:
    lanes = jnp.broadcast_shapes(*(jnp.shape(a) for a in jax.tree.leaves((drive, body, strap))))
    zero = jnp.zeros(lanes)
    rest = jnp.zeros(()), zero, zero + body.speed, zero + drive, zero, zero, zero, zero
    return Ride(*rest, pace=None if strap.law is None else zero)


def _next(now: Ride, drive: Any, dt: Any, body: Body, strap: Strap) -> Ride:
    """A step of velocity Verlet; without a speed law the strap's slip is exact at every payout."""
    half = now.speed + now.acceleration * dt / 2
    way = now.way + half * dt
    payout = body.ratio * way - body.slack
    if strap.law is None:
        slip, pace = drawn(payout, now.slip, strap), None
    else:
        slip = paced(strap.law, payout, now.slip, now.pace, dt, strap)
        pace = (slip - now.slip) / dt
    force = tension(payout, slip, strap)
    push = drive - body.ratio * force / body.mass
    before = now.acceleration + body.ratio * now.force / body.mass
    heat = now.heat + (force + now.force) / 2 * (slip - now.slip)
    put_in = now.put_in + body.mass * (before + drive) / 2 * (way - now.way)
    return Ride(now.time + dt, way, half + push * dt / 2, push, force, slip, heat, put_in, pace)


@jax.jit
def _ride(drive: Any, dt: Any, body: Body, strap: Strap) -> tuple[Ride, Ride]:
    def on(now: Ride, push: Any) -> tuple[Ride, Ride]:
        new = _next(now, push, dt, body, strap)
        return new, new

    start = _start(drive[0], body, strap)
    return start, jax.lax.scan(on, start, drive[1:])[1]


@jax.jit
def _extremes(drive: Any, dt: Any, body: Body, strap: Strap) -> Extremes:
    def on(state: tuple[Ride, Extremes], push: Any) -> tuple[tuple[Ride, Extremes], None]:
        now, most = state
        new = _next(now, push, dt, body, strap)
        held, push = body.ratio * new.force / body.mass, jnp.abs(new.acceleration)
        seen = new.way, new.force, held, push
        most = Extremes._make([*map(jnp.maximum, most[:4], seen), new.speed, new.slip])
        return (new, most), None

    start = _start(drive[0], body, strap)
    zero = jnp.zeros_like(start.way)
    first = Extremes(zero, zero, zero, jnp.abs(start.acceleration), start.speed, zero)
    return jax.lax.scan(on, (start, first), drive[1:])[0][1]


def ride(drive: Any, dt: float, body: Body, strap: Strap) -> Ride:
    """March a body under a drive [m/s^2], shape (N,), at steps of `dt` [s]; second order in time.

    `drive` is the acceleration the body has relative to its mount while nothing holds it.
    """
    start, rows = _ride(np.asarray(drive, float), np.float64(dt), _doubles(body), strap)
    return jax.tree.map(lambda a, b: np.concatenate([np.asarray(a)[None], b]), start, rows)


def extremes(drive: Any, dt: float, body: Body, strap: Strap) -> Extremes:
    """The greatest values of many rides side by side; body and strap may have lanes, shape (B,)."""
    leaves, tree = jax.tree.flatten((_doubles(body), strap))
    wide = np.broadcast_arrays(*(np.asarray(a) for a in leaves))
    shape, count = wide[0].shape, wide[0].size
    # few sizes, so that little is compiled
    room = next((size for size in ROOMS if count <= size), -(-count // ROOMS[-1]) * ROOMS[-1])
    lanes = [np.pad(a.ravel(), (0, room - count), mode="edge") for a in wide]
    made = _extremes(np.asarray(drive, float), np.float64(dt), *jax.tree.unflatten(tree, lanes))
    return Extremes(*(np.asarray(a)[:count].reshape(shape) for a in made))


def _doubles(body: Body) -> Body:
    return Body(*(jnp.asarray(a, jnp.float64) for a in body))


COARSE = 4
"""A search takes every fourth step of the drive."""


class Trial(NamedTuple):
    """A body that a drive [m/s^2] at steps of `dt` [s] throws into brakes behind webbing [N/m]."""

    scenario: Scenario
    body: Body
    webbing: float
    drive: Array
    dt: float

    def strap(self, **instead: Any) -> Strap:
        """The scenario's strap, or with `parallel`, `series`, `vacuum`, `webbing` instead."""
        brakes = self.scenario.brakes
        brake = straight(counted(self.scenario.brake.brake), "the restraint")
        own = {"parallel": brakes.parallel, "series": brakes.series, "vacuum": brakes.vacuum}
        made: Strap = strap_of(**(own | {"webbing": self.webbing} | instead), brake=brake)
        return made

    def tried(self, **grid: Any) -> pandas.DataFrame:
        """One row for each combination of `webbing`, `series`, `parallel` and `vacuum`.

        What `grid` leaves out is the scenario's own. The further columns are those of Extremes, and
        `count` of brakes, `mass` [kg], `as_built` (the webbing that is there), `sound` (the brakes
        do not snap) and `stops` (the body has stopped, on travel left).
        """
        brakes = self.scenario.brakes
        axes = {
            "webbing": self.webbing,
            "series": brakes.series,
            "parallel": brakes.parallel,
            "vacuum": brakes.vacuum,
        } | grid
        crossed = np.meshgrid(*axes.values(), indexing="ij")
        lanes = dict(zip(axes, (axis.ravel() for axis in crossed), strict=True))
        strap = self.strap(**lanes)
        most = extremes(self.drive[::COARSE], COARSE * self.dt, self.body, strap)
        rows = pandas.DataFrame(lanes | most._asdict())
        rows["count"] = rows.series * rows.parallel
        rows["mass"] = rows["count"] * self.scenario.mass
        rows["as_built"] = rows.webbing == self.webbing
        rows["sound"] = ~np.asarray(snaps(strap))
        left = rows.slip < rows.series * self.scenario.brake.brake.sheets.usable_travel * (1 - 1e-9)
        rows["stops"] = (rows.end_speed <= 0) & left
        return rows


def first(rows: pandas.DataFrame, *order: str) -> dict[str, Any]:
    """The row that is least in the columns of `order`; raises IndexError where there is none."""
    made: dict[str, Any] = rows.sort_values(list(order)).to_dict("records")[0]
    return made
