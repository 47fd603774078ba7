"""What was understood of the files chosen in the table, and how to correct it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.errors import LayerjamError
from layerjam.measure.sidecar import Facts
from layerjam.units import show, spec_of
from layerjam.workbench import live
from layerjam.workbench.call import parameters
from layerjam.workbench.charts import Curve, options
from layerjam.workbench.controls import with_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.laboratory_files import (
    FACTS,
    ROLES,
    Row,
    beginning,
    check_edit,
    edits_of,
    put_edits,
)
from layerjam.workbench.widgets import (
    Alert,
    button,
    chart,
    dressed,
    field,
    fold,
    heading,
    one_line,
    select,
)

UNITS = MappingProxyType(
    {
        "force": ("N", "kN", "mN", "lbf", "gf", "kgf"),
        "elongation": ("mm", "m", "µm", "in"),
        "time": ("s", "ms", "min"),
    }
)
EXAMPLES = MappingProxyType({"vacuum": "94.5 kPa", "normal_force": "2.45 N"})
DECIMALS = MappingProxyType({"": "as found", ".": "point", ",": "comma"})
SIGNS = MappingProxyType(
    {
        "": "nothing",
        "force": "the force",
        "elongation": "the elongation",
        "force\nelongation": "both",
    }
)
SHOWN = 6
"""Files whose curves are drawn."""
COLORS = ("main", "second", "good", "bad", "other", "sky")


def columns_said(text: str) -> dict[str, str]:
    """{ROLE-name: its column, ROLE-unit: unit} of lines ROLE[:UNIT]=NAME."""
    made: dict[str, str] = {}
    for line in text.split("\n"):
        said, _, name = line.partition("=")
        role, _, unit = said.partition(":")
        made |= {f"{role}-name": name, f"{role}-unit": unit}
    return made


def changes(value: Mapping[str, str]) -> dict[str, str]:
    """What the form's fields say, as settings of a file."""
    made = {key: text for key, text in value.items() if "-" not in key}
    column = []
    for role in UNITS:
        name, unit = value[f"{role}-name"], value[f"{role}-unit"]
        if name:
            column.append(f"{role}:{unit}={name}" if unit else f"{role}={name}")
    made["column"] = "\n".join(column)
    if not made["role"]:
        made.pop("role")
    for name in FACTS:
        made[name] = with_unit(made[name], EXAMPLES[name].partition(" ")[2])
    return made


