"""The result of a design as a chart to click through and as tables; nothing here computes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from layerjam.design.design_file import plain_name
from layerjam.design.merit import MERITS, VARIABLES
from layerjam.design.requirements import DesignSpecification
from layerjam.design.verdict import named
from layerjam.report.design_figures import scale
from layerjam.report.style import GREY
from layerjam.units import show
from layerjam.workbench.charts import COLORS, ink_of, options
from layerjam.workbench.pages.design_part import said, words
from layerjam.workbench.tables import html

PALE = "#9aa5af"
"""Grey on a dark ground."""
Row = Mapping[str, Any]
CHOSEN, REFINED = -2, -1
"""In place of a design's number: the chosen one, whichever it is, and the one between the steps."""
MARKS = (
    ("chosen", "chosen", "main", "circle", 17),
    ("runner_up", "runner-up", "second", "rect", 13),
    ("refined", "between the steps", "good", "diamond", 15),
)


def designs(result: Any) -> dict[int, Row]:
    """Every design of the result, by number; the front in the order of the first objective."""
    first = result.record.spec.objectives[0]
    rows: dict[int, Row] = {
        d["number"]: d for d in sorted(result.front, key=lambda d: first.sign * d[first.name])
    }
    told = [result.chosen, result.runner_up, *(f["design"] for f in result.forbidden)]
    rows |= {d["number"]: d for d in told if d is not None}
    if result.refined is not None:
        rows[REFINED] = result.refined
    return rows


def picked(result: Any, wanted: int) -> tuple[int, Row]:
    """The design that is looked at; the chosen one where what is wanted is not in the result."""
    rows = designs(result)
    number = wanted if wanted in rows else result.chosen["number"]
    return number, rows[number]


def axes(result: Any) -> tuple[str, str]:
    """What the front is seen over: the first two objectives, or mass or force beside the one."""
    names = [o.name for o in result.record.spec.objectives][:2]
    if len(names) == 1:
        names.insert(0, "mass" if names[0] != "mass" else "holding_force")
    return names[0], names[1]


def drawable(result: Any) -> dict[str, str]:
    """Quantities the front can be seen over: numbers that differ among its designs."""
    out = {}
    for name in (*MERITS, *VARIABLES):
        values = {d.get(name) for d in result.front}
        if len(values) > 1 and all(isinstance(v, int | float) and math.isfinite(v) for v in values):
            out[name] = words(name)
    return out


def front_chart(result: Any, names: tuple[str, str], number: int, dark: bool) -> dict[str, Any]:
    """Every design on the front as a point; value[2] of a point is the design's number."""
    (fx, ux), (fy, uy) = (scale(result, n) for n in names)
    ink, faint = ink_of(dark), PALE if dark else GREY
    x, y = (f"{words(n)} [{unit}]" for n, unit in zip(names, (ux, uy), strict=True))
    made = options([], x=x, y=y, dark=dark, y_range=(None, None))

    def at(design: Row, key: int) -> list[float]:
        return [float(f"{design[names[0]] * fx:.6g}"), float(f"{design[names[1]] * fy:.6g}"), key]

    def point(design: Row, key: int, word: str = "") -> dict[str, Any]:
        return {"value": at(design, key), "name": f"{word}{': ' if word else ''}{named(design)}"}

    points = [point(d, d["number"]) for d in result.front]
    front = dict(type="scatter", name="on the front", color=faint, symbolSize=8, z=2)
    series: list[dict[str, Any]] = [{**front, "data": points}]
    aside, down = (_losing(result, n) for n in names)
    # the label of the uppermost mark is the uppermost, so that no two of their lines cross
    marks = sorted(_marks(result, names), key=lambda m: down * m[0][names[1]])
    for rank, (design, key, word, look) in enumerate(marks):
        shift = (34 * aside, -down * (16 + 19 * rank))
        series.append({**_marked(look, word, ink, shift), "data": [point(design, key, word)]})
    _, design = picked(result, number)
    ring = dict(color="transparent", borderColor=ink, borderWidth=2.2)
    looked = dict(type="scatter", name="looked at", silent=True, symbol="circle", symbolSize=26)
    series.append({**looked, "data": [at(design, number)], "z": 5, "itemStyle": ring})
    made["series"] = series
    made["tooltip"] = {"trigger": "item", "confine": True, "formatter": "{b}"}
    made["grid"] |= {"right": 190, "left": 70}
    for axis in ("xAxis", "yAxis"):
        made[axis] |= {"scale": True}
    return made


def _marked(look: Any, word: str, ink: str, shift: tuple[float, float]) -> dict[str, Any]:
    """A mark with its word beside it, on a line; `look` is (colour, symbol, size)."""
    color, symbol, size = COLORS[look[0]], look[1], look[2]
    side = "right" if shift[0] > 0 else "left"
    return {
        **dict(type="scatter", name=word, symbol=symbol, symbolSize=size, color=color, z=4),
        "itemStyle": dict(borderColor="#fff", borderWidth=1, opacity=1),
        "label": dict(show=True, formatter=word, color=ink, fontSize=12, position=side),
        "labelLine": {"show": True, "lineStyle": {"color": color}},
        "labelLayout": {"dx": shift[0], "dy": shift[1]},
    }


