"""Uncertainty of a calibrated law, and the scatter of a further pull about it, for [[tested]]."""

from dataclasses import dataclass

import numpy as np

from layerjam.laboratory.identify.bayes.posterior import BayesFit
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.shape import SHAPE


@dataclass(frozen=True, kw_only=True, eq=False)
class LawSpread:
    """Scatter of repeats about a law, in (ln a, ln k, enclosure factor).

    These three depend on `estimate` (q,), whose `names` (q,) include exponents of vacuum and speed,
    and which has the `covariance` (q, q). `scatter` (3, 3) is that of a further pull about the law.
    """

    names: tuple[str, ...]
    estimate: np.ndarray
    covariance: np.ndarray
    scatter: np.ndarray
    reference_pressure: float = float("nan")

    @classmethod
    def from_calibration(cls, calibration: Calibration) -> "LawSpread | None":
        """Return the spread of a calibration; None if no repeats determine it."""
        if calibration.fit is None:
            return _make_peak_spread(calibration)
        if isinstance(calibration.fit, JointFit):
            return _make_curve_spread(calibration, calibration.fit)
        return _make_draw_spread(calibration, calibration.fit)


def _make_peak_spread(calibration: Calibration) -> LawSpread | None:
    count = len(calibration.fits)
    if count < 2:
        return None
    # a pull without a stiffness contributes scatter only to the scale factor
    logs = np.log(
        [[f.scale_factor, f.stiffness or calibration.stiffness, 1.0] for f in calibration.fits]
    )
    scatter = np.atleast_2d(np.cov(logs.T))
    covariance = scatter / count
    if calibration.covariance:
        covariance[:2, :2] = [
            [
                calibration.covariance[x][y] / (calibration.values[x] * calibration.values[y])
                for y in SHAPE[:2]
            ]
            for x in SHAPE[:2]
        ]
    # with a stronger enclosure, the sheets carry a smaller part of the peak force
    sleeve = calibration.contributions[1]
    square = (sleeve.standard or 0.0) ** 2
    covariance[0, 2] = covariance[2, 0] = sleeve.sensitivity * square
    covariance[2, 2] = square
    return LawSpread(
        names=SHAPE,
        estimate=np.array([np.log(calibration.scale_factor), np.log(calibration.stiffness), 1.0]),
        covariance=covariance,
        scatter=scatter,
    )


def _make_curve_spread(calibration: Calibration, fit: JointFit) -> LawSpread | None:
    count, interval = len(fit.reduced), calibration.intervals["scale_factor"]
    covariance = fit.population.join_groups(calibration.mountings).covariance()
    degrees = count - (len(fit.names) - 2)
    if degrees <= 0 or interval is None or not np.isfinite(covariance).all():
        return None
    covariance[:3, :3] += _shared_covariance(calibration)
    deviations = fit.own.own[:, :3] - (fit.design @ fit.population.estimate + fit.held)
    return LawSpread(
        names=fit.names,
        estimate=fit.population.estimate,
        covariance=covariance,
        scatter=deviations.T @ deviations / degrees,
        reference_pressure=fit.reference_pressure,
    )


def _shared_covariance(calibration: Calibration) -> np.ndarray:
    """Return the covariance (3, 3) of errors common to all pulls, as in `LawSpread`."""
    relative = np.array([calibration.common_errors.get(name, 0.0) for name in SHAPE])
    relative[2] *= calibration.values[SHAPE[2]]
    return np.diag(relative**2)


def _make_draw_spread(calibration: Calibration, fit: BayesFit) -> LawSpread:
    """Return the spread of a posterior, treated as normal in (ln a, ln k, factor)."""
    parts = np.log(fit.scale_factor), np.log(fit.stiffness), fit.enclosure_factor
    repeats = *(np.median(fit.scatter(name)) ** 2 for name in SHAPE[:2]), 0.0
    a = calibration.scale_factor
    k = calibration.stiffness
    enclosure = calibration.values["enclosure_factor"]
    return LawSpread(
        names=SHAPE,
        estimate=np.array([np.log(a), np.log(k), enclosure]),
        covariance=np.cov(np.stack([part.ravel() for part in parts]))
        + _shared_covariance(calibration),
        scatter=np.diag(repeats),
    )
