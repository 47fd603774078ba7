"""What an accelerometer on the mass shows of a stop: its low-pass, its sampling, its range, a CFC.

An accelerometer reads specific force, the force on the mass over the mass: F/M. It shows 0 in free
fall and 1 g at rest on the brake, so gravity is part of the reading and is not taken off. An ideal
one shows the peak F_peak/M; in g that is `peak_g` of `drop`.

The order is that of a measuring chain: analogue low-pass, samples, noise, range, steps of the
converter, then the digital filter of SAE J211-1. Outside the record the signal is held at its first
and its last value. Before a drop that is exact: the mass falls freely, the reading is 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.errors import QuantityError, UnknownNameError
from layerjam.simulate.record import DropRecord, Outcome, column
from layerjam.simulate.speed import follows_speed
from layerjam.units import check, quantity, show

STANDARD_GRAVITY = 9.80665
"""g of a data sheet [m/s^2]."""
CLASSES = (60, 180, 600, 1000)
"""Channel frequency classes of SAE J211-1."""
KINDS = ("bessel", "butterworth")
LEAST_RATE = 10
"""SAE J211-1: samples a second at least, in multiples of the class."""
FINE = 400
"""Samples a second for a sensor without a rate of its own, in multiples of the cutoff.

At the cutoff a peak between two samples is then missed by at most (pi/400)^2/2 = 3e-5 of it.
"""
MOST_SAMPLES = 5_000_000
_INSTANT = 1e-12
"""Seconds in which a jump happens."""
_MEMORY = 30.0
"""A filter has forgotten what is older than this many of its time constants (exp(-30) = 1e-13)."""

Array = np.ndarray[Any, np.dtype[Any]]
Signal = DropRecord | tuple[Any, Any]


@dataclass(frozen=True, kw_only=True)
class Accelerometer:
    """An accelerometer and its converter, along the pull. None is "not limited by this".

    `kind` is the low-pass, bessel or butterworth, both -3 dB at `bandwidth`. `noise` is white from
    sample to sample and needs a `seed`, so that a result can be had again.
    """

    name: str = "ideal"
    range: float | None = quantity(
        "m/s^2", "greatest specific force shown, either way", lo=1e-3, hi=1e7, default=None
    )
    bandwidth: float | None = quantity(
        "Hz", "-3 dB frequency of the built-in low-pass", lo=1e-2, hi=1e6, default=None
    )
    order: int = quantity("1", "poles of the built-in low-pass", lo=1, hi=8, whole=True, default=2)
    kind: str = "bessel"
    sampling: float | None = quantity("Hz", "sampling rate", lo=1, hi=1e7, default=None)
    phase: float = quantity(
        "1", "first sample after the taut rope, as a part of the sampling interval", hi=1, default=0
    )
    resolution: float | None = quantity(
        "m/s^2", "step of the converter", open_lo=True, hi=1e6, default=None
    )
    noise: float = quantity("m/s^2", "noise of a sample, RMS", hi=1e6, default=0.0)
    seed: int | None = quantity("1", "seed of the noise", hi=2**63 - 1, whole=True, default=None)
    source: str = ""

    def __post_init__(self) -> None:
        """Raise QuantityError for what no sensor can be."""
        check(self, "accelerometer ")
        if self.kind not in KINDS:
            raise UnknownNameError("low-pass", self.kind, KINDS)
        if self.range is not None and self.resolution is not None and self.resolution > self.range:
            raise QuantityError(
                f"accelerometer resolution: a step of {show(self.resolution, 'm/s^2')} is more "
                f"than the range of {show(self.range, 'm/s^2')}"
            )
        needed = {
            "seed": "noise needs one, so that the result can be had again",
            "sampling": "noise is given for each sample and needs a rate",
        }
        for name, why in needed.items():
            if self.noise and getattr(self, name) is None:
                raise QuantityError(f"accelerometer {name}: missing; {why}")


IDEAL = Accelerometer()
ADXL193 = Accelerometer(
    name="adxl193",
    range=250 * STANDARD_GRAVITY,
    bandwidth=400.0,
    order=2,
    kind="bessel",
    sampling=20e3,
    source="Analog Devices ADXL193, analogue output. From its data sheet, as others quote it: "
    "±250 g (a ±120 g grade exists; the paper does not say which), low-pass of 400 Hz on the "
    "output. Assumed: 2-pole Bessel (remembered of the data sheet, not checked), 20 kHz "
    "sampling, a converter without steps, no noise",
)
SENSORS = {sensor.name: sensor for sensor in (IDEAL, ADXL193)}


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What the sensor shows; arrays have shape (N,), equally spaced, SI units.

    `peak` is the reading of greatest size, with its sign, `ideal_peak` the same of the signal
    itself; `loss` = 1 - peak/ideal_peak, negative where a filter overshoots. `cfc` is the class of
    the SAE J211-1 filter or None, `rate` the samples a second. `saturated`: the signal left the
    range, and the samples show the range there.
    """

    time: Array = column("s", "time of the samples, on the clock of the signal")
    acceleration: Array = column("m/s^2", "specific force shown")
    peak: float
    time_of_peak: float
    ideal_peak: float
    loss: float
    saturated: bool
    rate: float
    sensor: Accelerometer
    cfc: int | None
    warnings: tuple[str, ...] = ()


