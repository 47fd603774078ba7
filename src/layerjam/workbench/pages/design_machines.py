"""The four machines of the paper's Fig. 13: a scenario, its verdict, its limits and pictures."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.commands.answer import Answer
from layerjam.studies.machines.apply import machines
from layerjam.studies.machines.registry import load_scenario
from layerjam.units import show
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import Choice, menu, word
from layerjam.workbench.page import Notes
from layerjam.workbench.pages.design_part import PAGE, Host, Part, said, words
from layerjam.workbench.tables import html


class Shown(NamedTuple):
    """An answer and its drawings."""

    answer: Answer
    pictures: list[tuple[str, str]]
    """(SVG text, caption)."""


class Machines(Part):
    """One of the scenarios that come with the program."""

    def __init__(self, page: Host) -> None:
        super().__init__(page)
        self._known: dict[str, Shown] = {}
        self._drawn: Shown | None = None

    def choice(self) -> Choice:
        """The scenarios by name."""
        names = {n: f"{n}: {load_scenario(n).title}" for n in machines()}
        return Choice("scenario", names, "seat-belt", help="What the brakes are built into")

    def scenario(self) -> str:
        """The one that is chosen."""
        return word(self.desk, PAGE, self.choice())

    def build(self) -> None:
        """Scenario, verdict, limits, pictures, every number."""
        with ui.column().classes("w-full").style("max-width: 640px"):
            menu(self.desk, PAGE, self.choice())
        self.verdict = ui.label("").classes("text-base").style("max-width: 75ch").props(
            f'role="status" data-testid="{PAGE}-verdict"'
        )  # fmt: skip
        self.limits = (
            ui.html("", sanitize=False).classes("w-full").props(f'data-testid="{PAGE}-limits"')
        )
        self.pictures = (
            ui.html("", sanitize=False).classes("w-full").props(f'data-testid="{PAGE}-pictures"')
        )
        with (
            ui.expansion("Every number")
            .classes("w-full")
            .props(f'dense header-class="font-medium" data-testid="{PAGE}-machine-numbers"')
        ):
            self.results = ui.html("", sanitize=False).classes("w-full")
        ui.label(
            "Computed from a model of the scenario's own brakes; nothing here was measured. A "
            "scenario of your own: layerjam apply FILE.toml."
        ).classes("text-sm opacity-80")
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The chosen machine."""
        return [Call("apply", (Subject(self.scenario()),))]

    def compute(self) -> Any:
        """The answer and the drawings that its report holds; each machine once a tab."""
        name = self.scenario()
        if name not in self._known:
            from layerjam.report.page import drawn
            from layerjam.studies.machines.figures import pictures

            answer = self.calls()[0].run(progress=self.page.waiting.tell)
            made = []
            for picture in pictures(answer.record):
                self.page.waiting.tell(f"figure {picture.name}", 0.0)
                made.append((drawn(picture.figure()), picture.caption))
            self._known[name] = Shown(answer, made)
        return self._known[name]

    def draw(self, found: Any) -> None:
        """Everything, where it is not what stands there."""
        if found is self._drawn:
            return
        self._drawn = found
        answer = found.answer
        self.verdict.set_text(answer.verdict)
        self.limits.set_content(limits_table(answer))
        self.pictures.set_content("".join(_figure(svg, text) for svg, text in found.pictures))
        rows = [(words(k), said(v, answer.units.get(k, ""))) for k, v in answer.results.items()]
        rows.append(("mass of the brakes", said(answer.mass, "kg")))
        needed = "none does" if answer.brakes_needed is None else str(answer.brakes_needed)
        rows.append(("brakes it would take", needed))
        self.results.set_content(html(("What", "Value"), rows, (1,), "Results"))
        self.notes.fill(answer.warnings)


def limits_table(answer: Answer) -> str:
    """Every limit, its value, and whether it is met."""
    rows = [
        (limit.name, said(limit.value, limit.unit),
         f"{'at least' if limit.least else 'at most'} {show(limit.limit, limit.unit)}",
         "met" if limit.met else f"missed, by {limit.factor:.3g} times"
         if 0 < limit.factor < float("inf") else "missed")
        for limit in answer.record.limits
    ]  # fmt: skip
    return html(("Limit", "Value", "Allowed", ""), rows, (1, 2), "Limits")


def _figure(svg: str, caption: str) -> str:
    """A drawing as an image of its own, so that nothing in it meets the page."""
    points = re.search(r'<svg[^>]*? width="([0-9.]+)pt"', svg)
    wide = float(points.group(1)) * 1.2 if points else 700.0  # every figure at one scale
    data = base64.b64encode(svg.encode()).decode()
    return (
        f'<figure style="margin: 0 0 16px"><img class="design-picture" '
        f'style="max-width: {wide:.0f}px" alt="{escape(caption)}" '
        f'src="data:image/svg+xml;base64,{data}"><figcaption class="text-sm opacity-80" '
        f'style="max-width: 75ch">{escape(caption)}</figcaption></figure>'
    )
