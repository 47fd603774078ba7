"""One step of a mass on rope and brake: taut, slack, or from one to the other (ours).

See `motion` for what a step is; here are the states it leads through.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.enclosure import (
    EnclosureLaw,
    backbone,
    backbone_dissipated,
    backbone_work,
)
from layerjam.mechanics.fan import along_tangents, force_of, growing_work, grown, tangent
from layerjam.mechanics.friction import growth
from layerjam.mechanics.hysteresis import Setting, slip_to_balance
from layerjam.mechanics.law import safe_sqrt
from layerjam.mechanics.memory import Memory, at_rest, at_vacuum, slide_to
from layerjam.mechanics.pull import rising_root
from layerjam.mechanics.roots import newton_root
from layerjam.mechanics.stop.algebra import snap_slip

_NEWTON = 3


class Load(NamedTuple):
    """What hangs on the brake, in SI; arrays broadcast."""

    mass: Any
    gravity: Any
    spring: Any
    """Brake and rope in series, or the brake alone where the rope is damped [N/m]."""
    rope: Any
    """Stiffness of a damped rope [N/m]; None where the rope is part of the spring."""
    damping: Any
    """[N s/m]; None for none, which leaves everything of the damper out."""


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
    enclosure: Memory | None
    """State of the enclosure; None at constant vacuum, where the backbone is enough."""
    vacuum: Any
    """What acted in the last step [Pa]."""
    heat: Any
    """Turned into heat in brake and rope so far [J], summed on its own."""
    peak: Any
    """Greatest force so far [N]."""
    outcome: Any
    pace: Any = None
    """Mean speed of the slip in the last step [m/s]; None where friction does not depend on it."""
    lapse: Any = None
    """How long that step took [s]."""


class _Pulled(NamedTuple):
    """The brake after being drawn by some distance at one vacuum."""

    drawn: Any
    slip: Any
    force: Any
    work: Any
    heat: Any
    enclosure: Memory | None


def at_start(speed: Any, vacuum: Any, steady: bool, paced: bool = False) -> Motion:
    """Just taut, everything relaxed; the shape is that of `speed` [m/s] and `vacuum` [Pa].

    `paced` where friction depends on the sliding speed.
    """
    speed, vacuum = jnp.broadcast_arrays(speed, vacuum)
    zero: Any = jnp.zeros_like(speed)
    no, none = jnp.zeros(speed.shape, bool), jnp.zeros(speed.shape, int)
    rest = Motion(**dict.fromkeys(Motion._fields, zero))
    rest = rest._replace(speed=speed, slack=no, vacuum=vacuum, outcome=none)
    # before the first step it has stood still for any time
    rest = rest._replace(pace=zero if paced else None, lapse=zero + 1.0 if paced else None)
    return rest._replace(enclosure=None if steady else at_rest(speed.shape))


def force_of_enclosure(motion: Motion, at: EnclosureLaw) -> Any:
    """Force of the enclosure [N], by its memory if it has one."""
    return backbone(motion.slip, at) if motion.enclosure is None else motion.enclosure.force


def _pulled(motion: Motion, distance: Any, slides: Any, at: Setting, c: Any = None) -> _Pulled:
    """Draw the brake by `distance` [m] from a taut state; it slides where `slides`, else it sticks.

    Friction goes from `c` [N/m] to that of `at` evenly over the slip.
    """
    drawn = motion.drawn + distance
    if motion.enclosure is None:
        out = along_tangents(lambda line: _first_loading(drawn, line), motion.slip, at)
    else:
        out = slip_to_balance(motion.enclosure, drawn, 1, at)
    slip = jnp.where(slides, jnp.maximum(out, motion.slip), motion.slip)
    more = slip - motion.slip
    force = motion.force + at.k * (distance - more)
    rubbed = growing_work(motion.slip, slip, at, at.c if c is None else c)
    work, warm, enclosure = _of_enclosure(motion, slip, at)
    elastic = (force - motion.force) * (force + motion.force) / (2 * at.k)
    return _Pulled(drawn, slip, force, elastic + rubbed + work, rubbed + warm, enclosure)


def _first_loading(drawn: Any, at: Setting) -> Any:
    """Slip [m] at an elongation [m] and constant vacuum; where nothing holds it, the snap."""
    drive, soft = at.k * drawn - at.c * at.overlap, at.c - at.k
    snap = snap_slip(soft, at.enclosure)
    # from there on nothing holds the spring's force: no root is left
    lost = jnp.isfinite(snap) & (drive >= snap * soft)
    out = rising_root(jnp.where(lost, 0.0, drive), -soft, at.enclosure)
    return jnp.where(lost, snap, out)


def _meet(motion: Motion, alpha: Any, beta: Any, at: Setting, c: Any) -> tuple[_Pulled, Any]:
    """Draw the brake until its mean force is alpha - beta distance [m], which goes with it."""
    hold = force_of(motion.slip, at)
    hold = hold + force_of_enclosure(motion, at.enclosure)
    distance = (alpha - motion.force) / (beta + at.k / 2)
    slides = motion.force + at.k * distance > hold
    least = (hold - motion.force) / at.k
    sliding = jnp.maximum((alpha - hold) / beta, least * (1 + 1e-9))
    far = jnp.where(slides & (sliding > 0), sliding, distance)

    def newton(_: int, far: Any) -> Any:
        pulled = _pulled(motion, far, slides, at, c)
        part = jnp.where(far != 0, far, 1.0)
        mean = pulled.work / part
        step = (mean + beta * far - alpha) / ((pulled.force - mean) / part + beta)
        return jnp.where(slides, jnp.maximum(far - step, least), distance)

    # at constant vacuum the loop is short enough to be written out, which batches like
    steady = motion.enclosure is None
    far = jax.lax.fori_loop(0, _NEWTON, newton, far, unroll=steady)
    return _pulled(motion, far, slides, at, c), far


def resting(at: Setting) -> Setting:
    """The same with the friction of sheets at rest."""
    made: Setting = at if at.law is None else grown(at, growth(0.0, at.law))
    return made


def _meet_paced(
    motion: Motion, alpha: Any, beta: Any, at: Setting, law: SpeedLaw, dt: Any
) -> tuple[_Pulled, Any]:
    """`_meet` where friction depends on the sliding speed: the slip is what is looked for.

    The force goes evenly from the old one to that of the new slip and its speed, so that the
    spring's work is exact; the speed at the end is that of a parabola through the last two steps.
    """
    start, force = motion.slip, motion.force
    share = dt / (dt + motion.lapse)

    def there(slip: Any) -> tuple[Any, Any]:
        mean = (slip - start) / dt
        pace = jnp.maximum(mean + (mean - motion.pace) * share, 0.0)
        new = force_of(slip, grown(at, growth(pace, law)))
        new = new + force_of_enclosure(_slide_to(motion, slip, at), at.enclosure)
        return new, slip - start + (new - force) / at.k

    def excess(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        def over(slip: Any) -> Any:
            new, distance = there(slip)
            return (force + new) / 2 + beta * distance - alpha

        return *jax.jvp(over, (state[0],), (jnp.ones_like(start),)), None

    hold = force_of(start, resting(at))
    hold = hold + force_of_enclosure(motion, at.enclosure)
    stuck = (alpha - force) / (beta + at.k / 2)
    slides = force + at.k * stuck > hold
    # it slips at most as far as nothing would hold mass and spring
    far = start + jnp.maximum(alpha / beta, 0.0) + force / at.k
    guess = jnp.minimum(start + motion.pace * dt, (start + far) / 2)
    slip = jnp.where(slides, newton_root(excess, guess, start, far), start)
    new, sliding = there(slip)
    distance = jnp.where(slides, sliding, stuck)
    new = jnp.where(slides, new, force + at.k * stuck)
    mean = (force + new) / 2
    work, warm, enclosure = _of_enclosure(motion, slip, at)
    more = slip - start
    heat = mean * more - work + warm
    pulled = _Pulled(motion.drawn + distance, slip, new, mean * distance, heat, enclosure)
    return pulled, distance


def _slide_to(motion: Motion, slip: Any, at: Setting) -> Motion:
    """The motion with its enclosure at another slip [m]."""
    if motion.enclosure is None:
        return motion._replace(slip=slip)
    return motion._replace(slip=slip, enclosure=slide_to(motion.enclosure, slip, at.enclosure))


def _of_enclosure(motion: Motion, slip: Any, at: Setting) -> tuple[Any, Any, Memory | None]:
    """Work of the enclosure up to a slip [J], what of it is heat, and its state there."""
    old, new = motion.enclosure, _slide_to(motion, slip, at).enclosure
    if old is not None and new is not None:
        warm = new.heat - old.heat
        return warm + new.stored - old.stored, warm, new
    work = backbone_work(slip, at.enclosure) - backbone_work(motion.slip, at.enclosure)
    warm = backbone_dissipated(slip, at.enclosure)
    return work, warm - backbone_dissipated(motion.slip, at.enclosure), None


def _taut(motion: Motion, dt: Any, at: Setting, c: Any, load: Load) -> Motion:
    """One step on the taut rope."""
    damped = load.damping is not None
    m, g, v = load.mass, load.gravity, motion.speed
    if damped:
        kappa = load.rope / 2 + load.damping / dt
        share = 1 + kappa * dt**2 / (2 * m)
        alpha = (load.rope * motion.stretch + kappa * (v * dt + g * dt**2 / 2)) / share
        beta = kappa / share
    else:
        alpha, beta = m * (g + 2 * v / dt), 2 * m / dt**2
    if at.law is None:
        pulled, distance = _meet(motion, alpha, beta, at, c)
    else:
        pulled, distance = _meet_paced(motion, alpha, beta, at, at.law, dt)
    mean = alpha - beta * distance
    place = v * dt + (g - mean / m) * dt**2 / 2
    stretch = place - distance if damped else jnp.zeros_like(distance)
    rope = load.damping * stretch**2 / dt if damped else 0.0
    return motion._replace(
        **_paced(motion, pulled.slip, dt),
        time=motion.time + dt,
        place=motion.place + place if damped else pulled.drawn,
        speed=v + (g - mean / m) * dt,
        drawn=pulled.drawn,
        stretch=motion.stretch + stretch,
        slip=pulled.slip,
        force=pulled.force,
        enclosure=pulled.enclosure,
        heat=motion.heat + pulled.heat + rope,
        peak=jnp.maximum(motion.peak, _highest(motion, pulled, at)),
    )


def _line_at_top(at: Setting) -> Any:
    """The friction's tangent where the force of first loading is greatest."""
    top = 0.0 * at.c
    for _ in range(4):
        top = (at.enclosure.root / (2 * jnp.where(at.c > 0, tangent(top, at).c, 1.0))) ** 2
    return tangent(top, at)


