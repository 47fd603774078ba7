"""Force over mass of a brake, and what more sheets do to both (paper, section III-F, Fig. 12)."""

from __future__ import annotations

from dataclasses import dataclass, replace

from layerjam.device.brake import Brake, mass
from layerjam.mechanics import pull

SHEETS = (21, 41, 81, 161, 321)


@dataclass(frozen=True, kw_only=True)
class SheetLine:
    """One brake with more and more sheets, all else kept: counts, masses [kg], forces [N]."""

    brake: str
    vacuum: float
    """[Pa]"""
    sheets: tuple[int, ...]
    masses: tuple[float, ...]
    forces: tuple[float, ...]


def peak_force(brake: Brake, vacuum: float) -> float:
    """Greatest force of a slow pull over the usable travel [N], as `show` has it; vacuum [Pa]."""
    return float(pull.peak(vacuum, brake.sheets.usable_travel, brake).force)


def with_sheets(brake: Brake, count: int) -> Brake:
    """The brake with another number of sheets; caps and fittings keep their mass.

    A brake that was weighed keeps the difference between balance and model.
    """
    other = replace(brake, sheets=replace(brake.sheets, count=count))
    if brake.weighed_mass is None:
        return other
    grown = mass(replace(other, weighed_mass=None)) - mass(replace(brake, weighed_mass=None))
    return replace(other, weighed_mass=brake.weighed_mass + grown)


def one_more_sheet(brake: Brake, vacuum: float) -> tuple[float, float]:
    """Force [N] and mass [kg] that one more sheet adds at a vacuum [Pa], its enclosure counted."""
    more = with_sheets(brake, brake.sheets.count + 1)
    return peak_force(more, vacuum) - peak_force(brake, vacuum), mass(more) - mass(brake)


def sheet_line(name: str, brake: Brake, vacuum: float) -> SheetLine:
    """A brake at its own count of sheets and at those of SHEETS above it; vacuum [Pa]."""
    count = brake.sheets.count
    counts = (count, *(n for n in SHEETS if n > count))
    built = [with_sheets(brake, n) for n in counts]
    return SheetLine(
        brake=name,
        vacuum=vacuum,
        sheets=counts,
        masses=tuple(mass(b) for b in built),
        forces=tuple(peak_force(b, vacuum) for b in built),
    )
