"""One step of a mass on rope and brake: taut, slack, or a change from one to the other (ours).

See `motion` for the definition of a step; this module defines its states.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import derivative, map_leaves, repeat, xp
from layerjam.brake.mechanics.cycle import Setting
from layerjam.brake.mechanics.enclosure import EnclosureLaw
from layerjam.brake.mechanics.law import safe_sqrt
from layerjam.brake.mechanics.memory import Memory, new_memory
from layerjam.brake.mechanics.roots import newton_root
from layerjam.brake.mechanics.slip_effects import (
    find_equilibrium,
    friction_force,
    friction_tangent,
    growing_work,
    scale_friction,
)
from layerjam.brake.mechanics.speed_effects import brake_growth
from layerjam.brake.mechanics.stop.algebra import snap_slip

_NEWTON = 3
_TIMES = 9


class Load(NamedTuple):
    """Load on the brake in SI units; arrays broadcast."""

    mass: Any
    gravity: Any
    spring: Any
    """Stiffness of brake and rope in series, or of the brake alone if the rope is damped [N/m]."""
    rope: Any
    """Stiffness of a damped rope [N/m]; None if the rope is part of the spring."""
    damping: Any
    """Damping of the rope [N s/m]; None omits the damper entirely."""


class Motion(NamedTuple):
    """State between two steps; arrays of the same shape."""

    time: Any
    place: Any
    """Displacement of the mass from the taut rope [m]."""
    speed: Any
    drawn: Any
    """Elongation of the spring `Load.spring` and the brake together [m]."""
    stretch: Any
    """Stretch of a damped rope [m]."""
    slack: Any
    slip: Any
    force: Any
    """Force in brake and rope [N]."""
    enclosure: Memory | None
    """State of the enclosure; None at constant vacuum, for which the backbone suffices."""
    vacuum: Any
    """Vacuum of the last step [Pa]."""
    heat: Any
    """Energy turned into heat in brake and rope so far [J], integrated separately."""
    peak: Any
    """Largest force so far [N]."""
    outcome: Any
    pace: Any = None
    """Mean speed of the slip in the last step [m/s]; None if friction does not depend on it."""
    lapse: Any = None
    """Duration of that step [s]."""


class _Extension(NamedTuple):
    """The brake after an extension by some distance at one vacuum."""

    drawn: Any
    slip: Any
    force: Any
    work: Any
    heat: Any
    enclosure: Memory | None


def new_motion(speed: Any, vacuum: Any, steady: bool, paced: bool = False) -> Motion:
    """Return a taut and relaxed state; its shape is that of `speed` [m/s] and `vacuum` [Pa].

    `paced` states whether friction depends on the sliding speed.
    """
    speed, vacuum = xp.broadcast_arrays(speed, vacuum)
    zero: Any = xp.zeros_like(speed)
    no, none = xp.zeros(speed.shape, bool), xp.zeros(speed.shape, int)
    start = Motion(**dict.fromkeys(Motion._fields, zero))
    start = start._replace(speed=speed, slack=no, vacuum=vacuum, outcome=none)
    # before the first step it has been at rest for an arbitrary time
    start = start._replace(pace=zero if paced else None, lapse=zero + 1.0 if paced else None)
    return start._replace(enclosure=None if steady else new_memory(speed.shape))


def memory_force(motion: Motion, enclosure: EnclosureLaw) -> Any:
    """Return the force of the enclosure [N], from its memory if it has one."""
    return enclosure.force(motion.slip) if motion.enclosure is None else motion.enclosure.force


def _extend_brake(
    motion: Motion, distance: Any, slides: Any, setting: Setting, c: Any = None
) -> _Extension:
    """Extend the brake by `distance` [m] from a taut state.

    The brake slides if `slides`, otherwise it sticks.

    Friction changes from `c` [N/m] to that of `setting` linearly over the slip.
    """
    elongation = motion.drawn + distance
    if motion.enclosure is None:
        out = find_equilibrium(lambda line: _first_loading(elongation, line), motion.slip, setting)
    else:
        out = motion.enclosure.find_slip(elongation, 1, setting)
    slip = xp.where(slides, xp.maximum(out, motion.slip), motion.slip)
    slide = slip - motion.slip
    force = motion.force + setting.k * (distance - slide)
    friction_heat = growing_work(motion.slip, slip, setting, setting.c if c is None else c)
    work, warm, enclosure = _enclosure_work(motion, slip, setting)
    elastic = (force - motion.force) * (force + motion.force) / (2 * setting.k)
    return _Extension(
        elongation, slip, force, elastic + friction_heat + work, friction_heat + warm, enclosure
    )


def _first_loading(elongation: Any, setting: Setting) -> Any:
    """Return the slip [m] at an elongation [m]; the brake snaps if nothing holds it."""
    drive, soft = setting.k * elongation - setting.c * setting.overlap, setting.c - setting.k
    snap = snap_slip(soft, setting.enclosure)
    # beyond this nothing balances the spring's force, so no root remains
    snaps = xp.isfinite(snap) & (drive >= snap * soft)
    out = setting.enclosure.find_slip(xp.where(snaps, 0.0, drive), -soft)
    return xp.where(snaps, snap, out)


def _balance_step(
    motion: Motion, alpha: Any, beta: Any, setting: Setting, c: Any
) -> tuple[_Extension, Any]:
    """Extend the brake until its mean force is alpha - beta distance [m].

    Also returns the distance.
    """
    hold = friction_force(motion.slip, setting)
    hold = hold + memory_force(motion, setting.enclosure)
    distance = (alpha - motion.force) / (beta + setting.k / 2)
    slides = motion.force + setting.k * distance > hold
    least = (hold - motion.force) / setting.k
    sliding = xp.maximum((alpha - hold) / beta, least * (1 + 1e-9))
    travel = xp.where(slides & (sliding > 0), sliding, distance)

    def newton(_: int, state: tuple[Any, Any, _Extension]) -> tuple[Any, Any, _Extension]:
        travel = state[1]
        pull = _extend_brake(motion, travel, slides, setting, c)
        part = xp.where(travel != 0, travel, 1.0)
        mean = pull.work / part
        step = (mean + beta * travel - alpha) / ((pull.force - mean) / part + beta)
        return travel, xp.where(slides, xp.maximum(travel - step, least), distance), pull

    # the last turn extends the brake to where the Newton steps end: one copy of it to compile
    zero = xp.zeros_like(travel)
    still = _Extension(zero, zero, zero, zero, zero, motion.enclosure)
    end, _, pull = repeat(_NEWTON + 1, newton, (travel, travel, still))
    return pull, end


def rest_setting(setting: Setting) -> Setting:
    """Return the setting with the friction of sheets at rest."""
    if setting.paced_brake is None:
        return setting
    result: Setting = scale_friction(setting, brake_growth(0.0, setting.paced_brake))
    return result


def _balance_paced(
    motion: Motion, alpha: Any, beta: Any, setting: Setting, brake: Brake, dt: Any
) -> tuple[_Extension, Any]:
    """Return `_balance_step` for friction that depends on the speed, by a search for the slip.

    The force changes linearly from its old value to that of the new slip and its speed, so that
    the spring's work is exact. The speed at the end follows from a parabola through two steps.
    """
    start, force = motion.slip, motion.force
    share = dt / (dt + motion.lapse)

    def state_at(slip: Any) -> tuple[Any, Any]:
        mean = (slip - start) / dt
        pace = xp.maximum(mean + (mean - motion.pace) * share, 0.0)
        new = friction_force(slip, scale_friction(setting, brake_growth(pace, brake)))
        new = new + memory_force(_slide_to(motion, slip, setting), setting.enclosure)
        return new, slip - start + (new - force) / setting.k

    def excess(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        def excess_force(slip: Any) -> Any:
            new, distance = state_at(slip)
            return (force + new) / 2 + beta * distance - alpha

        return excess_force(state[0]), derivative(excess_force, state[0]), None

    hold = friction_force(start, rest_setting(setting))
    hold = hold + memory_force(motion, setting.enclosure)
    stuck = (alpha - force) / (beta + setting.k / 2)
    slides = force + setting.k * stuck > hold
    # the slip is at most that of a mass and spring without resistance
    farthest = start + xp.maximum(alpha / beta, 0.0) + force / setting.k
    guess = xp.minimum(start + motion.pace * dt, (start + farthest) / 2)
    slip = xp.where(slides, newton_root(excess, guess, start, farthest), start)
    new, sliding = state_at(slip)
    distance = xp.where(slides, sliding, stuck)
    new = xp.where(slides, new, force + setting.k * stuck)
    mean = (force + new) / 2
    work, warm, enclosure = _enclosure_work(motion, slip, setting)
    slide = slip - start
    heat = mean * slide - work + warm
    pull = _Extension(motion.drawn + distance, slip, new, mean * distance, heat, enclosure)
    return pull, distance


def _slide_to(motion: Motion, slip: Any, setting: Setting) -> Motion:
    """Return the motion with its enclosure at a different slip [m]."""
    if motion.enclosure is None:
        return motion._replace(slip=slip)
    return motion._replace(slip=slip, enclosure=motion.enclosure.slide_to(slip, setting.enclosure))


def _enclosure_work(motion: Motion, slip: Any, setting: Setting) -> tuple[Any, Any, Memory | None]:
    """Return the enclosure's work up to a slip [J], the part that is heat, and its new state."""
    old, new = motion.enclosure, _slide_to(motion, slip, setting).enclosure
    if old is not None and new is not None:
        warm = new.heat - old.heat
        return warm + new.stored - old.stored, warm, new
    strip, start = setting.enclosure, motion.slip
    return strip.work(slip) - strip.work(start), strip.heat(slip) - strip.heat(start), None


