"""Several of the desk's brake as one: side by side, one behind the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from layerjam.report.style import ORANGE
from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call
from layerjam.workbench.charts import options
from layerjam.workbench.controls import Control, asked, by_key, vacuum_asked
from layerjam.workbench.more import More
from layerjam.workbench.outcomes import of_pull
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.design_part import PAGE, Part
from layerjam.workbench.panel import Panel
from layerjam.workbench.widgets import columns, hint, status

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