def _highest(motion: Motion, pulled: _Pulled, at: Setting) -> Any:
    """The greatest force of a step [N]: nobody sees it between two steps.

    It is the top of the backbone, if that was passed. With a speed law it lies there only by
    chance, and the force after the step is taken: off by the square of the step.
    """
    if at.law is not None:
        return pulled.force
    line = at if at.fan is None else _line_at_top(at)
    top = (at.enclosure.root / (2 * jnp.where(line.c > 0, line.c, 1.0))) ** 2
    passed = (motion.slip < top) & (top < pulled.slip) & (top < at.enclosure.saturation)
    if pulled.enclosure is not None:  # only on the backbone
        first = backbone(pulled.slip, at.enclosure)
        passed = passed & (jnp.abs(pulled.enclosure.force - first) <= 1e-9 * first)
    most = line.c * line.overlap + at.enclosure.root**2 / (4 * line.c)
    return jnp.where(passed, most, pulled.force)


def _paced(motion: Motion, slip: Any, dt: Any) -> dict[str, Any]:
    """How fast the brake slipped in a step [m/s], and how long that took [s]."""
    if motion.pace is None:
        return {}
    # a step of no time leaves no speed behind
    some = jnp.where(dt > 0, dt, 1.0) + jnp.zeros_like(motion.lapse)
    mean = jnp.where(dt > 0, (slip - motion.slip) / some, motion.pace)
    return {"pace": mean, "lapse": jnp.where(dt > 0, some, motion.lapse)}


