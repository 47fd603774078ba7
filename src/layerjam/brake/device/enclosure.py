"""The silicone enclosure around the stack."""

from layerjam.core.conversion import Quantity
from layerjam.core.units import quantity, record

FORCE_UNCERTAINTY = 0.3
"""Relative standard uncertainty of the enclosure's force, unless the file states one.

The moduli published for the same silicone differ by factors of 1.6 and 2.3 (catalogue: Ecoflex
00-50, 00-30), and its friction is known within a factor of 1.5. The force is proportional to the
square root of their product, which results in 0.27, rounded up.
"""
SILICONE_FRICTION = 1.5
"""Factor within which the friction of the enclosure on the sheets is known without a test."""


@record
class Enclosure:
    """Enclosure of the stack; two of its faces carry load (paper, section II-B)."""

    wall: Quantity[float] = quantity(
        "m", "wall thickness of the enclosure", lo=1e-5, hi=0.05, symbol="w_e"
    )
    modulus: Quantity[float] = quantity(
        "Pa", "modulus of the enclosure at 100 % stretch", lo=1e3, hi=1e9, symbol="E_e"
    )
    density: Quantity[float] = quantity("kg/m^3", "density of the enclosure", lo=100, hi=5000)
    force_uncertainty: Quantity[float | None] = quantity(
        "1",
        "relative standard uncertainty of the enclosure's force; 30 % if not stated",
        hi=2,
        default=None,
    )

    @property
    def force_sd(self) -> float:
        """Relative standard uncertainty of the enclosure's force, from the file or by default."""
        return FORCE_UNCERTAINTY if self.force_uncertainty is None else self.force_uncertainty
