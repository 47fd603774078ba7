"""Validations as tables: several brakes as one result, and rows for JSON, CSV and the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.errors import FitError
from layerjam.identify.checks import Check
from layerjam.identify.repeats import over_repeats
from layerjam.identify.validation.metrics import (
    ConditionError,
    CurveError,
    Split,
    Validation,
    assemble,
)
from layerjam.units import show


def pool(results: Sequence[Validation]) -> Validation:
    """Several brakes' validations as one, such as the paper's two films.

    Each was made with its own brake's model; pulls of different brakes are never repeats of one
    another, also at the same vacuum and speed. Raises FitError without any.
    """
    if not results:
        raise FitError("pool: no validation was given")
    return assemble(
        [condition for result in results for condition in result.conditions],
        [curve for result in results for curve in result.curves],
    )


def file_row(curve: CurveError) -> dict[str, Any]:
    """One pull, SI."""
    return {
        "path": curve.path,
        "vacuum": curve.vacuum,
        "speed": curve.speed,
        "repeat": curve.repeat,
        "mape": curve.mape,
        "rmse": curve.rmse,
        "bias": curve.bias,
        "r_squared": curve.r_squared,
        "points": len(curve.elongation),
        "note": curve.note,
    }


def scatter_row(split: Split | None) -> dict[str, Any] | None:
    """How much of the mean squared error [N^2] is the repeats' own scatter."""
    if split is None:
        return None
    return {
        "mse": split.mse,
        "model_mse": split.model,
        "scatter_mse": split.scatter,
        "share": split.share,
        "repeats": split.repeats,
    }


def condition_row(condition: ConditionError) -> dict[str, Any]:
    """The pulls at one vacuum and speed, SI."""
    return {
        "vacuum": condition.vacuum,
        "speed": condition.speed,
        "repeats": len(condition.curves),
        "mape": condition.mape,
        "mape_sd": condition.mape_sd,
        "rmse": condition.rmse,
        "bias": condition.bias,
        "r_squared": condition.r_squared,
        "scatter": scatter_row(condition.split),
    }


def summary(result: Validation) -> dict[str, Any]:
    """The errors in all and per condition, SI."""
    return {
        "mape": result.mape,
        "mape_sd": result.mape_sd,
        "mape_conditions": result.mape_conditions,
        "mape_conditions_sd": result.mape_conditions_sd,
        "rmse": result.rmse,
        "bias": result.bias,
        "r_squared": result.r_squared,
        "scatter": scatter_row(result.split),
        "conditions": [condition_row(c) for c in result.conditions],
    }


UNITS = {
    "mape": "1",
    "mape_sd": "1",
    "mape_conditions": "1",
    "mape_conditions_sd": "1",
    "rmse": "N",
    "bias": "N",
    "r_squared": "1",
}
"""Of the keys of `summary` that are numbers."""


SMALL = 0.05
"""Part of the measured force below which a bias or a trend is let pass whatever its interval."""


def validation_checks(result: Validation, seen: int) -> tuple[Check, ...]:
    """What the residuals say, in plain words; `seen` pulls were also calibrated on.

    The unit is the pull, not the sample: of each its mean residual relative to its mean force, and
    how far that drifts along the pull; then Student's t over the pulls.
    """
    count = len(result.curves)
    fresh = "the brake names none of these pulls as calibrated on"
    stale = f"{seen} of {count} pulls were also calibrated on: this is a fit, not a test"
    checks = [Check(name="independent", passed=not seen, sentence=stale if seen else fresh)]
    relative = [c.bias / float(c.measured.mean()) for c in result.curves]
    checks.append(_mean_check("bias", relative, "the model is {} off the measured force"))
    drifts = [_drift(c) for c in result.curves]
    checks.append(
        _mean_check("trend over elongation", drifts, "along a pull the residual drifts by {}")
    )
    vacuums = [c.vacuum for c in result.curves]
    checks += _slope_check("vacuum", relative, vacuums, "Pa")
    speeds = [c.speed for c in result.curves if c.speed is not None]
    if len(speeds) == count:
        checks += _slope_check("speed", relative, speeds, "m/s")
    return tuple(checks)


def _drift(curve: CurveError) -> float:
    """Change of the residual's straight line over the window, relative to the mean force."""
    far = curve.elongation - curve.elongation.mean()
    slope = float((far * (curve.model - curve.measured)).sum() / (far**2).sum())
    return slope * float(np.ptp(curve.elongation)) / float(curve.measured.mean())


def _percent(part: float) -> str:
    return f"{part:+.1%}".replace("-0.0%", "+0.0%")


def _mean_check(name: str, values: Sequence[float], words: str) -> Check:
    found = over_repeats(values)
    sentence = words.format(_percent(found.mean))
    if found.low is None or found.high is None:
        return Check(name=name, passed=abs(found.mean) < SMALL, sentence=f"{sentence} (one pull)")
    sentence += (
        f" (95 % interval {_percent(found.low)} to {_percent(found.high)}, {len(values)} pulls)"
    )
    holds_zero = found.low <= 0 <= found.high
    return Check(name=name, passed=holds_zero or abs(found.mean) < SMALL, sentence=sentence)


def _slope_check(
    what: str, relative: Sequence[float], over: Sequence[float], unit: str
) -> list[Check]:
    """Whether the relative residual changes over the conditions; none where they are alike."""
    from scipy.special import stdtrit

    x, y = np.asarray(over), np.asarray(relative)
    if len(y) < 3 or not np.ptp(x) > 0.05 * float(x.max()):
        return []
    off = x - x.mean()
    slope = float((off * y).sum() / (off**2).sum())
    rest = y - y.mean() - slope * off
    error = float(np.sqrt((rest**2).sum() / (len(y) - 2) / (off**2).sum()))
    span = float(np.ptp(x))
    change, reach = slope * span, float(stdtrit(len(y) - 2, 0.975)) * error * span
    sentence = (
        f"from {show(float(x.min()), unit, 3)} to {show(float(x.max()), unit, 3)} the residual "
        f"changes by {_percent(change)} (95 % interval {_percent(change - reach)} to "
        f"{_percent(change + reach)})"
    )
    fine = abs(change) < SMALL or abs(change) <= reach
    return [Check(name=f"trend over {what}", passed=fine, sentence=sentence)]
