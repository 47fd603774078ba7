"""Brake: materials, drawing, mass, force and strength."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from layerjam.brake.commands.edit import BRAKE_FIELDS, edit, find_stale_numbers, list_numbers
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.core.units import parse, show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, result_fields
from layerjam.workbench.controls import Choice, Control, add_tabs, control, map_keys, vacuum_control
from layerjam.workbench.desk import Desk
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.brake_build import BuildPart
from layerjam.workbench.pages.records import CUSTOM, Editor, Kind
from layerjam.workbench.scene import StackView, build_stack, describe_stack
from layerjam.workbench.tables import Cell, html_table
from layerjam.workbench.takeaway import save_result
from layerjam.workbench.widgets import (
    Hero,
    Heroes,
    button,
    columns,
    fold,
    key_title,
    predicted_hero,
    select,
    status,
)
from layerjam.workshop.design.uneven import WITH_FACTOR, calibration_notices

GROUPS = {
    "sheets": "Sheets",
    "film": "Film",
    "enclosure": "Enclosure",
    "mount": "Caps",
    "": "Whole brake",
    "speed_law": "Friction versus speed",
    "hyperelastic": "Enclosure rubber law",
    "rope": "Drop-test rope",
    "site": "Site",
}
KIND = Kind(
    "brake", "brake", "brake-catalogue", GROUPS, BRAKE_FIELDS, edit, origin=("kind", "source")
)
PART = Choice("part", {"brake": "Performance", "build": "Build"}, "brake", help="On this page")


class Brake(Page):
    """Page to change a brake's numbers and see the effect, or to check whether it can be built."""

    name, title = "brake", "Brake"
    summary = "Materials, mass, forces and strength"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.editor = Editor(desk, KIND)
        self.making = BuildPart(self)
        self.more = OtherInputs(self, "force", ("slip", "vacuum"))

    def controls(self) -> Mapping[str, Control]:
        """Return the controls for the displayed slip and vacuum, within the brake's bounds."""
        brake = self.desk.brake.brake
        lap, full_vacuum = brake.sheets.overlap, self.more.atmosphere(brake.site.atmosphere)
        slip = control("force", "slip", 0.0, (0.0, lap), label="Displayed slip")
        vacuum = vacuum_control("force", "vacuum", full_vacuum, label="Displayed vacuum")
        return map_keys(slip.narrow_bounds(high=lap), vacuum)

    def build(self) -> None:
        """Build the fields for the brake's numbers on the left and the results on the right."""
        add_tabs(self.desk, self.name, PART)
        side, main = columns("brake-page")
        with side:
            self.editor.build_selection()
            self.add_alert()
            self.editor.build_folds(("sheets",))
            self.editor.build_origin()
        with main:
            self.numbers = ui.column().classes("w-full gap-3")
            with self.numbers:
                self._show_numbers()
            self.workshop = ui.column().classes("w-full gap-3")
        self.desk.add_watcher(lambda _: self._open_part())
        self._open_part()

    def _has_build(self) -> bool:
        return self.word(PART) == "build"

    def _open_part(self) -> None:
        builds = self._has_build()
        self.numbers.set_visibility(not builds)
        self.workshop.set_visibility(builds)
        if builds and not self.making.built:
            self.making.built = True
            with self.workshop:
                self.making.build()

    def _show_numbers(self) -> None:
        self.heroes = Heroes(self.name)
        self.sentence = status("brake-sentence", "text-lg")
        with ui.row().classes("w-full no-wrap gap-6 items-start brake-top"):
            with ui.column().classes("gap-1 grow").style("min-width: 0"):
                self.view = StackView("brake-scene")
                self.words = live.Words("").classes("text-sm opacity-80")
            with ui.column().style("width: 250px; flex: none"):
                for key in self.controls():
                    self.add_slider(key)
                keys = ("force", "sheet_friction", "enclosure_force")
                self.figures = Figures(self.name, "force", keys)
                self.more.build()
        self._build_comparison()
        self.table = live.Table()
        self.notes = Notes()
        with (
            fold("Sources of the numbers", is_open=True),
            ui.element("div").classes("w-full overflow-auto brake-sources"),
        ):
            self.sources = live.Table()

    def _build_comparison(self) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self.other = select({}, "Compare with", "brake-beside", classes="w-64")
            self.other.on_value_change(lambda event: self._put_second(str(event.value or "")))
            text, look = "Keep a copy for comparison", "flat dense no-caps"
            keep = lambda: self._put_second(self.desk.state.brake)  # noqa: E731
            button(text, keep, "brake-keep", "push_pin", look=look)
            tip = "HTML file that computes this brake in any browser"
            button("Save as one page", self._save_page, "brake-html", "public", look=look, tip=tip)
        self.desk.add_watcher(lambda _: self._fill_second(), "brake", "undo")
        self._fill_second()

    async def _save_page(self) -> None:
        from layerjam.interop.html import make_html

        file = self.desk.brake
        await save_result(partial(make_html, file), f"{file.name}.html", "text/html")

    def _fill_second(self) -> None:
        text, second = self.desk.state.beside, self.desk.beside
        choices = {"": "nothing"} | {name: load(name).title or name for name in catalogue()}
        if second is not None and text not in choices:
            choices[CUSTOM] = f"{second.name} (kept)"
        self.other.set_options(choices, value=text if text in choices else CUSTOM)

    def _put_second(self, text: str) -> None:
        if text not in (CUSTOM, self.desk.state.beside):
            self.desk.put_file("beside", text)

    def calls(self) -> Sequence[Call]:
        """Return the calls for the brake, its force and the second brake, or for its build."""
        if self._has_build():
            return self.making.calls()
        brake = self.desk.brake_subject()
        options = self.more.options()
        site = {key: value for key, value in options.items() if key == "atmosphere"}
        place = {**self.texts("slip", "vacuum"), **options}
        calls = [Call("show", (brake,), site), Call("force", (brake,), place)]
        if self.desk.beside is not None:
            calls.append(Call("show", (self.desk.subject("beside"),), site))
        return calls

    def compute(self) -> Any:
        """Return (whether the Build part is open, the open part's result)."""
        return (True, self.making.compute()) if self._has_build() else (False, super().compute())

    def answers(self) -> Sequence[Answer]:
        """Return the displayed answers: the brake and its force, or the build."""
        if self.result is None or self.result[0] != self._has_build():
            return []
        builds, result = self.result
        return [result.answer] if builds else result

    def draw(self, result: Any) -> None:
        """Draw the picture, numbers, notes and sources, or the build."""
        builds, parts = result
        if builds:
            self.making.draw(parts)
            return
        facts, force, *second = (answer.result for answer in parts)
        brake, place = self.desk.brake.brake, parts[1].call.options
        slip, vacuum = (parse(place[key], u, key) for key, u in (("slip", "m"), ("vacuum", "Pa")))
        stack = build_stack(brake, slip, vacuum / brake.site.atmosphere)
        words = describe_stack(brake, stack, slip)
        self.view.show(stack, words, self.dark)
        self.words.set_text(words)
        self.figures.fill(force)
        full_vacuum = self.more.atmosphere(brake.site.atmosphere)
        self.heroes.fill(headlines(facts), facts)
        self.sentence.set_text(describe_forces(facts, force, full_vacuum, slip, vacuum))
        second_file = self.desk.beside
        unlike = calibration_notices(
            [self.desk.brake, *([] if second_file is None else [second_file])]
        )
        self.table.set_content(comparison_html(facts, second[0] if second else None, not unlike))
        self.notes.fill([*unlike, *facts.warnings, *find_stale_numbers(self.desk.brake)])
        self.sources.set_content(sources_table(self.desk.brake))


