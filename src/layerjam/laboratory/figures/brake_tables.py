"""Tables of a brake's report: friction, calibration, validation, and the files that were read."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from layerjam.core.drawing.page import NONE, Table
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.figures.brake_numbers import Cell, Column, Number, estimates_table
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.curves import crosshead_speed
from layerjam.laboratory.identify.friction.reduction import FrictionResult
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.identify.single_pulls import SinglePull
from layerjam.laboratory.identify.statistics import summarise_repeats
from layerjam.laboratory.identify.validation.metrics import (
    ConditionError,
    PooledErrors,
    Split,
    Validation,
)
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace

UNTOLD = "≈ 0"
"""Text for a model error that is not distinguishable from zero."""
KINDS = Column("static", "static", decimals=4), Column("kinetic", "kinetic", decimals=4)
CONDITION = Column("vacuum", "vacuum", "Pa", "kPa", 1), Column("speed", "speed", "m/s", "mm/s")
SINGLE = (
    Column("scale factor a", "factor", decimals=4),
    Column("stiffness k", "stiffness", "N/m", "kN/m", 1),
    Column("vacuum at the peak", "vacuum_of_peak", "Pa", "kPa", 1),
    Column("shape", "shape", "1", "%", 1),
    Column("seating", "seating", "1", "%", 1),
)
PEAK = Column("peak force", "peak_force", "N", "N", 2, error="peak_force_se")
FILE = Column("vacuum", "vacuum", "Pa"), Column("speed", "speed", "m/s")
MEASURES = (
    Column("MAPE", "mape", "1", "%", 2),
    Column("RMSE", "rmse", "N", "N", 2),
    Column("bias", "bias", "N", "N", 2),
    Column("R²", "r_squared", decimals=3),
)
SPLIT = (
    Column("model's own error, root mean square", "own", "N", "N", 2),
    Column("scatter between repeats, SD", "sd", "N", "N", 2),
    Column("fraction of the squared error due to scatter", "share", "1", "%", 0),
)
SQUARES = (
    Column("mean squared error", "mse", "N^2"),
    Column("part due to the model", "model_mse", "N^2"),
    Column("part due to scatter", "scatter_mse", "N^2"),
)
OVER_CONDITIONS = (
    (Column("MAPE, SD between pulls", "mape_sd"), "curves"),
    (Column("mean of the conditions' MAPE", "mape_conditions"), "conditions"),
    (Column("SD of the conditions' MAPE", "mape_conditions_sd"), "conditions"),
)
"""(column, field whose items are averaged)."""


@dataclass(frozen=True, kw_only=True)
class FileUsed:
    """A measurement and its use; `role` is friction, calibration or validation."""

    name: str
    role: str
    sha256: str
    format: str
    vacuum: float | None
    speed: float | None
    repeat: int | None
    synthetic: bool
    understood: Sequence[str] = ()
    facts: Facts = field(default_factory=Facts)


def make_file_entry(trace: Trace, role: str) -> FileUsed:
    """Return a measurement with its digest and its use."""
    facts = trace.facts
    return FileUsed(
        name=Path(trace.path).name,
        role=role,
        sha256=sha256(trace.path),
        format=trace.format,
        vacuum=facts.vacuum,
        speed=facts.speed if role == "friction" else crosshead_speed(trace),
        repeat=facts.repeat,
        synthetic=facts.synthetic,
        understood=trace.understood,
        facts=facts,
    )


def friction_table(result: FrictionResult) -> Table:
    """Return the table of friction coefficients, for each repeat and pooled."""
    count, rows = len(result.repeats), list[list[Cell]]()
    for index, repeat in enumerate(result.repeats, 1):
        name, repeat_name = Path(repeat.path).name, f"repeat {index}"
        numbers = [c.number(repeat, "friction", repeat_name, n=1, source=name) for c in KINDS]
        rows.append([str(index), *numbers, name])
    means, spread = [], []
    base: dict[str, Any] = {"n": count, "source": count_text(count, "repeat")}
    for column in KINDS:
        values = [v for r in result.repeats if (v := getattr(r, column.path)) is not None]
        span = summarise_repeats(values or [math.nan])
        error_cells = {"standard_error": span.standard_error, "low": span.low, "high": span.high}
        scatter = column._replace(path=f"{column.path}_sd")
        means.append(column.number(result, "friction", "mean", **base, **error_cells))
        spread.append(scatter.number(result, "friction", "standard deviation", **base))
    rows += [
        ["mean", *means, f"of {count_text(count, 'repeat')}"],
        ["SD", *spread, "between repeats"],
        ["95 %", *(number.interval_text() for number in means), "interval of the mean"],
    ]
    start, end = (show(w, "m") for w in result.window)
    first = "the first maximum" if result.standard.first_maximum else "the maximum force"
    window = zip(("from", "to"), result.window, strict=True)
    return Table(
        id="friction",
        caption="Friction coefficients",
        head=["repeat", "static", "kinetic", "file"],
        rows=rows,
        total=3,
        note=f"Evaluated according to {result.standard.title}. Static: {first}; kinetic: mean over "
        f"slips of {start} to {end}; both divided by the normal force, "
        f"{show(result.normal_force, 'N')}. The interval is Student's t interval of the repeats.",
        extra=[
            Column("normal force", "normal_force", "N").number(result, "friction"),
            *(Number(quantity=f"friction: window {edge}", value=w, unit="m") for edge, w in window),
        ],
    )


LABELS = {
    "scale_factor": ("scale factor a", "1"),
    "stiffness": ("stiffness k of brake and rig", "N/m"),
    "product": ("a × kinetic friction", "1"),
    "enclosure_factor": ("factor on the enclosure's force", "1"),
    "pressure_exponent": ("pressure exponent", "1"),
    "speed_slope": ("ln(friction) per decade of speed", "1"),
    "peak_force": ("peak force", "N"),
    "peak_elongation": ("elongation at the peak", "m"),
    "scale_factor_eq8": ("scale factor by the paper's eq. 8", "1"),
    "stiffness_eq9": ("stiffness by the paper's eq. 9", "N/m"),
}
_METHODS = {
    "scale_factor_eq8": "as printed, with crosshead travel instead of slip",
    "stiffness_eq9": "as printed: ratio of peak force to peak displacement",
}


def calibration_table(result: Calibration, kinetic: float) -> Table:
    """Return the table of the fitted values with their uncertainties."""
    count = len(result.curves)
    plainly = "mean of the pulls" if count > 1 else "the pull"
    numbers = []
    for key, (words, unit) in LABELS.items():
        like, factor = ("scale_factor", kinetic) if key == "product" else (key, 1.0)
        value = result.values.get(like, getattr(result, like, None))
        if value is None:
            continue
        error, interval = result.standard_errors.get(like), result.intervals.get(like)
        low, high = (interval.low * factor, interval.high * factor) if interval else (None, None)
        numbers.append(
            Number(
                quantity=f"calibration: {words}",
                value=value * factor,
                unit=unit,
                standard_error=None if error is None else error * factor,
                low=low,
                high=high,
                n=count,
                source=_METHODS.get(key, plainly) if error is None else result.errors_rest_on,
            )
        )
    note, changes = _describe_leave_one_out(result)
    caption = "Fitted quantities"
    return estimates_table(numbers, id="calibration", caption=caption, note=note, extra=changes)


def _describe_leave_one_out(result: Calibration) -> tuple[str, list[Number]]:
    """Return (sentence, numbers): changes of a and k without the most influential pull."""
    phrases, numbers = [], []
    for key, shown_in, decimals in (("scale_factor", "", 4), ("stiffness", "kN/m", 2)):
        shifts = (result.leave_one_out or {}).get(key)
        if shifts is None or shifts.most_influential is None:
            continue
        words, unit = LABELS[key]
        name = shifts.most_influential
        number = Number(
            quantity=f"calibration: change of {words} without its most influential pull",
            value=shifts.files[name],
            unit=unit,
            source=name,
            shown_in=shown_in,
            decimals=decimals,
        )
        numbers.append(number)
        phrases.append(f"{words} by {'+' * (shifts.files[name] >= 0)}{number.text()} ({name})")
    note = f"Change without the most influential pull: {'; '.join(phrases)}." if phrases else ""
    return note, numbers


class _Row(NamedTuple):
    """One pull of a stage: its cells, and standard errors {path in SinglePull: value}."""

    pull: SinglePull
    cells: Sequence[Cell]
    errors: Mapping[str, float | None] = MappingProxyType({})
    note: str = ""


def calibration_pulls_table(result: Calibration) -> Table:
    """Return one row for each pull used for calibration."""
    fits = iter(result.fits)
    rows = []
    for pull in result.pulls:
        if pull.factor is None:
            rows.append(_Row(pull, [NONE]))
            continue
        fit = next(fits)
        peak = PEAK.number(fit.pull, "calibration pull", n=1, source=pull.file)
        errors = {"factor": fit.scale_factor_se, "stiffness": fit.pull.stiffness_se}
        rows.append(_Row(pull, [peak], errors))
    note = "Numbers refer to the figure of the scale factors. " * bool(result.fits)
    return _pulls_table("calibration", rows, [PEAK], note)


def validation_pulls_table(result: Validation, before: Validation | None) -> Table:
    """Return one row for each pull used for validation."""
    columns = [*MEASURES[:3], MEASURES[3]._replace(decimals=4)]
    rows = []
    for index, (pull, curve) in enumerate(zip(result.pulls, result.curves, strict=True)):
        base: dict[str, Any] = {"n": curve.points, "source": pull.file}
        cells: list[Cell] = [column.number(curve, "validation pull", **base) for column in columns]
        if before is not None:
            earlier = before.curves[index]
            base["n"] = earlier.points
            cells.insert(
                0, columns[0].number(earlier, "validation pull", "before calibration", **base)
            )
        rows.append(_Row(pull, cells, note=curve.note))
    if before is not None:
        columns.insert(0, columns[0]._replace(words="MAPE before"))
    return _pulls_table("validation", rows, columns)


def _pulls_table(
    stage: str, pulls: Sequence[_Row], columns: Sequence[Column], note: str = ""
) -> Table:
    """Return the table of a stage's pulls: conditions, stage columns, fit of each pull, verdict."""
    rows: list[list[Cell]] = []
    for number, (pull, cells, errors, remark) in enumerate(pulls, 1):
        stem = f"{stage} pull"
        base: dict[str, Any] = {"n": 1, "source": pull.file}
        test = [column.number(pull, stem, **base) for column in CONDITION]
        numbers = [c.number(pull, stem, **base, standard_error=errors.get(c.path)) for c in SINGLE]
        words = "; ".join(filter(None, [_describe_verdict(pull), remark]))
        rows.append([str(number), pull.file, *test, *cells, *numbers, words])
    return Table(
        id=f"{stage}-pulls",
        caption="Individual pulls",
        head=["no.", "file", *map(_table_header, (*CONDITION, *columns, *SINGLE)), "verdict"],
        groups=[
            ("", 2 + len(CONDITION)),
            (stage, len(columns)),
            ("individual pull", len(SINGLE)),
            ("", 1),
        ],
        rows=rows,
        unit_in_head=True,
        note=note + OF_PULLS,
    )


