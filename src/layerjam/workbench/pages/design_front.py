"""The result of a design search as a clickable chart and tables; nothing is computed here."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from layerjam.core.drawing.chart import Pane
from layerjam.core.drawing.style import GREY
from layerjam.core.units import show
from layerjam.workbench.certainty import interval_meaning, interval_text
from layerjam.workbench.charts import chart_options, text_colour
from layerjam.workbench.pages.design_part import cell_text, key_name
from layerjam.workbench.spoken import typeset_text
from layerjam.workbench.tables import html_table
from layerjam.workbench.widgets import Hero
from layerjam.workshop.design.merit import MERITS, VARIABLES
from layerjam.workshop.design.verdict import describe_design
from layerjam.workshop.figures.design_figures import (
    Look,
    choose_scale,
    marked_designs,
    worse_direction,
)

PALE = "#9aa5af"
"""Grey that is visible on a dark background."""
Row = Mapping[str, Any]
CHOSEN, REFINED = -2, -1
"""Keys of the chosen design, and of the refined design between grid steps."""


def all_designs(result: Any) -> dict[int, Row]:
    """Return {index: design} of the result; the front comes first, sorted by first objective."""
    first = result.record.spec.objectives[0]
    rows: list[Row] = sorted(result.front, key=lambda d: first.sign * d[first.name])
    named_designs = [result.chosen, result.runner_up, *(f["design"] for f in result.forbidden)]
    rows_by_number = {d["number"]: d for d in (*rows, *named_designs) if d is not None}
    return rows_by_number if result.refined is None else {**rows_by_number, REFINED: result.refined}


def front_indices(result: Any) -> list[int]:
    """Return the indices of the designs on the front, in order of the first objective."""
    return list(all_designs(result))[: len(result.front)]


def pick_design(result: Any, selection: int) -> tuple[int, Row]:
    """Return (index, design) of the selected design, or of the chosen one if it is missing."""
    rows = all_designs(result)
    number = selection if selection in rows else result.chosen["number"]
    return number, rows[number]


def find_axes(result: Any) -> dict[str, str]:
    """Return {quantity: name} for the axes: the quantities that differ along the front."""
    out = {}
    for name in (*MERITS, *VARIABLES):
        values = {d.get(name) for d in result.front}
        if len(values) > 1 and all(isinstance(v, int | float) and math.isfinite(v) for v in values):
            out[name] = key_name(name)
    return out


def front_chart(result: Any, names: tuple[str, str], number: int, dark: bool) -> dict[str, Any]:
    """Return the chart of the designs on the front; value[2] of a point is the design's index."""
    scales = [choose_scale(result, n) for n in names]
    ink = text_colour(dark)
    x, y = (f"{key_name(n)} [{unit}]" for n, (_, unit) in zip(names, scales, strict=True))

    def point(design: Row, word: str = "") -> dict[str, Any]:
        place = [float(f"{design[n] * f:.6g}") for n, (f, _) in zip(names, scales, strict=True)]
        value = [*place, design.get("number", REFINED)]
        return {"value": value, "name": f"{word}{': ' if word else ''}{describe_design(design)}"}

    points = [point(d) for d in result.front]
    look = dict(color=PALE if dark else GREY, symbolSize=8, z=2)
    series = [scatter("on the front", points, **look)]
    aside, down = (worse_direction(result, n) for n in names)
    # the uppermost mark gets the uppermost label, so that the lines do not cross
    marks = sorted(marked_designs(result, names), key=lambda m: down * m[0][names[1]])
    for rank, (design, word, mark) in enumerate(marks):
        shift = (34 * aside, -down * (16 + 19 * rank))
        label = key_name(word)
        series.append(
            scatter(label, [point(design, label)], **_marker_style(mark, label, ink, shift))
        )
    ring = dict(color="transparent", borderColor=ink, borderWidth=2.2)
    ring_look = dict(silent=True, symbol="circle", symbolSize=26, z=5, itemStyle=ring)
    looked_at = point(pick_design(result, number)[1])["value"]
    series.append(scatter("selected", [looked_at], **ring_look))
    chart = points_chart(series, x=x, y=y, dark=dark, right=190)
    for axis in ("xAxis", "yAxis"):
        chart[axis][0] |= {"scale": True}
    return chart


