"""Design: from a requirement to a brake, several as one, what others make, four machines."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from html import escape
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.units import show
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import Choice, choice, menu
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Notes, Page
from layerjam.workbench.pages.design_arrays import Arrays
from layerjam.workbench.pages.design_density import Density
from layerjam.workbench.pages.design_need import NeedPart
from layerjam.workbench.pages.design_part import PAGE, Part, said, words
from layerjam.workbench.runner import waiting_line
from layerjam.workbench.tables import html
from layerjam.workbench.widgets import dressed, fold, hint, status


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
        titles = Call("apply", options={"names": True}).run().titles
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
            "scenario of your own: layerjam apply FILE.toml."
        )
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The chosen machine."""
        return [Call("apply", (Subject(self.word(self.choice)),))]

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
