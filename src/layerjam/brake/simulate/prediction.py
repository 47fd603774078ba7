"""The one place that turns a brake with uncertain numbers and a law into intervals and a basis.

A brake's uncertain numbers are replaced by samples, the law is evaluated for all of them at once,
and quantiles of its values are the interval. Samples are a Latin hypercube: each independent
deviation takes every quantile once, so intervals need few samples and never change between runs.
"""

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile, list_changes
from layerjam.brake.device.evidence import NUMBERS, RANGES, Evidence
from layerjam.brake.device.spread import (
    SPEED_SD,
    TEST_SPEED,
    TEST_VACUUM,
    Unknown,
    exponent_sd,
    find_borrowed_fit,
    join_alike,
    list_unknowns,
)
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.enclosure import enclosure_stretch
from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.errors import Notice
from layerjam.core.evolve import evolve
from layerjam.core.units import show

Array = npt.NDArray[np.float64]
LEVEL = 0.95
SAMPLES, FEWEST_SAMPLES = 1000, 40
MOST_ELEMENTS = 2_000_000
"""Number of samples times elements of an array up to which all `SAMPLES` are drawn."""
SEED = 2018
HUGE, FARTHEST = 1e300, 50.0
"""Values that count as infinite, and the largest deviation of a logarithm: e^50 is 5e21."""
LEAST_VACUUM, LEAST_SPEED = 1.0, 1e-6
"""Vacuum [Pa] and speed [m/s] below which friction changes no further."""
TOLERANCE = 0.1
"""Relative distance from the tested range within which a condition still counts as tested."""


class Deviations(NamedTuple):
    """Logarithms of the ratios of a brake's numbers to those in its file.

    `enclosure_force` multiplies the modulus of the enclosure and its friction alike.
    """

    scale_factor: Any
    stiffness_measured: Any
    enclosure_force: Any
    static: Any
    kinetic: Any


class Extrapolation(NamedTuple):
    """A condition outside the tested range, with the ends of that range, in SI."""

    quantity: str
    value: float
    low: float
    high: float

    def sentence(self) -> str:
        """Return such as "vacuum 11 kPa; tested from 55 kPa to 65 kPa"."""
        unit = RANGES[self.quantity].unit
        low, high = show(self.low, unit), show(self.high, unit)
        span = f"at {low}" if low == high else f"from {low} to {high}"
        return f"{self.quantity} {show(self.value, unit)}; tested {span}"


@dataclass(frozen=True)
class Basis:
    """Basis of a prediction, as a word: `tested`, `extrapolated` or `handbook`.

    `extrapolations` lists the conditions outside the tested range; `reason` explains the word.
    """

    word: str
    reason: str = ""
    extrapolations: tuple[Extrapolation, ...] = ()

    def sentence(self) -> str:
        """Return the word with its reason."""
        return f"{self.word}: {self.reason}" if self.reason else self.word


