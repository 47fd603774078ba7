"""`report`: the measurements of one brake as a page for an appendix."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.commands.calibration import calibrate as run_calibration
from layerjam.commands.declare import Help, Progress, PythonOnly, command, options
from layerjam.commands.friction import FrictionTest
from layerjam.commands.friction import friction as run_friction
from layerjam.commands.left_out import LeftOut, exclusion_lines
from layerjam.commands.measurements import Measurements
from layerjam.commands.quantities import Accept, Atmosphere, BrakeInput, Overwrite, convert_brake
from layerjam.commands.reading import FileOptions, FileVacuum, Measured, list_files
from layerjam.commands.results import Result, fact, result
from layerjam.commands.validation import validate as run_validation
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError, Notice, count_text
from layerjam.measure.trace import Trace
from layerjam.report.folder import to_json
from layerjam.verdict import Check, Verdict, judge, remaining, to_key

if TYPE_CHECKING:
    from layerjam.report.brake_files import ReportFiles
    from layerjam.report.brake_report import BrakeReport


@options
class Issued:
    """Identity of a report, in addition to its brake and date."""

    report_number: Annotated[str, Help("Report number, printed on every page.", metavar="TEXT")] = (
        ""
    )
    customer: Annotated[str, Help("Customer, with address.", metavar="TEXT")] = ""


@result
class Report(Result):
    """Files of the report, and the keys of each stage; `record` is the BrakeReport.

    The files are None if a check failed.
    """

    record: "BrakeReport | None" = None
    report: str | None = fact("report page; null if a check failed")
    pdf: str | None = fact("report as PDF; null unless the extra 'pdf' is installed")
    numbers: str | None = fact("all numbers, as CSV")
    results: str | None = fact("all results, as JSON")
    figures: Sequence[str] = fact(
        "files of the figures",
        default=(),
        shown=lambda found: found and f"{len(found)} in {Path(found[0]).parent}",
    )
    friction: Mapping[str, Any] | None = fact("results of the friction tests", listed=False)
    calibration: Mapping[str, Any] | None = fact("results of the calibration", listed=False)
    validation: Mapping[str, Any] | None = fact("results of the validation", listed=False)
    calibrated_on_the_same: Sequence[str] = fact(
        "files used for both calibration and validation", listed=False
    )
    excluded: Sequence[Mapping[str, Any]] = fact(
        ("files excluded by hand, with reasons"), listed=False
    )
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield the files left out by the user."""
        yield from exclusion_lines(self.excluded)


@dataclass(frozen=True, kw_only=True)
class _Work:
    """Inputs of the stages, and the report to which they add."""

    report: "BrakeReport"
    how: "HowTested"
    tell: Progress

    def judge(self, stage: str, checks: Sequence[Check], numbers: Sequence[str] = ()) -> Verdict:
        """Return the verdict of a stage with checks on `numbers`, and add it to the report."""
        failed_keys = {to_key(c.name) for c in checks if c.level == "failed"}
        accepted_here = {
            name: reason
            for name, reason in (self.how.accept or {}).items()
            if to_key(name) in failed_keys
        }
        verdict = judge(checks, accepted_here, numbers, date=self.report.date)
        before = self.report.verdict
        self.report.checks[stage] = checks
        self.report.verdict = Verdict(
            checks=(*before.checks, *verdict.checks),
            decisions=(*before.decisions, *verdict.decisions),
            numbers=(*before.numbers, *verdict.numbers),
        )
        return verdict

    def add_result(
        self, stage: str, result: Result, traces: Sequence[Trace], *left_out: str
    ) -> None:
        """Add a command's result to the report, without the warnings of the keys `left out`."""
        from layerjam.report.brake_tables import make_file_entry

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
        report.refused += [(Path(p).name, stage, reason) for p, reason in refusals.items()]
        exclusions: Sequence[Mapping[str, Any]] = result.values.get("excluded", ())
        report.excluded += [(Path(e["file"]).name, stage, e["because"]) for e in exclusions]
        report.files += [make_file_entry(trace, stage) for trace in traces]

    def adopt_brake(self, file: BrakeFile) -> None:
        """Use the brake of a stage for all later stages, at the site's atmosphere."""
        self.report.file = convert_brake(file, self.how.atmosphere)


