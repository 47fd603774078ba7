"""`regulate` and `follow`: a regulator on a line, and a brake whose force follows a profile."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.control.closed_loop import simulate
from layerjam.control.follow import bode, rehabilitation
from layerjam.control.follow import follow as run
from layerjam.control.plant import plant_of
from layerjam.control.settings import Regulator, detection_times
from layerjam.errors import FileError, QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile
from layerjam.fluid.line import Sensor
from layerjam.identify.logs.table import TIME, Want, read_log
from layerjam.units import Meaning, meaning_of, show
from layerjam.verbs.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.verbs.vacuum_line import FLUIDS, AnyLine, line_at, target_of

DURATION = Meaning("s", "time to simulate", open_lo=True, hi=1e5)
SPEED = Meaning("m/s", "speed of the slip", hi=100)
MODEL = Meaning("1", "factor of the true brake's friction over the known one", lo=0.1, hi=10)
SLIP_NOISE = Meaning("m", "standard deviation of a measured slip", hi=0.1)
FORCE = Want("force", "N", r"\b(force|load|kraft|f)\b", "'N' or 'kN'")
SLIP = Want("slip", "m", r"\b(slip|travel|weg|x|s)\b", "'mm' or 'm'", optional=True)
UNITS = {
    "target": "Pa", "rise_time": "s", "overshoot": "Pa", "steady_error": "Pa", "ripple": "Pa",
    "pump_on": "s", "fault_time": "s", "reachable": "Pa", "gain": "1/Pa", "integral_time": "s",
    "time_constant": "s", "duration": "s", "sample_time": "s", "rms_error": "N",
    "greatest_error": "N", "greatest_vacuum": "Pa", "bandwidth": "Hz",
}  # fmt: skip
PROFILES = ("step", "sine", "rehabilitation")
BODE = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Frequencies tried [Hz]."""


def regulator_of(
    file: LineFile, at: float, *, safe_state: str, kind: str, fluid: str,
    sample_time: Quantity | None, sensor_range: Quantity | None, noise: Quantity | None,
    reversible: bool, least_run: Quantity | None,
) -> tuple[Regulator, list[str]]:  # fmt: skip
    """A regulator for a line, its leak and valve made linear at a vacuum [Pa]; what is assumed."""
    if fluid not in FLUIDS:
        raise UnknownNameError("fluid", fluid, FLUIDS)
    said = list(file.warnings())
    plant = plant_of(file.line, vacuum=at, water=fluid == "water")
    sensor = file.line.sensor
    if sensor is None and sensor_range is None:
        raise QuantityError(
            f"sensor: {file.name} has none; give --sensor-range, the greatest vacuum it shows"
        )
    shown = sensor or Sensor(range=1.0)
    if sensor_range is not None:
        shown = replace(shown, range=si(sensor_range, meaning_of(Sensor, "range"), "sensor range"))
    if noise is not None:
        shown = replace(shown, noise=si(noise, meaning_of(Sensor, "noise"), "noise"))
    if not plant.vent or file.line.valve is None:
        said.append(
            f"{file.name} has no valve: venting stands for its pumps run backwards, and a fault of "
            "the pump leaves it without release"
        )
    more: dict[str, Any] = {}
    if sample_time is not None:
        more["sample_time"] = si(sample_time, meaning_of(Regulator, "sample_time"), "sample time")
    if least_run is not None:
        shortest = si(least_run, meaning_of(Regulator, "minimum_on"), "least run")
        more |= {"minimum_on": shortest, "minimum_off": shortest}
    # without a valve there is no other way down
    backwards = reversible or (file.line.valve is None and plant.backwards > 0)
    made = Regulator(
        plant=plant, sensor=shown, kind=kind, safe_state=safe_state, reversible=backwards,
        tuned_at=at, **more,
    )  # fmt: skip
    return made, said


