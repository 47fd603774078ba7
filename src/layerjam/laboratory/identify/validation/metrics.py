"""Errors of modelled curves relative to measured ones, and the part due to scatter of repeats.

The window is the loading branch from the peak to the end, 200 points equally spaced in elongation,
with a measured force of at least 5 % of the peak (a relative error means nothing near zero force).
For a pull without a peak the window starts where the force departs from its linear rise. Without
such a rise (low or no vacuum) the whole pull is used, and a note says so. Both curves start where
the straight line before onset meets zero force.

Over the points of the window, with y measured and m the model's force:

    MAPE  mean of |m - y| / y
    RMSE  root of the mean of (m - y)^2
    bias  mean of m - y; positive if the model is too strong
    R^2   1 - sum (m - y)^2 / sum (y - mean y)^2; negative if a constant would be better

The mean of y is over the points of the curve, of the condition (pulls at one vacuum and speed) or
of all pulls. The R^2 of all pulls therefore also rewards a correct dependence on vacuum.

The mean squared error of a condition with R >= 2 repeats is split. With e_r(u) the residual of
repeat r at one elongation, their mean e(u) and sample variance s^2(u) = sum (e_r - e)^2 / (R - 1),

    mean square of e_r  =  (e^2 - s^2/R)  +  s^2

exactly. The second part is the scatter between repeats, which no model can remove. The first is the
model's own error. Both are unbiased for any R, because the scatter s^2/R of the mean of few repeats
is subtracted. The first can therefore be negative: the model error is then indistinguishable from
zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.effects import remove_fitted
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.core.brief import brief
from layerjam.core.errors import FileError, FitError
from layerjam.core.evolve import evolve
from layerjam.laboratory.identify.calibration.forward import fix_friction_speed
from layerjam.laboratory.identify.curves import Curve, group_conditions, make_curve
from layerjam.laboratory.identify.pull.features import PullFeatures
from layerjam.laboratory.identify.single_pulls import SinglePull

POINTS = 200
FLOOR = 0.05
WINDOW = (
    "loading branch from the peak to the end, 200 points equally spaced in elongation, where the "
    "force is at least 5 % of the peak"
)


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Errors of a model at measured points.

    `mape` is the mean of |measured - model| / measured [-], `rmse` is in N, `bias` is the mean of
    model - measured [N]; `r_squared` is None if the measured force never changes.
    """

    mape: float
    rmse: float
    bias: float
    r_squared: float | None


@dataclass(frozen=True, kw_only=True)
class CurveError(Errors):
    """Errors of the model for one measured pull; arrays have shape (M,), M <= 200."""

    elongation: np.ndarray
    measured: np.ndarray
    model: np.ndarray
    vacuum: float
    path: str
    note: str
    pull: PullFeatures
    speed: float | None = None
    repeat: int | None = None

    @property
    def points(self) -> int:
        """Number of points M."""
        return len(self.elongation)

    @property
    def residual(self) -> np.ndarray:
        """Measured minus model force [N], shape (M,)."""
        return self.measured - self.model


@dataclass(frozen=True, kw_only=True)
class Split:
    """Mean squared error [N^2], split into the model's own error and the scatter between repeats.

    `mse` = `model_mse` + `scatter_mse`. If `model_mse` is negative, the scatter's `share` [-]
    exceeds 1. The share is None if there is no error at all.
    """

    mse: float
    model_mse: float
    scatter_mse: float
    share: float | None
    repeats: int

    @property
    def own(self) -> float:
        """Root mean square of the model's own error [N]; 0 if not distinguishable from zero."""
        return max(self.model_mse, 0.0) ** 0.5

    @property
    def sd(self) -> float:
        """Standard deviation of the repeats at one elongation [N]."""
        return self.scatter_mse**0.5

    @classmethod
    def of(cls, parts: Sequence[float] | np.ndarray, repeats: int) -> "Split":
        """Return the split from (mean square, the model's part, the scatter's part)."""
        mse, model, scatter = (float(part) for part in parts)
        share = scatter / mse if mse > 0 else None
        return cls(mse=mse, model_mse=model, scatter_mse=scatter, share=share, repeats=repeats)


