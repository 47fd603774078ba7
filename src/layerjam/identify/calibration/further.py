"""What further pulls would do to an interval, and how many reach a wanted one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.identify.calibration.intervals import Population
from layerjam.identify.repeats import LEVEL

SURE = 0.8
"""Chance that as many pulls as `Needed.sure` are enough."""
MOST = 1000
"""Further pulls beyond which nobody asks."""


@dataclass(frozen=True, kw_only=True)
class Needed:
    """How many further pulls of one condition bring an interval to a wanted width.

    `likely` if they scatter just as those at hand, `sure` with a chance of 80 % where it counts
    that the scatter of a few pulls is itself uncertain. None where 1000 are not enough.
    """

    condition: str
    likely: int | None
    sure: int | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Further:
    """The 95 % interval of one value, and what pulls like those at hand add to it.

    A pull of a condition (vacuum and speed) is worth what the pulls at hand there are worth on
    average; how far it scatters is what all pulls at hand say, with their degrees of freedom.
    """

    information: np.ndarray
    """Of all pulls about the shared parameters (q, q), as the weights have it."""
    contrast: np.ndarray
    """The value as a combination (q,) of the parameters."""
    each: Mapping[str, np.ndarray]
    """Of one more pull of each condition (q, q)."""
    scatter: float
    """Standard deviation over the one that the weights assume, of the value over its size."""
    degrees: float
    shared: float = 0.0
    """Standard uncertainty over the value that no further pull makes smaller."""

    def half_width(
        self, condition: str = "", more: int | np.ndarray = 0, chance: float | None = None
    ) -> np.ndarray:
        """Half the interval's width over the value with `more` pulls of a condition.

        `more` broadcasts. `chance`: the width that is not exceeded with it; else as if further
        pulls scattered just as those at hand.
        """
        count = np.asarray(more, float)
        added = self.each[condition] if condition else np.zeros_like(self.information)
        whole = self.information + count[..., None, None] * added
        unit = np.linalg.solve(whole, self.contrast[:, None])[..., 0] @ self.contrast
        total, grown = self.degrees + count, np.ones_like(count)
        if chance is not None:
            # the variance of pulls to come over that of those at hand follows F
            ratio = special.fdtri(np.maximum(count, 1.0), self.degrees, chance)
            grown = (self.degrees + count * ratio) / total
        square = self.scatter**2 * grown * unit
        whole_square = square + self.shared**2
        effective = total * (whole_square / square) ** 2  # Welch and Satterthwaite (GUM, G.4.1)
        # not below the scatter alone, as in `coverage_factor`
        widths = [
            special.stdtrit(degrees, (1 + LEVEL) / 2) * np.sqrt(part)
            for degrees, part in ((effective, whole_square), (total, square))
        ]
        return np.maximum(*widths)

    def after_one(self) -> dict[str, float]:
        """{condition: half the width with one more pull there}, the narrowest first."""
        widths = {condition: float(self.half_width(condition, 1)) for condition in self.each}
        return dict(sorted(widths.items(), key=lambda item: item[1]))

    def needed(self, within: float) -> Needed:
        """How many pulls of the best condition bring half the width to `within` of the value."""
        best = next(iter(self.after_one()))

        def least(chance: float | None) -> int | None:
            enough = self.half_width(best, np.arange(MOST + 1), chance) <= within
            return int(enough.argmax()) if enough.any() else None

        return Needed(condition=best, likely=least(None), sure=least(SURE))


def further(
    population: Population,
    contrasts: Mapping[str, np.ndarray],
    groups: Mapping[str, Sequence[int]],
    sizes: Mapping[str, float],
    shared: Mapping[str, float] | None = None,
    units: Population | None = None,
) -> dict[str, Further | None]:
    """What further pulls would add to each value; None where those at hand give no interval.

    `groups` are the places of the curves of each condition, `sizes` {name: what the interval's
    width is divided by}, one for a value whose logarithm is estimated. `shared` {name: standard
    uncertainty over the value} is what further pulls do not change. `units` is the population of
    the mountings, if pulls share one; a further pull is then taken as mounted anew.
    """
    information = population.information
    whole = information.sum(axis=0)
    each = {words: information[list(places)].mean(axis=0) for words, places in groups.items()}
    made: dict[str, Further | None] = {}
    for name, contrast in contrasts.items():
        found = (units or population).standard_error(contrast)
        if found is None or not found[0] > 0:
            made[name] = None
            continue
        unit = float(np.sqrt(contrast @ np.linalg.solve(whole, contrast)))
        made[name] = Further(
            information=whole,
            contrast=contrast,
            each=each,
            scatter=found[0] / unit / abs(sizes[name]),
            degrees=found[1],
            shared=(shared or {}).get(name, 0.0),
        )
    return made
