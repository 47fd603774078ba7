"""Force over mass: the desk's brake, the catalogue's, and what others make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from nicegui import ui

from layerjam.device.load import catalogue, load
from layerjam.report.style import GREY
from layerjam.units import show
from layerjam.workbench import live
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import COLORS, ink_of, options
from layerjam.workbench.controls import Control, asked, by_key
from layerjam.workbench.page import Notes
from layerjam.workbench.pages.design_front import PALE
from layerjam.workbench.pages.design_part import PAGE, Part
from layerjam.workbench.tables import html
from layerjam.workbench.widgets import chart, dressed, hint

GRAMS = 1e3
SYMBOLS = (
    ("bad", "rect"),
    ("good", "triangle"),
    ("other", "diamond"),
    ("second", "pin"),
    ("sky", "roundRect"),
)
HEADS = ("Device", "Kind", "Mass", "Force", "Force over mass", "Source")


class Density(Part):
    """A log-log picture and a table with the sources."""

    def controls(self) -> Mapping[str, Control]:
        """The vacuum of ours."""
        sites = [self.desk.brake, *map(load, catalogue())]
        full = min(file.brake.site.atmosphere for file in sites)
        span, name = (0.05 * full, full), "Vacuum of ours"
        ours = asked("compare", "vacuum", min(94.5e3, full), span, key="ours", label=name)
        return by_key(ours.within(high=full))

    def build(self) -> None:
        """The picture over the table."""
        with ui.column().classes("side"):
            self.slider("ours")
        what = "Force over mass, both logarithmic; the table below has the numbers"
        self.chart = chart(f"{PAGE}-density-chart", what, "width: 100%; height: 540px")
        self.sheet = dressed(live.Words(""), f"{PAGE}-sheet", "text-sm")
        self.missing = hint("")
        self.table = dressed(live.Table(), f"{PAGE}-density-table", "w-full")
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """The desk's brake first, then the catalogue's."""
        here = self.desk.brake_subject()
        others = [Subject(name) for name in catalogue() if name != here.name]
        return [Call("compare", (here, *others), {"vacuum": self.text("ours")})]

    def draw(self, found: Any) -> None:
        """Picture, what a sheet adds, table."""
        (found,) = found
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
        rows = []
        for r in found.devices:
            numbers = (("mass", "kg"), ("max_force", "N"), ("force_density", "N/kg"))
            shown = [show(r[key], unit) for key, unit in numbers]
            source = " ".join(filter(None, (r["source"], r["note"])))
            rows.append((r["name"], r["kind"], *shown, source))
        made = html(HEADS, rows, (2, 3, 4), "Force over mass of devices")
        self.table.set_content(made)
        self.notes.fill(found.warnings)


def density_chart(result: Any, dark: bool) -> dict[str, Any]:
    """Devices by kind, the first brake's line of more sheets, lines of one force density."""
    rows, lines, _ = result.record
    first, ink = lines[0], ink_of(dark)
    axes: dict[str, Any] = {"x": "mass [g]", "y": "greatest force [N]", "y_range": (None, None)}
    made = options([], dark=dark, log=(True, True), **axes)
    masses = [r["mass"] * GRAMS for r in rows] + [m * GRAMS for m in first.masses]
    forces = [r["max_force"] for r in rows] + list(first.forces)
    x, y = _decades(min(masses), max(masses)), _decades(min(forces), max(forces))
    made["xAxis"] |= {"min": x[0], "max": x[1]}
    made["yAxis"] |= {"min": y[0], "max": y[1]}
    made["grid"] |= {"right": 60, "left": 70}
    made["tooltip"] = {"trigger": "item", "confine": True, "formatter": "{b}"}
    ours = [r for r in rows if r["computed"]]
    kinds = dict.fromkeys(r["kind"] for r in rows if not r["computed"])
    series = _equal(x, y, PALE if dark else GREY)
    series += [_more_sheets(first, ink), _points(ours, "main", "circle", ink)]
    for place, kind in enumerate(kinds):
        color, symbol = SYMBOLS[place % len(SYMBOLS)]
        mine = [r for r in rows if r["kind"] == kind and not r["computed"]]
        series.append(_points(mine, color, symbol, ink, kind))
    made["series"] = series
    return made


def _more_sheets(line: Any, ink: str) -> dict[str, Any]:
    """What more sheets make of a brake."""
    data = []
    for place, (count, m, f) in enumerate(zip(line.sheets, line.masses, line.forces, strict=True)):
        label = dict(show=place > 0, formatter=f"{count} sheets", position="left")
        label |= dict(color=ink, fontSize=11)
        data.append({"value": [_short(m * GRAMS), _short(f)], "label": label})
    return {
        **dict(type="line", name="more sheets", silent=True, symbol="circle", symbolSize=4),
        "color": COLORS["main"],
        "lineStyle": dict(type="dashed", width=1.3),
        "data": data,
    }


def _points(
    rows: Sequence[dict[str, Any]], color: str, symbol: str, ink: str, kind: str = ""
) -> dict[str, Any]:
    """A kind of device; of others the middle one bears the kind's name, of ours each its own."""
    named = sorted(rows, key=lambda r: r["mass"])[len(rows) // 2]["name"] if kind else ""
    data = []
    for place, r in enumerate(rows):
        first = not kind and place == 0
        unsure = ", friction not measured" if r["note"] else ""
        rim = " (torque at its own rim)" if r["lever"] else ""
        text = f"{kind}{rim}" if r["name"] == named else "" if kind else r["name"] + unsure
        mass, force, density = r["mass"], r["max_force"], show(r["force_density"], "N/kg")
        label = dict(show=bool(text), formatter=text, color=ink, fontSize=12 if first else 11)
        label |= dict(position="bottom" if kind else "right")
        label |= dict(fontWeight="bold" if first else "normal")
        name = f"{r['name']}: {show(mass, 'kg')}, {show(force, 'N')}, {density}"
        value = [_short(mass * GRAMS), _short(force)]
        data.append(dict(name=name, value=value, symbolSize=16 if first else 9, label=label))
    look = dict(type="scatter", name=kind or "ours", color=COLORS[color], symbol=symbol)
    more = dict(itemStyle={"opacity": 1}, labelLayout={"moveOverlap": "shiftY"})
    return {**look, **more, "data": data}


def _equal(x: tuple[float, float], y: tuple[float, float], color: str) -> list[dict[str, Any]]:
    """Straight lines of one force over mass, named inside the picture."""
    out = []
    for power in range(-1, 8):
        per_gram = 10.0**power / GRAMS
        left, right = max(x[0], y[0] / per_gram), min(x[1], y[1] / per_gram)
        if right <= left * 1.5:
            continue
        words = show(10.0**power, "N/kg", 4)
        end = dict(show=True, formatter=words, color=color, fontSize=11, distance=3)
        line = dict(type="line", name="", silent=True, showSymbol=False, color=color)
        line["data"] = [[_short(m), _short(m * per_gram)] for m in (left, right)]
        line |= dict(lineStyle=dict(width=0.6, opacity=0.7), endLabel=end)
        out.append(line)
    return out


def _decades(low: float, high: float) -> tuple[float, float]:
    """A span a little wider, on 1, 2 or 5 of a decade."""
    marks = [f * 10.0**p for p in range(-9, 10) for f in (1, 2, 5)]
    return max(m for m in marks if m <= low / 1.2), min(m for m in marks if m >= high * 1.2)


def _short(value: float) -> float:
    return float(f"{value:.5g}")
