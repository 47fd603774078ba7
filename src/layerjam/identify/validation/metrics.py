"""How far a model's curves lie from measured ones, and how much of that the repeats explain.

The window: the loading branch from the peak to the end, 200 points equally spaced in elongation,
those with a measured force of at least 5 % of the peak (a relative error means nothing near zero
force). A pull without a peak is taken from where it has bent off its straight rise, or whole where
it has none (low or no vacuum), and says so. Both curves start where the straight line before onset
meets zero force.

Over the points of the window, y measured and m the model's force:

    MAPE  mean of |m - y| / y
    RMSE  root of the mean of (m - y)^2
    bias  mean of m - y; positive where the model is too strong
    R^2   1 - sum (m - y)^2 / sum (y - mean y)^2; negative where a constant would do better

Of one curve the mean of y is that curve's; of a condition (pulls at one vacuum and speed) or of
all it is that of all its points, so that the R^2 of all also rewards telling the vacuums apart.

The mean squared error of a condition with R >= 2 repeats is split. With e_r(u) the residual of
repeat r at one elongation, their mean e(u) and sample variance s^2(u) = sum (e_r - e)^2 / (R - 1),

    mean square of e_r  =  (e^2 - s^2/R)  +  s^2

exactly. The second part is what any model would be left with, the scatter between repeats; the
first is the model's own error. Both are unbiased for any R: the mean of few repeats still scatters
by s^2/R, which is no fault of the model. The first can therefore come out below zero, where the
model's error cannot be told from none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FileError, FitError
from layerjam.identify.curves import Curve, conditions, curve_of
from layerjam.identify.pull.features import PullFeatures
from layerjam.identify.speed import as_pulled
from layerjam.mechanics.pull import force_at_elongation

if TYPE_CHECKING:
    from layerjam.identify.single_pulls import SinglePull

POINTS = 200
FLOOR = 0.05
WINDOW = (
    "loading branch from the peak to the end, 200 points equally spaced in elongation, where the "
    "force is at least 5 % of the peak"
)


@dataclass(frozen=True, kw_only=True)
class Errors:
    """How far a model lies from measured points.

    `mape` is the mean of |measured - model| / measured [-], `rmse` [N], `bias` the mean of
    model - measured [N]; `r_squared` is None where the measured force never changes.
    """

    mape: float
    rmse: float
    bias: float
    r_squared: float | None


@dataclass(frozen=True, kw_only=True)
class CurveError(Errors):
    """One measured pull against the model; arrays have shape (M,), M <= 200."""

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
        """M."""
        return len(self.elongation)

    @property
    def residual(self) -> np.ndarray:
        """Measured less model [N], shape (M,): what the model leaves over."""
        return self.measured - self.model


@dataclass(frozen=True, kw_only=True)
class Split:
    """A mean squared error [N^2] in two: the model's own part and the scatter between repeats.

    `mse` = `model_mse` + `scatter_mse`; `model_mse` may be below zero, and then the scatter's
    `share` [-] is above 1; it is None where there is no error at all.
    """

    mse: float
    model_mse: float
    scatter_mse: float
    share: float | None
    repeats: int

    @property
    def own(self) -> float:
        """The model's own error, root mean square [N]; 0 where none can be told."""
        return max(self.model_mse, 0.0) ** 0.5

    @property
    def sd(self) -> float:
        """Of the repeats at one elongation [N]."""
        return self.scatter_mse**0.5

    @classmethod
    def of(cls, parts: Sequence[float] | np.ndarray, repeats: int) -> Split:
        """From (mean square, the model's part, the scatter's part)."""
        mse, model, scatter = (float(part) for part in parts)
        share = scatter / mse if mse > 0 else None
        return cls(mse=mse, model_mse=model, scatter_mse=scatter, share=share, repeats=repeats)


