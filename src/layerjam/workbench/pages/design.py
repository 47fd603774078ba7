"""Design: from a requirement to a brake, arrays of brakes, published devices, four machines."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from html import escape
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.core.drawing.style import ORANGE
from layerjam.core.units import show
from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import chart_options
from layerjam.workbench.controls import (
    Choice,
    Control,
    add_menu,
    add_tabs,
    control,
    map_keys,
    vacuum_control,
)
from layerjam.workbench.desk import Desk
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.outcomes import describe_pull
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.design_density import Density
from layerjam.workbench.pages.design_need import NeedPart
from layerjam.workbench.pages.design_part import PAGE, Part, cell_text, key_name
from layerjam.workbench.panel import Panel
from layerjam.workbench.tables import html_table
from layerjam.workbench.widgets import columns, dress, fold, hint, status

WIDE, LONG = 20, 10
"""Maximum number of brakes in parallel, and in series, on this page."""
CONTROLS = ("parallel", "series", "vacuum")
TOTALS = (
    "brakes",
    "peak_force",
    "peak_elongation",
    "end",
    "travel",
    "energy",
    "stiffness",
    "mass",
    "force_density",
)


class Arrays(Part):
    """Part for arrays of the desk's brake, in parallel and in series."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.more = OtherInputs(page, "array", CONTROLS)
        self.panel = Panel(self.desk, PAGE, f"{PAGE}-array")

    def controls(self) -> Mapping[str, Control]:
        """Return the controls for the numbers of brakes and their vacuum."""
        full_vacuum = self.more.atmosphere(self.desk.brake.brake.site.atmosphere)
        vacuum = vacuum_control("array", "vacuum", full_vacuum, 0.01 * full_vacuum)
        rows = control("array", "parallel", 2, (1, WIDE), label="In parallel", steps=WIDE - 1)
        row = control("array", "series", 2, (1, LONG), label="In series", steps=LONG - 1)
        return map_keys(rows.narrow_bounds(high=WIDE), row.narrow_bounds(high=LONG), vacuum)

    def build(self) -> None:
        """Build controls and totals on the left, force versus elongation on the right."""
        side, main = columns()
        with side:
            for key in CONTROLS:
                self.add_slider(key)
            self.more.build()
            self.figures = Figures(f"{PAGE}-array", "array", TOTALS)
        with main:
            self.outcome = status(f"{PAGE}-array-outcome")
            label = "Force versus elongation of the array and of one brake"
            self.panel.build(f"{PAGE}-array-chart", label)
            self.panel.build_exports()
            hint(
                "In series, the weakest brake slips first, and the others relax. The "
                "next one slips only when the first reaches its end stop. This produces "
                "the sawtooth curve."
            )
            self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """Return the calls for the array, and for a single brake as a comparison."""
        subjects, vacuum = (self.desk.brake_subject(),), self.text("vacuum")
        counts = {key: int(self.value(key)) for key in ("parallel", "series")}
        options = {"vacuum": vacuum, **self.more.options()}
        return [Call("array", subjects, {**counts, **options}), Call("array", subjects, options)]

    def draw(self, answers: Sequence[Answer]) -> None:
        """Draw the curves, and show totals and notes."""
        answer, single = answers
        array = answer.result
        pins = (Pinned("one brake", single),) if array.brakes > 1 else ()
        chart = array_chart(array, single.result, self.page.dark)
        self.panel.draw(replace(answer, pins=pins), chart)
        self.figures.fill(array)
        self.outcome.set_text(describe_pull(array))
        self.notes.fill(array.warnings)


def array_chart(array: Any, single: Any, dark: bool) -> dict[str, Any]:
    """Return the chart of force versus elongation for the array and for a single brake."""
    label = f"{array.parallel} × {array.series}"
    pane = array.panes()[0]
    curves = [replace(pane.curves[0], name=label, width=2.5)]
    if array.brakes > 1:
        curves.append(replace(single.panes()[0].curves[0], color=ORANGE, name="one brake"))
    return chart_options([replace(pane, curves=curves)], dark)


class MachineResult(NamedTuple):
    """An answer and its drawings."""

    answer: Answer
    pictures: list[tuple[str, str]]
    """(SVG text, caption)."""