def headlines(facts: Any) -> list[Hero]:
    """Return the headline numbers: forces at rest and during a pull, and mass."""
    return [
        predicted_hero("hero-holding", "Holds at rest", facts, "holding_force"),
        predicted_hero("hero-pull", "Resists a pull of up to", facts, "max_force"),
        predicted_hero("hero-mass", "Mass", facts, "mass"),
    ]


def describe_forces(facts: Any, force: Any, full: float, slip: float, vacuum: float) -> str:
    """Return a sentence with the page's three forces, each with its vacuum."""
    holding, pulled = show(facts.holding_force, "N", 3), show(facts.max_force, "N", 3)
    return (
        f"Holds {holding} at rest and resists {pulled} when pulled, both at full vacuum, "
        f"{show(full, 'Pa', 3)}; at a slip of {show(slip, 'm', 3)} and {show(vacuum, 'Pa', 3)} "
        f"it resists {show(force.force, 'N', 3)}."
    )


ROWS: Mapping[str, int] = {
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
"""{key of a `show` result: 1 if more is better, -1 if less is better, 0 if neither}."""


ALIKE = 5e-5
"""Relative difference that the display cannot show; smaller differences count as none."""


def compare_numbers(first: float | None, second: float | None, better_sign: int) -> str:
    """Return the difference of two numbers as text: sign, percentage, and better or worse."""
    if first is None or second is None:
        return ""
    if first == second or (second and abs(first / second - 1) < ALIKE):
        return "same"
    much = _format_percent(first / second - 1) if second else "was zero"
    if not better_sign:
        return much
    return f"▲ {much}, better" if (first - second) * better_sign > 0 else f"▼ {much}, worse"


def _format_percent(part: float) -> str:
    text = f"{part:+.1%}" if abs(part) >= 0.001 else f"{part:+.2%}"
    return text.replace("-", "−")


def comparison_html(first: Any, second: Any | None, is_even: bool = True) -> str:
    """Return a brake's numbers as an HTML table, with its differences from a second brake.

    `is_even` is false if only one brake is calibrated; the forces are then not judged.
    """
    heads = ["", first.values["name"]]
    if second is not None:
        heads += [second.values["name"], f"{first.values['name']} is"]
    rows: list[list[Cell]] = []
    meanings = result_fields("show")
    for key, better in ROWS.items():
        unit, first_value = first.units[key], first.values[key]
        name = meanings[key][0].upper() + meanings[key][1:]
        row: list[Cell] = [name, (show(first_value, unit), "font-medium")]
        if second is not None:
            second_value = second.values[key]
            judged = is_even or key not in WITH_FACTOR
            words = compare_numbers(first_value, second_value, better if judged else 0)
            row += [show(second_value, unit), (words, _class_names(words))]
        rows.append(row)
    return html_table(heads, rows, (1, 2, 3), "The brake", "brake-numbers")


def _class_names(words: str) -> str:
    if words.endswith("better"):
        return "font-bold verdict-better"
    return "verdict-worse" if words.endswith("worse") else "opacity-80"


def sources_table(file: BrakeFile) -> str:
    """Return an HTML table of a brake's numbers, each with its kind and its source."""
    heads = ["Number", "Value", "Kind", "Source", "Spread", "Conflict"]
    rows = []
    for path, spec, value, source in list_numbers(file):
        source_texts = ("default", "", "", "")
        if source is not None:
            source_texts = (source.kind, source.text, source.spread, source.conflict)
        rows.append([key_title(path.replace(".", ", ")), show(value, spec.unit, 6), *source_texts])
    return html_table(heads, rows, (1,), "Sources", "brake-sources")
