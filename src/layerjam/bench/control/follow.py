"""Force control: target force and measured slip determine the vacuum, and hence the force.

The slip is prescribed, as by a turning joint or a rope that runs out. The law yields the brake's
force at the current vacuum and, with a speed law, at the current speed. Target force and measured
slip determine the target vacuum by the inverse law of the brake that the controller assumes
(`model`). The true brake may differ, and the measured slip is noisy. Unattainable parts of the
target are reported beforehand: forces outside the brake's range, and vacuums that would have to
change faster than pump and vent allow.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.bench.control.closed_loop import ClosedLoop, simulate_run
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import brake_force, force_limits, vacuum_for_force
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.simulate.prediction import Prediction
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import show

SPREAD_SAMPLES, SPREAD_POINTS, PEAK_POINTS = 400, 400, 60
"""Number of brakes, of times, and of times with the largest errors and forces, for the scatter."""
Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
LEAST = 1.0
"""Target vacuum [Pa] if the force needs no vacuum, because a target of zero would open the vent."""
MARGIN = 0.98
"""Highest target, relative to the pump's maximum vacuum."""
CYCLES = 6
"""Number of sine cycles to follow; the response is fitted to the second half."""


@brief
@dataclass(frozen=True, eq=False)
class Following:
    """One run, in SI units; the arrays have one entry per sample of the controller, shape (N,)."""

    loop: ClosedLoop
    wanted: Array = field(repr=False)
    force: Array = field(repr=False)
    slip: Array = field(repr=False)
    possible: Mask
    """Whether the brake can produce the force here, and pump or vent can follow it fast enough."""
    reasons: tuple[str, ...]
    """Reasons why some samples cannot be followed."""

    @property
    def time(self) -> Array:
        """Sample times [s]."""
        return self.loop.time

    @property
    def error(self) -> Array:
        """Force minus target [N]."""
        return self.force - self.wanted

    @property
    def rms(self) -> float:
        """Root mean square of the error [N]."""
        return float(np.sqrt(np.mean(self.error**2)))


def _pad_values(values: Array) -> Array:
    """Return the values padded to one of a few lengths, because each new length is compiled.

    The laws take 0.2 ms for 4,096 values; compiling them takes a hundred times as long.
    """
    count, length = len(values), 4096
    while length < count:
        length *= 8
    return np.pad(values, (0, length - count), mode="edge")


def target_vacuums(
    forces: Array, slip: Array, brake: Brake, highest: float, pace: Array | None = None
) -> tuple[Array, Mask, list[str]]:
    """Return the vacuum [Pa] for each force [N] at a slip [m], whether one exists, and why not.

    Targets below the enclosure's own force get the vacuum `LEAST`, those above the maximum force
    get `highest` [Pa]. `pace` [m/s] is the sliding speed, if friction depends on it; None means
    quasi-static.
    """
    count = len(slip)
    padded_slip = _pad_values(slip)
    moving = fix_speed(np.zeros_like(padded_slip) if pace is None else _pad_values(pace), brake)
    low, high = (np.asarray(f)[:count] for f in force_limits(padded_slip, moving))
    vacuum = np.asarray(vacuum_for_force(_pad_values(forces), padded_slip, moving))[:count]
    full_vacuum = min(highest, brake.site.atmosphere)
    is_too_low = forces < low
    much = ~is_too_low & ~(vacuum <= highest)
    reasons = []
    if is_too_low.any():
        i = int(np.argmax(is_too_low))
        reasons.append(
            f"{show(float(forces[i]), 'N')} at a slip of {show(float(slip[i]), 'm')} is below "
            f"the enclosure's own force, {show(float(low[i]), 'N')}"
        )
    if much.any():
        i = int(np.argmax(much))
        top = float(np.asarray(brake_force(padded_slip, full_vacuum, moving))[i])
        reasons.append(
            f"{show(float(forces[i]), 'N')} at a slip of {show(float(slip[i]), 'm')} exceeds "
            f"the brake's force at {show(highest, 'Pa')}, {show(min(top, float(high[i])), 'N')}"
        )
    target = np.where(is_too_low, LEAST, np.where(much, highest, vacuum))
    return np.maximum(target, LEAST), ~(is_too_low | much), reasons


