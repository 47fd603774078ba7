"""Stick–slip: the brake pulled steadily through its mount, with a mass that sticks and slips.

The moving cap and its load are one mass; the rig and the sheets are one spring. Friction follows a
Stribeck law and falls with slip as the overlap is used up; the enclosure pulls in parallel.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake, mass
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.effects import require_linear
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.speed_effects import brake_growth, depends_on_speed
from layerjam.brake.mechanics.stick_slip.laws import critical_speed, film_curve, slow_saw
from layerjam.brake.mechanics.stick_slip.slide import CLOSED, SEPARATED, STEADY, TOO_LONG, slide
from layerjam.brake.mechanics.stick_slip.slide_step import Slide
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck
from layerjam.brake.mechanics.stiffness import stiffness_before_slip, working_stiffness
from layerjam.brake.simulate.quantities import (
    CROSSHEAD_SPEED,
    ELONGATION,
    MASS,
    VACUUM,
    check_inputs,
)
from layerjam.brake.simulate.record import Outcome, PullRecord, column, header_values
from layerjam.core.brief import brief
from layerjam.core.errors import FitError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, show

Array = np.ndarray[Any, np.dtype[Any]]
TEETH = 12
"""Number of events in a run, unless its travel is given."""
EVENTS, SAMPLES, TOLERANCE = 512, 60_000, 1e-9
MAP_TOLERANCE, MAP_ACTIONS = 1e-7, 20_000
LIMITS = {
    "speed": evolve(CROSSHEAD_SPEED, lo=0.0, open_lo=True),
    "mass": evolve(MASS, lo=0.0, open_lo=True),
    "mount_stiffness": QuantitySpec("N/m", "stiffness of the mount", open_lo=True),
    "travel": evolve(ELONGATION, lo=0.0, open_lo=True),
    "step": QuantitySpec("s", "longest step", open_lo=True),
    "damping": QuantitySpec("N s/m", "damping parallel to the spring"),
    "hold": QuantitySpec("s", "time for which the crosshead rests after the pull"),
}
ENDS = {
    SEPARATED: Outcome.SEPARATED,
    CLOSED: Outcome.CLOSED_BY_SLEEVE,
    STEADY: Outcome.STEADY_SLIDING,
}
"""{reason to end: outcome}; other outcomes depend on the events."""


@dataclass(frozen=True)
class Events:
    """Slips of a run, arrays of shape (events,), SI units."""

    break_time: Array = field(repr=False)
    stick_time: Array = field(repr=False)
    force_at_break: Array = field(repr=False)
    force_high: Array = field(repr=False)
    force_low: Array = field(repr=False)
    slip: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.slip)


@brief
@dataclass(frozen=True, kw_only=True)
class StickSlipRecord(PullRecord):
    """Pull with stick–slip; arrays have shape (N,), SI units; N differs from run to run.

    While the sheets stick there are samples only at both ends, with straight lines in between. The
    outcome is STEADY_SLIDING (the record ends when the motion has settled), JUDDERS, STUCK,
    SEPARATED or CLOSED_BY_SLEEVE.
    """

    command: ClassVar[str] = "stick-slip"
    speed_of_mass: Array = column("m/s", "speed of the moving mass and of the sliding sheets")
    sliding: Array = column("1", "1 while the sheets slide, 0 while they stick")
    work: Array = column("J", "work done by the crosshead")
    dissipated_energy: Array = column("J", "energy turned into heat")
    stored_energy: Array = column("J", "energy of spring, enclosure and moving mass")
    events: Events
    vacuum: float
    speed: float
    mass: float
    stiffness: float
    damping: float
    stribeck: Stribeck

    def conditions(self) -> dict[str, str]:
        """Return vacuum, speed, mass, spring, damper and friction in SI."""
        curve = self.stribeck
        return {
            **header_values(
                self, vacuum="Pa", speed="m/s", mass="kg", stiffness="N/m", damping="N s/m"
            ),
            "static friction": f"{curve.static!r}",
            "kinetic friction": f"{curve.kinetic!r}",
            "Stribeck speed": f"{curve.speed!r} m/s",
            "Stribeck exponent": f"{curve.exponent!r}",
            "viscous growth": f"{curve.viscous!r} s/m",
        }

    def freeze_friction(self, slip: Any) -> Slide:
        """Return this slide with constant friction, as at a slip [m]; slips broadcast."""
        inputs: dict[str, Any] = {name: getattr(self, name) for name in _INPUTS}
        return make_slide(self.brake.brake, slip=slip, frozen=True, **inputs)

    frozen = freeze_friction  # former name


_INPUTS = ("vacuum", "speed", "mass", "stiffness", "damping", "stribeck")


def moving_mass(brake: Brake) -> float:
    """Return half of the brake's mass [kg], one cap and its sheets without the rig (assumed)."""
    return mass(brake) / 2