@dataclass(frozen=True, kw_only=True)
class PooledErrors(Errors):
    """Errors over several pulls: `mape` is the mean over files, `mape_sd` the SD between files.

    RMSE [N], bias [N] and R^2 are over all points. `scatter` is None if no pull is repeated.
    """

    mape_sd: float | None
    scatter: Split | None
    curves: tuple[CurveError, ...]

    @property
    def repeats(self) -> int:
        """Number of pulls."""
        return len(self.curves)


@dataclass(frozen=True, kw_only=True)
class ConditionError(PooledErrors):
    """Errors at one vacuum [Pa] and speed [m/s]; `speed` is None if unknown."""

    vacuum: float
    speed: float | None


@brief
@dataclass(frozen=True, kw_only=True)
class Validation(PooledErrors):
    """Errors over all pulls; `scatter` is the mean of the conditions' splits.

    `mape_conditions` and its SD are over conditions, as in the paper (section III-C). `pulls` is
    the table of single pulls, if requested.
    """

    mape_conditions: float
    mape_conditions_sd: float | None
    conditions: tuple[ConditionError, ...]
    pulls: tuple[SinglePull, ...] = ()


def uncalibrated(brake: Brake) -> Brake:
    """Return the brake before calibration: scale factor 1, stiffness of stuck sheets (eq. 1).

    A fitted dependence on pressure or speed is removed too; friction and enclosure remain as in the
    file.
    """
    handbook_brake = remove_fitted(brake)
    return evolve(
        handbook_brake, scale_factor=1.0, amplification_held=None, stiffness_measured=None
    )


def sample_force(pull: PullFeatures, points: np.ndarray) -> np.ndarray:
    """Return the force [N] of a pull at elongations `points` [m], shape (N,)."""
    order = np.argsort(pull.elongation, kind="stable")
    return np.interp(points, pull.elongation[order], pull.force[order])


def _model_force(pull: PullFeatures, points: np.ndarray, vacuum: float, brake: Brake) -> np.ndarray:
    model = np.asarray(force_at_elongation(points, vacuum, brake))
    if not np.isfinite(model).all():
        raise FitError.of(pull.path, "the model has no solution there; the brake would snap")
    return model


def _find_comparison_window(pull: PullFeatures, vacuum: float) -> tuple[float, float, str]:
    """Return the start and end of the window [m], and a note if it is unusual."""
    note = ""
    if pull.has_peak:
        start = pull.peak_elongation
    elif not pull.straight or vacuum == 0:
        start = 0.0
        note = "no peak and no linear rise: the window is the whole record"
    else:
        line = pull.stiffness * pull.elongation
        slipping = np.flatnonzero(pull.force < 0.9 * line)
        slipping = slipping[pull.force[slipping] > FLOOR * pull.peak_force]
        start = float(pull.elongation[slipping[0]]) if len(slipping) else np.inf
        note = "no peak: the window starts where the force departs from its linear rise"
    end = float(pull.elongation[-1])
    if not end - start > 1e-6:
        raise FileError(pull.path, "ends at its peak: no sliding part to compare")
    return start, end, note


def _error_fields(forces: np.ndarray, model: np.ndarray) -> dict[str, Any]:
    error, mean = model - forces, float(forces.mean())
    r_squared = None
    if np.ptp(forces) > 1e-12 * abs(mean):  # equal values may differ from their mean by rounding
        r_squared = 1 - float((error**2).sum() / ((forces - mean) ** 2).sum())
    return {
        "mape": float(np.mean(np.abs(error) / forces)),
        "rmse": float(np.sqrt(np.mean(error**2))),
        "bias": float(error.mean()),
        "r_squared": r_squared,
    }


def compare_pull(
    pull: PullFeatures,
    vacuum: float,
    brake: Brake,
    *,
    speed: float | None = None,
    repeat: int | None = None,
) -> CurveError:
    """Compare the model at `vacuum` [Pa] with one pull, over the window.

    `speed` [m/s] and `repeat` are stored for grouping. Raises FileError if the record ends at its
    peak, FitError if the brake would snap.
    """
    start, end, note = _find_comparison_window(pull, vacuum)
    points = np.linspace(start, end, POINTS)
    forces = sample_force(pull, points)
    model = _model_force(pull, points, vacuum, brake)
    kept = forces >= FLOOR * pull.peak_force
    points, forces, model = points[kept], forces[kept], model[kept]
    return CurveError(
        elongation=points,
        measured=forces,
        model=model,
        vacuum=vacuum,
        path=pull.path,
        note=note,
        pull=pull,
        speed=speed,
        repeat=repeat,
        **_error_fields(forces, model),
    )