OF_PULLS = (
    "Scale factor a: from the peak. Vacuum at the peak: vacuum at which the pull would "
    "have the scale factor of the others. Shape: difference between the scale factors after and "
    "at the peak. Seating: increase in slope in the upper half of the rise. The verdict names "
    "the columns in which a pull differs from the others, with at most 5 % false alarms for all "
    "pulls and tests together."
)


def _table_header(column: Column) -> str:
    return f"{column.words} [{column.shown_in}]" if column.shown_in else column.words


def _describe_verdict(pull: SinglePull) -> str:
    """Return `ok`, the tests in which the pull differs, or a note that there are too few pulls."""
    outlier_tests = [test for test, verdict in pull.verdicts.items() if verdict == "odd"]
    return ", ".join(outlier_tests) or ("ok" if "ok" in pull.verdicts.values() else "too few pulls")


def _pair_errors(after: Any, before: Any) -> list[tuple[str, Any]]:
    """Return the errors before calibration, if known, then those of the calibrated brake."""
    states = ("before calibration", before), ("calibrated", after)
    return [(state, value) for state, value in states if value is not None]


def _make_error_cells(stem: str, after: PooledErrors, before: PooledErrors | None) -> list[Cell]:
    """Return MAPE, RMSE, bias and R^2 before and after calibration, for one condition or all."""
    cells: list[Cell] = []
    for column in MEASURES:
        for state, errors in _pair_errors(after, before):
            error_cells = {}
            if column.path == "mape" and isinstance(errors, ConditionError):
                spread = summarise_repeats([c.mape for c in errors.curves])
                error_cells = {"low": spread.low, "high": spread.high}
            cells.append(column.number(errors, stem, state, n=errors.repeats, **error_cells))
    return cells


