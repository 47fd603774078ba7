"""Fits of the dry and wet Stribeck laws to forces at several speeds, with errors and a verdict.

For a given v_s both laws are linear in all other parameters. The fit therefore searches over v_s
alone, with bounded linear least squares at each step, and finds the best v_s from any start. The
data seldom determine v_s well. A wide prior on its logarithm keeps it finite, and the verdict
states whether the data add information to the prior.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.effects import require_linear
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck
from layerjam.brake.mechanics.stick_slip.wet import WetFilm
from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.laboratory.identify.fit_checks import Check, check, check_span

Array = np.ndarray[Any, np.dtype[np.float64]]
PRIOR = (np.log(1e-2), 2 * np.log(10.0))
"""Mean and SD of ln v_s (v_s in m/s): 10 mm/s, two decades either way."""
_RANGE = (1e-7, 1e2)
_WORST_CONDITION = 100.0
USUAL = (0.02, 1.5)
"""Usual range of films' kinetic friction coefficients."""


@dataclass(frozen=True, kw_only=True)
class SpeedPoints:
    """Forces of a sliding brake, arrays of shape (N,); build them with `speed_points`."""

    speed: Array
    """Sliding speeds [m/s]."""
    force: Array
    """Forces [N]."""
    slip: Array
    """Slips [m]."""
    vacuum: Array
    """Vacuums [Pa]."""


@dataclass(frozen=True, kw_only=True)
class SpeedFit:
    """A fitted law: parameters, standard errors and checks.

    `law` is a Stribeck or a WetFilm. A standard error is None if the parameter is at its bound or
    the noise is unknown; that of `speed` is relative (of ln v_s). The friction includes the brake's
    scale factor, because only their product matters.
    """

    law: Stribeck | WetFilm
    standard_errors: dict[str, float | None]
    noise: float
    """SD of the residuals [N]."""
    residuals: Array
    checks: tuple[Check, ...]

    @property
    def trusted(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)


def speed_points(
    speed: Sequence[float] | Array,
    force: Sequence[float] | Array,
    *,
    vacuum: float | Sequence[float] | Array,
    slip: float | Sequence[float] | Array = 0.0,
    brake: Brake,
) -> SpeedPoints:
    """Validate and return points of speed [m/s], force [N], slip [m] and vacuum [Pa].

    Slip and vacuum may each be one number. Raises FitError for arrays of different lengths, for
    negative or non-finite numbers, and for slips beyond the overlap.
    """
    try:
        speeds, forces = (np.asarray(a, float).ravel() for a in (speed, force))
        slips, vacuums = (
            np.broadcast_to(np.asarray(a, float), speeds.shape) for a in (slip, vacuum)
        )
    except ValueError:
        raise FitError(
            "points: speed, force, slip and vacuum must be lists of the same length"
        ) from None
    if len(forces) != len(speeds):
        raise FitError(f"points: {len(speeds)} speeds do not match {len(forces)} forces")
    basis_columns = {"speed": speeds, "force": forces, "slip": slips, "vacuum": vacuums}
    for name, values in basis_columns.items():
        bad = np.flatnonzero(~np.isfinite(values) | (values < 0))
        if len(bad):
            raise FitError(
                f"points: {name} {values[bad[0]]} of point {bad[0] + 1} is not allowed; it must "
                "be zero or more"
            )
    if len(slips) and slips.max() >= brake.sheets.overlap:
        raise FitError(
            f"points: slip {show(float(slips.max()), 'm')} is beyond the overlap of "
            f"{show(brake.sheets.overlap, 'm')}"
        )
    return SpeedPoints(speed=speeds, force=forces, slip=slips, vacuum=vacuums)


def fit_dry(
    points: SpeedPoints, brake: Brake, *, exponent: float = 1.0, viscous: bool = False
) -> SpeedFit:
    """Fit the Stribeck law for dry sheets; `viscous` adds growth with speed. Raises FitError."""
    coulomb, enclosure = _unit_friction_force(points, brake)
    if not (points.vacuum > 0).all():
        raise FitError("points: dry sheets without vacuum have no friction to fit")
    speed = points.speed

    def basis_columns(stribeck: float) -> Array:
        parts = [coulomb, coulomb * _compute_static_share(speed, stribeck, exponent)]
        return np.stack(parts + [coulomb * speed] * viscous, axis=1)

    names = ("kinetic", "drop", "viscous")[: 2 + viscous]
    best = _Search(basis_columns, points.force - enclosure, names, points).run()
    kinetic, drop = best.values[:2]
    law = Stribeck(
        static=kinetic + drop,
        kinetic=kinetic,
        speed=best.speed,
        exponent=exponent,
        viscous=best.values[2] if viscous else 0.0,
    )
    return best.result(law)


