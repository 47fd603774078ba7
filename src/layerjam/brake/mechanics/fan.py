"""Self-amplified friction of a fan: sheets clamped without spacers (after Alarcon et al. 2016).

A cap without spacers clamps its sheets at a pitch t, but in the overlap their pitch is 2t. Sheet i,
counted from the middle, therefore runs to the overlap at the angle i t/L. At both ends of the
overlap its tension T presses on all interfaces further inside. With T = 2 mu N for a sheet that
rubs on both faces, dT/di = -2 mu T (1/L1 + 1/L3) i t. So T = T_outer exp(alpha (1 - (i/m)^2)) for
the m = n/4 sheets of one side's half, alpha = mu t m^2 (1/L1 + 1/L3). The factor is the ratio of
their mean to T_outer.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import erf, xp
from layerjam.brake.mechanics.law import keep_if, law

STEEPEST = 1.0
"""Slope of the outermost sheet, n t/(4 L), above which the angles are not small."""
_TERMS = 14
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


class Fan(NamedTuple):
    """Effect of the fanning of the sheets on their friction."""

    strength: Any
    """mu t m^2 [m], with the friction of the sheets without a fan; 0 with spacers."""
    left: Any
    """Free length at rest [m]."""
    right: Any
    reference: Any
    """The factor that the scale factor already contains."""

    def factor(self, slip: Any) -> Any:
        """Return the factor at a slip [m] relative to that already in the scale factor."""
        return fan_mean(self._exponent(slip)) / self.reference

    def fall_over(self, left: Any, slip: Any) -> Any:
        """Return the decrease of the factor along its tangent, over a further slip `left` [m]."""
        slope = _fan_mean_slope(self._exponent(slip)) / self.reference
        shrink = self.strength * (1 / (self.left + slip) ** 2 + 1 / (self.right + slip) ** 2)
        return left * slope * shrink

    def gain(self, slip: Any) -> Any:
        """Return the slope of the factor's logarithm versus that of the friction coefficient."""
        alpha = self._exponent(slip)
        return alpha * _fan_mean_slope(alpha) / fan_mean(alpha)

    def scale(self, factor: Any) -> "Fan":
        """Return the fan with `factor` times the friction coefficient, which it amplifies more."""
        return self._replace(strength=self.strength * factor)

    @property
    def length(self) -> Any:
        """Return the free length [m] within which the factor changes."""
        return xp.minimum(self.left, self.right)

    def amplify_middle(self, stress: Any) -> Any:
        """Return a stress as in the middle sheet at rest, which has the highest pressure."""
        return stress * xp.exp(fan_exponent(0.0, self)) / self.reference

    def interface_factors(self, slip: Any) -> tuple[Any, Any]:
        """Return the factor of each interface at its slip [m], shape (n - 1,), and its fall [1/m].

        The middle interfaces have the highest pressure: each has the mean of exp(alpha (1 - s^2))
        over its part of the stack's half height s.
        """
        count = len(slip)
        middle = (2 * np.arange(count) + 1) / count - 1
        depth = 1 - (middle[:, None] + _NODES / count) ** 2
        left, right = self.left + slip, self.right + slip
        alpha = self.strength * (1 / left + 1 / right)
        fades = self.strength * (1 / left**2 + 1 / right**2)
        growth = np.exp(alpha[:, None] * depth)
        factor = (growth * _WEIGHTS).sum(1) / 2
        fall = fades * (growth * depth * _WEIGHTS).sum(1) / 2
        return factor / self.reference, fall / self.reference

    def _exponent(self, slip: Any) -> Any:
        return xp.asarray(fan_exponent(slip, self), xp.float64)


def make_fan(brake: Brake, factor: Any = 1.0) -> Fan | None:
    """Return the fan of a brake, None if its spacers are unknown; `factor` is (P/P_test)^m."""
    sheets, mount = brake.sheets, brake.mount
    if mount.spacers is None:
        return None
    reference: Any = 1.0 if brake.amplification_held is None else brake.amplification_held
    reference = xp.where(reference > 0, reference, 1.0)  # a design may contain NaN
    friction = brake.scale_factor / reference * brake.film.kinetic * factor
    strength = friction * sheets.thickness * (sheets.count / 4) ** 2
    strength = xp.where(xp.asarray(mount.spacers) > 0, 0.0, strength)
    return Fan(strength, sheets.free_left, sheets.free_right, reference)


def fan_exponent(slip: Any, fan: Fan) -> Any:
    """Return alpha [-] at a slip [m], which lengthens both free lengths."""
    return fan.strength * (1 / (fan.left + slip) + 1 / (fan.right + slip))


def fan_mean(alpha: Any) -> Any:
    """Return sqrt(pi/4 alpha) exp(alpha) erf(sqrt(alpha)): the mean of exp(alpha (1 - s^2))."""
    small = alpha < 0.5
    series = xp.ones_like(alpha)
    for k in reversed(range(1, _TERMS)):
        series = 1 + xp.where(small, alpha, 0.0) / (k + 0.5) * series
    large = xp.where(small, 1.0, alpha)
    root = xp.sqrt(large)
    return xp.where(small, series, xp.sqrt(xp.pi) / (2 * root) * xp.exp(large) * erf(root))


def _fan_mean_slope(alpha: Any) -> Any:
    """Return d mean_of/d alpha: (1 - M + 2 alpha M)/(2 alpha), 2/3 at 0."""
    small = alpha < 0.5
    low = xp.where(small, alpha, 0.0)
    series, term = xp.zeros_like(low), xp.ones_like(low)
    for k in range(1, _TERMS + 1):
        series = series + k * term / (k + 0.5)
        term = term * low / (k + 0.5)
    large = xp.where(small, 1.0, alpha)
    mean = fan_mean(large)
    return xp.where(small, series, mean + (1 - mean) / (2 * large))


@law
def amplification(slip: Any, brake: Brake) -> Any:
    """Return the ratio of friction to Coulomb friction [-] for sheets that fan out, at a slip [m].

    It is sqrt(pi/4 alpha) exp(alpha) erf(sqrt(alpha)) with alpha = a mu_k t (n/4)^2 (1/(L1 + x) +
    1/(L3 + x)), where a is the scale factor without this amplification. NaN for a negative slip,
    for a brake that does not state whether it has spacers, and if a sheet would run to the overlap
    at more than 45 degrees.
    """
    fan = make_fan(brake)
    if fan is None:
        return xp.full(xp.shape(slip), xp.nan)
    return keep_if((slip >= 0) & is_flat(brake), fan_mean(fan_exponent(slip, fan)))


def fan_slope(brake: Brake) -> Any:
    """Return the slope [-] at which the outermost sheet of a fan leaves its cap, n t/(4 L)."""
    sheets = brake.sheets
    least = xp.minimum(sheets.free_left, sheets.free_right)
    return sheets.count * sheets.thickness / (4 * least)


def is_flat(brake: Brake) -> Any:
    """Return whether the sheets are flat, or run to the overlap at no more than 45 degrees."""
    if brake.mount.spacers is None:
        return xp.asarray(True)
    return (xp.asarray(brake.mount.spacers) > 0) | (fan_slope(brake) <= STEEPEST)


def tension_ratio(brake: Brake) -> Any:
    """Return the ratio of the middle sheets' tension to their side's mean [-] at rest."""
    fan = make_fan(brake)
    if fan is None:
        return 1.0
    alpha = xp.asarray(fan_exponent(0.0, fan), xp.float64)
    return xp.exp(alpha) / fan_mean(alpha)
