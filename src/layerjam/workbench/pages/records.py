"""Editor for the desk's brake or line: select, open, save, and cite a source for each number."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from nicegui import events, ui

from layerjam.brake.fluid.parts import FAMILIES
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.toml_files.source import KINDS
from layerjam.core.toml_files.toml import MAX_BYTES, decode_toml
from layerjam.core.units import QuantitySpec, exact_text, get, show, usual_unit
from layerjam.workbench.controls import (
    Choice,
    add_menu,
    add_unit,
    number_field,
    on_submit,
    read_word,
)
from layerjam.workbench.desk import SHELVES, Desk
from layerjam.workbench.spoken import typeset_text
from layerjam.workbench.widgets import Alert, button, dress, field, fold, one_line, select

NEW_KINDS = ("measured", "data sheet", "handbook", "assumed")
"""Kinds of source available for typed numbers; files may contain others."""
CUSTOM, NONE = "own", "none"


@dataclass(frozen=True)
class Kind:
    """Kind of record to edit: a brake or a line.

    `groups` maps each table of the file to a heading, and `fields` each dotted path to
    (specification, required). `origin` contains the desk's keys for the kind and the source of new
    numbers. Tables in `optional` may be absent.
    """

    what: str
    page: str
    ident: str
    groups: Mapping[str, str]
    fields: Mapping[str, tuple[QuantitySpec, bool]]
    edit: Callable[..., Any]
    origin: tuple[str, str]
    optional: tuple[str, ...] = ()
    parts: Callable[[str], Mapping[str, str]] = lambda table: {}
    """Function that returns {catalogue part: title} for a table."""

    def paths(self, table: str) -> list[str]:
        """Return the dotted paths of one table, in the file's order."""
        return [path for path in self.fields if path.rpartition(".")[0] == table]