def specific_force(record: DropRecord) -> tuple[Array, Array]:
    """Time [s] and F/M [m/s^2] of a drop, shape (N,) each, with the rebound up to the slack rope.

    A record that ends at its first standstill ends in full load, where a filter still needs what
    follows. At constant vacuum and without damping the brake sticks there, so the mass swings back
    on the spring of rope, mount and sheets, in closed form; then it flies and reads 0. Any other
    record is left as it is: give a `duration`, and the rebound is in it. A damped rope pulls from
    the first instant on; a zero stands just before it.
    """
    time, force = np.asarray(record.time, float), np.asarray(record.force, float)
    if _swings_back(record):
        from layerjam.simulate.drop import spring_of  # brings JAX, which no sensor needs

        spring = spring_of(record.brake.brake, record.rope_stiffness)
        weight = record.mass * record.gravity
        swing = float(force[-1]) - weight
        end = np.arccos(-weight / swing) if swing >= weight else np.pi
        angle = np.linspace(0, end, 200)[1:]
        time = np.append(time, time[-1] + angle / np.sqrt(spring / record.mass))
        force = np.append(force, np.maximum(weight + swing * np.cos(angle), 0.0))
    apart = np.append(True, np.diff(time) > 0)
    time, force = time[apart], force[apart]
    if force[0] > 0:
        time, force = np.append(time[0] - _INSTANT, time), np.append(0.0, force)
    return time, force / record.mass


def _swings_back(record: DropRecord) -> bool:
    """Whether what follows the record is an undamped swing of the mass on the stuck brake."""
    still = abs(float(record.speed_of_mass[-1])) <= 1e-6 * record.speed
    steady = not record.rope_damping and bool(np.all(record.vacuum_in_time == record.vacuum))
    # sheets that slide the slower the less they are pulled go on sliding after the standstill
    steady = steady and not follows_speed(record.brake.brake)
    stopped = record.outcome in (Outcome.STOPPED, Outcome.NEVER_SLID)
    # below the weight the mass does not go up again: it hangs, and the force stays
    return stopped and still and steady and record.force[-1] > record.mass * record.gravity


def _end_of(record: DropRecord) -> list[str]:
    """What to say of a record that ends in the middle of a pull."""
    force, weight = float(record.force[-1]), record.mass * record.gravity
    hangs = abs(force - weight) <= 1e-3 * float(record.force.max())
    if force == 0 or hangs or _swings_back(record):
        return []
    return [
        f"the record ends under load ({record.outcome}, {show(force, 'N')}), which is taken as "
        "held; what follows is not part of the reading"
    ]


def lowpass_poles(kind: str, order: int, bandwidth: float) -> Array:
    """Poles [rad/s], shape (order,), of an analogue low-pass that is -3 dB at `bandwidth` [Hz]."""
    from scipy import signal

    shape = signal.besselap(order, norm="mag") if kind == "bessel" else signal.buttap(order)
    return np.asarray(2 * np.pi * bandwidth * shape[1])


def low_pass(time: Any, value: Any, poles: Array, first: float, rate: float, count: int) -> Any:
    """A signal behind an analogue low-pass, at `count` instants from `first` [s] at `rate` [Hz].

    Exact, not stepped: between its samples (`time`, `value`, shape (N,), any spacing) the signal is
    a straight line, and for each pole the response to a straight line is a closed form. So nothing
    folds that the low-pass has not let through. Before `first` the filter is at rest at the
    signal's value there. The filter is 1 at zero frequency.
    """
    from scipy.signal import lfilter

    at = first + np.arange(count) / rate
    every = np.union1d(at, time[(time > at[0]) & (time < at[-1])])
    level = np.interp(every, time, value)
    step, start, rise = np.diff(every), level[:-1], np.diff(level)
    goal = np.minimum(np.searchsorted(at, every[:-1], side="right"), count - 1)
    gain = np.prod(-poles)
    out = np.zeros(count)
    for i, pole in enumerate(poles):
        x = pole * step
        part = step * (start * _phi1(x) + rise * _phi2(x)) * np.exp(pole * (at[goal] - every[1:]))
        inflow = np.zeros(count, complex)
        np.add.at(inflow, goal, part)
        inflow[0] = -level[0] / pole
        state = lfilter([1.0], [1.0, -np.exp(pole / rate)], inflow)
        out += np.real(gain / np.prod(pole - np.delete(poles, i)) * state)
    return out


