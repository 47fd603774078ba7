"""Force versus mass: the current brake, the catalogue's brakes, and published devices."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from nicegui import ui

from layerjam.brake.device.load import devices, load
from layerjam.core.drawing.style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import text_colour
from layerjam.workbench.controls import Control, map_keys, vacuum_control
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Notes, Page
from layerjam.workbench.pages.design_front import PALE, points_chart, scatter
from layerjam.workbench.pages.design_part import PAGE, Part
from layerjam.workbench.panel import Panel
from layerjam.workbench.tables import html_table
from layerjam.workbench.widgets import dress, hint

GRAMS = 1e3
SYMBOLS = (
    (RED, "rect"),
    (GREEN, "triangle"),
    (PURPLE, "diamond"),
    (ORANGE, "pin"),
    (SKY, "roundRect"),
)
HEADS = ("Device", "Kind", "Mass", "Force", "Force per unit mass", "Source")


class Density(Part):
    """Part with a log-log chart, and a table with the sources of its points."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.more = OtherInputs(page, "compare", ("vacuum",))
        self.panel = Panel(self.desk, PAGE, f"{PAGE}-density")

    def controls(self) -> Mapping[str, Control]:
        """Return the control for the vacuum of the computed brakes."""
        sites = [self.desk.brake, *map(load, devices())]
        full_vacuum = self.more.atmosphere(min(file.brake.site.atmosphere for file in sites))
        name = "Vacuum of the computed brakes"
        vacuum = vacuum_control(
            "compare", "vacuum", full_vacuum, 0.05 * full_vacuum, key="ours", label=name
        )
        return map_keys(vacuum)

    def build(self) -> None:
        """Build the control, the chart, and the table below."""
        with ui.column().classes("side"):
            self.add_slider("ours")
            self.more.build()
        label = "Force versus mass on logarithmic axes; the table below lists the numbers"
        look = "width: 100%; height: max(540px, 60vh)"
        self.panel.build(f"{PAGE}-density-chart", label, look)
        self.panel.build_exports()
        self.sheet = dress(live.Words(""), f"{PAGE}-sheet", "text-sm")
        self.missing = hint("")
        self.table = dress(live.Table(), f"{PAGE}-density-table", "w-full")
        self.notes = Notes()

    def calls(self) -> Sequence[Call]:
        """Return a comparison of the desk's brake, listed first, with the catalogue's brakes."""
        subject = self.desk.brake_subject()
        other_subjects = [Subject(name) for name in devices() if name != subject.name]
        return [
            Call(
                "compare",
                (subject, *other_subjects),
                {"vacuum": self.text("ours"), **self.more.options()},
            )
        ]

    def draw(self, answers: Sequence[Answer]) -> None:
        """Draw the chart, and show the effect of one more sheet and the table."""
        (answer,) = answers
        result = answer.result
        self.panel.draw(answer, density_chart(result, self.page.dark))
        sheet = result.sheet
        self.sheet.set_text(
            f"One more sheet in {sheet['brake']} at {show(sheet['vacuum'], 'Pa')} adds "
            f"{show(sheet['force_per_sheet'], 'N', 3)} and {show(sheet['mass_per_sheet'], 'kg', 3)}"
            f"; the paper reports {show(sheet['paper_force'], 'N', 3)} and "
            f"{show(sheet['paper_mass'], 'kg', 3)} ({sheet['why']})."
        )
        lacking = ", ".join(result.none_found)
        self.missing.set_text(
            f"Not drawn, because no published device was found: {lacking}." if lacking else ""
        )
        rows = [
            (
                r["name"],
                r["kind"],
                *_format_cells(r),
                " ".join(filter(None, (r["source"], r["note"]))),
            )
            for r in result.devices
        ]
        self.table.set_content(html_table(HEADS, rows, (2, 3, 4), "Force versus mass of devices"))
        self.notes.fill(result.warnings)


def density_chart(result: Any, dark: bool) -> dict[str, Any]:
    """Return the chart: devices by kind, a curve for more sheets, lines of equal force density."""
    rows, lines, _ = result.record
    first, ink = lines[0], text_colour(dark)
    masses = [r["mass"] * GRAMS for r in rows] + [m * GRAMS for m in first.masses]
    forces = [r["max_force"] for r in rows] + list(first.forces)
    x, y = _decade_limits(min(masses), max(masses)), _decade_limits(min(forces), max(forces))
    kinds: dict[str, list[Any]] = {}
    for r in rows:
        kinds.setdefault("" if r["computed"] else r["kind"], []).append(r)
    computed_rows = kinds.pop("")
    series = [*_isolines(x, y, PALE if dark else GREY), _sheet_count_line(first, ink)]
    series.append(_device_series(computed_rows, BLUE, "circle", ink))
    for look, (kind, rows) in zip(itertools.cycle(SYMBOLS), kinds.items(), strict=False):
        series.append(_device_series(rows, *look, ink, kind))
    axes = {"x": "mass [g]", "y": "maximum force [N]"}
    chart = points_chart(series, dark=dark, right=60, **axes)
    for axis, (low, high) in (("xAxis", x), ("yAxis", y)):
        chart[axis][0] |= {"type": "log", "min": low, "max": high}
    return chart


