"""A mass on a rope and the brake in time: any vacuum, rope damping, rebound, slack rope (ours).

The brake's force depends on its path alone, so one step asks: by how much is the brake drawn out
that its mean force over the step, work by way, is the one that slows the mass? Work and heat are
exact along the path, so that energy is kept to rounding at any step; time is of second order.

Without rope damping rope and brake are one spring, as in the exact stop. With it the rope is a
spring and a damper side by side (it only pulls) in series with the brake.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    Sleeve,
    backbone,
    backbone_dissipated,
    backbone_stored,
    backbone_work,
    sleeve_at,
)
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.hysteresis import Setting, first_slip
from layerjam.mechanics.law import law, safe_sqrt, within
from layerjam.mechanics.memory import Memory, Turns, at_vacuum, first_force, first_work
from layerjam.mechanics.pull import rising_root
from layerjam.mechanics.stiffness import working_stiffness

MOVING, STANDSTILL, TRAVEL_USED, CLOSED, SNAPPED = 0, 1, 2, 3, 4
"""How far it got: still moving, first standstill, end of travel, sleeve closes the brake, snaps."""
_NEWTON = 3


class Load(NamedTuple):
    """What hangs on the brake, in SI; arrays broadcast."""

    mass: Any
    gravity: Any
    spring: Any
    """Brake and rope in series, or the brake alone where the rope is damped [N/m]."""
    rope: Any
    """Stiffness of a damped rope [N/m]; not used without damping."""
    damping: Any
    """[N s/m]"""


class Motion(NamedTuple):
    """State between two steps; arrays of one shape."""

    time: Any
    place: Any
    """Way of the mass from the taut rope [m]."""
    speed: Any
    drawn: Any
    """Elongation of the spring `Load.spring` and the brake [m]."""
    stretch: Any
    """Stretch of a damped rope [m]."""
    slack: Any
    slip: Any
    force: Any
    """Force in brake and rope [N]."""
    sleeve: Memory | None
    """Loading state of the sleeve; None at constant vacuum, where the backbone is enough."""
    vacuum: Any
    """What acted in the last step [Pa]."""
    heat: Any
    """Turned into heat in brake and rope so far [J], summed on its own."""
    peak: Any
    """Greatest force so far [N]."""
    outcome: Any


class _Pulled(NamedTuple):
    """The brake after being drawn by some way at one vacuum."""

    drawn: Any
    slip: Any
    force: Any
    work: Any
    heat: Any
    held: Any
    """What the sleeve stores more than before [J]."""


def at_start(speed: Any, vacuum: Any, steady: bool) -> Motion:
    """Just taut, everything relaxed; the shape is that of `speed` [m/s] and `vacuum` [Pa]."""
    speed, vacuum = jnp.broadcast_arrays(speed, vacuum)
    zero = jnp.zeros_like(speed)
    no, none = jnp.zeros(speed.shape, bool), jnp.zeros(speed.shape, int)
    turns = Turns(zero, zero, zero, none)
    memory = Memory(zero, zero, zero, turns, zero, zero, turns, turns, ~no, zero, zero, no)
    return Motion(
        time=zero, place=zero, speed=speed, drawn=zero, stretch=zero, slack=no, slip=zero,
        force=zero, sleeve=None if steady else memory, vacuum=vacuum, heat=zero, peak=zero,
        outcome=none,
    )  # fmt: skip


def setting_of(vacuum: Any, spring: Any, brake: Brake) -> Setting:
    """What resists at a vacuum [Pa] on a series spring [N/m]."""
    c, overlap = friction_per_contact(vacuum, brake), brake.sheets.overlap
    return Setting(c, spring, overlap, sleeve_at(vacuum, brake))


def _sleeve_force(slip: Any, sleeve: Memory | None, at: Sleeve) -> Any:
    return backbone(slip, at) if sleeve is None else first_force(sleeve, slip, at)


def _pulled(motion: Motion, way: Any, slides: Any, at: Setting, c: Any = None) -> _Pulled:
    """Draw the brake by `way` [m] from a taut state; it slides where `slides`, else it sticks.

    Friction goes from `c` [N/m] to that of `at` evenly over the slip.
    """
    drawn = motion.drawn + way
    if motion.sleeve is None:
        out = rising_root(at.k * drawn - at.c * at.overlap, at.k - at.c, at.sleeve)
    else:
        out = first_slip(motion.sleeve, drawn, at)
    slip = jnp.where(slides, jnp.maximum(out, motion.slip), motion.slip)
    more = slip - motion.slip
    force = motion.force + at.k * (way - more)
    rubbed = at.c * more * (at.overlap - (slip + motion.slip) / 2)
    if c is not None:
        rubbed = rubbed - (at.c - c) * more * ((at.overlap - motion.slip) / 2 - more / 6)
    if motion.sleeve is None:
        work = backbone_work(slip, at.sleeve) - backbone_work(motion.slip, at.sleeve)
        warm = backbone_dissipated(slip, at.sleeve) - backbone_dissipated(motion.slip, at.sleeve)
    else:
        work, warm = first_work(motion.sleeve, motion.slip, slip, at.sleeve)
    elastic = (force - motion.force) * (force + motion.force) / (2 * at.k)
    return _Pulled(drawn, slip, force, elastic + rubbed + work, rubbed + warm, work - warm)


def _meet(motion: Motion, alpha: Any, beta: Any, at: Setting, c: Any) -> tuple[_Pulled, Any]:
    """Draw the brake until its mean force is alpha - beta way; the way [m] goes with it."""
    hold = at.c * (at.overlap - motion.slip)
    hold = hold + _sleeve_force(motion.slip, motion.sleeve, at.sleeve)
    way = (alpha - motion.force) / (beta + at.k / 2)
    slides = motion.force + at.k * way > hold
    least = (hold - motion.force) / at.k
    sliding = jnp.maximum((alpha - hold) / beta, least * (1 + 1e-9))
    far = jnp.where(slides & (sliding > 0), sliding, way)

    def newton(_: int, far: Any) -> Any:
        pulled = _pulled(motion, far, slides, at, c)
        part = jnp.where(far != 0, far, 1.0)
        mean = pulled.work / part
        step = (mean + beta * far - alpha) / ((pulled.force - mean) / part + beta)
        return jnp.where(slides, jnp.maximum(far - step, least), way)

    # at constant vacuum the loop is short enough to be written out, which batches like
    steady = motion.sleeve is None
    far = jax.lax.fori_loop(0, _NEWTON, newton, far, unroll=steady)
    return _pulled(motion, far, slides, at, c), far


def _taut(motion: Motion, dt: Any, at: Setting, c: Any, load: Load, damped: bool) -> Motion:
    """One step on the taut rope."""
    m, g, v = load.mass, load.gravity, motion.speed
    if damped:
        kappa = load.rope / 2 + load.damping / dt
        share = 1 + kappa * dt**2 / (2 * m)
        alpha = (load.rope * motion.stretch + kappa * (v * dt + g * dt**2 / 2)) / share
        beta = kappa / share
    else:
        alpha, beta = m * (g + 2 * v / dt), 2 * m / dt**2
    pulled, way = _meet(motion, alpha, beta, at, c)
    mean = alpha - beta * way
    place = v * dt + (g - mean / m) * dt**2 / 2
    stretch = place - way if damped else jnp.zeros_like(way)
    rope = load.damping * stretch**2 / dt if damped else 0.0
    # nobody sees the force between two steps: its top is that of the backbone, if passed
    top = (at.sleeve.root / (2 * jnp.where(at.c > 0, at.c, 1.0))) ** 2
    passed = (motion.slip < top) & (top < pulled.slip) & (top < at.sleeve.saturation)
    highest = jnp.where(passed, at.c * at.overlap + at.sleeve.root**2 / (4 * at.c), pulled.force)
    return motion._replace(
        time=motion.time + dt,
        place=motion.place + place if damped else pulled.drawn,
        speed=v + (g - mean / m) * dt,
        drawn=pulled.drawn,
        stretch=motion.stretch + stretch,
        slip=pulled.slip,
        force=pulled.force,
        sleeve=_kept(motion.sleeve, pulled),
        heat=motion.heat + pulled.heat + rope,
        peak=jnp.maximum(motion.peak, highest),
    )


def _until_slack(motion: Motion, dt: Any, at: Setting, load: Load, damped: bool) -> Motion:
    """The part of a step after which the brake, shrinking elastically, pulls no more."""
    m, v, force = load.mass, motion.speed, motion.force
    pull, give = load.gravity - force / (2 * m), force / at.k
    time = safe_sqrt(jnp.maximum(v**2 - 2 * pull * give, 0.0)) - v
    time = jnp.clip(2 * give / jnp.where(time > 0, time, 1.0), 0.0, dt)
    if damped:
        for _ in range(6):
            short = give + v * time + pull * time**2 / 2
            off = (load.rope * motion.stretch - force / 2) * time
            off = off + (load.rope * time / 2 + load.damping) * short
            slope = load.rope * motion.stretch - force / 2 + load.rope * short / 2
            slope = slope + (load.rope * time / 2 + load.damping) * (v + pull * time)
            time = jnp.clip(time - off / jnp.where(slope != 0, slope, 1.0), 0.0, dt)
    place = v * time + pull * time**2 / 2
    more = place + give if damped else jnp.zeros_like(place)
    rope = load.damping * more**2 / jnp.where(time > 0, time, 1.0) if damped else 0.0
    return motion._replace(
        time=motion.time + time,
        place=motion.place + place if damped else motion.slip,
        speed=v + pull * time,
        drawn=motion.slip,
        stretch=motion.stretch + more,
        slack=jnp.ones_like(motion.slack),
        force=jnp.zeros_like(force),
        heat=motion.heat + rope,
    )


def _slack(motion: Motion, dt: Any, load: Load, damped: bool) -> Motion:
    """Free flight for a step, or up to the place where the rope is taut again."""
    g, v = load.gravity, motion.speed

    def rest(time: Any) -> Any:
        if not damped:
            return motion.stretch
        return motion.stretch * jnp.exp(-load.rope / load.damping * time)

    gap = motion.slip + motion.stretch - motion.place
    root = v + safe_sqrt(jnp.maximum(v**2 + 2 * g * gap, 0.0))
    # falling back, or never where nothing falls and the mass flies off
    time = jnp.where(root > 0, 2 * gap / jnp.where(root > 0, root, 1.0), jnp.inf)
    if damped:
        time = jnp.minimum(time, dt)
        for _ in range(6):
            ahead = motion.place + v * time + g * time**2 / 2 - motion.slip - rest(time)
            slope = v + g * time + load.rope / load.damping * rest(time)
            time = jnp.maximum(time - ahead / jnp.where(slope != 0, slope, 1.0), 0.0)
        reached = (time <= dt) & (v + g * time >= 0)
    else:
        reached = (time <= dt) & (root > 0)
    time = jnp.where(reached, time, dt)
    stretch = rest(time)
    place = motion.place + v * time + g * time**2 / 2
    return motion._replace(
        time=motion.time + time,
        place=jnp.where(reached, motion.slip + stretch, place),
        speed=v + g * time,
        stretch=stretch,
        slack=~reached,
        heat=motion.heat + (load.rope * (motion.stretch**2 - stretch**2) / 2 if damped else 0.0),
    )


def _kept(sleeve: Memory | None, pulled: _Pulled) -> Memory | None:
    return None if sleeve is None else sleeve._replace(stored=sleeve.stored + pulled.held)


def _pump(motion: Motion, vacuum: Any, before: Setting, at: Setting) -> Motion:
    """Another vacuum while the mass rests: what the brake gives way for turns into heat."""
    assert motion.sleeve is not None
    force = first_force(motion.sleeve, motion.slip, before.sleeve)
    held = motion.sleeve._replace(slip=motion.slip, force=force)
    sleeve = at_vacuum(held, before.sleeve, at.sleeve)
    new = motion._replace(sleeve=sleeve)
    gives = motion.force > at.c * (at.overlap - motion.slip) + sleeve.force
    pulled = _pulled(new, jnp.zeros_like(motion.slip), gives & ~motion.slack, at)
    # the spring drives the sheets harder than friction holds: all it gives but the sleeve's share
    spring = (motion.force - pulled.force) * (motion.force + pulled.force) / (2 * at.k)
    lost = held.stored - sleeve.stored + spring - pulled.held
    return new._replace(
        sleeve=_kept(sleeve, pulled),
        slip=pulled.slip,
        force=pulled.force,
        vacuum=vacuum + jnp.zeros_like(motion.vacuum),
        heat=motion.heat + lost,
    )


def _ahead(motion: Motion, dt: Any, at: Setting, c: Any, load: Load, damped: bool) -> Motion:
    """One step, shorter where the rope goes slack or taut within it."""
    taut = _taut(motion, dt, at, c, load, damped)
    parted = _until_slack(motion, dt, at, load, damped)
    free = _slack(motion, dt, load, damped)
    taut = jax.tree.map(lambda a, b: jnp.where(taut.force < 0, a, b), parted, taut)
    return jax.tree.map(lambda a, b: jnp.where(motion.slack, a, b), free, taut)


def _event(old: Motion, new: Motion, at: Setting, travel: Any) -> Any:
    """What happened in a step that the run must not go past."""
    hold = at.c * (at.overlap - new.slip)
    sleeve = _sleeve_force(new.slip, new.sleeve, at.sleeve)
    closes = sleeve * (1 - 1e-9) - new.force > hold
    code = jnp.where((old.speed > 0) & (new.speed <= 0), STANDSTILL, MOVING)
    code = jnp.where(new.slip >= travel, TRAVEL_USED, code)
    code = jnp.where((new.slip > 0) & closes, CLOSED, code)
    return jnp.where((new.slip > old.slip) & (at.k <= at.c), SNAPPED, code)


class Vacuum(NamedTuple):
    """A vacuum [Pa], or its samples over time [s], shape (H,), joined by straight lines."""

    pressure: Any
    time: Any = None

    def at(self, time: Any) -> Any:
        """Before the first and after the last sample it stays as it is."""
        return jnp.interp(time, self.time, self.pressure)


def _ready(
    motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake
) -> tuple[Motion, Setting, Any]:
    """What a step of `dt` [s] starts from, what resists in it, and friction at its start [N/m].

    A vacuum that falls does so between steps, by what puts its mean right. One that rises does so
    while the brake slides: at rest the force could not follow.
    """
    if motion.sleeve is None:
        return motion, setting_of(vacuum.pressure, load.spring, brake), None
    begin, end = vacuum.at(motion.time), vacuum.at(motion.time + dt)
    falls = end < begin
    level = jnp.where(falls, (begin + end) / 2, end)
    before = setting_of(motion.vacuum, load.spring, brake)
    at = setting_of(level, load.spring, brake)
    pumped = _pump(motion, level, before, at)
    same = level == motion.vacuum
    pumped = jax.tree.map(lambda a, b: jnp.where(same, a, b), motion, pumped)
    return pumped, at, jnp.where(falls, at.c, before.c)


def step_on(
    motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake, damped: bool
) -> Motion:
    """One step of `dt` [s]; a state whose next step holds an event stays, with its outcome."""
    ready, at, c = _ready(motion, dt, vacuum, load, brake)
    new = _ahead(ready, dt, at, c, load, damped)
    code = _event(motion, new, at, brake.sheets.usable_travel)
    going = (motion.outcome == MOVING) & (code == MOVING)
    still = motion._replace(outcome=jnp.where(motion.outcome == MOVING, code, motion.outcome))
    return jax.tree.map(lambda a, b: jnp.where(going, a, b), new, still)


def ended(
    motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake, damped: bool
) -> Motion:
    """Go to the standstill or the end of travel that the next step holds, by 60 halvings."""
    travel = brake.sheets.usable_travel

    def reached(time: Any) -> Motion:
        ready, at, c = _ready(motion, time, vacuum, load, brake)
        new = _ahead(ready, time, at, c, load, damped)
        if new.sleeve is None:
            return new
        # what is left of a fall of the vacuum when it stands
        now = vacuum.at(new.time)
        left = _pump(new, now, at, setting_of(now, load.spring, brake))
        return jax.tree.map(lambda a, b: jnp.where(now < new.vacuum, a, b), left, new)

    def halve(_: int, state: tuple[Any, Any, Motion]) -> tuple[Any, Any, Motion]:
        low, high, best = state
        middle = (low + high) / 2
        there = reached(middle)
        over = (there.speed <= 0) | (there.slip >= travel)
        best = jax.tree.map(lambda a, b: jnp.where(over, a, b), there, best)
        return jnp.where(over, low, middle), jnp.where(over, middle, high), best

    # the first of them is the whole step, known to hold the event
    least = jnp.zeros_like(motion.time)
    last = jax.lax.fori_loop(0, 60, halve, (least, least + 2 * dt, motion))[2]
    used = last.slip >= travel
    last = last._replace(
        speed=jnp.where(used, last.speed, 0.0),
        slip=jnp.where(used, travel, last.slip),
        outcome=jnp.where(used, TRAVEL_USED, STANDSTILL).astype(motion.outcome.dtype),
    )
    on = (motion.outcome == STANDSTILL) | (motion.outcome == TRAVEL_USED)
    return jax.tree.map(lambda a, b: jnp.where(on, a, b), last, motion)


def stored_energy(motion: Motion, load: Load, brake: Brake) -> Any:
    """Elastic energy [J] in rope, sheets, mount and sleeve."""
    if motion.sleeve is None:
        sleeve = backbone_stored(motion.slip, sleeve_at(motion.vacuum, brake))
    else:
        sleeve = motion.sleeve.stored
    rope = jnp.where(jnp.isfinite(load.rope), load.rope * motion.stretch**2 / 2, 0.0)
    return motion.force**2 / (2 * load.spring) + rope + sleeve


def load_of(mass: Any, gravity: Any, rope: Any, damping: Any, brake: Brake) -> Load:
    """The load of a mass [kg] on a rope [N/m] (None: on the brake alone) with damping [N s/m]."""
    own = working_stiffness(brake)
    if damping is not None:
        return Load(mass, gravity, own, rope, damping)
    return Load(mass, gravity, own if rope is None else 1 / (1 / own + 1 / rope), 0.0, 0.0)


@law
def stop_in_time(
    mass: Any, speed: Any, vacuum: Any, times: Any, rope: Any, damping: Any, gravity: Any,
    step: Any, steps: Any, brake: Brake,
) -> Motion:  # fmt: skip
    """March a mass [kg] arriving with `speed` [m/s] to its first standstill or the end of travel.

    `vacuum` [Pa] broadcasts with the rest where `times` is None; with `times` [s], shape (H,), it
    holds samples of a history. `rope` [N/m] and `damping` [N s/m] may be None. `step` [s] may
    differ from drop to drop, `steps` is the most that are taken; outcome MOVING where they did not
    do. Energy is kept to rounding, time and slip are of second order in the step (slip exact at
    constant vacuum without damping).
    """
    damped, steady = damping is not None, times is None
    history = Vacuum(vacuum, times)
    first = vacuum if steady else history.at(0.0)
    load = load_of(mass, gravity, rope, damping, brake)
    parts = jax.tree.leaves((load, setting_of(first, load.spring, brake), speed, step))
    speed = jnp.broadcast_to(speed, jnp.broadcast_shapes(*(jnp.shape(a) for a in parts)))
    start = at_start(speed, first, steady)

    def going(state: tuple[Any, Motion]) -> Any:
        return (state[0] < steps) & jnp.any(state[1].outcome == MOVING)

    def on(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        return state[0] + 1, step_on(state[1], step, history, load, brake, damped)

    last = jax.lax.while_loop(going, on, (jnp.zeros_like(steps), start))[1]
    last = ended(last, step, history, load, brake, damped)
    fine = (mass > 0) & (speed >= 0) & (gravity >= 0) & (step > 0) & (jnp.min(vacuum) >= 0)
    return jax.tree.map(lambda a: within(fine, a) if a.dtype == jnp.float64 else a, last)