def _phi1(x: Array) -> Array:
    """(e^x - 1)/x."""
    small = abs(x) < 1e-3
    safe = np.where(small, 1.0, x)
    return np.where(small, 1 + x / 2 + x**2 / 6 + x**3 / 24, np.expm1(safe) / safe)


def _phi2(x: Array) -> Array:
    """(e^x - 1 - x)/x^2."""
    small = abs(x) < 1e-2
    safe = np.where(small, 1.0, x)
    series = 1 / 2 + x / 6 + x**2 / 24 + x**3 / 120 + x**4 / 720 + x**5 / 5040
    return np.where(small, series, (np.expm1(safe) - safe) / safe**2)


def cfc_coefficients(cfc: float, rate: float) -> tuple[Array, Array]:
    """(a, b) of SAE J211-1, appendix C: y_i = a0 x_i + a1 x_i-1 + a2 x_i-2 + b1 y_i-1 + b2 y_i-2.

    Shape (3,) and (2,). A 2-pole Butterworth low-pass by the bilinear transform; its cutoff lies at
    2.0775 times the class, so that after two passes -3 dB stand at class/0.6.
    """
    warped = np.tan(np.pi * 2.0775 * cfc / rate)
    scale = 1 + np.sqrt(2) * warped + warped**2
    first = warped**2 / scale
    return (
        np.array([first, 2 * first, first]),
        np.array([-2 * (warped**2 - 1), -1 + np.sqrt(2) * warped - warped**2]) / scale,
    )


def cfc_filter(value: Any, rate: float, cfc: float) -> Array:
    """Equally spaced samples, shape (N,), through the filter of SAE J211-1, forward and backward.

    Four poles, no phase. Ends: the samples count as held at their first and last value for ever,
    which zeros before a drop make exact; the filter starts at rest at that value, and runs on
    behind the end until it has forgotten (at least 10 ms, as the standard pads). Raises
    QuantityError for a rate below ten times the class, which the standard asks for.
    """
    from scipy.signal import lfilter

    if rate < LEAST_RATE * cfc * (1 - 1e-12):
        raise QuantityError(
            f"sampling: {show(rate, 'Hz')} is too slow for CFC {cfc:g}; SAE J211-1 asks for at "
            f"least ten times the class, {show(LEAST_RATE * cfc, 'Hz')}"
        )
    a, b = cfc_coefficients(cfc, rate)
    whole = np.concatenate([[1.0], -b])
    # state of the direct form at rest at a level of one
    rest = np.array([1 - a[0], a[2] + b[1]])
    values = np.asarray(value, float)
    tail = int(np.ceil(rate * memory(cfc)))
    padded = np.concatenate([values, np.full(tail, values[-1])])
    forward, _ = lfilter(a, whole, padded, zi=rest * padded[0])
    backward, _ = lfilter(a, whole, forward[::-1], zi=rest * forward[-1])
    return np.asarray(backward[::-1][: len(values)])


def memory(cfc: float) -> float:
    """Seconds after which the filter of a class has forgotten; no less than 10 ms."""
    return float(max(_MEMORY * np.sqrt(2) / (2 * np.pi * 2.0775 * cfc), 0.010))


def seen(signal: Signal, sensor: Accelerometer = IDEAL, cfc: float | None = None) -> Reading:
    """What `sensor` shows of a stop, and SAE J211-1 class `cfc` makes of it (None: no filter).

    `signal` is the record of a drop or (time [s], specific force [m/s^2]), rising times, shape (N,)
    each. A sensor without a sampling rate is looked at 400 times its cutoff (the lower one of its
    low-pass and the class); one without low-pass, rate and filter shows the signal as it is.
    Raises QuantityError for a rate below ten times the class, for a class that SAE J211-1 does not
    have, and for a signal that is none.
    """
    time, value = _checked(signal)
    warnings = _end_of(signal) if isinstance(signal, DropRecord) else []
    if cfc is not None and cfc not in CLASSES:
        known = ", ".join(map(str, CLASSES))
        raise QuantityError(f"filter: CFC {cfc:g} is not a class of SAE J211-1; there are {known}")
    return _read(time, value, sensor, cfc, warnings)