def _marks(result: Any, names: tuple[str, str]) -> list[tuple[Row, int, str, Any]]:
    """(design, number, word, look) of what is named in the picture."""
    made: list[tuple[Row, int, str, Any]] = []
    for key, word, *look in MARKS:
        design = result.values[key]
        if design is not None:
            made.append((design, REFINED if key == "refined" else design["number"], word, look))
    for blocked in sorted(result.forbidden, key=lambda f: f["short"])[:1]:
        design, word = blocked["design"], f"but for {blocked['constraint']}"
        if all(math.isfinite(design[n]) for n in names):
            made.append((design, design["number"], word, ("bad", "triangle", 13)))
    return made


def _losing(result: Any, name: str) -> float:
    """1 where more of it is worse, -1 where less is: nothing is drawn on that side of the front."""
    goals = {o.name: o.least for o in result.record.spec.objectives}
    return 1.0 if goals.get(name, True) else -1.0


def comparison(result: Any, number: int) -> str:
    """The design looked at, the chosen one, the refined one and the runner-up, row by row."""
    spec = result.record.spec
    number, design = picked(result, number)
    columns: dict[str, Row] = {"looked at": design, "chosen": result.chosen}
    if result.refined is not None:
        columns["between the steps"] = result.refined
    if result.runner_up is not None:
        columns["runner-up"] = result.runner_up
    asked: dict[str, list[str]] = {}
    for c in spec.constraints:
        sign = "at most" if c.most else "at least"
        asked.setdefault(c.name, []).append(f"{sign} {show(c.limit, c.unit)}")
    for o in spec.objectives:
        asked.setdefault(o.name, []).append("least" if o.least else "most")
    rows = []
    for name in ("film", *VARIABLES, *(n for n in MERITS if n not in VARIABLES)):
        cells = [said(d.get(name), result.units.get(name, "1")) for d in columns.values()]
        if set(cells) != {"–"}:
            rows.append((words(name), ", ".join(asked.get(name, [])), *cells))
    heads = ("", "asked for", *columns)
    return html(heads, rows, range(2, len(heads)), "Designs side by side")


def forbidden(result: Any) -> str:
    """What would have been better but for one constraint."""
    units = {str(c): c.unit for c in result.record.spec.constraints}
    rows = []
    for f in result.forbidden:
        value = said(f["value"], units[f["constraint"]])
        missed, gain = f"{f['short']:.1%}", f"{f['gain']:.1%}"
        rows.append((f["constraint"], named(f["design"]), value, missed, gain))
    if not rows:
        return "<p>No single constraint keeps a better design out.</p>"
    heads = ("Constraint", "keeps out", "which has", "missed by", "better by")
    return html(heads, rows, (2, 3, 4), "Designs that one constraint forbids")


def chances(result: Any) -> str:
    """How likely each constraint holds with the scatter in friction."""
    units = {str(c): c.unit for c in result.record.spec.constraints}
    rows = []
    for name, c in result.robustness.items():
        shares = (f"{c['probability']:.1%}", f"{c['error']:.1%}")
        span = (said(c[end], units.get(name, "1")) for end in ("low", "high"))
        rows.append(("all of them" if name == "all" else name, *shares, *span))
    if not rows:
        return "<p>The brake states no scatter of its friction, so none is taken into account.</p>"
    heads = ("Constraint", "holds", "give or take", "5 % below", "5 % above")
    return html(heads, rows, (1, 2, 3, 4), "Robustness of the chosen design")


def slopes(result: Any) -> str:
    """What one percent more of a number changes, in percent."""
    table = result.sensitivities
    names = dict.fromkeys(n for row in table.values() for n in row)
    rows = []
    for n in names:
        changes = [row.get(n, 0.0) for row in table.values()]
        if any(abs(c) > 0.005 for c in changes):
            rows.append((words(n), *(f"{c:+.2f}" if abs(c) > 0.005 else "–" for c in changes)))
    heads = ("1 % more of", *(f"{words(m)} [%]" for m in table))
    return html(heads, rows, range(1, len(heads)), "Sensitivities of the chosen design")


def verdict(result: Any) -> str:
    """The outcome in a few sentences."""
    if not result.feasible:
        return refusal(result)
    text = (
        f"{result.feasible_designs:,} of {result.designs:,} designs meet all constraints; "
        f"{result.front_size:,} are on the front. Chosen: {named(result.chosen)}."
    )
    if result.runner_up is not None:
        text += f"\nRunner-up: {named(result.runner_up)}; {result.runner_up_lost}."
    if result.binding:
        text += f"\nHeld by {', '.join(result.binding)}."
    return text


def refusal(result: Any) -> str:
    """Which constraint kills a specification, and what could be had."""
    text = f"Not possible: {result.reason}."
    if result.excludes:
        text += (
            f" At least one of {result.killed_by}, {', '.join(result.excludes)} must be relaxed."
        )
    if not result.examined:
        return f"{text} Shown by bounds, before any of the {result.designs:,} designs was computed."
    return f"{text} All {result.examined:,} designs were computed."


def along(result: Any) -> list[int]:
    """Numbers of the front in the order of the first objective."""
    first = result.record.spec.objectives[0]
    rows = sorted(result.front, key=lambda d: (first.sign * d[first.name], d["number"]))
    return [d["number"] for d in rows]


def file_name(spec: DesignSpecification) -> str:
    """What a file of this specification is called."""
    return plain_name(spec.name)
