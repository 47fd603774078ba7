"""What was understood of the files chosen in the table, and how to correct it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.errors import LayerjamError
from layerjam.measure.sidecar import Facts
from layerjam.units import show, spec_of
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
from layerjam.workbench.widgets import Alert, button, chart, dressed, fold, one_line, select

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


class Correct:
    """The panel below the table of files."""

    def __init__(self, desk: Desk, remove: Callable[[Sequence[str]], None]) -> None:
        self.desk, self._remove = desk, remove
        self.rows: list[Row] = []
        self.dark = False
        self._fields: dict[str, Any] = {}
        self._keys: list[str] = []
        with dressed(ui.card(), "laboratory-detail", "w-full", "flat bordered") as self.box:
            name = ui.label("")
            self._name = dressed(name, "", "text-lg font-medium break-all", role="heading")
            with ui.row().classes("w-full items-start gap-6"):
                self._words = ui.column().classes("gap-1").style("flex:1; min-width:300px")
                look = "flex:1; min-width:320px; height:260px"
                self._chart = chart("laboratory-record", "Measured curve", look)
            self._below = ui.column().classes("w-full gap-3")
        self.box.set_visibility(False)

    def fill(self, rows: Sequence[Row], dark: bool) -> None:
        """Show what there is of some files; nothing is rebuilt where nothing has changed."""
        if list(rows) == self.rows and dark == self.dark:
            return
        self.rows, self.dark = list(rows), dark
        self._keys = [r.upload.key for r in rows]
        self.box.set_visibility(bool(rows))
        if not rows:
            return
        alone = len(self.rows) == 1
        self._name.set_text(self.rows[0].upload.name if alone else f"{len(self.rows)} files")
        self._words.clear()
        with self._words:
            self._understood(alone)
        self._draw(alone)
        self._below.clear()
        with self._below:
            if alone:
                self._beginning()
            self._form()

    def _understood(self, alone: bool) -> None:
        for row in self.rows[:SHOWN]:
            if not alone:
                ui.label(row.upload.name).classes("font-medium break-all")
            if row.refused:
                ui.label(row.refused).classes("text-negative").props(
                    'role="alert" data-testid="laboratory-why"'
                )
            for sentence in row.understood:
                ui.label(f"✓ {sentence}").classes("text-sm")
            for sentence in row.warnings:
                ui.label(f"Note: {sentence}").classes("text-sm opacity-80")
        if len(self.rows) > SHOWN:
            ui.label(f"and {len(self.rows) - SHOWN} more")

    def _draw(self, alone: bool) -> None:
        curves = self._curves(alone)
        self._chart.set_visibility(bool(curves))
        axes: dict[str, Any] = {"x": "elongation [mm]", "y": "force [N]"}
        made = options(curves, y_range=(None, None), dark=self.dark, **axes)
        made["grid"] = {"left": 62, "right": 24 if alone else 110, "top": 16, "bottom": 44}
        self._chart.options.clear()
        self._chart.options.update(made)
        self._chart.update()

    def _beginning(self) -> None:
        look = "font-mono text-xs whitespace-pre overflow-x-auto w-full"
        with fold("How the file begins"):
            lines = ui.label("\n".join(beginning(self.rows[0].upload)))
            dressed(lines, "laboratory-beginning", look, "tabindex=0")

    def _curves(self, alone: bool) -> list[Curve]:
        drawn = [(r, t) for r in self.rows[:SHOWN] for t in r.traces][:SHOWN]
        made = []
        for n, (row, trace) in enumerate(drawn):
            unnamed = alone and len(row.traces) == 1
            name = "" if unnamed else (trace.specimen or row.upload.name)[-14:]
            color = COLORS[n % len(COLORS)]
            made.append(Curve(trace.travel * 1e3, trace.force, color, name, width=1.5))
        return made

    def _form(self) -> None:
        said = edits_of(self.desk).get(self._keys[0], {})
        fields: dict[str, Any] = {}
        self._fields = fields
        with ui.row().classes("w-full items-end gap-3"):
            roles = {r.role for r in self.rows}
            role = self.rows[0].role if len(roles) == 1 else None
            fields["role"] = _select("Used as", ROLES, role, "role", "w-56")
            for name in FACTS:
                tip = f"{spec_of(Facts, name).text}, with its unit; empty: as the sidecar says"
                label = name.replace("_", " ").capitalize()
                fields[name] = _text(label, said.get(name, ""), name, tip, self._stated(name))
        corrections = fold("Correct columns, units, signs", "laboratory-correct")
        with corrections, ui.column().classes("gap-3 w-full"):
            self._columns(said)
        self._trouble = Alert("laboratory-edit-problem")
        many = "" if len(self.rows) == 1 else f" to {len(self.rows)} files"
        with ui.row().classes("gap-2"):
            remove = partial(self._remove, self._keys)
            _button(f"Apply{many}", "check", self._apply, "apply", "unelevated")
            _button("Forget corrections", "restart_alt", self._forget, "forget")
            _button("Remove", "delete", remove, "remove")

    def _columns(self, said: dict[str, str]) -> None:
        """What the columns are, in which unit, counted how."""
        fields, declared = self._fields, parameters("pull")
        given = _columns(said.get("column", ""))

        def text(label: str, key: str, example: str, width: str = "w-44") -> None:
            tip = f"{declared[key].sentence} ({declared[key].option})"
            fields[key] = _text(label, said.get(key, ""), key, tip, example, width)

        for role, units in UNITS.items():
            with ui.row().classes("items-end gap-3"):
                name, unit = given.get(role, ("", ""))
                tip = f"Name of the column that holds the {role} (--column)"
                fields[f"{role}-name"] = _text(f"Column of the {role}", name, f"{role}-name", tip)
                known = {"": "its own unit", **{u: u for u in (*units, unit) if u}}
                fields[f"{role}-unit"] = _select("in", known, unit, f"{role}-unit", "w-36")
        text(
            "All columns in order", "columns", "such as time:s,skip,force:N,elongation:mm", "w-full"
        )
        with ui.row().classes("items-end gap-3"):
            for label, key, words in (
                ("Decimal sign", "decimal", DECIMALS),
                ("Counted negative", "negative", SIGNS),
            ):
                tip, now = declared[key].sentence, said.get(key, "")
                fields[key] = _select(label, dict(words), now, key, "w-44", tip)
            text("Specimen", "specimen", "such as 1")
            text("Sheet", "sheet", "")

    def _stated(self, name: str) -> str:
        """What the files say of a fact, for an empty field; else an example."""
        found = {r.vacuum if name == "vacuum" else r.facts.normal_force for r in self.rows}
        value = found.pop()
        if not found and value is not None:
            return f"stated: {show(value, spec_of(Facts, name).unit)}"
        return f"such as {EXAMPLES[name]}"

    def changes(self) -> dict[str, str]:
        """What the form says, as settings of a file."""
        value = {k: str(f.value or "").strip() for k, f in self._fields.items()}
        column = []
        for role in UNITS:
            name, unit = value.pop(f"{role}-name"), value.pop(f"{role}-unit")
            if name:
                column.append(f"{role}:{unit}={name}" if unit else f"{role}={name}")
        value["column"] = "\n".join(column)
        if not value["role"]:
            value.pop("role")
        for name in FACTS:
            value[name] = with_unit(value[name], EXAMPLES[name].partition(" ")[2])
        return value

    def _apply(self) -> None:
        changes = self.changes()
        try:
            check_edit(changes)
        except LayerjamError as err:
            self._trouble.say(one_line(err))
            return
        self._trouble.say("")
        put_edits(self.desk, self._keys, changes)

    def _forget(self) -> None:
        edits = edits_of(self.desk)
        for key in self._keys:
            gone = dict.fromkeys(set(edits.get(key, {})) - {"role"}, "")
            if gone:
                put_edits(self.desk, [key], gone)
        self.rows = []


def _columns(text: str) -> dict[str, tuple[str, str]]:
    """{role: (column's name, unit)} of lines ROLE[:UNIT]=NAME."""
    made = {}
    for line in text.split("\n"):
        said, equals, name = line.partition("=")
        role, _, unit = said.partition(":")
        if equals:
            made[role] = (name, unit)
    return made


def _text(
    label: str, value: str, key: str, tip: str, example: str = "", width: str = "w-44"
) -> ui.input:
    field = ui.input(label, value=value, placeholder=example).tooltip(tip)
    look = "dense outlined stack-label maxlength=300"
    return dressed(field, f"laboratory-{key}", width, look, aria_label=label)


def _select(
    label: str, words: dict[str, str], value: str | None, key: str, width: str, tip: str = ""
) -> ui.select:
    now = value if value in words else None
    box = select(words, label, f"laboratory-{key}", value=now, classes=width, tip=tip)
    return dressed(box, how="stack-label")


def _button(text: str, icon: str, act: Callable[[], Any], key: str, how: str = "flat") -> ui.button:
    return button(text, act, f"laboratory-{key}", icon, how=f"{how} dense no-caps")
