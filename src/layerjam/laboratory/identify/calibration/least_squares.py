"""Least squares over all curves at once, with shared parameters and others for each curve.

Every curve has its own friction, stiffness, enclosure and slack, scattered about shared values. The
fit minimises the squared residuals plus the squared scatter divided by a working variance. Each
iteration solves for each curve's own parameters with the shared ones fixed (Levenberg-Marquardt),
then for the shared ones. With little noise, all curves have equal weight; a curve that determines a
parameter poorly has less weight for it. A curve's misfit is estimated from that curve alone. If the
other curves affected it, an unusual curve's deviation would count as noise and reduce its weight.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import scale_factor_of_peak
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.tracing import in_double_precision, jax, jnp
from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.forward import (
    ReducedCurves,
    friction_growth,
    pull_force,
    reduce_curves,
)
from layerjam.laboratory.identify.calibration.intervals import Population
from layerjam.laboratory.identify.curves import Curve, group_conditions
from layerjam.laboratory.identify.shape import SHAPE, drop_exponent, keep_fitted_law

FREE = ("pressure_exponent", "speed", "force_offset")
"""Names that `--free` accepts."""
WORKING = np.array([0.05, 0.05, 0.15])
"""Scatter of ln a, ln k and the enclosure factor between repeats, as the weights assume."""
LOOSE = 20.0
"""Multiplier of `WORKING` while a curve's own noise is estimated."""
MISFIT = 0.01
"""First estimate of a section's misfit, relative to the peak."""
QUIETEST = 2e-4
"""Minimum noise of a section, relative to the peak: the limit of load cells and means at a bend."""
BLOCK = 6
"""Number of curves solved at once: one shape to compile, and a short wait for the slowest."""
ROUNDS = 12
SETTLED = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnFit:
    """Each curve's own parameters, shape (curves, 5), as in `forward.pull_force`.

    `information` (curves, 3, 3) is that of each curve alone about its shape, with slack and offset
    free. `noise` [N] (curves,) is from the residuals of the sections, scaled for their correlation.
    """

    own: np.ndarray
    information: np.ndarray
    noise: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """Shared parameters by name, with the data of intervals and checks.

    `own` is the fit of each curve drawn towards the shared values, `alone` that of each by itself.
    """

    names: tuple[str, ...]
    population: Population
    own: OwnFit
    alone: OwnFit
    reduced: ReducedCurves
    design: np.ndarray
    held: np.ndarray
    reference_pressure: float
    reference_speed: float | None
    free: tuple[str, ...]
    groups: tuple[tuple[int, ...], ...]
    settled: bool
    rounds: int = field(default=0)

    def shape(self, place: int) -> np.ndarray:
        """Return (a, k, enclosure factor) of a curve from the shared parameters."""
        values = self.design[place] @ self.population.estimate + self.held[place]
        return np.array([np.exp(values[0]), np.exp(values[1]), values[2]])


