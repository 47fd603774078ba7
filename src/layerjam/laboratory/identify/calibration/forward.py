"""The law in a fit: friction at a pull's speed, reduced curves, parameters and derivatives.

A curve of tens of thousands of samples is reduced to means over sections of elongation, short where
the curve bends and long where it is smooth. A section's weight is its number of samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.brake.mechanics.speed_effects import (
    brake_growth,
    depends_on_speed,
    fix_speed,
    name_speed_effects,
    test_speed,
)
from layerjam.brake.mechanics.tracing import jax, jnp
from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.laboratory.identify.curves import Curve, select_fitted_part
from layerjam.laboratory.identify.shape import change_shape

FINE, COARSE = 320, 320
"""Number of equally long sections below and above `NEAR_END` times the straight rise."""
NEAR_END = 2.0
LEAST_ENCLOSURE = 1e-3
"""Smallest multiplier of the enclosure force within a fit."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedCurves:
    """Curves as arrays of shape (curves, sections); sections without samples have no weight.

    `elongation` [m] and `force` [N] are means over a section. `weight` is its number of samples,
    relative to the mean of the non-empty sections. `vacuum` [Pa], `height` (maximum force [N]) and
    `onset` (elongation [m] at which a straight rise would reach it) have shape (curves,).
    """

    elongation: np.ndarray
    force: np.ndarray
    weight: np.ndarray
    vacuum: np.ndarray
    height: np.ndarray
    onset: np.ndarray

    def __len__(self) -> int:
        return len(self.vacuum)


def reduce_curves(curves: Sequence[Curve]) -> ReducedCurves:
    """Return means over sections of equal elongation, with their weights."""
    parts = [_reduce_curve(curve) for curve in curves]
    height = np.array([c.peak_force for c in curves])
    return ReducedCurves(
        elongation=np.array([p[0] for p in parts]),
        force=np.array([p[1] for p in parts]),
        weight=np.array([p[2] for p in parts]),
        vacuum=np.array([c.vacuum for c in curves]),
        height=height,
        onset=np.array([_find_onset(c) for c in curves]),
    )


def _find_onset(curve: Curve) -> float:
    """Return the elongation [m] at which a straight rise reaches the peak, or that of the peak."""
    place = curve.peak_elongation
    if curve.straight:
        place = curve.peak_force / curve.stiffness
    return float(max(place, 1e-6))


def _reduce_curve(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    part = select_fitted_part(curve)
    u, force = curve.elongation[part], curve.force[part]
    first, last = float(u[0]), float(u.max())
    bend = min(first + NEAR_END * max(_find_onset(curve) - first, 0.0), last)
    bend = bend if bend > first else first + 0.1 * (last - first)
    fine, coarse = (bend - first) / FINE, max(last - bend, 1e-12) / COARSE
    place = np.where(u < bend, (u - first) / fine, FINE + (u - bend) / coarse)
    place = np.clip(place.astype(np.int64), 0, FINE + COARSE - 1)
    count = np.bincount(place, minlength=FINE + COARSE).astype(float)
    samples = np.maximum(count, 1.0)
    mean_u = np.bincount(place, u, FINE + COARSE) / samples
    mean_f = np.bincount(place, force, FINE + COARSE) / samples
    return mean_u, mean_f, count / count[count > 0].mean()


def pull_force(
    parameters: Any, elongation: Any, vacuum: Any, height: Any, onset: Any, brake: Brake
) -> Any:
    """Return the force [N] of one curve; `parameters` (ln a, ln k, enclosure, slack, offset).

    The slack is relative to the onset, the offset to the height. The force is zero before the slack
    is taken up. The gradient is that of the law and finite everywhere, because the slip grows with
    the square of the elongation past the onset.
    """
    enclosure = jnp.maximum(parameters[2], LEAST_ENCLOSURE)
    brake = change_shape(brake, jnp.exp(parameters[0]), jnp.exp(parameters[1]), enclosure)
    taut = jnp.maximum(elongation - parameters[3] * onset, 0.0)
    return force_at_elongation(taut, vacuum, brake) + parameters[4] * height


def friction_growth(brake: Brake, speed: float | None, path: str) -> float:
    """Return the ratio of friction at a speed [m/s] to that at the test speed; 1 without a law.

    Raises FitError if the brake has a law and the speed of the pull is unknown.
    """
    if not depends_on_speed(brake):
        return 1.0
    if speed is None:
        raise FitError.of(
            path,
            "has neither a speed nor a time, but the friction of this brake depends on "
            "speed ([speed_law]); state the speed in a sidecar, or use the brake without "
            "that table",
        )
    return float(brake_growth(speed, brake))


def describe_test_speed(brake: Brake) -> str:
    """Return ", at 13 mm/s (brake's [speed_law])" if friction depends on speed, else ""."""
    if not depends_on_speed(brake):
        return ""
    return f", at {show(test_speed(brake), 'm/s')} (brake's {name_speed_effects(brake)})"


def fix_friction_speed(brake: Brake, speed: float | None, path: str) -> Brake:
    """Return the brake with its friction at a crosshead speed [m/s]; raises as `friction_growth`.

    A scale factor fitted with this brake is valid at the law's test speed.
    """
    friction_growth(brake, speed, path)
    return brake if speed is None else fix_speed(speed, brake)