@command("test")
def report(
    brake: BrakeInput,
    *,
    out: Annotated[str | Path, Help("Folder for the report.", metavar="DIR")],
    measurements: Measurements = Measurements(),
    test: FrictionTest = FrictionTest(),
    depth: Annotated[
        Literal["exact", "curves"], Help("Calibrate on peaks, or on whole curves.")
    ] = "exact",
    vacuum: FileVacuum = None,
    atmosphere: Atmosphere = None,
    left_out: LeftOut = LeftOut(),
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    issued: Issued = Issued(),
    overwrite: Overwrite = False,
    command: Annotated[
        str, PythonOnly("Program printed on the page.", typed=True)
    ] = "layerjam.report(...) in Python",
    date: Annotated[str | None, PythonOnly("ISO date to print instead of today's.")] = None,
    names: Annotated[
        Mapping[str, str] | None, PythonOnly("Names to print for the files, by file name.")
    ] = None,
    progress: Progress | None = None,
) -> Report:
    """Report the measurements of one brake as HTML and PDF: friction, calibration, validation.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` are friction tests, `pulls` calibrate the brake, and the calibrated brake is compared
    with the pulls in `validate`; each may be omitted. Without `validate`, some of the pulls can be
    reserved for validation: `calibrate_on` names those for calibration, or `holdout` reserves a
    vacuum ("46.1 kPa"), a speed ("19 mm/s") or a repeat ("repeat 3"). Otherwise the brake is
    compared with its calibration pulls, and the page says so. `vacuum` applies to files without a
    sidecar; the options of friction tests, `depth` and `exclude` are as in `friction` and
    `calibrate`. `command` is printed as the command that created the page; `date` (ISO) is today by
    default. `names` {file name: name in the report} is for files stored under other names.
    `report_number` and `customer` appear on the pages; sidecars may state them instead. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError if a report exists and `overwrite` is not set.
    """
    from layerjam.report.brake_files import check_folder, write_report
    from layerjam.report.page import require_extras

    out, tell = Path(out), progress or (lambda _what, _share: None)
    require_extras()
    check_folder(out, overwrite)
    content = compute_stages(
        brake,
        measurements,
        HowTested(
            test=test,
            depth=depth,
            vacuum=vacuum,
            atmosphere=atmosphere,
            left_out=left_out,
            options=options,
            accept=accept,
        ),
        tell,
        command=command,
        date=date,
        names=names,
    )
    content.number, content.customer = issued.report_number, issued.customer
    failed_checks = content.verdict.failed
    files = None if failed_checks else write_report(content, out, overwrite, lambda w: tell(w, 0.9))
    return _make_report_result(content, files)


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


def compute_stages(
    brake: BrakeFile,
    measurements: Measurements,
    methods: HowTested,
    tell: Progress,
    *,
    command: str,
    date: str | None = None,
    names: Mapping[str, str] | None = None,
) -> "BrakeReport":
    """Return the computed stages of a report, which `publish` and `recompute` also use.

    `command`, `date` and `names` are as in `report`. Raises FitError if no file is given, and
    QuantityError or UnknownNameError for an accepted check that did not fail.
    """
    from layerjam.report.brake_report import BrakeReport

    content = BrakeReport(
        file=brake,
        command=command,
        date=date or datetime.now(UTC).date().isoformat(),
        brake_sha256=brake.sha256,
        names=names or {},
    )
    work = _Work(report=content, how=methods, tell=tell)
    fitted_on, tested_on = measurements.split_pulls(methods.options, tell)
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
    judge(content.verdict.checks, methods.accept)
    content.earlier = remaining(brake.accepted, content.verdict.numbers)
    return content