@dataclass(frozen=True, kw_only=True)
class Pooled(Errors):
    """Errors over several pulls: `mape` is the mean over files, `mape_sd` its SD between files.

    RMSE and bias [N] and R^2 are over all points. `scatter` is None without any repeat.
    """

    mape_sd: float | None
    scatter: Split | None
    curves: tuple[CurveError, ...]

    @property
    def repeats(self) -> int:
        """Pulls."""
        return len(self.curves)


@dataclass(frozen=True, kw_only=True)
class ConditionError(Pooled):
    """The pulls at one vacuum [Pa] and speed [m/s]; `speed` is None where nothing tells it."""

    vacuum: float
    speed: float | None


@dataclass(frozen=True, kw_only=True)
class Validation(Pooled):
    """Errors over all pulls; `scatter` is the mean of the conditions' splits.

    `mape_conditions` and its SD are over conditions, as the paper counts (section III-C); `pulls`
    is the table pull by pull, where it was asked for, and `gross` {file: reason} of the pulls that
    no plausible scatter explains.
    """

    mape_conditions: float
    mape_conditions_sd: float | None
    conditions: tuple[ConditionError, ...]
    pulls: tuple[SinglePull, ...] = ()
    gross: Mapping[str, str] = field(default_factory=dict)


def uncalibrated(brake: Brake) -> Brake:
    """The brake before calibration: scale factor 1, stiffness of the stuck sheets (eq. 1).

    A fitted dependence on pressure or speed goes too; friction and enclosure stay as the file has
    them.
    """
    return replace(
        brake,
        scale_factor=1.0,
        amplification_held=None,
        stiffness_measured=None,
        pressure_exponent=None,
        test_pressure=None,
        speed_law=None,
    )


def sampled(pull: PullFeatures, points: np.ndarray) -> np.ndarray:
    """Force [N] of a pull at elongations `points` [m], shape (N,)."""
    order = np.argsort(pull.elongation, kind="stable")
    return np.interp(points, pull.elongation[order], pull.force[order])


def _modelled(pull: PullFeatures, points: np.ndarray, vacuum: float, brake: Brake) -> np.ndarray:
    model = np.asarray(force_at_elongation(points, vacuum, brake))
    if not np.isfinite(model).all():
        raise FitError.of(pull.path, "the model has no answer there; the brake would snap")
    return model


def _window(pull: PullFeatures, vacuum: float) -> tuple[float, float, str]:
    """Where the window starts and ends [m], and what is unusual about it."""
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
    return start, end, note


def _errors(measured: np.ndarray, model: np.ndarray) -> dict[str, Any]:
    """The fields of `Errors` over some points [N]."""
    error, mean = model - measured, float(measured.mean())
    squared = None
    if np.ptp(measured) > 1e-12 * abs(mean):  # a mean of like values is off by a rounding
        squared = 1 - float((error**2).sum() / ((measured - mean) ** 2).sum())
    return {
        "mape": float(np.mean(np.abs(error) / measured)),
        "rmse": float(np.sqrt(np.mean(error**2))),
        "bias": float(error.mean()),
        "r_squared": squared,
    }


def compare(
    pull: PullFeatures,
    vacuum: float,
    brake: Brake,
    *,
    speed: float | None = None,
    repeat: int | None = None,
) -> CurveError:
    """MAPE, RMSE, bias and R^2 of the model at `vacuum` [Pa] against one pull, over the window.

    `speed` [m/s] and `repeat` are kept for grouping. Raises FileError where the record ends at its
    peak, FitError where the brake would snap.
    """
    start, end, note = _window(pull, vacuum)
    points = np.linspace(start, end, POINTS)
    measured = sampled(pull, points)
    model = _modelled(pull, points, vacuum, brake)
    kept = measured >= FLOOR * pull.peak_force
    points, measured, model = points[kept], measured[kept], model[kept]
    return CurveError(
        elongation=points,
        measured=measured,
        model=model,
        vacuum=vacuum,
        path=pull.path,
        note=note,
        pull=pull,
        speed=speed,
        repeat=repeat,
        **_errors(measured, model),
    )


