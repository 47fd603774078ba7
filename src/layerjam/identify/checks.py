"""The verdict a fit carries: whether its numbers deserve belief, in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.device.brake import Brake
from layerjam.units import show

PLAUSIBLE = (0.5, 2.0)
"""Scale factors beyond this are suspect; the paper's are 0.875 and 1.24."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One check: its name, whether it passed, and the sentence that says why."""

    name: str
    passed: bool
    sentence: str


def identifiable(brake: Brake) -> Check:
    """Peaks give the product of scale factor and friction, never either alone."""
    return Check(
        name="identifiable",
        passed=True,
        sentence="a peak fixes only the product of scale factor and kinetic friction; the factor "
        f"holds together with the friction it was fitted with, {brake.film.kinetic:.4g}",
    )


def plausible(factor: float) -> Check:
    """The scale factor lies where one expects it."""
    low, high = PLAUSIBLE
    fine = low <= factor <= high
    sentence = f"scale factor {factor:.4g} lies {'within' if fine else 'outside'} {low} to {high}"
    if not fine:
        sentence += ": check friction, vacuum and the number of sheets of the file"
    return Check(name="plausible", passed=fine, sentence=sentence)


def stiffness_possible(stiffness: float, sheets_alone: float) -> Check:
    """A rig in series cannot make the sheets stiffer."""
    fine = stiffness <= sheets_alone
    word = "below" if fine else "above"
    sentence = (
        f"measured stiffness {show(stiffness, 'N/m')} is {word} the sheets' own, "
        f"{show(sheets_alone, 'N/m')}"
    )
    if not fine:
        sentence += ": the film's modulus or the elongation's unit is wrong"
    return Check(name="stiffness", passed=fine, sentence=sentence)


def agreement(factors: Sequence[float], errors: Sequence[float]) -> Check:
    """Pulls agree with each other within 5 % or three of their own standard errors."""
    values = np.asarray(factors)
    if len(values) < 2:
        return Check(
            name="repeats",
            passed=False,
            sentence="one pull only: nothing says how well it repeats",
        )
    spread = float(values.std(ddof=1) / values.mean())
    within = max(0.05, 3 * float(np.mean(errors)) / float(values.mean()))
    return Check(
        name="repeats",
        passed=spread <= within,
        sentence=f"scale factors of {len(values)} pulls scatter by {spread:.1%} (SD)",
    )


def no_trend(values: Sequence[float], over: Sequence[float], what: str, unit: str) -> Check | None:
    """The scale factor does not drift with vacuum; None with fewer than three distinct values."""
    x, y = np.asarray(over, dtype=float), np.asarray(values, dtype=float)
    if len(np.unique(x)) < 3:
        return None
    slope, level = np.polyfit(x - x.mean(), y, 1)
    change = float(slope * np.ptp(x) / level)
    rest = y - level - slope * (x - x.mean())
    freedom = max(len(x) - 2, 1)
    error = np.sqrt((rest**2).sum() / freedom / ((x - x.mean()) ** 2).sum())
    fine = abs(change) < 0.05 or abs(slope) < 2.5 * error
    sentence = (
        f"over {what} from {show(x.min(), unit)} to {show(x.max(), unit)} the scale factor "
        f"changes by {change:+.1%}"
    )
    return Check(name=f"trend over {what}", passed=bool(fine), sentence=sentence)


def end_of_curve(predicted: float, measured: float) -> Check:
    """The calibrated law also meets the end of the curve, not only the peak it was fitted to."""
    off = (predicted - measured) / measured if measured > 0 else np.inf
    return Check(
        name="shape",
        passed=bool(abs(off) <= 0.15),
        sentence=f"at the end of the pulls the calibrated law is {off:+.1%} off the measured force",
    )