def _advance_taut(motion: Motion, dt: Any, setting: Setting, c: Any, load: Load) -> Motion:
    damped = load.damping is not None
    m, g, v = load.mass, load.gravity, motion.speed
    if damped:
        kappa = load.rope / 2 + load.damping / dt
        share = 1 + kappa * dt**2 / (2 * m)
        alpha = (load.rope * motion.stretch + kappa * (v * dt + g * dt**2 / 2)) / share
        beta = kappa / share
    else:
        alpha, beta = m * (g + 2 * v / dt), 2 * m / dt**2
    if setting.paced_brake is None:
        pull, distance = _balance_step(motion, alpha, beta, setting, c)
    else:
        pull, distance = _balance_paced(motion, alpha, beta, setting, setting.paced_brake, dt)
    mean = alpha - beta * distance
    place = v * dt + (g - mean / m) * dt**2 / 2
    stretch = place - distance if damped else xp.zeros_like(distance)
    rope = load.damping * stretch**2 / dt if damped else 0.0
    return motion._replace(
        **_pace_fields(motion, pull.slip, dt),
        time=motion.time + dt,
        place=motion.place + place if damped else pull.drawn,
        speed=v + (g - mean / m) * dt,
        drawn=pull.drawn,
        stretch=motion.stretch + stretch,
        slip=pull.slip,
        force=pull.force,
        enclosure=pull.enclosure,
        heat=motion.heat + pull.heat + rope,
        peak=xp.maximum(motion.peak, _highest_force(motion, pull, setting)),
    )


