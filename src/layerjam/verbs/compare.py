"""`compare`: force over mass of layer-jamming brakes, beside what others make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from layerjam.design.force_density import one_more_sheet, peak_force, sheet_line
from layerjam.design.rivals import Rival, Rivals, rivals
from layerjam.device.brake import mass, sheet_mass
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue
from layerjam.units import show
from layerjam.verbs.answer import Answer, AnyBrake, Quantity, brake_at, vacuum_of

KIND = "layer-jamming brake"
PAPER_VACUUM = 94.5e3
"""The paper's tests [Pa], and so its 17.5 N a sheet."""
LOWER = (PAPER_VACUUM, 50e3, 20e3)
STACKED = (2, 5, 10)
UNITS = {
    "mass": "kg", "max_force": "N", "force_density": "N/kg", "vacuum": "Pa", "sheets": "1",
    "brakes": "1", "torque": "N m", "lever": "m", "force_per_sheet": "N", "mass_per_sheet": "kg",
    "density_per_sheet": "N/kg", "sheet_mass": "kg", "paper_force": "N", "paper_mass": "kg",
    "paper_density": "N/kg",
}  # fmt: skip


def compare(
    *brakes: AnyBrake, vacuum: Quantity | None = None, atmosphere: Quantity | None = None
) -> Answer:
    """Mass, greatest force and force density of brakes and of what others make (paper, III-F).

    Without brakes, those of the catalogue. `vacuum` is that of ours (the site's full vacuum, as in
    `show`). The first brake is also shown at lower vacuums, stacked, and with more sheets.
    `devices` is a list of rows with their source; `computed` is True for ours. `sheet` compares
    what a sheet adds with the paper's words. `none_found` maps a class without a sourced device to
    what was looked at. `record` is (devices, SheetLine list, Rivals).
    """
    made = [brake_at(b, atmosphere) for b in brakes or catalogue()]
    at = [f.brake.site.atmosphere if vacuum is None else vacuum_of(vacuum, f.brake) for f in made]
    others = rivals()
    first, full = made[0], at[0]
    rows = [_row(file, p) for file, p in zip(made, at, strict=True)]
    rows += [_row(first, p) for p in LOWER if p < full]
    rows += [_row(first, full, brakes=n) for n in STACKED]
    lines = [sheet_line(f.name, f.brake, p) for f, p in zip(made, at, strict=True)]
    sheet = _sheet(first, others.sheet)
    rows += [_other(r) for r in others.devices]
    warnings = [
        "force density is force over the device's own mass: pump, valve and supply are not in it, "
        "of ours or of others",
        "the devices of others were found in what could be read, not chosen as the best of their "
        "class",
    ]
    return Answer(
        values={
            "devices": rows,
            "sheet": sheet,
            "lines": [vars(line) for line in lines],
            "none_found": dict(others.looked_for),
        },
        units=UNITS,
        warnings=[w for file in made for w in file.warnings()] + warnings,
        record=(rows, lines, others),
    )


def _row(file: BrakeFile, vacuum: float, *, brakes: int = 1) -> dict[str, Any]:
    brake = file.brake
    force, weight = brakes * peak_force(brake, vacuum), brakes * mass(brake)
    stacked = f", {brakes} side by side" if brakes > 1 else ""
    weighed = "a balance" if brake.weighed_mass is not None else "sheets, sleeve and fittings"
    factor = file.sources.get("scale_factor")
    said = f"; scale factor {brake.scale_factor:g}, {factor.sentence()}" if factor else ""
    return {
        "name": f"{file.name}{stacked}, {show(vacuum, 'Pa', 4)}",
        "kind": KIND,
        "mass": weight,
        "max_force": force,
        "force_density": force / weight,
        "source": f"computed: peak of a pull; mass from {weighed}{said}",
        "note": _guessed(file),
        "computed": True,
        "vacuum": vacuum,
        "sheets": brake.sheets.count,
        "brakes": brakes,
        "torque": None,
        "lever": None,
    }


def _guessed(file: BrakeFile) -> str:
    """Said where the friction behind the force was not measured for this brake."""
    source = file.sources.get("film.kinetic")
    if source is None or source.kind not in ("handbook", "assumed", "unstated"):
        return ""
    conflict = f": {source.conflict}" if source.conflict else ""
    return f"friction not measured on this brake ({source.kind}){conflict}"


def _other(rival: Rival) -> dict[str, Any]:
    return {
        "name": rival.name,
        "kind": rival.kind,
        "mass": rival.mass,
        "max_force": rival.force,
        "force_density": rival.density,
        "source": rival.source(),
        "note": rival.note,
        "computed": False,
        "vacuum": None,
        "sheets": None,
        "brakes": 1,
        "torque": rival.torque,
        "lever": rival.lever,
    }


def _sheet(file: BrakeFile, paper: Rival) -> dict[str, Any]:
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
        "why": "ours counts the sleeve that grows around the sheet; the paper's mass is that of "
        "the bare sheet",
    }


def listing(rows: Sequence[dict[str, Any]], sheet: dict[str, Any], others: Rivals) -> list[str]:
    """The answer as lines for a terminal, the source under every row."""
    lines = ["mass, greatest force, force over mass"]
    for row in rows:
        lines += [
            "",
            f"{row['name']} ({row['kind']}): {show(row['mass'], 'kg')}, "
            f"{show(row['max_force'], 'N')}, {show(row['force_density'], 'N/kg')}",
            f"    {row['source']}",
        ]
        if row["note"]:
            lines.append(f"    {row['note']}")
    lines += [
        "",
        f"one more sheet in {sheet['brake']} at {show(sheet['vacuum'], 'Pa')}: "
        f"{show(sheet['force_per_sheet'], 'N')} and {show(sheet['mass_per_sheet'], 'kg')} "
        f"({show(sheet['sheet_mass'], 'kg')} bare), {show(sheet['density_per_sheet'], 'N/kg')}",
        f"    the paper: {show(sheet['paper_force'], 'N')} and {show(sheet['paper_mass'], 'kg')}, "
        f"{show(sheet['paper_density'], 'N/kg')}; {sheet['why']}",
        "",
        "none found (a device whose mass and force stand in a source that could be read)",
    ]
    lines += [f"  {kind}: {what}" for kind, what in others.looked_for.items()]
    return lines
