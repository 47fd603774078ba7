"""Two quantities of sheets that fan out of their caps at rest, for warnings and bounds.

The law is in `mechanics.fan`. `Brake` is not imported, because its module imports this one.
"""

from typing import Any

from layerjam.errors import QuantityError
from layerjam.units import show

MATTERS = 0.1
"""Relative change of the friction above which a result mentions spacers."""


def fan_exponent(brake: Any) -> float:
    """Return the exponent alpha at rest, without spacers: a mu_k t (n/4)^2 (1/L1 + 1/L3)."""
    sheets = brake.sheets
    friction = brake.scale_factor / (brake.amplification_held or 1.0) * brake.film.kinetic
    free = 1 / sheets.free_left + 1 / sheets.free_right
    return friction * sheets.thickness * (sheets.count / 4) ** 2 * free


def fan_factor(alpha: float) -> float:
    """Return the factor on friction, sqrt(pi/(4 alpha)) exp(alpha) erf(sqrt(alpha))."""
    total = term = 1.0
    for k in range(1, 2000):
        term *= alpha / (k + 0.5)
        total += term
        if term < 1e-15 * total:
            break
    return total


def check_fan_exponent(brake: Any) -> None:
    """Raise QuantityError for a pressure exponent that is impossible for sheets without spacers.

    Their friction grows exponentially with the coefficient. If the coefficient rose without bound
    as the vacuum falls, the brake would hold without a vacuum. A negative exponent therefore
    requires the lowest pressure of its measurement, from which friction must rise with the vacuum.
    """
    exponent, lowest = brake.pressure_exponent, brake.lowest_pressure
    fans_out = brake.mount.spacers is not None and not brake.mount.spacers
    if lowest is not None and (exponent is None or not fans_out):
        raise QuantityError.of(
            "lowest_pressure",
            "is only valid with a pressure_exponent of sheets without spacers "
            "(mount.spacers = false); other sheets lose their friction with the vacuum "
            "in any case",
        )
    if exponent is None or exponent >= 0 or not fans_out:
        return
    if lowest is None:
        raise QuantityError.of(
            "lowest_pressure",
            f"is missing: with a pressure_exponent of {exponent:g} and no spacers, friction would "
            "grow without bound as the vacuum falls. Give the lowest contact pressure at "
            'which the exponent was measured, such as "20 kPa"',
        )
    alpha = fan_exponent(brake) * (lowest / (brake.test_pressure or lowest)) ** exponent
    factor = fan_factor(alpha)
    # d ln M/d ln alpha for M = sqrt(pi/(4 alpha)) exp(alpha) erf(sqrt(alpha))
    growth = (1 - factor + 2 * alpha * factor) / (2 * factor)
    if 1 + exponent * (1 + growth) <= 0:
        raise QuantityError.of(
            "pressure_exponent",
            f"{exponent:g} is too low for sheets without spacers: at {show(lowest, 'Pa')} "
            f"(lowest_pressure) their friction would fall as the vacuum rises; at least "
            f"{-1 / (1 + growth):.3g} is allowed there",
        )
