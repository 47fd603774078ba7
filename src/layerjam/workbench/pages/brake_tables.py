"""Tables of the brake's page: two brakes side by side, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.commands.edit import BRAKE_FIELDS
from layerjam.device.file import BrakeFile
from layerjam.units import get, show
from layerjam.workbench import live
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


@dataclass(frozen=True)
class Line:
    """One row of the comparison, as shown."""

    name: str
    here: str
    beside: str = ""
    verdict: str = ""


def lines(here: Any, beside: Any | None) -> list[Line]:
    """The rows; with a second brake the difference in words, seen from the first."""
    made = []
    about = result_fields("show")
    for key, better in ROWS.items():
        unit, name = here.units[key], about[key][0].upper() + about[key][1:]
        mine = here.values[key]
        if beside is None:
            made.append(Line(name, show(mine, unit)))
            continue
        other = beside.values[key]
        made.append(Line(name, show(mine, unit), show(other, unit), verdict(mine, other, better)))
    return made


def verdict(mine: float | None, other: float | None, better: int) -> str:
    """How the first compares with the second: sign, percent and, where it is clear, which wins."""
    if mine is None or other is None:
        return ""
    if mine == other:
        return "same"
    much = _percent(mine / other - 1) if other else "more than none"
    if not better:
        return much
    return f"▲ {much}, better" if (mine - other) * better > 0 else f"▼ {much}, worse"


def _percent(part: float) -> str:
    text = f"{part:+.1%}" if abs(part) >= 0.001 else f"{part:+.2%}"
    return text.replace("-", "−")


class Comparison:
    """The table of what the brake is and will do; a second column for a second brake."""

    def __init__(self) -> None:
        self._box = live.Table()

    def fill(self, here: Any, beside: Any | None) -> None:
        """Show one brake, or two and their difference."""
        heads = ["", here.values["name"]]
        if beside is not None:
            heads += [beside.values["name"], f"{here.values['name']} is"]
        rows: list[list[Cell]] = [
            [row.name, (row.here, "font-medium"), row.beside, (row.verdict, _weight(row.verdict))]
            for row in lines(here, beside)
        ]
        shown = (row[: len(heads)] for row in rows)
        self._box.set_content(html(heads, shown, (1, 2, 3), "The brake", "brake-numbers"))


def _weight(words: str) -> str:
    if words.endswith("better"):
        return "font-bold verdict-better"
    return "verdict-worse" if words.endswith("worse") else "opacity-80"


class Sources:
    """Every number of the brake with its kind and what its file says of it."""

    def __init__(self) -> None:
        with ui.element("div").classes("w-full overflow-auto brake-sources"):
            self._box = live.Table()
        self._shown: str | None = None

    def fill(self, file: BrakeFile) -> None:
        """The table of one brake; made anew only where the brake has changed."""
        if file.text == self._shown:
            return
        self._shown = file.text
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
        self._box.set_content(html(heads, rows, (1,), "Sources", "brake-sources"))