def regulate(
    line: AnyLine,
    *,
    target: Quantity,
    safe_state: str = "",
    kind: str = "pi",
    fluid: str = "air",
    duration: Quantity | None = None,
    sample_time: Quantity | None = None,
    sensor_range: Quantity | None = None,
    noise: Quantity | None = None,
    reversible: bool = False,
    least_run: Quantity | None = None,
    atmosphere: Quantity | None = None,
    seed: int = 0,
) -> Answer:
    """Bring a line to a vacuum and hold it there, in closed loop with a noisy sensor.

    `kind` is "bang-bang", "pi" or "scheduled"; `safe_state`, "release" or "hold", is where a fault
    ends and must be declared; `least_run` is the pump's shortest run and rest. Times are those of
    the true vacuum, not of the reading. `detection` has the worst time [s] until each fault is said
    at this vacuum (None: never). `record` is (Regulator, ClosedLoop).
    """
    file = line_at(line, atmosphere)
    wanted = target_of(target, file.line)
    made, said = regulator_of(
        file, wanted, safe_state=safe_state, kind=kind, fluid=fluid, sample_time=sample_time,
        sensor_range=sensor_range, noise=noise, reversible=reversible,
        least_run=least_run,
    )  # fmt: skip
    constant = 1 / (made.plant.rate + made.plant.leak)
    length = 12 * constant if duration is None else si(duration, DURATION, "duration")
    loop = simulate(made, [(length, wanted)], seed=seed)
    gains = made.gains()
    values = {
        "target": wanted,
        "kind": kind,
        "safe_state": safe_state,
        "outcome": loop.outcome,
        "rise_time": _finite(loop.rise_time),
        "overshoot": loop.overshoot,
        "steady_error": loop.steady_error,
        "ripple": loop.ripple,
        "pump_switches": loop.pump_switches,
        "vent_switches": loop.vent_switches,
        "pump_on": loop.pump_on,
        "fault_time": _finite(loop.fault_time),
        "reachable": made.plant.reach,
        "time_constant": constant,
        "gain": None if kind == "bang-bang" else gains.gain,
        "integral_time": None if kind == "bang-bang" else gains.integral_time,
        "sample_time": made.sample_time,
        "duration": length,
        "detection": {k: _finite(v) for k, v in detection_times(made, wanted).items()},
    }
    return Answer(
        values=values, units={k: v for k, v in UNITS.items() if k in values}, warnings=said,
        record=(made, loop),
    )  # fmt: skip


