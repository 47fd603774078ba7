"""Mountings that pulls share, and the scatter between mountings that a campaign does not show.

Pulls of one mounting share its friction and its grips, so they do not scatter independently. If the
sidecars state three or more mountings, intervals use the scatter between them. Fewer do not show
it, and pulls without a stated mounting may all share one. Intervals then include `SCATTER`, or the
scatter seen if that is larger. Mountings that resemble the one before are not independent either:
intervals then include their scatter in full, as if they were one.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from layerjam.core.errors import count_text
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import Check, check
from layerjam.laboratory.identify.order import correlate_neighbours, find_order
from layerjam.laboratory.identify.shape import SHAPE

SCATTER: Mapping[str, float] = dict(zip(SHAPE, (0.05, 0.05, 0.1), strict=True))
"""{value: relative standard deviation between mountings}, if the pulls do not show it.

The friction of a film scatters by 3 to 8 % between tests (Choi 2018, table I).
"""
FEWEST = 3
"""Minimum number of mountings that show their scatter: Student's t of two is 12.7."""
FEWEST_ALIKE = 6
"""Minimum number of mountings that are compared with the one before."""
ALIKE = 0.35
"""Fraction of campaigns with independent mountings whose intervals may include the full scatter.

A smaller one leaves the interval too narrow if each pull resembles the last: at a correlation of
0.8, twelve pulls show it in nine of ten campaigns.
"""


class Mountings(NamedTuple):
    """Indices of the curves in each mounting, and the check that states the assumption.

    `unseen` {value: relative standard uncertainty} is due to the scatter between mountings that
    these groups do not show, and `reason` states why they do not; `supply` states what would show
    it. All are empty if enough independent mountings are stated.
    """

    groups: tuple[tuple[int, ...], ...]
    check: Check
    unseen: Mapping[str, float]
    reason: str = ""
    supply: str = ""


def find_mountings(curves: Sequence[Curve], logs: np.ndarray) -> Mountings:
    """Return the mountings on which intervals are based.

    `logs` (curves, m) are logs of each curve's own scale factor, stiffness, ..., relative to the
    law; NaN if unknown.
    """
    labels = [c.mounting for c in curves]
    groups = _label_indices(labels) if None not in labels else ()
    if len(groups) >= FEWEST:
        ending = "each pull has its own" if len(groups) == len(curves) else "some pulls share one"
        sentence = f"{len(groups)} mountings, as stated in the sidecars; {ending}"
        unseen = _scatter_of_neighbours(curves, logs, groups)
        if (sd := unseen.get(SHAPE[0])) is not None:
            sentence += (
                "; successive ones resemble each other, so the intervals include their full "
                f"scatter of {sd:.1%} (SD)"
            )
        reason = "successive mountings resemble each other" if unseen else ""
        return Mountings(groups, check("mountings", True, sentence), unseen, reason)
    singles = tuple((place,) for place in range(len(curves)))
    start = f"the sidecars state only {count_text(len(groups), 'mounting')}"
    if not groups:
        has_label = any(label is not None for label in labels)
        start = "some pulls do not state a mounting" if has_label else "no mounting is stated"
        start += f", so {count_text(len(curves), 'pull')} may share one"
    spreads = _scatter_of_means(logs, groups if len(groups) > 1 else singles)
    sds = {name: max(sd, spreads.get(name, 0.0)) for name, sd in SCATTER.items()}
    sentence = (
        f"{start}: the intervals include a scatter of {sds[SHAPE[0]]:.1%} (SD) between mountings. "
        f"For narrower ones, mount the brake at least {FEWEST} times and state mounting in the "
        "sidecars"
    )
    unseen = {name: sd / max(len(groups), 1) ** 0.5 for name, sd in sds.items()}
    return Mountings(
        singles,
        check("mountings", True, sentence),
        unseen,
        "too few mountings are stated",
        "mounting in the sidecars of pulls of several mountings",
    )


def _scatter_of_neighbours(
    curves: Sequence[Curve], logs: np.ndarray, groups: Sequence[Sequence[int]]
) -> dict[str, float]:
    """Return {value: scatter of the groups' means}, of values that resemble the one before."""
    if len(groups) < FEWEST_ALIKE:
        return {}
    ranks = np.argsort(find_order([curve.name for curve in curves], curves).places)
    sequence = sorted(groups, key=lambda group: min(ranks[place] for place in group))
    unseen = {}
    for name, column in zip(SCATTER, logs.T, strict=False):
        means = _list_means(column, sequence)
        if len(means) >= FEWEST_ALIKE and correlate_neighbours(np.array(means), ALIKE)[1]:
            unseen[name] = float(np.std(means, ddof=1))
    return unseen


def _scatter_of_means(logs: np.ndarray, groups: Sequence[Sequence[int]]) -> dict[str, float]:
    """Return {value: standard deviation of the groups' means}, as far as they are known."""
    spreads = {}
    for name, column in zip(SCATTER, logs.T, strict=False):
        means = _list_means(column, groups)
        spreads[name] = float(np.std(means, ddof=1)) if len(means) > 1 else 0.0
    return spreads


def _list_means(column: np.ndarray, groups: Sequence[Sequence[int]]) -> list[float]:
    """Return the means of the groups' known values."""
    parts = [column[list(g)][np.isfinite(column[list(g)])] for g in groups]
    return [float(part.mean()) for part in parts if len(part)]


def _label_indices(labels: Sequence[int | None]) -> tuple[tuple[int, ...], ...]:
    """Return the indices of each label, in order of first appearance."""
    places_of: dict[int | None, list[int]] = {}
    for place, label in enumerate(labels):
        places_of.setdefault(label, []).append(place)
    return tuple(tuple(places) for places in places_of.values())
