"""Report of one brake; HTML and PDF have the same content."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from layerjam._version import __version__
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.brief import brief
from layerjam.core.drawing.page import Page, Part, Picture, Word, typeset_text
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.core.verdict import Acceptance, Check, Verdict
from layerjam.laboratory.figures import (
    brake_figures,
    brake_tables,
    calibration_figure,
    friction_figures,
    signed,
)
from layerjam.laboratory.figures.brake_numbers import Number, table_numbers
from layerjam.laboratory.figures.brake_tables import FileUsed
from layerjam.laboratory.identify.calibration.budget import (
    Budget,
    Contribution,
    Peak,
    make_budget,
    make_friction_lines,
)
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.friction.reduction import FrictionResult
from layerjam.laboratory.identify.validation.metrics import WINDOW, Validation
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace

STAGES = ("friction", "calibration", "validation")
SYNTHETIC = (
    "Synthetic data: a program wrote some of the files from stated true values; they were not "
    "measured. The results show the procedure and do not describe a real brake."
)
HEADLINE = {
    "friction: kinetic, mean": "kinetic friction",
    "calibration: scale factor a": "scale factor a",
    "calibration: a × kinetic friction": "a × kinetic friction",
    "calibration: stiffness k of brake and rig": "stiffness k of brake and rig",
    "validation, all: MAPE, calibrated": "MAPE",
}
"""The most important numbers, with their names."""
KEY = (
    "After ±: expanded uncertainty at 95 % coverage, with coverage factor k and effective degrees "
    "of freedom ν. Other intervals are based on the scatter of the tests alone."
)


@brief
@dataclass(kw_only=True)
class BrakeReport:
    """Content of a report, stage by stage; `file` is the brake after the last stage.

    `names` {name of a file: its name on the pages} is for files that are stored under different
    names. `stages` maps each stage (friction, calibration, validation) that was done to the keys of
    its command's result. `refused` are (path of the file, stage, reason), `excluded` are rows with
    these and whether the exclusion was automatic. `seen` names validation files that were also used
    for calibration. `command` wrote the report, on `date` (ISO). `checks` are those of each stage;
    `verdict` judges them all. `earlier` are accepted failures of the brake's file that still apply.
    `number` and `customer` are empty if only sidecars may state them.
    """

    file: BrakeFile
    command: str
    date: str
    brake_sha256: str
    names: Mapping[str, str]
    stages: dict[str, dict[str, Any]] = field(default_factory=dict)
    files: list[FileUsed] = field(default_factory=list)
    refused: list[tuple[str, str, str]] = field(default_factory=list)
    excluded: list[Mapping[str, Any]] = field(default_factory=list)
    warnings: dict[str, list[str]] = field(default_factory=dict)
    friction: tuple[Sequence[Trace], FrictionResult] | None = None
    calibration: Calibration | None = None
    validation: Validation | None = None
    before: Validation | None = None
    seen: Sequence[str] = ()
    checks: dict[str, Sequence[Check]] = field(default_factory=dict)
    verdict: Verdict = field(default_factory=Verdict)
    earlier: Sequence[Acceptance] = ()
    number: str = ""
    customer: str = ""

    @property
    def brake(self) -> Brake:
        """Brake in `file`."""
        return self.file.brake

    @property
    def synthetic(self) -> bool:
        """Whether a program generated any of the files, or any source of the brake's numbers."""
        return any(f.synthetic for f in self.files) or bool(self.file.synthetic)

    @property
    def accepted(self) -> list[Acceptance]:
        """Failed checks that were accepted, in this run or earlier."""
        return [*self.verdict.decisions, *self.earlier]

    @property
    def stated(self) -> list[tuple[str, Facts]]:
        """Return (file, its metadata) for every file."""
        return [*{f.name: f.facts for f in self.files}.items()]

    @property
    def identity(self) -> dict[str, str]:
        """Identification of the report, as {label: text}."""
        return signed.make_identity(self.stated, self.number, self.customer, self.date)