def fit_wet(points: SpeedPoints, brake: Brake, *, exponent: float = 1.0) -> SpeedFit:
    """Fit the wet law, with adhesion and a viscous term, to several vacuums; raises FitError."""
    coulomb, enclosure = _unit_friction_force(points, brake)
    if np.ptp(points.vacuum) <= 0.05 * points.vacuum.max(initial=0.0):
        raise FitError(
            "points: one vacuum cannot tell adhesion from friction; measure at two or more"
        )
    sheets = brake.sheets
    area = (sheets.count - 1) * sheets.width * (sheets.overlap - points.slip)

    def basis_columns(stribeck: float) -> Array:
        static_share = _compute_static_share(points.speed, stribeck, exponent)
        return np.stack([coulomb, coulomb * static_share, area, area * points.speed], axis=1)

    names = ("kinetic", "drop", "adhesion", "viscosity")
    best = _Search(basis_columns, points.force - enclosure, names, points).run()
    kinetic, drop, adhesion, viscosity = best.values
    law = WetFilm(
        static=kinetic + drop,
        kinetic=kinetic,
        speed=best.speed,
        exponent=exponent,
        adhesion=adhesion,
        viscosity=viscosity,
    )
    return best.result(law)


def _unit_friction_force(points: SpeedPoints, brake: Brake) -> tuple[Array, Array]:
    """Return (force per unit friction coefficient, enclosure force) [N]."""
    brake = require_linear(brake, "the fit of friction versus speed")
    contact = brake.sheets.overlap - points.slip
    per_metre = np.asarray(friction_per_contact(points.vacuum, brake)) / brake.film.kinetic
    return per_metre * contact, np.asarray(enclosure_law(points.vacuum, brake).force(points.slip))


def _compute_static_share(speed: Array, stribeck: float, exponent: float) -> Array:
    return np.asarray(np.exp(-((speed / stribeck) ** exponent)))


