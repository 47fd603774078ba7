"""The silicone enclosure around the stack."""

from __future__ import annotations

from layerjam.units import quantity, record


@record
class Enclosure:
    """What encloses the stack; two faces of it carry load (paper, section II-B)."""

    wall: float = quantity("m", "wall thickness of the enclosure", lo=1e-5, hi=0.05, symbol="w_e")
    modulus: float = quantity(
        "Pa", "modulus of the enclosure at 100 % stretch", lo=1e3, hi=1e9, symbol="E_e"
    )
    density: float = quantity("kg/m^3", "density of the enclosure", lo=100, hi=5000)