def series_stiffness(brake: Brake, mount: float | None = None) -> float:
    """Return the spring [N/m]: as measured in the rig, or that of a mount and the stuck sheets.

    The measured stiffness contains the paper's rig, so a given mount replaces it.
    """
    if mount is None:
        return float(working_stiffness(brake))
    return 1 / (1 / float(stiffness_before_slip(brake)) + 1 / mount)


def make_slide(
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
    """Return the brake as a mass on a spring; `frozen` fixes friction at its value at `slip` [m].

    Entries broadcast. The crosshead does not stop and the run has no end yet; set `ramp` and `end`.
    """
    brake = require_linear(brake, "stick–slip")
    curve = stribeck or film_curve(brake)
    c = np.asarray(friction_per_contact(np.asarray(vacuum, float), brake))
    c = c * curve.kinetic / brake.film.kinetic
    enclosure, overlap = enclosure_law(np.asarray(vacuum, float), brake), brake.sheets.overlap
    base = np.asarray(enclosure.force(np.asarray(slip, float))) if frozen else 0.0
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
        base=base,
        enclosure=None if frozen else enclosure,
        overlap=np.inf if frozen else overlap,
        start=0.0 if frozen else slip,
        events=np.inf,
        tolerance=TOLERANCE,
        paced_brake=brake if depends_on_speed(brake) else None,
    )


class Bounds(NamedTuple):
    """Friction at one slip."""

    static: Any
    """Largest force of the brake at rest [N], including the enclosure."""
    kinetic: Any
    """Kinetic force [N]."""


def force_bounds(run: Slide, speed: Any = None) -> Bounds:
    """Return static and kinetic force [N] of a slide with constant friction.

    With a speed law, the kinetic force is that at `speed` [m/s], by default the crosshead's.
    """
    kinetic = run.level + np.asarray(run.base)
    if run.paced_brake is not None:
        pace = run.speed if speed is None else speed
        kinetic = run.level * brake_growth(pace, run.paced_brake) + np.asarray(run.base)
    return Bounds(run.level * (1 + np.asarray(run.rise)) + run.base, kinetic)


