"""Reading of an accelerometer on the mass: low-pass, sampling, noise, range, CFC filter.

An accelerometer reads specific force, which is the force on the mass divided by the mass, F/M. It
reads 0 in free fall and 1 g at rest on the brake, so gravity is part of the reading and is not
subtracted. An ideal sensor reads the peak F_peak/M, which in g is `peak_g` of `drop`.

The steps are those of a measuring chain: analogue low-pass, sampling, noise, range, quantization,
then the digital filter of SAE J211-1. Before and after the record, the signal has its first or last
value. This is exact before a drop: the mass falls freely and the reading is 0.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.simulate.record import DropRecord, Outcome, column
from layerjam.core.errors import (
    Notice,
    QuantityError,
    UnknownNameError,
    explain_arguments,
    make_notices,
    short_text,
)
from layerjam.core.units import check, quantity, show

STANDARD_GRAVITY = 9.80665
"""Unit g of data sheets [m/s^2]."""
CLASSES = (60, 180, 600, 1000)
"""Channel frequency classes of SAE J211-1."""
KINDS = ("bessel", "butterworth")
LEAST_RATE = 10
"""Lowest sampling rate of SAE J211-1, in multiples of the class."""
FINE = 400
"""Default sampling rate of a sensor, in multiples of the cutoff.

A peak at the cutoff frequency that lies between two samples is then read too low by at most a
fraction of (pi/400)^2/2 = 3e-5.
"""
MOST_SAMPLES = 5_000_000
_INSTANT = 1e-12
"""Duration of a jump [s]."""
_MEMORY = 30.0
"""Age, in time constants, after which an input no longer affects a filter (exp(-30) = 1e-13)."""

Array = np.ndarray[Any, np.dtype[Any]]
Signal = DropRecord | tuple[Any, Any]


@explain_arguments
@dataclass(frozen=True, kw_only=True)
class Accelerometer:
    """Accelerometer along the pull, with its analogue-to-digital converter; None means no limit.

    `kind` is the type of low-pass, bessel or butterworth, both -3 dB at `bandwidth`. `noise` is
    white and needs a `seed`, so that results are reproducible.
    """

    name: str = "ideal"
    range: float | None = quantity(
        "m/s^2", "largest measurable specific force, of either sign", lo=1e-3, hi=1e7, default=None
    )
    bandwidth: float | None = quantity(
        "Hz", "-3 dB frequency of the built-in low-pass", lo=1e-2, hi=1e6, default=None
    )
    order: int = quantity("1", "number of poles of the low-pass", lo=1, hi=8, whole=True, default=2)
    kind: str = "bessel"
    sampling: float | None = quantity("Hz", "sampling rate", lo=1, hi=1e7, default=None)
    phase: float = quantity(
        "1",
        "time from when the rope is taut to the first sample, in sampling intervals",
        hi=1,
        default=0,
    )
    resolution: float | None = quantity(
        "m/s^2", "quantization step", open_lo=True, hi=1e6, default=None
    )
    noise: float = quantity("m/s^2", "RMS noise of a sample", hi=1e6, default=0.0)
    seed: int | None = quantity("1", "seed of the noise", hi=2**63 - 1, whole=True, default=None)
    source: str = ""

    def __post_init__(self) -> None:
        """Raise QuantityError for values that no sensor can have."""
        check(self, "accelerometer ")
        if self.kind not in KINDS:
            raise UnknownNameError("low-pass", self.kind, KINDS)
        if self.range is not None and self.resolution is not None and self.resolution > self.range:
            raise QuantityError(
                f"accelerometer resolution: a step of {show(self.resolution, 'm/s^2')} exceeds "
                f"the range of {show(self.range, 'm/s^2')}"
            )
        requirements = {
            "seed": "noise needs a seed, so that the result is reproducible",
            "sampling": "noise applies to each sample and needs a rate",
        }
        for name, reason in requirements.items():
            if self.noise and getattr(self, name) is None:
                raise QuantityError(f"accelerometer {name}: missing; {reason}")


IDEAL = Accelerometer()
ADXL193 = Accelerometer(
    name="adxl193",
    range=250 * STANDARD_GRAVITY,
    bandwidth=400.0,
    order=2,
    kind="bessel",
    sampling=20e3,
    source="Analog Devices ADXL193, analogue output. From its data sheet, as quoted by others: "
    "±250 g (a ±120 g grade exists; the paper does not state which one it used), 400 Hz low-pass "
    "at the output. Assumed: 2-pole Bessel (quoted from memory of the data sheet, not "
    "checked), 20 kHz sampling, no quantization, no noise",
)
SENSORS = {sensor.name: sensor for sensor in (IDEAL, ADXL193)}


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Reading of the sensor; arrays have shape (N,), equally spaced, SI units.

    `peak` is the reading of largest magnitude, with its sign, `ideal_peak` that of the signal
    itself; `loss` = 1 - peak/ideal_peak, negative if a filter overshoots. `cfc` is the class of the
    SAE J211-1 filter or None, `rate` the sampling rate [Hz]. If `saturated`, the signal left the
    range and the samples are clipped to it.
    """

    time: Array = column("s", "sample times, on the signal's clock")
    acceleration: Array = column("m/s^2", "measured specific force")
    peak: float
    time_of_peak: float
    ideal_peak: float
    loss: float
    saturated: bool
    rate: float
    sensor: Accelerometer
    cfc: int | None
    warnings: tuple[Notice, ...] = ()


