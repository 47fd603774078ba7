"""Force over mass of brakes, beside devices that others make (paper III-F, Fig. 12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from layerjam.design.published import PublishedDevice, PublishedDevices, published_devices
from layerjam.device.brake import Brake, mass, sheet_mass
from layerjam.device.file import BrakeFile
from layerjam.errors import Notice
from layerjam.mechanics import pull
from layerjam.units import show

WITH_FACTOR = ("max_force", "holding_force", "force_density", "energy_capacity", "peak_vacuum")
"""Numbers of a brake that its scale factor moves."""


def uneven(files: Sequence[BrakeFile]) -> list[Notice]:
    """Said where brakes are compared of which some are calibrated and some are not."""
    with_pulls, without = (
        list(dict.fromkeys(f.name for f in files if f.calibrated is is_so))
        for is_so in (True, False)
    )
    if not (with_pulls and without):
        return []
    one = len(without) == 1
    return [
        Notice(
            f"{', '.join(with_pulls)} {'is' if len(with_pulls) == 1 else 'are'} calibrated, "
            f"{', '.join(without)} {'is' if one else 'are'} not: the forces of "
            f"{'that brake' if one else 'those brakes'} rest on a scale factor that no pull has "
            "shown (the paper's two are 0.875 and 1.24), so a difference of some 20 % says nothing",
            "calibrated-with-uncalibrated",
        )
    ]


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


KIND = "layer-jamming brake"
PAPER_VACUUM = 94.5e3
"""The paper's tests [Pa], and so its 17.5 N a sheet."""
LOWER = (PAPER_VACUUM, 50e3, 20e3)
STACKED = (2, 5, 10)
OF_SOME = {
    "vacuum": None,
    "sheets": None,
    "brakes": 1,
    "torque": None,
    "lever": None,
    "calibrated": None,
}
"""What a row holds that is known of our brakes only, or of rotary devices only."""


def comparison(
    brakes: Sequence[BrakeFile], vacuums: Sequence[float]
) -> tuple[list[dict[str, Any]], dict[str, Any], list[SheetLine], PublishedDevices]:
    """(rows, what a sheet of the first adds, lines of sheet counts, the catalogue of others).

    `vacuums` [Pa] of the brakes, one each; the first is also shown at lower ones and stacked.
    """
    others = published_devices()
    first, full = brakes[0], vacuums[0]
    rows = [_ours(file, p) for file, p in zip(brakes, vacuums, strict=True)]
    rows += [_ours(first, p) for p in LOWER if p < full]
    rows += [_ours(first, full, brakes=n) for n in STACKED]
    rows += [
        _row(d.name, d.kind, d.mass, d.force, d.source(), d.note, torque=d.torque, lever=d.lever)
        for d in others.devices
    ]
    lines = [sheet_line(f.name, f.brake, p) for f, p in zip(brakes, vacuums, strict=True)]
    return rows, _sheet(first, others.sheet), lines, others


def _row(
    name: str, kind: str, mass: float, force: float, source: str, note: str, **more: Any
) -> dict[str, Any]:
    """A device: mass [kg], force [N], and what is known of some of them only."""
    known = {"name": name, "kind": kind, "mass": mass, "max_force": force}
    known |= {"force_density": force / mass, "source": source, "note": note, "computed": False}
    return {**known, **OF_SOME, **more}


def _ours(file: BrakeFile, vacuum: float, *, brakes: int = 1) -> dict[str, Any]:
    brake = file.brake
    stacked = f", {brakes} side by side" if brakes > 1 else ""
    weighed = "a balance" if brake.weighed_mass is not None else "sheets, enclosure and fittings"
    factor = file.sources.get("scale_factor")
    said = f"; scale factor {brake.scale_factor:g}, {factor.sentence()}" if factor else ""
    return _row(
        f"{file.name}{stacked}, {show(vacuum, 'Pa', 4)}",
        KIND,
        brakes * mass(brake),
        brakes * peak_force(brake, vacuum),
        f"computed: peak of a pull; mass from {weighed}{said}",
        _guessed(file),
        computed=True,
        vacuum=vacuum,
        sheets=brake.sheets.count,
        brakes=brakes,
        calibrated=file.calibrated,
    )


def _guessed(file: BrakeFile) -> str:
    """Said where the friction behind the force was not measured for this brake."""
    source = file.sources.get("film.kinetic")
    if source is None or source.kind not in ("handbook", "assumed", "unstated"):
        return ""
    conflict = f": {source.conflict}" if source.conflict else ""
    return f"friction not measured on this brake ({source.kind}){conflict}"


def _sheet(file: BrakeFile, paper: PublishedDevice) -> dict[str, Any]:
    """What one more sheet adds at the vacuum of the paper's tests, beside what the paper prints."""
    vacuum = min(PAPER_VACUUM, file.brake.site.atmosphere)
    force, weight = one_more_sheet(file.brake, vacuum)
    return {
        "brake": file.name,
        "vacuum": vacuum,
        "force_per_sheet": force,
        "mass_per_sheet": weight,
        "density_per_sheet": force / weight,
        "sheet_mass": sheet_mass(file.brake),
        "paper_force": paper.force,
        "paper_mass": paper.mass,
        "paper_density": paper.density,
        "paper_words": paper.words,
        "why": "ours counts the enclosure that grows around the sheet; the paper's mass is that of "
        "the bare sheet",
    }
