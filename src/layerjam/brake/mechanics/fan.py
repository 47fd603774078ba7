"""Self-amplified friction of a fan: sheets clamped without spacers (after Alarcon et al. 2016).

A cap without spacers clamps its sheets at a pitch t, but in the overlap their pitch is 2t. Sheet i,
counted from the middle, therefore runs to the overlap at the angle i t/L. At both ends of the
overlap its tension T presses on all interfaces further inside. With T = 2 mu N for a sheet that
rubs on both faces, dT/di = -2 mu T (1/L1 + 1/L3) i t. So T = T_outer exp(alpha (1 - (i/m)^2)) for
the m = n/4 sheets of one side's half, alpha = mu t m^2 (1/L1 + 1/L3). The factor is the ratio of
their mean to T_outer.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import erf, freeze, repeat, xp
from layerjam.brake.mechanics.effects import list_effects
from layerjam.brake.mechanics.law import keep_if, law

STEEPEST = 1.0
"""Slope of the outermost sheet, n t/(4 L), above which the angles are not small."""
_TERMS = 14
_STEPS = 8
"""Newton steps on a convex curve; convergence is quadratic, so the last ones change nothing."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(32)


class Fan(NamedTuple):
    """Effect of the fanning of the sheets on their friction."""

    strength: Any
    """mu t m^2 [m], with the friction of the sheets without a fan; 0 with spacers."""
    left: Any
    """Free length at rest [m]."""
    right: Any
    reference: Any
    """The factor that the scale factor already contains."""


class Sheets(NamedTuple):
    """The sheets' friction at a vacuum, c (overlap - x), times the factor of their fan."""

    c: Any
    overlap: Any
    fan: Fan | None
    """None if the brake does not state whether it has spacers."""


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


def fan_factor(slip: Any, fan: Fan) -> Any:
    """Return the factor at a slip [m] relative to that already in the scale factor."""
    return fan_mean(xp.asarray(fan_exponent(slip, fan), xp.float64)) / fan.reference


def fan_force(slip: Any, sheets: Any) -> Any:
    """Return the friction [N] at a slip [m] of `Sheets`, or any object with c, overlap and fan."""
    plain = sheets.c * xp.maximum(sheets.overlap - slip, 0.0)
    return plain if sheets.fan is None else plain * fan_factor(slip, sheets.fan)


def scale_friction(sheets: Any, factor: Any) -> Any:
    """Return the sheets with `factor` times the friction coefficient, which their fan amplifies.

    All interfaces slide at the same speed, so a speed-dependent coefficient is the same for all,
    and the derivation above remains valid.
    """
    fan = sheets.fan
    if fan is not None:
        fan = fan._replace(strength=fan.strength * factor)
    return sheets._replace(c=sheets.c * factor, fan=fan)


def log_slope(slip: Any, sheets: Any) -> Any:
    """Return the slope of friction versus the logarithm of its coefficient [N]."""
    force = fan_force(slip, sheets)
    if sheets.fan is None:
        return force
    alpha = xp.asarray(fan_exponent(slip, sheets.fan), xp.float64)
    return force * (1 + alpha * _fan_mean_slope(alpha) / fan_mean(alpha))


def fan_tangent(slip: Any, sheets: Any) -> Any:
    """Return the sheets without a fan whose friction is tangent to this one at a slip [m]."""
    if sheets.fan is None:
        return sheets
    slip = xp.clip(slip, 0.0, sheets.overlap)
    fan, left = sheets.fan, sheets.overlap - slip
    alpha = xp.asarray(fan_exponent(slip, fan), xp.float64)
    ratio = fan_mean(alpha) / fan.reference
    slope = _fan_mean_slope(alpha) / fan.reference
    shrink = fan.strength * (1 / (fan.left + slip) ** 2 + 1 / (fan.right + slip) ** 2)
    steep = ratio + left * slope * shrink
    reach = slip + left * ratio / steep
    return sheets._replace(c=sheets.c * steep, overlap=reach, fan=None)


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


def fan_work(start: Any, end: Any, sheets: Any) -> Any:
    """Return the work of friction [J] between two slips [m]; the overlap may end in between."""
    start, end = xp.minimum(start, sheets.overlap), xp.minimum(end, sheets.overlap)
    if sheets.fan is None:
        return sheets.c * (end - start) * (sheets.overlap - (start + end) / 2)
    # one slip may belong to many frictions
    none = 0.0 * sheets.c
    return _integrate(lambda slip: fan_force(slip, sheets), start + none, end + none, sheets.fan)


def growing_work(start: Any, end: Any, sheets: Any, c: Any) -> Any:
    """Return the same if c changes linearly from `c` [N/m] to that of `sheets` over the slip."""
    slide = end - start
    if sheets.fan is None:
        work = sheets.c * slide * (sheets.overlap - (end + start) / 2)
        if c is sheets.c:
            return work
        return work - (sheets.c - c) * slide * ((sheets.overlap - start) / 2 - slide / 6)
    part = xp.where(slide != 0, slide, 1.0)

    def force(slip: Any) -> Any:
        friction = c + (sheets.c - c) * (slip - start) / part
        return fan_force(slip, sheets._replace(c=friction))

    return _integrate(force, start, end, sheets.fan)


def _integrate(force: Callable[[Any], Any], start: Any, end: Any, fan: Fan) -> Any:
    """Return the integral [J] by 32-point Gauss quadrature over ln(L + x), which is smooth."""
    least = xp.minimum(fan.left, fan.right)
    low, high = xp.broadcast_arrays(xp.log(least + start), xp.log(least + end))
    shape = (-1,) + (1,) * low.ndim
    nodes, weights = (xp.asarray(a).reshape(shape) for a in (_NODES, _WEIGHTS))
    half = (high - low) / 2
    place = xp.exp(low + half * (nodes + 1))
    return (weights * half * place * force(place - least)).sum(axis=0)


def solve_fan(solve: Callable[[Any], Any], start: Any, sheets: Any) -> Any:
    """Return the slip at which `solve` finds an equilibrium, for friction along any curve.

    `solve` assumes a linear friction; each step uses the tangent at the result of the previous one.
    The search is not differentiated; only the last step carries the gradient of the root.
    """
    if sheets.fan is None:
        return solve(sheets)

    def step(_: int, slip: Any) -> Any:
        return solve(fan_tangent(slip, sheets)) + xp.zeros_like(slip)

    first = solve(fan_tangent(start, sheets))
    root = repeat(_STEPS, step, first)
    return solve(fan_tangent(freeze(root), sheets))


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


def require_flat(brake: Brake, caller: str) -> Brake:
    """Return the brake without its fan, for a `caller` that needs friction linear in slip.

    With spacers, the fan of a different brake is removed from the scale factor. Raises
    QuantityError for a brake without spacers.
    """
    for effect in list_effects(brake):
        if effect.depends_on_slip and effect.is_active(brake):
            raise effect.refuse(caller)
    return remove_fan(brake)


def remove_fan(brake: Brake) -> Brake:
    """Return the brake with flat sheets: its scale factor without the effect of a fan.

    A brake that does not state whether it has spacers is unchanged.
    """
    for effect in list_effects(brake):
        if effect.depends_on_slip:
            brake = effect.remove(brake)
    return brake


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
