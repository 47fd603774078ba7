"""Probability that a design meets its constraints, for brakes with uncertain numbers.

The samples are those of a `Prediction` for the brake file of the design, so its probabilities agree
with the intervals of `force`, `vacuum` and `tune` for that file. Identical brakes of a design share
their deviations.
"""

import functools
import math
import operator
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.simulate.prediction import SAMPLES, Deviations, Prediction
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.workshop.design.bill import drawn_merits
from layerjam.workshop.design.design_file import compose_design_file
from layerjam.workshop.design.grid import Array, Kernel, Numbers, pad
from layerjam.workshop.design.merit import (
    STOP_MERITS,
    Point,
    StickSlipPull,
    Stock,
    make_point,
    merits,
)
from layerjam.workshop.design.requirements import Constraint, DesignSpecification
from layerjam.workshop.design.stopping import all_merits

FEW = 64
"""Number of samples for each design of a sweep; only the last candidates have all of them."""
SMALL_PIECE, ROUND = 4096, 16
"""Number of stops in one call, and how many of them belong to one design."""
SAMPLED_PIECE = 4096
"""Number of designs whose other merits are computed in one call, with FEW samples of each."""


class Chance(NamedTuple):
    """Probability that a constraint is met."""

    probability: float
    error: float
    """Standard error of the probability for random samples, at least 1/samples."""
    low: float
    """5 % quantile of the quantity [SI]; NaN if more than 5 % of the samples have no value."""
    high: float
    """95 % quantile of the quantity [SI]."""


def predict_design(spec: DesignSpecification, point: Point, film: str) -> Prediction:
    """Return the prediction for one brake of a design, at its vacuum."""
    file = compose_design_file(spec, point, film, "the design")
    count = SAMPLES if spec.scatter is None else spec.scatter.samples
    return _predict_scatter(spec, file, float(point.vacuum), count)


def _predict_scatter(
    spec: DesignSpecification, file: BrakeFile, vacuum: float | None, count: int
) -> Prediction:
    """Return a prediction; a [scatter] of the specification replaces that of the film."""
    if spec.scatter is None:
        return Prediction(file, vacuum, samples=count)
    spreads = {"film.static": spec.scatter.static, "film.kinetic": spec.scatter.kinetic}
    sources = {
        path: Source(kind="measured", text="the specification", sd=sd)
        for path, sd in spreads.items()
        if sd is not None
    }
    others = tuple(entry for entry in file.evidence if entry.command != "friction")
    file = evolve(file, sources={**file.sources, **sources}, evidence=others)
    return Prediction(file, vacuum, samples=count, seed=spec.scatter.seed)


class Assessment(NamedTuple):
    """Samples (n,) of the merits of a design, and the probability that it meets each constraint."""

    design: Mapping[str, Any]
    prediction: Prediction
    samples: Mapping[str, Array]
    """Samples of the merits that depend on uncertain numbers."""
    chances: Mapping[str, Chance]
    """{constraint: Chance} and "all"; empty if there are no constraints."""

    @property
    def probability(self) -> float:
        """Probability that the design meets all constraints."""
        return self.chances["all"].probability if self.chances else 1.0

    def reaches(self, confidence: float) -> bool:
        """Return whether the design meets all constraints with a probability."""
        return self.probability >= confidence - 1e-9

    def state(self) -> dict[str, Any]:
        """Return the fields of a `PredictionResult`."""
        return self.prediction.state(**self.samples)

    def find_margins(self, spec: DesignSpecification) -> dict[str, float]:
        """Return {constraint: factor} by which the average brake must be better than its limit.

        A similar design that is better by these factors meets each constraint with the confidence.
        """
        margins = {}
        for c in spec.constraints:
            if c.name in self.samples:
                level = spec.confidence if c.most else 1 - spec.confidence
                end = float(Prediction.quantiles(self.samples[c.name], level))
                ratio = end / float(self.design[c.name])
                margins[str(c)] = max(ratio if c.most else 1 / ratio, 1.0)
        return {name: factor for name, factor in margins.items() if math.isfinite(factor)}


def assess(
    spec: DesignSpecification, point: Point, design: Mapping[str, Any], of_mean: bool = False
) -> Assessment:
    """Return the probabilities of a design, given with its film, variables and merits.

    With `of_mean`, the scatter between tests is left out.
    """
    prediction = evolve(predict_design(spec, point, str(design["film"])), of_mean=of_mean)
    evaluation, count, logs = spec.evaluation, prediction.samples, prediction.deviations
    base, longest = evaluation.base, spec.grid.max_series
    merits = all_merits(point, base, evaluation.stick_slip, evaluation.stop, longest, logs)
    if evaluation.draw is not None and spec.drawn_merits:
        merits |= drawn_merits(point, base, evaluation.draw, count, logs)
    samples = {n: np.asarray(value, float) for n, value in merits.items() if np.ndim(value)}
    # a mass that does not stop exceeds every slip and force
    samples |= {n: np.nan_to_num(samples[n], nan=np.inf) for n in STOP_MERITS if n in samples}
    all_hold, chances = np.ones(count, bool), dict[str, Chance]()
    for c in spec.constraints:
        value = samples[c.name] if c.name in samples else np.full(count, design[c.name], float)
        is_met = np.asarray(c.is_met(value))
        all_hold &= is_met
        chances[str(c)] = Chance(*_estimate_chance(is_met), *_value_range(value))
    if chances:
        chances["all"] = Chance(*_estimate_chance(all_hold), math.nan, math.nan)
    return Assessment(design, prediction, samples, chances)


