"""Force over mass: the desk's brake, the catalogue's, and what others make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import ui

from layerjam.commands.answer import VACUUM, Answer
from layerjam.design.comparison import KIND
from layerjam.device.load import catalogue, load
from layerjam.report.style import GREY, INK
from layerjam.units import QuantitySpec, show
from layerjam.workbench import live
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import COLORS, options
from layerjam.workbench.controls import Control
from layerjam.workbench.page import Notes
from layerjam.workbench.pages.design_front import PALE
from layerjam.workbench.pages.design_part import PAGE, Part
from layerjam.workbench.tables import html

GRAMS = 1e3
SYMBOLS = (("bad", "rect"), ("good", "triangle"), ("other", "diamond"), ("second", "pin"),
           ("sky", "roundRect"))  # fmt: skip


class Density(Part):
    """A log-log picture and a table with the sources."""

    def controls(self) -> dict[str, Control]:
        """The vacuum of ours."""
        sites = [self.desk.brake, *map(load, catalogue())]
        full = min(file.brake.site.atmosphere for file in sites)
        vacuum = QuantitySpec("Pa", VACUUM.text, 0.0, full, open_lo=True)
        return {"ours": Control("ours", vacuum, min(94.5e3, full), 0.05 * full, full,
                                label="Vacuum of ours")}  # fmt: skip

    def build(self) -> None:
        """The picture over the table."""
        with ui.column().classes("side"):
            self.slider("ours")
        self.chart = ui.echart({}).classes("chart").style("height: 540px").props(
            f'data-testid="{PAGE}-density-chart" role="img" '
            'aria-label="Force over mass, both logarithmic; the table below has the numbers"'
        )  # fmt: skip
        self.sheet = live.Words("").classes("text-sm").props(f'data-testid="{PAGE}-sheet"')
        self.missing = ui.label("").classes("text-sm opacity-80")
        self.table = live.Table().classes("w-full").props(
            f'data-testid="{PAGE}-density-table"'
        )  # fmt: skip
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The desk's brake first, then the catalogue's."""
        here = self.desk.brake_subject()
        others = [Subject(name) for name in catalogue() if name != here.name]
        return [Call("compare", (here, *others), {"vacuum": self.text("ours")})]

    def compute(self) -> Any:
        """The comparison."""
        return self.calls()[0].run()

    def draw(self, found: Any) -> None:
        """Picture, what a sheet adds, table."""
        live.draw(self.chart, density_chart(found, self.page.dark))
        sheet = found.sheet
        self.sheet.set_text(
            f"One more sheet in {sheet['brake']} at {show(sheet['vacuum'], 'Pa')}: "
            f"{show(sheet['force_per_sheet'], 'N', 3)} and {show(sheet['mass_per_sheet'], 'kg', 3)}"
            f"; the paper says {show(sheet['paper_force'], 'N', 3)} and "
            f"{show(sheet['paper_mass'], 'kg', 3)} ({sheet['why']})."
        )
        lacking = ", ".join(found.none_found)
        self.missing.set_text(
            f"Not drawn, for no device with a source was found: {lacking}." if lacking else ""
        )
        rows = [
            (r["name"], r["kind"], show(r["mass"], "kg"), show(r["max_force"], "N"),
             show(r["force_density"], "N/kg"), " ".join(filter(None, (r["source"], r["note"]))))
            for r in found.devices
        ]  # fmt: skip
        self.table.set_content(
            html(("Device", "Kind", "Mass", "Force", "Force over mass", "Source"), rows,
                       (2, 3, 4), "Force over mass of devices")
        )  # fmt: skip
        self.notes.fill(found.warnings)


