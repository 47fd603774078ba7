"""The tables of a brake's report: friction, calibration, validation, and what was read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from layerjam.identify.calibration.peaks import PullFit
from layerjam.identify.checks import Check
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.repeats import over_repeats
from layerjam.identify.validation.metrics import ConditionError, CurveError, Split, Validation
from layerjam.report.brake_numbers import NONE, Cell, Number, Table, estimates
from layerjam.units import show

FEW = 6
"""Pulls that the printed pages list one by one."""
UNTOLD = "≈ 0"
"""Shown for a model's error that cannot be told from none."""


@dataclass(frozen=True, kw_only=True)
class FileUsed:
    """A measurement and what it served for; `role` is friction, calibration or validation."""

    name: str
    role: str
    sha256: str
    format: str
    vacuum: float | None
    speed: float | None
    repeat: int | None
    synthetic: bool
    understood: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """A calibration of any depth as the report shows it.

    `values` are those of the verb's answer; `fits` what each pull says alone, without those that
    only a fit of whole curves can use; `count` is how many pulls were calibrated on.
    """

    values: Mapping[str, Any]
    fits: Sequence[PullFit]
    checks: Sequence[Check]
    count: int


def friction_table(result: FrictionResult) -> Table:
    """Per repeat, and pooled."""
    rows: list[list[Cell]] = []
    for index, repeat in enumerate(result.repeats, 1):
        name = Path(repeat.path).name
        rows.append(
            [
                str(index),
                *(
                    Number(
                        quantity=f"friction: {kind}, repeat {index}", value=getattr(repeat, kind),
                        unit="1", n=1, source=name, decimals=4,
                    )
                    for kind in ("static", "kinetic")
                ),
                name,
            ]
        )  # fmt: skip
    pooled, count = {}, len(result.repeats)
    for kind in ("static", "kinetic"):
        known = [v for r in result.repeats if (v := getattr(r, kind)) is not None]
        found = over_repeats(known or [math.nan])
        pooled[kind] = Number(
            quantity=f"friction: {kind}, mean", value=getattr(result, kind), unit="1",
            standard_error=found.standard_error, low=found.low, high=found.high, n=count,
            source=f"{count} repeats", decimals=4,
        )  # fmt: skip
    spread = {
        kind: Number(
            quantity=f"friction: {kind}, standard deviation", unit="1", n=count, decimals=4,
            value=getattr(result, f"{kind}_sd"), source=f"{count} repeats",
        )
        for kind in pooled
    }  # fmt: skip
    both = list(pooled)
    rows += [
        ["mean", *(pooled[k] for k in both), f"of {count} repeats"],
        ["SD", *(spread[k] for k in both), "between repeats"],
        ["95 %", *(pooled[k].interval_text() for k in both), "interval of the mean"],
    ]
    settings = [
        Number(quantity="friction: normal force", value=result.normal_force, unit="N"),
        Number(quantity="friction: window from", value=result.window[0], unit="m"),
        Number(quantity="friction: window to", value=result.window[1], unit="m"),
    ]
    start, end = (show(w, "m") for w in result.window)
    first = "the first maximum" if result.standard.first_maximum else "the greatest force"
    return Table(
        id="friction",
        caption="Friction coefficients",
        head=["repeat", "static", "kinetic", "file"],
        rows=rows,
        total=3,
        note=f"Read after {result.standard.title}. Static: {first}; kinetic: the mean from {start} "
        f"to {end} of travel; both over the normal force, {show(result.normal_force, 'N')}. The "
        "interval is Student's t over the repeats.",
        extra=settings,
    )


LABELS = {
    "scale_factor": ("scale factor a", "1"),
    "stiffness": ("stiffness k of brake and rig", "N/m"),
    "product": ("a × kinetic friction", "1"),
    "enclosure_factor": ("factor on the sleeve's force", "1"),
    "pressure_exponent": ("pressure exponent", "1"),
    "speed_slope": ("ln(friction) per decade of speed", "1"),
    "peak_force": ("peak force", "N"),
    "peak_elongation": ("elongation at the peak", "m"),
    "scale_factor_eq8": ("scale factor by the paper's eq. 8", "1"),
    "stiffness_eq9": ("stiffness by the paper's eq. 9", "N/m"),
}


