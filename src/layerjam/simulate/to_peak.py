"""The vacuum, or the number of sheets, with which a pull peaks at a given force.

The pull is a function: the lumped brake, the stack, or anything else whose peak rises.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from layerjam.errors import QuantityError

CLOSE = 1e-9
"""How near the root is found, as a share of the greatest vacuum."""
FEWEST = 2
"""Sheets of a brake at least."""


@dataclass(frozen=True)
class ToPeak:
    """What gives the asked peak, or that nothing does and how near the ends come."""

    value: float | None
    """Vacuum [Pa] or number of sheets; None where none gives the force."""
    force: float
    """Peak there [N]; where there is none, the nearest that can be had."""
    at: float
    """Vacuum [Pa] or sheets with that peak."""


def vacuum_to_peak(peak_at: Callable[[float], float], force: float, most: float) -> ToPeak:
    """The vacuum [Pa], from none to `most`, at which a pull peaks at a force [N].

    `peak_at` is the peak [N] over the vacuum, and rises. Bracketed, then by Brent's method. Raises
    QuantityError for a force that is none.
    """
    from scipy.optimize import brentq

    _check(force)
    low, high = peak_at(0.0), peak_at(most)
    if not low <= force <= high:
        end = 0.0 if force < low else most
        return ToPeak(None, low if force < low else high, end)
    if force in (low, high):
        return ToPeak(0.0 if force == low else most, force, 0.0 if force == low else most)
    root = float(brentq(lambda p: peak_at(p) - force, 0.0, most, xtol=CLOSE * most))
    return ToPeak(root, peak_at(root), root)


def sheets_to_peak(peak_at: Callable[[int], float], force: float, most: int) -> ToPeak:
    """The number of sheets, from two to `most`, whose pull peaks nearest to a force [N].

    `peak_at` is the peak [N] over the number, and rises. A force below the peak of two sheets by
    more than half a step, or above that of `most`, has none. By halving. Raises QuantityError for
    a force that is none.
    """
    _check(force)
    low, high = FEWEST, most
    known = {low: peak_at(low), high: peak_at(high)}
    step = peak_at(low + 1) - known[low]
    if force > known[high]:
        return ToPeak(None, known[high], float(high))
    if force < known[low] - step / 2:
        return ToPeak(None, known[low], float(low))
    while high - low > 1:
        middle = (low + high) // 2
        known[middle] = peak_at(middle)
        low, high = (middle, high) if known[middle] <= force else (low, middle)
    best = min((low, high), key=lambda count: abs(known[count] - force))
    return ToPeak(float(best), known[best], float(best))


def _check(force: float) -> None:
    if not 0 <= force < float("inf"):
        raise QuantityError.of("force", f"{force:g} N is none; a force of 0 N or more is needed")