class Editor:
    """Editor for the desk's record; errors appear next to the field that causes them."""

    def __init__(self, desk: Desk, kind: Kind) -> None:
        self.desk, self.kind = desk, kind
        self.rows: dict[str, FieldRow] = {}
        self.waiting: dict[str, str] = {}
        """Numbers typed into an incomplete table, such as a tube without its bore."""
        self._parts: dict[str, ui.select] = {}
        self._folds: dict[str, ui.expansion] = {}

    @property
    def file(self) -> Any:
        """The desk's record."""
        return getattr(self.desk, self.kind.what)

    @property
    def text(self) -> str:
        """Catalogue name or TOML text of the record."""
        return str(getattr(self.desk.state, self.kind.what))

    @property
    def catalogue_names(self) -> list[str]:
        """Names of the catalogue's records."""
        return SHELVES[self.kind.what].names()

    def value(self, path: str) -> Any:
        """Return a number or a table of the record; None if it is absent."""
        return get(getattr(self.file, self.kind.what), path)

    # ---- selection of the file

    def build_selection(self) -> None:
        """Build the fields to select a record, open a file, save it, and rename the record."""
        page, kind = self.kind.page, self.kind.what
        self.problem = Alert(f"{page}-{kind}-problem")
        self._chosen = select({}, kind.capitalize(), self.kind.ident, self._on_choose)
        with ui.row().classes("w-full gap-2 no-wrap"):
            build_open_button(self.desk, kind, page, self.problem)
            button("Save TOML", self._save_toml, f"{page}-save", "download")
        self._named = field("Name", f"{page}-name", longest=80)
        on_submit(self._named, self._on_rename)
        self.desk.add_watcher(lambda _: self.fill(), kind, "undo")
        self.fill()

    def fill(self) -> None:
        """Show the desk's record."""
        titles = {
            name: SHELVES[self.kind.what].load(name).title or name for name in self.catalogue_names
        }
        is_own = self.text not in titles
        choices = {CUSTOM: f"{self.file.name} (a file)", **titles} if is_own else titles
        self._chosen.set_options(choices, value=CUSTOM if is_own else self.text)
        self._named.set_value(self.file.name)
        self._named.error = None
        self.problem.show_error("")
        self.waiting.clear()
        for row in self.rows.values():
            row.fill()
        self._fill_parts()

    def _on_choose(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value in self.catalogue_names and event.value != self.text:
            self.desk.put_file(self.kind.what, str(event.value))

    def _save_toml(self) -> None:
        """Download the TOML text, including its comments and sources."""
        ui.download.content(self.file.text.encode(), f"{self.file.name}.toml", "application/toml")

    def _on_rename(self) -> None:
        name = str(self._named.value or "").strip()
        if name == self.file.name:
            self._named.error = None
            return
        try:
            self.desk.put_file(self.kind.what, self.kind.edit(self.file, name=name).record.text)
        except LayerjamError as err:
            self._named.error = one_line(err)

    # ---- numbers of the record

    def change_values(
        self, changes: Mapping[str, str | None], takes: Mapping[str, str | None] | None = None
    ) -> str:
        """Change numbers, or the catalogue parts of tables (`takes`).

        Return the reason if the changes are rejected, otherwise "".
        """
        kind, source = self.origin()
        # only unchanged numbers keep the catalogue's name
        name = f"{self.file.name}-edited" if self.text in self.catalogue_names else None
        part_changes = {"takes": takes} if takes else {}
        try:
            result = self.kind.edit(
                self.file, changes, name=name, kind=kind, source=source, **part_changes
            )
            self.desk.put_file(self.kind.what, result.record.text)
        except FileError as err:
            return err.reason
        except LayerjamError as err:
            return one_line(err)
        return ""

    def build_folds(self, open_groups: tuple[str, ...] = ()) -> None:
        """Build a panel for each table; a panel's fields are built when it is first opened."""
        for table, title in self.kind.groups.items():
            ident = f"{self.kind.page}-group-{table}"
            self._folds[table] = fold(title, ident, table in open_groups)
            if table in open_groups:
                self._fill_fold(table)
            else:  # build lazily: hidden panels delay the first page
                self._folds[table].on_value_change(partial(self._fill_fold, table))

    def field_row(self, path: str) -> "FieldRow":
        """Return the field for a number, and build its panel first if necessary."""
        self._fill_fold(path.rpartition(".")[0])
        return self.rows[path]

    def _fill_fold(self, table: str, _: object = None) -> None:
        if self._folds[table].default_slot.children:
            return
        with self._folds[table]:
            if table in FAMILIES and self.kind.what == "line":
                self._build_part_choice(table)
            elif table in self.kind.optional:
                drop = partial(self.use_part, table, NONE)
                title, ident = self.kind.groups[table].lower(), f"{self.kind.page}-without-{table}"
                button(f"No {title}", drop, ident, "close", look="flat dense no-caps")
            for path in self.kind.paths(table):
                self.rows[path] = FieldRow(self, path)

    def _build_part_choice(self, table: str) -> None:
        no_part = {NONE: "none"} if table in self.kind.optional else {}
        parts = {CUSTOM: "custom values", **no_part, **self.kind.parts(table)}
        ident = f"{self.kind.page}-part-{table}"
        box = select(parts, "Part", ident, lambda event: self.use_part(table, str(event.value)))
        self._parts[table] = dress(box, aria_label=f"Catalogue part for the {table}")
        self._fill_parts()

    def current_part(self, table: str) -> str:
        """Return a table's catalogue part, CUSTOM for custom numbers, or NONE if it is absent."""
        absent = table in self.kind.optional and self.value(table) is None
        return str(self.file.parts.get(table, NONE if absent else CUSTOM))

    def _fill_parts(self) -> None:
        for table, box in self._parts.items():
            part = self.current_part(table)
            box.set_value(part if part in (box.options or ()) else CUSTOM)

    def use_part(self, table: str, part: str) -> None:
        """Use a different catalogue part for a table, or remove the table."""
        if part in (CUSTOM, self.current_part(table)):
            return
        problem = self.change_values({}, {table: None if part == NONE else part})
        if problem:
            self.fill()
            self.problem.show_error(problem)

    # ---- source of new numbers

    def origin(self) -> tuple[str, str]:
        """Return the kind and the source that typed numbers get."""
        return read_word(self.desk, self.kind.page, self._kind_choice), self._source_text()

    @property
    def _kind_choice(self) -> Choice:
        words = {kind: f"{kind}: {KINDS[kind]}" for kind in NEW_KINDS}
        return Choice(self.kind.origin[0], words, "assumed", label="Kind")

    def _source_text(self) -> str:
        return str(self.desk.get(self.kind.page, self.kind.origin[1], ""))[:200]

    def build_origin(self) -> None:
        """Build the fields for the kind and the source that typed numbers get."""
        page, key = self.kind.page, self.kind.origin[1]
        with fold("Source of new numbers"):
            add_menu(self.desk, page, self._kind_choice)
            example = "caliper, 3 readings"
            box = field(
                "Source", f"{page}-{key}", self._source_text(), example=example, longest=200
            )
        box.on_value_change(lambda event: self.desk.put_setting(page, key, str(event.value or "")))
        self.desk.add_watcher(lambda _: box.set_value(self._source_text()), "undo")


def build_open_button(desk: Desk, kind: str, page: str, problem: Alert) -> None:
    """Build a button that opens a TOML file from disk; `problem` shows errors."""

    async def on_upload(event: events.UploadEventArguments) -> None:
        upload.reset()
        try:
            text = decode_toml(await event.file.read(), event.file.name)
            desk.put_file(kind, text if "\n" in text else f"{text}\n")
            problem.show_error("")
        except LayerjamError as err:
            problem.show_error(one_line(err))

    too_large = f"the {kind} file is too large; the limit is {MAX_BYTES // 1000} kB"
    upload = ui.upload(
        max_file_size=MAX_BYTES,
        max_files=1,
        auto_upload=True,
        on_upload=on_upload,
        on_rejected=lambda: problem.show_error(too_large),
    )
    dress(upload, f"{page}-open-file", "hidden", accept=".toml")
    pick = partial(upload.run_method, "pickFiles")
    dress(button("Open", pick, f"{page}-open", "folder_open"), aria_label="Open a TOML file")


class FieldRow:
    """Row for one number: name, field for the value with its unit, and source."""

    def __init__(self, editor: Editor, path: str) -> None:
        self.editor, self.path = editor, path
        self.spec, is_required = editor.kind.fields[path]
        name, ident = path.rpartition(".")[2].replace("_", " "), f"{editor.kind.page}-{path}"
        symbol = f"{self.spec.symbol}: " if self.spec.symbol else ""
        with ui.column().classes("w-full gap-0"):
            with ui.row().classes("w-full items-center justify-between no-wrap gap-2"):
                meaning = f"{symbol}{self.spec.text}; {self.spec.limits()}"
                ui.label(name.capitalize()).classes("text-sm").tooltip(typeset_text(meaning))
                self.field = number_field(f"{name}, {self.spec.text}", "w-40")
                dress(self.field, ident, placeholder="" if is_required else "unknown")
            source = "text-xs opacity-80 source-line"
            self.source = dress(ui.label(), f"{ident}-source", source)
        on_submit(self.field, self.on_type)
        self.fill()

    def value_text(self) -> str:
        """Return the value as text; empty if it is unknown."""
        value = self.editor.value(self.path)
        if value is None:
            return ""
        if isinstance(value, bool):
            return show(value, "1")
        if self.spec.unit == "1":
            return f"{value:g}"
        return exact_text(float(f"{value:.12g}"), self.spec.unit)

    def fill(self) -> None:
        """Show the number's current value and source."""
        text = self.value_text()
        self.field.set_value(text)
        self.field.error = None
        source = self.editor.file.sources.get(self.path)
        origin_text = source.sentence() if source is not None else "the default" if text else ""
        self.source.set_text(origin_text)
        self.source.set_visibility(bool(origin_text))

    def on_type(self) -> None:
        """Apply the typed text, or show an error below the field.

        Numbers of a new table are kept until the table is complete.
        """
        current, text = self.value_text(), str(self.field.value or "").strip()
        if text == current:
            self.field.error = None
            return
        text = add_unit(text, "" if self.spec.unit == "1" else bare_unit(current, self.spec))
        table = self.path.rpartition(".")[0]
        waiting = {p: t for p, t in self.editor.waiting.items() if p.rpartition(".")[0] == table}
        problem = self.editor.change_values({**waiting, self.path: text or None})
        self.field.error = problem or None
        if problem and text and table and self.editor.value(table) is None:
            self.editor.waiting[self.path] = text


def bare_unit(text: str, spec: QuantitySpec) -> str:
    """Return the unit for a bare number: that of the displayed text, otherwise the usual one."""
    return text.partition(" ")[2] or usual_unit(spec.unit)
