"""Parts of a report for a signature: identity, apparatus, certificates, budget, signature lines.

They follow ASTM D1894, section 12, and ISO/IEC 17025, section 7.8. Missing statements are listed.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields

from layerjam.core.drawing.page import NONE, Part, Table, Word
from layerjam.core.errors import count_text
from layerjam.core.units import QuantitySpec, show
from layerjam.laboratory.figures.brake_numbers import Cell, Number
from layerjam.laboratory.identify.calibration.budget import Budget
from layerjam.laboratory.measure.certificate import Certificate
from layerjam.laboratory.measure.sidecar import Facts

NOT_STATED = "not stated"
LIMIT = 4
"""Largest number of different statements listed for one subject."""
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
    "normal_force_limit",
    "area",
    "area_limit",
    "procedure",
    "note",
)
"""Metadata of the sidecars, in the order in which a report states them."""
INSTRUMENTS = {
    "load_cell_certificate": "load cell",
    "gauge_certificate": "vacuum gauge",
    "normal_force_certificate": "normal force",
}
"""{key that contains certificates: its instrument}."""
REQUIRED = {
    "report number": "--report-number, or number in conditions.toml",
    "customer": "--customer, or customer in conditions.toml",
    "laboratory": "laboratory in conditions.toml",
    "tests done on": "date in conditions.toml",
}
"""{item that a report must state (ISO/IEC 17025, section 7.8.2.1): how to state it}."""
STATES = {
    "valid": "valid",
    "overdue": "overdue since {due}",
    "later": "calibrated after the tests",
    "no day": "unknown: no test date is stated",
    "no due day": "unknown: no due date is stated",
}
LINES = "Name and function", "Date", "Signature"
BLANK = "_" * 60
FileFacts = Sequence[tuple[str, Facts]]
"""Return (file, its metadata) of every file."""


def make_identity(facts: FileFacts, number: str, customer: str, date: str) -> dict[str, str]:
    """Return the identification of a report as {label: text}; missing texts are `NOT_STATED`.

    `number` and `customer` replace those of the sidecars if not empty; `date` is a date.
    """
    return {
        "report number": number or _join_statements(facts, "number"),
        "customer": customer or _join_statements(facts, "customer"),
        "laboratory": _join_statements(facts, "laboratory"),
        "tests done on": _join_statements(facts, "date"),
        "issued on": date,
    }


def make_apparatus(facts: FileFacts) -> Part:
    """Return the person, object and apparatus of the tests, one row each, and the certificates."""
    rows: list[list[str | Word]] = []
    for name in STATED:
        words = name.replace("_limit", ", error limit").replace("_", " ")
        rows.append([words, Word(_join_statements(facts, name), "stated")])
    return Part(
        id="circumstances",
        title="People, objects and apparatus",
        tables=[
            Table(id="circumstances", head=["", "as stated in the sidecars"], rows=rows),
            _make_certificate_table(facts),
        ],
    )


def _make_certificate_table(facts: FileFacts) -> Table:
    rows: list[list[Cell]] = []
    used_by = _group_facts(facts)
    for (instrument, certificate), used in used_by.items():
        days = [certificate.date, certificate.due or NOT_STATED, certificate.laboratory]
        state = STATES[_certificate_state(certificate, used)].format(due=certificate.due)
        rows.append([instrument, certificate.number, *days, state, _shorten([f for f, _ in used])])
    for instrument in INSTRUMENTS.values():
        if instrument not in {name for name, _ in used_by}:
            rows.append([instrument, *[NOT_STATED] * 4, "", ""])
    return Table(
        id="certificates",
        caption="Calibration certificates",
        head=[
            "instrument",
            "number",
            "date",
            "due",
            "laboratory",
            "status at the test date",
            "files",
        ],
        rows=rows,
    )


def _certificate_state(certificate: Certificate, facts: FileFacts) -> str:
    """Return the key in `STATES` for the validity of a certificate on the days of the tests."""
    days = [day for _, fact in facts for day in re.findall(r"\d{4}-\d\d-\d\d", fact.date)]
    if not days:
        return "no day"
    if min(days) < certificate.date:
        return "later"
    if certificate.due and max(days) > certificate.due:
        return "overdue"
    return "valid" if certificate.due else "no due day"


def list_certificate_problems(facts: FileFacts) -> list[str]:
    """Return a sentence for each certificate that was not valid on the days of the tests."""
    return [
        f"Calibration certificate {certificate.number} of the {instrument}: "
        f"{STATES[state].format(due=certificate.due)} ({_shorten([file for file, _ in files])})."
        for (instrument, certificate), files in _group_facts(facts).items()
        if (state := _certificate_state(certificate, files)) in ("later", "overdue")
    ]


def _group_facts(facts: FileFacts) -> dict[tuple[str, Certificate], list[tuple[str, Facts]]]:
    used: dict[tuple[str, Certificate], list[tuple[str, Facts]]] = {}
    for name, instrument in INSTRUMENTS.items():
        for file, fact in facts:
            if (certificate := getattr(fact, name)) is not None:
                used.setdefault((instrument, certificate), []).append((file, fact))
    return used


def _format_entry(facts: Facts, name: str) -> str:
    """Return one metadata entry as text; empty if it is not stated."""
    value = getattr(facts, name)
    if value is None or value == "":
        return ""
    spec = next(f.metadata.get("quantity") for f in fields(Facts) if f.name == name)
    if not isinstance(spec, QuantitySpec):
        return str(value)
    return f"{100 * value:.3g} %" if spec.unit == "1" else show(value, spec.unit).replace("^2", "²")


def _join_statements(facts: FileFacts, name: str) -> str:
    """Return the statement on one entry that all files share, or each statement with its files."""
    texts: dict[str, list[str]] = {}
    for file, fact in facts:
        texts.setdefault(_format_entry(fact, name), []).append(file)
    if len(texts) == 1:
        return next(iter(texts)) or NOT_STATED
    silent = texts.pop("", [])
    parts = [f"{text} ({_shorten(names)})" for text, names in list(texts.items())[:LIMIT]]
    tail = [f"and {len(texts) - LIMIT} others"] if len(texts) > LIMIT else []
    silent_note = [f"{NOT_STATED} for {count_text(len(silent), 'file')}"] if silent else []
    return "; ".join([*parts, *tail, *silent_note]) or NOT_STATED


def _shorten(names: Sequence[str]) -> str:
    """Return the first few names, and the number of those omitted."""
    return names[0] + (f" and {len(names) - 1} more" if len(names) > 1 else "")


def budget_table(budget: Budget, product: Budget | None = None) -> Table:
    """Return the uncertainty budget of the scale factor, with the combination of its lines.

    `product` is the budget of the scale factor times the friction, which starts with the same
    lines. The product has its own totals if the friction adds lines.
    """
    rows: list[list[Cell]] = []
    extra: list[Number] = []
    for line in budget.contributions:
        stem = f"uncertainty of the scale factor: {line.what}"
        rows.append(
            [
                line.what,
                line.basis,
                _make_percent_cell(f"{stem}, standard uncertainty", line.standard),
                Number(
                    quantity=f"{stem}, sensitivity",
                    value=line.sensitivity,
                    unit="1",
                    decimals=3,
                ),
                _make_percent_cell(f"{stem}, contribution", line.relative),
            ]
        )
    divided = product is not None and len(product.contributions) < len(budget.contributions)
    if product is not None and divided:
        first = f"first {len(product.contributions)} lines"
        _add_totals(rows, extra, product, "a × kinetic friction", first)
    _add_totals(rows, extra, budget, "the scale factor", "all lines")
    note = (
        "Each relative to the value. Error limits: rectangular distribution, divided by √3. k "
        "is Student's 95 % quantile for the effective degrees of freedom ν (GUM, annex G.4), or "
        "larger if the sum would otherwise be below the expanded uncertainty of a single line."
    )
    if not budget.is_complete:
        if budget.standard_uncertainty is not None:
            note += " Missing entries count as zero: the sum is a lower bound."
        note += f" For a complete budget, state: {'; '.join(budget.missing)}."
    return Table(
        id="budget",
        caption="Uncertainty budget of the scale factor",
        head=["source", "basis", "standard uncertainty", "sensitivity", "contribution"],
        rows=rows,
        total=4 if divided else 2,
        note=note,
        extra=extra,
    )


def _add_totals(
    rows: list[list[Cell]], extra: list[Number], budget: Budget, name: str, lines: str
) -> None:
    """Add the rows of a combined and an expanded uncertainty, and the numbers in their texts."""
    stem = f"uncertainty of {name}"
    degrees, factor = budget.degrees_of_freedom, budget.coverage_factor
    basis = f"root of the sum of squares, {lines}"
    combined_cell = _make_percent_cell(f"{stem}, combined", budget.standard_uncertainty)
    expanded_cell = _make_percent_cell(f"{stem}, expanded", budget.expanded_uncertainty)
    rows += [
        [f"{name}, combined", basis, NONE, NONE, combined_cell],
        [f"{name}, expanded", coverage_text(budget), NONE, NONE, expanded_cell],
    ]
    extra += [
        Number(quantity=f"{stem}, {words}", value=value, unit="1")
        for words, value in (("coverage factor k", factor), ("degrees of freedom", degrees))
        if value is not None and value < math.inf
    ]


def coverage_text(budget: Budget) -> str:
    """Return coverage factor and effective degrees of freedom as text."""
    degrees, factor = budget.degrees_of_freedom, budget.coverage_factor
    if factor is None or degrees is None:
        return NOT_STATED
    freedom = "∞" if degrees > 1e4 else f"{degrees:.1f}"
    return f"k = {factor:.2f}, ν = {freedom}"


def _make_percent_cell(quantity: str, value: float | None) -> Cell:
    if value is None:
        return NOT_STATED
    return Number(quantity=quantity, value=value, unit="1", shown_in="%", decimals=3)


def make_signature_part(items: Mapping[str, str]) -> Part:
    """Return scope and identity of the report, missing statements, and lines for a signature."""
    missing = [
        f"{words[0].upper()}{words[1:]}: {NOT_STATED}. ISO/IEC 17025, section 7.8.2.1, requires "
        f"it; state it with {hint}."
        for words, hint in REQUIRED.items()
        if NOT_STATED in items[words]
    ]
    rows = [[words, Word(text, "stated")] for words, text in items.items()]
    rows += [[line, Word(BLANK)] for line in LINES]
    return Part(
        id="signature",
        title="Signature",
        text=[
            "These results apply only to the specimens in the files named above. This report "
            "may only be copied in full.",
            *missing,
        ],
        tables=[Table(id="signature", head=["", ""], rows=rows, whole=True)],
    )