def fit_jointly(
    curves: Sequence[Curve],
    brake: Brake,
    free: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> JointFit:
    """Fit all shared and own parameters; raises FitError if the curves do not determine them."""
    if not curves:
        raise FitError("calibrate: no pull was given")
    tell = progress or (lambda what, share: None)
    tell("reducing the curves", 0.0)
    means = reduce_curves(curves)
    names, design, base, pressure, speed = _make_design(curves, brake, free)
    start = _find_start_values(curves, brake, base)
    estimate = np.linalg.lstsq(
        design.reshape(-1, design.shape[2]), (start[:, :3] - base).reshape(-1), rcond=None
    )[0]
    offset = "force_offset" in free
    names_of = [c.name for c in curves]
    single_fits = _fit_each_curve(start, means, names_of, brake, offset)
    point, noise = single_fits.own, single_fits.noise
    is_settled, rounds = False, 0
    for rounds in range(1, ROUNDS + 1):
        prior = np.einsum("gij,j->gi", design, estimate) + base
        own_fit = fit_own_parameters(point, prior, means, noise, brake, offset)
        _check_finite(own_fit, means, names_of)
        point = own_fit.own
        deviations = point[:, :3] - prior
        root = _inverse_roots(own_fit.information)
        seen_design = root @ design
        residuals = np.einsum(
            "gij,gj->gi",
            np.linalg.pinv(np.swapaxes(root, 1, 2), rcond=1e-10),
            deviations / WORKING**2,
        )
        total = np.einsum("gki,gkj->ij", seen_design, seen_design)
        score = np.einsum("gki,gk->gi", seen_design, residuals)
        step = _solve_shared_step(total, score.sum(axis=0), names)
        tell("least squares over all curves", min(rounds / 6, 0.99))
        is_settled = bool(np.abs(step).max() < SETTLED)
        if is_settled:
            break
        estimate = estimate + step
    if not np.isfinite(estimate).all():
        raise FitError("calibrate: least squares over the curves found no finite solution")
    return JointFit(
        names=names,
        population=Population(estimate=estimate, design=seen_design, residual=residuals),
        own=own_fit,
        alone=single_fits,
        reduced=means,
        design=design,
        held=base,
        reference_pressure=pressure,
        reference_speed=speed,
        free=tuple(free),
        groups=tuple(group_conditions(curves)),
        settled=is_settled,
        rounds=rounds,
    )


def _inverse_roots(information: np.ndarray) -> np.ndarray:
    """Return the inverse root of each curve's variance: that of `WORKING`, plus noise.

    `information` is that of each curve alone (curves, 3, 3); it may not determine every parameter.
    """
    scale = np.diag(WORKING)
    strengths, axes = np.linalg.eigh(scale @ information @ scale)
    strengths = np.maximum(strengths, 0.0)
    root = axes * np.sqrt(strengths / (1 + strengths))[:, None, :] @ np.swapaxes(axes, 1, 2)
    return np.asarray(root / WORKING)


def _solve_shared_step(total: np.ndarray, score: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Return the step of the shared parameters; raises FitError if one is undetermined."""
    unknown = [n for n, strength in zip(names, np.diag(total), strict=True) if not strength > 1e-9]
    if unknown:
        words = ", ".join(unknown)
        raise FitError(
            f"{words}: these curves do not determine it; check that they slide over "
            "several millimetres"
        )
    return np.linalg.solve(total, score)


def _make_design(
    curves: Sequence[Curve], brake: Brake, free: Sequence[str]
) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, float, float | None]:
    """Return names, design (curves, 3, q), constants (curves, 3), reference pressure and speed."""
    names = list(SHAPE)
    vacuums = np.array([c.vacuum for c in curves])
    pressure = float(np.exp(np.log(vacuums).mean()))
    design = np.tile(np.eye(3), (len(curves), 1, 1))
    base = np.zeros((len(curves), 3))
    speed: float | None = None
    if "pressure_exponent" in free:
        if np.ptp(vacuums) < 0.1 * vacuums.max():
            raise FitError(
                "pressure_exponent: cannot be fitted because all pulls were at about "
                f"{show(float(vacuums.mean()), 'Pa')}; vacuums at least 10 % apart are needed"
            )
        names.append("pressure_exponent")
        design = _add_column(design, np.log(vacuums / pressure))
    elif brake.pressure_exponent is not None and brake.test_pressure is not None:
        base[:, 0] = brake.pressure_exponent * np.log(vacuums / brake.test_pressure)
    base[:, 0] += np.log([friction_growth(brake, c.speed, c.path) for c in curves])
    if "speed" in free:
        known_speeds = [c.speed for c in curves]
        speeds = np.array([np.nan if s is None else s for s in known_speeds])
        if np.isnan(speeds).any():
            unknown = next(c.name for c, s in zip(curves, known_speeds, strict=True) if s is None)
            raise FitError(
                f"speed: {unknown} has neither a speed nor a time; state the speed in a sidecar"
            )
        if speeds.max() < 1.2 * speeds.min():
            raise FitError(
                "speed: no law can be fitted because all pulls were at about "
                f"{show(float(speeds.mean()), 'm/s')}; speeds at least 20 % apart are needed"
            )
        speed = float(np.exp(np.log(speeds).mean()))
        names.append("speed_slope")
        design = _add_column(design, np.log10(speeds / speed))
    if np.linalg.matrix_rank(design.reshape(-1, design.shape[2])) < design.shape[2]:
        raise FitError(
            "speed: vacuum and speed change together, so their effects are not distinguishable"
        )
    return tuple(names), design, base, pressure, speed


def _add_column(design: np.ndarray, of_friction: np.ndarray) -> np.ndarray:
    column = np.zeros((*design.shape[:2], 1))
    column[:, 0, 0] = of_friction
    return np.concatenate([design, column], axis=2)


def _find_start_values(curves: Sequence[Curve], brake: Brake, base: np.ndarray) -> np.ndarray:
    straight = [c.stiffness for c in curves if c.straight]
    typical_spring = float(np.median(straight)) if straight else float(working_stiffness(brake))
    spring = [c.stiffness if c.straight else typical_spring for c in curves]
    linear_brake = drop_exponent(brake)
    peaks = np.array([c.peak_force for c in curves])
    vacuums = np.array([c.vacuum for c in curves])
    factors = np.asarray(scale_factor_of_peak(peaks, vacuums, linear_brake))
    finite = np.isfinite(factors) & np.array([c.has_peak for c in curves])
    logs = np.log(np.where(finite, factors, 1.0)) - base[:, 0]
    typical = float(np.median(logs[finite])) if finite.any() else float(np.log(brake.scale_factor))
    start = np.zeros((len(curves), 5))
    start[:, 0] = np.where(finite, logs, typical) + base[:, 0]
    start[:, 1] = np.log(spring)
    start[:, 2] = 1.0
    return start


def _fit_each_curve(
    start: np.ndarray, means: ReducedCurves, names: Sequence[str], brake: Brake, offset: bool
) -> OwnFit:
    """Fit every curve by itself, starting at its own features; its noise is the law's misfit."""
    point, noise = start, MISFIT * means.height
    for _ in range(3):
        fit = fit_own_parameters(point, start[:, :3], means, noise, brake, offset, LOOSE)
        _check_finite(fit, means, names)
        point, noise = fit.own, fit.noise
    return fit


def _check_finite(fit: OwnFit, means: ReducedCurves, names: Sequence[str]) -> None:
    """Raise FitError if a curve is too far from the law for a finite result."""
    is_finite = np.isfinite(fit.own).all(axis=1) & np.isfinite(fit.information).all(axis=(1, 2))
    if not is_finite.all():
        failure = int(np.argmin(is_finite))
        raise FitError.of(
            names[failure],
            f"its peak of {show(float(means.height[failure]), 'N')} at "
            f"{show(float(means.vacuum[failure]), 'Pa')} is too far from the law of this "
            "brake to fit a scale factor and a stiffness. Check the units of force and "
            "elongation and the vacuum, or leave the file out",
        )


@in_double_precision
def fit_own_parameters(
    start: np.ndarray,
    prior: np.ndarray,
    means: ReducedCurves,
    noise: np.ndarray,
    brake: Brake,
    offset: bool,
    loose: float = 1.0,
) -> OwnFit:
    """Fit every curve's own parameters, drawn towards `prior` (curves, 3) with width `WORKING`.

    `loose` multiplies that width.
    """
    count = len(means)
    places = np.arange(-(-count // BLOCK) * BLOCK)
    places[count:] = 0  # pad the last block
    widths = np.r_[loose * WORKING, 1e3, 1.0 if offset else 1e-9]
    law = keep_fitted_law(brake)
    blocks = []
    for block in places.reshape(-1, BLOCK):
        curves = jax.tree.map(lambda a, at=block: a[at], (start, prior, means, noise))
        blocks.append(_compile_solver()(*curves, widths, law))
    point, information, residual = (np.concatenate(a)[:count] for a in zip(*blocks, strict=True))
    weight = means.weight
    stretches = (weight > 0).sum(axis=1)
    variance = (weight * residual**2).sum(axis=1) / np.maximum(stretches - 5, 1)
    starts = np.array(
        [_neighbour_correlation(r[w > 0]) for r, w in zip(residual, weight, strict=True)]
    )
    noise_levels = np.sqrt(variance * (1 + starts) / (1 - starts))
    return OwnFit(
        own=point,
        information=information,
        noise=np.maximum(noise_levels, QUIETEST * means.height),
        residual=residual,
    )


def _neighbour_correlation(residual: np.ndarray) -> float:
    """Return the correlation of neighbouring residuals, 0 to 0.98."""
    offsets = residual - residual.mean()
    square = float((offsets**2).sum())
    if square <= 0 or len(residual) < 10:
        return 0.0
    return float(np.clip((offsets[1:] * offsets[:-1]).sum() / square, 0.0, 0.98))


@functools.cache
def _compile_solver() -> Any:
    """Return a Levenberg-Marquardt solver for `BLOCK` curves at once, compiled once."""

    def solve_curve(
        start: Any, prior: Any, curve: ReducedCurves, noise: Any, widths: Any, brake: Any
    ) -> Any:
        root = jnp.sqrt(curve.weight) / noise
        centre = jnp.concatenate([prior, jnp.zeros(2)])
        pull = 1 / widths**2

        def residual(point: Any) -> Any:
            law = pull_force(
                point, curve.elongation, curve.vacuum, curve.height, curve.onset, brake
            )
            return root * (curve.force - law)

        def normal(point: Any) -> Any:
            residuals, slope = residual(point), -jax.jacfwd(residual)(point)
            deviations = point - centre
            cost = residuals @ residuals + deviations @ (pull * deviations)
            return cost, slope.T @ residuals - pull * deviations, slope.T @ slope

        def take_better_step(state: Any) -> Any:
            point, damping, cost, descent, square, count, _ = state
            matrix = square + jnp.diag(pull)
            step = jnp.linalg.solve(matrix + damping * jnp.diag(jnp.diag(matrix)), descent)
            trial = point + step
            new = normal(trial)
            is_accepted = new[0] <= cost
            has_converged = jnp.max(jnp.abs(step)) < 1e-10
            state_kept = [
                jnp.where(is_accepted, a, b)
                for a, b in zip((trial, *new), (point, cost, descent, square), strict=True)
            ]
            damping = jnp.where(is_accepted, damping / 10, damping * 8)
            return (
                state_kept[0],
                jnp.maximum(damping, 1e-12),
                *state_kept[1:],
                count + 1,
                has_converged,
            )

        def is_unfinished(state: Any) -> Any:
            return (state[5] < 60) & ~state[6] & (state[1] < 1e12)

        first = (start, jnp.asarray(1e-4), *normal(start), 0, jnp.asarray(False))
        point, _, _, _, square, _, _ = jax.lax.while_loop(is_unfinished, take_better_step, first)
        nuisance = square[3:, 3:] + jnp.diag(pull[3:])
        information = square[:3, :3] - square[:3, 3:] @ jnp.linalg.solve(nuisance, square[3:, :3])
        return (
            point,
            information,
            residual(point) * noise / jnp.where(root > 0, jnp.sqrt(curve.weight), 1.0),
        )

    return jax.jit(jax.vmap(solve_curve, in_axes=(0,) * 4 + (None, None)))
