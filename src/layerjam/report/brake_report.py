"""The report of one brake: what stands in it, the same on every page."""

from __future__ import annotations

import functools
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.identify.checks import Check
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.validation.metrics import WINDOW, Validation
from layerjam.identify.validation.table import validation_checks
from layerjam.measure.trace import Trace
from layerjam.report import brake_figures, brake_tables
from layerjam.report.brake_numbers import Number, Table
from layerjam.report.brake_tables import Calibrated, FileUsed
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SYNTHETIC = (
    "Synthetic data: the files marked so were written by a program from a stated truth, not "
    "measured. What follows shows the procedure; it says nothing about a real brake."
)


MOST_WORDS = 3
"""Words after an option that the printed pages' command shows one by one."""


@dataclass(frozen=True, kw_only=True)
class BrakeReport:
    """What a report is made of. `file` is the brake the model's lines were drawn with.

    `names` {name of a file: what the pages call it} is for files that lie under other names.
    `stages` maps friction, calibration and validation to the keys of the verbs' answers, for the
    stages there are; `refused` is (file, stage, why); `seen` names validation files that the brake
    was calibrated on; `command` made the report, on `date` (ISO).
    """

    file: BrakeFile
    stages: Mapping[str, Mapping[str, Any]]
    files: Sequence[FileUsed]
    command: str
    date: str
    friction: tuple[Sequence[Trace], FrictionResult] | None = None
    calibration: Calibrated | None = None
    validation: Validation | None = None
    before: Validation | None = None
    refused: Sequence[tuple[str, str, str]] = ()
    seen: Sequence[str] = ()
    warnings: Mapping[str, Sequence[str]] = field(default_factory=dict)
    brake_sha256: str = ""
    names: Mapping[str, str] = field(default_factory=dict)

    @property
    def brake(self) -> Brake:
        """The numbers of `file`."""
        return self.file.brake

    @property
    def synthetic(self) -> bool:
        """Whether any file was made by a program."""
        return any(f.synthetic for f in self.files)


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A figure of the report: its name, how it is drawn, and its caption."""

    name: str
    figure: Callable[[], Figure]
    caption: str


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of the report, the same on every page."""

    id: str
    title: str
    text: Sequence[str] = ()
    tables: Sequence[Table] = ()
    drawings: Sequence[Drawing] = ()
    checks: Sequence[Check] = ()
    notes: Sequence[str] = ()


def sections(report: BrakeReport) -> list[Section]:
    """The parts there is something to say in."""
    makers = (_friction, _calibration, _validation)
    return [part for make in makers if (part := make(report)) is not None]


def _friction(report: BrakeReport) -> Section | None:
    if report.friction is None:
        return None
    traces, result = report.friction
    return Section(
        id="friction",
        title="Friction",
        tables=[brake_tables.friction_table(result)],
        drawings=[
            Drawing(
                name="friction", figure=functools.partial(brake_figures.friction, traces, result),
                caption="Friction tests: force over normal force against travel. Dots: greatest "
                "value of each repeat; red: mean over the shaded window.",
            )
        ],
        notes=report.warnings.get("friction", ()),
    )  # fmt: skip


def _calibration(report: BrakeReport) -> Section | None:
    result = report.calibration
    if result is None:
        return None
    table = brake_tables.calibration_table(result, report.brake.film.kinetic)
    factor = table.numbers()[0]
    text = [
        f"Peaks fix only the product of scale factor and kinetic friction; the factor a holds "
        f"together with the friction it was fitted with, {report.brake.film.kinetic:.4g}."
    ]
    return Section(
        id="calibration",
        title="Calibration",
        text=text,
        tables=[table, brake_tables.pulls_table(result)] if result.fits else [table],
        drawings=[]
        if not result.fits
        else [
            Drawing(
                name="calibration",
                figure=functools.partial(
                    brake_figures.calibration, report.brake, result, factor.low, factor.high
                ),
                caption="Calibration. Left: the pulls near their peaks, the slope that gave k and "
                "the calibrated law. Right: the scale factor each pull gives.",
            )
        ],
        checks=result.checks,
        notes=report.warnings.get("calibration", ()),
    )


def _validation(report: BrakeReport) -> Section | None:
    result = report.validation
    if result is None:
        return None
    text = []
    if report.seen:
        count, of = len(report.seen), len(result.curves)
        which = "all" if count == of else f"{count} of {of}"
        text.append(
            f"This is no test of the model: {which} pulls below were also calibrated on "
            f"({_some(report.seen)}). It shows how well the law fits, not how well it predicts."
        )
    elif report.calibration is not None:
        text.append("None of these pulls was calibrated on.")
    if report.calibration is None:
        spring = report.brake.stiffness_measured
        stiff = "that of eq. 1" if spring is None else show(spring, "N/m")
        text.append(
            f"Model: the brake as its file has it, scale factor {report.brake.scale_factor:.4g}, "
            f"stiffness {stiff}."
        )
    text.append(f"Window: {WINDOW}.")
    both = " and before it (dotted)" if report.before is not None else ""
    return Section(
        id="validation",
        title="Fit to the calibration's own pulls" if _all_seen(report) else "Validation",
        text=text,
        tables=[
            brake_tables.validation_table(result, report.before),
            brake_tables.curves_table(result, report.before),
        ],
        drawings=[
            Drawing(
                name="validation",
                figure=functools.partial(
                    brake_figures.overlay, report.brake, result, report.before is not None
                ),
                caption="Measured force, mean of the repeats with a band of ± 1 SD, and the model "
                f"after calibration (dashed){both}.",
            ),
            Drawing(
                name="residuals", figure=functools.partial(brake_figures.residuals, result),
                caption="Residuals, model less measured, over the window: mean of the repeats with "
                "a band of ± 1 SD. A model without fault leaves bands that hold the zero line.",
            ),
        ],
        checks=validation_checks(result, len(report.seen)),
        notes=report.warnings.get("validation", ()),
    )  # fmt: skip


