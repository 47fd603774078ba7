"""Effect of further pulls on an interval, and the number of pulls for a target width."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.identify.calibration.intervals import Population
from layerjam.identify.repeats import LEVEL

SURE = 0.8
"""Probability that `RequiredPulls.sure` further pulls are enough."""
PULL_LIMIT = 1000
"""Largest number of further pulls considered."""


@dataclass(frozen=True, kw_only=True)
class RequiredPulls:
    """Number of further pulls under one condition that narrow an interval to a target width.

    `likely` assumes the scatter of the existing pulls. `sure` is enough with a probability of 80 %,
    given that the scatter of a few pulls is itself uncertain. None if 1000 are not enough.
    """

    condition: str
    likely: int | None
    sure: int | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Further:
    """The 95 % interval of one value, and the effect of further similar pulls on it.

    A further pull has the mean weight of the existing pulls under its condition (vacuum and speed).
    Its scatter is that of all existing pulls, with their degrees of freedom.
    """

    information: np.ndarray
    """Information of all pulls about the shared parameters, from the weights, shape (q, q)."""
    contrast: np.ndarray
    """The value as a linear combination of the parameters, shape (q,)."""
    one_more: Mapping[str, np.ndarray]
    """{condition: information of one more pull}, each of shape (q, q)."""
    scatter: float
    """Ratio of the value's relative standard deviation to the value that the weights assume."""
    degrees: float
    shared: float = 0.0
    """Relative standard uncertainty that further pulls do not reduce."""

    def half_width(
        self, condition: str = "", added_pulls: int | np.ndarray = 0, chance: float | None = None
    ) -> np.ndarray:
        """Return the relative half-width of the interval with `added_pulls` under a condition.

        `added_pulls` broadcasts. With `chance`, it is the half-width not exceeded with that
        probability; otherwise further pulls are assumed to scatter like the existing ones.
        """
        count = np.asarray(added_pulls, float)
        information = self.one_more[condition] if condition else np.zeros_like(self.information)
        total_information = self.information + count[..., None, None] * information
        unit = np.linalg.solve(total_information, self.contrast[:, None])[..., 0] @ self.contrast
        total, growth = self.degrees + count, np.ones_like(count)
        if chance is not None:
            # the ratio of the variances of future and existing pulls follows F
            ratio = special.fdtri(np.maximum(count, 1.0), self.degrees, chance)
            growth = (self.degrees + count * ratio) / total
        square = self.scatter**2 * growth * unit
        whole_square = square + self.shared**2
        effective = total * (whole_square / square) ** 2  # Welch and Satterthwaite (GUM, G.4.1)
        # but not below the scatter alone, as in `coverage_factor`
        widths = [
            special.stdtrit(degrees, (1 + LEVEL) / 2) * np.sqrt(part)
            for degrees, part in ((effective, whole_square), (total, square))
        ]
        return np.maximum(*widths)

    def after_one(self) -> dict[str, float]:
        """Return {condition: half-width with one more pull under it}, narrowest first."""
        widths = {condition: float(self.half_width(condition, 1)) for condition in self.one_more}
        return dict(sorted(widths.items(), key=lambda item: item[1]))

    def required_pulls(self, target: float) -> RequiredPulls:
        """Return the number of pulls under the best condition that reach a target half-width."""
        best = next(iter(self.after_one()))

        def smallest_count(chance: float | None) -> int | None:
            enough = self.half_width(best, np.arange(PULL_LIMIT + 1), chance) <= target
            return int(enough.argmax()) if enough.any() else None

        return RequiredPulls(condition=best, likely=smallest_count(None), sure=smallest_count(SURE))


def predict_further_pulls(
    population: Population,
    contrasts: Mapping[str, np.ndarray],
    groups: Mapping[str, Sequence[int]],
    sizes: Mapping[str, float],
    common: Mapping[str, float] | None = None,
    units: Population | None = None,
) -> dict[str, Further | None]:
    """Return the effect of further pulls on each value; None if it has no interval yet.

    `groups` lists the indices of the curves of each condition. `sizes` {name: divisor of the
    interval's width} is 1 for a value whose logarithm is estimated. `common` {name: relative
    standard uncertainty} does not change with further pulls. `units` is the population of the
    mountings, if pulls share one; a further pull then has a new mounting.
    """
    information = population.information
    total = information.sum(axis=0)
    per_condition = {
        words: information[list(places)].mean(axis=0) for words, places in groups.items()
    }
    results: dict[str, Further | None] = {}
    for name, contrast in contrasts.items():
        error = (units or population).standard_error(contrast)
        if error is None or not error[0] > 0:
            results[name] = None
            continue
        unit = float(np.sqrt(contrast @ np.linalg.solve(total, contrast)))
        results[name] = Further(
            information=total,
            contrast=contrast,
            one_more=per_condition,
            scatter=error[0] / unit / abs(sizes[name]),
            degrees=error[1],
            shared=(common or {}).get(name, 0.0),
        )
    return results
