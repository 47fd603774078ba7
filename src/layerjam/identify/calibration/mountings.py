"""Mountings that pulls share, known from the sidecars or inferred from the scatter of the pulls.

Pulls of one mounting share its friction and its grips, so they do not scatter independently.
Intervals use the means of mountings. If no mounting is known, the scatter between candidate groups
is compared with that within them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import special

from layerjam.identify.checks import Check, check
from layerjam.identify.curves import Curve, group_conditions, number_repeats

POOLED, POOLED_TWO = 0.25, 0.05
"""Probabilities, for at least three candidate groups and for two, above which their differences are
attributed to chance and intervals treat every pull as independent. The first is large because a
missed group makes intervals too narrow. The second is smaller because Student's t for two means is
12.7."""
ALIKE = 0.005
"""Probability below which the pulls of a candidate group are taken to belong together."""
TINY = 1e-6
"""Relative scatter below which pulls count as identical."""


class Mountings(NamedTuple):
    """Indices of the curves in each mounting, and the check that states the assumption."""

    groups: tuple[tuple[int, ...], ...]
    check: Check


def find_mountings(curves: Sequence[Curve], logs: np.ndarray) -> Mountings:
    """Return the mountings on which intervals are based.

    `logs` (curves, m) are logs of each curve's own values, relative to the law; NaN if unknown.
    """
    singles = tuple((place,) for place in range(len(curves)))
    labels = [c.mounting for c in curves]
    if None not in labels and len(set(labels)) > 1:
        groups = _label_indices(labels)
        ending = "each pull has its own" if len(groups) == len(curves) else "some pulls share one"
        sentence = f"{len(groups)} mountings, as stated in the sidecars; {ending}"
        return Mountings(groups, check("mountings", True, sentence))
    start = "no mounting is stated"
    if labels.count(None) < len(labels):
        start = "some pulls do not state a" if None in labels else "all pulls state one"
        start += " mounting"
    order = [c.repeat for c in number_repeats(curves)]
    chance = _scatter_probability(logs, order, curves)
    advice = "; state mounting or repeat in the sidecars"
    groups = _label_indices(order)
    if chance is None or chance > (POOLED if len(groups) > 2 else POOLED_TWO):
        reason = "" if chance is None else f": their scatter shows no groups (p = {chance:.2g})"
        sentence = f"{start}{reason}; intervals treat every pull as a separate mounting"
        return Mountings(singles, check("mountings", True, sentence))
    sentence = (
        f"{start}; the first, second, ... pulls at each vacuum and speed are alike (p = "
        f"{chance:.2g}): intervals treat them as {len(groups)} mountings"
    )
    return Mountings(groups, check("mountings", chance > ALIKE, sentence, advice))


def _label_indices(labels: Sequence[int | None]) -> tuple[tuple[int, ...], ...]:
    """Return the indices of each label, in order of first appearance."""
    places_of: dict[int | None, list[int]] = {}
    for place, label in enumerate(labels):
        places_of.setdefault(label, []).append(place)
    return tuple(tuple(places) for places in places_of.values())


def _scatter_probability(
    logs: np.ndarray, order: Sequence[int | None], curves: Sequence[Curve]
) -> float | None:
    """Return the probability that groups of independent pulls differ as much, or None.

    It is based on Fisher's F for the groups, after removing the conditions' means: the smallest
    over the columns, times their number (Bonferroni).
    """
    if len(set(order)) < 2:
        return None
    condition = np.zeros(len(curves), int)
    for number, places in enumerate(group_conditions(curves)):
        condition[list(places)] = number
    chances = []
    for column in logs.T:
        is_known = np.isfinite(column)
        y, base = column[is_known], _label_columns(condition[is_known])
        group = _label_columns(np.asarray(order)[is_known])
        fits = [_residual_squares(y, x) for x in (base, np.hstack([base, group]))]
        (before, free), (after, freedom) = fits
        if freedom < 1 or free == freedom or not before > len(y) * TINY**2:
            continue
        ratio = (before - after) / (free - freedom) / max(after / freedom, TINY**2)
        chances.append(float(special.fdtrc(free - freedom, freedom, ratio)))
    return min(1.0, len(chances) * min(chances)) if chances else None


def _label_columns(labels: np.ndarray) -> np.ndarray:
    return np.asarray(labels[:, None] == np.unique(labels)[None], float)


def _residual_squares(y: np.ndarray, x: np.ndarray) -> tuple[float, int]:
    """Return the residual sum of squares of a least-squares fit, and its degrees of freedom."""
    solution, _, rank, _ = np.linalg.lstsq(x, y, rcond=None)
    return float(((y - x @ solution) ** 2).sum()), len(y) - int(rank)