def _estimate_chance(holds: Any) -> tuple[float, float]:
    part, count = float(holds.mean()), len(holds)
    return part, max(math.sqrt(part * (1 - part) / count), 1 / count)


def _value_range(value: Any) -> tuple[float, float]:
    ends = Prediction.quantiles(np.where(np.isnan(value), np.inf, value), (0.05, 0.95))
    low, high = (float(end) if math.isfinite(end) else math.nan for end in ends)
    return low, high


class Samples:
    """A few samples of the brakes of each film, for the probabilities of many designs."""

    def __init__(self, spec: DesignSpecification, kernel: Kernel) -> None:
        self.spec, self.kernel = spec, kernel
        films = {name: self._film_deviations(name) for name in dict.fromkeys(spec.grid.names)}
        rows = [films[name] for name in spec.grid.names]
        self.deviations = Deviations(*(np.array(parts) for parts in zip(*rows, strict=True)))
        """Deviations (films, FEW) of each row of the grid's first axis."""

    def _film_deviations(self, film: str) -> Deviations:
        spec, grid = self.spec, self.spec.grid
        row, start = grid.names.index(film), make_point(spec.brake.brake)
        stock = Stock(*(float(column[row]) for column in grid.stock))
        file = compose_design_file(spec, start._replace(stock=stock), film, film)
        others = {name: values for name, values in grid.axes.items() if name != "vacuum"}
        if any((v != getattr(start, n)).any() for n, v in others.items()) or len(grid.names) > 1:
            # pulls of a brake are not valid for designs with other dimensions
            film_tests = tuple(e for e in file.evidence if e.command != "calibrate")
            file = evolve(file, evidence=film_tests)
        return _predict_scatter(spec, file, None, FEW).deviations

    def find_probabilities(self, numbers: Numbers) -> Array:
        """Return the probability that each design meets all constraints.

        Stops are computed for designs that may reach the confidence or be the surest; the
        probability of the others is an upper bound.
        """
        is_met = np.ones((len(numbers), FEW), bool)
        for part in _split(np.arange(len(numbers)), SAMPLED_PIECE):
            films = self.kernel.grid.digits(numbers[part])[0]
            for film in np.unique(films):
                members = part[films == film]
                is_met[members] &= self._check_merits(numbers[members], film)
        rules, bounds, best = self._list_constraints(STOP_MERITS), is_met.mean(axis=1), 0.0
        for part in _split(np.argsort(-bounds, kind="stable"), SMALL_PIECE // ROUND):
            for first in range(0, FEW if rules else 0, ROUND):
                samples = slice(first, first + ROUND)
                live = part[is_met[part].mean(axis=1) >= min(best, self.spec.confidence)]
                films = self.kernel.grid.digits(numbers[live])[0]
                flat = Deviations(*(rows[films, samples].ravel() for rows in self.deviations))
                rows = self.kernel.stops(np.repeat(numbers[live], ROUND), flat)
                for c in rules:
                    values = rows[STOP_MERITS.index(c.name)].reshape(-1, ROUND)
                    is_met[live, samples] &= c.is_met(values)
            best = max(best, float(is_met[part].mean(axis=1).max()))
        return np.asarray(is_met.mean(axis=1))

    def _check_merits(self, numbers: Numbers, film: int) -> npt.NDArray[np.bool_]:
        """Return whether designs with a film meet the constraints, except of the stop, (n, FEW)."""
        is_met = np.ones((len(numbers), FEW), bool)
        evaluation, deviations = self.kernel.evaluation, [row[film] for row in self.deviations]
        if rules := self._list_constraints(self.kernel.names):
            meets = _meet_all(
                self.kernel.grid.point(pad(numbers)[:, None]),
                evaluation.base,
                evaluation.stick_slip,
                Deviations(*deviations),
                [c.limit for c in rules],
                names=tuple((c.name, c.most) for c in rules),
            )
            is_met &= np.asarray(meets)[: len(numbers)]
        # the amounts of a drawing do not depend on friction
        if rules := self._list_constraints(("buildable",)):
            columns = Deviations(*(row[:, None] for row in deviations))
            margins = self.kernel.drawn_merits(numbers, columns)["buildable"].T
            is_met &= functools.reduce(operator.and_, (c.is_met(margins) for c in rules))
        return is_met

    def _list_constraints(self, names: Sequence[str]) -> list[Constraint]:
        return [c for c in self.spec.constraints if c.name in names]


@compiled(static=("names",))
def _meet_all(
    point: Point,
    base: Brake,
    stick_slip: StickSlipPull | None,
    deviations: Deviations,
    limits: Sequence[Any],
    *,
    names: tuple[tuple[str, bool], ...],
) -> Any:
    """Return whether designs (n, 1) with deviations (m,) meet all limits, (n, m)."""
    out = merits(point, base, stick_slip, deviations)
    rules = [Constraint(*rule, limit) for rule, limit in zip(names, limits, strict=True)]
    return functools.reduce(operator.and_, (c.is_met(out[c.name]) for c in rules))


def _split(places: Numbers, size: int) -> Iterator[Numbers]:
    return (places[i : i + size] for i in range(0, len(places), size))
