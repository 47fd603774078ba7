"""The line on the desk: chosen, opened, saved, its parts and every number of it."""

from __future__ import annotations

from nicegui import events, ui

from layerjam.commands.edit import LINE_FIELDS as FIELDS
from layerjam.commands.edit import edit_line
from layerjam.commands.parts import parts
from layerjam.errors import LayerjamError
from layerjam.fluid.file import lines, load_line
from layerjam.fluid.parts import FAMILIES
from layerjam.records.toml import MAX_BYTES
from layerjam.units import exact_text, get, usual_unit
from layerjam.workbench.desk import Desk

GROUPS = {
    "chamber": "Chamber", "pump": "Pump", "tube": "Tube", "valve": "Vent valve", "leak": "Leak",
    "sensor": "Sensor", "reservoir": "Reservoir", "": "Gas", "site": "Site",
}  # fmt: skip
"""Table of the line's file and what stands above its fields."""
OPTIONAL = ("tube", "valve", "sensor", "reservoir")
OWN, NONE = "own", "none"


class LineFields:
    """All of the line; refusals are said in place."""

    def __init__(self, desk: Desk) -> None:
        """Fills the current slot."""
        self.desk = desk
        self._typed: dict[str, str] = {}
        self._rows: dict[str, ui.input] = {}
        self._sources: dict[str, ui.label] = {}
        self._parts: dict[str, ui.select] = {}
        self._choosing()
        with (
            ui.expansion("Parts and numbers of the line")
            .classes("w-full")
            .props('dense header-class="font-medium" data-testid="vacuum-numbers"')
        ):
            for table, title in GROUPS.items():
                with ui.expansion(title).classes("w-full").props(
                    f'dense data-testid="vacuum-group-{table}"'
                ):  # fmt: skip
                    self._group(table)
        desk.watch(lambda what: self.fill() if what in ("line", "undo") else None)
        self.fill()

    def _choosing(self) -> None:
        self.chosen = ui.select({}, label="Line", on_change=self._chose).props(
            'dense outlined data-testid="vacuum-line" aria-label="Line"'
        ).classes("w-full")  # fmt: skip
        with ui.row().classes("w-full gap-2 no-wrap"):
            self.upload = ui.upload(
                max_file_size=MAX_BYTES, max_files=1, auto_upload=True, on_upload=self._opened,
                on_rejected=lambda: self.say(f"a line's file has at most {MAX_BYTES // 1000} kB"),
            ).props('accept=.toml data-testid="vacuum-open-file"').classes("hidden")  # fmt: skip
            ui.button("Open", icon="folder_open",
                      on_click=lambda: self.upload.run_method("pickFiles")).props(
                'outline dense no-caps data-testid="vacuum-open" aria-label="Open a TOML file"'
            )  # fmt: skip
            ui.button("Save TOML", icon="download", on_click=self._save).props(
                'outline dense no-caps data-testid="vacuum-save"'
            )
        self.problem = ui.label("").classes("text-negative").props(
            'role="alert" data-testid="vacuum-line-problem"'
        )  # fmt: skip
        self.say("")

    def _group(self, table: str) -> None:
        if table in FAMILIES:
            known = {
                p["name"]: p["title"] or p["name"]
                for p in parts().values[f"{table}s"] if p["missing"] is None
            }  # fmt: skip
            none = {NONE: "none"} if table in OPTIONAL else {}
            self._parts[table] = ui.select(
                {OWN: "own numbers", **none, **known}, label="Part",
                on_change=lambda e: self._takes(table, str(e.value)),
            ).props(
                f'dense outlined options-dense data-testid="vacuum-part-{table}" '
                f'aria-label="Part for the {table}"'
            ).classes("w-full")  # fmt: skip
        elif table in OPTIONAL:
            ui.button(
                f"No {GROUPS[table].lower()}", icon="close",
                on_click=lambda: self._change(takes={table: None}),
            ).props(f'flat dense no-caps data-testid="vacuum-without-{table}"')  # fmt: skip
        for path in FIELDS:
            if path.rpartition(".")[0] == table:
                self._row(path)

    def _row(self, path: str) -> None:
        spec = FIELDS[path][0]
        name = path.rpartition(".")[2].replace("_", " ")
        with ui.column().classes("w-full gap-0 q-mb-xs"):
            with ui.row().classes("w-full items-center justify-between no-wrap gap-2"):
                ui.label(name.capitalize()).classes("text-sm").tooltip(
                    f"{path}: {spec.text}; {spec.allowed()}"
                )
                field = ui.input().props(
                    'dense outlined hide-bottom-space input-class="text-right" placeholder="none" '
                    f'aria-label="{name}: {spec.text}" data-testid="vacuum-{path}"'
                ).classes("w-40")  # fmt: skip
            self._sources[path] = ui.label().classes("text-xs opacity-80")
        self._rows[path] = field
        field.on("keydown.enter", lambda: self._read(path))
        field.on("blur", lambda: self._read(path))

    def shown(self, path: str) -> str:
        """A number of the line as it stands in its field; empty for what it has not."""
        value, spec = get(self.desk.line.line, path), FIELDS[path][0]
        if value is None:
            return ""
        return f"{value:g}" if spec.unit == "1" else exact_text(value, spec.unit)

    def fill(self) -> None:
        """What the line on the desk is."""
        file, known = self.desk.line, {name: load_line(name).title or name for name in lines()}
        own = self.desk.state.line not in known
        choices = {OWN: f"{file.name} (a file)", **known} if own else known
        self.chosen.set_options(choices, value=OWN if own else self.desk.state.line)
        self._typed.clear()
        self.say("")
        for path, field in self._rows.items():
            field.set_value(self.shown(path))
            field.error = None
            source = file.sources.get(path)
            self._sources[path].set_text("" if source is None else source.sentence())
            self._sources[path].set_visibility(source is not None)
        for table, box in self._parts.items():
            absent = table in OPTIONAL and getattr(file.line, table) is None
            part = file.parts.get(table, NONE if absent else OWN)
            box.set_value(part if part in box.options else OWN)

    def say(self, problem: str) -> None:
        """A refusal in words."""
        self.problem.set_text(problem)
        self.problem.set_visibility(bool(problem))

    def _chose(self, event: events.ValueChangeEventArguments[str]) -> None:
        if event.value in lines() and event.value != self.desk.state.line:
            self.desk.put_line(str(event.value))

    async def _opened(self, event: events.UploadEventArguments) -> None:
        self.upload.reset()
        try:
            text = (await event.file.read()).decode("utf-8-sig")
            self.desk.put_line(text if "\n" in text else f"{text}\n")
        except UnicodeDecodeError:
            self.say("the file is not UTF-8 text, so no line's TOML file")
        except LayerjamError as err:
            self.say(" ".join(str(err).split()))

    def _save(self) -> None:
        """The TOML text as it is, comments and sources and all."""
        file = self.desk.line
        ui.download.content(file.text.encode(), f"{file.name}.toml", "application/toml")

    def _takes(self, table: str, part: str) -> None:
        line = self.desk.line
        absent = table in OPTIONAL and getattr(line.line, table) is None
        if part == line.parts.get(table, NONE if absent else OWN) or part == OWN:
            return
        self._change(takes={table: None if part == NONE else part})

    def _read(self, path: str) -> None:
        """Take what was typed; a table's first number waits for those without which it is none."""
        field = self._rows[path]
        text = str(field.value or "").strip()
        if text == self.shown(path):
            field.error = None
            return
        spec = FIELDS[path][0]
        try:
            float(text)
            unit = usual_unit(spec.unit)
            text = text if spec.unit == "1" else f"{text} {self._unit(path) or unit}"
        except ValueError:
            pass
        table = path.rpartition(".")[0]
        waiting = {p: t for p, t in self._typed.items() if p.rpartition(".")[0] == table}
        why = self._change({**waiting, path: text or None})
        field.error = why or None
        if why and "missing" in why and text:
            self._typed[path] = text

    def _unit(self, path: str) -> str:
        """The unit a number without one is in: that shown."""
        return self.shown(path).partition(" ")[2]

    def _change(
        self,
        changes: dict[str, str | None] | None = None,
        takes: dict[str, str | None] | None = None,
    ) -> str:
        """Change the line; why not where it is refused."""
        file = self.desk.line
        # the catalogue's name stays with the catalogue's numbers
        name = f"{file.name}-edited" if self.desk.state.line in lines() else None
        try:
            made = edit_line(file, changes, takes=takes, name=name)
            self.desk.put_line(made.text)
        except LayerjamError as err:
            why = " ".join(str(err).split())
            if takes:
                self.say(why)
                self.fill_parts()
            return why
        return ""

    def fill_parts(self) -> None:
        """The choice of parts as the line has it, after one was refused."""
        problem = self.problem.text
        self.fill()
        self.say(problem)