def _sheet_count_line(line: Any, ink: str) -> dict[str, Any]:
    data = []
    for place, (count, m, f) in enumerate(zip(line.sheets, line.masses, line.forces, strict=True)):
        label = dict(show=place > 0, formatter=f"{count} sheets", position="left")
        data.append({"value": _chart_point(m, f), "label": dict(label, color=ink, fontSize=11)})
    line_style = dict(type="dashed", width=1.3)
    look = dict(silent=True, symbol="circle", symbolSize=4, lineStyle=line_style)
    return dict(type="line", name="more sheets", color=BLUE, data=data, **look)


def _device_series(
    rows: Sequence[dict[str, Any]], color: str, symbol: str, ink: str, kind: str = ""
) -> dict[str, Any]:
    """Return the points of one kind of device; only those of computed brakes are all named.

    The first brake is labelled with its name and vacuum, others with what differs from it.
    """
    strongest = max(rows, key=lambda r: r["max_force"])["name"] if kind else ""
    data = []
    for place, r in enumerate(rows):
        first = not kind and place == 0
        unsure = ", friction not measured" if r["note"] else ""
        rim = " (torque at the device's own rim)" if r["lever"] else ""
        name_shown = r["name"] if first else _short_name(r["name"], rows[0]["name"])
        text = f"{kind}{rim}" if r["name"] == strongest else "" if kind else name_shown + unsure
        label = dict(show=bool(text), formatter=text, color=ink, fontSize=12 if first else 11)
        free = dict(position="top" if len(rows) > 1 else "bottom", lineHeight=13)
        label |= free | dict(width=130, overflow="break") if kind else dict(position="right")
        label |= dict(fontWeight="bold" if first else "normal")
        name = f"{r['name']}: {', '.join(_format_cells(r))}"
        value, size = _chart_point(r["mass"], r["max_force"]), 16 if first else 9
        data.append(dict(name=name, value=value, symbolSize=size, label=label))
    look = dict(color=color, symbol=symbol, labelLayout={"moveOverlap": "shiftY"})
    return scatter(kind or "ours", data, itemStyle={"opacity": 1}, **look)


def _short_name(name: str, first: str) -> str:
    """Return the part of a name that differs from the first name, "BRAKE, VACUUM"."""
    brake, _, vacuum = first.rpartition(", ")
    return name.removesuffix(f", {vacuum}").removeprefix(f"{brake}, ")


def _isolines(x: tuple[float, float], y: tuple[float, float], color: str) -> list[dict[str, Any]]:
    """Return straight lines of constant force per unit mass, labelled inside the chart."""
    out = []
    for density in (10.0**power for power in range(-1, 8)):
        left, right = max(x[0], y[0] * GRAMS / density), min(x[1], y[1] * GRAMS / density)
        if right <= left * 1.5:
            continue
        words = show(density, "N/kg", 4)
        end = dict(show=True, formatter=words, color=color, fontSize=11, distance=3)
        look = dict(color=color, lineStyle=dict(width=0.6, opacity=0.7), endLabel=end)
        data = [_chart_point(m / GRAMS, m / GRAMS * density) for m in (left, right)]
        out.append(dict(type="line", name="", silent=True, showSymbol=False, data=data, **look))
    return out


def _decade_limits(low: float, high: float) -> tuple[float, float]:
    """Return limits outside a span, each 1, 2 or 5 times a power of ten."""
    marks = [f * 10.0**p for p in range(-9, 10) for f in (1, 2, 5)]
    return max(m for m in marks if m <= low / 1.2), min(m for m in marks if m >= high * 1.2)


def _chart_point(mass: float, force: float) -> list[float]:
    return [float(f"{value:.5g}") for value in (mass * GRAMS, force)]


def _format_cells(row: dict[str, Any]) -> list[str]:
    units = {"mass": "kg", "max_force": "N", "force_density": "N/kg"}
    return [show(row[key], unit) for key, unit in units.items()]