def _check_hold(hold: float, step: float) -> None:
    if not hold / step <= 0.9 * SAMPLES:
        raise QuantityError(
            f"step: {step:g} s divides the hold of {hold:g} s into too many steps "
            f"({hold / step:.0f}); use longer steps, which give the same result"
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
    in parallel with it. Without `travel` the pull is long enough for a dozen events. The
    crosshead then rests for `hold` [s]. `step` [s] limits the length of steps; the result does not
    depend on it while the sheets stick. Raises FitError if the run would take too many steps.
    """
    brake = file.brake
    evolve(VACUUM, hi=brake.site.atmosphere).check(vacuum, "vacuum")
    inputs = {"speed": speed, "mass": mass, "mount_stiffness": mount_stiffness, "travel": travel}
    options = {"damping": damping, "hold": hold, "step": None if step == np.inf else step}
    check_inputs({**inputs, **options}, LIMITS)
    _check_hold(hold, step)
    motion: dict[str, Any] = {
        "vacuum": vacuum,
        "speed": speed,
        "mass": moving_mass(brake) if mass is None else mass,
        "stiffness": series_stiffness(brake, mount_stiffness),
        "damping": damping,
        "stribeck": stribeck or film_curve(brake),
    }
    setup = make_slide(brake, slip=slip, **motion)
    travel = _crosshead_travel(setup, brake, speed, slip) if travel is None else travel
    setup = setup._replace(ramp=travel / speed, end=travel / speed + hold, step=step)
    state = slide(setup, events=EVENTS, samples=SAMPLES, max_actions=4 * SAMPLES)
    if int(state.reason) == TOO_LONG:
        raise FitError(
            f"speed: at {show(speed, 'm/s')} the motion over {show(travel, 'm')} takes more than "
            f"{SAMPLES} steps; shorten the travel, raise the damping or, if the Stribeck speed is "
            "very small, set it to 0"
        )
    table = np.asarray(state.table)[: min(int(state.count), EVENTS)]
    rows = np.asarray(state.trace)[: int(state.written)]
    time, crosshead, force, slips, pace, work, heat, sliding = rows.T
    # read all rows, whose number is constant, so that this compiles once
    energy = np.asarray(enclosure_law(vacuum, brake).stored_energy(state.trace[:, 3]))
    energy = energy[: len(rows)]
    spring_held = setup.spring * np.maximum(crosshead - slips, 0.0) ** 2 / 2
    return StickSlipRecord(
        time=time,
        elongation=crosshead - slip,
        force=force,
        slip=slips,
        speed_of_mass=pace,
        sliding=sliding,
        work=work,
        # the enclosure's friction is part of the resistance, but half of its work is stored
        dissipated_energy=heat - (energy - energy[0]),
        stored_energy=spring_held + setup.mass * pace**2 / 2 + energy,
        events=Events(*table.T),
        **motion,
        outcome=_slide_outcome(state, rows, table),
        brake=file,
        warnings=tuple(file.warnings()),
    )


def _crosshead_travel(run: Slide, brake: Brake, speed: float, slip: float) -> float:
    """Return the crosshead travel [m] for TEETH events, or for the oscillations of a fast pull."""
    static = float(run.level - run.fall * slip) * (1 + float(run.rise))
    kinetic = float(run.level - run.fall * slip)
    # without friction there are no teeth
    tooth = float(slow_saw(static, kinetic, run.spring, run.mass, speed).slip) if kinetic else 0.0
    swings = 30 * 2 * np.pi * np.sqrt(run.mass / run.spring) * speed
    enclosure = 0.0 if run.enclosure is None else float(run.enclosure.force(slip))
    onset = (static + enclosure) / float(run.spring)
    max_travel = onset + max(brake.sheets.usable_travel - slip, 0.0)
    return float(min(onset + max(TEETH * tooth, swings), max_travel))


def _slide_outcome(state: Any, rows: Array, table: Array) -> Outcome:
    if int(state.reason) in ENDS:
        return ENDS[int(state.reason)]
    if not rows[:, 7].any():
        return Outcome.STUCK
    # after the sheets stick again, the next slip starts like the one before
    return Outcome.JUDDERS if len(table) else Outcome.STEADY_SLIDING


class Tooth(NamedTuple):
    """Stick–slip at one slip; arrays of the broadcast shape."""

    judders: Array
    amplitude: Array
    """Half the peak-to-peak force [N]; 0 if the brake slides steadily."""
    force_high: Array
    force_low: Array
    slip: Array
    """Slip [m]."""
    period: Array
    """Period [s]."""


def single_event(run: Slide, swings: int = 300) -> Tooth:
    """Return one event of a slide with constant friction, or none; entries of `run` may be arrays.

    A mass that sticks again starts its next slip like this one, so one event describes all. Without
    an event, the motion is simulated for `swings` natural periods.
    """
    static, _ = force_bounds(run)
    omega = np.sqrt(np.asarray(run.spring) / run.mass)
    end = np.asarray(static) / (np.asarray(run.spring) * run.speed) + swings * 2 * np.pi / omega
    run = run._replace(ramp=np.inf, end=end, events=1.0, tolerance=MAP_TOLERANCE)
    state = slide(run, events=1, samples=1, max_actions=MAP_ACTIONS)
    row = np.asarray(state.table)[..., 0, :]
    judders = np.asarray(state.count) > 0
    high, low, slip = (np.where(judders, row[..., i], 0.0) for i in (3, 4, 5))
    swing = np.where(judders, (high - low) / 2, 0.0)
    period = np.where(judders, slip / run.speed, np.nan)
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
    """Return stick–slip at speeds [m/s] and vacuums [Pa], which broadcast; friction at `slip`.

    `mass` [kg], `stiffness` [N/m] and `damping` [N s/m] may be arrays that broadcast with them.
    """
    speeds, vacuums = np.broadcast_arrays(speeds, vacuums)
    run = make_slide(
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
    return single_event(run, swings)


def find_critical_speed(run: Slide) -> float:
    """Return the speed [m/s] above which stick–slip from rest decays, with constant friction.

    It is a closed form for the jump law while the spring stays taut; otherwise, simulations find it
    to within 0.1 %. It is infinite without damping.
    """
    static, kinetic = (float(v) for v in force_bounds(run, 0.0))
    drag = float(run.damping) + float(run.level) * float(run.viscous)
    if static <= kinetic:
        return 0.0
    if not drag and run.paced_brake is None:
        return float("inf")
    spring, mass = float(run.spring), float(run.mass)
    scale = (static - kinetic) / np.sqrt(spring * mass)
    low, high = 1e-9 * scale, 1e3 * scale
    if float(run.stribeck) == 0.0 and float(run.viscous) == 0.0 and run.paced_brake is None:
        speed = float(critical_speed(static, kinetic, spring, mass, run.damping))
        if speed < low or not single_event(run._replace(speed=1.001 * speed)).judders:
            return speed
        low = speed
    for _ in range(8):
        speeds = np.geomspace(low, high, 24)
        judders = single_event(run._replace(speed=speeds)).judders
        if not judders.any():
            return 0.0
        last = int(np.flatnonzero(judders)[-1])
        low, high = float(speeds[last]), float(speeds[min(last + 1, len(speeds) - 1)])
        if high <= low * 1.001:
            break
    return low