class _Search:
    """Search for the best v_s and its linear parameters."""

    def __init__(
        self,
        basis_columns: Callable[[float], Array],
        target: Array,
        names: Sequence[str],
        points: SpeedPoints,
    ) -> None:
        self.columns, self.target, self.names, self.points = basis_columns, target, names, points
        self.values: list[float] = []
        self.speed = 0.0
        unknowns = len(names) + 1
        if len(target) <= unknowns:
            raise FitError(f"points: {len(target)} are too few to fit {unknowns} parameters")
        if len(np.unique(points.speed)) < 3:
            raise FitError("points: forces at a minimum of three speeds are needed")

    def solve_at(self, logarithm: float) -> tuple[Array, float]:
        """Return (values, sum of squares) of bounded least squares at a given ln v_s."""
        from scipy.optimize import nnls

        table = self.columns(float(np.exp(logarithm)))
        size = np.linalg.norm(table, axis=0)
        size[size == 0] = 1.0
        values, residual = nnls(table / size, self.target)
        return values / size, float(residual**2)

    def run(self) -> "_Search":
        """Search first without the prior, to estimate the noise, then with it, to find v_s."""
        grid = np.linspace(np.log(_RANGE[0]), np.log(_RANGE[1]), 240)
        sums = np.array([self.solve_at(g)[1] for g in grid])
        self.freedom = len(self.target) - len(self.names) - 1
        size = float(np.abs(self.target).max(initial=0.0))
        minimum = min(float(sums.min()), self._refine_minimum(grid, sums, 0.0))
        self.variance = max(minimum / self.freedom, (1e-12 * size) ** 2, 1e-300)
        weight = self.variance / PRIOR[1] ** 2
        self._refine_minimum(grid, sums + weight * (grid - PRIOR[0]) ** 2, weight)
        return self

    def _refine_minimum(self, grid: Array, costs: Array, weight: float) -> float:
        from scipy.optimize import minimize_scalar

        nearest = int(np.argmin(costs))
        ends = grid[max(nearest - 1, 0)], grid[min(nearest + 1, len(grid) - 1)]

        def cost(g: float) -> float:
            return self.solve_at(g)[1] + weight * (g - PRIOR[0]) ** 2

        minimum = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": 1e-10})
        self.logarithm = float(minimum.x)
        self.speed = float(np.exp(self.logarithm))
        self.values = [float(v) for v in self.solve_at(self.logarithm)[0]]
        return float(minimum.fun)

    def _estimate_covariance(self) -> tuple[Array, list[bool], float]:
        """Return (covariance of values and ln v_s, free parameters, condition number)."""
        table = self.columns(self.speed)
        step = 1e-5
        change = self.columns(self.speed * np.exp(step)) - self.columns(self.speed * np.exp(-step))
        slope = change @ np.array(self.values) / (2 * step)
        full_table = np.column_stack([table, slope])
        free = [v > 0 for v in self.values] + [self.values[1] > 0]
        part = full_table[:, free] / np.sqrt(self.variance)
        size = np.linalg.norm(part, axis=0)
        size[size == 0] = 1.0
        condition = float(np.linalg.cond(part / size))
        information = part.T @ part
        if free[-1]:
            information[-1, -1] += 1 / PRIOR[1] ** 2
        cov = np.zeros((len(free), len(free)))
        cov[np.ix_(free, free)] = np.linalg.pinv(information, hermitian=True)
        return cov, free, condition

    def result(self, law: Stribeck | WetFilm) -> SpeedFit:
        """Return the fit with its errors and checks."""
        cov, free, condition = self._estimate_covariance()
        residuals = self.target - self.columns(self.speed) @ np.array(self.values)
        noise = float(np.sqrt((residuals**2).sum() / self.freedom))
        noisy = noise > 1e-9 * float(np.abs(self.target).max())
        errors: dict[str, float | None] = {}
        for i, name in enumerate(self.names):
            errors[name] = float(np.sqrt(cov[i, i])) if free[i] and noisy else None
        static_se = float(np.sqrt(max(cov[0, 0] + cov[1, 1] + 2 * cov[0, 1], 0.0)))
        errors["static"] = static_se if free[0] and free[1] and noisy else errors["kinetic"]
        errors["speed"] = float(np.sqrt(cov[-1, -1])) if free[-1] and noisy else None
        log_error = float(np.sqrt(cov[-1, -1])) if free[-1] else PRIOR[1]
        checks = (
            self._check_identifiability(log_error, condition),
            self._check_bounds(),
            self._check_trend(residuals, noise),
            self._check_spans(),
            check_span(
                "plausible", float(law.kinetic), USUAL, "kinetic friction", "unusual for films"
            ),
        )
        return SpeedFit(
            law=law, standard_errors=errors, noise=noise, residuals=residuals, checks=checks
        )

    def _check_identifiability(self, log_error: float, condition: float) -> Check:
        factor = float(np.exp(min(log_error, 50.0)))
        return check(
            "identifiable",
            log_error < 0.25 * PRIOR[1] and condition < _WORST_CONDITION,
            f"v_s is known to within a factor of {factor:.3g} (prior: {np.exp(PRIOR[1]):.3g}); "
            f"condition number {condition:.3g}",
            ": the points do not distinguish the parameters; measure at more speeds",
        )

    def _check_bounds(self) -> Check:
        low, high = np.log(_RANGE)
        at_bound = [n for n, v in zip(self.names, self.values, strict=True) if v <= 0]
        at_bound += ["v_s"] * (not low + 0.1 < self.logarithm < high - 0.1)
        sentence = "no parameter lies at its bound"
        if at_bound:
            sentence = f"{', '.join(at_bound)} at the bound: these points do not require the term"
        return check("bounds", not at_bound, sentence)

    def _check_trend(self, residuals: Array, noise: float) -> Check:
        """Check the residuals versus log speed for a slope, a bend or correlated neighbours."""
        moving = self.points.speed > 0
        x = np.log(self.points.speed[moving])
        worst = 0.0
        if len(np.unique(x)) >= 4 and noise > 1e-9 * float(np.abs(self.target).max()):
            x = (x - x.mean()) / x.std()
            for shape in (x, x**2 - (x**2).mean()):
                part = residuals[moving]
                worst = max(worst, abs(float(shape @ part)) / noise / float(np.linalg.norm(shape)))
            part = residuals[np.argsort(self.points.speed, kind="stable")]
            correlation = float(part[1:] @ part[:-1]) / float(part @ part)
            worst = max(worst, correlation * float(np.sqrt(len(part))))
        sentence = f"residuals trend with the logarithm of speed by {worst:.2g} standard errors"
        return check("trend over speed", worst < 2.5, sentence)

    def _check_spans(self) -> Check:
        moving = self.points.speed[self.points.speed > 0]
        low, high = float(moving.min()), float(moving.max())
        is_ok, shown_speed = low / 2 <= self.speed <= high, show(self.speed, "m/s")
        sentence = (
            f"v_s = {shown_speed} lies {'within' if is_ok else 'outside'} the measured speeds, "
            f"{show(low, 'm/s')} to {show(high, 'm/s')}"
        )
        return check("span", is_ok, sentence)
