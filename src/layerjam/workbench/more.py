"""Every other input of a command, as plain fields in a fold: generated from its declaration."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from typing import Any

from nicegui import events, ui

from layerjam.commands.declare import PYTHON_ONLY, Help, OutFile, Parameter, Progress
from layerjam.commands.quantities import ATMOSPHERE
from layerjam.errors import LayerjamError
from layerjam.units import usual_unit
from layerjam.workbench.call import DataFile, Options, parameters
from layerjam.workbench.controls import on_typed, with_unit
from layerjam.workbench.page import Page
from layerjam.workbench.uploads import LARGEST, Refused, Uploads
from layerjam.workbench.widgets import Alert, button, dressed, fold, hint, select


def others(command: str, shown: Collection[str]) -> list[Parameter]:
    """The inputs of a command that a page does not show by itself."""
    return [
        p
        for p in parameters(command).values()
        if p.name not in shown
        and not p.positional
        and p.type not in (Progress, PYTHON_ONLY)
        and not isinstance(p.help, OutFile)
    ]


def is_file(p: Parameter) -> bool:
    """Whether it is read from a file: on a page one that is dropped, never a path."""
    return type(p.help) is Help and p.spec is None and "Path" in str(p.type)


class More:
    """Fields for the inputs of a command that have no control of their own; empty: the default."""

    def __init__(self, page: Page, command: str, shown: Collection[str]) -> None:
        self.page, self.desk = page, page.desk
        self.inputs = others(command, shown)
        self.uploads = Uploads()
        self._files: dict[str, DataFile] = {}

    def options(self) -> Options:
        """What was set: texts that the command can read, words, flags, and files."""
        made: Options = {}
        for p in self.inputs:
            value = self.desk.get(self.page.name, p.name, "")
            if p.name in self._files:
                made[p.name] = self._files[p.name]
            elif value and not is_file(p) and not refusal(p, value):
                made[p.name] = value
        return made

    def atmosphere(self, usual: float) -> float:
        """The site's atmosphere [Pa]: as set here, or the usual one."""
        text, spec = self.options().get("atmosphere"), ATMOSPHERE
        return float(spec.read(text, "atmosphere")) if isinstance(text, str) else usual

    def build(self) -> None:
        """The fold; the files go with the tab."""
        ui.context.client.on_delete(self.uploads.close)
        with fold("More", f"{self.page.name}-more"):
            for p in self.inputs:
                self._field(p)

    def _field(self, p: Parameter) -> None:
        ident, label = f"{self.page.name}-{p.name}", p.label.capitalize()
        value = self.desk.get(self.page.name, p.name, "")
        if is_file(p):
            self._upload(p, ident, label)
            return
        put = partial(self._put, p)
        box: Any
        if p.type is bool:
            box = dressed(ui.switch(label, value=bool(value), on_change=put), ident)
            box.tooltip(p.sentence)
        elif p.words and p.spec is None:
            words = {"": "default", **{word: word for word in p.words}}
            box = select(words, label, ident, put, value=str(value or ""), tip=p.sentence)
        else:
            box = self._text(p, ident, label)
        empty: Any = False if p.type is bool else ""

        def fill(what: str) -> None:
            if what == "undo":
                box.set_value(self.desk.get(self.page.name, p.name, empty))

        self.desk.watch(fill)

    def _put(self, p: Parameter, event: events.ValueChangeEventArguments[Any]) -> None:
        self.desk.put(self.page.name, p.name, event.value or "")

    def _text(self, p: Parameter, ident: str, label: str) -> ui.input:
        now = str(self.desk.get(self.page.name, p.name, ""))
        default = "" if p.default in (None, ()) else f"{p.default}"
        example = p.spec.example.strip("'") if p.spec else ""
        hinted = default or (f"such as {example}" if example else "")
        field = dressed(ui.input(label, value=now), ident, "w-full", "dense outlined stack-label")
        dressed(field, placeholder=hinted, maxlength=120, aria_label=label)
        field.tooltip(p.sentence)

        def typed() -> None:
            unit = usual_unit(p.spec.unit) if p.spec else ""
            text = with_unit(str(field.value or ""), unit)
            why = refusal(p, text) if text else ""
            field.error = why or None
            if not why and text != self.desk.get(self.page.name, p.name, ""):
                self.desk.put(self.page.name, p.name, text)
                field.set_value(text)

        on_typed(field, typed)
        return field

    def _upload(self, p: Parameter, ident: str, label: str) -> None:
        """A file; it stays on this machine and is no part of the link."""

        async def came(event: events.UploadEventArguments) -> None:
            area.reset()
            try:
                self.uploads.room(event.file.name, event.file.size())
                made = self.uploads.take(event.file.name, await event.file.read())
            except Refused as err:
                alert.say(str(err))
                return
            if made is not None:
                self._files[p.name] = DataFile(made.name, made.path)
                changed(made.name)

        def forget() -> None:
            self.uploads.remove(f.key for f in self.uploads.files)
            self._files.pop(p.name, None)
            changed("")

        def changed(name: str) -> None:
            alert.say("")
            kept.set_text(name)
            drop.set_visibility(bool(name))
            self.page.refresh()

        hint(p.sentence)
        area = ui.upload(
            label=label, auto_upload=True, max_files=1, max_file_size=LARGEST, on_upload=came
        )
        dressed(area, f"{ident}-file", "w-full", "flat bordered", aria_label=label)
        kept = dressed(ui.label(), ident, "text-sm font-medium")
        drop = button("Take it away", forget, f"{ident}-forget", "close", how="flat dense no-caps")
        drop.set_visibility(False)
        alert = Alert(f"{ident}-problem", "text-sm")


def refusal(p: Parameter, value: Any) -> str:
    """Why a value is none that the command takes; empty where it is."""
    try:
        p.read(value, {}, [])
    except LayerjamError as err:
        return str(err)
    return ""
