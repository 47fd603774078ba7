"""What a report that one can sign adds: circumstances, uncertainty budget, a place to sign.

After ASTM D1894, section 12, and ISO/IEC 17025, section 7.8; what nobody stated says so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields

from layerjam.identify.calibration.budget import Budget
from layerjam.measure.sidecar import Facts
from layerjam.report.brake_numbers import Cell, Number
from layerjam.report.page import NONE, Part, Table
from layerjam.units import QuantitySpec, show

NOT_STATED = "not stated"
MOST = 4
"""Different statements of one thing that are spelled out."""
STATED = (
    "number",
    "date",
    "laboratory",
    "operator",
    "film_maker",
    "film_lot",
    "film_direction",
    "conditioning",
    "climate",
    "machine",
    "apparatus",
    "load_cell",
    "load_cell_limit",
    "gauge",
    "gauge_limit",
    "procedure",
    "note",
)
"""Facts of the sidecars, in the order a report states them."""
LINES = "Name and function", "Date", "Signature"
BLANK = "_" * 60


def circumstances(facts: Sequence[tuple[str, Facts]]) -> Part:
    """Who tested what with which apparatus, of every (file, facts); one row for each thing."""
    rows: list[list[Cell]] = []
    for name in STATED:
        words = name.replace("_limit", ", limit of error").replace("_", " ")
        rows.append([words, _said([(file, _text(one, name)) for file, one in facts])])
    return Part(
        id="circumstances",
        title="Who, what and with which apparatus",
        tables=[Table(id="circumstances", head=["", "as the sidecars state it"], rows=rows)],
    )


def _text(facts: Facts, name: str) -> str:
    """One fact as a reader reads it; empty where nobody stated it."""
    value = getattr(facts, name)
    if value is None or value == "":
        return ""
    spec = next(f.metadata.get("quantity") for f in fields(Facts) if f.name == name)
    if not isinstance(spec, QuantitySpec):
        return str(value)
    return f"{value:.3g} of the reading" if spec.unit == "1" else show(value, spec.unit)


def _said(texts: Sequence[tuple[str, str]]) -> str:
    """What all files state of one thing, or which states what."""
    by: dict[str, list[str]] = {}
    for file, text in texts:
        by.setdefault(text, []).append(file)
    if len(by) == 1:
        return next(iter(by)) or NOT_STATED
    silent = by.pop("", [])
    parts = [
        f"{text} ({names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''})"
        for text, names in list(by.items())[:MOST]
    ]
    more = [f"and {len(by) - MOST} others"] if len(by) > MOST else []
    count = f"{len(silent)} file{'s' * (len(silent) > 1)}"
    rest = [f"{NOT_STATED} of {count}"] if silent else []
    return "; ".join([*parts, *more, *rest])


def budget_table(found: Budget) -> Table:
    """The uncertainty budget of the scale factor, and what its stated lines make together."""
    rows: list[list[Cell]] = []
    for line in found.contributions:
        stem = f"uncertainty of the scale factor: {line.what}"
        rows.append(
            [
                line.what,
                line.basis,
                _percent(f"{stem}, standard uncertainty", line.standard),
                Number(
                    quantity=f"{stem}, sensitivity",
                    value=line.sensitivity,
                    unit="1",
                    decimals=3,
                ),
                _percent(f"{stem}, contribution", line.relative),
            ]
        )
    stem = "uncertainty of the scale factor"
    degrees, factor = found.degrees_of_freedom, found.coverage_factor
    known = "" if degrees is None else f"{_degrees(degrees)} degrees of freedom"
    basis = "root of the sum of squares" + (known and f", {known}")
    student = NOT_STATED if factor is None else f"k = {factor:.2f} for 95 %"
    rows += [
        ["combined", basis, NONE, NONE, _percent(f"{stem}, combined", found.combined)],
        ["expanded", student, NONE, NONE, _percent(f"{stem}, expanded", found.expanded)],
    ]
    note = (
        "Each over the value. Limits of error count as rectangular, over the root of three. k is "
        "Student's quantile for the effective degrees of freedom (GUM, annex G.4)."
    )
    if not found.whole:
        if found.combined is not None:
            note += " What is not stated adds nothing: the sum is a lower bound."
        note += f" State for a whole budget: {'; '.join(found.missing)}."
    return Table(
        id="budget",
        caption="Uncertainty budget of the scale factor",
        head=["source", "basis", "standard uncertainty", "sensitivity", "contribution"],
        rows=rows,
        total=2,
        note=note,
        extra=[
            Number(quantity=f"{stem}, {words}", value=value, unit="1")
            for words, value in (("coverage factor k", factor), ("degrees of freedom", degrees))
            if value is not None and value < math.inf
        ],
    )


def _degrees(degrees: float) -> str:
    return "infinitely many" if degrees > 1e4 else f"{degrees:.3g}"


def _percent(quantity: str, value: float | None) -> Cell:
    if value is None:
        return NOT_STATED
    return Number(quantity=quantity, value=value, unit="1", shown_in="%", decimals=3)


def place_to_sign() -> Part:
    """What the report is about, and lines for a name, a date and a signature."""
    return Part(
        id="signature",
        title="Signed",
        text=[
            "These results concern the specimens in the files named above, and no others. This "
            "report may be copied as a whole only.",
        ],
        tables=[
            Table(id="signature", head=["by hand", ""], rows=[[line, BLANK] for line in LINES])
        ],
    )
