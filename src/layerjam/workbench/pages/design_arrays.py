"""Several of the desk's brake as one: side by side, one behind the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from nicegui import ui

from layerjam.commands.answer import VACUUM, Answer
from layerjam.commands.array import PARALLEL, SERIES
from layerjam.units import QuantitySpec
from layerjam.workbench import live
from layerjam.workbench.call import Call
from layerjam.workbench.charts import Curve, options, with_readout
from layerjam.workbench.controls import Control
from layerjam.workbench.page import Figures, Notes
from layerjam.workbench.pages.design_part import PAGE, Part

MM = 1e3
WIDE, LONG = 20, 10
"""Brakes side by side and in series at most, on this page."""
TOTALS = [
    ("brakes", "Brakes"), ("peak_force", "Peak force"), ("peak_elongation", "at elongation"),
    ("end", "Elongation at the end"), ("travel", "Travel, by slip alone"),
    ("energy", "Work of slipping all"), ("stiffness", "Stiffness before slip"), ("mass", "Mass"),
    ("force_density", "Force over mass"), ("outcome", "Outcome"),
]  # fmt: skip


class Arrays(Part):
    """The desk's brake, N side by side, M in series."""

    def controls(self) -> dict[str, Control]:
        """How many, and their vacuum."""
        full = self.desk.brake.brake.site.atmosphere
        vacuum = QuantitySpec("Pa", VACUUM.text, 0.0, full, open_lo=True)
        return {
            c.key: c
            for c in (
                Control("parallel", replace(PARALLEL, hi=WIDE), 2, 1, WIDE, label="Side by side",
                        steps=WIDE - 1),
                Control("series", replace(SERIES, hi=LONG), 2, 1, LONG, label="In series",
                        steps=LONG - 1),
                Control("vacuum", vacuum, min(94.5e3, full), 0.01 * full, full),
            )
        }  # fmt: skip

    def build(self) -> None:
        """Controls and totals left, force over elongation right."""
        with ui.row().classes("w-full no-wrap items-start gap-6 page"):
            with ui.column().classes("side"):
                for key in ("parallel", "series", "vacuum"):
                    self.slider(key)
                self.figures = Figures(f"{PAGE}-array", TOTALS)
            with ui.column().classes("main gap-2"):
                self.chart = ui.echart({}).classes("chart").props(
                    f'data-testid="{PAGE}-array-chart" role="img" '
                    'aria-label="Force over elongation of the array and of one brake"'
                )  # fmt: skip
                ui.label(
                    "In series the weakest slips first; once it slides the others relax, and the "
                    "next slips only when the first is on its stop: the teeth of the curve."
                ).classes("text-sm opacity-80")
                self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The array, and one brake beside it."""
        here, vacuum = (self.desk.brake_subject(),), self.text("vacuum")
        said: dict[str, str | float | bool] = {
            "parallel": int(self.value("parallel")), "series": int(self.value("series")),
            "vacuum": vacuum,
        }  # fmt: skip
        return [Call("array", here, said), Call("array", here, {"vacuum": vacuum})]

    def compute(self) -> Any:
        """Both."""
        return [call.run() for call in self.calls()]

    def draw(self, found: Any) -> None:
        """Curves, totals and notes."""
        whole, one = found
        live.draw(self.chart, array_chart(whole, one, self.page.dark))
        self.figures.fill(whole)
        self.notes.fill(whole.warnings)


def array_chart(whole: Answer, one: Answer, dark: bool) -> dict[str, Any]:
    """Force over elongation of the array and of a single brake."""
    many = f"{whole.parallel} × {whole.series}"
    curves = [Curve(whole.record.elongation * MM, whole.record.force, name=many, width=2.5)]
    if whole.brakes > 1:
        curves.append(Curve(one.record.elongation * MM, one.record.force, "second", "one brake"))
    made = options(
        curves, x="elongation [mm]", y="force [N]", dark=dark,
        marks=[(whole.peak_elongation * MM, whole.peak_force, f"{whole.peak_force:.0f} N", "bad")],
    )  # fmt: skip
    made["grid"]["top"] = 34
    return with_readout(made, ("elongation", "mm"), "N")
