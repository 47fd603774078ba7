"""What holds the brake: the clamp in the caps, and the rope of the drop test."""

from __future__ import annotations

from layerjam.units import flag, quantity, record


@record
class Mount:
    """How the sheets are held in the caps."""

    clamped_length: float = quantity("m", "length of a sheet inside the cap", lo=0, hi=1)
    screw_hole: float = quantity("m", "diameter of the screw's hole through the sheets", hi=0.1)
    spacers: bool | None = flag(
        "whether spacers of the film's thickness lie between the sheets in both caps", default=None
    )


@record
class Rope:
    """The rope between a falling mass and the brake; it only pulls (paper, section III-E)."""

    stiffness: float = quantity(
        "N/m",
        "stiffness of the rope of the paper's drop test; commands take --rope-stiffness",
        lo=1,
        hi=1e9,
        symbol="k_r",
    )
    damping: float = quantity("N s/m", "damping of the rope", hi=1e6, default=0.0)


@record
class Site:
    """Where the brake is used."""

    atmosphere: float = quantity(
        "Pa", "atmospheric pressure at the site", lo=1e4, hi=1.2e5, symbol="p_atm", default=101325.0
    )
    gravity: float = quantity(
        "m/s^2", "gravity at the site", lo=0, hi=100, symbol="g", default=9.80665
    )