def make_page(report: BrakeReport) -> Page:
    """Return the page, from which HTML, PDF and the list of numbers are made."""
    rejections = [
        f"{Path(path).name} ({stage}): {reason}" for path, stage, reason in report.refused
    ]
    parts = _make_stages(report)
    if report.excluded:
        exclusions = [
            f"{row['file']} ({row['stage']}{', automatically' * row['automatic']}): "
            f"{row['because']}"
            for row in list_excluded(report.excluded)
        ]
        title = "Left out and not used in any number here"
        parts.insert(0, Part(id="excluded", title=title, notes=exclusions))
    if rejections:
        title = "Rejected and not used in any number here"
        parts.insert(0, Part(id="refused", title=title, notes=rejections))
    files = Part(
        id="provenance",
        title="Sources",
        tables=[brake_tables.files_table(report.files)],
        notes=[
            f"Brake: {report.file.name}, SHA-256 {report.brake_sha256}",
            f"Command: {report.command}",
            "Every number in this report is in numbers.csv (SI units); results.json has the rest.",
        ],
    )
    facts, identity = report.stated, report.identity
    parts += [signed.make_apparatus(facts), files, signed.make_signature_part(identity)]
    number = identity["report number"]
    return Page(
        title=f"Test report: {report.file.name}",
        lead=_make_lead(report),
        identity=identity,
        mark="Report without a number" if number == signed.NOT_STATED else f"Report {number}",
        verdicts=[_make_verdict(report)],
        banner=[
            *([SYNTHETIC] if report.synthetic else []),
            *map(_describe_acceptance, report.accepted),
            *signed.list_certificate_problems(facts),
        ],
        numbers=list_headlines(report, parts),
        key=KEY,
        parts=parts,
        footer=f"layerjam {__version__}, {report.date}",
        more={"date": report.date},
    )


