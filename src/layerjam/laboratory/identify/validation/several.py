"""Validations as tables: several brakes as one result, and rows for JSON, CSV and the report."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.errors import FitError
from layerjam.core.evolve import evolve
from layerjam.laboratory.identify.calibration.peaks import fit_curves, make_pull_table
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import (
    POSSIBLE,
    SMALL,
    Check,
    check,
    check_span,
    check_trend,
    format_percent,
)
from layerjam.laboratory.identify.pull_checks import check_single_pulls
from layerjam.laboratory.identify.statistics import fit_line, summarise_repeats
from layerjam.laboratory.identify.validation.metrics import (
    CurveError,
    Errors,
    Split,
    Validation,
    pool_curves,
)


def pool(results: Sequence[Validation]) -> Validation:
    """Join the validations of several brakes, such as those of the paper's two films.

    Each is based on its own brake; pulls of different brakes are never repeats. Raises
    FitError if no validation is given.
    """
    if not results:
        raise FitError("pool: no validation was given")
    return pool_curves(
        [condition for result in results for condition in result.conditions],
        [curve for result in results for curve in result.curves],
    )


def add_pull_table(result: Validation, curves: Sequence[Curve], brake: Brake) -> Validation:
    """Return the validation with the table of the single pulls of the same curves."""
    return evolve(result, pulls=make_pull_table(curves, fit_curves(curves, brake), brake))


MODEL_ADVICE = "check the units, the vacuum and whether it is this brake"
_ERRORS = ("rmse", "bias", "r_squared")
FILE = ("path", "vacuum", "speed", "repeat", "mape", *_ERRORS, "points", "note")
CONDITION = ("vacuum", "speed", "mape", "mape_sd", *_ERRORS, "repeats", "scatter")
ALL = ("mape", "mape_sd", "mape_conditions", "mape_conditions_sd", *_ERRORS, "scatter")


def make_error_row(errors: Errors, names: Sequence[str]) -> dict[str, Any]:
    """Return the errors of one pull (`FILE`), a condition (`CONDITION`) or `ALL`, in SI units."""
    values = ((name, getattr(errors, name)) for name in names)
    return {name: asdict(v) if isinstance(v, Split) else v for name, v in values}


def make_error_rows(result: Validation) -> dict[str, Any]:
    """Return the errors of all pulls and of each condition, in SI units."""
    return {
        **make_error_row(result, ALL),
        "conditions": [make_error_row(c, CONDITION) for c in result.conditions],
    }


def check_validation(result: Validation, calibrated_on: int) -> tuple[Check, ...]:
    """Return the checks of the residuals; `calibrated_on` pulls were also used for calibration.

    The unit is the pull, not the sample. Student's t tests the mean residual of each pull, relative
    to its mean force, and the drift of the residual along the pull.
    """
    count = len(result.curves)
    fresh = "none of these pulls was used to calibrate the brake"
    stale = f"{calibrated_on} of {count} pulls were also used for calibration: a fit, not a test"
    relative = np.array([c.bias / float(c.measured.mean()) for c in result.curves])
    drifts = [_residual_drift(c) for c in result.curves]
    vacuums = np.array([c.vacuum for c in result.curves])
    speeds = np.array([c.speed for c in result.curves if c.speed is not None])
    ratio = 1 + float(np.median(relative))
    checks = [
        check("independent", not calibrated_on, stale if calibrated_on else fresh),
        check_span("model", ratio, POSSIBLE, "model over measured force", MODEL_ADVICE, "failed"),
        _check_mean("bias", relative.tolist(), "the model deviates by {} from the measured force"),
        _check_mean("trend over elongation", drifts, "along a pull the residual drifts by {}"),
        check_trend("trend over vacuum", "residual", relative, vacuums, "Pa", levels=2),
    ]
    if len(speeds) == count:
        checks.append(
            check_trend("trend over speed", "residual", relative, speeds, "m/s", levels=2)
        )
    single_checks = check_single_pulls(result.pulls) if result.pulls else ()
    return (*(c for c in checks if c is not None), *single_checks)


def _residual_drift(curve: CurveError) -> float:
    """Return the residual's linear change over the window, relative to the mean force."""
    line = fit_line(curve.elongation, curve.model - curve.measured)
    slope = 0.0 if line is None else line.slope
    return slope * float(np.ptp(curve.elongation)) / float(curve.measured.mean())


def _check_mean(name: str, values: Sequence[float], words: str) -> Check:
    mean = summarise_repeats(values, positive=False)
    sentence, is_small = words.format(format_percent(mean.mean)), abs(mean.mean) < SMALL
    if mean.low is None or mean.high is None:
        return check(name, is_small, f"{sentence} (one pull)")
    low, high = format_percent(mean.low), format_percent(mean.high)
    sentence += f" (95 % interval {low} to {high}, {len(values)} pulls)"
    return check(name, is_small or mean.low <= 0 <= mean.high, sentence)
