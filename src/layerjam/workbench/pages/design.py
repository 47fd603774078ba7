"""Design: from a requirement to a brake, several as one, what others make, four machines."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from html import escape
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.report.style import ORANGE
from layerjam.units import show
from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import options
from layerjam.workbench.controls import Choice, Control, asked, by_key, choice, menu, vacuum_asked
from layerjam.workbench.desk import Desk
from layerjam.workbench.more import More
from layerjam.workbench.outcomes import of_pull
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.design_density import Density
from layerjam.workbench.pages.design_need import NeedPart
from layerjam.workbench.pages.design_part import PAGE, Part, said, words
from layerjam.workbench.panel import Panel
from layerjam.workbench.runner import waiting_line
from layerjam.workbench.tables import html
from layerjam.workbench.widgets import columns, dressed, fold, hint, status

WIDE, LONG = 20, 10
"""Brakes side by side and in series at most, on this page."""
OWN = ("parallel", "series", "vacuum")
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
    """The desk's brake, N side by side, M in series."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.more = More(page, "array", OWN)
        self.panel = Panel(self.desk, PAGE, f"{PAGE}-array")

    def controls(self) -> Mapping[str, Control]:
        """How many, and their vacuum."""
        full = self.more.atmosphere(self.desk.brake.brake.site.atmosphere)
        vacuum = vacuum_asked("array", "vacuum", full, 0.01 * full)
        rows = asked("array", "parallel", 2, (1, WIDE), label="Side by side", steps=WIDE - 1)
        row = asked("array", "series", 2, (1, LONG), label="In series", steps=LONG - 1)
        return by_key(rows.within(high=WIDE), row.within(high=LONG), vacuum)

    def build(self) -> None:
        """Controls and totals left, force over elongation right."""
        side, main = columns()
        with side:
            for key in OWN:
                self.slider(key)
            self.more.build()
            self.figures = Figures(f"{PAGE}-array", "array", TOTALS)
        with main:
            self.outcome = status(f"{PAGE}-array-outcome")
            what = "Force over elongation of the array and of one brake"
            self.panel.build(f"{PAGE}-array-chart", what)
            self.panel.build_row()
            hint(
                "In series the weakest slips first; once it slides the others relax, and the "
                "next slips only when the first is on its stop: the teeth of the curve."
            )
            self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The array, and one brake beside it."""
        here, vacuum = (self.desk.brake_subject(),), self.text("vacuum")
        counts = {key: int(self.value(key)) for key in ("parallel", "series")}
        more = {"vacuum": vacuum, **self.more.options()}
        return [Call("array", here, {**counts, **more}), Call("array", here, more)]

    def draw(self, found: Sequence[Answer]) -> None:
        """Curves, totals and notes."""
        answer, one = found
        whole = answer.result
        beside = (Pinned("one brake", one),) if whole.brakes > 1 else ()
        made = array_chart(whole, one.result, self.page.dark)
        self.panel.draw(replace(answer, pins=beside), made)
        self.figures.fill(whole)
        self.outcome.set_text(of_pull(whole))
        self.notes.fill(whole.warnings)


def array_chart(whole: Any, one: Any, dark: bool) -> dict[str, Any]:
    """Force over elongation of the array and of a single brake."""
    many = f"{whole.parallel} × {whole.series}"
    pane = whole.panes()[0]
    curves = [replace(pane.curves[0], name=many, width=2.5)]
    if whole.brakes > 1:
        curves.append(replace(one.panes()[0].curves[0], color=ORANGE, name="one brake"))
    return options([replace(pane, curves=curves)], dark)


class Shown(NamedTuple):
    """An answer and its drawings."""

    answer: Answer
    pictures: list[tuple[str, str]]
    """(SVG text, caption)."""


class Machines(Part):
    """One of the scenarios that come with the program."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._known: dict[str, Shown] = {}

    @cached_property
    def choice(self) -> Choice:
        """The scenarios by name."""
        titles = Call("scenario", options={"names": True}).run().titles
        names = {name: f"{name}: {title}" for name, title in titles.items()}
        return Choice("scenario", names, "seat-belt", help="What the brakes are built into")

    def build(self) -> None:
        """Scenario, verdict, limits, pictures, every number."""
        with ui.column().classes("w-full").style("max-width: 640px"):
            menu(self.desk, PAGE, self.choice)
        self.verdict = status(f"{PAGE}-verdict", "text-base")
        self.verdict.style("max-width: 75ch")
        self.limits = dressed(ui.html("", sanitize=False), f"{PAGE}-limits", "w-full")
        self.pictures = dressed(ui.html("", sanitize=False), f"{PAGE}-pictures", "w-full figure")
        with fold("Every number", f"{PAGE}-machine-numbers"):
            self.results = ui.html("", sanitize=False).classes("w-full")
        hint(
            "Computed from a model of the scenario's own brakes; nothing here was measured. A "
            "scenario of your own: layerjam scenario FILE.toml."
        )
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The chosen machine."""
        return [Call("scenario", (Subject(self.word(self.choice)),))]

    def compute(self) -> Shown:
        """The result and its drawings; each machine once a tab."""
        name = self.word(self.choice)
        if name not in self._known:
            (call,) = self.calls()
            result = call.run(progress=self.page.runner.tell)
            pictures = result.pictures(self.page.runner.tell)
            self._known[name] = Shown(Answer(call, result), pictures)
        return self._known[name]

    def draw(self, found: Shown) -> None:
        """Everything."""
        result = found.answer.result
        self.verdict.set_text(result.conclusion)
        self.limits.set_content(limits_table(result))
        drawings = enumerate(found.pictures)
        self.pictures.set_content("".join(_figure(f"machine{n}", *one) for n, one in drawings))
        rows = [(words(k), said(v, result.units.get(k, ""))) for k, v in result.results.items()]
        rows.append(("mass of the brakes", said(result.mass, "kg")))
        needed = "none does" if result.brakes_needed is None else str(result.brakes_needed)
        rows.append(("brakes it would take", needed))
        self.results.set_content(html(("What", "Value"), rows, (1,), "Results"))
        self.notes.fill(result.warnings)


def limits_table(result: Any) -> str:
    """Every limit, its value, and whether it is met."""
    rows = []
    for limit in result.record.limits:
        allowed = f"{'at least' if limit.least else 'at most'} {show(limit.limit, limit.unit)}"
        missed = "missed"
        if 0 < limit.factor < float("inf"):
            missed = f"missed, by {limit.factor:.3g} times"
        value = said(limit.value, limit.unit)
        rows.append((limit.name, value, allowed, "met" if limit.met else missed))
    return html(("Limit", "Value", "Allowed", ""), rows, (1, 2), "Limits")


def _figure(name: str, svg: str, caption: str) -> str:
    """A drawing in the colours of the page, light or dark; its ids carry `name`."""
    from layerjam.report.page import svg_of, themed

    said = escape(caption)
    inside = themed(svg_of(svg, name)).replace("<svg", f'<svg role="img" aria-label="{said}"', 1)
    return f'<figure>{inside}<figcaption class="text-sm opacity-80">{said}</figcaption></figure>'


KINDS: dict[str, tuple[str, type[Part]]] = {
    "need": ("From a requirement", NeedPart),
    "arrays": ("Several as one", Arrays),
    "density": ("Force over mass", Density),
    "machines": ("Four machines", Machines),
}
WORDS = {key: words for key, (words, _) in KINDS.items()}
PART = Choice("part", WORDS, "need", help="What this page shows")


class Design(Page):
    """Four parts, one of them open; only the open one is computed."""

    name, title = "design", "Design"
    about = "From a requirement to a brake"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.parts = {key: kind(self) for key, (_, kind) in KINDS.items()}
        self.boxes: dict[str, ui.column] = {}

    def build(self) -> None:
        """The choice of a part, and the parts below it; each is built when first opened."""
        with ui.column().classes("w-full page gap-3"):
            with ui.row().classes("w-full items-center gap-6 design-head"):
                choice(self.desk, self.name, PART)
                self.problem_line()
            waiting_line(self.name, self.runner)
            for key in self.parts:
                self.boxes[key] = ui.column().classes("w-full gap-3")
                self.boxes[key].set_visibility(False)
        self.desk.watch(lambda _: self._open_part())
        self._open_part()

    def part(self) -> Part:
        """The one that is open."""
        return self.parts[self.word(PART)]

    def _open_part(self) -> None:
        now = self.word(PART)
        for key, box in self.boxes.items():
            box.set_visibility(key == now)
        if not self.parts[now].built:
            self.parts[now].built = True
            with self.boxes[now]:
                self.parts[now].build()

    def calls(self) -> Sequence[Call]:
        """The open part's calls."""
        return self.part().calls()

    def compute(self) -> Any:
        """The open part's results, and whose they are."""
        part = self.part()
        return part, part.compute()

    def answers(self) -> Sequence[Answer]:
        """What the open part shows."""
        return self.part().answers()

    def draw(self, result: Any) -> None:
        """Show them where the part is still open."""
        part, found = result
        if part is self.part():
            part.result = found
            part.draw(found)