def _all_seen(report: BrakeReport) -> bool:
    return report.validation is not None and len(report.seen) == len(report.validation.curves)


def _some(names: Sequence[str], most: int = 4) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def headline(report: BrakeReport) -> list[tuple[str, str]]:
    """(value, words): the results one looks for first."""
    out = []
    for part in sections(report):
        numbers = {n.quantity: n for t in part.tables for n in t.numbers()}
        wanted = {
            "friction: kinetic, mean": "kinetic friction",
            "calibration: scale factor a": "scale factor a",
            "calibration: stiffness k of brake and rig": "stiffness k of brake and rig",
            "validation, all: MAPE, calibrated": "MAPE" + (" (fit)" if report.seen else ""),
        }
        for name, words in wanted.items():
            if name in numbers and numbers[name].value is not None:
                number = numbers[name]
                between = number.interval_text()
                more = f", 95 % interval {between}" if number.low is not None else ""
                out.append((number.text(), words + more))
        if part.id == "validation" and report.before is not None:
            out.append((f"{report.before.mape:.2%}".replace("%", " %"), "MAPE before calibration"))
    return out


def all_numbers(report: BrakeReport) -> list[Number]:
    """Every number of the pages, in order of reading."""
    tables = [t for part in sections(report) for t in part.tables]
    tables.append(brake_tables.files_table(report.files))
    return [number for table in tables for number in table.numbers()]


def _lead(report: BrakeReport) -> str:
    sheets = report.brake.sheets
    counts = []
    if report.friction is not None:
        counts.append(f"{len(report.friction[0])} friction tests")
    if report.calibration is not None:
        counts.append(f"{report.calibration.count} calibration pulls")
    if report.validation is not None:
        count = len(report.validation.conditions)
        counts.append(f"{len(report.validation.curves)} validation pulls at {count} conditions")
    what = f"{report.file.title.rstrip('.')}. " if report.file.title else ""
    size = f"{show(sheets.width, 'm')} wide, {show(sheets.thickness, 'm')} thick"
    return (
        f"{what}{sheets.count} sheets, {size}, overlapping by {show(sheets.overlap, 'm')}. "
        f"Tested: {', '.join(counts)}."
    )


def context(report: BrakeReport) -> dict[str, Any]:
    """What the templates of both pages show, all of it text."""
    banner = [SYNTHETIC] if report.synthetic else []
    parts = []
    for part in sections(report):
        parts.append(
            {
                "id": part.id,
                "title": part.title,
                "text": list(part.text),
                "tables": [_table(t) for t in part.tables],
                "figures": [{"name": d.name, "caption": d.caption} for d in part.drawings],
                "checks": [
                    {"name": c.name, "passed": c.passed, "sentence": c.sentence}
                    for c in part.checks
                ],
                "notes": list(dict.fromkeys(part.notes)),
            }
        )
    files = brake_tables.files_table(report.files)
    return {
        "title": f"Test report: {report.file.name}",
        "lead": _lead(report),
        "banner": banner,
        "headline": [{"value": v, "words": w} for v, w in headline(report)],
        "parts": parts,
        "refused": [{"file": n, "stage": s, "why": w} for n, s, w in report.refused],
        "files": _table(files),
        "digests": [
            {"name": f.name, "role": f.role, "sha": f.sha256, "synthetic": f.synthetic}
            for f in report.files
        ],
        "made": f"layerjam {__version__}, {report.date}",
        "date": report.date,
        "brake_file": f"{report.file.name}, SHA-256 {report.brake_sha256}",
        "command": report.command,
        "short_command": _short(report.command),
    }


def _short(command: str) -> str:
    """The command with runs of files cut to the first and their number."""
    words = shlex.split(command)
    out: list[str] = []
    run: list[str] = []
    for word in [*words, "--"]:
        if word.startswith("-"):
            many = len(run) > MOST_WORDS
            out += [shlex.quote(w) for w in (run[:1] if many else run)]
            out += [f"… ({len(run)} in all)"] if many else []
            out.append(word)
            run = []
        elif out and out[-1].startswith("--"):
            run.append(word)
        else:
            out.append(shlex.quote(word))
    return " ".join(out[:-1])


def _table(table: Table) -> dict[str, Any]:
    return {
        "id": table.id,
        "caption": table.caption,
        "head": list(table.head),
        "groups": [{"title": t, "span": n} for t, n in table.groups],
        "rows": table.cells(),
        "total": table.total,
        "note": table.note,
        "printed": table.printed,
    }


def drawings(report: BrakeReport) -> Iterator[Drawing]:
    """Every figure, in order of reading."""
    for part in sections(report):
        yield from part.drawings
