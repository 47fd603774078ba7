"""Motion in time of a mass on rope and brake: any vacuum, damping, rebound, slack rope (ours).

The brake's force depends only on its path. A step finds the elongation at which its mean force
(work per distance) equals the force that slows the mass. Work and heat are exact along the path, so
that energy is conserved to rounding with any step; the error of time is of second order.

Without rope damping, rope and brake are one spring, as in the exact stop. With it, the rope is a
parallel spring and damper (it only pulls) in series with the brake.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import (
    choose,
    is_double,
    leaves,
    map_leaves,
    repeat,
    repeat_while,
    xp,
)
from layerjam.brake.mechanics.cycle import Setting
from layerjam.brake.mechanics.enclosure import check_modulus, enclosure_law
from layerjam.brake.mechanics.hysteresis import make_setting
from layerjam.brake.mechanics.law import compiled, keep_if, law
from layerjam.brake.mechanics.memory import sliding_fraction
from layerjam.brake.mechanics.slip_effects import friction_force, friction_tangent
from layerjam.brake.mechanics.speed_effects import has_speed_effects
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.stop.algebra import NOT_A_CASE
from layerjam.brake.mechanics.stop.motion_step import (
    Load,
    Motion,
    change_vacuum,
    force_between,
    memory_force,
    new_motion,
    rest_setting,
    step_motion,
)

MOVING, STANDSTILL, TRAVEL_USED, CLOSED, SNAPPED = 0, 1, 2, 3, 4
"""Outcomes: still moving, first standstill, end of travel, closing enclosure, snap.