@dataclass(frozen=True)
class Prediction:
    """Intervals and basis of a prediction for a brake at certain conditions.

    `vacuum`, `slip` and `speed` are those of the prediction in SI, numbers or arrays, or None if
    they do not matter. With `of_mean`, intervals are those of the mean of many tests; otherwise
    those of the next test, which include the scatter between tests and mountings. `device` is the
    brake of the file as it is used, if a condition changes its numbers.
    """

    file: BrakeFile
    vacuum: float | Array | None = None
    slip: float | Array | None = None
    speed: float | Array | None = None
    device: Brake | None = None
    of_mean: bool = False
    samples: int = SAMPLES
    seed: int = SEED
    unknowns: tuple[Unknown, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        # the mean has the draws of the next test without its scatter, so its intervals lie inside
        unknowns = (
            unknown._replace(root=0.0 * unknown.root)
            if unknown.further and self.of_mean
            else unknown
            for unknown in list_unknowns(self.file)
        )
        object.__setattr__(self, "unknowns", join_alike(unknowns))
        size = max(np.size(0.0 if v is None else v) for v in self._conditions.values())
        fewer = max(min(self.samples, MOST_ELEMENTS // size), FEWEST_SAMPLES)
        object.__setattr__(self, "samples", fewer)

    @property
    def _conditions(self) -> dict[str, float | Array | None]:
        """Conditions {quantity: value}, with the part of the vacuum that presses the sheets."""
        share = (self.device or self.file.brake).vacuum_share
        vacuum = self.vacuum if share is None or self.vacuum is None else share * self.vacuum
        return {"vacuum": vacuum, "slip": self.slip, "speed": self.speed}

    @functools.cached_property
    def basis(self) -> Basis:
        """Basis of the prediction."""
        fit, specimens = (self.file.valid_evidence(c) for c in ("calibrate", "enclosure"))
        ranges = list(_find_beyond(self._conditions, fit))
        # pulls of the brake stretch its enclosure too
        if fit is None or any(extrapolation.quantity == "slip" for extrapolation in ranges):
            ranges += _find_beyond({"strain": self._find_strain(specimens)}, specimens)
        cases = tuple(ranges)
        reasons = "; ".join(b.sentence() for b in cases)
        if fit is None:
            basis = _find_handbook_basis(self.file)
            reason = "; ".join(filter(None, (basis.reason, reasons)))
            return replace(basis, reason=reason, extrapolations=cases)
        return Basis("extrapolated", reasons, cases) if cases else Basis("tested")

    def _find_strain(self, specimens: Evidence | None) -> Array | None:
        """Return the strain at the enclosure's end; None without tests of it, or slip or vacuum."""
        if specimens is None or self.vacuum is None or self.slip is None:
            return None
        brake = self.device or self.file.brake
        return np.asarray(enclosure_stretch(self.slip, self.vacuum, brake))

    def is_tested(self) -> Any:
        """Return where the conditions lie within the tested range; True without tests."""
        fit, inside = self.file.valid_evidence("calibrate"), np.array(True)
        for name, (low, high) in ({} if fit is None else fit.ranges).items():
            value = self._conditions.get(name)
            if value is not None:
                inside = (
                    inside & (value >= low * (1 - TOLERANCE)) & (value <= high * (1 + TOLERANCE))
                )
        return inside

    @functools.cached_property
    def brakes(self) -> Brake:
        """The brake with samples of its uncertain numbers along a new first axis."""
        return change_numbers(self.device or self.file.brake, self.deviations)

    @functools.cached_property
    def deviations(self) -> Deviations:
        """Samples of the deviations of the brake's numbers along a new first axis."""
        dims = max(np.ndim(0.0 if v is None else v) for v in self._conditions.values())
        shape = (-1, *[1] * dims)
        # numbers without an uncertainty get the axis of the samples too
        none = np.zeros((self.samples, *[1] * dims))
        logs: dict[str, Any] = dict.fromkeys((*NUMBERS, "speed_slope"), none)
        count = sum(len(unknown.names) for unknown in self.unknowns)
        levels = iter(draw_levels(self.samples, count + 2, self.seed).T)
        for unknown in self.unknowns:
            units = [find_quantiles(next(levels), nu) for nu in unknown.degrees]
            shifts = unknown.shift or (0.0,) * len(unknown.names)
            for name, move, shift in zip(
                unknown.names, unknown.root @ np.array(units), shifts, strict=True
            ):
                logs[name] = logs[name] + (move + shift).reshape(shape)
        fit = self.file.valid_evidence("calibrate")
        if fit is None or "pressure_exponent" not in fit.names:
            exponent = exponent_sd(fit) * find_quantiles(next(levels))
            logs["pressure_exponent"] = exponent.reshape(shape)
        if not depends_on_speed(self.file.brake):
            logs["speed_slope"] = (SPEED_SD * find_quantiles(next(levels))).reshape(shape)
        logs["scale_factor"] = logs["scale_factor"] + self._friction_beyond(fit, logs)
        logs = {name.removeprefix("film."): value for name, value in logs.items()}
        logs = {name: np.clip(logs[name], -FARTHEST, FARTHEST) for name in Deviations._fields}
        return Deviations(**logs)

    def _friction_beyond(self, fit: Evidence | None, logs: Mapping[str, Any]) -> Any:
        """Return the change of ln(friction) from the conditions of the tests to these conditions.

        Between the tests and a vacuum, ln(friction) changes by the uncertain exponent times the
        logarithm of their ratio; beyond the tested speeds by an uncertain slope per decade. Without
        tests, the conditions are full vacuum and the speed of usual tests.
        """
        change = 0.0
        ranges: Mapping[str, tuple[float, float]] = (
            {"vacuum": (TEST_VACUUM, TEST_VACUUM), "speed": (TEST_SPEED, TEST_SPEED)}
            if fit is None
            else fit.ranges
        )
        vacuum, speed = (self._conditions[name] for name in ("vacuum", "speed"))
        if vacuum is not None and (ends := ranges.get("vacuum")):
            low, high = (max(end, LEAST_VACUUM) for end in ends)
            reference = (fit.reference_pressure if fit else None) or math.sqrt(low * high)
            # without a vacuum there is no friction to be uncertain
            level = np.where(np.asarray(vacuum) > 0, vacuum, reference)
            change = change + logs["pressure_exponent"] * np.log(level / reference)
        if speed is not None and (ends := ranges.get("speed")):
            pace = np.maximum(speed, LEAST_SPEED)
            low, high = (max(end, LEAST_SPEED) for end in ends)
            change = change + logs["speed_slope"] * np.log10(pace / np.clip(pace, low, high))
        return change

    def interval(self, values: Any) -> dict[str, Any]:
        """Return the 95 % interval of values with the samples along their first axis.

        An end is None if more samples than the level allows have no finite value. Use +-inf for
        values that are beyond every bound, not NaN.
        """
        low, high = self.quantiles(values, ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
        return {"low": _finite(low), "high": _finite(high), "level": LEVEL, "of": self.subject}

    @property
    def subject(self) -> str:
        """Content of the intervals: the mean of many tests, or the next test."""
        return "mean" if self.of_mean else "next test"

    @staticmethod
    def quantiles(values: Any, levels: Sequence[float] | float) -> Any:
        """Return quantiles of values with the samples along their first axis, inf included."""
        values = np.clip(np.asarray(values, float), -HUGE, HUGE)
        ends = np.quantile(values, levels, axis=0, method="hazen")
        return np.where(ends > HUGE / 2, np.inf, np.where(ends < -HUGE / 2, -np.inf, ends))

    def notices(self) -> list[Notice]:
        """Return notices if the brake is not the one to which its numbers were fitted."""
        return [*self.file.change_notices(), *list_borrowed_notices(self.file)]

    def state(self, **values: Any) -> dict[str, Any]:
        """Return the fields of a `PredictionResult`, from samples of its numbers by name."""
        return {
            "intervals": {name: self.interval(samples) for name, samples in values.items()},
            "basis": self.basis.word,
            "basis_reason": self.basis.reason,
            "extrapolated": [condition._asdict() for condition in self.basis.extrapolations],
        }


def list_borrowed_notices(file: BrakeFile) -> Iterator[Notice]:
    """Yield a notice if the scale factor was fitted to a different brake of the catalogue."""
    fit = find_borrowed_fit(file)
    if fit is not None:
        name, changes = fit
        differences = list_changes(changes)
        yield Notice(
            f"the scale factor of {file.name} was fitted to {name}, a different brake "
            f"({differences}), and counts as not fitted; test your brake and calibrate it",
            "borrowed-fit",
        )


def _find_beyond(
    conditions: Mapping[str, float | Array | None], tests: Evidence | None
) -> Iterator[Extrapolation]:
    """Yield the conditions {quantity: value} outside the range of some tests."""
    for name, (low, high) in ({} if tests is None else tests.ranges).items():
        value = conditions.get(name)
        if value is None or not np.isfinite(value).any():
            continue
        for end, is_beyond in (
            (float(np.nanmin(value)), np.nanmin(value) < low * (1 - TOLERANCE)),
            (float(np.nanmax(value)), np.nanmax(value) > high * (1 + TOLERANCE)),
        ):
            if is_beyond:
                yield Extrapolation(name, end, low, high)
                break


def _finite(end: Any) -> Any:
    """Return an end of an interval as a number, None or an array."""
    if np.ndim(end):
        return end
    return float(end) if np.isfinite(end) else None


def _find_handbook_basis(file: BrakeFile) -> Basis:
    """Return the basis of a brake without valid tests, with what changed since the last ones."""
    if file.is_changed:
        return Basis("handbook", "changed since its tests")
    if file.is_calibrated and file.sources["scale_factor"].kind in ("calibrated", "synthetic"):
        reason = "the file does not state where it was tested; calibrate it again"
        return Basis("handbook", reason)
    if file.valid_evidence("friction") is not None:
        return Basis("handbook", "only the friction of its film was tested, no pull of the brake")
    return Basis("handbook", "no test of this brake")


@functools.lru_cache(4)
def draw_levels(samples: int, columns: int, seed: int) -> Array:
    """Return a Latin hypercube (samples, columns): each column has each quantile once."""
    random = np.random.Generator(np.random.Philox(seed))
    order = np.argsort(random.random((samples, columns)), axis=0)
    return np.asarray((order + 0.5) / samples)


def find_quantiles(levels: Array, degrees: float = math.inf) -> Array:
    """Return the quantiles of a standard normal, or of Student's t for its degrees of freedom.

    `levels` are those of `draw_levels`, in any order.
    """
    count = len(levels)
    return _tabulate_quantiles(count, degrees)[np.rint(levels * count - 0.5).astype(int)]


@functools.lru_cache(32)
def _tabulate_quantiles(count: int, degrees: float) -> Array:
    levels = (np.arange(count) + 0.5) / count
    if math.isfinite(degrees):
        from scipy.special import stdtrit

        return np.asarray(stdtrit(degrees, levels))
    return np.array([NormalDist().inv_cdf(level) for level in levels])


def log_normal(normal: Array, mean: float, sd: float) -> Array:
    """Return the values of a log-normal quantity for values of a standard normal one."""
    width = np.sqrt(np.log1p((sd / mean) ** 2)) if sd else 0.0
    return np.asarray(mean * np.exp(width * normal - width**2 / 2))


def change_numbers(brake: Brake, deviations: Deviations | None) -> Brake:
    """Return the brake with numbers multiplied by the exponentials of deviations, if there are any.

    Arrays of JAX are allowed.
    """
    if deviations is None:
        return brake
    scale, stiffness, enclosure, static, kinetic = map(xp.exp, deviations)
    film = evolve(
        brake.film,
        static=brake.film.static * static,
        kinetic=brake.film.kinetic * kinetic,
        friction_on_silicone=brake.film.friction_on_silicone * enclosure,
    )
    return evolve(
        brake,
        film=film,
        scale_factor=brake.scale_factor * scale,
        stiffness_measured=working_stiffness(brake) * stiffness,
        enclosure=evolve(brake.enclosure, modulus=brake.enclosure.modulus * enclosure),
    )
