"""The tables of a brake's report: friction, calibration, validation, and what was read."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam.identify.calibration.record import Calibration
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.repeats import over_repeats
from layerjam.identify.validation.metrics import ConditionError, CurveError, Split, Validation
from layerjam.report.brake_numbers import Cell, Number, estimates
from layerjam.report.page import NONE, Table
from layerjam.units import show

UNTOLD = "≈ 0"
"""Shown for a model's error that cannot be told from none."""
KINDS = ("static", "kinetic")


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


def _under(stem: str, **common: Any) -> Callable[..., Number]:
    """What makes numbers whose quantities begin alike and that share what is `common`."""

    def number(what: str, value: Any, unit: str = "1", shown_in: str = "", **more: Any) -> Number:
        given = common | more
        return Number(quantity=stem + what, value=value, unit=unit, shown_in=shown_in, **given)

    return number


def friction_table(result: FrictionResult) -> Table:
    """Per repeat, and pooled."""
    count, rows = len(result.repeats), list[list[Cell]]()
    for index, repeat in enumerate(result.repeats, 1):
        number = _under("friction: ", n=1, source=Path(repeat.path).name, decimals=4)
        both = [number(f"{kind}, repeat {index}", getattr(repeat, kind)) for kind in KINDS]
        rows.append([str(index), *both, Path(repeat.path).name])
    number = _under("friction: ", n=count, source=f"{count} repeats", decimals=4)
    pooled, spread = [], []
    for kind in KINDS:
        known = [v for r in result.repeats if (v := getattr(r, kind)) is not None]
        found = over_repeats(known or [math.nan])
        sure = {"standard_error": found.standard_error, "low": found.low, "high": found.high}
        pooled.append(number(f"{kind}, mean", getattr(result, kind), **sure))
        spread.append(number(f"{kind}, standard deviation", getattr(result, f"{kind}_sd")))
    rows += [
        ["mean", *pooled, f"of {count} repeats"],
        ["SD", *spread, "between repeats"],
        ["95 %", *(number.interval_text() for number in pooled), "interval of the mean"],
    ]
    start, end = (show(w, "m") for w in result.window)
    first = "the first maximum" if result.standard.first_maximum else "the greatest force"
    setting = _under("friction: ")
    return Table(
        id="friction",
        caption="Friction coefficients",
        head=["repeat", "static", "kinetic", "file"],
        rows=rows,
        total=3,
        note=f"Read after {result.standard.title}. Static: {first}; kinetic: the mean from {start} "
        f"to {end} of slip; both over the normal force, {show(result.normal_force, 'N')}. The "
        "interval is Student's t over the repeats.",
        extra=[
            setting("normal force", result.normal_force, "N"),
            setting("window from", result.window[0], "m"),
            setting("window to", result.window[1], "m"),
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
_HOW = {
    "scale_factor_eq8": "as printed: crosshead where slip belongs",
    "stiffness_eq9": "as printed: peak force over peak displacement",
}


def calibration_table(result: Calibration, kinetic: float) -> Table:
    """What the pulls fix, with its uncertainty."""
    count = len(result.curves)
    plainly = "mean of the pulls" if count > 1 else "the pull"
    numbers = []
    for key, (words, unit) in LABELS.items():
        like, factor = ("scale_factor", kinetic) if key == "product" else (key, 1.0)
        value = result.values.get(like, getattr(result, like, None))
        if value is None:
            continue
        error, over = result.standard_errors.get(like), result.intervals.get(like)
        low, high = (over.low * factor, over.high * factor) if over else (None, None)
        numbers.append(
            Number(
                quantity=f"calibration: {words}",
                value=value * factor,
                unit=unit,
                standard_error=None if error is None else error * factor,
                low=low,
                high=high,
                n=count,
                source=_HOW.get(key, plainly) if error is None else result.errors_rest_on,
            )
        )
    note, moved = _leave_one_out(result)
    caption = "What the pulls fix"
    return estimates(numbers, id="calibration", caption=caption, note=note, extra=moved)


def _leave_one_out(result: Calibration) -> tuple[str, list[Number]]:
    """(sentence, numbers): how far a and k move without the pull that matters most."""
    said, numbers = [], []
    for key, shown_in, decimals in (("scale_factor", "", 4), ("stiffness", "kN/m", 2)):
        moves = (result.leave_one_out or {}).get(key)
        if moves is None or moves.most_influential is None:
            continue
        words, unit = LABELS[key]
        name = moves.most_influential
        number = Number(
            quantity=f"calibration: change of {words} without its most influential pull",
            value=moves.files[name],
            unit=unit,
            source=name,
            shown_in=shown_in,
            decimals=decimals,
        )
        numbers.append(number)
        said.append(f"{words} by {'+' * (moves.files[name] >= 0)}{number.text()} ({name})")
    note = f"Without its most influential pull changes {'; '.join(said)}." if said else ""
    return note, numbers


def pulls_table(result: Calibration) -> Table:
    """Each pull that was calibrated on."""
    rows: list[list[Cell]] = []
    for fit in result.fits:
        name, pull = Path(fit.pull.path).name, fit.pull
        number = _under("calibration pull: ", source=name, n=1)
        peak = {"standard_error": pull.peak_force_se, "decimals": 2}
        factor = {"standard_error": fit.scale_factor_se, "decimals": 4}
        spring = {"standard_error": pull.stiffness_se, "decimals": 1}
        cells = [
            number("vacuum", fit.vacuum, "Pa"),
            number("peak force", pull.peak_force, "N", **peak),
            number("scale factor a", fit.scale_factor, **factor),
            number("stiffness k", fit.stiffness, "N/m", **spring),
        ]
        rows.append([name, *cells])
    head = ["file", "vacuum", "peak force", "scale factor a", "stiffness k"]
    return Table(id="pulls", caption="Each pull", head=head, rows=rows)


MEASURES = (
    ("MAPE", "mape", "1", "%", 2),
    ("RMSE", "rmse", "N", "N", 2),
    ("bias", "bias", "N", "N", 2),
    ("R²", "r_squared", "1", "", 3),
)
"""Name, attribute, SI unit, unit shown, decimals."""


def _error_cells(title: str, one: Any, before: Any) -> list[Cell]:
    """MAPE, RMSE, bias and R^2 of a condition or of all, before calibration (if known) and after.

    Both are a ConditionError or a Validation, `before` None where it is not known.
    """
    states = [("calibrated", one)]
    if before is not None:
        states.insert(0, ("before calibration", before))
    cells: list[Cell] = []
    for what, key, unit, shown, places in MEASURES:
        for state, found in states:
            sure = {}
            if what == "MAPE" and isinstance(found, ConditionError):
                spread = over_repeats([c.mape for c in found.curves])
                sure = {"low": spread.low, "high": spread.high}
            number = _under(f"validation, {title}: ", n=len(found.curves), decimals=places, **sure)
            cells.append(number(f"{what}, {state}", getattr(found, key), unit, shown))
    return cells


def _split_cells(title: str, split: Split | None) -> tuple[list[Cell], list[Number]]:
    """(cells, numbers that no cell shows): the model's own error, the scatter, its share."""
    if split is None:
        return [NONE] * 3, []
    number = _under(f"validation, {title}: ", n=split.repeats, source="split over the repeats")
    own = max(split.model, 0.0) ** 0.5
    share: Cell = NONE
    if split.share is not None:
        name = "scatter's share of the squared error"
        share = number(name, split.share, "1", "%", decimals=0)
    return [
        number("model's own error, root mean square", own, "N", "N", decimals=2) if own else UNTOLD,
        number("scatter between repeats, SD", split.scatter**0.5, "N", "N", decimals=2),
        share,
    ], [
        number("mean squared error", split.mse, "N^2"),
        number("model's part of it", split.model, "N^2"),
        number("scatter's part of it", split.scatter, "N^2"),
    ]


def condition_words(condition: ConditionError) -> str:
    """Such as "80.6 kPa, 7 mm/s"."""
    speed = "speed unknown" if condition.speed is None else show(condition.speed, "m/s", 3)
    return f"{show(condition.vacuum, 'Pa')}, {speed}"


def validation_table(result: Validation, before: Validation | None) -> Table:
    """A row for every condition and one for all; after calibration beside before."""
    rows: list[list[Cell]] = []
    extra: list[Number] = []

    def row(first: Sequence[Cell], title: str, one: Any, then: Any) -> None:
        split, hidden = _split_cells(title, one.split)
        pulls = _under(f"validation, {title}: ", decimals=0)("pulls", len(one.curves))
        rows.append([*first, pulls, *_error_cells(title, one, then), *split])
        extra.extend(hidden)

    for index, one in enumerate(result.conditions):
        title = condition_words(one)
        number = _under(f"validation, {title}: ")
        vacuum = number("vacuum", one.vacuum, "Pa", "kPa", decimals=1)
        then = before.conditions[index] if before is not None else None
        row([vacuum, number("speed", one.speed, "m/s", "mm/s")], title, one, then)
    row(["all", ""], "all", result, before)
    names = ["MAPE [%]", "RMSE [N]", "bias [N]", "R²"]
    head, groups = names, [("", 3), ("brake as it is", 4)]
    if before is not None:
        head, groups = ["before", "after"] * 4, [("", 3), *((name, 2) for name in names)]
    split = ["own [N]", "scatter [N]", "share [%]"]
    return Table(
        id="validation",
        caption="Validation per condition",
        head=["vacuum [kPa]", "speed [mm/s]", "pulls", *head, *split],
        groups=[*groups, ("squared error split", 3)],
        rows=rows,
        total=1,
        unit_in_head=True,
        note=_note(result, before),
        extra=[*extra, *_pooled(result, before)],
    )


def _pooled(result: Validation, before: Validation | None) -> list[Number]:
    """MAPE in all with its SDs, as the table's note has them."""
    out = []
    for state, one in (("before calibration", before), ("calibrated", result)):
        for what, key, of in (
            ("MAPE, SD between pulls", "mape_sd", "curves"),
            ("mean of the conditions' MAPE", "mape_conditions", "conditions"),
            ("SD of the conditions' MAPE", "mape_conditions_sd", "conditions"),
        ):
            if one is not None:
                number = _under("validation, all: ", n=len(getattr(one, of)))
                out.append(number(f"{what}, {state}", getattr(one, key)))
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
        cells = _curve_cells(name, curve, "")
        if before is not None:
            cells.append(_curve_cells(name, then[curve.path], ", before calibration")[0])
        rows.append([name, *cells, curve.note])
    earlier = [] if before is None else ["MAPE before [%]"]
    head = ["file", "MAPE [%]", "RMSE [N]", "bias [N]", "R²", *earlier, "note"]
    return Table(id="curves", caption="Each pull", head=head, rows=rows, unit_in_head=True)


def _curve_cells(name: str, curve: CurveError, state: str) -> list[Number]:
    number = _under("validation pull: ", n=len(curve.elongation), source=name)
    return [
        number(
            what + state, getattr(curve, key), unit, shown, decimals=4 if what == "R²" else places
        )
        for what, key, unit, shown, places in MEASURES
    ]


def files_table(files: Sequence[FileUsed]) -> Table:
    """What was read, with its digest."""
    rows: list[list[Cell]] = []
    for file in files:
        number = _under(f"file {file.name}: ")
        known = number("vacuum", file.vacuum, "Pa"), number("speed", file.speed, "m/s")
        rows.append([file.name, file.role, file.format, *known, file.sha256])
    head = ["file", "used for", "format", "vacuum", "speed", "SHA-256"]
    return Table(id="files", caption="Files", head=head, rows=rows)