def points_chart(
    series: Sequence[dict[str, Any]], *, right: int, dark: bool, **axes: Any
) -> dict[str, Any]:
    """Return a chart of named points."""
    chart = chart_options([Pane([], **axes, x_range=(None, None), y_range=(None, None))], dark)
    chart["grid"][0] |= {"right": right, "left": 70, "top": 44}
    chart["tooltip"] = {"trigger": "item", "confine": True, "formatter": "{b}"}
    return {**chart, "series": list(series)}


def scatter(name: str, data: Sequence[Any], **look: Any) -> dict[str, Any]:
    """Return a series of points."""
    return dict(type="scatter", name=name, data=list(data), **look)


def _marker_style(mark: Look, word: str, ink: str, shift: tuple[float, float]) -> dict[str, Any]:
    """Return the style of a mark whose label is next to it, connected by a line."""
    side = "right" if shift[0] > 0 else "left"
    return {
        **dict(symbol=mark.symbol, symbolSize=mark.symbol_size, color=mark.color, z=4),
        "itemStyle": dict(borderColor="#fff", borderWidth=1, opacity=1),
        "label": dict(show=True, formatter=word, color=ink, fontSize=12, position=side),
        "labelLine": {"show": True, "lineStyle": {"color": mark.color}},
        "labelLayout": {"dx": shift[0], "dy": shift[1]},
    }


def headlines(result: Any, design: Row) -> list[Hero]:
    """Return the headline numbers of a design: mass, the force that is required, and energy."""
    rules = [c.name for c in result.record.spec.constraints]
    force = "max_force" if "max_force" in rules else "holding_force"
    if result.record.spec.evaluation.stop is not None:
        force = "stop_peak"
    mass = "drawn_mass" if design.get("drawn_mass") is not None else "mass"
    source, numbers = find_predicted(result, design), []
    for name in (mass, force, "energy_capacity"):
        value, unit = design[name], result.units.get(name, "1")
        interval = interval_text(source, name, unit, value), interval_meaning(source, name)
        title = key_name(name).capitalize()
        numbers.append(Hero(name, title, cell_text(value, unit), *interval))
    return numbers


def find_predicted(result: Any, design: Row) -> Any:
    """Return the result if its intervals are those of the design: the chosen one; else None."""
    return result if design == result.chosen else None


def forces_text(result: Any, design: Row, pull: tuple[float, float] | None) -> str:
    """Return sentences that explain a design's forces, and report a mass that is too high."""
    vacuum = f"at {show(design['vacuum'], 'Pa', 3)}"
    holding, peak = (show(design[name], "N", 3) for name in ("holding_force", "max_force"))
    end = "" if pull is None else f", falling to {show(pull[1], 'N', 3)} at the end of its travel"
    text = f"Holds {holding} at rest; when pulled, it resists up to {peak}{end}, all {vacuum}."
    for limit in result.record.spec.constraints:
        drawn = design.get("drawn_mass")
        if limit.name in ("mass", "drawn_mass") and limit.most and drawn and drawn > limit.limit:
            mass, bound = show(drawn, "kg", 3), show(limit.limit, "kg")
            text += f" As drawn, it weighs {mass}, which exceeds {bound}."
    return text


def comparison_table(result: Any, number: int, is_main: bool = True) -> str:
    """Return a table of the selected, chosen, refined and runner-up designs, by quantity.

    The main rows contain the required quantities and the dimensions that differ.
    """
    spec = result.record.spec
    marks = {"chosen": result.chosen, "between grid steps": result.refined}
    marks = {"selected": pick_design(result, number)[1], **marks, "runner-up": result.runner_up}
    columns = {word: design for word, design in marks.items() if design is not None}
    limits: dict[str, list[str]] = {}
    for c in spec.constraints:
        sign = "at most" if c.most else "at least"
        limits.setdefault(c.name, []).append(f"{sign} {show(c.limit, c.unit)}")
    for o in spec.objectives:
        limits.setdefault(o.name, []).append("lowest" if o.least else "highest")
    rows = []
    names = dict.fromkeys(("mass", "drawn_mass", *limits, "film", *VARIABLES, *MERITS))
    for name in names:
        cells = [cell_text(d.get(name), result.units.get(name, "1")) for d in columns.values()]
        is_requested = name in limits or name in ("mass", "drawn_mass")
        differs = len(set(cells)) > 1 and (name == "film" or name in VARIABLES)
        if set(cells) == {"–"} or is_main != (is_requested or differs):
            continue
        if name == "drawn_mass":
            bounds = [c.limit for c in spec.constraints if c.name in ("mass", name) and c.most]
            masses = [d.get(name) or 0.0 for d in columns.values()]
            pairs = zip(cells, masses, strict=True)
            cells = [f"{c}, too heavy" if min(bounds, default=m) < m else c for c, m in pairs]
        rows.append((key_name(name), ", ".join(limits.get(name, [])), *cells))
    empty_text = "" if is_main else "All rows are shown above."
    return _format_table("Comparison of designs", ("", "required", *columns), rows, 2, empty_text)


