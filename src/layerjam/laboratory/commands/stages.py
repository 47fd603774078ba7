"""Stages of the measurements of one brake: friction, calibration and validation.

`report`, `publish` and `recompute` share them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from layerjam.brake.commands.arguments import convert_brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.command.declare import Progress
from layerjam.core.command.results import Result
from layerjam.core.drawing.folder import to_json
from layerjam.core.errors import FitError, Notice, QuantityError, count_text
from layerjam.core.verdict import Check, Verdict, judge, remaining, to_key
from layerjam.laboratory.commands.calibration import calibrate as run_calibration
from layerjam.laboratory.commands.friction import FrictionTest, list_numbers
from layerjam.laboratory.commands.friction import friction as run_friction
from layerjam.laboratory.commands.left_out import LeftOut
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.reading import FileOptions, Measured, list_files
from layerjam.laboratory.commands.validation import validate as run_validation
from layerjam.laboratory.measure.trace import Trace

if TYPE_CHECKING:
    from layerjam.laboratory.figures.brake_report import BrakeReport


@dataclass(frozen=True, kw_only=True)
class HowTested:
    """Options for reading and fitting the files of a report.

    The fields are those of the command.
    """

    test: FrictionTest = FrictionTest()
    depth: Literal["exact", "curves"] = "exact"
    vacuum: float | None = None
    atmosphere: float | None = None
    left_out: LeftOut = LeftOut()
    options: FileOptions = FileOptions()
    accept: Mapping[str, str] | None = None


@dataclass(frozen=True, kw_only=True)
class _Work:
    """Inputs of the stages, and the report to which they add."""

    report: "BrakeReport"
    methods: HowTested
    tell: Progress

    def judge(
        self, stage: str, checks: Sequence[Check], numbers: Sequence[str] = (), files: int = 0
    ) -> Verdict:
        """Return the verdict of a stage with checks on `numbers`, and add it to the report.

        In the report a check is named after its stage, as in `friction.repeats`, because stages
        have checks of the same name. The short name accepts a check for the stage's own numbers;
        `_check_accepted` rejects it if it means several.
        """
        report = self.report
        stage_checks = [replace(check, name=f"{stage}.{check.name}") for check in checks]
        full_names = {to_key(c.name): c.name for c in stage_checks if c.level == "failed"}
        short_names = {to_key(c.name): f"{stage}.{c.name}" for c in checks if c.level == "failed"}
        accepted_here = {
            {**short_names, **full_names}[to_key(name)]: reason
            for name, reason in (self.methods.accept or {}).items()
            if to_key(name) in {**short_names, **full_names}
        }
        verdict = judge(stage_checks, accepted_here, numbers, date=report.date, files=files)
        old_verdict = report.verdict
        report.checks[stage] = checks
        report.verdict = Verdict(
            checks=(*old_verdict.checks, *verdict.checks),
            decisions=(*old_verdict.decisions, *verdict.decisions),
            numbers=(*old_verdict.numbers, *verdict.numbers),
        )
        report.earlier = remaining(report.earlier, verdict)
        return verdict

    def add_result(
        self, stage: str, result: Result, traces: Sequence[Trace], *left_out: str
    ) -> None:
        """Add a command's result to the report, without the warnings of the keys `left out`."""
        from layerjam.laboratory.figures.brake_tables import make_file_entry

        report = self.report
        values = {
            k: v for k, v in result.values.items() if k not in ("file", "refused", "excluded")
        }
        report.stages[stage] = {**to_json(values), "units": dict(result.units)}
        notices = (
            w for w in result.warnings if getattr(w, "key", "") not in ("synthetic", *left_out)
        )
        report.warnings[stage] = list(dict.fromkeys(notices))
        refusals: Mapping[str, str] = result.values["refused"]
        report.refused += [(path, stage, reason) for path, reason in refusals.items()]
        exclusions: Sequence[Mapping[str, Any]] = result.values.get("excluded", ())
        report.excluded += [
            {
                "file": row["file"],
                "stage": stage,
                "because": row["because"],
                "automatic": row["automatic"],
            }
            for row in exclusions
        ]
        report.files += [make_file_entry(trace, stage) for trace in traces]

    def adopt_brake(self, file: BrakeFile) -> None:
        """Use the brake of a stage for all later stages, at the site's atmosphere."""
        self.report.file = convert_brake(file, self.methods.atmosphere)


