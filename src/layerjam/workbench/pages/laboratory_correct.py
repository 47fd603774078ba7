"""What was understood of the files chosen in the table, and how to correct it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nicegui import ui

from layerjam.errors import LayerjamError
from layerjam.measure.sidecar import Facts
from layerjam.units import show, spec_of
from layerjam.workbench.charts import Curve, options
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

UNITS = {"force": ("N", "kN", "mN", "lbf", "gf", "kgf"), "elongation": ("mm", "m", "µm", "in"),
         "time": ("s", "ms", "min")}  # fmt: skip
SHOWN = 6
"""Files whose curves are drawn."""
HELP = {
    "columns": "Every column in order, for files without names: time:ms,force:N,elongation:mm,skip "
    "(--columns)",
    "decimal": "The decimal sign, where a comma could be either (--decimal)",
    "negative": "What this machine counts the other way round (--negative)",
    "specimen": "Which specimen of a file that holds several, from 1 (--specimen)",
    "sheet": "Which sheet of a workbook (--sheet)",
}


class Correct:
    """The panel below the table of files."""

    def __init__(self, desk: Desk, remove: Callable[[Sequence[str]], None]) -> None:
        self.desk, self._remove = desk, remove
        self.rows: list[Row] = []
        self.dark = False
        self._fields: dict[str, Any] = {}
        self._keys: list[str] = []
        with ui.card().classes("w-full").props(
            'flat bordered data-testid="laboratory-detail"'
        ) as self.box:  # fmt: skip
            self._name = (
                ui.label("").classes("text-lg font-medium break-all").props('role="heading"')
            )
            with ui.row().classes("w-full items-start gap-6"):
                self._words = ui.column().classes("gap-1").style("flex:1; min-width:300px")
                self._chart = (
                    ui.echart({})
                    .style("flex:1; min-width:320px; height:260px")
                    .props('data-testid="laboratory-record" role="img" aria-label="Measured curve"')
                )
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
        chart = options(curves, x="elongation [mm]", y="force [N]", y_range=(None, None),
                        dark=self.dark)  # fmt: skip
        chart["grid"] = {"left": 62, "right": 24 if alone else 110, "top": 16, "bottom": 44}
        self._chart.options.clear()
        self._chart.options.update(chart)
        self._chart.update()

    def _beginning(self) -> None:
        with ui.expansion("How the file begins").classes("w-full").props("dense"):
            ui.label("\n".join(beginning(self.rows[0].upload))).classes(
                "font-mono text-xs whitespace-pre overflow-x-auto w-full"
            ).props('data-testid="laboratory-beginning" tabindex=0')

    def _curves(self, alone: bool) -> list[Curve]:
        colors = ("main", "second", "good", "bad", "other", "sky")
        return [
            Curve(trace.travel * 1e3, trace.force, color=colors[n % len(colors)], width=1.5,
                  name="" if alone and len(row.traces) == 1
                  else (trace.specimen or row.upload.name)[-14:])
            for n, (row, trace) in enumerate(
                [(r, t) for r in self.rows[:SHOWN] for t in r.traces][:SHOWN])
        ]  # fmt: skip

    def _form(self) -> None:
        edits = edits_of(self.desk)
        said = edits.get(self._keys[0], {})
        fields: dict[str, Any] = {}
        with ui.row().classes("w-full items-end gap-3"):
            roles = {r.role for r in self.rows}
            fields["role"] = _select(
                "Used as", ROLES, self.rows[0].role if len(roles) == 1 else None, "role", "w-56"
            )
            for name in FACTS:
                spec = spec_of(Facts, name)
                fields[name] = _text(
                    f"{name.replace('_', ' ').capitalize()}", said.get(name, ""), name,
                    f"{spec.text}, with its unit; empty: as the sidecar says",
                    self._stated(name),
                )  # fmt: skip
        with ui.expansion("Correct columns, units, signs").classes("w-full").props(
            'dense data-testid="laboratory-correct"'
        ), ui.column().classes("gap-3 w-full"):  # fmt: skip
            given = _columns(said.get("column", ""))
            for role, units in UNITS.items():
                with ui.row().classes("items-end gap-3"):
                    name, unit = given.get(role, ("", ""))
                    fields[f"{role}-name"] = _text(
                        f"Column of the {role}", name, f"{role}-name",
                        f"Name of the column that holds the {role} (--column)", "",
                    )  # fmt: skip
                    known = {"": "its own unit", **{u: u for u in (*units, unit) if u}}
                    fields[f"{role}-unit"] = _select("in", known, unit, f"{role}-unit", "w-36")
            fields["columns"] = _text("All columns in order", said.get("columns", ""), "columns",
                                      HELP["columns"], "such as time:s,skip,force:N,elongation:mm",
                                      "w-full")  # fmt: skip
            with ui.row().classes("items-end gap-3"):
                fields["decimal"] = _select(
                    "Decimal sign", {"": "as found", ".": "point", ",": "comma"},
                    said.get("decimal", ""), "decimal", "w-36", HELP["decimal"],
                )  # fmt: skip
                fields["negative"] = _select(
                    "Counted negative",
                    {"": "nothing", "force": "the force", "elongation": "the elongation",
                     "force\nelongation": "both"},
                    said.get("negative", ""), "negative", "w-44", HELP["negative"],
                )  # fmt: skip
                fields["specimen"] = _text("Specimen", said.get("specimen", ""), "specimen",
                                           HELP["specimen"], "such as 1")  # fmt: skip
                fields["sheet"] = _text("Sheet", said.get("sheet", ""), "sheet", HELP["sheet"], "")
        self._fields = fields
        self._trouble = ui.label("").classes("text-negative").props(
            'role="alert" data-testid="laboratory-edit-problem"'
        )  # fmt: skip
        many = "" if len(self.rows) == 1 else f" to {len(self.rows)} files"
        with ui.row().classes("gap-2"):
            _button(f"Apply{many}", "check", self._apply, "apply", "unelevated")
            _button("Forget corrections", "restart_alt", self._forget, "forget")
            _button("Remove", "delete", lambda: self._remove(self._keys), "remove")

    def _stated(self, name: str) -> str:
        """What the files say of a fact, for an empty field; else an example."""
        found = {r.vacuum if name == "vacuum" else r.facts.normal_force for r in self.rows}
        value = found.pop()
        if not found and value is not None:
            return f"stated: {show(value, spec_of(Facts, name).unit)}"
        return "such as 94.5 kPa" if name == "vacuum" else "such as 2.45 N"

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
            value[name] = _with_unit(value[name], name)
        return value

    def _apply(self) -> None:
        changes = self.changes()
        try:
            check_edit(changes)
        except LayerjamError as err:
            self._trouble.set_text(" ".join(str(err).split()))
            return
        self._trouble.set_text("")
        put_edits(self.desk, self._keys, changes)

    def _forget(self) -> None:
        edits = edits_of(self.desk)
        for key in self._keys:
            gone = dict.fromkeys(set(edits.get(key, {})) - {"role"}, "")
            if gone:
                put_edits(self.desk, [key], gone)
        self.rows = []


def _with_unit(text: str, name: str) -> str:
    """A bare number means the unit the field shows."""
    try:
        float(text)
    except ValueError:
        return text
    return f"{text} {'kPa' if name == 'vacuum' else 'N'}"


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
    label: str, value: str, key: str, help: str, example: str, width: str = "w-44"
) -> ui.input:
    field = ui.input(label, value=value, placeholder=example).classes(width)
    field.props(f'dense outlined stack-label maxlength=300 aria-label="{label}" '
                f'data-testid="laboratory-{key}"')  # fmt: skip
    field.tooltip(help)
    return field


def _select(
    label: str, words: dict[str, str], value: str | None, key: str, width: str, help: str = ""
) -> ui.select:
    box = ui.select(words, value=value if value in words else None, label=label).classes(width)
    box.props(f'dense outlined options-dense stack-label aria-label="{label}" '
              f'data-testid="laboratory-{key}"')  # fmt: skip
    if help:
        box.tooltip(help)
    return box


def _button(text: str, icon: str, act: Callable[[], Any], key: str, how: str = "flat") -> ui.button:
    return ui.button(text, icon=icon, on_click=act).props(
        f'{how} dense no-caps padding="4px 10px" data-testid="laboratory-{key}"'
    )
