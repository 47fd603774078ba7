"""Uncertainty of a calibrated law at one vacuum, and the scatter of a further pull about it."""

from dataclasses import dataclass

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.laboratory.identify.bayes.posterior import BayesFit
from layerjam.laboratory.identify.calibration.forward import evaluate_law, friction_growth
from layerjam.laboratory.identify.calibration.intervals import quantile
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.shape import SHAPE


@dataclass(frozen=True, kw_only=True, eq=False)
class LawError:
    """Uncertainty of a calibrated brake's law at one vacuum and speed.

    `covariance` (3, 3) is that of (ln a, ln k, the multiplier of the enclosure force), `t` is
    Student's 95 % quantile and `pulls` the number of pulls.
    """

    covariance: np.ndarray
    t: float
    pulls: int

    def half_width(
        self, brake: Brake, elongation: np.ndarray, vacuum: float, speed: float | None
    ) -> np.ndarray:
        """Return the half-width of the 95 % interval of the brake's force [N], to first order.

        It is evaluated at elongations [m], shape (n,), a vacuum [Pa] and a crosshead speed [m/s].
        """
        friction = brake.scale_factor * friction_growth(brake, speed, "")
        if brake.pressure_exponent is not None and brake.test_pressure is not None:
            friction = friction * (vacuum / brake.test_pressure) ** brake.pressure_exponent
        shape = np.array([float(friction), float(working_stiffness(brake)), 1.0])
        return self.t * evaluate_law(elongation, vacuum, shape, self.covariance, brake)[1]


@dataclass(frozen=True, kw_only=True, eq=False)
class LawSpread:
    """Scatter of repeats about a law, in (ln a, ln k, enclosure factor).

    These three are `design` times `estimate` (q,), which has the `covariance` (q, q). The design
    may depend on vacuum and speed. `scatter` (3, 3) is that of a further pull about the law, `t`
    Student's 95 % quantile. `names` (q,) are those of the estimate, `pulls` is the number of pulls.
    """

    names: tuple[str, ...]
    estimate: np.ndarray
    covariance: np.ndarray
    scatter: np.ndarray
    t: float
    pulls: int
    reference_pressure: float = float("nan")
    reference_speed: float | None = None

    @classmethod
    def from_calibration(cls, calibration: Calibration) -> "LawSpread | None":
        """Return the spread of a calibration; None if no repeats determine it."""
        if calibration.fit is None:
            return _make_peak_spread(calibration)
        if isinstance(calibration.fit, JointFit):
            return _make_curve_spread(calibration, calibration.fit)
        return _make_draw_spread(calibration, calibration.fit)

    def design_at(self, vacuum: float, speed: float | None) -> np.ndarray:
        """Return the design (3, q) at a vacuum [Pa] and a crosshead speed [m/s]."""
        matrix = np.eye(3, len(self.names))
        for column, name in enumerate(self.names[3:], 3):
            if name == "pressure_exponent":
                matrix[0, column] = np.log(vacuum / self.reference_pressure)
            elif speed is not None and self.reference_speed is not None:
                matrix[0, column] = np.log10(speed / self.reference_speed)
        return matrix

    def covariance_at(self, vacuum: float, speed: float | None) -> np.ndarray:
        """Return the law's covariance (3, 3) at a vacuum [Pa] and a crosshead speed [m/s]."""
        design = self.design_at(vacuum, speed)
        return np.asarray(design @ self.covariance @ design.T)

    def error_at(self, vacuum: float, speed: float | None) -> LawError:
        """Return the error of the calibrated brake at a vacuum [Pa] and a speed [m/s]."""
        scales = np.array(
            [1.0, 1.0, 1 / self.estimate[2]]
        )  # the enclosure in the file already includes the factor
        covariance = self.covariance_at(vacuum, speed) * np.outer(scales, scales)
        return LawError(covariance=covariance, t=self.t, pulls=self.pulls)


def _make_peak_spread(calibration: Calibration) -> LawSpread | None:
    count = len(calibration.fits)
    if count < 2:
        return None
    # a pull without a stiffness contributes scatter only to the scale factor
    logs = np.log(
        [[f.scale_factor, f.stiffness or calibration.stiffness, 1.0] for f in calibration.fits]
    )
    scatter = np.atleast_2d(np.cov(logs.T))
    covariance, interval = scatter / count, calibration.intervals["scale_factor"]
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
        t=quantile(count - 1) if interval is None else interval.coverage_factor,
        pulls=count,
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
        t=interval.coverage_factor,
        pulls=count,
        reference_pressure=fit.reference_pressure,
        reference_speed=fit.reference_speed,
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
    a, k, enclosure = (
        calibration.scale_factor,
        calibration.stiffness,
        calibration.values["enclosure_factor"],
    )
    return LawSpread(
        names=SHAPE,
        estimate=np.array([np.log(a), np.log(k), enclosure]),
        covariance=np.cov(np.stack([part.ravel() for part in parts]))
        + _shared_covariance(calibration),
        scatter=np.diag(repeats),
        t=quantile(1e6),
        pulls=len(calibration.curves),
    )