def _peak_tangent(setting: Setting) -> Any:
    """Return the friction's tangent where the first-loading force is largest."""
    top = 0.0 * setting.c
    for _ in range(4):
        fall = xp.where(setting.c > 0, friction_tangent(top, setting).c, 1.0)
        top = (setting.enclosure.root / (2 * fall)) ** 2
    return friction_tangent(top, setting)


def _highest_force(motion: Motion, pull: _Extension, setting: Setting) -> Any:
    """Return the largest force within a step [N], which may exceed that at its ends.

    It is the top of the backbone, if the step passed it. With a speed law the peak depends on the
    speeds, so the force after the step is used; the error is of second order.
    """
    if setting.paced_brake is not None:
        return pull.force
    line = _peak_tangent(setting) if setting.shapes else setting
    top = (setting.enclosure.root / (2 * xp.where(line.c > 0, line.c, 1.0))) ** 2
    is_passed = (motion.slip < top) & (top < pull.slip) & (top < setting.enclosure.saturation)
    if pull.enclosure is not None:  # this holds only on the backbone
        first = setting.enclosure.force(pull.slip)
        is_passed = is_passed & (xp.abs(pull.enclosure.force - first) <= 1e-9 * first)
    top_force = line.c * line.overlap + setting.enclosure.root**2 / (4 * line.c)
    return xp.where(is_passed, top_force, pull.force)


