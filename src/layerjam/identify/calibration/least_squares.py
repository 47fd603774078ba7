"""Least squares over all curves at once: what they share, and what each has of its own.

Every curve has its own friction, stiffness, enclosure and slack, scattered about what all share.
The sum of squared residuals plus the squared scatter over a working variance is made least: first
each curve's own parameters with the shared ones held (Levenberg and Marquardt), then the shared
ones, until neither moves. With little noise every curve counts alike; one that tells a parameter
badly counts less in it. How much a curve misses the law is found from the curve alone: were it
found while the others draw on it, a curve unlike them would count as noise and weigh nothing.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.identify.calibration.forward import Reduced, pull_force, reduce
from layerjam.identify.calibration.intervals import Population
from layerjam.identify.curves import Curve, conditions
from layerjam.identify.shape import SHAPE, plain
from layerjam.identify.speed import growth_in
from layerjam.mechanics.pull import scale_factor_of_peak
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.units import show

FREE = ("pressure_exponent", "speed", "force_offset")
"""What `--free` can name."""
WORKING = np.array([0.05, 0.05, 0.15])
"""Scatter between repeats of ln a, ln k and the enclosure's factor that the weights assume."""
LOOSE = 20.0
"""How many times wider than `WORKING` a curve may differ while its own noise is found."""
MISFIT = 0.01
"""Part of the peak by which a stretch is taken to miss the law before that is known."""
QUIETEST = 2e-4
"""Least noise of a stretch, part of the peak: no load cell is better, nor the mean over a bend."""
BLOCK = 6
"""Curves that are solved at once: one shape to compile, and none waits long for the slowest."""
ROUNDS = 12
SETTLED = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnFit:
    """Each curve's own parameters: shape (curves, 5) as in `forward.pull_force`.

    `information` (curves, 3, 3) is what a curve alone tells of its shape, slack and offset left
    open; `noise` [N] (curves,) the residuals of its stretches, grown for their correlation.
    """

    own: np.ndarray
    information: np.ndarray
    noise: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """The shared parameters by name, and all that intervals and checks need.

    `own` is each curve drawn towards what all share, `alone` each curve by itself.
    """

    names: tuple[str, ...]
    population: Population
    own: OwnFit
    alone: OwnFit
    reduced: Reduced
    design: np.ndarray
    held: np.ndarray
    reference_pressure: float
    reference_speed: float | None
    free: tuple[str, ...]
    groups: tuple[tuple[int, ...], ...]
    settled: bool
    rounds: int = field(default=0)

    def shape(self, place: int) -> np.ndarray:
        """(a, k, enclosure's factor) that the shared parameters give a curve."""
        at = self.design[place] @ self.population.estimate + self.held[place]
        return np.array([np.exp(at[0]), np.exp(at[1]), at[2]])