def interval_of(values: Mapping[str, Any], name: str) -> tuple[float | None, float | None]:
    """The 95 % interval of `name` as a verb gives it, in whatever form; Nones without one."""
    given = (values.get("intervals") or {}).get(name)
    if isinstance(given, Mapping):
        return given.get("low"), given.get("high")
    if isinstance(given, list | tuple) and len(given) == 2:
        return given[0], given[1]
    return None, None


def calibration_table(result: Calibrated, kinetic: float) -> Table:
    """What the pulls fix, with its uncertainty."""
    values = result.values
    errors = values["standard_errors"]
    rests = str(errors.get("rests_on", ""))
    numbers = []
    for key, (words, unit) in LABELS.items():
        like = "scale_factor" if key == "product" else key
        factor = kinetic if key == "product" else 1.0
        value, error = values.get(like), errors.get(like)
        if value is None:
            continue
        low, high = interval_of(values, like)
        numbers.append(
            Number(
                quantity=f"calibration: {words}",
                value=None if value is None else value * factor,
                unit=unit,
                standard_error=None if error is None else error * factor,
                low=None if low is None else low * factor,
                high=None if high is None else high * factor,
                n=result.count,
                source=rests if error is not None else _how(key, result.count),
            )
        )
    words, moved = _leave_one_out(values)
    return replace(estimates("calibration", "What the pulls fix", numbers, words), extra=moved)


def _leave_one_out(values: Mapping[str, Any]) -> tuple[str, list[Number]]:
    """(sentence, numbers): how far a and k move without the pull that matters most."""
    said, numbers = [], []
    for key in ("scale_factor", "stiffness"):
        moves = (values.get("leave_one_out") or {}).get(key)
        if not moves or not moves.get("files"):
            continue
        name = moves["most_influential"]
        words, unit = LABELS[key]
        number = Number(
            quantity=f"calibration: change of {words} without its most influential pull",
            value=moves["files"][name], unit=unit, source=name,
            shown_in="kN/m" if unit == "N/m" else "", decimals=4 if unit == "1" else 2,
        )  # fmt: skip
        numbers.append(number)
        sign = "+" if (number.value or 0) >= 0 else ""
        said.append(f"{words} by {sign}{number.text()} ({name})")
    return (
        f"Without its most influential pull changes {'; '.join(said)}." if said else ""
    ), numbers


def _how(key: str, count: int) -> str:
    return {
        "scale_factor_eq8": "as printed: crosshead where slip belongs",
        "stiffness_eq9": "as printed: peak force over peak displacement",
    }.get(key, "mean of the pulls" if count > 1 else "the pull")


def pulls_table(result: Calibrated) -> Table:
    """Each pull that was calibrated on."""
    rows: list[list[Cell]] = []
    for fit in result.fits:
        name = Path(fit.pull.path).name
        rows.append(
            [
                name,
                *(
                    Number(quantity=f"calibration pull: {what}", value=value, unit=unit,
                           standard_error=error, source=name, n=1, decimals=places)
                    for what, value, unit, error, places in (
                        ("vacuum", fit.vacuum, "Pa", None, None),
                        ("peak force", fit.pull.peak_force, "N", fit.pull.peak_force_se, 2),
                        ("scale factor a", fit.scale_factor, "1", fit.scale_factor_se, 4),
                        ("stiffness k", fit.stiffness, "N/m", fit.pull.stiffness_se, 1),
                    )
                ),
            ]
        )  # fmt: skip
    return Table(
        id="pulls",
        caption="Each pull",
        head=["file", "vacuum", "peak force", "scale factor a", "stiffness k"],
        rows=rows,
        printed=len(result.fits) <= FEW,
    )