def force_between(
    old: Motion, new: Motion, vacuum: Any, setting_at: Callable[[Any], Setting]
) -> Any:
    """Return the largest force [N] within a step to a different vacuum [Pa], zero if it is an end.

    In first loading the slip follows from the elongation, which changes evenly within a step. So
    the force is known at nine times, with a parabola at the highest.
    """
    before, after = setting_at(old.vacuum), setting_at(vacuum)
    if before.paced_brake is not None:
        return xp.zeros_like(new.force)
    share = xp.linspace(0.0, 1.0, _TIMES).reshape((-1,) + (1,) * xp.ndim(new.force))
    setting = setting_at(old.vacuum + share * (vacuum - old.vacuum))
    elongation = old.drawn + share * (new.drawn - old.drawn)
    slip = find_equilibrium(
        lambda line: _first_loading(elongation, line), 0.0 * elongation, setting
    )
    force = setting.k * (elongation - xp.maximum(slip, old.slip))
    low, middle, high = force[:-2], force[1:-1], force[2:]
    bend = 2 * middle - low - high
    is_top = (middle >= low) & (middle >= high) & (bend > 0)
    top = middle + (high - low) ** 2 / (8 * xp.where(is_top, bend, 1.0))
    is_first = ~old.slack & ~new.slack
    for motion, setting in ((old, before), (new, after)):
        backbone = setting.enclosure.force(motion.slip)
        load_force = memory_force(motion, setting.enclosure)
        is_first = is_first & (xp.abs(load_force - backbone) <= 1e-9 * backbone)
    return xp.max(xp.where(is_top & is_first, top, 0.0), axis=0)


def _pace_fields(motion: Motion, slip: Any, dt: Any) -> dict[str, Any]:
    """Return the mean speed of the slip in a step [m/s], and the duration of that step [s]."""
    if motion.pace is None:
        return {}
    # a step of zero duration must not change the speed
    duration = xp.where(dt > 0, dt, 1.0) + xp.zeros_like(motion.lapse)
    mean = xp.where(dt > 0, (slip - motion.slip) / duration, motion.pace)
    return {"pace": mean, "lapse": xp.where(dt > 0, duration, motion.lapse)}


def _advance_until_slack(motion: Motion, dt: Any, setting: Setting, load: Load) -> Motion:
    """Advance to the instant at which the contracting brake no longer pulls."""
    damped = load.damping is not None
    m, v, force = load.mass, motion.speed, motion.force
    pull, shrink = load.gravity - force / (2 * m), force / setting.k
    time = safe_sqrt(xp.maximum(v**2 - 2 * pull * shrink, 0.0)) - v
    time = xp.clip(2 * shrink / xp.where(time > 0, time, 1.0), 0.0, dt)
    if damped:
        for _ in range(6):
            short = shrink + v * time + pull * time**2 / 2
            error = (load.rope * motion.stretch - force / 2) * time
            error = error + (load.rope * time / 2 + load.damping) * short
            slope = load.rope * motion.stretch - force / 2 + load.rope * short / 2
            slope = slope + (load.rope * time / 2 + load.damping) * (v + pull * time)
            time = xp.clip(time - error / xp.where(slope != 0, slope, 1.0), 0.0, dt)
    place = v * time + pull * time**2 / 2
    rope_slide = place + shrink if damped else xp.zeros_like(place)
    rope = load.damping * rope_slide**2 / xp.where(time > 0, time, 1.0) if damped else 0.0
    return motion._replace(
        **_pace_fields(motion, motion.slip, time),
        time=motion.time + time,
        place=motion.place + place if damped else motion.slip,
        speed=v + pull * time,
        drawn=motion.slip,
        stretch=motion.stretch + rope_slide,
        slack=xp.ones_like(motion.slack),
        force=xp.zeros_like(force),
        heat=motion.heat + rope,
    )


