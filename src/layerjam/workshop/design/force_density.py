"""Force per mass of a brake, and the effect of adding sheets (paper, section III-F, Fig. 12)."""

from dataclasses import dataclass

from layerjam.brake.device.brake import Brake, mass
from layerjam.brake.mechanics import pull
from layerjam.core.brief import brief
from layerjam.core.evolve import evolve

SHEETS = (21, 41, 81, 161, 321)


@brief
@dataclass(frozen=True, kw_only=True)
class SheetLine:
    """A brake with increasing numbers of sheets: sheet counts, masses [kg] and forces [N]."""

    brake: str
    vacuum: float
    """Vacuum [Pa]."""
    sheets: tuple[int, ...]
    masses: tuple[float, ...]
    forces: tuple[float, ...]


def peak_force(brake: Brake, vacuum: float) -> float:
    """Return the peak force [N] of a slow pull over the usable travel, as `show` prints it."""
    return float(pull.peak(vacuum, brake.sheets.usable_travel, brake).force)


def set_sheet_count(brake: Brake, count: int) -> Brake:
    """Return the brake with a different number of sheets; caps and fittings keep their mass.

    For a weighed brake, the difference between the weighed mass and the model is kept.
    """
    variant = evolve(brake, sheets=evolve(brake.sheets, count=count))
    if brake.weighed_mass is None:
        return variant
    difference = mass(evolve(variant, weighed_mass=None)) - mass(evolve(brake, weighed_mass=None))
    return evolve(variant, weighed_mass=brake.weighed_mass + difference)


def added_sheet_effect(brake: Brake, vacuum: float) -> tuple[float, float]:
    """Return the force [N] and mass [kg] that one more sheet adds, enclosure included."""
    thicker = set_sheet_count(brake, brake.sheets.count + 1)
    return peak_force(thicker, vacuum) - peak_force(brake, vacuum), mass(thicker) - mass(brake)


def make_sheet_line(name: str, brake: Brake, vacuum: float) -> SheetLine:
    """Return a brake's force and mass for its own and larger numbers of sheets; vacuum [Pa]."""
    count = brake.sheets.count
    counts = (count, *(n for n in SHEETS if n > count))
    variants = [set_sheet_count(brake, n) for n in counts]
    return SheetLine(
        brake=name,
        vacuum=vacuum,
        sheets=counts,
        masses=tuple(mass(b) for b in variants),
        forces=tuple(peak_force(b, vacuum) for b in variants),
    )