def specific_force(record: DropRecord) -> tuple[Array, Array]:
    """Return time [s] and F/M [m/s^2] of a drop, shape (N,) each, until the rope is slack.

    A record that ends at its first standstill ends under full load, but a filter needs later
    samples. At constant vacuum and without damping the brake sticks there. The mass then swings
    back on the spring of rope, mount and sheets, in closed form, until it flies and the reading is
    0. Any other record is unchanged; specify a `duration` to include the rebound. A damped rope
    pulls from the first instant, so a zero is added just before that.
    """
    time, force = np.asarray(record.time, float), np.asarray(record.force, float)
    if _is_swinging_back(record):
        from layerjam.brake.simulate.drop import (
            series_spring,  # loads JAX, which a sensor does not need
        )

        spring = series_spring(record.brake.brake, record.rope_stiffness)
        weight = record.mass * record.gravity
        swing = float(force[-1]) - weight
        end = np.arccos(-weight / swing) if swing >= weight else np.pi
        angle = np.linspace(0, end, 200)[1:]
        time = np.append(time, time[-1] + angle / np.sqrt(spring / record.mass))
        force = np.append(force, np.maximum(weight + swing * np.cos(angle), 0.0))
    is_later = np.append(True, np.diff(time) > 0)
    time, force = time[is_later], force[is_later]
    if force[0] > 0:
        time, force = np.append(time[0] - _INSTANT, time), np.append(0.0, force)
    return time, force / record.mass


def _is_swinging_back(record: DropRecord) -> bool:
    """Return whether the record continues with an undamped swing on the stuck brake."""
    is_at_rest = abs(float(record.speed_of_mass[-1])) <= 1e-6 * record.speed
    steady = not record.rope_damping and bool(np.all(record.vacuum_in_time == record.vacuum))
    # with a speed law, the sheets keep sliding after the mass has stopped
    steady = steady and not depends_on_speed(record.brake.brake)
    stopped = record.outcome in (Outcome.STOPPED, Outcome.NEVER_SLID)
    # below the weight the mass does not rise again: it hangs, and the force stays constant
    return stopped and is_at_rest and steady and record.force[-1] > record.mass * record.gravity


def _list_end_warnings(record: DropRecord) -> list[str]:
    force, weight = float(record.force[-1]), record.mass * record.gravity
    hangs = abs(force - weight) <= 1e-3 * float(record.force.max())
    if force == 0 or hangs or _is_swinging_back(record):
        return []
    return [
        f"the record ends under load ({record.outcome}, {show(force, 'N')}), which is assumed to "
        "stay constant; the reading excludes later motion"
    ]


def lowpass_poles(kind: str, order: int, bandwidth: float) -> Array:
    """Return poles [rad/s], shape (order,), of a low-pass that is -3 dB at `bandwidth` [Hz]."""
    from scipy import signal

    shape = signal.besselap(order, norm="mag") if kind == "bessel" else signal.buttap(order)
    return np.asarray(2 * np.pi * bandwidth * shape[1])


def low_pass(time: Any, value: Any, poles: Array, first: float, rate: float, count: int) -> Any:
    """Return a signal after an analogue low-pass, at `count` instants from `first` [s].

    `rate` [Hz] is their spacing. The response is exact: the signal is linear between its samples
    (`time`, `value`, shape (N,), any spacing), and a line has a closed-form response for each pole.
    Therefore only frequencies that pass through the filter can alias. At `first`, the filter has
    settled at the signal's value. Its gain at zero frequency is 1.
    """
    from scipy.signal import lfilter

    instants = first + np.arange(count) / rate
    knots = np.union1d(instants, time[(time > instants[0]) & (time < instants[-1])])
    level = np.interp(knots, time, value)
    step, start, rise = np.diff(knots), level[:-1], np.diff(level)
    goal = np.minimum(np.searchsorted(instants, knots[:-1], side="right"), count - 1)
    gain = np.prod(-poles)
    out = np.zeros(count)
    for i, pole in enumerate(poles):
        x = pole * step
        fade = np.exp(pole * (instants[goal] - knots[1:]))
        part = step * (start * _phi1(x) + rise * _phi2(x)) * fade
        inflow = np.zeros(count, complex)
        np.add.at(inflow, goal, part)
        inflow[0] = -level[0] / pole
        state = lfilter([1.0], [1.0, -np.exp(pole / rate)], inflow)
        out += np.real(gain / np.prod(pole - np.delete(poles, i)) * state)
    return out