def _until_slack(motion: Motion, dt: Any, at: Setting, load: Load) -> Motion:
    """The part of a step after which the brake, shrinking elastically, pulls no more."""
    damped = load.damping is not None
    m, v, force = load.mass, motion.speed, motion.force
    pull, shrink = load.gravity - force / (2 * m), force / at.k
    time = safe_sqrt(jnp.maximum(v**2 - 2 * pull * shrink, 0.0)) - v
    time = jnp.clip(2 * shrink / jnp.where(time > 0, time, 1.0), 0.0, dt)
    if damped:
        for _ in range(6):
            short = shrink + v * time + pull * time**2 / 2
            off = (load.rope * motion.stretch - force / 2) * time
            off = off + (load.rope * time / 2 + load.damping) * short
            slope = load.rope * motion.stretch - force / 2 + load.rope * short / 2
            slope = slope + (load.rope * time / 2 + load.damping) * (v + pull * time)
            time = jnp.clip(time - off / jnp.where(slope != 0, slope, 1.0), 0.0, dt)
    place = v * time + pull * time**2 / 2
    more = place + shrink if damped else jnp.zeros_like(place)
    rope = load.damping * more**2 / jnp.where(time > 0, time, 1.0) if damped else 0.0
    return motion._replace(
        **_paced(motion, motion.slip, time),
        time=motion.time + time,
        place=motion.place + place if damped else motion.slip,
        speed=v + pull * time,
        drawn=motion.slip,
        stretch=motion.stretch + more,
        slack=jnp.ones_like(motion.slack),
        force=jnp.zeros_like(force),
        heat=motion.heat + rope,
    )


