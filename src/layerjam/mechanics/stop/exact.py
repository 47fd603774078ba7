"""A mass stopped by the brake at constant vacuum, exactly (paper, section III-E).

The mass hangs on a spring k, rope and brake in series, and on the brake, which slips by s once the
force has reached Y(0). All is work and energy: K(s), the kinetic energy at slip s, is a closed
form, and the travel is its first root. In w = sqrt(s) it is a quartic, smooth at the start.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.enclosure import backbone, backbone_work, enclosure_at
from layerjam.mechanics.fan import force_of, grown
from layerjam.mechanics.friction import friction_per_contact, growth, sheets_at
from layerjam.mechanics.hyperelastic import at_slip, strip_at
from layerjam.mechanics.law import law, safe_sqrt, within
from layerjam.mechanics.stop import fanned, rubber
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    Quartic,
    Setup,
    Stop,
    balance_root,
    curved,
    end_of,
    guess,
    polished,
    quartic,
    search,
    setup,
    slope_of,
    value,
)
from layerjam.mechanics.stop.paced import Course, Paced, paced_course, paced_of, paced_stop
from layerjam.mechanics.stop.timing import Expansion, pieces_time

__all__ = ["BOTTOMED_OUT", "NEVER_SLID", "NOT_A_CASE", "SNAPS", "STOPPED"]
__all__ += ["Stop", "kinetic_energy", "speed_at_slip", "stop", "time_at_slip"]
SETTLED = 1e-5
"""Last step of the root's search, over its bracket, below which the next one changes nothing."""