def split_error(residuals: np.ndarray) -> tuple[float, float, float]:
    """(mean square, the model's part, the scatter's part) of residuals, shape (R, M), R >= 2.

    Rows are repeats, columns elongations; the three come in the residuals' unit squared.
    """
    repeats = len(residuals)
    if repeats < 2:
        raise FitError(f"repeats: {repeats} is not allowed; scatter needs at least 2")
    scatter = residuals.var(axis=0, ddof=1)
    model = residuals.mean(axis=0) ** 2 - scatter / repeats
    return float((residuals**2).mean()), float(model.mean()), float(scatter.mean())


def _split(curves: Sequence[CurveError], brake: Brake) -> Split | None:
    """The split of one condition over the elongations all its windows share; None without any."""
    if len(curves) < 2:
        return None
    start = max(float(c.elongation[0]) for c in curves)
    end = min(float(c.elongation[-1]) for c in curves)
    if not end - start > 1e-6:
        return None
    points = np.linspace(start, end, POINTS)
    residuals = np.stack(
        [
            _modelled(c.pull, points, c.vacuum, as_pulled(brake, c.speed, c.path))
            - sampled(c.pull, points)
            for c in curves
        ]
    )
    return Split.of(split_error(residuals), len(curves))


def _pooled(curves: Sequence[CurveError]) -> dict[str, Any]:
    """The fields of `Pooled` but the split: errors over all points, MAPE and its SD over files."""
    measured = np.concatenate([c.measured for c in curves])
    model = np.concatenate([c.model for c in curves])
    mape, mape_sd = _mean_sd([c.mape for c in curves])
    over_files = {"mape": mape, "mape_sd": mape_sd, "curves": tuple(curves)}
    return _errors(measured, model) | over_files


def _mean_sd(values: Sequence[float]) -> tuple[float, float | None]:
    return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else None


def _condition(curves: Sequence[CurveError], brake: Brake) -> ConditionError:
    speeds = [c.speed for c in curves if c.speed is not None]
    return ConditionError(
        vacuum=float(np.mean([c.vacuum for c in curves])),
        speed=float(np.mean(speeds)) if speeds else None,
        scatter=_split(curves, brake),
        **_pooled(curves),
    )


def assemble(found: Sequence[ConditionError], curves: Sequence[CurveError]) -> Validation:
    """The errors in all; every file counts the same, in the split every condition."""
    over, over_sd = _mean_sd([c.mape for c in found])
    known = [c.scatter for c in found if c.scatter is not None]
    split = None
    if known:
        parts = np.mean([(s.mse, s.model_mse, s.scatter_mse) for s in known], axis=0)
        split = Split.of(parts, sum(s.repeats for s in known))
    return Validation(
        mape_conditions=over,
        mape_conditions_sd=over_sd,
        scatter=split,
        conditions=tuple(found),
        **_pooled(curves),
    )


def validate_curves(curves: Sequence[Curve], brake: Brake) -> Validation:
    """Compare a brake with pulls whose vacuum, speed and repeat are known.

    Raises FitError without any pull or where the brake would snap, FileError for a pull that ends
    at its peak.
    """
    if not curves:
        raise FitError("validate: no pull was given")
    errors = [
        compare(
            c.pull,
            c.vacuum,
            as_pulled(brake, c.speed, c.path),
            speed=c.speed,
            repeat=c.repeat,
        )
        for c in curves
    ]
    found = [_condition([errors[i] for i in group], brake) for group in conditions(curves)]
    found.sort(key=lambda c: (c.speed or 0.0, -c.vacuum))
    return assemble(found, errors)


def validate_pulls(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> Validation:
    """`validate_curves` for pulls given with their vacuum [Pa] alone."""
    return validate_curves([curve_of(pull, vacuum) for pull, vacuum in pulls], brake)
