"""Panel to view and correct how the files selected in the table are read."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.core.drawing.chart import Curve, Pane
from layerjam.core.drawing.style import CYCLE
from layerjam.core.errors import LayerjamError
from layerjam.core.units import get_spec, show
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.measure.preview import Preview, preview_file
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, parameters
from layerjam.workbench.charts import chart_options
from layerjam.workbench.columns import ColumnTable
from layerjam.workbench.controls import add_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.panel import Panel
from layerjam.workbench.pins import toggle_file_pin
from layerjam.workbench.proposals import CALIBRATE, FACTS, VALIDATE
from layerjam.workbench.said import (
    ROLES,
    UNITS,
    check_edit,
    column_edit,
    get_edits,
    negated_columns,
    put_edits,
    reverse_sign,
)
from layerjam.workbench.spoken import page_text
from layerjam.workbench.widgets import (
    Alert,
    button,
    dress,
    field,
    find_error,
    fold,
    heading,
    one_line,
    select,
)

EXAMPLES = MappingProxyType({"vacuum": "94.5 kPa", "normal_force": "2.45 N", "speed": "13 mm/s"})
DECIMALS = MappingProxyType({"": "as detected", ".": "point", ",": "comma"})
SHOWN = 6
"""Maximum number of files whose curves are drawn."""


class CorrectionPanel:
    """Panel that shows and corrects the selected files."""

    def __init__(self, desk: Desk, remove: Callable[[Sequence[str]], None]) -> None:
        self.desk, self._remove = desk, remove
        self._shown: tuple[object, ...] = ()
        self.rows: list[Row] = []
        self._said: dict[str, str] = {}
        self._fields: dict[str, Any] = {}
        self._pins: ui.button | None = None
        with dress(ui.card(), "laboratory-detail", "w-full", "flat bordered") as self.box:
            self._name = heading("").classes("break-all")
            with ui.row().classes("w-full items-start gap-6"):
                self._words = ui.column().classes("gap-1").style("flex:1; min-width:300px")
                with ui.column().classes("gap-1").style("flex:1; min-width:320px") as self._curve:
                    look = "width:100%; height:260px"
                    self._panel = Panel(desk, "laboratory", "laboratory-record")
                    self._panel.build("laboratory-record", "Measured curve", look)
                    self._panel.build_exports()
            self._below = ui.column().classes("w-full gap-3")
        self.box.set_visibility(False)

    @property
    def _row_keys(self) -> list[str]:
        return [r.upload.key for r in self.rows]

    def fill(self, rows: Sequence[Row], dark: bool) -> None:
        """Show the details of some files; unchanged content is not rebuilt."""
        if self._shown == (*rows, dark):
            self._update_pin_button()
            return
        self._shown, self.rows = (*rows, dark), list(rows)
        self.box.set_visibility(bool(rows))
        if not rows:
            return
        is_single = len(rows) == 1
        self._name.set_text(rows[0].upload.shown if is_single else f"{len(rows)} files")
        self._words.clear()
        with self._words:
            self._show_readings(is_single)
        self._draw_readings(is_single, dark)
        self._below.clear()
        with self._below:
            self._build_form()

    def _show_readings(self, is_single: bool) -> None:
        for row in self.rows[:SHOWN]:
            if not is_single:
                ui.label(row.upload.shown).classes("font-medium break-all")
            if row.refused:
                reason = ui.label(page_text(row.refused))
                dress(reason, "laboratory-why", "text-negative", role="alert")
            for sentence in row.understood:
                ui.label(page_text(f"✓ {sentence}")).classes("text-sm")
            for sentence in row.warnings:
                ui.label(page_text(f"Note: {sentence}")).classes("text-sm opacity-80")
        if len(self.rows) > SHOWN:
            ui.label(f"and {len(self.rows) - SHOWN} more")

    def _draw_readings(self, is_single: bool, dark: bool) -> None:
        traces = [(r, t) for r in self.rows[:SHOWN] for t in r.traces][:SHOWN]
        curves = []
        for color, (row, trace) in zip(CYCLE, traces, strict=False):
            unnamed = is_single and len(row.traces) == 1
            name = "" if unnamed else (trace.specimen or row.upload.shown)[-14:]
            curves.append(Curve(trace.travel * 1e3, trace.force, color, name, width=1.5))
        self._curve.set_visibility(bool(curves))
        ends = (None, None), (None, None)
        chart = chart_options([Pane(curves, "elongation [mm]", "force [N]", *ends)], dark)
        # the `pull` command draws these files when its figure is requested
        files = tuple(r.upload for r in self.rows[:SHOWN] if r.traces)
        name = Path(files[0].shown).stem if len(files) == 1 else "records"
        answer = Answer(Call("pull", files=files), title=name) if files else None
        self._panel.draw(answer, chart)

    def _build_form(self) -> None:
        edits = get_edits(self.desk).get(self._row_keys[0], {})
        roles = {r.role for r in self.rows}
        self._said = {**edits, "role": roles.pop() if len(roles) == 1 else ""}
        self._fields, self._pins = {}, None
        with ui.row().classes("w-full items-end gap-3"):
            self._add_select("role", "Used as", ROLES, width="w-56")
            for name in FACTS:
                tip = f"{get_spec(Facts, name).text}, with its unit; if empty, the file's value"
                self._add_text(
                    name, name.replace("_", " ").capitalize(), self._make_placeholder(name), tip
                )
        table = self._read_preview()
        is_refused = any(r.refused for r in self.rows)
        with (
            fold("Columns, units, signs", "laboratory-correct", is_refused),
            ui.column().classes("gap-3 w-full"),
        ):
            self._build_columns(table)
        self._trouble = Alert("laboratory-edit-problem")
        suffix = "" if len(self.rows) == 1 else f" to {len(self.rows)} files"
        with ui.row().classes("gap-2"):
            for text, icon, act, key, look in (
                (f"Apply{suffix}", "check", self._apply_edits, "apply", "unelevated"),
                ("Discard corrections", "restart_alt", self._discard_edits, "forget", "flat"),
                ("Remove", "delete", partial(self._remove, self._row_keys), "remove", "flat"),
            ):
                button(text, act, f"laboratory-{key}", icon, look=f"{look} dense no-caps")
            if all(r.traces and r.role in (CALIBRATE, VALIDATE) for r in self.rows):
                look = "flat dense no-caps"
                self._pins = button("", self._toggle_pins, "laboratory-pin", "push_pin", look=look)
                self._update_pin_button()

    def _unpinned_keys(self) -> list[str]:
        return [key for key in self._row_keys if key not in self.desk.state.files]

    def _update_pin_button(self) -> None:
        if self._pins is not None:
            free = bool(self._unpinned_keys())
            self._pins.set_text("Show on the Pull page" if free else "Remove from the Pull page")

    def _toggle_pins(self) -> None:
        """Show the files on the Pull page, or remove them from it if all are already there."""
        free = self._unpinned_keys()
        keys = free or self._row_keys
        errors = (find_error(toggle_file_pin, self.desk, key) for key in keys)
        problem = next(filter(None, errors), "")
        self._trouble.show_error(problem)
        if problem:
            return
        count, (singular, plural) = len(keys), ("is", "are") if free else ("was", "were")
        subject = f"The file {singular}" if count == 1 else f"{count} files {plural}"
        end = (
            "on the Pull page, next to the computed curve" if free else "removed from the Pull page"
        )
        ui.notify(f"{subject} {end}")

    def _read_preview(self) -> Preview | str:
        """Return the first rows of the first file, or the reason why it has none."""
        upload = self.rows[0].upload
        try:
            return preview_file(upload.path)
        except LayerjamError as err:
            return str(rename_files(one_line(err), {upload.path.name: upload.shown}))

    def _build_columns(self, table: Preview | str) -> None:
        if isinstance(table, str):
            ui.label(table).classes("text-sm")
            return
        note = "" if len(self.rows) == 1 else f" Your choice applies to all {len(self.rows)} files."
        ui.label(f"Click a column header to choose its content.{note}").classes("text-sm")
        negative = negated_columns(self._said)
        ColumnTable(table, negative, partial(self._on_click, table), self._on_reverse)
        with ui.row().classes("items-end gap-3"):
            self._add_select("decimal", "Decimal separator", DECIMALS)
            if len(self.rows[0].traces) > 1 or self._said.get("specimen"):
                self._add_text("specimen", "Specimen", "such as 1")
            if table.sheets or self._said.get("sheet"):
                names = {"": "all worksheets with curves", **{name: name for name in table.sheets}}
                self._add_select("sheet", "Worksheet", names)

    def _on_click(self, table: Preview, index: int, role: str, unit: str) -> None:
        upload = self.rows[0].upload
        try:
            change = column_edit(upload.path, table, index, role, unit)
            check_edit(change)
        except LayerjamError as err:
            self._trouble.show_error(
                str(rename_files(one_line(err), {upload.path.name: upload.shown}))
            )
            return
        put_edits(self.desk, dict.fromkeys(self._row_keys, change))

    def _on_reverse(self, role: str) -> None:
        put_edits(self.desk, dict.fromkeys(self._row_keys, reverse_sign(self._said, role)))

    def _add_text(
        self, key: str, label: str, example: str = "", tip: str = "", width: str = "w-44"
    ) -> None:
        ident, text = f"laboratory-{key}", self._said.get(key, "")
        box = field(
            label, ident, text, tip=tip or _option_help(key), example=example, classes=width
        )
        self._fields[key] = box

    def _add_select(
        self, key: str, label: str, words: Mapping[str, str], width: str = "w-44"
    ) -> None:
        text = self._said.get(key, "")
        value, tip, ident = text if text in words else None, _option_help(key), f"laboratory-{key}"
        box = select(words, label, ident, value=value, classes=width, tip=tip)
        self._fields[key] = dress(box, look="stack-label")

    def _make_placeholder(self, name: str) -> str:
        """Return a placeholder for a metadata field: the stated value, or an example."""
        values = {r.vacuum if name == "vacuum" else getattr(r.facts, name) for r in self.rows}
        value = values.pop()
        if not values and value is not None:
            return f"stated: {show(value, get_spec(Facts, name).unit)}"
        return f"such as {EXAMPLES[name]}"

    def _apply_edits(self) -> None:
        changes = {k: str(f.value or "").strip() for k, f in self._fields.items()}
        changes |= {name: add_unit(changes[name], UNITS[name]) for name in FACTS}
        if not changes["role"]:
            del changes["role"]
        problem = find_error(check_edit, changes)
        self._trouble.show_error(problem)
        if not problem:
            put_edits(self.desk, dict.fromkeys(self._row_keys, changes))

    def _discard_edits(self) -> None:
        edits = get_edits(self.desk)
        changes = {k: dict.fromkeys(set(edits.get(k, {})) - {"role"}, "") for k in self._row_keys}
        put_edits(self.desk, changes)
        self._shown = ()


def _option_help(key: str) -> str:
    option = parameters("pull").get(key)
    return "" if option is None else str(option.sentence)
