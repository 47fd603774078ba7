"""Which pulls share a mounting: as the sidecars state it, or as the pulls' scatter shows it.

Pulls of one mounting share its friction and its grips, so that they do not scatter independently.
Intervals rest on the means of mountings. If no mounting is known, the scatter between candidate
groups is compared with that within them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import special

from layerjam.identify.checks import Check, check
from layerjam.identify.curves import Curve, conditions, numbered

POOLED, POOLED_TWO = 0.25, 0.05
"""Probability above which three and more candidate groups, or two, count as chance: intervals then
take every pull by itself. It is large because a group that is missed makes intervals too narrow;
for two it is less, because Student's t of two means is 12.7."""
ALIKE = 0.005
"""Probability below which pulls of one candidate group are alike beyond doubt."""
TINY = 1e-6
"""Relative scatter below which pulls do not differ at all."""


class Mountings(NamedTuple):
    """The places of the curves of each mounting, and the check that states what is assumed."""

    groups: tuple[tuple[int, ...], ...]
    check: Check


def find_mountings(curves: Sequence[Curve], logs: np.ndarray) -> Mountings:
    """Return the mountings that intervals rest on.

    `logs` (curves, m) are values of each curve alone, as logarithms relative to the law; NaN where
    a curve does not tell one.
    """
    alone = tuple((place,) for place in range(len(curves)))
    stated = [c.mounting for c in curves]
    if None not in stated and len(set(stated)) > 1:
        groups = _members(stated)
        each = "each pull has its own" if len(groups) == len(curves) else "pulls of one share it"
        sentence = f"{len(groups)} mountings, as the sidecars state them; {each}"
        return Mountings(groups, check("mountings", True, sentence))
    known = "no mounting is stated"
    if stated.count(None) < len(stated):
        known = "some pulls state no" if None in stated else "all pulls state one"
        known += " mounting"
    order = [c.repeat for c in numbered(curves)]
    chance = _chance(logs, order, curves)
    advice = "; state mounting or repeat in the sidecars"
    groups = _members(order)
    if chance is None or chance > (POOLED if len(groups) > 2 else POOLED_TWO):
        found = "" if chance is None else f": the pulls' scatter shows none (p = {chance:.2g})"
        sentence = f"{known}{found}; intervals take every pull as mounted by itself"
        return Mountings(alone, check("mountings", True, sentence))
    sentence = (
        f"{known}; the first, second, ... pulls of each vacuum and speed are alike (p = "
        f"{chance:.2g}): intervals take them as {len(groups)} mountings"
    )
    return Mountings(groups, check("mountings", chance > ALIKE, sentence, advice))


def _members(labels: Sequence[int | None]) -> tuple[tuple[int, ...], ...]:
    """The places of each label, in the order in which labels first appear."""
    found: dict[int | None, list[int]] = {}
    for place, label in enumerate(labels):
        found.setdefault(label, []).append(place)
    return tuple(tuple(places) for places in found.values())


def _chance(logs: np.ndarray, order: Sequence[int | None], curves: Sequence[Curve]) -> float | None:
    """Probability of such a scatter between groups if pulls are independent; None if unknown.

    Fisher's F of the groups, the conditions' means taken out; the least over the columns times
    their number (Bonferroni).
    """
    condition = np.zeros(len(curves), int)
    for number, places in enumerate(conditions(curves)):
        condition[list(places)] = number
    found = []
    for column in logs.T:
        told = np.isfinite(column)
        y, base = column[told], _columns(condition[told])
        group = _columns(np.asarray(order)[told])
        rest = [_left(y, x) for x in (base, np.hstack([base, group]))]
        (before, free), (after, freedom) = rest
        if freedom < 1 or free == freedom or not before > len(y) * TINY**2:
            continue
        ratio = (before - after) / (free - freedom) / max(after / freedom, TINY**2)
        found.append(float(special.fdtrc(free - freedom, freedom, ratio)))
    return min(1.0, len(found) * min(found)) if found else None


def _columns(labels: np.ndarray) -> np.ndarray:
    return np.asarray(labels[:, None] == np.unique(labels)[None], float)


def _left(y: np.ndarray, x: np.ndarray) -> tuple[float, int]:
    """Sum of squares that least squares leaves, and its degrees of freedom."""
    fitted, _, rank, _ = np.linalg.lstsq(x, y, rcond=None)
    return float(((y - x @ fitted) ** 2).sum()), len(y) - int(rank)