def list_excluded(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of excluded files with their names in place of their paths."""
    return [{**row, "file": Path(row["file"]).name} for row in rows]


def _make_verdict(report: BrakeReport) -> Word:
    """Return the verdict on all checks, with the counts of accepted failures and of warnings."""
    count = len(report.accepted)
    looks = sum(c.level == "warning" for checks in report.checks.values() for c in checks)
    text = f"Verdict: accepted, {count_text(count, 'failed check')}" if count else "Verdict: passed"
    if looks:
        text += f", {count_text(looks, 'warning')}"
    return Word(text, "differs" if count else "reproduced")


def _describe_acceptance(acceptance: Acceptance) -> str:
    finding = f" ({acceptance.finding})" if acceptance.finding else ""
    place = f", as {Path(acceptance.file).name} states" if acceptance.file else ""
    decision = f"Accepted on {acceptance.date}{place}: {acceptance.reason}."
    return typeset_text(f"Check '{acceptance.check}' failed{finding}. {decision}")


def _make_stages(report: BrakeReport) -> list[Part]:
    parts = []
    if report.friction is not None:
        parts.append(_friction_part(report, *report.friction))
    if report.calibration is not None:
        parts.append(_calibration_part(report, report.calibration))
    if report.validation is not None:
        parts.append(_validation_part(report, report.validation))
    return parts


def _friction_part(report: BrakeReport, traces: Sequence[Trace], result: FrictionResult) -> Part:
    drawing = Picture(
        name="friction",
        figure=functools.partial(friction_figures.draw_friction, traces, result),
        caption="Friction tests: ratio of force to normal force versus slip. Circles: maximum of "
        "each repeat. Thick line: mean over the shaded window.",
    )
    return Part(
        id="friction",
        title="Friction",
        tables=[brake_tables.friction_table(result)],
        pictures=[drawing],
        checks=report.checks.get("friction", ()),
        notes=_list_notes(report, "friction"),
    )


def _calibration_part(report: BrakeReport, result: Calibration) -> Part:
    kinetic = report.brake.film.kinetic
    tables = [
        brake_tables.calibration_table(result, kinetic),
        signed.budget_table(*_make_budgets(report, result)),
    ]
    curves = functools.partial(
        calibration_figure.draw_calibration, report.file, result, report.synthetic
    )
    caption = "Pulls and calibrated law: whole curves, and near the peaks. Below: residuals."
    pictures = [Picture(name="calibration", figure=curves, caption=caption)]
    tables.append(brake_tables.calibration_pulls_table(result))
    if result.fits:
        factors = functools.partial(brake_figures.draw_factors, result)
        caption = "Scale factor of each individual pull."
        pictures.append(Picture(name="scale-factors", figure=factors, caption=caption))
    return Part(
        id="calibration",
        title="Calibration",
        text=[
            "Peaks determine only the product of scale factor and kinetic friction; the "
            f"factor a is valid only with the friction used in the fit, {kinetic:.4g}."
        ],
        tables=tables,
        pictures=pictures,
        checks=report.checks.get("calibration", ()),
        notes=_list_notes(report, "calibration"),
    )


def _find_widest_limits(report: BrakeReport, role: str) -> dict[str, float | None]:
    """Return the widest error limit of each instrument in the files of a role.

    It is None if a file does not state it.
    """
    facts = [f.facts for f in report.files if f.role == role]
    out: dict[str, float | None] = {}
    for name in ("load_cell", "gauge", "normal_force", "area"):
        limits = [getattr(fact, f"{name}_limit") for fact in facts]
        out[name] = None if None in limits else max(limits, default=None)
    return out


def _friction_lines(report: BrakeReport, exponent: float) -> tuple[Contribution, ...]:
    """Return the budget lines of the friction; none if the report has no friction test."""
    kinetic = None if report.friction is None else report.friction[1].over["kinetic"]
    if kinetic is None:
        return ()
    return make_friction_lines(kinetic, _find_widest_limits(report, "friction"), exponent)


def _make_budgets(report: BrakeReport, result: Calibration) -> tuple[Budget, Budget]:
    """Return the budgets of the scale factor, and of its product with the friction.

    If the report has no friction test, both have the same lines.
    """
    product = make_budget(
        [Peak(c.peak_force, c.vacuum) for c in result.curves],
        report.brake,
        result.contributions,
        report.file.sources,
        result.scale_factor,
    )
    lines = _friction_lines(report, report.brake.pressure_exponent or 0.0)
    factor = replace(product, contributions=(*product.contributions, *lines))
    return factor, replace(product, value=product.value * report.brake.film.kinetic)


def _validation_part(report: BrakeReport, result: Validation) -> Part:
    before = report.before
    model = functools.partial(brake_figures.draw_overlay, report.brake, result, before is not None)
    earlier = "" if before is None else " and before it (dotted)"
    is_fit = len(report.seen) == len(result.curves)
    tables = [
        brake_tables.validation_table(result, before),
        brake_tables.validation_pulls_table(result, before),
    ]
    return Part(
        id="validation",
        title="Fit to the calibration pulls" if is_fit else "Validation",
        text=_describe_validation(report, result),
        tables=tables,
        pictures=[
            Picture(
                name="validation",
                figure=model,
                caption="Measured force, mean of the repeats with a band of ± 1 SD, and the model "
                f"after calibration (dashed){earlier}.",
            ),
            Picture(
                name="residuals",
                figure=functools.partial(brake_figures.draw_residuals, result),
                caption="Residuals, model minus measured, over the window: mean of the repeats "
                "with a band of ± 1 SD. For a perfect model, the bands contain zero.",
            ),
        ],
        checks=report.checks.get("validation", ()),
        notes=_list_notes(report, "validation"),
    )


def _describe_validation(report: BrakeReport, result: Validation) -> list[str]:
    text = []
    if report.seen:
        count, total = len(report.seen), len(result.curves)
        share = "all" if count == total else f"{count} of {total}"
        tail = f" and {count - 4} more" if count > 4 else ""
        text.append(
            f"This does not test the model: {share} pulls below were also used for calibration "
            f"({', '.join(report.seen[:4])}{tail}). It shows how well the law fits, not how well "
            "it predicts."
        )
    elif report.calibration is not None:
        text.append("None of these pulls was used for calibration.")
    if report.calibration is None:
        spring = report.brake.stiffness_measured
        stiff = "that of eq. 1" if spring is None else show(spring, "N/m")
        factor = report.brake.scale_factor
        text.append(
            f"Model: the brake as in the brake file, scale factor {factor:.4g}, stiffness {stiff}."
        )
    return [*text, f"Window: {WINDOW}."]


def _list_notes(report: BrakeReport, stage: str) -> list[str]:
    return [typeset_text(f"Note: {note}") for note in report.warnings.get(stage, ())]


def list_headlines(report: BrakeReport, parts: Sequence[Part]) -> list[tuple[str, str]]:
    """Return (value, description) for each of the most important results."""
    numbers = {n.quantity: n for n in list_numbers(parts)}
    out = []
    budgets: dict[str, Budget] = {}
    if rig := _friction_lines(report, 0.0):
        budgets["kinetic friction"] = Budget(contributions=rig, value=report.brake.film.kinetic)
    if report.calibration is not None:
        factor, product = _make_budgets(report, report.calibration)
        budgets |= {"scale factor a": factor, "a × kinetic friction": product}
    for name, words in HEADLINE.items():
        number = numbers.get(name)
        if number is not None and number.value is not None:
            uncertainty = budgets.get(words)
            if uncertainty is not None:
                out.append(_add_uncertainty(number, words, uncertainty))
                continue
            fit = " (fit)" if report.seen and words == "MAPE" else ""
            interval = "" if number.low is None else f"\n95 % interval {number.interval_text()}"
            out.append((number.text(), words + fit + interval))
    if report.validation is not None and report.before is not None:
        out.append((f"{100 * report.before.mape:.2f} %", "MAPE before calibration"))
    return out


def _add_uncertainty(number: Number, words: str, uncertainty: Budget) -> tuple[str, str]:
    if uncertainty.headline is None:
        digits = replace(number, standard_error=None).text()
        return digits, f"{words}\nuncertainty not stated: the budget lists the missing entries"
    if (uncertainty.expanded_uncertainty or 0.0) >= 1:
        interval_text = f"± {uncertainty.headline[1]} includes zero"
        return number.text(), f"{words}\nnot determined: expanded uncertainty {interval_text}"
    missing_count = len(uncertainty.missing)
    bound_note = (
        f"\nlower bound: {count_text(missing_count, 'line')} not stated" if missing_count else ""
    )
    return " ± ".join(
        uncertainty.headline
    ), f"{words}\n{signed.coverage_text(uncertainty)}{bound_note}"


def list_numbers(parts: Sequence[Part]) -> list[Number]:
    """Return every number of a page, in reading order."""
    return [number for part in parts for table in part.tables for number in table_numbers(table)]


def _make_lead(report: BrakeReport) -> str:
    sheets = report.brake.sheets
    counts = []
    if report.friction is not None:
        counts.append(count_text(len(report.friction[0]), "friction test"))
    if report.calibration is not None:
        counts.append(count_text(len(report.calibration.curves), "calibration pull"))
    if report.validation is not None:
        pulls = count_text(len(report.validation.curves), "validation pull")
        counts.append(f"{pulls} at {count_text(len(report.validation.conditions), 'condition')}")
    title = f"{report.file.title.rstrip('.')}. " if report.file.title else ""
    size = f"{show(sheets.width, 'm')} wide, {show(sheets.thickness, 'm')} thick"
    return (
        f"{title}{sheets.count} sheets, {size}, overlapping by {show(sheets.overlap, 'm')}. "
        f"Tested: {', '.join(counts)}."
    )