def _error_cells(
    title: str, one: ConditionError | Validation, before: ConditionError | Validation | None
) -> list[Cell]:
    """MAPE, RMSE, bias and R^2, before calibration (if known) and after each."""
    cells: list[Cell] = []
    for what, key, unit, shown, places in (
        ("MAPE", "mape", "1", "%", 2),
        ("RMSE", "rmse", "N", "N", 2),
        ("bias", "bias", "N", "N", 2),
        ("R²", "r_squared", "1", "", 3),
    ):
        for state, found in (("before calibration", before), ("calibrated", one)):
            if before is None and state == "before calibration":
                continue
            low = high = None
            if what == "MAPE" and found is not None and isinstance(found, ConditionError):
                spread = over_repeats([c.mape for c in found.curves])
                low, high = spread.low, spread.high
            cells.append(
                Number(
                    quantity=f"validation, {title}: {what}, {state}",
                    value=getattr(found, key), unit=unit, shown_in=shown, decimals=places,
                    n=len(found.curves) if found is not None else None, low=low, high=high,
                )
            )  # fmt: skip
    return cells


def _split_cells(title: str, split: Split | None) -> tuple[list[Cell], list[Number]]:
    """(cells, numbers that no cell shows): the model's own error, the scatter, its share."""
    if split is None:
        return [NONE] * 3, []

    def number(what: str, value: float | None, unit: str, shown: str, places: int | None) -> Number:
        return Number(
            quantity=f"validation, {title}: {what}", value=value, unit=unit, shown_in=shown,
            decimals=places, n=split.repeats, source="split over the repeats",
        )  # fmt: skip

    own = number("model's own error, root mean square", max(split.model, 0.0) ** 0.5, "N", "N", 2)
    squares = [
        number("mean squared error", split.mse, "N^2", "", None),
        number("model's part of it", split.model, "N^2", "", None),
        number("scatter's part of it", split.scatter, "N^2", "", None),
    ]
    share: Cell = NONE
    if split.share is not None:
        share = number("scatter's share of the squared error", split.share, "1", "%", 0)
    return [
        own if split.model > 0 else UNTOLD,
        number("scatter between repeats, SD", split.scatter**0.5, "N", "N", 2),
        share,
    ], squares


def condition_words(condition: ConditionError) -> str:
    """Such as "80.6 kPa, 7 mm/s"."""
    speed = "speed unknown" if condition.speed is None else show(condition.speed, "m/s", 3)
    return f"{show(condition.vacuum, 'Pa')}, {speed}"


def validation_table(result: Validation, before: Validation | None) -> Table:
    """A row for every condition and one for all; after calibration beside before."""
    rows: list[list[Cell]] = []
    extra: list[Number] = []
    for index, one in enumerate(result.conditions):
        title, count = condition_words(one), len(one.curves)
        then = before.conditions[index] if before is not None else None
        split, hidden = _split_cells(title, one.split)
        extra += hidden
        rows.append(
            [
                Number(quantity=f"validation, {title}: vacuum", value=one.vacuum, unit="Pa",
                       shown_in="kPa", decimals=1),
                Number(quantity=f"validation, {title}: speed", value=one.speed, unit="m/s",
                       shown_in="mm/s"),
                Number(quantity=f"validation, {title}: pulls", value=count, unit="1", decimals=0),
                *_error_cells(title, one, then),
                *split,
            ]
        )  # fmt: skip
    split, hidden = _split_cells("all", result.split)
    extra += hidden
    count = len(result.curves)
    every = Number(quantity="validation, all: pulls", value=count, unit="1", decimals=0)
    rows.append(["all", "", every, *_error_cells("all", result, before), *split])
    extra += _pooled(result, before)
    states = 1 if before is None else 2
    names = ("MAPE [%]", "RMSE [N]", "bias [N]", "R²")
    if before is None:
        head, groups = list(names), [("", 3), ("brake as it is", 4)]
    else:
        head = ["before", "after"] * 4
        groups = [("", 3), *((name, states) for name in names)]
    return Table(
        id="validation",
        caption="Validation per condition",
        head=[
            "vacuum [kPa]",
            "speed [mm/s]",
            "pulls",
            *head,
            "own [N]",
            "scatter [N]",
            "share [%]",
        ],
        groups=[*groups, ("squared error split", 3)],
        rows=rows,
        total=1,
        unit_in_head=True,
        note=_note(result, before),
        extra=extra,
    )


