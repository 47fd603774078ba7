"""`judder`: does the brake stick and slip, how much, and what would stop it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from layerjam.commands.answer import (
    SPEED,
    TRAVEL,
    Answer,
    AnyBrake,
    Quantity,
    brake_at,
    si,
    slip_of,
    vacuum_of,
)
from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.mechanics.stick_slip.laws import (
    Stribeck,
    of_film,
    stable_speed,
    stiffness_without_judder,
)
from layerjam.mechanics.stick_slip.slide_step import Slide
from layerjam.simulate.record import Outcome
from layerjam.simulate.stick_slip import (
    Bounds,
    JudderRecord,
    bounds_at,
    critical_speed_of,
    moving_mass,
    series_stiffness,
    slide_of,
)
from layerjam.simulate.stick_slip import judder as run_judder
from layerjam.units import QuantitySpec, show, spec_of

MASS = QuantitySpec("kg", "moving mass", lo=1e-6, hi=1e4)
MOUNT = QuantitySpec("N/m", "stiffness of the mount", lo=100, hi=1e9)
DAMPING = QuantitySpec("N s/m", "damping beside the spring", hi=1e6)
STATIC = QuantitySpec("1", "static friction", lo=1e-4, hi=10)
UNITS = {
    "amplitude": "N", "relative_amplitude": "1", "force_high": "N", "force_low": "N",
    "slip_per_event": "m", "period": "s", "events": "1", "static_force": "N",
    "kinetic_force": "N", "critical_speed": "m/s", "stable_speed": "m/s",
    "stiffness_needed": "N/m", "mass": "kg", "stiffness": "N/m", "damping_ratio": "1",
}  # fmt: skip


def judder(
    brake: AnyBrake,
    *,
    vacuum: Quantity,
    speed: Quantity,
    mass: Quantity | None = None,
    mount_stiffness: Quantity | None = None,
    damping: Quantity = 0.0,
    stribeck_speed: Quantity = 0.0,
    static: Quantity | None = None,
    slip: Quantity = 0.0,
    travel: Quantity | None = None,
    atmosphere: Quantity | None = None,
) -> Answer:
    """Pull a brake at one speed and see whether it judders, from rest at `slip`.

    Amplitude and forces are those of the last event of the run; `travel` (of the crosshead) sets
    its length, by default a dozen events. `critical_speed`, `stable_speed` and `stiffness_needed`
    hold friction at its value at `slip`. `stribeck_speed` 0 means that static friction is lost at
    once. `record` is the JudderRecord. Raises QuantityError for a bad value, FitError for a run
    of too many steps.
    """
    file = brake_at(brake, atmosphere)
    device = file.brake
    pressure = vacuum_of(vacuum, device)
    pull = si(speed, SPEED, "speed")
    curve = _curve(device, stribeck_speed, static)
    weighs = moving_mass(device) if mass is None else si(mass, MASS, "mass")
    mount = None if mount_stiffness is None else si(mount_stiffness, MOUNT, "mount stiffness")
    drag = si(damping, DAMPING, "damping")
    start, warnings = slip_of(slip, device)
    if start >= device.sheets.overlap:
        raise QuantityError(f"slip: {show(start, 'm')} leaves no overlap to pull on")
    way = None if travel is None else _way(si(travel, TRAVEL, "travel"), start, device)
    record = run_judder(
        file, vacuum=pressure, speed=pull, mass=weighs, mount_stiffness=mount, damping=drag,
        stribeck=curve, slip=start, travel=way,
    )  # fmt: skip
    spring = series_stiffness(device, mount)
    frozen = slide_of(
        device, vacuum=pressure, speed=pull, mass=weighs, stiffness=spring, damping=drag,
        stribeck=curve, slip=start, frozen=True,
    )  # fmt: skip
    bounds = Bounds(*(float(v) for v in bounds_at(frozen)))
    ratio = drag / (2 * math.sqrt(spring * weighs))
    values = {
        "outcome": str(record.outcome),
        **_swing(record),
        "events": len(record.events),
        "static_force": bounds.static,
        "kinetic_force": bounds.kinetic,
        **_limits(frozen, bounds, pull, ratio),
        "mass": weighs,
        "stiffness": spring,
        "damping_ratio": ratio,
    }
    if record.outcome is Outcome.STEADY_SLIDING and len(record.events):
        count = len(record.events)
        warnings.append(
            f"it stuck {count} time{'s' if count > 1 else ''} before it settled: friction falls "
            "with slip, and the critical speed with it"
        )
    warnings += [*record.warnings, *_notes(device, mass, drag, curve, bounds, static)]
    return Answer(values=values, units=UNITS, warnings=warnings, record=record)


def _curve(brake: Brake, stribeck_speed: Quantity, static: Quantity | None) -> Stribeck:
    pace = si(stribeck_speed, spec_of(Stribeck, "speed"), "stribeck speed")
    curve = of_film(brake, pace)
    if static is None:
        return curve
    bound = si(static, STATIC, "static")
    if bound < curve.kinetic:
        raise QuantityError(
            f"static: {bound:g} is below the film's kinetic friction, {curve.kinetic:g}; static "
            "friction is at least that"
        )
    return replace(curve, static=bound)


def _way(travel: float, slip: float, brake: Brake) -> float:
    room = brake.sheets.overlap - slip
    if travel > room:
        raise QuantityError(
            f"travel: {show(travel, 'm')} from a slip of {show(slip, 'm')} is beyond the overlap "
            f"of {show(brake.sheets.overlap, 'm')}"
        )
    return travel


def _swing(record: JudderRecord) -> dict[str, float | None]:
    """The last event, or the force it settled at."""
    events = record.events
    last = float(record.force[-1])
    out: dict[str, float | None] = dict.fromkeys(
        ("amplitude", "relative_amplitude", "force_high", "force_low", "slip_per_event", "period")
    )
    if record.outcome is Outcome.JUDDERS or (
        record.outcome in (Outcome.SEPARATED, Outcome.CLOSED_BY_SLEEVE) and len(events)
    ):
        high, low = float(events.force_high[-1]), float(events.force_low[-1])
        begun = float(np.interp(events.break_time[-1], record.time, record.slip))
        level = _kinetic_at(record, begun)
        out |= {"amplitude": (high - low) / 2, "force_high": high, "force_low": low}
        out["relative_amplitude"] = (high - low) / 2 / level if level else None
        out["slip_per_event"] = float(events.slip[-1])
        if len(events) > 1:
            out["period"] = float(events.break_time[-1] - events.break_time[-2])
    elif record.outcome is Outcome.STEADY_SLIDING:
        out |= {"amplitude": 0.0, "relative_amplitude": 0.0, "force_high": last, "force_low": last}
    elif record.outcome is Outcome.STUCK:
        out["force_high"] = last
    return out


def _kinetic_at(record: JudderRecord, slip: float) -> float:
    """Kinetic force [N] at a slip [m]."""
    at = slide_of(
        record.brake.brake, vacuum=record.vacuum, speed=record.speed, mass=record.mass,
        stiffness=record.stiffness, stribeck=record.stribeck, slip=slip, frozen=True,
    )  # fmt: skip
    return float(bounds_at(at).kinetic)


def _limits(at: Slide, bounds: Bounds, speed: float, ratio: float) -> dict[str, float | None]:
    """What would stop it: speed and stiffness; None for never."""
    critical = critical_speed_of(at)
    drop = bounds.static - bounds.kinetic
    drag = float(at.damping) + float(at.level) * float(at.viscous)
    # without any damping sliding is never stable, only (jump law) never unstable
    stable = float(stable_speed(drop, at.stribeck, at.exponent, drag)) if drag else math.inf
    needed = math.inf
    if float(at.stribeck) == 0.0:
        needed = float(
            stiffness_without_judder(speed, bounds.static, bounds.kinetic, at.mass, ratio)
        )
    found = {"critical_speed": critical, "stable_speed": stable, "stiffness_needed": needed}
    return {key: value if math.isfinite(value) else None for key, value in found.items()}


def _notes(
    brake: Brake, mass: Quantity | None, drag: float, curve: Stribeck, bounds: Bounds,
    static: Quantity | None,
) -> list[str]:  # fmt: skip
    """What the numbers rest on."""
    out = []
    if mass is None:
        out.append(
            f"moving mass {show(moving_mass(brake), 'kg')}: half of the brake, assumed; what hangs "
            "on it counts too"
        )
    if not drag:
        out.append(
            "no damping was given: judder then dies at no speed; critical speed and stiffness "
            "needed are not known"
        )
    if curve.speed == 0:
        out.append("static friction is taken as lost at once; no Stribeck speed is measured")
    else:
        out.append("the Stribeck speed is an input: none is measured for the catalogue's films")
    if static is None and bounds.static > bounds.kinetic:
        out.append(
            "static friction is that of a friction test; sheets that let go one after another "
            "bear less together (tensile --model stack)"
        )
    return out