def _make_split_cells(stem: str, split: Split | None) -> tuple[list[Cell], list[Number]]:
    """Return (cells, numbers not in a cell): the model's own error, the scatter, its fraction."""
    if split is None:
        return [NONE] * 3, []
    base: dict[str, Any] = {"n": split.repeats, "source": "split over the repeats"}
    error, scatter, share = (column.number(split, stem, **base) for column in SPLIT)
    cells: list[Cell] = [error if error.value else UNTOLD, scatter, share if split.share else NONE]
    return cells, [column.number(split, stem, **base) for column in SQUARES]


def describe_condition(condition: ConditionError) -> str:
    """Return a condition as text, such as "80.6 kPa, 7 mm/s"."""
    speed = "speed unknown" if condition.speed is None else show(condition.speed, "m/s", 3)
    return f"{show(condition.vacuum, 'Pa')}, {speed}"


def validation_table(result: Validation, before: Validation | None) -> Table:
    """Return the table of errors before and after calibration, by condition and for all."""
    rows: list[list[Cell]] = []
    extra: list[Number] = []

    def add_row(
        first: Sequence[Cell], stem: str, case: PooledErrors, earlier: PooledErrors | None
    ) -> None:
        split, hidden = _make_split_cells(stem, case.scatter)
        pulls = Column("pulls", "repeats", decimals=0).number(case, stem)
        rows.append([*first, pulls, *_make_error_cells(stem, case, earlier), *split])
        extra.extend(hidden)

    for index, case in enumerate(result.conditions):
        stem = f"validation, {describe_condition(case)}"
        earlier = before.conditions[index] if before is not None else None
        add_row([column.number(case, stem) for column in CONDITION], stem, case, earlier)
    add_row(["all", ""], "validation, all", result, before)
    names = ["MAPE [%]", "RMSE [N]", "bias [N]", "R²"]
    head, groups = names, [("", 3), ("brake as specified", 4)]
    if before is not None:
        head, groups = ["before", "after"] * 4, [("", 3), *((name, 2) for name in names)]
    split = ["own [N]", "scatter [N]", "share [%]"]
    for state, errors in _pair_errors(result, before):
        for column, count in OVER_CONDITIONS:
            number = column.number(errors, "validation, all", state, n=len(getattr(errors, count)))
            extra.append(number)
    return Table(
        id="validation",
        caption="Validation by condition",
        head=["vacuum [kPa]", "speed [mm/s]", "pulls", *head, *split],
        groups=[*groups, ("split of the squared error", 3)],
        rows=rows,
        total=1,
        unit_in_head=True,
        note=_make_note(result, before),
        extra=extra,
    )