def density_chart(answer: Answer, dark: bool) -> dict[str, Any]:
    """Devices by kind, the first brake's line of more sheets, lines of one force density."""
    rows, lines, _ = answer.record
    first = lines[0]
    ink = "#dfe5ea" if dark else INK
    made = options([], x="mass [g]", y="greatest force [N]", dark=dark, log=(True, True),
                   y_range=(None, None))  # fmt: skip
    masses = [r["mass"] * GRAMS for r in rows] + [m * GRAMS for m in first.masses]
    forces = [r["max_force"] for r in rows] + list(first.forces)
    x, y = _decades(min(masses), max(masses)), _decades(min(forces), max(forces))
    made["xAxis"] |= {"min": x[0], "max": x[1]}
    made["yAxis"] |= {"min": y[0], "max": y[1]}
    made["grid"] |= {"right": 60, "left": 70}
    made["tooltip"] = {"trigger": "item", "confine": True, "formatter": "{b}"}
    series: list[dict[str, Any]] = _equal(x, y, PALE if dark else GREY)
    series.append({
        "type": "line", "name": "more sheets", "silent": True, "symbol": "circle", "symbolSize": 4,
        "color": COLORS["main"], "lineStyle": {"type": "dashed", "width": 1.3},
        "data": [
            {"value": [_short(m * GRAMS), _short(f)],
             "label": {"show": place > 0, "formatter": f"{count} sheets", "position": "left",
                       "color": ink, "fontSize": 11}}
            for place, (count, m, f) in enumerate(
                zip(first.sheets, first.masses, first.forces, strict=True))
        ],
    })  # fmt: skip
    ours = [r for r in rows if r["computed"]]
    series.append(_points(ours, "main", "circle", ink, ours[0]["name"]))
    kinds = dict.fromkeys(r["kind"] for r in rows if r["kind"] != KIND)
    for place, kind in enumerate(kinds):
        color, symbol = SYMBOLS[place % len(SYMBOLS)]
        mine = [r for r in rows if r["kind"] == kind]
        series.append(_points(mine, color, symbol, ink, "", kind))
    made["series"] = series
    return made


def _points(
    rows: Sequence[dict[str, Any]], color: str, symbol: str, ink: str, first: str, kind: str = ""
) -> dict[str, Any]:
    """A kind of device; of others the middle one bears the kind's name, of ours each its own."""
    named = sorted(rows, key=lambda r: r["mass"])[len(rows) // 2]["name"] if kind else ""
    data = []
    for r in rows:
        mine = r["name"] == first
        unsure = ", friction not measured" if r["note"] else ""
        rim = " (torque at its own rim)" if r["lever"] else ""
        text = f"{kind}{rim}" if r["name"] == named else "" if kind else r["name"] + unsure
        data.append({
            "name": f"{r['name']}: {show(r['mass'], 'kg')}, {show(r['max_force'], 'N')}, "
                    f"{show(r['force_density'], 'N/kg')}",
            "value": [_short(r["mass"] * GRAMS), _short(r["max_force"])],
            "symbolSize": 16 if mine else 9,
            "label": {"show": bool(text), "formatter": text, "color": ink,
                      "position": "bottom" if kind else "right", "fontSize": 12 if mine else 11,
                      "fontWeight": "bold" if mine else "normal"},
        })  # fmt: skip
    return {
        "type": "scatter", "name": kind or "ours", "color": COLORS[color], "symbol": symbol,
        "data": data, "itemStyle": {"opacity": 1}, "labelLayout": {"moveOverlap": "shiftY"},
    }  # fmt: skip


def _equal(x: tuple[float, float], y: tuple[float, float], color: str) -> list[dict[str, Any]]:
    """Straight lines of one force over mass, named inside the picture."""
    out = []
    for power in range(-1, 8):
        per_gram = 10.0**power / GRAMS
        left, right = max(x[0], y[0] / per_gram), min(x[1], y[1] / per_gram)
        if right <= left * 1.5:
            continue
        out.append({
            "type": "line", "name": "", "silent": True, "showSymbol": False, "color": color,
            "lineStyle": {"width": 0.6, "opacity": 0.7},
            "data": [[_short(left), _short(left * per_gram)],
                     [_short(right), _short(right * per_gram)]],
            "endLabel": {"show": True, "formatter": show(10.0**power, "N/kg", 4), "color": color,
                         "fontSize": 11, "distance": 3},
        })  # fmt: skip
    return out


def _decades(low: float, high: float) -> tuple[float, float]:
    """A span a little wider, on 1, 2 or 5 of a decade."""
    marks = [f * 10.0**p for p in range(-9, 10) for f in (1, 2, 5)]
    return max(m for m in marks if m <= low / 1.2), min(m for m in marks if m >= high * 1.2)


def _short(value: float) -> float:
    return float(f"{value:.5g}")
