"""Softening of a rubber by its first loading, after Ogden and Roxburgh (1999).

Once a point has reached the energy density W_max, its stress below that is eta times the stress of
first loading, with eta = 1 - erf((W_max - W)/(m + beta W_max))/r. This is reversible until W_max
grows. When unloaded, the point returns W_max - D(W_max); D is counted as heat when W_max is
reached. D rises with W_max, so that softening never releases energy.
"""

from typing import Any

from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.mechanics.arrays import erf, xp

_ROOT_PI = xp.pi**0.5


def _width(peak_energy: Any, rubber: Hyperelastic) -> Any:
    return rubber.softening_m + rubber.softening_beta * peak_energy


def softening(energy: Any, peak_energy: Any, rubber: Hyperelastic) -> tuple[Any, Any]:
    """Return eta [-] and its slope versus energy [1/Pa]; `peak_energy` is the highest so far."""
    if rubber.softening_r is None:
        return xp.ones_like(energy), xp.zeros_like(energy)
    width = _width(peak_energy, rubber)
    energy_gap = (peak_energy - energy) / width
    eta = 1 - erf(xp.maximum(energy_gap, 0.0)) / rubber.softening_r
    slope = 2 / _ROOT_PI * xp.exp(-(energy_gap**2)) / (rubber.softening_r * width)
    return eta, xp.where(energy_gap > 0, slope, 0.0)


def _erf_integral(below: Any) -> Any:
    """Return the integral of erf from 0."""
    return below * erf(below) + xp.expm1(-(below**2)) / _ROOT_PI


def lost_energy(peak_energy: Any, rubber: Hyperelastic) -> Any:
    """Return D [Pa], the energy per unit volume lost by softening once W_max was reached."""
    if rubber.softening_r is None:
        return xp.zeros_like(peak_energy)
    width = _width(peak_energy, rubber)
    return width * _erf_integral(peak_energy / width) / rubber.softening_r


def elastic_energy(energy: Any, peak_energy: Any, rubber: Hyperelastic) -> Any:
    """Return the energy per unit volume [Pa] that a softened point can still return."""
    if rubber.softening_r is None:
        return energy
    width = _width(peak_energy, rubber)
    area = _erf_integral(peak_energy / width) - _erf_integral(
        xp.maximum(peak_energy - energy, 0.0) / width
    )
    return energy - width * area / rubber.softening_r
