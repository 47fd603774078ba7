"""Brake: what it is made of, what it looks like inside, what it weighs, holds and bears."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from nicegui import events, ui

from layerjam.commands.answer import SLIP, VACUUM
from layerjam.commands.edit import edit, stale
from layerjam.device.load import catalogue, load
from layerjam.errors import FileError, LayerjamError
from layerjam.records.toml import MAX_BYTES
from layerjam.units import QuantitySpec
from layerjam.workbench import tables
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import Control, number, slider
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.brake_fields import Fields, origin, origin_fields, refusal
from layerjam.workbench.pages.brake_tables import Comparison, Sources
from layerjam.workbench.scene import StackView, in_words, stack_of

STYLE = """
.source-line { line-height: 1.25 }
@media (max-width: 900px) {
  .brake-page .side { order: 2 }
  .brake-sources { max-height: 320px; overflow: auto }
}
@media (max-width: 1100px) { .brake-top { flex-wrap: wrap } }
"""
OWN, NONE = "own", ""


class Brake(Page):
    """Change a number and see what it does."""

    name = "brake"

    def controls(self) -> dict[str, Control]:
        """What the picture shows: slip and vacuum, within the brake's bounds."""
        brake = self.desk.brake.brake
        lap, full = brake.sheets.overlap, brake.site.atmosphere
        return {
            "slip": Control("slip", QuantitySpec("m", SLIP.text, 0.0, lap), 0.0, 0.0, lap,
                            label="Slip drawn"),
            "vacuum": Control("vacuum", QuantitySpec("Pa", VACUUM.text, 0.0, full), full, 0.0, full,
                              label="Vacuum drawn"),
        }  # fmt: skip

    def control(self, key: str) -> Control:
        """One of them, with the bounds of the brake of now."""
        return self.controls()[key]

    def build(self) -> None:
        """Numbers of the brake left, what follows from them right."""
        ui.add_css(STYLE + tables.STYLE)
        with ui.row().classes("w-full no-wrap items-start gap-6 page brake-page"):
            with ui.column().classes("side"):
                self._choosing()
                self.problem_line()
                self.fields = Fields(self.desk, self.change, ("sheets",))
                origin_fields(self.desk, self.name)
            with ui.column().classes("main"):
                with ui.row().classes("w-full no-wrap gap-6 items-start brake-top"):
                    with ui.column().classes("gap-1 grow").style("min-width: 0"):
                        self.view = StackView("brake-scene")
                        self.words = ui.label().classes("text-sm opacity-80")
                    with ui.column().style("width: 250px; flex: none"):
                        for key, control in self.controls().items():
                            slider(self.desk, self.name, control, partial(self.control, key))
                        self.figures = Figures(
                            self.name,
                            [("force", "Force, sliding there"), ("sheet_friction", "of the sheets"),
                             ("enclosure_force", "of the sleeve")],
                        )  # fmt: skip
                self._beside()
                self.table = Comparison()
                self.notes = Notes()
                with ui.expansion("Where the numbers come from", value=True).classes("w-full"):
                    self.sources = Sources()

    def _choosing(self) -> None:
        """Which brake: from the catalogue, from a file; its name; saving."""
        self.chosen = ui.select(
            self._choices(), value=self._choice(), label="Brake", on_change=self._chose
        ).props('dense outlined data-testid="brake-catalogue"').classes("w-full")  # fmt: skip
        with ui.row().classes("w-full gap-2 no-wrap"):
            self.upload = ui.upload(
                max_file_size=MAX_BYTES, max_files=1, auto_upload=True, on_upload=self._opened,
                on_rejected=lambda: self.say(f"a brake's file has at most {MAX_BYTES // 1000} kB"),
            ).props('accept=.toml data-testid="brake-open-file"').classes("hidden")  # fmt: skip
            ui.button("Open", icon="folder_open", on_click=lambda: self.upload.run_method(
                "pickFiles")).props('outline dense no-caps data-testid="brake-open" '
                                    'aria-label="Open a TOML file"')  # fmt: skip
            ui.button("Save TOML", icon="download", on_click=self._save).props(
                'outline dense no-caps data-testid="brake-save"'
            )
        self.named = ui.input("Name").props(
            'dense outlined hide-bottom-space data-testid="brake-name" maxlength=80'
        ).classes("w-full")  # fmt: skip
        self.named.on("keydown.enter", self._renamed)
        self.named.on("blur", self._renamed)
        self.named.set_value(self.desk.brake.name)
        self.desk.watch(self._refill)

    def _choices(self) -> dict[str, str]:
        known = {name: load(name).title or name for name in catalogue()}
        if self.desk.state.brake in known:
            return known
        return {OWN: f"{self.desk.brake.name} (a file)", **known}

    def _choice(self) -> str:
        return self.desk.state.brake if self.desk.state.brake in catalogue() else OWN

    def _chose(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value and event.value not in (OWN, self.desk.state.brake):
            self.desk.put_brake(str(event.value))

    def _refill(self, what: str) -> None:
        if what in ("brake", "undo"):
            self.chosen.set_options(self._choices(), value=self._choice())
            self.named.set_value(self.desk.brake.name)
            self.named.error = None
            self.other.set_value(self._other())

    def say(self, problem: str) -> None:
        """A refusal in words, where the page has them."""
        if self.problem is not None:
            self.problem.set_text(problem)
            self.problem.set_visibility(bool(problem))

    async def _opened(self, event: events.UploadEventArguments) -> None:
        self.upload.reset()
        try:
            text = (await event.file.read()).decode("utf-8-sig")
            self.desk.put_brake(text if "\n" in text else f"{text}\n")
        except UnicodeDecodeError:
            self.say("the file is not UTF-8 text, so no brake's TOML file")
        except LayerjamError as err:
            self.say(refusal(err))

    def _save(self) -> None:
        """The TOML text as it is: comments and sources and all."""
        file = self.desk.brake
        ui.download.content(file.text.encode(), f"{file.name}.toml", "application/toml")

    def _renamed(self) -> None:
        name = str(self.named.value or "").strip()
        if name == self.desk.brake.name:
            self.named.error = None
            return
        try:
            self.desk.put_brake(edit(self.desk.brake, name=name).text)
        except LayerjamError as err:
            self.named.error = refusal(err)

    def change(self, path: str, text: str | None) -> str:
        """Another value for one number; why not, if it is refused."""
        file = self.desk.brake
        kind, source = origin(self.desk, self.name)
        # the catalogue's name stays with the catalogue's numbers
        name = f"{file.name}-edited" if self.desk.state.brake in catalogue() else None
        try:
            self.desk.put_brake(edit(file, {path: text}, name=name, kind=kind, source=source).text)
        except LayerjamError as err:
            return err.reason if isinstance(err, FileError) else refusal(err)
        return ""

    def _beside(self) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self.other = ui.select(
                self._others(), value=self._other(), label="Compare with",
                on_change=lambda e: self._put_beside(str(e.value or NONE)),
            ).props('dense outlined data-testid="brake-beside"').classes("w-64")  # fmt: skip
            ui.button("Keep as it is now, to compare", icon="push_pin", on_click=lambda:
                      self._put_beside(self.desk.state.brake)).props(
                'flat dense no-caps data-testid="brake-keep"')  # fmt: skip

    def _others(self) -> dict[str, str]:
        known = {NONE: "nothing"} | {name: load(name).title or name for name in catalogue()}
        if self.desk.beside is not None and self.desk.state.beside not in known:
            known[OWN] = f"{self.desk.beside.name} (kept)"
        return known

    def _other(self) -> str:
        return self.desk.state.beside if self.desk.state.beside in self._others() else OWN

    def _put_beside(self, text: str) -> None:
        if text not in (OWN, self.desk.state.beside):
            self.desk.put_beside(text)
            self.other.set_options(self._others(), value=self._other())

    def beside_subject(self) -> Subject | None:
        """The second brake as a call takes it."""
        file = self.desk.beside
        if file is None:
            return None
        if self.desk.state.beside in catalogue():
            return Subject(self.desk.state.beside)
        return Subject(f"{file.name}.toml", file)

    def calls(self) -> Sequence[Call]:
        """What the brake is, its force where it is drawn, and what the other one is."""
        here = self.desk.brake_subject()
        said: dict[str, str | float | bool] = {
            c.key: c.text(number(self.desk, self.name, c)) for c in self.controls().values()
        }
        made = [Call("show", (here,)), Call("force", (here,), said)]
        other = self.beside_subject()
        return made if other is None else [*made, Call("show", (other,))]

    def draw(self, result: Any) -> None:
        """Picture, numbers, notes and sources."""
        shown, force, *other = result
        brake = self.desk.brake.brake
        slip, vacuum = (number(self.desk, self.name, c) for c in self.controls().values())
        stack = stack_of(brake, slip, vacuum / brake.site.atmosphere)
        words = in_words(brake, stack, slip)
        self.view.show(stack, words, self.dark)
        self.words.set_text(words)
        self.figures.fill(force)
        self.table.fill(shown, other[0] if other else None)
        self.notes.fill([*shown.warnings, *stale(self.desk.brake)])
        self.sources.fill(self.desk.brake)