def fit_jointly(
    curves: Sequence[Curve],
    brake: Brake,
    free: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> JointFit:
    """Shared and own parameters of all curves; FitError where they cannot tell what is asked."""
    if not curves:
        raise FitError("calibrate: no pull was given")
    tell = progress or (lambda what, share: None)
    tell("curves are reduced", 0.0)
    reduced = reduce(curves)
    names, design, held, pressure, speed = _design(curves, brake, free)
    start = _start(curves, brake, held)
    shared = np.linalg.lstsq(
        design.reshape(-1, design.shape[2]), (start[:, :3] - held).reshape(-1), rcond=None
    )[0]
    offset = "force_offset" in free
    names_of = [c.name for c in curves]
    alone = _alone(start, reduced, names_of, brake, offset)
    own, noise = alone.own, alone.noise
    settled, rounds = False, 0
    for rounds in range(1, ROUNDS + 1):
        expected = np.einsum("gij,j->gi", design, shared) + held
        fitted = fit_own(own, expected, reduced, noise, brake, offset)
        _check_finite(fitted, reduced, names_of)
        own = fitted.own
        away = own[:, :3] - expected
        root = _roots(fitted.information)
        seen = root @ design
        rest = np.einsum(
            "gij,gj->gi", np.linalg.pinv(np.swapaxes(root, 1, 2), rcond=1e-10), away / WORKING**2
        )
        whole = np.einsum("gki,gkj->ij", seen, seen)
        score = np.einsum("gki,gk->gi", seen, rest)
        step = _step(whole, score.sum(axis=0), names)
        tell("least squares over all curves", min(rounds / 6, 0.99))
        settled = bool(np.abs(step).max() < SETTLED)
        if settled:
            break
        shared = shared + step
    if not np.isfinite(shared).all():
        raise FitError("calibrate: least squares over the curves found no finite answer")
    return JointFit(
        names=names,
        population=Population(estimate=shared, design=seen, residual=rest),
        own=fitted,
        alone=alone,
        reduced=reduced,
        design=design,
        held=held,
        reference_pressure=pressure,
        reference_speed=speed,
        free=tuple(free),
        groups=tuple(conditions(curves)),
        settled=settled,
        rounds=rounds,
    )


def _roots(information: np.ndarray) -> np.ndarray:
    """Symmetric root of the inverse of each curve's variance, `WORKING` and noise together.

    From what the curve alone tells (curves, 3, 3), which may be nothing about some parameter.
    """
    scale = np.diag(WORKING)
    told, axes = np.linalg.eigh(scale @ information @ scale)
    told = np.maximum(told, 0.0)
    root = axes * np.sqrt(told / (1 + told))[:, None, :] @ np.swapaxes(axes, 1, 2)
    return np.asarray(root / WORKING)


def _step(whole: np.ndarray, score: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """How far the shared parameters go; FitError where the curves do not tell one at all."""
    unknown = [n for n, told in zip(names, np.diag(whole), strict=True) if not told > 1e-9]
    if unknown:
        words = ", ".join(unknown)
        raise FitError(
            f"{words}: cannot be told from these curves; do they slide, and over some millimetres?"
        )
    return np.linalg.solve(whole, score)


def _design(
    curves: Sequence[Curve], brake: Brake, free: Sequence[str]
) -> tuple[tuple[str, ...], np.ndarray, np.ndarray, float, float | None]:
    """Names, design (curves, 3, q), what is held (curves, 3), reference pressure and speed."""
    names = list(SHAPE)
    vacuums = np.array([c.vacuum for c in curves])
    pressure = float(np.exp(np.log(vacuums).mean()))
    design = np.tile(np.eye(3), (len(curves), 1, 1))
    held = np.zeros((len(curves), 3))
    speed: float | None = None
    if "pressure_exponent" in free:
        if np.ptp(vacuums) < 0.1 * vacuums.max():
            raise FitError(
                "pressure_exponent: cannot be fitted, all pulls were at about "
                f"{show(float(vacuums.mean()), 'Pa')}; it takes vacuums at least 10 % apart"
            )
        names.append("pressure_exponent")
        design = _with_column(design, np.log(vacuums / pressure))
    elif brake.pressure_exponent is not None and brake.test_pressure is not None:
        held[:, 0] = brake.pressure_exponent * np.log(vacuums / brake.test_pressure)
    held[:, 0] += np.log([growth_in(brake, c.speed, c.path) for c in curves])
    if "speed" in free:
        known = [c.speed for c in curves]
        speeds = np.array([np.nan if s is None else s for s in known])
        if np.isnan(speeds).any():
            missing = next(c.name for c, s in zip(curves, known, strict=True) if s is None)
            raise FitError(f"speed: {missing} tells no speed and has no time; name it in a sidecar")
        if speeds.max() < 1.2 * speeds.min():
            raise FitError(
                "speed: no law can be fitted, all pulls were at about "
                f"{show(float(speeds.mean()), 'm/s')}; it takes speeds at least 20 % apart"
            )
        speed = float(np.exp(np.log(speeds).mean()))
        names.append("speed_slope")
        design = _with_column(design, np.log10(speeds / speed))
    if np.linalg.matrix_rank(design.reshape(-1, design.shape[2])) < design.shape[2]:
        raise FitError("speed: vacuum and speed change together, so that their laws cannot be told")
    return tuple(names), design, held, pressure, speed


def _with_column(design: np.ndarray, of_friction: np.ndarray) -> np.ndarray:
    column = np.zeros((*design.shape[:2], 1))
    column[:, 0, 0] = of_friction
    return np.concatenate([design, column], axis=2)


def _start(curves: Sequence[Curve], brake: Brake, held: np.ndarray) -> np.ndarray:
    straight = [c.pull.stiffness for c in curves if c.pull.straight]
    typical_spring = float(np.median(straight)) if straight else float(working_stiffness(brake))
    spring = [c.pull.stiffness if c.pull.straight else typical_spring for c in curves]
    bare = plain(brake)
    peaks = np.array([c.pull.peak_force for c in curves])
    vacuums = np.array([c.vacuum for c in curves])
    factors = np.asarray(scale_factor_of_peak(peaks, vacuums, bare))
    known = np.isfinite(factors) & np.array([c.pull.has_peak for c in curves])
    logs = np.log(np.where(known, factors, 1.0)) - held[:, 0]
    typical = float(np.median(logs[known])) if known.any() else float(np.log(brake.scale_factor))
    start = np.zeros((len(curves), 5))
    start[:, 0] = np.where(known, logs, typical) + held[:, 0]
    start[:, 1] = np.log(spring)
    start[:, 2] = 1.0
    return start


def _alone(
    start: np.ndarray, reduced: Reduced, names: Sequence[str], brake: Brake, offset: bool
) -> OwnFit:
    """Every curve by itself, from its own features, with the noise that the law leaves in it."""
    own, noise = start, MISFIT * reduced.height
    for _ in range(3):
        found = fit_own(own, start[:, :3], reduced, noise, brake, offset, LOOSE)
        _check_finite(found, reduced, names)
        own, noise = found.own, found.noise
    return found


def _check_finite(found: OwnFit, reduced: Reduced, names: Sequence[str]) -> None:
    """Raise FitError for a curve so far from the law that least squares has no numbers for it."""
    known = np.isfinite(found.own).all(axis=1) & np.isfinite(found.information).all(axis=(1, 2))
    if not known.all():
        lost = int(np.argmin(known))
        raise FitError.of(
            names[lost],
            f"its peak of {show(float(reduced.height[lost]), 'N')} at "
            f"{show(float(reduced.vacuum[lost]), 'Pa')} is so far from the law of this brake that "
            "no scale factor and stiffness can be found; check the units of force and elongation "
            "and the vacuum, or leave the file out",
        )


def fit_own(
    start: np.ndarray,
    expected: np.ndarray,
    reduced: Reduced,
    noise: np.ndarray,
    brake: Brake,
    offset: bool,
    loose: float = 1.0,
) -> OwnFit:
    """Every curve's own parameters, drawn towards `expected` (curves, 3) as `WORKING` says.

    By how much less than that, `loose` says.
    """
    count = len(reduced)
    places = np.arange(-(-count // BLOCK) * BLOCK)
    places[count:] = 0  # the last block is filled up
    widths, bare = np.r_[loose * WORKING, 1e3, 1.0 if offset else 1e-9], plain(brake)
    blocks = []
    for block in places.reshape(-1, BLOCK):
        curves = jax.tree.map(lambda a, at=block: a[at], (start, expected, reduced, noise))
        blocks.append(_solver()(*curves, widths, bare))
    own, information, residual = (np.concatenate(a)[:count] for a in zip(*blocks, strict=True))
    weight = reduced.weight
    stretches = (weight > 0).sum(axis=1)
    variance = (weight * residual**2).sum(axis=1) / np.maximum(stretches - 5, 1)
    alike = np.array([_correlation(r[w > 0]) for r, w in zip(residual, weight, strict=True)])
    grown = np.sqrt(variance * (1 + alike) / (1 - alike))
    return OwnFit(
        own=own,
        information=information,
        noise=np.maximum(grown, QUIETEST * reduced.height),
        residual=residual,
    )


def _correlation(residual: np.ndarray) -> float:
    """Of neighbouring residuals, 0 to 0.98."""
    centred = residual - residual.mean()
    square = float((centred**2).sum())
    if square <= 0 or len(residual) < 10:
        return 0.0
    return float(np.clip((centred[1:] * centred[:-1]).sum() / square, 0.0, 0.98))


@functools.cache
def _solver() -> Any:
    """Levenberg and Marquardt for one curve, over `BLOCK` of them, compiled once."""

    def one(start: Any, expected: Any, of: Reduced, noise: Any, widths: Any, brake: Any) -> Any:
        root = jnp.sqrt(of.weight) / noise
        centre = jnp.concatenate([expected, jnp.zeros(2)])
        pull = 1 / widths**2

        def residual(own: Any) -> Any:
            law = pull_force(own, of.elongation, of.vacuum, of.height, of.onset, brake)
            return root * (of.force - law)

        def normal(own: Any) -> Any:
            rest, slope = residual(own), -jax.jacfwd(residual)(own)
            away = own - centre
            cost = rest @ rest + away @ (pull * away)
            return cost, slope.T @ rest - pull * away, slope.T @ slope

        def better(state: Any) -> Any:
            own, damping, cost, descent, square, count, _ = state
            whole = square + jnp.diag(pull)
            step = jnp.linalg.solve(whole + damping * jnp.diag(jnp.diag(whole)), descent)
            trial = own + step
            new = normal(trial)
            fine = new[0] <= cost
            small = jnp.max(jnp.abs(step)) < 1e-10
            kept = [
                jnp.where(fine, a, b)
                for a, b in zip((trial, *new), (own, cost, descent, square), strict=True)
            ]
            damping = jnp.where(fine, damping / 10, damping * 8)
            return kept[0], jnp.maximum(damping, 1e-12), *kept[1:], count + 1, small

        def going(state: Any) -> Any:
            return (state[5] < 60) & ~state[6] & (state[1] < 1e12)

        first = (start, jnp.asarray(1e-4), *normal(start), 0, jnp.asarray(False))
        own, _, _, _, square, _, _ = jax.lax.while_loop(going, better, first)
        nuisance = square[3:, 3:] + jnp.diag(pull[3:])
        told = square[:3, :3] - square[:3, 3:] @ jnp.linalg.solve(nuisance, square[3:, :3])
        return own, told, residual(own) * noise / jnp.where(root > 0, jnp.sqrt(of.weight), 1.0)

    return jax.jit(jax.vmap(one, in_axes=(0,) * 4 + (None, None)))