def _make_note(result: Validation, before: Validation | None) -> str:
    def format_mape(v: Validation) -> str:
        text = f"{v.mape_conditions:.1%}"
        return text + (f" ± {v.mape_conditions_sd:.1%}" if v.mape_conditions_sd else "")

    text = f"MAPE of {count_text(len(result.conditions), 'condition')}, mean ± SD: "
    text += format_mape(result)
    if before is not None:
        text += f" (before calibration {format_mape(before)})"
    text += (
        ". Before: scale factor 1 and the stiffness of eq. 1. Bias: model minus measured. Own: "
        "error of the calibrated model against the mean of the repeats. Scatter: the repeats' SD "
        "at one elongation. Both are root mean squares. Share: fraction of the mean squared error "
        "due to scatter, which no model can remove."
    )
    if any(c.scatter is not None and c.scatter.model_mse <= 0 for c in result.conditions):
        text += (
            f" {UNTOLD}: the model's error cannot be distinguished from zero. The estimate of its "
            "square is negative and the share above 100 %."
        )
    return text


def files_table(files: Sequence[FileUsed]) -> Table:
    """Return the table of the files that were read, with their digests."""
    rows: list[list[Cell]] = []
    for file in files:
        numbers = (column.number(file, f"file {file.name}") for column in FILE)
        rows.append([file.name, file.role, file.format, *numbers, file.sha256])
    head = ["file", "used for", "format", "vacuum", "speed", "SHA-256"]
    return Table(id="files", caption="Files", head=head, rows=rows)