def _slack(motion: Motion, dt: Any, load: Load) -> Motion:
    """Free flight for a step, or up to the place where the rope is taut again."""
    damped = load.damping is not None
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
        **_paced(motion, motion.slip, time),
        time=motion.time + time,
        place=jnp.where(reached, motion.slip + stretch, place),
        speed=v + g * time,
        stretch=stretch,
        slack=~reached,
        heat=motion.heat + (load.rope * (motion.stretch**2 - stretch**2) / 2 if damped else 0.0),
    )


def pump(motion: Motion, vacuum: Any, at: Setting) -> Motion:
    """Another vacuum while the mass rests: what the brake slips by turns into heat."""
    if motion.enclosure is None:  # constant vacuum
        return motion
    enclosure = at_vacuum(motion.enclosure, at.enclosure)
    new = motion._replace(enclosure=enclosure)
    gives = motion.force > force_of(motion.slip, at) + enclosure.force
    if at.law is not None:  # it takes its time to slide on
        gives = jnp.zeros_like(gives)
    pulled = _pulled(new, jnp.zeros_like(motion.slip), gives & ~motion.slack, at)
    # the spring drives the sheets harder than friction holds: heat, but for the enclosure's share
    spring = (motion.force - pulled.force) * (motion.force + pulled.force) / (2 * at.k)
    held = enclosure.stored if pulled.enclosure is None else pulled.enclosure.stored
    lost = motion.enclosure.stored - held + spring
    return new._replace(
        enclosure=pulled.enclosure,
        slip=pulled.slip,
        force=pulled.force,
        vacuum=vacuum + jnp.zeros_like(motion.vacuum),
        heat=motion.heat + lost,
    )


def ahead(motion: Motion, dt: Any, at: Setting, c: Any, load: Load) -> Motion:
    """One step, shorter where the rope goes slack or taut within it."""
    taut = _taut(motion, dt, at, c, load)
    parted = _until_slack(motion, dt, at, load)
    free = _slack(motion, dt, load)
    # a step so long that the sheets would lie apart at its end has not been slack
    parts = (taut.force < 0) & (taut.slip < at.overlap)
    taut = jax.tree.map(lambda a, b: jnp.where(parts, a, b), parted, taut)
    return jax.tree.map(lambda a, b: jnp.where(motion.slack, a, b), free, taut)
