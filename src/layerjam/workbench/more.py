"""Panel of plain fields for a command's other inputs, generated from its declaration."""

from collections.abc import Collection
from functools import partial
from typing import Any

from nicegui import events, ui

from layerjam.brake.commands.arguments import ATMOSPHERE
from layerjam.core.command.declare import Help, OutFile, Parameter
from layerjam.core.units import usual_unit
from layerjam.workbench.call import Options, parameters
from layerjam.workbench.controls import add_unit, on_submit
from layerjam.workbench.page import Page
from layerjam.workbench.spoken import page_text
from layerjam.workbench.uploads import LARGEST, Uploads
from layerjam.workbench.widgets import (
    Alert,
    button,
    dress,
    drop_area,
    field,
    find_error,
    fold,
    hint,
    select,
)


def find_other_inputs(command: str, names: Collection[str]) -> list[Parameter]:
    """Return the inputs of a command that the page does not already show (`names`)."""
    return [
        p
        for p in parameters(command).values()
        if p.name not in names
        and not p.positional
        and p.is_offered
        and not isinstance(p.help, OutFile)
    ]


def is_file(p: Parameter) -> bool:
    """Whether the input is a file: on a page, always a dropped file and never a path."""
    return type(p.help) is Help and p.spec is None and "Path" in str(p.type)


class OtherInputs:
    """Fields for a command's inputs that have no control; an empty field means the default."""

    def __init__(self, page: Page, command: str, names: Collection[str]) -> None:
        self.page, self.desk = page, page.desk
        self.inputs = find_other_inputs(command, names)
        self.files = {p.name: Uploads() for p in self.inputs if is_file(p)}
        """Files dropped on each file input; the last one is used."""

    def options(self) -> Options:
        """Return the inputs that are set: texts with units, choices, flags and files."""
        values: Options = {}
        for p in self.inputs:
            value = self.desk.get(self.page.name, p.name, "")
            if p.name in self.files:
                if self.files[p.name].files:
                    values[p.name] = self.files[p.name].files[-1]
            elif value and not find_refusal(p, value):
                values[p.name] = value
        return values

    def atmosphere(self, usual: float) -> float:
        """Return the site's atmospheric pressure [Pa] as set here, or the usual one."""
        text, spec = self.options().get("atmosphere"), ATMOSPHERE
        return float(spec.read(text, "atmosphere")) if isinstance(text, str) else usual

    def build(self, title: str = "More") -> None:
        """Build the panel; the files are deleted with the tab."""
        for uploads in self.files.values():
            ui.context.client.on_delete(uploads.close)
        with fold(title, f"{self.page.name}-more"):
            for p in self.inputs:
                self._build_field(p)

    def _build_field(self, p: Parameter) -> None:
        ident, label = f"{self.page.name}-{p.name}", p.label.capitalize()
        value = self.desk.get(self.page.name, p.name, "")
        if p.name in self.files:
            self._build_upload(p, ident, label)
            return
        put = partial(self._put_option, p)
        box: Any
        if p.type is bool:
            box = dress(ui.switch(label, value=bool(value), on_change=put), ident)
            box.tooltip(page_text(p.sentence))
        elif p.words and p.spec is None:
            words = {"": "default", **{word: word for word in p.words}}
            box = select(words, label, ident, put, value=str(value or ""), tip=p.sentence)
        else:
            box = self._build_text_field(p, ident, label)
        empty: Any = False if p.type is bool else ""
        read = partial(self.desk.get, self.page.name, p.name, empty)
        self.desk.add_watcher(lambda _: box.set_value(read()), "undo")

    def _put_option(self, p: Parameter, event: events.ValueChangeEventArguments[Any]) -> None:
        self.desk.put_setting(self.page.name, p.name, event.value or "")

    def _build_text_field(self, p: Parameter, ident: str, label: str) -> ui.input:
        current = str(self.desk.get(self.page.name, p.name, ""))
        default = p.default_text
        example = p.spec.example.strip("'") if p.spec else ""
        hinted = default or (f"such as {example}" if example else "")
        box = field(label, ident, current, tip=p.sentence, example=hinted, longest=120)

        def on_type() -> None:
            unit = usual_unit(p.spec.unit) if p.spec else ""
            text = add_unit(str(box.value or ""), unit)
            problem = find_refusal(p, text) if text else ""
            box.error = problem or None
            if not problem and text != self.desk.get(self.page.name, p.name, ""):
                self.desk.put_setting(self.page.name, p.name, text)
                box.set_value(text)

        on_submit(box, on_type)
        self.page.fields[p.name] = box
        return box

    def _build_upload(self, p: Parameter, ident: str, label: str) -> None:
        uploads = self.files[p.name]

        async def on_file(event: events.UploadEventArguments) -> None:
            area.reset()
            alert.show_error(await uploads.receive_file(event.file))
            show_file()

        def remove_files() -> None:
            uploads.remove_files(f.key for f in uploads.files)
            alert.show_error("")
            show_file()

        def show_file() -> None:
            file_label.set_text("".join(f.shown for f in uploads.files[-1:]))
            drop.set_visibility(bool(uploads.files))
            self.page.refresh()

        hint(p.sentence)
        area = ui.upload(auto_upload=True, max_files=1, max_file_size=LARGEST, on_upload=on_file)
        drop_area(area, label, f"{ident}-file")
        file_label = dress(ui.label(), ident, "text-sm font-medium")
        drop = button("Remove", remove_files, f"{ident}-forget", "close", look="flat dense no-caps")
        drop.set_visibility(False)
        alert = Alert(f"{ident}-problem", "text-sm")


def find_refusal(p: Parameter, value: Any) -> str:
    """Return the reason why a command rejects a value; empty if it accepts it."""
    return find_error(p.read, value, {}, [])
