"""`follow`: a brake whose force follows a profile while it slides on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.commands.regulate import DURATION, SEED, regulator_of
from layerjam.commands.vacuum_line import AnyLine, line_at
from layerjam.control.follow import bode, rehabilitation
from layerjam.control.follow import follow as run
from layerjam.errors import FileError, QuantityError
from layerjam.measure.log import TIME, read_log
from layerjam.measure.readers.columns import Want
from layerjam.units import QuantitySpec, show

SPEED = QuantitySpec("m/s", "speed of the slip", hi=100)
MODEL = QuantitySpec("1", "factor of the true brake's friction over the known one", lo=0.1, hi=10)
SLIP_NOISE = QuantitySpec("m", "standard deviation of a measured slip", hi=0.1)
FORCE = Want("force", "N", r"\b(force|load|kraft|f)\b", ("N", "kN"))
SLIP = Want("slip", "m", r"\b(slip|travel|weg|x|s)\b", ("mm", "m"), optional=True)
UNITS = {
    "rms_error": "N", "greatest_error": "N", "greatest_vacuum": "Pa", "bandwidth": "Hz",
    "sample_time": "s",
}  # fmt: skip
PROFILES = ("step", "sine", "rehabilitation")
BODE = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Frequencies tried [Hz]."""


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
    SEED.check(float(seed), "seed")
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
        values=values, units=UNITS,
        warnings=[*device.warnings(), *said], record=(done, swept),
    )  # fmt: skip


def _drawn(
    profile: str, dt: float, low: Quantity, high: Quantity, period: Quantity, duration: Quantity,
    speed: Quantity,
) -> tuple[Any, Any]:  # fmt: skip
    """Wanted force [N] and slip [m] at the samples."""
    force = QuantitySpec("N", "force")
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