def _read(
    time: Array, value: Array, sensor: Accelerometer, cfc: float | None, warnings: list[str]
) -> Reading:
    ideal = float(value[np.argmax(abs(value))])
    rate = _rate(sensor, cfc)
    if rate is None:
        at, shown = time, value.copy()
    else:
        at, shown = _sampled(time, value, sensor, cfc, rate)
        if sensor.bandwidth is not None and rate < 2 * sensor.bandwidth:
            warnings.append(
                f"sampled at {show(rate, 'Hz')}, below twice the low-pass of "
                f"{show(sensor.bandwidth, 'Hz')}: what lies above half the rate folds down"
            )
    if sensor.noise:
        random = np.random.default_rng(int(sensor.seed or 0))
        shown = shown + random.normal(0, sensor.noise, len(shown))
    saturated = sensor.range is not None and bool(np.any(abs(shown) > sensor.range))
    if sensor.range is not None and saturated:
        warnings.append(
            f"saturated: {show(float(abs(shown).max()), 'm/s^2')} is beyond the range of "
            f"{show(sensor.range, 'm/s^2')}, which stands in its place; the peak shown is too low"
        )
        shown = np.clip(shown, -sensor.range, sensor.range)
    if sensor.resolution is not None:
        shown = np.round(shown / sensor.resolution) * sensor.resolution
    if cfc is not None and rate is not None:
        shown = cfc_filter(shown, rate, cfc)
    top = int(np.argmax(abs(shown)))
    peak = float(shown[top])
    return Reading(
        time=at,
        acceleration=shown,
        peak=peak,
        time_of_peak=float(at[top]),
        ideal_peak=ideal,
        loss=1 - peak / ideal if ideal else 0.0,
        saturated=saturated,
        rate=rate if rate is not None else float("inf"),
        sensor=sensor,
        cfc=None if cfc is None else int(cfc),
        warnings=tuple(warnings),
    )


def _rate(sensor: Accelerometer, cfc: float | None) -> float | None:
    """Samples a second [Hz]; None where the signal is shown as it is."""
    if sensor.sampling is not None:
        return sensor.sampling
    cutoffs = [f for f in (sensor.bandwidth, cfc and cfc / 0.6) if f is not None]
    return max(FINE * min(cutoffs), LEAST_RATE * (cfc or 0)) if cutoffs else None


def _sampled(
    time: Array, value: Array, sensor: Accelerometer, cfc: float | None, rate: float
) -> tuple[Array, Array]:
    """Instants and values behind the analogue low-pass, with room for the filters on both sides."""
    room = memory(cfc) if cfc is not None else 0.010
    poles = None
    if sensor.bandwidth is not None:
        poles = lowpass_poles(sensor.kind, sensor.order, sensor.bandwidth)
        room = max(room, _MEMORY / float(np.min(-poles.real)))
    before = int(np.ceil(room * rate)) + 1
    span = (time[-1] - time[0]) * rate
    if not span + 2 * before < MOST_SAMPLES:
        raise QuantityError(
            f"sampling: {show(rate, 'Hz')} over {show(float(time[-1] - time[0]), 's')} would be "
            f"more than {MOST_SAMPLES} samples; take fewer"
        )
    count = int(np.ceil(span)) + 2 * before + 1
    first = float(time[0]) + (sensor.phase - before) / rate
    if poles is None:
        at = first + np.arange(count) / rate
        return at, np.interp(at, time, value)
    shown = low_pass(time, value, poles, first, rate, count)
    return first + np.arange(count) / rate, shown


def _checked(signal: Signal) -> tuple[Array, Array]:
    """Time and specific force as arrays; QuantityError for what is no signal."""
    pair = specific_force(signal) if isinstance(signal, DropRecord) else signal
    time, value = (np.atleast_1d(np.asarray(part, float)) for part in pair)
    if time.ndim != 1 or time.shape != value.shape or len(time) < 2:
        raise QuantityError(
            "acceleration: give times and values of the same length, two or more of each"
        )
    if not (np.all(np.isfinite(time)) and np.all(np.isfinite(value))):
        raise QuantityError("acceleration: a time or a value is not a finite number")
    if not np.all(np.diff(time) > 0):
        raise QuantityError("acceleration: the times must rise")
    return time, value


def named(name: str) -> Accelerometer:
    """The accelerometer of that name, ideal or adxl193; raises UnknownNameError for another."""
    try:
        return SENSORS[name.lower()]
    except KeyError:
        raise UnknownNameError("accelerometer", name, SENSORS) from None