def check_slew(targets: Array, dt: float, plant: Plant) -> tuple[Mask, list[str]]:
    """Return whether pump and vent can follow each target, and the reasons why not."""
    middle = (targets[1:] + targets[:-1]) / 2
    rate = np.diff(targets) / dt
    up, down = plant.rise(middle), plant.fall(middle)
    can_follow = np.append((rate <= up) & (-rate <= down), True)
    reasons = []
    for is_too_fast, limit, actor in ((rate > up, up, "pump"), (-rate > down, down, "vent")):
        if is_too_fast.any():
            i = int(np.argmax(is_too_fast))
            reasons.append(
                f"at {show(i * dt, 's')} the vacuum would have to change by "
                f"{show(abs(float(rate[i])), 'Pa')} per second, but the {actor} achieves "
                f"{show(float(limit[i]), 'Pa')}"
            )
    return can_follow, reasons


def follow(
    regulator: Regulator,
    model: Brake,
    wanted: Array,
    slip: Array,
    *,
    brake: Brake | None = None,
    slip_noise: float = 0.0,
    plant: Plant | None = None,
    seed: int = 0,
    pace: float | None = None,
) -> Following:
    """Follow target forces [N] at prescribed slips [m], with one of each per sample, shape (N,).

    `brake` is the true brake if it differs from `model`; `slip_noise` [m] is the standard deviation
    of the measured slip. `pace` [m/s] is the sliding speed if it differs from the rate of slip.
    Raises QuantityError for profiles of different lengths or a slip beyond the overlap.
    """
    wanted, slip = np.asarray(wanted, float), np.asarray(slip, float)
    if wanted.ndim != 1 or wanted.shape != slip.shape or len(wanted) < 2:
        raise QuantityError(
            f"profile: {wanted.shape} forces and {slip.shape} slips; expected two rows "
            "of the same length, with at least two samples"
        )
    if not (np.isfinite(wanted).all() and np.isfinite(slip).all()):
        raise QuantityError("profile: contains a number that is not finite")
    if slip.min() < 0 or slip.max() > model.sheets.overlap:
        raise QuantityError(
            f"slip: {show(float(slip.min()), 'm')} to {show(float(slip.max()), 'm')} is not "
            f"allowed; it must be from 0 to the overlap of {show(model.sheets.overlap, 'm')}"
        )
    dt, highest = regulator.sample_time, MARGIN * regulator.plant.reach
    if regulator.kind == "bang-bang":
        highest = min(highest, regulator.plant.reach - 2 * regulator.half_band)
    random = np.random.default_rng(seed)
    readings = np.clip(
        slip + slip_noise * random.standard_normal(len(slip)), 0.0, model.sheets.overlap
    )
    paces = np.abs(np.gradient(slip, dt)) if pace is None else np.full_like(slip, pace)
    clean, is_held, reasons = target_vacuums(wanted, slip, model, highest, paces)
    can_follow, slew_reasons = check_slew(clean, dt, regulator.plant)
    targets, _, _ = target_vacuums(wanted, readings, model, highest, paces)
    regulator = evolve(regulator, plant=regulator.plant.tune_up_to(float(targets.max())))
    loop = simulate_run(
        regulator, [(dt, float(level)) for level in targets], plant=plant, seed=seed
    )
    true = fix_speed(_pad_values(paces), brake or model)
    force = np.asarray(brake_force(_pad_values(slip), _pad_values(loop.vacuum), true))[: len(slip)]
    return Following(loop, wanted, force, slip, is_held & can_follow, (*reasons, *slew_reasons))


@brief
@dataclass(frozen=True, eq=False)
class ForceSpread:
    """Scatter of a followed force, for samples of the true brake."""

    errors: dict[str, Array] = field(repr=False)
    """Samples of the errors [N], by the keys of `follow`."""
    time: Array = field(repr=False)
    """Some of the times of the run [s], shape (K,)."""
    low: Array = field(repr=False)
    """Ends of the 95 % interval of the force at these times [N]."""
    high: Array = field(repr=False)
    is_tested: Mask
    """Whether tests of the brake cover these times."""


