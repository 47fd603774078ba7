"""Additions to a drop: the reading of an accelerometer, and the temperature of the sheets."""

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from layerjam.brake.commands.arguments import parse_options
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.accelerometer import (
    CLASSES,
    Accelerometer,
    Signal,
    find_accelerometer,
    measure_acceleration,
    specific_force,
)
from layerjam.brake.simulate.accelerometer import Reading as Seen
from layerjam.brake.simulate.record import DropRecord
from layerjam.core.command.arguments import check_kind
from layerjam.core.command.declare import Help, Input, options
from layerjam.core.command.results import Judged, Result, fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, get_spec, show
from layerjam.core.verdict import Check, check, judge

if TYPE_CHECKING:
    from layerjam.brake.simulate.rope_alone import BareDrop

LEAST_SAMPLES = 10
"""Number of samples in a pull below which the peak may fall between samples."""
ALLOWED_RISE = QuantitySpec(
    "K",
    "allowed temperature rise of the sheets above the surrounding air",
    lo=0.01,
    hi=1000,
    example="20K",
)
FILM_COEFFICIENT = QuantitySpec(
    "W/(m^2 K)",
    "heat transfer coefficient of the enclosure's outer surface",
    lo=0.01,
    hi=1e5,
    example="'10 W/(m^2 K)'",
)
DEFAULT_RISE = 20.0
"""Default rise: from air of 23 °C to 43 °C, the burn threshold for 8 h of contact (ISO 13732-1)."""
DEFAULT_FILM_COEFFICIENT = 10.0
"""Still air, assumed: free convection, 2 to 25 W/(m^2 K) in gases (Incropera, table 1.1), and
radiation, 4 ε σ T³ = 5.8 at 300 K and ε = 0.95."""
LOW_PASS = evolve(get_spec(Accelerometer, "bandwidth"), example="400Hz")
SAMPLING = evolve(get_spec(Accelerometer, "sampling"), example="10kHz")


def _read_rise(value: float | str, arguments: Mapping[str, Any]) -> float:
    if isinstance(value, str) and re.search(r"°|deg|[CF]\s*$", value):
        raise QuantityError(
            f"allowed rise: '{value[:40]}' is a temperature; give a temperature rise in K"
        )
    return ALLOWED_RISE.si(value, "allowed rise")


@options
class Sensing:
    """Measuring chain of a stop: accelerometer, low-pass, sampling rate, and filter."""

    accelerometer: Annotated[
        str | Accelerometer, Help("Accelerometer on the mass: ideal or adxl193.", metavar="NAME")
    ] = "ideal"
    filter_class: Annotated[
        str | None,
        Help("SAE J211 filter: cfc60, 180, 600, 1000 or none.", metavar="CLASS", option="--filter"),
    ] = None
    low_pass: Annotated[float | None, LOW_PASS, Help("Low-pass filter of the sensor.")] = None
    sampling: Annotated[float | None, SAMPLING, Help("Sampling rate of the accelerometer.")] = None

    def is_plain(self) -> bool:
        """Return whether the reading shows the stop unchanged."""
        return self == Sensing()

    plain = is_plain  # former name


@options
class Warmth:
    """Limits for the temperature rise of the sheets."""

    allowed_rise: Annotated[
        float | None,
        Input("Allowed temperature rise of the sheets, e.g. 20K.", metavar="Q", convert=_read_rise),
    ] = None
    film_coefficient: Annotated[
        float | None, FILM_COEFFICIENT, Help("Heat transfer coefficient to the air.")
    ] = None


@result
class Reading(Judged):
    """Reading of an accelerometer; `record` holds the signal after sensor and filter."""

    record: "Seen | DropRecord | BareDrop | None" = None
    measured_peak: float | None = number("m/s^2", "peak measured by the sensor", default=None)
    measured_peak_g: float | None = number("1", "measured peak, in local g", default=None)
    measured_peak_time: float | None = number("s", "time of the measured peak", default=None)
    peak_loss: float | None = number("1", "fraction of the true peak that is lost", default=None)
    measured_rate: float | None = number("Hz", "sampling rate", default=None)
    accelerometer: str | None = fact("name of the sensor", default=None)
    filter: str | None = fact("filter after the sensor", default=None)
    saturated: bool | None = fact("whether the sensor saturated", default=None)


@result
class Heating(Result):
    """Temperature rise of the sheets by a stop."""

    temperature_rise: float | None = number(
        "K", "mean temperature rise of the rubbing part", default=None
    )
    temperature_rise_of_sheets: float | None = number(
        "K", "mean temperature rise of the whole sheets", default=None
    )
    stops_per_minute: float | None = number(
        "1/min", "maximum stops per minute within the allowed rise", default=None
    )
    allowed_rise: float | None = number("K", "allowed temperature rise", default=None)
    film_coefficient: float | None = number(
        "W/(m^2 K)", "heat transfer from the enclosure to the air", default=None
    )


def parse_channel_class(text: str | None) -> int | None:
    """Return 180 for ``"cfc180"``, None for ``"none"`` or None; raises QuantityError otherwise."""
    if text is None or text.lower() == "none":
        return None
    match = re.fullmatch(r"(?:cfc)?[ -]?([0-9]{1,6})", text.strip().lower())
    if match is None or int(match.group(1)) not in CLASSES:
        names = ", ".join(f"cfc{c}" for c in CLASSES)
        raise QuantityError(f"filter: '{text[:40]}' is unknown; choose none, {names}")
    return int(match.group(1))


