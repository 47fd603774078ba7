"""A design's answer as a chart to click through and as tables; nothing here computes a design."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from layerjam.commands.answer import Answer
from layerjam.design.design_file import plain_name
from layerjam.design.merit import MERITS, VARIABLES
from layerjam.design.requirements import DesignSpecification
from layerjam.design.verdict import named
from layerjam.report.design_figures import scale
from layerjam.report.style import GREY, INK
from layerjam.units import show
from layerjam.workbench.charts import COLORS, options
from layerjam.workbench.pages.design_part import said, words
from layerjam.workbench.tables import html

PALE = "#9aa5af"
"""Grey on a dark ground."""
Row = Mapping[str, Any]
CHOSEN, REFINED = -2, -1
"""In place of a design's number: the chosen one, whichever it is, and the one between the steps."""
MARKS = (
    ("chosen", "chosen", "main", "circle", 17), ("runner_up", "runner-up", "second", "rect", 13),
    ("refined", "between the steps", "good", "diamond", 15),
)  # fmt: skip


def designs(answer: Answer) -> dict[int, Row]:
    """Every design the answer tells of, by number; the front in the order of the first wish."""
    first = answer.record.spec.objectives[0]
    rows: dict[int, Row] = {
        d["number"]: d for d in sorted(answer.front, key=lambda d: first.sign * d[first.name])
    }
    told = [answer.chosen, answer.runner_up, *(f["design"] for f in answer.forbidden)]
    rows |= {d["number"]: d for d in told if d is not None}
    if answer.refined is not None:
        rows[REFINED] = answer.refined
    return rows


def picked(answer: Answer, wanted: int) -> tuple[int, Row]:
    """The design that is looked at; the chosen one where what is wanted is not told of."""
    rows = designs(answer)
    number = wanted if wanted in rows else answer.chosen["number"]
    return number, rows[number]


def axes(answer: Answer) -> tuple[str, str]:
    """What the front is seen over: the first two wishes; with one, mass or the holding force."""
    names = [o.name for o in answer.record.spec.objectives][:2]
    if len(names) == 1:
        names.insert(0, "mass" if names[0] != "mass" else "holding_force")
    return names[0], names[1]


def drawable(answer: Answer) -> dict[str, str]:
    """Quantities the front can be seen over: numbers that differ among its designs."""
    out = {}
    for name in (*MERITS, *VARIABLES):
        values = {d.get(name) for d in answer.front}
        if len(values) > 1 and all(isinstance(v, int | float) and math.isfinite(v) for v in values):
            out[name] = words(name)
    return out


def front_chart(answer: Answer, names: tuple[str, str], number: int, dark: bool) -> dict[str, Any]:
    """Every design on the front as a point; value[2] of a point is the design's number."""
    (fx, ux), (fy, uy) = (scale(answer, n) for n in names)
    ink = "#dfe5ea" if dark else INK
    made = options(
        [], x=f"{words(names[0])} [{ux}]", y=f"{words(names[1])} [{uy}]", dark=dark,
        y_range=(None, None),
    )  # fmt: skip

    def at(design: Row, key: int) -> list[float]:
        return [float(f"{design[names[0]] * fx:.6g}"), float(f"{design[names[1]] * fy:.6g}"), key]

    def point(design: Row, key: int, word: str = "") -> dict[str, Any]:
        return {"value": at(design, key), "name": f"{word}{': ' if word else ''}{named(design)}"}

    series: list[dict[str, Any]] = [{
        "type": "scatter", "name": "on the front", "color": PALE if dark else GREY,
        "symbolSize": 8, "data": [point(d, d["number"]) for d in answer.front], "z": 2,
    }]  # fmt: skip
    marks = _marks(answer, names)
    aside, down = (_losing(answer, n) for n in names)
    # the label of the uppermost mark is the uppermost, so that no two of their lines cross
    for rank, (design, key, word, look) in enumerate(
        sorted(marks, key=lambda m: -down * m[0][names[1]], reverse=True)
    ):
        series.append({
            "type": "scatter", "name": word, "data": [point(design, key, word)],
            "symbol": look[1], "symbolSize": look[2], "color": COLORS[look[0]], "z": 4,
            "itemStyle": {"borderColor": "#fff", "borderWidth": 1, "opacity": 1},
            "label": {"show": True, "formatter": word, "color": ink, "fontSize": 12,
                      "position": "right" if aside > 0 else "left"},
            "labelLine": {"show": True, "lineStyle": {"color": COLORS[look[0]]}},
            "labelLayout": {"dx": 34 * aside, "dy": -down * (16 + 19 * rank)},
        })  # fmt: skip
    _, design = picked(answer, number)
    series.append({
        "type": "scatter", "name": "looked at", "silent": True, "symbol": "circle",
        "symbolSize": 26, "data": [at(design, number)], "z": 5,
        "itemStyle": {"color": "transparent", "borderColor": ink, "borderWidth": 2.2},
    })  # fmt: skip
    made["series"] = series
    made["tooltip"] = {"trigger": "item", "confine": True, "formatter": "{b}"}
    made["grid"] |= {"right": 190, "left": 70}
    for axis in ("xAxis", "yAxis"):
        made[axis] |= {"scale": True}
    return made