def _pooled(result: Validation, before: Validation | None) -> list[Number]:
    """MAPE in all with its SDs, as the table's note has them."""
    out = []
    for state, one in (("before calibration", before), ("calibrated", result)):
        if one is None:
            continue
        out += [
            Number(quantity=f"validation, all: MAPE, SD between pulls, {state}",
                   value=one.mape_sd, unit="1", n=len(one.curves)),
            Number(quantity=f"validation, all: mean of the conditions' MAPE, {state}",
                   value=one.mape_conditions, unit="1", n=len(one.conditions)),
            Number(quantity=f"validation, all: SD of the conditions' MAPE, {state}",
                   value=one.mape_conditions_sd, unit="1", n=len(one.conditions)),
        ]  # fmt: skip
    return out


def _note(result: Validation, before: Validation | None) -> str:
    def words(one: Validation) -> str:
        text = f"{one.mape_conditions:.1%}"
        return text + (f" ± {one.mape_conditions_sd:.1%}" if one.mape_conditions_sd else "")

    text = f"Mean MAPE of the {len(result.conditions)} conditions ± SD between them: "
    text += words(result)
    if before is not None:
        text += f" (before calibration {words(before)})"
    text += (
        ". Before: scale factor 1 and the stiffness of eq. 1. Bias is model less measured. Own and "
        "scatter: the calibrated model's error against the mean of the repeats, and the repeats' "
        "SD at one elongation, as root mean squares; share: the scatter's part of the mean squared "
        "error, which no model can take away."
    )
    if any(c.split is not None and c.split.model <= 0 for c in result.conditions):
        text += (
            f" {UNTOLD}: the model's error cannot be told from none; the estimate of its square is "
            "below zero and the share above 100 %."
        )
    return text


def curves_table(result: Validation, before: Validation | None) -> Table:
    """Each pull that was validated on."""
    rows: list[list[Cell]] = []
    then = {} if before is None else {c.path: c for c in before.curves}
    for curve in result.curves:
        name = Path(curve.path).name
        cells = [*_curve_cells(name, curve, "")]
        if before is not None:
            cells.append(_curve_cells(name, then[curve.path], ", before calibration")[0])
        rows.append([name, *cells, curve.note])
    head = ["file", "MAPE [%]", "RMSE [N]", "bias [N]", "R²"]
    if before is not None:
        head.append("MAPE before [%]")
    return Table(
        id="curves", caption="Each pull", head=[*head, "note"], rows=rows, unit_in_head=True,
        printed=False,
    )  # fmt: skip


def _curve_cells(name: str, curve: CurveError, state: str) -> list[Cell]:
    points = len(curve.elongation)
    return [
        Number(quantity=f"validation pull: {what}{state}", value=value, unit=unit, shown_in=shown,
               decimals=places, n=points, source=name)
        for what, value, unit, shown, places in (
            ("MAPE", curve.mape, "1", "%", 2),
            ("RMSE", curve.rmse, "N", "N", 2),
            ("bias", curve.bias, "N", "N", 2),
            ("R²", curve.r_squared, "1", "", 4),
        )
    ]  # fmt: skip


def files_table(files: Sequence[FileUsed]) -> Table:
    """What was read, with its digest."""
    return Table(
        id="files",
        caption="Files",
        head=["file", "used for", "format", "vacuum", "speed", "SHA-256"],
        rows=[
            [
                f.name,
                f.role,
                f.format,
                Number(quantity=f"file {f.name}: vacuum", value=f.vacuum, unit="Pa"),
                Number(quantity=f"file {f.name}: speed", value=f.speed, unit="m/s"),
                f.sha256,
            ]
            for f in files
        ],
        printed=False,
    )