class Correct:
    """The panel below the table of files."""

    def __init__(self, desk: Desk, remove: Callable[[Sequence[str]], None]) -> None:
        self.desk, self._remove = desk, remove
        self._shown: tuple[object, ...] = ()
        self.rows: list[Row] = []
        self._said: dict[str, str] = {}
        self._fields: dict[str, Any] = {}
        with dressed(ui.card(), "laboratory-detail", "w-full", "flat bordered") as self.box:
            self._name = heading("").classes("break-all")
            with ui.row().classes("w-full items-start gap-6"):
                self._words = ui.column().classes("gap-1").style("flex:1; min-width:300px")
                look = "flex:1; min-width:320px; height:260px"
                self._chart = chart("laboratory-record", "Measured curve", look)
            self._below = ui.column().classes("w-full gap-3")
        self.box.set_visibility(False)

    @property
    def _keys(self) -> list[str]:
        return [r.upload.key for r in self.rows]

    def fill(self, rows: Sequence[Row], dark: bool) -> None:
        """Show what there is of some files; nothing is rebuilt where nothing has changed."""
        if self._shown == (*rows, dark):
            return
        self._shown, self.rows = (*rows, dark), list(rows)
        self.box.set_visibility(bool(rows))
        if not rows:
            return
        alone = len(rows) == 1
        self._name.set_text(rows[0].upload.shown if alone else f"{len(rows)} files")
        self._words.clear()
        with self._words:
            self._understood(alone)
        self._draw(alone, dark)
        self._below.clear()
        with self._below:
            if alone:
                look = "font-mono text-xs whitespace-pre overflow-x-auto w-full"
                with fold("How the file begins"):
                    lines = ui.label("\n".join(beginning(rows[0].upload)))
                    dressed(lines, "laboratory-beginning", look, "tabindex=0")
            self._form()

    def _understood(self, alone: bool) -> None:
        for row in self.rows[:SHOWN]:
            if not alone:
                ui.label(row.upload.shown).classes("font-medium break-all")
            if row.refused:
                why = ui.label(row.refused)
                dressed(why, "laboratory-why", "text-negative", role="alert")
            for sentence in row.understood:
                ui.label(f"✓ {sentence}").classes("text-sm")
            for sentence in row.warnings:
                ui.label(f"Note: {sentence}").classes("text-sm opacity-80")
        if len(self.rows) > SHOWN:
            ui.label(f"and {len(self.rows) - SHOWN} more")

    def _draw(self, alone: bool, dark: bool) -> None:
        drawn = [(r, t) for r in self.rows[:SHOWN] for t in r.traces][:SHOWN]
        curves = []
        for color, (row, trace) in zip(COLORS, drawn, strict=False):
            unnamed = alone and len(row.traces) == 1
            name = "" if unnamed else (trace.specimen or row.upload.shown)[-14:]
            curves.append(Curve(trace.travel * 1e3, trace.force, color, name, width=1.5))
        self._chart.set_visibility(bool(curves))
        axes: dict[str, Any] = {"x": "elongation [mm]", "y": "force [N]"}
        made = options(curves, y_range=(None, None), dark=dark, **axes)
        made["grid"] = {"left": 62, "right": 24 if alone else 110, "top": 16, "bottom": 44}
        live.draw(self._chart, made)

    def _form(self) -> None:
        said = edits_of(self.desk).get(self._keys[0], {})
        roles = {r.role for r in self.rows}
        role = roles.pop() if len(roles) == 1 else ""
        self._said = {**said, **columns_said(said.get("column", "")), "role": role}
        self._fields = {}
        with ui.row().classes("w-full items-end gap-3"):
            self._select("role", "Used as", ROLES, width="w-56")
            for name in FACTS:
                tip = f"{spec_of(Facts, name).text}, with its unit; empty: as the sidecar says"
                self._text(name, name.replace("_", " ").capitalize(), self._stated(name), tip)
        corrections = fold("Correct columns, units, signs", "laboratory-correct")
        with corrections, ui.column().classes("gap-3 w-full"):
            self._columns()
        self._trouble = Alert("laboratory-edit-problem")
        many = "" if len(self.rows) == 1 else f" to {len(self.rows)} files"
        with ui.row().classes("gap-2"):
            for text, icon, act, key, how in (
                (f"Apply{many}", "check", self._apply, "apply", "unelevated"),
                ("Forget corrections", "restart_alt", self._forget, "forget", "flat"),
                ("Remove", "delete", partial(self._remove, self._keys), "remove", "flat"),
            ):
                button(text, act, f"laboratory-{key}", icon, how=f"{how} dense no-caps")

    def _columns(self) -> None:
        """What the columns are, in which unit, counted how."""
        for role, units in UNITS.items():
            with ui.row().classes("items-end gap-3"):
                name, unit = f"{role}-name", f"{role}-unit"
                tip = f"Name of the column that holds the {role} (--column)"
                self._text(name, f"Column of the {role}", "", tip)
                known = {u: u for u in (*units, self._said.get(unit)) if u}
                self._select(unit, "in", {"": "its own unit", **known}, width="w-36")
        order = "such as time:s,skip,force:N,elongation:mm"
        self._text("columns", "All columns in order", order, width="w-full")
        with ui.row().classes("items-end gap-3"):
            self._select("decimal", "Decimal sign", DECIMALS)
            self._select("negative", "Counted negative", SIGNS)
            self._text("specimen", "Specimen", "such as 1")
            self._text("sheet", "Sheet")

    def _text(
        self, key: str, label: str, example: str = "", tip: str = "", width: str = "w-44"
    ) -> None:
        ident, now = f"laboratory-{key}", self._said.get(key, "")
        made = field(label, ident, now, tip=tip or _about(key), example=example, classes=width)
        self._fields[key] = made

    def _select(self, key: str, label: str, words: Mapping[str, str], width: str = "w-44") -> None:
        now = self._said.get(key, "")
        value, tip, ident = now if now in words else None, _about(key), f"laboratory-{key}"
        made = select(words, label, ident, value=value, classes=width, tip=tip)
        self._fields[key] = dressed(made, how="stack-label")

    def _stated(self, name: str) -> str:
        """What the files say of a fact, for an empty field; else an example."""
        found = {r.vacuum if name == "vacuum" else r.facts.normal_force for r in self.rows}
        value = found.pop()
        if not found and value is not None:
            return f"stated: {show(value, spec_of(Facts, name).unit)}"
        return f"such as {EXAMPLES[name]}"

    def _apply(self) -> None:
        said = changes({k: str(f.value or "").strip() for k, f in self._fields.items()})
        try:
            check_edit(said)
        except LayerjamError as err:
            self._trouble.say(one_line(err))
            return
        self._trouble.say("")
        put_edits(self.desk, dict.fromkeys(self._keys, said))

    def _forget(self) -> None:
        edits = edits_of(self.desk)
        gone = {k: dict.fromkeys(set(edits.get(k, {})) - {"role"}, "") for k in self._keys}
        put_edits(self.desk, gone)
        self._shown = ()


def _about(key: str) -> str:
    """What the option means that says how files are read; nothing of what is none."""
    option = parameters("pull").get(key)
    return "" if option is None else f"{option.sentence} ({option.option})"