def _phi1(x: Array) -> Array:
    """Return (e^x - 1)/x."""
    is_small = abs(x) < 1e-3
    safe = np.where(is_small, 1.0, x)
    return np.where(is_small, 1 + x / 2 + x**2 / 6 + x**3 / 24, np.expm1(safe) / safe)


def _phi2(x: Array) -> Array:
    """Return (e^x - 1 - x)/x^2."""
    is_small = abs(x) < 1e-2
    safe = np.where(is_small, 1.0, x)
    series = 1 / 2 + x / 6 + x**2 / 24 + x**3 / 120 + x**4 / 720 + x**5 / 5040
    return np.where(is_small, series, (np.expm1(safe) - safe) / safe**2)


def cfc_coefficients(cfc: float, rate: float) -> tuple[Array, Array]:
    """Return the filter coefficients (a, b) of SAE J211-1, appendix C, of shape (3,) and (2,).

    y_i = a0 x_i + a1 x_i-1 + a2 x_i-2 + b1 y_i-1 + b2 y_i-2 is a 2-pole Butterworth low-pass by the
    bilinear transform. Its cutoff is 2.0775 times the class, so two passes give -3 dB at class/0.6.
    """
    angle = np.tan(np.pi * 2.0775 * cfc / rate)
    scale = 1 + np.sqrt(2) * angle + angle**2
    first = angle**2 / scale
    return (
        np.array([first, 2 * first, first]),
        np.array([-2 * (angle**2 - 1), -1 + np.sqrt(2) * angle - angle**2]) / scale,
    )


def cfc_filter(value: Any, rate: float, cfc: float) -> Array:
    """Filter equally spaced samples, shape (N,), by SAE J211-1, forwards and backwards.

    The result has four poles and no phase shift. Beyond its ends the signal keeps its first and
    last values, which is exact for the zeros before a drop. The filter starts at rest at that
    value, and continues past the end until it has settled (at least 10 ms, the padding of the
    standard). Raises QuantityError for a rate below ten times the class, the standard's minimum.
    """
    from scipy.signal import lfilter

    if rate < LEAST_RATE * cfc * (1 - 1e-12):
        raise QuantityError(
            f"sampling: {show(rate, 'Hz')} is too slow for CFC {cfc:g}; SAE J211-1 requires at "
            f"least ten times the class, {show(LEAST_RATE * cfc, 'Hz')}"
        )
    a, b = cfc_coefficients(cfc, rate)
    denominator = np.concatenate([[1.0], -b])
    # state of the direct form for a constant level of one
    level_state = np.array([1 - a[0], a[2] + b[1]])
    values = np.asarray(value, float)
    tail = int(np.ceil(rate * filter_memory(cfc)))
    padded = np.concatenate([values, np.full(tail, values[-1])])
    forward, _ = lfilter(a, denominator, padded, zi=level_state * padded[0])
    backward, _ = lfilter(a, denominator, forward[::-1], zi=level_state * forward[-1])
    return np.asarray(backward[::-1][: len(values)])


def filter_memory(cfc: float) -> float:
    """Return the time [s] after which a class's filter has settled; at least 10 ms."""
    return float(max(_MEMORY * np.sqrt(2) / (2 * np.pi * 2.0775 * cfc), 0.010))


def measure_acceleration(
    signal: Signal, sensor: Accelerometer = IDEAL, cfc: float | None = None
) -> Reading:
    """Return the reading of a stop by `sensor`, filtered by SAE J211-1 class `cfc` if not None.

    `signal` is the record of a drop or (time [s], specific force [m/s^2]), with rising times, shape
    (N,) each. A sensor without a sampling rate is sampled at 400 times its cutoff, the lower of its
    low-pass and the class. Without low-pass, rate and class, the signal is returned unchanged.
    Raises QuantityError for a rate below ten times the class, for a class that is not in SAE
    J211-1, and for an invalid signal.
    """
    time, value = _check_signal(signal)
    warnings = _list_end_warnings(signal) if isinstance(signal, DropRecord) else []
    if cfc is not None and cfc not in CLASSES:
        names = ", ".join(map(str, CLASSES))
        raise QuantityError(f"filter: CFC {cfc:g} is not an SAE J211-1 class; classes: {names}")
    return _read_signal(time, value, sensor, cfc, warnings)


