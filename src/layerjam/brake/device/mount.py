"""Mounting of the brake: the clamp in the caps, the rope of the drop test, and the site."""

from typing import Any

from layerjam.core.conversion import Quantity
from layerjam.core.units import flag, quantity, record

WIDTH_OF_A_SCREW = 20e-3
"""Sheet width for each screw of a cap [m], unless the number of screws is stated."""


@record
class Mount:
    """Clamp of the sheets in the caps."""

    clamped_length: Quantity[float] = quantity("m", "length of a sheet inside the cap", lo=0, hi=1)
    screw_hole: Quantity[float] = quantity(
        "m", "diameter of the screw's hole through the sheets", hi=0.1
    )
    screws: Quantity[int | None] = quantity(
        "1",
        "screws in each cap, in a row (default: one for every 20 mm of width)",
        lo=1,
        hi=25,
        whole=True,
        default=None,
    )
    spacers: bool | None = flag(
        "whether spacers of the film's thickness lie between the sheets in both caps", default=None
    )

    def count_screws(self, width: Any) -> Any:
        """Return the number of screws in each cap: as stated, or the default for a width [m]."""
        if self.screws is not None:
            return self.screws
        share = width / WIDTH_OF_A_SCREW
        nearest = round(share) if isinstance(share, float) else share.round()
        return nearest + (nearest < 1)


@record
class Rope:
    """The rope between a falling mass and the brake; it can only pull (paper, section III-E)."""

    stiffness: Quantity[float] = quantity(
        "N/m",
        "stiffness of the rope in the brake's drop test; stops use --rope-stiffness instead",
        lo=1,
        hi=1e9,
        symbol="k_r",
    )
    damping: Quantity[float] = quantity("N s/m", "damping of the rope", hi=1e6, default=0.0)


@record
class Site:
    """Conditions at the site of the brake."""

    atmosphere: Quantity[float] = quantity(
        "Pa", "atmospheric pressure at the site", lo=1e4, hi=1.2e5, symbol="p_atm", default=101325.0
    )
    gravity: Quantity[float] = quantity(
        "m/s^2", "gravity at the site", lo=0, hi=100, symbol="g", default=9.80665
    )
