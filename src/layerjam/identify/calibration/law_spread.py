"""How sure a calibration is of its law at a vacuum, and how a further pull scatters about it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.identify.calibration.forward import law_with_error
from layerjam.identify.calibration.intervals import quantile
from layerjam.identify.calibration.least_squares import JointFit
from layerjam.identify.calibration.record import Calibration
from layerjam.identify.shape import SHAPE
from layerjam.identify.speed import growth_in
from layerjam.mechanics.stiffness import working_stiffness

if TYPE_CHECKING:
    from layerjam.identify.bayes.posterior import BayesFit

HALF = np.triu_indices(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class LawError:
    """How sure the law of a calibrated brake is at one vacuum and speed.

    `covariance` (3, 3) is that of (ln a, ln k, a factor on the brake's enclosure), `t` Student's
    quantile of 95 %, `pulls` how many told it.
    """

    covariance: np.ndarray
    t: float
    pulls: int

    def half_width(
        self, brake: Brake, elongation: np.ndarray, vacuum: float, speed: float | None
    ) -> np.ndarray:
        """How far the 95 % reach to either side of the brake's force [N], to first order.

        Over elongations [m], shape (n,), at a vacuum [Pa] and a crosshead's speed [m/s].
        """
        friction = brake.scale_factor * growth_in(brake, speed, "")
        if brake.pressure_exponent is not None and brake.test_pressure is not None:
            friction = friction * (vacuum / brake.test_pressure) ** brake.pressure_exponent
        shape = np.array([float(friction), float(working_stiffness(brake)), 1.0])
        return self.t * law_with_error(elongation, vacuum, shape, self.covariance, brake)[1]

    def text(self) -> str:
        """Its numbers as JSON."""
        return json.dumps([self.pulls, self.t, *self.covariance[HALF].tolist()])

    @classmethod
    def read(cls, text: str) -> LawError:
        """That of a `text`; QuantityError for what is none."""
        try:
            pulls, t, *numbers = (float(value) for value in json.loads(text))
            covariance = np.zeros((3, 3))
            covariance[HALF] = np.reshape(numbers, HALF[0].shape)  # as many, not one for all
            covariance = covariance + np.triu(covariance, 1).T
            low, high = np.linalg.eigvalsh(covariance)[[0, -1]]
            right = pulls >= 2 and 0 < t < 1e3 and low >= -1e-9 * high and high < 1e3
        except (ValueError, TypeError, RecursionError, np.linalg.LinAlgError):
            right = False
        if not right:
            raise QuantityError("band: what is given is no covariance of a calibrated law")
        return cls(covariance=covariance, t=t, pulls=int(pulls))


@dataclass(frozen=True, kw_only=True, eq=False)
class LawSpread:
    """What repeats tell of a law, in (ln a, ln k, the enclosure's factor).

    These three are a design, which a vacuum or a speed may change, times `estimate` (q,), whose
    covariance is `covariance` (q, q). `scatter` (3, 3) is that of a further pull about the law,
    `t` Student's quantile of 95 %; `names` (q,) are the estimate's, `pulls` how many told it.
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
    def of(cls, found: Calibration) -> LawSpread | None:
        """That of a calibration; None where no repeats tell it."""
        if found.fit is None:
            return _of_peaks(found)
        if isinstance(found.fit, JointFit):
            return _of_curves(found, found.fit)
        return _of_draws(found, found.fit)

    def design(self, vacuum: float, speed: float | None) -> np.ndarray:
        """(3, q) at a vacuum [Pa] and a crosshead's speed [m/s]."""
        made = np.eye(3, len(self.names))
        for column, name in enumerate(self.names[3:], 3):
            if name == "pressure_exponent":
                made[0, column] = np.log(vacuum / self.reference_pressure)
            elif speed is not None and self.reference_speed is not None:
                made[0, column] = np.log10(speed / self.reference_speed)
        return made

    def sure(self, vacuum: float, speed: float | None) -> np.ndarray:
        """Covariance (3, 3) of the law itself at a vacuum [Pa] and a crosshead's speed [m/s]."""
        design = self.design(vacuum, speed)
        return np.asarray(design @ self.covariance @ design.T)

    def error(self, vacuum: float, speed: float | None) -> LawError:
        """That of the brake which the calibration wrote, at a vacuum [Pa] and a speed [m/s]."""
        own = np.array(
            [1.0, 1.0, 1 / self.estimate[2]]
        )  # the file's enclosure has the factor in it
        covariance = self.sure(vacuum, speed) * np.outer(own, own)
        return LawError(covariance=covariance, t=self.t, pulls=self.pulls)


def _of_peaks(found: Calibration) -> LawSpread | None:
    count = len(found.fits)
    if count < 2:
        return None
    # a pull that tells no stiffness scatters in the scale factor only
    own = np.log([[f.scale_factor, f.stiffness or found.stiffness, 1.0] for f in found.fits])
    scatter = np.atleast_2d(np.cov(own.T))
    covariance, interval = scatter / count, found.intervals["scale_factor"]
    if found.covariance:
        covariance[:2, :2] = [
            [found.covariance[x][y] / (found.values[x] * found.values[y]) for y in SHAPE[:2]]
            for x in SHAPE[:2]
        ]
    # a stronger enclosure leaves less of the peaks to the sheets
    sleeve = found.contributions[1]
    square = (sleeve.standard or 0.0) ** 2
    covariance[0, 2] = covariance[2, 0] = sleeve.sensitivity * square
    covariance[2, 2] = square
    return LawSpread(
        names=SHAPE,
        estimate=np.array([np.log(found.scale_factor), np.log(found.stiffness), 1.0]),
        covariance=covariance,
        scatter=scatter,
        t=quantile(count - 1) if interval is None else interval.coverage_factor,
        pulls=count,
    )


def _of_curves(found: Calibration, fit: JointFit) -> LawSpread | None:
    count, interval = len(fit.reduced), found.intervals["scale_factor"]
    covariance = fit.population.joined(found.mountings).covariance()
    degrees = count - (len(fit.names) - 2)
    if degrees <= 0 or interval is None or not np.isfinite(covariance).all():
        return None
    away = fit.own.own[:, :3] - (fit.design @ fit.population.estimate + fit.held)
    return LawSpread(
        names=fit.names,
        estimate=fit.population.estimate,
        covariance=covariance,
        scatter=away.T @ away / degrees,
        t=interval.coverage_factor,
        pulls=count,
        reference_pressure=fit.reference_pressure,
        reference_speed=fit.reference_speed,
    )


def _of_draws(found: Calibration, fit: BayesFit) -> LawSpread:
    """A posterior, taken as normal in (ln a, ln k, factor), which it nearly is."""
    parts = np.log(fit.scale_factor), np.log(fit.stiffness), fit.enclosure_factor
    repeats = *(np.median(fit.scatter(name)) ** 2 for name in SHAPE[:2]), 0.0
    a, k, enclosure = found.scale_factor, found.stiffness, found.values["enclosure_factor"]
    return LawSpread(
        names=SHAPE,
        estimate=np.array([np.log(a), np.log(k), enclosure]),
        covariance=np.cov(np.stack([part.ravel() for part in parts])),
        scatter=np.diag(repeats),
        t=quantile(1e6),
        pulls=len(found.curves),
    )