def _marks(answer: Answer, names: tuple[str, str]) -> list[tuple[Row, int, str, Any]]:
    """(design, number, word, look) of what is named in the picture."""
    made: list[tuple[Row, int, str, Any]] = []
    for key, word, *look in MARKS:
        design = answer.values[key]
        if design is not None:
            made.append((design, REFINED if key == "refined" else design["number"], word, look))
    for blocked in sorted(answer.forbidden, key=lambda f: f["short"])[:1]:
        design, word = blocked["design"], f"but for {blocked['constraint']}"
        if all(math.isfinite(design[n]) for n in names):
            made.append((design, design["number"], word, ("bad", "triangle", 13)))
    return made


def _losing(answer: Answer, name: str) -> float:
    """1 where more of it is worse, -1 where less is: nothing is drawn on that side of the front."""
    goals = {o.name: o.least for o in answer.record.spec.objectives}
    return 1.0 if goals.get(name, True) else -1.0


def comparison(answer: Answer, number: int) -> str:
    """The design looked at, the chosen one, the refined one and the runner-up, row by row."""
    spec = answer.record.spec
    number, design = picked(answer, number)
    columns: dict[str, Row] = {"looked at": design, "chosen": answer.chosen}
    if answer.refined is not None:
        columns["between the steps"] = answer.refined
    if answer.runner_up is not None:
        columns["runner-up"] = answer.runner_up
    asked: dict[str, list[str]] = {}
    for c in spec.constraints:
        sign = "at most" if c.most else "at least"
        asked.setdefault(c.name, []).append(f"{sign} {show(c.limit, c.unit)}")
    for o in spec.objectives:
        asked.setdefault(o.name, []).append("least" if o.least else "most")
    rows = []
    for name in ("film", *VARIABLES, *(n for n in MERITS if n not in VARIABLES)):
        cells = [said(d.get(name), answer.units.get(name, "1")) for d in columns.values()]
        if set(cells) != {"–"}:
            rows.append((words(name), ", ".join(asked.get(name, [])), *cells))
    heads = ("", "asked for", *columns)
    return html(heads, rows, range(2, len(heads)), "Designs side by side")


def forbidden(answer: Answer) -> str:
    """What would have been better but for one constraint."""
    units = {str(c): c.unit for c in answer.record.spec.constraints}
    rows = [
        (f["constraint"], named(f["design"]), said(f["value"], units[f["constraint"]]),
         f"{f['short']:.1%}", f"{f['gain']:.1%}")
        for f in answer.forbidden
    ]  # fmt: skip
    if not rows:
        return "<p>No single constraint keeps a better design out.</p>"
    heads = ("Constraint", "keeps out", "which has", "missed by", "better by")
    return html(heads, rows, (2, 3, 4), "Designs that one constraint forbids")


def chances(answer: Answer) -> str:
    """How likely each constraint holds with the scatter in friction."""
    units = {str(c): c.unit for c in answer.record.spec.constraints}
    rows = [
        ("all of them" if name == "all" else name, f"{c['probability']:.1%}", f"{c['error']:.1%}",
         said(c["low"], units.get(name, "1")), said(c["high"], units.get(name, "1")))
        for name, c in answer.robustness.items()
    ]  # fmt: skip
    if not rows:
        return "<p>The brake states no scatter of its friction, so none is reckoned with.</p>"
    heads = ("Constraint", "holds", "give or take", "5 % below", "5 % above")
    return html(heads, rows, (1, 2, 3, 4), "Robustness of the chosen design")


def slopes(answer: Answer) -> str:
    """What one percent more of a number changes, in percent."""
    table = answer.sensitivities
    names = [n for n in dict.fromkeys(n for row in table.values() for n in row)
             if any(abs(row.get(n, 0.0)) > 0.005 for row in table.values())]  # fmt: skip
    rows = [
        (words(n), *(f"{row[n]:+.2f}" if n in row and abs(row[n]) > 0.005 else "–"
                     for row in table.values()))
        for n in names
    ]  # fmt: skip
    heads = ("1 % more of", *(f"{words(m)} [%]" for m in table))
    return html(heads, rows, range(1, len(heads)), "Sensitivities of the chosen design")


def verdict(answer: Answer) -> str:
    """The outcome in a few sentences."""
    if not answer.feasible:
        return refusal(answer)
    text = (f"{answer.feasible_designs:,} of {answer.designs:,} designs meet all constraints; "
            f"{answer.front_size:,} are on the front. Chosen: {named(answer.chosen)}.")  # fmt: skip
    if answer.runner_up is not None:
        text += f"\nRunner-up: {named(answer.runner_up)}; {answer.runner_up_lost}."
    if answer.binding:
        text += f"\nHeld by {', '.join(answer.binding)}."
    return text


def refusal(answer: Answer) -> str:
    """Which constraint kills a specification, and what could be had."""
    text = f"Not possible: {answer.reason}."
    if answer.excludes:
        text += f" At least one of {answer.killed_by}, {', '.join(answer.excludes)} must give."
    if not answer.examined:
        return f"{text} Shown by bounds, before any of the {answer.designs:,} designs was computed."
    return f"{text} All {answer.examined:,} designs were computed."


def along(answer: Answer) -> list[int]:
    """Numbers of the front in the order of the first wish."""
    first = answer.record.spec.objectives[0]
    rows = sorted(answer.front, key=lambda d: (first.sign * d[first.name], d["number"]))
    return [d["number"] for d in rows]


def file_name(spec: DesignSpecification) -> str:
    """What a file of this specification is called."""
    return plain_name(spec.name)