def _advance_slack(motion: Motion, dt: Any, load: Load) -> Motion:
    """Advance in free flight by a step, or until the rope is taut again."""
    damped = load.damping is not None
    g, v = load.gravity, motion.speed

    def rope_stretch(time: Any) -> Any:
        if not damped:
            return motion.stretch
        return motion.stretch * xp.exp(-load.rope / load.damping * time)

    gap = motion.slip + motion.stretch - motion.place
    root = v + safe_sqrt(xp.maximum(v**2 + 2 * g * gap, 0.0))
    # the mass falls back; without gravity it flies off and never does
    time = xp.where(root > 0, 2 * gap / xp.where(root > 0, root, 1.0), xp.inf)
    if damped:
        time = xp.minimum(time, dt)
        for _ in range(6):
            overshoot = motion.place + v * time + g * time**2 / 2 - motion.slip - rope_stretch(time)
            slope = v + g * time + load.rope / load.damping * rope_stretch(time)
            time = xp.maximum(time - overshoot / xp.where(slope != 0, slope, 1.0), 0.0)
        gets_taut = (time <= dt) & (v + g * time >= 0)
    else:
        gets_taut = (time <= dt) & (root > 0)
    time = xp.where(gets_taut, time, dt)
    stretch = rope_stretch(time)
    place = motion.place + v * time + g * time**2 / 2
    return motion._replace(
        **_pace_fields(motion, motion.slip, time),
        time=motion.time + time,
        place=xp.where(gets_taut, motion.slip + stretch, place),
        speed=v + g * time,
        stretch=stretch,
        slack=~gets_taut,
        heat=motion.heat + (load.rope * (motion.stretch**2 - stretch**2) / 2 if damped else 0.0),
    )


def change_vacuum(motion: Motion, vacuum: Any, setting: Setting) -> Motion:
    """Change the vacuum while the mass rests; the slip of the brake turns into heat."""
    if motion.enclosure is None:  # constant vacuum
        return motion
    enclosure = motion.enclosure.apply_vacuum(setting.enclosure)
    new = motion._replace(enclosure=enclosure)
    gives = motion.force > friction_force(motion.slip, setting) + enclosure.force
    if setting.paced_brake is not None:  # with a speed law the brake starts to slide with a delay
        gives = xp.zeros_like(gives)
    pull = _extend_brake(new, xp.zeros_like(motion.slip), gives & ~motion.slack, setting)
    # if the spring drives the sheets harder than friction resists, the excess is heat, except for
    # the enclosure's share
    spring = (motion.force - pull.force) * (motion.force + pull.force) / (2 * setting.k)
    energy = enclosure.stored if pull.enclosure is None else pull.enclosure.stored
    loss = motion.enclosure.stored - energy + spring
    return new._replace(
        enclosure=pull.enclosure,
        slip=pull.slip,
        force=pull.force,
        vacuum=vacuum + xp.zeros_like(motion.vacuum),
        heat=motion.heat + loss,
    )


def step_motion(motion: Motion, dt: Any, setting: Setting, c: Any, load: Load) -> Motion:
    """Advance by one step, which is shortened if the rope becomes slack or taut within it."""
    taut = _advance_taut(motion, dt, setting, c, load)
    loose = _advance_until_slack(motion, dt, setting, load)
    free = _advance_slack(motion, dt, load)
    # a step in which the sheets would separate has not been slack
    parts = (taut.force < 0) & (taut.slip < setting.overlap)
    taut = map_leaves(lambda a, b: xp.where(parts, a, b), loose, taut)
    return map_leaves(lambda a, b: xp.where(motion.slack, a, b), free, taut)