def split_error(residuals: np.ndarray) -> tuple[float, float, float]:
    """Return (mean square, model's part, scatter's part) of residuals, shape (R, M), R >= 2.

    Rows are repeats, columns are elongations; the three results have the residuals' unit squared.
    """
    repeats = len(residuals)
    if repeats < 2:
        raise FitError(f"repeats: {repeats} is not allowed; scatter needs at least 2")
    scatter = residuals.var(axis=0, ddof=1)
    model = residuals.mean(axis=0) ** 2 - scatter / repeats
    return float((residuals**2).mean()), float(model.mean()), float(scatter.mean())


def _split_condition_error(curves: Sequence[CurveError], brake: Brake) -> Split | None:
    """Return the split of one condition over the elongations that its windows share, or None."""
    if len(curves) < 2:
        return None
    start = max(float(c.elongation[0]) for c in curves)
    end = min(float(c.elongation[-1]) for c in curves)
    if not end - start > 1e-6:
        return None
    points = np.linspace(start, end, POINTS)
    residuals = np.stack(
        [
            _model_force(c.pull, points, c.vacuum, fix_friction_speed(brake, c.speed, c.path))
            - sample_force(c.pull, points)
            for c in curves
        ]
    )
    return Split.of(split_error(residuals), len(curves))


def _pool_errors(curves: Sequence[CurveError]) -> dict[str, Any]:
    """Return the fields of `PooledErrors` except the split: point errors, and MAPE of files."""
    forces = np.concatenate([c.measured for c in curves])
    model = np.concatenate([c.model for c in curves])
    mape, mape_sd = _mean_and_sd([c.mape for c in curves])
    over_files = {"mape": mape, "mape_sd": mape_sd, "curves": tuple(curves)}
    return _error_fields(forces, model) | over_files


def _mean_and_sd(values: Sequence[float]) -> tuple[float, float | None]:
    return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else None


def _condition_errors(curves: Sequence[CurveError], brake: Brake) -> ConditionError:
    speeds = [c.speed for c in curves if c.speed is not None]
    return ConditionError(
        vacuum=float(np.mean([c.vacuum for c in curves])),
        speed=float(np.mean(speeds)) if speeds else None,
        scatter=_split_condition_error(curves, brake),
        **_pool_errors(curves),
    )


def pool_curves(conditions: Sequence[ConditionError], curves: Sequence[CurveError]) -> Validation:
    """Return the errors of all pulls; files have equal weight, and in the split, conditions do."""
    mape, mape_sd = _mean_and_sd([c.mape for c in conditions])
    splits = [c.scatter for c in conditions if c.scatter is not None]
    split = None
    if splits:
        parts = np.mean([(s.mse, s.model_mse, s.scatter_mse) for s in splits], axis=0)
        split = Split.of(parts, sum(s.repeats for s in splits))
    return Validation(
        mape_conditions=mape,
        mape_conditions_sd=mape_sd,
        scatter=split,
        conditions=tuple(conditions),
        **_pool_errors(curves),
    )


def validate_curves(curves: Sequence[Curve], brake: Brake) -> Validation:
    """Compare a brake with pulls of known vacuum, speed and repeat.

    Raises FitError if no pull is given or the brake would snap, FileError if a pull ends at its
    peak.
    """
    if not curves:
        raise FitError("validate: no pull was given")
    errors = [
        compare_pull(
            c,
            c.vacuum,
            fix_friction_speed(brake, c.speed, c.path),
            speed=c.speed,
            repeat=c.repeat,
        )
        for c in curves
    ]
    errors_by_condition = [
        _condition_errors([errors[i] for i in group], brake) for group in group_conditions(curves)
    ]
    errors_by_condition.sort(key=lambda c: (c.speed or 0.0, -c.vacuum))
    return pool_curves(errors_by_condition, errors)


def validate_pulls(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> Validation:
    """Return `validate_curves` for pulls of which only the vacuum [Pa] is known."""
    return validate_curves([make_curve(pull, vacuum) for pull, vacuum in pulls], brake)