def configure_sensor(
    accelerometer: str | Accelerometer, low_pass: float | None, sampling: float | None
) -> Accelerometer:
    """Return a named sensor, with a different low-pass filter or rate, if given.

    A low-pass is a 2-pole Butterworth filter unless the sensor has its own kind.
    """
    sensor = find_accelerometer(accelerometer) if isinstance(accelerometer, str) else accelerometer
    if low_pass is not None:
        kind = "butterworth" if sensor.bandwidth is None else sensor.kind
        sensor = evolve(sensor, bandwidth=low_pass, kind=kind)
    if sampling is not None:
        sensor = evolve(sensor, sampling=sampling)
    return sensor


def reading(
    signal: Signal,
    sensing: Sensing | None = None,
    *,
    gravity: float | None = None,
    accept: Mapping[str, str] | None = None,
    **options: Any,
) -> Reading:
    """Reading of an accelerometer during a stop: ideal, adxl193 or a user-defined sensor.

    `signal` is the record of a drop or (time [s], specific force [m/s^2]); `sensing` or its fields
    by name describe the sensor. `gravity` [m/s^2] is the unit g of `measured_peak_g`, as for
    `peak_g` in `drop`; the default is that of the site (9.80665 without a record). A peak beyond
    the sensor's range is a failed check; `accept` is {check: reason}. Raises UnknownNameError for
    unknown names, and QuantityError for numbers out of bounds or a sampling rate that is too low.
    """
    options = {"filter_class" if k == "filter" else k: v for k, v in options.items()}
    chain = parse_options(Sensing, options) if sensing is None else sensing
    sensor = configure_sensor(chain.accelerometer, chain.low_pass, chain.sampling)
    measurement = measure_acceleration(signal, sensor, parse_channel_class(chain.filter_class))
    if gravity is None:
        gravity = signal.brake.brake.site.gravity if isinstance(signal, DropRecord) else 9.80665
    return Reading.create(
        judge(_sensor_checks(measurement, signal, sensor), accept),
        measured_peak=measurement.peak,
        measured_peak_g=measurement.peak / gravity if gravity else None,
        measured_peak_time=measurement.time_of_peak,
        peak_loss=measurement.loss,
        measured_rate=measurement.rate if measurement.rate != float("inf") else None,
        accelerometer=sensor.name,
        filter="none" if measurement.cfc is None else f"cfc{measurement.cfc}",
        saturated=measurement.saturated,
        warnings=list(measurement.warnings),
        record=measurement,
    )


def _sensor_checks(measurement: Seen, signal: Signal, sensor: Accelerometer) -> Iterator[Check]:
    """Yield the checks of a sensor's range and rate; there are none for an ideal sensor."""
    if sensor.range is not None:
        fits = "the sensor's range contains the peak"
        limit = show(sensor.range, "m/s^2")
        sentence = f"the peak exceeds the sensor's range; the limit of {limit} is reported"
        yield check(
            "saturation",
            not measurement.saturated,
            sentence if measurement.saturated else fits,
            level="failed",
        )
    if sensor.sampling is None:
        return
    time, value = specific_force(signal) if isinstance(signal, DropRecord) else signal[:2]
    pulls = np.flatnonzero(np.asarray(value) != 0)
    if len(pulls):
        span = float(np.asarray(time)[pulls[-1]] - np.asarray(time)[pulls[0]])
        samples = span * sensor.sampling
        yield check(
            "sampling",
            samples >= LEAST_SAMPLES,
            f"sampled at {show(sensor.sampling, 'Hz')}, the pull of {show(span, 's')} has "
            f"only {samples:.2g} samples",
            ": the peak may lie between them",
        )


def heating(
    heat: float | str, file: BrakeFile, warmth: Warmth | None = None, **asked: Any
) -> Heating:
    """Temperature rise of the sheets by a stop, and the number of such stops per minute.

    `temperature_rise` is the mean over the rubbing part, `temperature_rise_of_sheets` over the
    whole sheets. Two defaults are assumed and should be replaced by your own values: a rise of 20
    K, and 10 W/(m^2 K) from the enclosure to still air. Wear is not modelled. None if the film's
    specific heat is unknown or no heat was generated.
    """
    from layerjam.brake.mechanics.heat import (
        stops_per_minute,
        temperature_rise,
        temperature_rise_of_sheets,
    )

    check_kind(file, BrakeFile, "file")
    limits = parse_options(Warmth, asked) if warmth is None else warmth
    rise = DEFAULT_RISE if limits.allowed_rise is None else limits.allowed_rise
    film = DEFAULT_FILM_COEFFICIENT if limits.film_coefficient is None else limits.film_coefficient
    joule, brake = QuantitySpec("J", "heat of a stop").si(heat, "heat"), file.brake
    verdict = Heating(allowed_rise=rise, film_coefficient=film)
    if brake.film.specific_heat is None:
        unknown = (
            f"{file.name} does not state the film's specific heat, so no temperature rise is "
            "computed"
        )
        return verdict.with_notices(Notice(unknown, "no-specific-heat"))
    return evolve(
        verdict,
        temperature_rise=float(temperature_rise(joule, brake)),
        temperature_rise_of_sheets=float(temperature_rise_of_sheets(joule, brake)),
        stops_per_minute=float(stops_per_minute(joule, rise, film, brake)) if joule > 0 else None,
    )
