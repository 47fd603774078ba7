"""How far a model's curve lies from a measured one: MAPE and RMSE over a written window.

The window: the loading branch from the peak to the end, 200 points equally spaced in elongation,
those with a measured force of at least 5 % of the peak (a relative error means nothing near zero
force). A pull without a peak is taken from where it has bent off its straight rise, or whole where
it has none (low or no vacuum), and says so. Both curves start where the straight line before onset
meets zero force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FileError, FitError
from layerjam.identify.pull import PullFeatures
from layerjam.mechanics.pull import force_at_elongation

POINTS = 200
FLOOR = 0.05


@dataclass(frozen=True, kw_only=True)
class CurveError:
    """One measured pull against the model; arrays have shape (M,), M <= 200."""

    mape: float
    """Mean of |measured - model| / measured [-]."""
    rmse: float
    """[N]"""
    bias: float
    """Mean of model - measured [N]."""
    elongation: np.ndarray
    measured: np.ndarray
    model: np.ndarray
    vacuum: float
    path: str
    note: str


def compare(pull: PullFeatures, vacuum: float, brake: Brake) -> CurveError:
    """MAPE [-] and RMSE [N] of the model at `vacuum` [Pa] against one pull, over the window above.

    Raises FileError where the record ends at its peak.
    """
    note = ""
    if pull.has_peak:
        start = pull.peak_elongation
    elif not pull.straight or vacuum == 0:
        start = 0.0
        note = "no peak and no straight rise: the window is the whole record"
    else:
        line = pull.stiffness * pull.elongation
        bent = np.flatnonzero(pull.force < 0.9 * line)
        bent = bent[pull.force[bent] > FLOOR * pull.peak_force]
        start = float(pull.elongation[bent[0]]) if len(bent) else np.inf
        note = "no peak: the window starts where the force bends off its straight rise"
    end = float(pull.elongation[-1])
    if not end - start > 1e-6:
        raise FileError(pull.path, "ends at its peak: nothing of the sliding brake to compare")
    points = np.linspace(start, end, POINTS)
    order = np.argsort(pull.elongation, kind="stable")
    measured = np.interp(points, pull.elongation[order], pull.force[order])
    kept = measured >= FLOOR * pull.peak_force
    points, measured = points[kept], measured[kept]
    model = np.asarray(force_at_elongation(points, vacuum, brake))
    if not np.isfinite(model).all():
        raise FitError(f"{pull.path}: the model has no answer there; the brake would snap")
    error = model - measured
    return CurveError(
        mape=float(np.mean(np.abs(error) / measured)),
        rmse=float(np.sqrt(np.mean(error**2))),
        bias=float(error.mean()),
        elongation=points,
        measured=measured,
        model=model,
        vacuum=vacuum,
        path=pull.path,
        note=note,
    )


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Errors over pulls: mean of the files' MAPE [-] with its SD, RMSE [N] of all points."""

    mape: float
    mape_sd: float | None
    rmse: float
    curves: tuple[CurveError, ...]


def validate_pulls(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> Validation:
    """Compare a brake with pulls, each given with its vacuum [Pa]; every file counts the same."""
    if not pulls:
        raise FitError("validate: no pull was given")
    curves = tuple(compare(pull, vacuum, brake) for pull, vacuum in pulls)
    mapes = np.array([c.mape for c in curves])
    squares = np.concatenate([(c.model - c.measured) ** 2 for c in curves])
    return Validation(
        mape=float(mapes.mean()),
        mape_sd=float(mapes.std(ddof=1)) if len(mapes) > 1 else None,
        rmse=float(np.sqrt(squares.mean())),
        curves=curves,
    )