def _setup(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Setup:
    c, enclosure = friction_per_contact(vacuum, brake), enclosure_at(vacuum, brake)
    return setup(mass, speed, c, brake.sheets.overlap, enclosure, spring, gravity)


def paced_setup(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake, law: SpeedLaw
) -> Paced:
    """What a stop with a speed law starts from: it slides from the friction at rest on."""
    sheets, enclosure = sheets_at(vacuum, brake), enclosure_at(vacuum, brake)
    rest = force_of(0.0, grown(sheets, growth(0.0, law))) / sheets.overlap
    at = setup(mass, speed, rest, sheets.overlap, enclosure, spring, gravity)
    at = at._replace(c=sheets.c + jnp.zeros_like(rest))
    return paced_of(at, gravity, sheets.fan, brake, law)


def kinetic_energy(slip: Any, at: Setup) -> Any:
    """K(s) [J]: what is left of the mass's energy of motion at slip s [m]."""
    change = backbone(slip, at.enclosure) - at.c * slip
    spring = (at.weight - at.onset) * change - change**2 / 2
    work = at.onset * slip - at.c * slip**2 / 2 + backbone_work(slip, at.enclosure)
    return at.kinetic + at.weight * slip - work + spring / at.k


def _first_root(energy: Quartic, low: Any, high: Any) -> Any:
    """sqrt of the slip in [low, high] where the kinetic energy, falling, passes zero.

    Three curved steps from the root without an enclosure; if anywhere they have not settled, Newton
    steps kept in their bracket for all.
    """
    before = guess(energy, low, high)
    for _ in range(2):
        before = curved(energy, before, low, high)
    found = curved(energy, before, low, high)
    settled = jnp.all(~(jnp.abs(found - before) > SETTLED * high))
    return jax.lax.cond(settled, lambda: found, lambda: _bracketed(energy, low, high))


def _bracketed(energy: Quartic, low: Any, high: Any) -> Any:
    def step(_: int, state: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        low, high, w = state
        here, slope = value(energy, w), slope_of(energy, w)
        low, high = jnp.where(here > 0, w, low), jnp.where(here > 0, high, w)
        near = w - here / jnp.where(slope != 0, slope, 1.0)
        inside = (near > low) & (near < high) & (slope != 0)
        return low, high, jnp.where(inside, near, (low + high) / 2)

    return jax.lax.fori_loop(0, 60, step, (low, high, (low + high) / 2))[2]


@law
def stop(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Stop a mass [kg] that arrives with `speed` [m/s] on a taut rope, at a vacuum [Pa].

    `spring` [N/m] is rope and brake in series, `gravity` [m/s^2] acts along the pull (0 for a
    horizontal one); all broadcast. Exact: closed-form work, one bracketed root, the first one. With
    a speed law (of a power above 0) integrated, see `paced`, and not reversely differentiable. With
    a hyperelastic enclosure its work is a quadrature; NOT_A_CASE where that is stretched too far.
    """
    made = _exact(mass, speed, vacuum, spring, gravity, brake)
    law = brake.speed_law
    if law is None:
        return made
    shape = jnp.shape(made.slip)
    given = (jnp.broadcast_to(a, shape) for a in (mass, speed, vacuum, spring, gravity))
    mass, speed, vacuum, spring, gravity = given
    paced = paced_stop(paced_setup(mass, speed, vacuum, spring, gravity, brake, law), speed)
    fine = made.outcome != NOT_A_CASE
    chosen = [jnp.where((law.power > 0) & fine, *pair) for pair in zip(paced, made, strict=True)]
    outcome = chosen[-1]
    return Stop(*(within(outcome != NOT_A_CASE, x) for x in chosen))._replace(outcome=outcome)


def _exact(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """The stop at a friction that does not depend on speed."""
    mass, speed, vacuum, spring, gravity = jnp.broadcast_arrays(
        mass, speed, vacuum, spring, gravity
    )
    if brake.hyperelastic is not None:
        return _rubber_stop(mass, speed, vacuum, spring, gravity, brake)
    if brake.mount.spacers is not None:
        return _fanned_stop(mass, speed, vacuum, spring, gravity, brake)
    at = _setup(mass, speed, vacuum, spring, gravity, brake)
    travel = brake.sheets.usable_travel + jnp.zeros_like(at.kinetic)
    found = search(at, travel)
    # the search is not differentiated: the polishing step carries the gradient of the root
    energy, low, high = jax.lax.stop_gradient((found.energy, found.low, found.high))
    root = _first_root(energy, low, high)
    root = polished(found.energy, root, jax.lax.stop_gradient(slope_of(energy, root)))
    end = end_of(at, found, root)
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    fine = fine & (at.onset + at.enclosure.root >= 0)
    outcome = jnp.where(fine, end.outcome, NOT_A_CASE)
    return Stop(*(within(fine, x) for x in end))._replace(outcome=outcome)


def _fanned(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> fanned.Case:
    sheets, enclosure = sheets_at(vacuum, brake), enclosure_at(vacuum, brake)
    return fanned.case_of(mass, speed, spring, gravity, sheets, enclosure)


def _fanned_stop(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Stop:
    """`stop` where the friction is no straight line over the slip."""
    at = _fanned(mass, speed, vacuum, spring, gravity, brake)
    onset = fanned.force(0.0 * mass, at)
    travel = brake.sheets.usable_travel + 0.0 * (mass + onset)
    end = fanned.stop_of(at, travel)
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    fine = fine & (onset + at.enclosure.root >= 0)
    outcome = jnp.where(fine, end.outcome, NOT_A_CASE)
    return Stop(*(within(fine, x) for x in end))._replace(outcome=outcome)


def _rubber(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> rubber.Case:
    sheets, strip = sheets_at(vacuum, brake), strip_at(vacuum, brake)
    return rubber.Case(mass, mass * speed**2 / 2, mass * gravity, spring, sheets, strip)


def _rubber_stop(
    mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Stop:
    """`stop` of a brake with a hyperelastic enclosure."""
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    # outside the domain the search would meet NaN; there it is given a case of its own
    mass, speed, vacuum, spring, gravity = (
        jnp.where(fine, x, 1.0) for x in (mass, speed, vacuum, spring, gravity)
    )
    at = _rubber(mass, speed, vacuum, spring, gravity, brake)
    end = rubber.stop_of(at, brake.sheets.usable_travel + 0.0 * at.arriving)
    outcome = jnp.where(fine, end.outcome, NOT_A_CASE)
    return Stop(*(within(outcome != NOT_A_CASE, x) for x in end))._replace(outcome=outcome)


@law
def course_of(
    law: SpeedLaw, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> tuple[Any, Course]:
    """Time of the onset [s] and the course after it, of one stop that slides with a speed law."""
    of = paced_setup(mass, speed, vacuum, spring, gravity, brake, law)
    return _elastic_time(mass, speed, gravity, spring, of.at.onset, True), paced_course(of, speed)


def _elastic_time(mass: Any, speed: Any, gravity: Any, spring: Any, force: Any, slides: Any) -> Any:
    """Seconds until the brake begins to slide, or (if it never does) to the first standstill."""
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
    """Speed of the mass [m/s] once the brake has slipped by `slip` [m]; NaN past its standstill.

    NaN with a speed law, where no closed form holds.
    """
    if brake.hyperelastic is not None:
        rubbery = _rubber(mass, speed, vacuum, spring, gravity, brake)
        left = rubber.energy(at_slip(slip, vacuum, brake)[1], rubbery)
        size = rubbery.arriving + rubbery.weight * slip
    elif brake.mount.spacers is not None:
        case = _fanned(mass, speed, vacuum, spring, gravity, brake)
        left, size = fanned.energy(slip, case), case.arriving + case.weight * slip
    else:
        at = _setup(mass, speed, vacuum, spring, gravity, brake)
        left, size = kinetic_energy(slip, at), at.kinetic + at.weight * slip
    # a standstill found to rounding may lie on either side of zero
    pace = safe_sqrt(jnp.where(left < -1e-9 * size, left, jnp.maximum(left, 0.0)) * 2 / mass)
    return within(any_speed(brake), pace)


def any_speed(brake: Brake) -> Any:
    """Whether friction is the same at every speed."""
    return jnp.asarray(True if brake.speed_law is None else brake.speed_law.power == 0)


@law
def time_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Seconds from the taut rope until the brake has slipped by `slip` [m], up to its standstill.

    The elastic part in closed form, the sliding part by Gauss quadrature of dz/v in pieces, cut
    where the mass is slowest and where the enclosure is saturated.
    """
    arrays = jnp.broadcast_arrays(slip, mass, speed, vacuum, spring, gravity)
    slip, mass, speed, vacuum, spring, gravity = arrays
    if brake.hyperelastic is not None:
        rubbery = _rubber(mass, speed, vacuum, spring, gravity, brake)
        onset, weight = force_of(0.0 * slip, rubbery.sheets), rubbery.weight
        sliding = rubber.sliding_time(slip, rubbery)
    elif brake.mount.spacers is not None:
        case = _fanned(mass, speed, vacuum, spring, gravity, brake)
        onset, weight = fanned.force(jnp.zeros_like(slip), case), case.weight
        sliding = fanned.sliding_time(slip, case)
    else:
        at = _setup(mass, speed, vacuum, spring, gravity, brake)
        onset, weight = at.onset, at.weight
        sliding = _sliding_time(slip, at)
    slides = weight + jnp.sqrt(weight**2 + spring * mass * speed**2) > onset
    start = _elastic_time(mass, speed, gravity, spring, onset, slides)
    return within(any_speed(brake), start + sliding)


def _sliding_time(slip: Any, at: Setup) -> Any:
    """Seconds from the first slip to a slip [m] of a kinetic energy in two quartics."""
    end, strip = safe_sqrt(slip), at.enclosure
    balance = jax.lax.stop_gradient(balance_root(at, jnp.inf))
    whole = jnp.minimum(safe_sqrt(strip.saturation + jnp.zeros_like(slip)), end)
    slope = strip.stiffness / strip.reach
    forms = (
        (quartic(at, False), 2 * (1 - at.c / at.k), strip.root / at.k, 0.0 * end, whole),
        (quartic(at, True), 2 * (1 - (at.c - slope) / at.k), 0.0, whole, end),
    )

    def seconds(part: Quartic, bend: Any, linear: Any, low: Any, high: Any) -> Any:
        return pieces_time(
            [low, jnp.clip(balance, low, high), high],
            partial(_quartic_expansion, part),
            lambda w: slope_of(part, w) < 0,
            lambda w: bend * w + linear,
            at.mass,
        )

    return seconds(*forms[0]) + seconds(*forms[1])


def _quartic_expansion(part: Quartic, end: Any, way: Any) -> Expansion:
    """The energy around a point, from its exact derivatives: no digits are lost near zero."""
    rest, first = jnp.maximum(value(part, end), 0.0), way * slope_of(part, end)
    second = 2 * part.a2 + end * (6 * part.a3 + end * 12 * part.a4)
    third, fourth = way * (6 * part.a3 + 24 * part.a4 * end), part.a4

    def energy(far: Any) -> Any:
        return rest + far * (first + far * (second / 2 + far * (third / 6 + far * fourth)))

    return Expansion(rest, first, second, energy)
