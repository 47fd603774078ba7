"""Tables of the brake's page: two brakes side by side, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from layerjam.commands.edit import BRAKE_FIELDS
from layerjam.design.uneven import WITH_FACTOR
from layerjam.device.file import BrakeFile
from layerjam.units import get, show
from layerjam.workbench.call import result_fields
from layerjam.workbench.tables import Cell, html

ROWS: Mapping[str, int] = MappingProxyType(
    {
        "mass": -1,
        "max_force": 1,
        "holding_force": 1,
        "force_density": 1,
        "energy_capacity": 1,
        "usable_travel": 1,
        "stiffness_before_slip": 0,
        "stiffness_measured": 0,
        "stiffness_sliding": 0,
        "peak_vacuum": 0,
        "buckling_force": 0,
        "sheet_stress": -1,
        "clamp_stress": -1,
        "film_strength": 1,
        "scale_factor": 0,
    }
)
"""Key of `show`, and which is better: more, less, or neither of the two."""


ALIKE = 5e-5
"""Part by which numbers may differ that are called the same: less than is shown of it."""


def verdict(mine: float | None, other: float | None, better: int) -> str:
    """How the first compares with the second: sign, percent and, where it is clear, which wins."""
    if mine is None or other is None:
        return ""
    if mine == other or (other and abs(mine / other - 1) < ALIKE):
        return "same"
    much = _percent(mine / other - 1) if other else "more than none"
    if not better:
        return much
    return f"▲ {much}, better" if (mine - other) * better > 0 else f"▼ {much}, worse"


def _percent(part: float) -> str:
    text = f"{part:+.1%}" if abs(part) >= 0.001 else f"{part:+.2%}"
    return text.replace("-", "−")


def comparison(here: Any, beside: Any | None, even: bool = True) -> str:
    """What the brake is and will do as HTML; with a second brake the difference, in words.

    Where only one of the two is calibrated they are not `even`, and none has the better force.
    """
    heads = ["", here.values["name"]]
    if beside is not None:
        heads += [beside.values["name"], f"{here.values['name']} is"]
    rows: list[list[Cell]] = []
    about = result_fields("show")
    for key, better in ROWS.items():
        unit, mine = here.units[key], here.values[key]
        name = about[key][0].upper() + about[key][1:]
        row: list[Cell] = [name, (show(mine, unit), "font-medium")]
        if beside is not None:
            other = beside.values[key]
            judged = even or key not in WITH_FACTOR
            words = verdict(mine, other, better if judged else 0)
            row += [show(other, unit), (words, _weight(words))]
        rows.append(row)
    return html(heads, rows, (1, 2, 3), "The brake", "brake-numbers")


def _weight(words: str) -> str:
    if words.endswith("better"):
        return "font-bold verdict-better"
    return "verdict-worse" if words.endswith("worse") else "opacity-80"


def sources(file: BrakeFile) -> str:
    """Every number of a brake with its kind and what its file says of it, as HTML."""
    heads = ["Number", "Value", "Kind", "Source", "Spread", "Conflict"]
    rows = []
    for path, (spec, _) in BRAKE_FIELDS.items():
        value, source = get(file.brake, path), file.sources.get(path)
        if value is None:
            continue
        said = ("default", "", "", "")
        if source is not None:
            said = (source.kind, source.text, source.spread, source.conflict)
        rows.append([path, show(value, spec.unit, 6), *said])
    return html(heads, rows, (1,), "Sources", "brake-sources")