def spread_force(
    record: Following, brake: Brake, paces: Array, conditions: Prediction
) -> ForceSpread:
    """Return the scatter of the force and its errors for samples of the true brake.

    `brake` is the average one, `paces` [m/s] are the sliding speeds, shape (N,). The vacuum does
    not depend on the brake, so it is that of the record.
    """
    length = len(record.slip)
    even = np.linspace(0, length - 1, min(length, SPREAD_POINTS)).round().astype(int)
    # another brake has its largest error where this one has it, or where the force is largest
    largest = (np.argsort(size)[-PEAK_POINTS:] for size in (np.abs(record.error), record.force))
    places = np.concatenate((even, *largest))
    vacuum, slip, pace = record.loop.vacuum[places], record.slip[places], paces[places]
    moving = fix_speed(pace, brake)
    numbers: dict[str, Any] = {"vacuum": vacuum, "slip": slip, "speed": pace, "device": moving}
    prediction = evolve(conditions, **numbers, samples=SPREAD_SAMPLES)
    force = np.asarray(brake_force(slip, vacuum, prediction.brakes))
    error = force - record.wanted[places]
    # few times are enough for the change of the mean square from that of the record
    change = np.mean(error[:, : len(even)] ** 2 - record.error[even] ** 2, axis=-1)
    errors = {
        "rms_error": np.sqrt(np.maximum(record.rms**2 + change, 0.0)),
        "greatest_error": np.abs(error).max(axis=-1),
    }
    band = prediction.interval(force[:, : len(even)])
    is_tested = np.broadcast_to(prediction.is_tested(), places.shape)[: len(even)]
    return ForceSpread(errors, record.time[even], band["low"], band["high"], is_tested)


@brief
@dataclass(frozen=True, eq=False)
class Bode:
    """Response of the force to sinusoidal targets, one entry per frequency, shape (F,)."""

    frequency: Array = field(repr=False)
    """Frequency [Hz]."""
    magnitude: Array = field(repr=False)
    phase: Array = field(repr=False)
    """Phase [degrees], negative if the force lags."""

    @property
    def bandwidth(self) -> float | None:
        """Return the frequency [Hz] at which the magnitude falls to 1/sqrt(2), or None."""
        indices_below = np.flatnonzero(self.magnitude < 2**-0.5)
        if not len(indices_below):
            return None
        i = int(indices_below[0])
        if i == 0:
            return float(self.frequency[0])
        a, b = np.log(self.magnitude[i - 1 : i + 1])
        part = (np.log(2**-0.5) - a) / (b - a)
        low, high = np.log(self.frequency[i - 1 : i + 1])
        return float(np.exp(low + part * (high - low)))


def bode_response(
    regulator: Regulator,
    model: Brake,
    *,
    slip: float,
    mean: float,
    amplitude: float,
    frequencies: Sequence[float],
    **how: Any,
) -> Bode:
    """Return the response to a sinusoidal target force [N] about a mean, at one slip [m].

    The fit uses the last cycles and is valid for this amplitude only, because a pump is limited and
    works in one direction. The options `how` are passed to `follow`.
    """
    ratios = []
    dt = regulator.sample_time
    for frequency in frequencies:
        settle = 4 * regulator.plant.time_constant(0.5 * regulator.plant.top)
        count = round((settle + CYCLES / frequency) / dt)
        time = np.arange(count) * dt
        turn = 2 * np.pi * frequency * time
        run = follow(regulator, model, mean + amplitude * np.sin(turn), np.full(count, slip), **how)
        is_late = time >= time[-1] - (CYCLES / 2) / frequency
        basis = np.column_stack([np.sin(turn), np.cos(turn), np.ones(count)])[is_late]
        (real, imaginary, _), *_ = np.linalg.lstsq(basis, run.force[is_late], rcond=None)
        ratios.append(complex(real, imaginary) / amplitude)
    response = np.array(ratios)
    phase = np.degrees(np.unwrap(np.angle(response)))
    return Bode(np.asarray(frequencies, float), np.abs(response), phase)


def rehabilitation(time: Any, *, low: float, high: float, period: float) -> Any:
    """Return a profile of resistance [N]: rise, hold, fall and rest, each a quarter of the time.

    The shape was invented for tests and has no clinical basis.
    """
    phase = (time / period) % 1.0
    rise = 0.5 - 0.5 * np.cos(np.pi * np.clip(4 * phase, 0, 1))
    fall = 0.5 + 0.5 * np.cos(np.pi * np.clip(4 * phase - 2, 0, 1))
    return low + (high - low) * np.where(phase < 0.5, rise, fall)