def _make_report_result(content: "BrakeReport", files: "ReportFiles | None") -> Report:
    """Return the paths of the files, and the keys of each stage (None if it was omitted)."""
    warnings: list[str] = [w for notices in content.warnings.values() for w in notices]
    if content.synthetic:
        sentence = "synthetic: written by a program, not measured"
        warnings.insert(0, Notice(sentence, "synthetic"))
    if content.seen:
        sentence = (
            "validated on pulls that were also used for calibration, which does not test the "
            "model: reserve some with --holdout or --calibrate-on, or give others with "
            "--validate"
        )
        warnings.append(Notice(sentence, "calibrated-on"))
    stages = {s: content.stages.get(s) for s in ("friction", "calibration", "validation")}
    return Report.create(
        files,
        content.verdict,
        numbers=files and files.numbers,
        **stages,
        calibrated_on_the_same=list(content.seen),
        excluded=[{"file": f, "stage": s, "because": reason} for f, s, reason in content.excluded],
        refused={name: reason for name, _, reason in content.refused},
        warnings=[*warnings, *(files.warnings if files else ())],
        record=content,
    )


def _add_friction(work: _Work, files: Sequence[Measured]) -> None:
    from layerjam.identify.friction.reduction import add_friction

    work.tell(f"friction: {count_text(len(files), 'file')}", 0.1)
    stage = run_friction(files, test=work.how.test, options=work.how.options, progress=work.tell)
    traces, fit = work.report.friction = stage.record
    work.add_result("friction", stage, traces)
    verdict = work.judge("friction", fit.checks, [f"film.{kind}" for kind in fit.means])
    name = work.report.file.name
    if fit.kinetic is None:
        stands = f"the kinetic friction in the file {name} is kept: these tests yield none"
        work.report.warnings["friction"].append(Notice(stands, "kinetic-stands"))
    else:
        text, _ = add_friction(work.report.file, fit, name, verdict.decisions)
        work.adopt_brake(BrakeFile.read(text, name))


def _add_calibration(work: _Work, files: Sequence[Measured], exclusions: LeftOut) -> None:
    from layerjam.identify.provenance import format_brake

    work.tell(f"calibration: {count_text(len(files), 'pull')}", 0.3)
    stage = run_calibration(
        work.report.file,
        files,
        depth=work.how.depth,
        vacuum=work.how.vacuum,
        left_out=exclusions,
        options=work.how.options,
        progress=work.tell,
    )
    file, fit = stage.record
    verdict = work.judge("calibration", fit.checks, [*fit.sources])
    text = format_brake(
        file,
        fit,
        work.how.depth,
        file.name,
        exclusions=stage.excluded,
        files=stage.made_from["files"],
        acceptances=verdict.decisions,
        date=work.report.date,
    )
    work.adopt_brake(BrakeFile.read(text, file.name))
    work.add_result("calibration", stage, stage.traces)
    work.report.calibration = fit


def _add_validation(work: _Work, files: Sequence[Measured], exclusions: LeftOut) -> None:
    """Add the validation before and after calibration to the report, and the files used twice."""
    from layerjam.identify.validation.table import check_validation

    work.tell(f"validation: {count_text(len(files), 'pull')}", 0.6)
    report = work.report
    stage = run_validation(
        report.file,
        files,
        vacuum=work.how.vacuum,
        left_out=exclusions,
        options=work.how.options,
        progress=work.tell,
    )
    work.add_result("validation", stage, stage.traces, "calibrated-on")
    report.validation = stage.record[1]
    if report.calibration is not None or report.brake.scale_factor != 1.0:
        report.before = stage.before
    report.seen = [Path(p).name for p in stage.calibrated_on]
    work.judge("validation", check_validation(report.validation, len(report.seen)))
