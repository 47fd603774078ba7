"""`compare`: force over mass of layer-jamming brakes, beside what others make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, vacuum_of
from layerjam.design.comparison import comparison
from layerjam.design.published import PublishedDevices
from layerjam.device.load import catalogue
from layerjam.units import show

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
    what was looked at. `record` is (devices, SheetLine list, PublishedDevices).
    """
    made = [brake_at(b, atmosphere) for b in brakes or catalogue()]
    at = [f.brake.site.atmosphere if vacuum is None else vacuum_of(vacuum, f.brake) for f in made]
    rows, sheet, lines, others = comparison(made, at)
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


def listing(
    rows: Sequence[dict[str, Any]], sheet: dict[str, Any], others: PublishedDevices
) -> list[str]:
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