class Machines(Part):
    """Part for the scenarios supplied with the program."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._known: dict[str, MachineResult] = {}

    @cached_property
    def choice(self) -> Choice:
        """Choice of scenario."""
        titles = Call("scenario", options={"names": True}).run().titles
        names = {name: f"{name}: {title}" for name, title in titles.items()}
        return Choice("scenario", names, "seat-belt", help="Machine that contains the brakes")

    def build(self) -> None:
        """Build scenario, verdict, limits, pictures and the table of all numbers."""
        with ui.column().classes("w-full").style("max-width: 640px"):
            add_menu(self.desk, PAGE, self.choice)
        self.verdict = status(f"{PAGE}-verdict", "text-base")
        self.verdict.style("max-width: 75ch")
        self.limits = dress(ui.html("", sanitize=False), f"{PAGE}-limits", "w-full")
        self.pictures = dress(ui.html("", sanitize=False), f"{PAGE}-pictures", "w-full figure")
        with fold("All numbers", f"{PAGE}-machine-numbers"):
            self.results = ui.html("", sanitize=False).classes("w-full")
        hint(
            "Computed from a model of the scenario's own brakes; nothing here was "
            "measured. For a scenario of your own, run layerjam scenario FILE.toml."
        )
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """Return the call for the selected machine."""
        return [Call("scenario", (Subject(self.word(self.choice)),))]

    def compute(self) -> MachineResult:
        """Compute the result and its drawings, once per machine and tab."""
        name = self.word(self.choice)
        if name not in self._known:
            (call,) = self.calls()
            result = call.run(progress=self.page.runner.report_progress)
            pictures = result.pictures(self.page.runner.report_progress)
            self._known[name] = MachineResult(Answer(call, result), pictures)
        return self._known[name]

    def draw(self, machine: MachineResult) -> None:
        """Draw all parts of the result."""
        result = machine.answer.result
        self.verdict.set_text(result.conclusion)
        self.limits.set_content(limits_table(result))
        drawings = enumerate(machine.pictures)
        self.pictures.set_content(
            "".join(_svg_figure(f"machine{n}", *item) for n, item in drawings)
        )
        rows = [
            (key_name(k), cell_text(v, result.units.get(k, ""))) for k, v in result.results.items()
        ]
        rows.append(("mass of the brakes", cell_text(result.mass, "kg")))
        count = "no number is enough" if result.brakes_needed is None else str(result.brakes_needed)
        rows.append(("brakes required", count))
        self.results.set_content(html_table(("Quantity", "Value"), rows, (1,), "Results"))
        self.notes.fill(result.warnings)


def limits_table(result: Any) -> str:
    """Return an HTML table of the limits: value, bound, and whether each is met."""
    rows = []
    for limit in result.record.limits:
        bound = f"{'at least' if limit.least else 'at most'} {show(limit.limit, limit.unit)}"
        verdict = "missed"
        if 0 < limit.factor < float("inf"):
            verdict = f"missed by a factor of {limit.factor:.3g}"
        value = cell_text(limit.value, limit.unit)
        rows.append((limit.name, value, bound, "met" if limit.is_met else verdict))
    return html_table(("Limit", "Value", "Allowed", ""), rows, (1, 2), "Limits")


def _svg_figure(name: str, svg: str, caption: str) -> str:
    """Return a drawing with a caption, in the page's colours; its ids contain `name`."""
    from layerjam.core.drawing.page import apply_theme, read_inline_svg

    text = escape(caption)
    image = apply_theme(read_inline_svg(svg, name)).replace(
        "<svg", f'<svg role="img" aria-label="{text}"', 1
    )
    return f'<figure>{image}<figcaption class="text-sm opacity-80">{text}</figcaption></figure>'


KINDS: dict[str, tuple[str, type[Part]]] = {
    "need": ("From a requirement", NeedPart),
    "arrays": ("Arrays of brakes", Arrays),
    "density": ("Force versus mass", Density),
    "machines": ("Four machines", Machines),
}
WORDS = {key: key_name for key, (key_name, _) in KINDS.items()}
PART = Choice("part", WORDS, "need", help="On this page")


class Design(Page):
    """Page with four parts, of which only the open one is computed."""

    name, title = "design", "Design"
    summary = "From a requirement to a brake"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.parts = {key: kind(self) for key, (_, kind) in KINDS.items()}
        self.boxes: dict[str, ui.column] = {}

    def build(self) -> None:
        """Build the choice of a part, and below it the parts, each when first opened."""
        with ui.column().classes("w-full page gap-3"):
            add_tabs(self.desk, self.name, PART)
            self.add_alert()
            for key in self.parts:
                self.boxes[key] = ui.column().classes("w-full gap-3")
                self.boxes[key].set_visibility(False)
        self.desk.add_watcher(lambda _: self._open_part())
        self._open_part()

    def current_part(self) -> Part:
        """Return the open part."""
        return self.parts[self.word(PART)]

    def _open_part(self) -> None:
        current = self.word(PART)
        for key, box in self.boxes.items():
            box.set_visibility(key == current)
        if not self.parts[current].built:
            self.parts[current].built = True
            with self.boxes[current]:
                self.parts[current].build()

    def calls(self) -> Sequence[Call]:
        """Return the open part's calls."""
        return self.current_part().calls()

    def compute(self) -> Any:
        """Return the open part and its results."""
        part = self.current_part()
        return part, part.compute()

    def answers(self) -> Sequence[Answer]:
        """Return the answers of the open part."""
        return self.current_part().answers()

    def draw(self, result: Any) -> None:
        """Draw the results if their part is still open."""
        part, answers = result
        if part is self.current_part():
            part.result = answers
            part.draw(answers)