def exclusion_table(result: Any) -> str:
    """Return a table of better designs, each excluded by a single constraint."""
    units = _constraint_units(result)
    rows = [
        (
            f["constraint"],
            describe_design(f["design"]),
            cell_text(f["value"], units.get(f["constraint"], "1")),
            f"{f['short']:.1%}",
            f"{f['gain']:.1%}",
        )
        for f in result.forbidden
    ]
    heads = ("Constraint", "Excluded design", "Its value", "Violated by", "Better by")
    empty_text = "No single constraint excludes a better design."
    return _format_table("Designs excluded by one constraint", heads, rows, 2, empty_text)


def probability_table(result: Any) -> str:
    """Return a table of the probability that the next brake meets each constraint."""
    units = _constraint_units(result)
    rows = []
    for name, c in result.robustness.items():
        shares = (f"{c['probability']:.1%}", f"{c['error']:.1%}")
        span = (cell_text(c[end], units.get(name, "1")) for end in ("low", "high"))
        rows.append(("all constraints" if name == "all" else name, *shares, *span))
    heads = ("Constraint", "Probability", "±", "5th percentile", "95th percentile")
    empty_text = "The specification has no constraints."
    return _format_table("Robustness of the selected design", heads, rows, 1, empty_text)


def sensitivity_table(result: Any) -> str:
    """Return a table of the change [%] of each result per 1 % increase in each number."""
    table = result.sensitivities
    rows = []
    for n in dict.fromkeys(n for row in table.values() for n in row):
        changes = [row.get(n, 0.0) for row in table.values()]
        if any(abs(c) > 0.005 for c in changes):
            rows.append((key_name(n), *(f"{c:+.2f}" if abs(c) > 0.005 else "–" for c in changes)))
    heads = ("1 % increase in", *(f"{key_name(m)} [%]" for m in table))
    return _format_table("Sensitivities of the selected design", heads, rows, 1)


def _constraint_units(result: Any) -> dict[str, str]:
    return {str(c): c.unit for c in result.record.spec.constraints}


def _format_table(
    caption: str, heads: Sequence[str], rows: Sequence[Iterable[str]], words: int, none: str = ""
) -> str:
    """Return a table whose first `words` columns are text, or `none` if it has no rows."""
    if none and not rows:
        return f"<p>{none}</p>"
    cells = [tuple(map(typeset_text, row)) for row in rows]
    return html_table(heads, cells, range(words, len(heads)), caption)


def outcome_text(result: Any) -> str:
    """Return the outcome of the search in a few sentences."""
    if not result.feasible:
        return refusal_text(result)
    are = "is" if result.front_size == 1 else "are"
    text = (
        f"{result.feasible_designs:,} of {result.designs:,} designs meet all constraints; "
        f"{result.front_size:,} {are} on the front. Chosen: {describe_design(result.chosen)}."
    )
    if result.runner_up is not None:
        text += f"\nRunner-up: {describe_design(result.runner_up)}; {result.runner_up_lost}."
    if result.binding:
        text += f"\nLimited by {', '.join(result.binding)}."
    return text


def refusal_text(result: Any) -> str:
    """Return sentences about the constraint that excludes all designs."""
    text = f"Not possible: {result.reason}."
    if result.excludes:
        text += (
            f" At least one of {result.killed_by}, {', '.join(result.excludes)} must be relaxed."
        )
    if not result.examined:
        return (
            f"{text} Bounds show this; none of the {result.designs:,} designs had to be computed."
        )
    return f"{text} All {result.examined:,} designs were computed."
