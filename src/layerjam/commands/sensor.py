"""What goes with a drop: what an accelerometer shows of it, and how warm the sheets get."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.mechanics.heat import stops_per_minute, temperature_rise, temperature_rise_of_sheets
from layerjam.simulate.accelerometer import (
    CLASSES,
    Accelerometer,
    Signal,
    named,
    seen,
    specific_force,
)
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.rope_alone import BareDrop
from layerjam.units import QuantitySpec, show, spec_of

LEAST_SAMPLES = 10
"""Samples in a pull below which its peak may fall between them."""
ALLOWED_RISE = QuantitySpec(
    "K", "warmth the sheets may reach over the air around the brake", lo=0.01, hi=1000
)
FILM_COEFFICIENT = QuantitySpec(
    "W/(m^2 K)", "heat given off by the sleeve's outer surface", lo=0.01, hi=1e5
)
DEFAULT_RISE = 20.0
"""Air of 23 °C to 43 °C, the burn threshold for contact of 8 h and longer (ISO 13732-1)."""
DEFAULT_FILM_COEFFICIENT = 10.0
"""Still air, assumed: free convection, 2 to 25 W/(m^2 K) in gases (Incropera, table 1.1), and
radiation, 4 ε σ T³ = 5.8 at 300 K and ε = 0.95."""
READING_UNITS = {
    "measured_peak": "m/s^2", "measured_peak_g": "1", "measured_peak_time": "s",
    "peak_loss": "1", "measured_rate": "Hz",
}  # fmt: skip
HEAT_UNITS = {
    "temperature_rise": "K", "temperature_rise_of_sheets": "K", "stops_per_minute": "1/min",
    "allowed_rise": "K", "film_coefficient": "W/(m^2 K)",
}  # fmt: skip


def channel_class(text: str | None) -> int | None:
    """``"cfc180"`` as 180, ``"none"`` or None as None; QuantityError for another filter."""
    if text is None or text.lower() == "none":
        return None
    match = re.fullmatch(r"(?:cfc)?[ -]?([0-9]{1,6})", text.strip().lower())
    if match is None or int(match.group(1)) not in CLASSES:
        known = ", ".join(f"cfc{c}" for c in CLASSES)
        raise QuantityError(f"filter: '{text[:40]}' is not known; there are none, {known}")
    return int(match.group(1))


def sensor_of(
    accelerometer: str | Accelerometer, low_pass: Quantity | None, sampling: Quantity | None
) -> Accelerometer:
    """A named sensor with another low-pass or rate where they are given.

    A low-pass of its own makes the sensor's 2-pole Butterworth one unless it has one already.
    """
    sensor = named(accelerometer) if isinstance(accelerometer, str) else accelerometer
    if low_pass is not None:
        kind = "butterworth" if sensor.bandwidth is None else sensor.kind
        cutoff = si(low_pass, spec_of(Accelerometer, "bandwidth"), "low-pass")
        sensor = replace(sensor, bandwidth=cutoff, kind=kind)
    if sampling is not None:
        rate = si(sampling, spec_of(Accelerometer, "sampling"), "sampling")
        sensor = replace(sensor, sampling=rate)
    return sensor


def reading(
    signal: Signal,
    *,
    accelerometer: str | Accelerometer = "ideal",
    filter: str | None = None,
    low_pass: Quantity | None = None,
    sampling: Quantity | None = None,
    gravity: float | None = None,
) -> Answer:
    """What an accelerometer shows of a stop: ideal, adxl193 or a sensor of your own.

    `signal` is the record of a drop or (time [s], specific force [m/s^2]). `filter` is none,
    cfc60, cfc180, cfc600 or cfc1000 (SAE J211-1); `low_pass` and `sampling` replace the sensor's.
    `gravity` [m/s^2] is what `measured_peak_g` counts in, by default the site's (9.80665 without a
    record), as `peak_g` of `drop`. `record` is the Reading. Raises QuantityError and
    UnknownNameError for what is not known, out of bounds or sampled too slowly for the class.
    """
    sensor = sensor_of(accelerometer, low_pass, sampling)
    made = seen(signal, sensor, channel_class(filter))
    sparse = _sparse(signal, sensor)
    if gravity is None:
        gravity = signal.brake.brake.site.gravity if isinstance(signal, DropRecord) else 9.80665
    return Answer(
        values={
            "measured_peak": made.peak,
            "measured_peak_g": made.peak / gravity if gravity else None,
            "measured_peak_time": made.time_of_peak,
            "peak_loss": made.loss,
            "measured_rate": made.rate if made.rate != float("inf") else None,
            "accelerometer": sensor.name,
            "filter": "none" if made.cfc is None else f"cfc{made.cfc}",
            "saturated": made.saturated,
        },
        units=READING_UNITS,
        warnings=[*made.warnings, *sparse],
        record=made,
    )


def _sparse(signal: Signal, sensor: Accelerometer) -> list[str]:
    """What to say of a rate that takes fewer than ten samples while the brake or rope pulls."""
    if sensor.sampling is None:
        return []
    time, value = specific_force(signal) if isinstance(signal, DropRecord) else signal[:2]
    pulls = np.flatnonzero(np.asarray(value) != 0)
    if not len(pulls):
        return []
    span = float(np.asarray(time)[pulls[-1]] - np.asarray(time)[pulls[0]])
    if span * sensor.sampling >= LEAST_SAMPLES:
        return []
    return [
        f"sampled at {show(sensor.sampling, 'Hz')} the pull of {show(span, 's')} has "
        f"{span * sensor.sampling:.2g} samples: the peak falls between them"
    ]


def heating(
    heat: Quantity,
    file: BrakeFile,
    *,
    allowed_rise: Quantity | None = None,
    film_coefficient: Quantity | None = None,
) -> Answer:
    """How warm a stop's heat makes the sheets, and how many such stops a minute they bear.

    `temperature_rise` is the mean over the rubbing part, `temperature_rise_of_sheets` over the
    whole sheets. Defaults, both assumed and to be replaced by your own: a rise of 20 K, and
    10 W/(m^2 K) from the sleeve to still air. Wear is not modelled. Null where the film's specific
    heat is not known or there was no heat.
    """
    if isinstance(allowed_rise, str) and re.search(r"°|deg|[CF]\s*$", allowed_rise):
        raise QuantityError(
            f"allowed rise: '{allowed_rise[:40]}' is a temperature; a rise is given in K"
        )
    rise = DEFAULT_RISE if allowed_rise is None else si(allowed_rise, ALLOWED_RISE, "allowed rise")
    film = DEFAULT_FILM_COEFFICIENT
    if film_coefficient is not None:
        film = si(film_coefficient, FILM_COEFFICIENT, "film coefficient")
    joule = si(heat, QuantitySpec("J", "heat of a stop"), "heat")
    brake, warnings = file.brake, []
    known = brake.film.specific_heat is not None
    if not known:
        warnings.append(f"{file.name} does not say the film's specific heat: no temperature rise")
    return Answer(
        values={
            "temperature_rise": float(temperature_rise(joule, brake)) if known else None,
            "temperature_rise_of_sheets": (
                float(temperature_rise_of_sheets(joule, brake)) if known else None
            ),
            "stops_per_minute": (
                float(stops_per_minute(joule, rise, film, brake)) if known and joule > 0 else None
            ),
            "allowed_rise": rise,
            "film_coefficient": film,
        },
        units=HEAT_UNITS,
        warnings=warnings,
    )


def observed(
    stop: Answer,
    *,
    accelerometer: str | Accelerometer = "ideal",
    filter: str | None = None,
    low_pass: Quantity | None = None,
    sampling: Quantity | None = None,
    allowed_rise: Quantity | None = None,
    film_coefficient: Quantity | None = None,
) -> Answer:
    """The answer of `drop` with what is measured and felt of it: `reading` and `heating`.

    The readings are None where there is no stop, the warmth also where there is no brake.
    """
    sensor_of(accelerometer, low_pass, sampling), channel_class(filter)
    asked = (accelerometer, filter, low_pass, sampling)
    if isinstance(stop.record, BareDrop):
        shown = reading(
            (stop.record.time, stop.record.acceleration), accelerometer=accelerometer,
            filter=filter, low_pass=low_pass, sampling=sampling, gravity=stop.record.gravity,
        )  # fmt: skip
        bounces = "the reading holds the first pull of the rope; bounces after it are left out"
        said = [bounces] if asked != ("ideal", None, None, None) else []
        return replace(
            stop,
            values={**stop.values, **shown.values, **dict.fromkeys(HEAT_UNITS)},
            units={**stop.units, **shown.units, **HEAT_UNITS},
            warnings=[*stop.warnings, *shown.warnings, *said],
        )
    if stop.record is None or not stop.values["feasible"]:
        nothing = dict.fromkeys(
            (*READING_UNITS, "accelerometer", "filter", "saturated", *HEAT_UNITS)
        )
        return replace(stop, values={**stop.values, **nothing})
    record = stop.record
    if stop.values.get("outcome_at_end"):
        # what is held behind the end is how the record ended, not how the stop did
        record = replace(record, outcome=Outcome(stop.values["outcome_at_end"]))
    shown = reading(
        record, accelerometer=accelerometer, filter=filter, low_pass=low_pass,
        sampling=sampling,
    )  # fmt: skip
    felt = heating(
        float(stop.values["dissipated_energy"]), stop.record.brake, allowed_rise=allowed_rise,
        film_coefficient=film_coefficient,
    )  # fmt: skip
    return replace(
        stop,
        values={**stop.values, **shown.values, **felt.values},
        units={**stop.units, **shown.units, **felt.units},
        warnings=[*stop.warnings, *shown.warnings, *felt.warnings],
    )