def follow(
    line: AnyLine,
    brake: AnyBrake,
    *,
    profile: str | Path,
    safe_state: str = "",
    low: Quantity | None = None,
    high: Quantity | None = None,
    period: Quantity | None = None,
    duration: Quantity | None = None,
    speed: Quantity | None = None,
    kind: str = "scheduled",
    fluid: str = "air",
    sample_time: Quantity | None = None,
    sensor_range: Quantity | None = None,
    noise: Quantity | None = None,
    slip_noise: Quantity | None = None,
    model_error: Quantity | None = None,
    reversible: bool = False,
    least_run: Quantity | None = None,
    atmosphere: Quantity | None = None,
    seed: int = 0,
) -> Answer:
    """A brake's force made to follow a profile while it slides on.

    `profile` is "step", "sine" or "rehabilitation" between the forces `low` and `high` with a
    `period`, while the brake slips at `speed`; or a file with time, force and slip. `model_error`
    is the true friction over the known one. `possible` is the share of the time in which brake and
    line can do what is asked, `reasons` says why not. `bandwidth` [Hz] is where a sine of half the
    swing comes out at 71 %. `record` is (Following, Bode).
    """
    file, device = line_at(line, atmosphere), brake_at(brake, atmosphere)
    made, said = regulator_of(
        file, 0.6 * file.line.site.atmosphere, safe_state=safe_state, kind=kind, fluid=fluid,
        sample_time=sample_time, sensor_range=sensor_range, noise=noise, reversible=reversible,
        least_run=least_run,
    )  # fmt: skip
    given = (low, high, period, duration, speed)
    names = ("low", "high", "period", "duration", "speed")
    if str(profile) in PROFILES:
        missing = [n for n, v in zip(names, given, strict=True) if v is None]
        if missing:
            raise QuantityError(f"{', '.join(missing)}: missing; the profile {profile} needs them")
        wanted, slip = _drawn(str(profile), made.sample_time, *given)  # type: ignore[arg-type]
    else:
        if given != (None,) * 5:
            raise QuantityError(f"{', '.join(names)}: they go only with {' or '.join(PROFILES)}")
        wanted, slip = _from_file(profile, made.sample_time)
    factor = 1.0 if model_error is None else si(model_error, MODEL, "model error")
    true = replace(device.brake, scale_factor=device.brake.scale_factor * factor)
    off = 0.0 if slip_noise is None else si(slip_noise, SLIP_NOISE, "slip noise")
    done = run(made, device.brake, wanted, slip, brake=true, slip_noise=off, seed=seed)
    half = float(np.ptp(wanted)) / 2
    middle = float(wanted.min()) + half
    swept = None
    if half > 0:
        fast = [f for f in BODE if f * made.sample_time < 0.05]
        swept = bode(
            made, device.brake, slip=float(np.median(slip)), mean=middle, amplitude=half,
            frequencies=fast, brake=true, seed=seed,
        )  # fmt: skip
    values = {
        "rms_error": done.rms,
        "greatest_error": float(np.abs(done.error).max()),
        "possible": float(done.possible.mean()),
        "reasons": list(done.reasons),
        "feasible": bool(done.possible.all()),
        "outcome": done.loop.outcome,
        "greatest_vacuum": float(done.loop.vacuum.max()),
        "pump_switches": done.loop.pump_switches,
        "vent_switches": done.loop.vent_switches,
        "bandwidth": None if swept is None else swept.bandwidth,
        "bode": None if swept is None else [
            {"frequency": float(f), "magnitude": float(m), "phase": float(p)}
            for f, m, p in zip(swept.frequency, swept.magnitude, swept.phase, strict=True)
        ],
        "sample_time": made.sample_time,
    }  # fmt: skip
    return Answer(
        values=values, units={k: v for k, v in UNITS.items() if k in values},
        warnings=[*device.warnings(), *said], record=(done, swept),
    )  # fmt: skip


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _drawn(
    profile: str, dt: float, low: Quantity, high: Quantity, period: Quantity, duration: Quantity,
    speed: Quantity,
) -> tuple[Any, Any]:  # fmt: skip
    """Wanted force [N] and slip [m] at the samples."""
    force = Meaning("N", "force")
    least, most = si(low, force, "low"), si(high, force, "high")
    if most <= least:
        raise QuantityError(f"high: {show(most, 'N')} is not above low, {show(least, 'N')}")
    turn, length = si(period, DURATION, "period"), si(duration, DURATION, "duration")
    time = np.arange(round(length / dt)) * dt
    if len(time) < 2:
        raise QuantityError(f"duration: {show(length, 's')} is less than two samples")
    slip = si(speed, SPEED, "speed") * time
    if profile == "rehabilitation":
        return rehabilitation(time, low=least, high=most, period=turn), slip
    wave = np.sin(2 * np.pi * time / turn)
    shape = (1 + wave) / 2 if profile == "sine" else (wave < 0).astype(float)
    return least + (most - least) * shape, slip


def _from_file(path: str | Path, dt: float) -> tuple[Any, Any]:
    """The same from a file with time, force and slip, joined by straight lines."""
    log = read_log(path, (TIME, FORCE, SLIP))
    if "slip" not in log:
        raise FileError(path, "has no column of slip; the force depends on it")
    time = log["time"] - log["time"][0]
    if len(time) < 2 or (np.diff(time) <= 0).any():
        raise FileError(path, "its time must rise from row to row")
    at = np.arange(round(float(time[-1]) / dt) + 1) * dt
    return np.interp(at, time, log["force"]), np.interp(at, time, log["slip"])
