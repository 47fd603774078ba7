"""What a brake would hold more if its sheets fanned out of their caps, for a word of warning.

The law itself is in `mechanics.fan`; here are its two numbers for one brake at rest.
"""

from __future__ import annotations

from layerjam.device.brake import Brake

MATTERS = 0.1
"""Share of the friction from which an answer says what spacers would change."""


def fan_exponent(brake: Brake) -> float:
    """alpha [-] of the sheets at rest, without spacers: a mu_k t (n/4)^2 (1/L1 + 1/L3)."""
    sheets = brake.sheets
    friction = brake.scale_factor / (brake.amplification_held or 1.0) * brake.film.kinetic
    free = 1 / sheets.free_left + 1 / sheets.free_right
    return friction * sheets.thickness * (sheets.count / 4) ** 2 * free


def fan_factor(alpha: float) -> float:
    """The factor on the friction, sqrt(pi/4 alpha) exp(alpha) erf(sqrt(alpha)), as its series."""
    total = term = 1.0
    for k in range(1, 2000):
        term *= alpha / (k + 0.5)
        total += term
        if term < 1e-15 * total:
            break
    return total
