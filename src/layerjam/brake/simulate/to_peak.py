"""Search for the vacuum, or the number of sheets, that makes a pull peak at a given force.

The pull is a function: the lumped brake, the stack, or any model with a rising peak.
"""

from collections.abc import Callable
from dataclasses import dataclass

from layerjam.core.errors import QuantityError

CLOSE = 1e-9
"""Tolerance of the root, relative to the highest vacuum."""
FEWEST = 2
"""Smallest number of sheets of a brake."""


@dataclass(frozen=True)
class ToPeak:
    """Setting that produces the requested peak, or the nearest possible peak."""

    value: float | None
    """Vacuum [Pa] or number of sheets; None if no value produces the force."""
    force: float
    """Peak at that setting [N], or the nearest possible one."""
    at: float
    """Vacuum [Pa] or number of sheets with that peak."""


def find_vacuum_for_peak(peak_at: Callable[[float], float], force: float, limit: float) -> ToPeak:
    """Return the vacuum [Pa], from zero to `limit`, at which a pull peaks at a force [N].

    `peak_at` returns the peak [N], which rises with the vacuum. The root is bracketed, then found
    by Brent's method. Raises QuantityError for an invalid force.
    """
    from scipy.optimize import brentq

    _check_force(force)
    low, high = peak_at(0.0), peak_at(limit)
    if not low <= force <= high:
        end = 0.0 if force < low else limit
        return ToPeak(None, low if force < low else high, end)
    if force in (low, high):
        return ToPeak(0.0 if force == low else limit, force, 0.0 if force == low else limit)
    root = float(brentq(lambda p: peak_at(p) - force, 0.0, limit, xtol=CLOSE * limit))
    return ToPeak(root, peak_at(root), root)


def find_sheet_count_for_peak(peak_at: Callable[[int], float], force: float, limit: int) -> ToPeak:
    """Return the number of sheets, from two to `limit`, whose pull peaks nearest to a force [N].

    `peak_at` returns the peak [N], which rises with the number. The value is found by bisection. It
    is None if the force is more than half a step below the peak of two sheets, or above the peak of
    `limit` sheets. Raises QuantityError for an invalid force.
    """
    _check_force(force)
    low, high = FEWEST, limit
    peaks = {low: peak_at(low), high: peak_at(high)}
    step = peak_at(low + 1) - peaks[low]
    if force > peaks[high]:
        return ToPeak(None, peaks[high], float(high))
    if force < peaks[low] - step / 2:
        return ToPeak(None, peaks[low], float(low))
    while high - low > 1:
        middle = (low + high) // 2
        peaks[middle] = peak_at(middle)
        low, high = (middle, high) if peaks[middle] <= force else (low, middle)
    best = min((low, high), key=lambda count: abs(peaks[count] - force))
    return ToPeak(float(best), peaks[best], float(best))


def _check_force(force: float) -> None:
    if not 0 <= force < float("inf"):
        raise QuantityError.of("force", f"{force:g} N is not allowed; use 0 N or more")
