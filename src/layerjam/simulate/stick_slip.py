"""Stick–slip: the brake pulled steadily through its mount, with a mass that sticks and slips.

The moving cap and what hangs on it are one mass, rig and sheets one spring. Friction follows a
Stribeck law and falls with slip as the overlap is used up; the enclosure pulls beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from layerjam.device.brake import Brake, mass
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError, QuantityError
from layerjam.mechanics.enclosure import backbone, backbone_stored, enclosure_at
from layerjam.mechanics.fan import straight
from layerjam.mechanics.friction import friction_per_contact, growth
from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.stick_slip.curve import Stribeck
from layerjam.mechanics.stick_slip.laws import critical_speed, of_film, slow_saw
from layerjam.mechanics.stick_slip.slide import (
    CLOSED,
    SEPARATED,
    STEADY,
    TOO_LONG,
    slide,
)
from layerjam.mechanics.stick_slip.slide_step import Slide
from layerjam.mechanics.stiffness import stiffness_before_slip, working_stiffness
from layerjam.simulate.quantities import CROSSHEAD_SPEED, ELONGATION, MASS, VACUUM, check_given
from layerjam.simulate.record import Outcome, PullRecord, column, stated
from layerjam.simulate.speed import follows_speed
from layerjam.units import QuantitySpec, show

Array = np.ndarray[Any, np.dtype[Any]]
TEETH = 12
"""Events a run is long enough for, unless its travel is given."""
EVENTS, SAMPLES, TOLERANCE = 512, 60_000, 1e-9
MAP_TOLERANCE, MAP_ACTIONS = 1e-7, 20_000
LIMITS = {
    "speed": replace(CROSSHEAD_SPEED, lo=0.0, open_lo=True),
    "mass": replace(MASS, lo=0.0, open_lo=True),
    "mount_stiffness": QuantitySpec("N/m", "stiffness of the mount", open_lo=True),
    "travel": replace(ELONGATION, lo=0.0, open_lo=True),
    "step": QuantitySpec("s", "longest step", open_lo=True),
    "damping": QuantitySpec("N s/m", "damping beside the spring"),
    "hold": QuantitySpec("s", "time that the crosshead stands still"),
}
ENDS = {
    SEPARATED: Outcome.SEPARATED,
    CLOSED: Outcome.CLOSED_BY_SLEEVE,
    STEADY: Outcome.STEADY_SLIDING,
}
"""Outcomes of a run by the reason for which it ended; others depend on what happened in it."""


@dataclass(frozen=True)
class Events:
    """The slips of a run, arrays of shape (events,), SI units."""

    break_time: Array = field(repr=False)
    stick_time: Array = field(repr=False)
    force_at_break: Array = field(repr=False)
    force_high: Array = field(repr=False)
    force_low: Array = field(repr=False)
    slip: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.slip)


@dataclass(frozen=True, kw_only=True)
class StickSlipRecord(PullRecord):
    """A pull with stick and slip; arrays have shape (N,), SI units; N differs from run to run.

    While the sheets stick there is a sample at either end only: force and elongation are straight
    lines between. The outcome is STEADY_SLIDING (the record ends where the motion has settled),
    JUDDERS, STUCK, SEPARATED or CLOSED_BY_SLEEVE.
    """

    command: ClassVar[str] = "stick-slip"
    speed_of_mass: Array = column("m/s", "speed of the moving mass, that of the sliding sheets")
    sliding: Array = column("1", "1 while the sheets slide, 0 while they stick")
    work: Array = column("J", "work done by the crosshead")
    dissipated_energy: Array = column("J", "energy turned into heat")
    stored_energy: Array = column("J", "energy held in spring, enclosure and moving mass")
    events: Events
    vacuum: float
    speed: float
    mass: float
    stiffness: float
    damping: float
    stribeck: Stribeck

    def conditions(self) -> dict[str, str]:
        """Vacuum, speed, mass, spring, damper and friction in SI."""
        curve = self.stribeck
        return {
            **stated(self, vacuum="Pa", speed="m/s", mass="kg", stiffness="N/m", damping="N s/m"),
            "static friction": f"{curve.static!r}",
            "kinetic friction": f"{curve.kinetic!r}",
            "Stribeck speed": f"{curve.speed!r} m/s",
            "Stribeck exponent": f"{curve.exponent!r}",
            "viscous growth": f"{curve.viscous!r} s/m",
        }

    def frozen(self, slip: Any) -> Slide:
        """What is pulled here, with friction held at its value at a slip [m]; slips broadcast."""
        known: dict[str, Any] = {name: getattr(self, name) for name in _PULLED}
        return slide_of(self.brake.brake, slip=slip, frozen=True, **known)


_PULLED = ("vacuum", "speed", "mass", "stiffness", "damping", "stribeck")


def moving_mass(brake: Brake) -> float:
    """Half of the brake [kg]: one cap and the sheets it holds, nothing of the rig (assumed)."""
    return mass(brake) / 2


def series_stiffness(brake: Brake, mount: float | None = None) -> float:
    """Spring [N/m]: as measured in the rig; with a mount of one's own, that and the stuck sheets'.

    The measured stiffness holds the paper's rig already, so a mount given replaces it.
    """
    if mount is None:
        return float(working_stiffness(brake))
    return 1 / (1 / float(stiffness_before_slip(brake)) + 1 / mount)


@in_double_precision
def slide_of(
    brake: Brake,
    *,
    vacuum: Any,
    speed: Any,
    mass: Any,
    stiffness: Any,
    damping: Any = 0.0,
    stribeck: Stribeck | None = None,
    slip: Any = 0.0,
    frozen: bool = False,
) -> Slide:
    """The brake as a mass on a spring; `frozen` holds friction at its value at `slip` [m].

    Entries broadcast. The crosshead never stops and the run has no end yet: set `ramp` and `end`.
    """
    brake = straight(brake, "stick–slip")
    curve = stribeck or of_film(brake)
    c = np.asarray(friction_per_contact(np.asarray(vacuum, float), brake))
    c = c * curve.kinetic / brake.film.kinetic
    enclosure, overlap = enclosure_at(np.asarray(vacuum, float), brake), brake.sheets.overlap
    held = np.asarray(backbone(np.asarray(slip, float), enclosure)) if frozen else 0.0
    return Slide(
        mass=mass,
        spring=stiffness,
        damping=damping,
        speed=speed,
        ramp=np.inf,
        end=np.inf,
        step=np.inf,
        level=c * (overlap - np.asarray(slip) if frozen else overlap),
        fall=np.zeros(()) if frozen else c,
        rise=(curve.static - curve.kinetic) / curve.kinetic,
        stribeck=curve.speed,
        exponent=curve.exponent,
        viscous=curve.viscous / curve.kinetic,
        base=held,
        enclosure=None if frozen else enclosure,
        overlap=np.inf if frozen else overlap,
        start=0.0 if frozen else slip,
        events=np.inf,
        tolerance=TOLERANCE,
        law=brake.speed_law if follows_speed(brake) else None,
    )


class Bounds(NamedTuple):
    """Friction at one slip."""

    static: Any
    """What the brake at rest bears [N], enclosure included."""
    kinetic: Any
    """[N]"""


def bounds_at(at: Slide, speed: Any = None) -> Bounds:
    """Static and kinetic force [N] of a frozen slide.

    With a speed law the kinetic one is that at a `speed` [m/s], the crosshead's unless given.
    """
    kinetic = at.level + np.asarray(at.base)
    if at.law is not None:
        pace = at.speed if speed is None else speed
        kinetic = at.level * growth(pace, at.law) + np.asarray(at.base)
    return Bounds(at.level * (1 + np.asarray(at.rise)) + at.base, kinetic)


@in_double_precision
def _check_hold(hold: float, step: float) -> None:
    if not hold / step <= 0.9 * SAMPLES:
        raise QuantityError(
            f"step: {step:g} s makes too many steps ({hold / step:.0f}) of the hold of {hold:g} s; "
            "longer steps give the same result"
        )


def stick_slip(
    file: BrakeFile,
    *,
    vacuum: float,
    speed: float,
    mass: float | None = None,
    mount_stiffness: float | None = None,
    damping: float = 0.0,
    stribeck: Stribeck | None = None,
    slip: float = 0.0,
    travel: float | None = None,
    hold: float = 0.0,
    step: float = np.inf,
) -> StickSlipRecord:
    """Pull a brake at `speed` [m/s] from rest at `slip` [m], over a `travel` of the crosshead [m].

    `mass` [kg] is by default `moving_mass`, the spring `series_stiffness`; `damping` [N s/m] acts
    beside the spring. Without `travel` the pull is long enough for a dozen events. The crosshead
    then stands still for `hold` [s]. `step` [s] bounds the steps; the result does not depend on
    it while the sheets stick. Raises FitError where the run would be too long to follow.
    """
    brake = file.brake
    replace(VACUUM, hi=brake.site.atmosphere).check(vacuum, "vacuum")
    given = {"speed": speed, "mass": mass, "mount_stiffness": mount_stiffness, "travel": travel}
    bounded = {"damping": damping, "hold": hold, "step": None if step == np.inf else step}
    check_given({**given, **bounded}, LIMITS)
    _check_hold(hold, step)
    pulled: dict[str, Any] = {
        "vacuum": vacuum,
        "speed": speed,
        "mass": moving_mass(brake) if mass is None else mass,
        "stiffness": series_stiffness(brake, mount_stiffness),
        "damping": damping,
        "stribeck": stribeck or of_film(brake),
    }
    at = slide_of(brake, slip=slip, **pulled)
    travel = _travel(at, brake, speed, slip) if travel is None else travel
    at = at._replace(ramp=travel / speed, end=travel / speed + hold, step=step)
    state = slide(at, events=EVENTS, samples=SAMPLES, most=4 * SAMPLES)
    if int(state.reason) == TOO_LONG:
        raise FitError(
            f"speed: at {show(speed, 'm/s')} the motion over {show(travel, 'm')} has more than "
            f"{SAMPLES} steps; pull over a shorter travel, give more damping or, if the Stribeck "
            "speed is very small, 0 for it"
        )
    table = np.asarray(state.table)[: min(int(state.count), EVENTS)]
    rows = np.asarray(state.trace)[: int(state.written)]
    time, crosshead, force, slips, pace, work, heat, sliding = rows.T
    # of the whole table, which has one length: compiled once
    held = np.asarray(backbone_stored(state.trace[:, 3], enclosure_at(vacuum, brake)))[: len(rows)]
    spring_held = at.spring * np.maximum(crosshead - slips, 0.0) ** 2 / 2
    return StickSlipRecord(
        time=time,
        elongation=crosshead - slip,
        force=force,
        slip=slips,
        speed_of_mass=pace,
        sliding=sliding,
        work=work,
        # friction of the enclosure is part of the resistance, but half of its work is stored
        dissipated_energy=heat - (held - held[0]),
        stored_energy=spring_held + at.mass * pace**2 / 2 + held,
        events=Events(*table.T),
        **pulled,
        outcome=_outcome(state, rows, table),
        brake=file,
        warnings=tuple(file.warnings()),
    )


def _travel(at: Slide, brake: Brake, speed: float, slip: float) -> float:
    """Crosshead travel [m] for TEETH events, or for the swings of a fast pull."""
    static = float(at.level - at.fall * slip) * (1 + float(at.rise))
    kinetic = float(at.level - at.fall * slip)
    # without friction there are no teeth
    tooth = float(slow_saw(static, kinetic, at.spring, at.mass, speed).slip) if kinetic else 0.0
    swings = 30 * 2 * np.pi * np.sqrt(at.mass / at.spring) * speed
    enclosure = 0.0 if at.enclosure is None else float(backbone(slip, at.enclosure))
    onset = (static + enclosure) / float(at.spring)
    room = onset + max(brake.sheets.usable_travel - slip, 0.0)
    return float(min(onset + max(TEETH * tooth, swings), room))


def _outcome(state: Any, rows: Array, table: Array) -> Outcome:
    if int(state.reason) in ENDS:
        return ENDS[int(state.reason)]
    if not rows[:, 7].any():
        return Outcome.STUCK
    # once the sheets have stuck again the next slip starts as the one before
    return Outcome.JUDDERS if len(table) else Outcome.STEADY_SLIDING


class Tooth(NamedTuple):
    """Stick–slip at one slip; arrays of the broadcast shape."""

    judders: Array
    amplitude: Array
    """Half of the swing of the force [N]; 0 where it slides steadily."""
    force_high: Array
    force_low: Array
    slip: Array
    """[m]"""
    period: Array
    """[s]"""


def tooth(at: Slide, swings: int = 300) -> Tooth:
    """One event of a frozen slide, or none; entries of `at` may be arrays.

    A mass that sticks again starts its next slip as it did this one, so that one event tells all.
    Where there is none the motion is followed for so many `swings`.
    """
    static, _ = bounds_at(at)
    omega = np.sqrt(np.asarray(at.spring) / at.mass)
    end = np.asarray(static) / (np.asarray(at.spring) * at.speed) + swings * 2 * np.pi / omega
    at = at._replace(ramp=np.inf, end=end, events=1.0, tolerance=MAP_TOLERANCE)
    state = slide(at, events=1, samples=1, most=MAP_ACTIONS)
    row = np.asarray(state.table)[..., 0, :]
    judders = np.asarray(state.count) > 0
    high, low, slip = (np.where(judders, row[..., i], 0.0) for i in (3, 4, 5))
    swing = np.where(judders, (high - low) / 2, 0.0)
    period = np.where(judders, slip / at.speed, np.nan)
    return Tooth(judders, swing, high, low, slip, period)


def amplitude_map(
    brake: Brake,
    speeds: Array,
    vacuums: Array,
    *,
    mass: Any,
    stiffness: Any,
    damping: Any = 0.0,
    stribeck: Stribeck | None = None,
    slip: float = 0.0,
    swings: int = 300,
) -> Tooth:
    """Stick–slip over speed [m/s] and vacuum [Pa], which broadcast; friction is that at `slip`.

    `mass` [kg], `stiffness` [N/m] and `damping` [N s/m] may be arrays that broadcast with them.
    """
    speeds, vacuums = np.broadcast_arrays(speeds, vacuums)
    at = slide_of(
        brake,
        vacuum=vacuums,
        speed=speeds,
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        stribeck=stribeck,
        slip=slip,
        frozen=True,
    )
    return tooth(at, swings)


def critical_speed_of(at: Slide) -> float:
    """Speed [m/s] above which stick–slip from a standing start dies, friction frozen.

    Closed form for the jump law while the spring stays taut; otherwise bracketed by runs to a
    thousandth. Infinite where nothing damps.
    """
    static, kinetic = (float(v) for v in bounds_at(at, 0.0))
    drag = float(at.damping) + float(at.level) * float(at.viscous)
    if static <= kinetic:
        return 0.0
    if not drag and at.law is None:
        return float("inf")
    spring, mass = float(at.spring), float(at.mass)
    scale = (static - kinetic) / np.sqrt(spring * mass)
    low, high = 1e-9 * scale, 1e3 * scale
    if float(at.stribeck) == 0.0 and float(at.viscous) == 0.0 and at.law is None:
        speed = float(critical_speed(static, kinetic, spring, mass, at.damping))
        if speed < low or not tooth(at._replace(speed=1.001 * speed)).judders:
            return speed
        low = speed
    for _ in range(8):
        speeds = np.geomspace(low, high, 24)
        shaken = tooth(at._replace(speed=speeds)).judders
        if not shaken.any():
            return 0.0
        last = int(np.flatnonzero(shaken)[-1])
        low, high = float(speeds[last]), float(speeds[min(last + 1, len(speeds) - 1)])
        if high <= low * 1.001:
            break
    return low