def _read_signal(
    time: Array, value: Array, sensor: Accelerometer, cfc: float | None, warnings: list[str]
) -> Reading:
    ideal = float(value[np.argmax(abs(value))])
    rate = _sampling_rate(sensor, cfc)
    if rate is None:
        instants, reading = time, value.copy()
    else:
        instants, reading = _sample_signal(time, value, sensor, cfc, rate)
        if sensor.bandwidth is not None and rate < 2 * sensor.bandwidth:
            warnings.append(
                f"sampled at {show(rate, 'Hz')}, below twice the low-pass of "
                f"{show(sensor.bandwidth, 'Hz')}: frequencies above half the rate alias"
            )
    if sensor.noise:
        random = np.random.default_rng(int(sensor.seed or 0))
        reading = reading + random.normal(0, sensor.noise, len(reading))
    saturated = sensor.range is not None and bool(np.any(abs(reading) > sensor.range))
    if sensor.range is not None and saturated:
        warnings.append(
            f"saturated: {show(float(abs(reading).max()), 'm/s^2')} exceeds the range and is "
            f"clipped to {show(sensor.range, 'm/s^2')}; the reported peak is too low"
        )
        reading = np.clip(reading, -sensor.range, sensor.range)
    if sensor.resolution is not None:
        reading = np.round(reading / sensor.resolution) * sensor.resolution
    if cfc is not None and rate is not None:
        reading = cfc_filter(reading, rate, cfc)
    top = int(np.argmax(abs(reading)))
    peak = float(reading[top])
    return Reading(
        time=instants,
        acceleration=reading,
        peak=peak,
        time_of_peak=float(instants[top]),
        ideal_peak=ideal,
        loss=1 - peak / ideal if ideal else 0.0,
        saturated=saturated,
        rate=rate if rate is not None else float("inf"),
        sensor=sensor,
        cfc=None if cfc is None else int(cfc),
        warnings=tuple(make_notices(warnings)),
    )


def _sampling_rate(sensor: Accelerometer, cfc: float | None) -> float | None:
    """Return the sampling rate [Hz], or None if the signal is not resampled."""
    if sensor.sampling is not None:
        return sensor.sampling
    cutoffs = [f for f in (sensor.bandwidth, cfc and cfc / 0.6) if f is not None]
    return max(FINE * min(cutoffs), LEAST_RATE * (cfc or 0)) if cutoffs else None


def _sample_signal(
    time: Array, value: Array, sensor: Accelerometer, cfc: float | None, rate: float
) -> tuple[Array, Array]:
    """Return instants and values after the analogue low-pass, extended so that filters settle."""
    margin = filter_memory(cfc) if cfc is not None else 0.010
    poles = None
    if sensor.bandwidth is not None:
        poles = lowpass_poles(sensor.kind, sensor.order, sensor.bandwidth)
        margin = max(margin, _MEMORY / float(np.min(-poles.real)))
    lead_samples = int(np.ceil(margin * rate)) + 1
    span = (time[-1] - time[0]) * rate
    if not span + 2 * lead_samples < MOST_SAMPLES:
        raise QuantityError(
            f"sampling: {show(rate, 'Hz')} for {show(float(time[-1] - time[0]), 's')} gives more "
            f"than {MOST_SAMPLES} samples; use a lower rate"
        )
    count = int(np.ceil(span)) + 2 * lead_samples + 1
    first = float(time[0]) + (sensor.phase - lead_samples) / rate
    if poles is None:
        instants = first + np.arange(count) / rate
        return instants, np.interp(instants, time, value)
    filtered = low_pass(time, value, poles, first, rate, count)
    return first + np.arange(count) / rate, filtered


def _check_signal(signal: Signal) -> tuple[Array, Array]:
    pair = specific_force(signal) if isinstance(signal, DropRecord) else signal
    try:
        time, value = (np.atleast_1d(np.asarray(part, float)) for part in pair)
    except (TypeError, ValueError):
        kinds = "is not the record of a drop or a pair of times and specific forces"
        raise QuantityError.of("signal", f"{short_text(signal)} {kinds}") from None
    if time.ndim != 1 or time.shape != value.shape or len(time) < 2:
        raise QuantityError(
            "acceleration: times and values must have the same length, at least two of each"
        )
    if not (np.all(np.isfinite(time)) and np.all(np.isfinite(value))):
        raise QuantityError("acceleration: a time or a value is not a finite number")
    if not np.all(np.diff(time) > 0):
        raise QuantityError("acceleration: times must increase")
    return time, value


seen = measure_acceleration  # former name


def find_accelerometer(name: str) -> Accelerometer:
    """Return the accelerometer "ideal" or "adxl193"; raises UnknownNameError for others."""
    try:
        return SENSORS[name.lower()]
    except KeyError:
        raise UnknownNameError("accelerometer", name, SENSORS) from None