def compute_stages(
    brake: BrakeFile,
    measurements: Measurements,
    methods: HowTested,
    progress: Progress,
    *,
    command: str,
    date: str | None = None,
    names: Mapping[str, str] | None = None,
) -> "BrakeReport":
    """Return the computed stages of a report, which `publish` and `recompute` also use.

    `command`, `date` and `names` are as in `report`. Raises FitError if no file is given, and
    QuantityError or UnknownNameError for an accepted check that did not fail.
    """
    from layerjam.laboratory.figures.brake_report import BrakeReport

    content = BrakeReport(
        file=brake,
        command=command,
        date=date or datetime.now(UTC).date().isoformat(),
        brake_sha256=brake.sha256,
        names=names or {},
        earlier=brake.accepted,
    )
    work = _Work(report=content, methods=methods, tell=progress)
    fitted_on, tested_on = measurements.split_pulls(methods.options, progress)
    tests = list_files(measurements.friction)
    if not (tests or fitted_on or tested_on):
        raise FitError("nothing to report; give --friction, --pulls or --validate")
    files_out = [*methods.left_out.split_groups(fitted_on, tested_on)]
    if tests:
        _add_friction(work, tests)
    if fitted_on:
        _add_calibration(work, fitted_on, files_out[0])
    if tested_on:
        _add_validation(work, tested_on, files_out[1])
    _check_accepted(content.verdict.checks, methods.accept or {})
    return content


def _check_accepted(checks: Sequence[Check], accept: Mapping[str, str]) -> None:
    """Raise QuantityError or UnknownNameError unless every accepted name means one failed check."""
    for name, reason in accept.items():
        failures = [c.name for c in checks if c.level == "failed"]
        matches = [n for n in failures if to_key(name) in (to_key(n), to_key(n.partition(".")[2]))]
        names = ", ".join(dict.fromkeys(matches))
        if len({*matches}) > 1:
            raise QuantityError.of("accept", f"'{name}' means several failed checks: {names}")
        if not matches:
            judge([*checks, *(_shorten_name(c) for c in checks)], {name: reason})


def _shorten_name(check: Check) -> Check:
    return replace(check, name=check.name.partition(".")[2])


def _add_friction(work: _Work, files: Sequence[Measured]) -> None:
    from layerjam.laboratory.identify.friction.reduction import add_friction

    work.tell(f"friction: {count_text(len(files), 'file')}", 0.1)
    stage = run_friction(
        files, test=work.methods.test, options=work.methods.options, progress=work.tell
    )
    traces, fit = work.report.friction = stage.record
    work.add_result("friction", stage, traces)
    verdict = work.judge("friction", fit.checks, list_numbers(fit), len(traces))
    name = work.report.file.name
    if fit.kinetic is None:
        stands = f"the kinetic friction in the file {name} is kept: these tests yield none"
        work.report.warnings["friction"].append(Notice(stands, "kinetic-stands"))
    else:
        text, _ = add_friction(work.report.file, fit, name, verdict)
        work.adopt_brake(BrakeFile.read(text, name))


def _add_calibration(work: _Work, files: Sequence[Measured], exclusions: LeftOut) -> None:
    from layerjam.laboratory.identify.provenance import format_brake

    work.tell(f"calibration: {count_text(len(files), 'pull')}", 0.3)
    stage = run_calibration(
        work.report.file,
        files,
        depth=work.methods.depth,
        vacuum=work.methods.vacuum,
        left_out=exclusions,
        tare=work.methods.test.tare,
        options=work.methods.options,
        progress=work.tell,
    )
    file, fit = stage.record
    verdict = work.judge("calibration", fit.checks, [*fit.sources], len(fit.curves))
    text = format_brake(
        file,
        fit,
        work.methods.depth,
        file.name,
        exclusions=stage.excluded,
        files=stage.made_from["files"],
        verdict=verdict,
        date=work.report.date,
        brake_sha256=work.report.brake_sha256,
    )
    work.adopt_brake(BrakeFile.read(text, file.name))
    stage.made_from["brake"]["sha256"] = work.report.brake_sha256
    work.add_result("calibration", stage, stage.traces)
    work.report.calibration = fit


def _add_validation(work: _Work, files: Sequence[Measured], exclusions: LeftOut) -> None:
    """Add the validation before and after calibration to the report, and the files used twice."""
    from layerjam.laboratory.identify.validation.several import check_validation

    work.tell(f"validation: {count_text(len(files), 'pull')}", 0.6)
    report = work.report
    stage = run_validation(
        report.file,
        files,
        vacuum=work.methods.vacuum,
        left_out=exclusions,
        tare=work.methods.test.tare,
        options=work.methods.options,
        progress=work.tell,
    )
    work.add_result("validation", stage, stage.traces, "calibrated-on")
    report.validation = stage.record[1]
    if report.calibration is not None or report.brake.scale_factor != 1.0:
        report.before = stage.before
    report.seen = [Path(p).name for p in stage.calibrated_on]
    work.judge("validation", check_validation(report.validation, len(report.seen)))