NOT_A_CASE (-1) if a quantity lies outside the domain; all numbers are then NaN.
"""
LONGEST = 0.25
"""Ratio of the longest step to sqrt(M/k); longer steps would pass over a standstill."""


def _find_event(old: Motion, new: Motion, setting: Setting, travel: Any) -> Any:
    """Return the event of a step at which the run must end."""
    hold = friction_force(new.slip, rest_setting(setting))
    enclosure = memory_force(new, setting.enclosure)
    closes = enclosure * (1 - 1e-9) - new.force > hold
    code = xp.where((old.speed > 0) & (new.speed <= 0), STANDSTILL, MOVING)
    code = xp.where(new.slip >= travel, TRAVEL_USED, code)
    code = xp.where((new.slip > 0) & closes, CLOSED, code)
    return xp.where(_snaps(old, new, setting), SNAPPED, code)


def _snaps(old: Motion, new: Motion, setting: Setting) -> Any:
    """Return whether the force fell faster than the spring relaxes between `old` and `new`.

    The brake does not snap if 1 + Y'/k > 0 at the new position and the brake holds the spring
    there. Friction that grows with speed is stable on any spring.
    """
    if setting.paced_brake is not None:
        return xp.zeros_like(new.slack)
    strip = setting.enclosure
    slides = new.slip if new.enclosure is None else sliding_fraction(new.enclosure)
    part = xp.where(slides > 0, slides, 1.0)
    if new.enclosure is None:
        steep = xp.maximum(strip.root / (2 * xp.sqrt(part)), strip.stiffness / strip.reach)
    else:
        steep = strip.stiffness / (strip.reach * part)
    steep = xp.where(slides > 0, steep, xp.inf)
    soft = friction_tangent(new.slip, setting).c - setting.k
    hold = friction_force(new.slip, setting) + memory_force(new, strip)
    is_torn = (new.force > hold * (1 + 1e-6)) & (soft > 0)
    falls = soft >= steep * (1 - 1e-9)
    return ((new.slip > old.slip) & (falls | is_torn)) | (xp.isnan(new.force) & (soft > 0))


class Vacuum(NamedTuple):
    """A vacuum [Pa], or its samples at times [s], shape (H,), interpolated linearly."""

    pressure: Any
    time: Any = None

    def value_at(self, time: Any) -> Any:
        """Return the vacuum [Pa]; constant before the first and after the last sample."""
        return xp.interp(time, self.time, self.pressure)


def try_step(
    motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake
) -> tuple[Motion, Setting]:
    """Return the state after a step of `dt` [s], and the setting at its end.

    A falling vacuum changes before the step to its mean over the step, and after it to its end. A
    rising one changes while the brake slides, because at rest the force could not follow.
    """
    if motion.enclosure is None:
        setting = make_setting(vacuum.pressure, load.spring, brake)
        return step_motion(motion, dt, setting, None, load), setting
    begin, end = motion.vacuum, vacuum.value_at(motion.time + dt)
    falls = end < begin
    if has_speed_effects(brake):  # then a fall needs no separate treatment
        falls = xp.zeros_like(falls)
    level = xp.where(falls, (begin + end) / 2, end)

    def setting_at(pressure: Any) -> Setting:
        return make_setting(pressure, load.spring, brake)

    setting = setting_at(level)
    c = xp.where(falls, setting.c, setting_at(begin).c)

    def advance(stage: Any, current: Motion) -> Motion:
        # a step ends early if the rope becomes slack or taut
        target = xp.where((stage == 1) & falls, vacuum.value_at(current.time), level)
        new = _change_vacuum(target != current.vacuum, current, target, load, brake)
        return choose(stage == 0, lambda m: step_motion(m, dt, setting, c, load), lambda m: m, new)

    new = repeat(2, advance, motion)
    # during a step the force belongs to its mean vacuum, at its end to the true one
    highest = xp.maximum(new.force, force_between(motion, new, new.vacuum, setting_at))
    highest = xp.maximum(motion.peak, highest)
    new = new._replace(peak=xp.where(begin == end, new.peak, highest))
    return new, setting_at(new.vacuum)


def _change_vacuum(changes: Any, motion: Motion, vacuum: Any, load: Load, brake: Brake) -> Motion:
    """Apply a different vacuum [Pa] to the drops for which it changes.

    It is a separate branch, because otherwise the compiler would repeat the computation for every
    number that depends on it, with three times the code and start-up time.
    """

    def change(motion: Motion) -> Motion:
        new = change_vacuum(motion, vacuum, make_setting(vacuum, load.spring, brake))
        return _choose(changes, new, motion)

    return choose(xp.any(changes), change, lambda m: m, motion)  # type: ignore[no-any-return]


def advance_step(motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake) -> Motion:
    """Advance by one step of `dt` [s].

    A state whose next step contains an event does not change, except for its outcome.
    """
    new, setting = try_step(motion, dt, vacuum, load, brake)
    code = _find_event(motion, new, setting, brake.sheets.usable_travel)
    going = (motion.outcome == MOVING) & (code == MOVING)
    still = motion._replace(outcome=xp.where(motion.outcome == MOVING, code, motion.outcome))
    return map_leaves(lambda a, b: xp.where(going, a, b), new, still)


def go_to_event(motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake) -> Motion:
    """Advance to the standstill, end of travel or snap within the next step, by 60 bisections."""
    travel = brake.sheets.usable_travel

    def state_after(time: Any) -> tuple[Motion, Any]:
        new, setting = try_step(motion, time, vacuum, load, brake)
        return new, _snaps(motion, new, setting)

    def bisect(_: int, state: _Bisection) -> _Bisection:
        middle = (state.low + state.high) / 2
        trial, snaps = state_after(middle)
        is_past = (trial.speed <= 0) | (trial.slip >= travel) | snaps
        return _Bisection(
            xp.where(is_past, state.low, middle),
            xp.where(is_past, middle, state.high),
            _choose(is_past, state.before, trial),
            _choose(is_past, trial, state.after),
            xp.where(is_past, snaps, state.snaps),
        )

    # the first interval is the whole step, which is known to contain the event
    least, no = xp.zeros_like(motion.time), xp.zeros_like(motion.slack)
    end = repeat(60, bisect, _Bisection(least, least + 2 * dt, motion, motion, no))
    last = _choose(end.snaps, end.before, end.after)
    used = ~end.snaps & (last.slip >= travel)
    code = xp.where(end.snaps, SNAPPED, xp.where(used, TRAVEL_USED, STANDSTILL))
    last = last._replace(
        speed=xp.where(used | end.snaps, last.speed, 0.0),
        slip=xp.where(used, travel, last.slip),
        outcome=code + 0 * motion.outcome,
    )
    has_event = (motion.outcome == STANDSTILL) | (motion.outcome == TRAVEL_USED)
    return _choose(has_event | (motion.outcome == SNAPPED), last, motion)


class _Bisection(NamedTuple):
    """The two times [s] between which an event happens, and the states there."""

    low: Any
    high: Any
    before: Motion
    after: Motion
    snaps: Any


def _choose(condition: Any, yes: Motion, no: Motion) -> Motion:
    return map_leaves(lambda a, b: xp.where(condition, a, b), yes, no)


def stored_energy(motion: Motion, load: Load, brake: Brake) -> Any:
    """Return the elastic energy [J] in rope, sheets, mount and enclosure."""
    if motion.enclosure is None:
        enclosure = enclosure_law(motion.vacuum, brake).stored_energy(motion.slip)
    else:
        enclosure = motion.enclosure.stored
    rope = xp.zeros_like(motion.stretch)
    if load.rope is not None:
        rope = xp.where(xp.isfinite(load.rope), load.rope * motion.stretch**2 / 2, 0.0)
    return motion.force**2 / (2 * load.spring) + rope + enclosure


def make_load(mass: Any, gravity: Any, rope: Any, damping: Any, brake: Brake) -> Load:
    """Return the load of a mass [kg] on a rope [N/m] (None: only the brake); damping [N s/m]."""
    check_modulus(brake)
    if damping is not None:
        return Load(mass, gravity, working_stiffness(brake), rope, damping)
    return Load(mass, gravity, rope_spring(rope, brake), None, None)


def rope_spring(rope: Any, brake: Brake) -> Any:
    """Return the stiffness [N/m] of rope (None: no rope) and brake in series."""
    stiffness = working_stiffness(brake)
    return stiffness if rope is None else 1 / (1 / stiffness + 1 / rope)


@law
@compiled
def stop_in_time(
    mass: Any,
    speed: Any,
    vacuum: Any,
    times: Any,
    rope: Any,
    damping: Any,
    gravity: Any,
    step: Any,
    steps: Any,
    brake: Brake,
) -> Motion:
    """Integrate the motion of a mass [kg] arriving with `speed` [m/s] to its first standstill.

    It also ends at the end of travel. `vacuum` [Pa] broadcasts with the other arguments if `times`
    is None; with `times` [s], shape (H,), it contains samples of a history. `rope` [N/m] and
    `damping` [N s/m] may be None. `step` [s] may differ from drop to drop. `steps` is the maximum
    number of steps (the largest if there are several); the outcome is MOVING if they were not
    enough. Energy is conserved to rounding. Time and slip are of second order in the step (slip is
    exact at constant vacuum without damping). NaN and NOT_A_CASE outside the domain. A step longer
    than a quarter of sqrt(M/k), with k of rope and brake in series, is also outside, since it may
    pass over events.
    """
    steady = times is None
    history = Vacuum(vacuum, times)
    first = vacuum if steady else history.value_at(0.0)
    load = make_load(mass, gravity, rope, damping, brake)
    parts = leaves((load, make_setting(first, load.spring, brake), speed, step))
    speed = xp.broadcast_to(speed, xp.broadcast_shapes(*(xp.shape(a) for a in parts)))
    start = new_motion(speed, first, steady, has_speed_effects(brake))
    setting = make_setting(first, load.spring, brake)
    fine = (mass > 0) & (speed >= 0) & (gravity >= 0) & (step > 0) & (xp.min(vacuum) >= 0)
    fine = fine & (friction_force(0.0, setting) + setting.enclosure.root >= 0)
    fine = fine & (step <= LONGEST * xp.sqrt(mass / rope_spring(rope, brake)))

    def is_moving(state: tuple[Any, Motion]) -> Any:
        return (state[0] < xp.max(steps)) & xp.any(fine & (state[1].outcome == MOVING))

    def advance(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        return state[0] + 1, advance_step(state[1], step, history, load, brake)

    last = repeat_while(is_moving, advance, (xp.asarray(0), start))[1]
    last = go_to_event(last, step, history, load, brake)
    last = last._replace(outcome=xp.where(fine, last.outcome, NOT_A_CASE))
    return map_leaves(lambda a: keep_if(fine, a) if is_double(a) else a, last)
