"""`report`: the measurements of one brake as a page for an appendix."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import (
    Accept,
    Atmosphere,
    BrakeInput,
    Overwrite,
)
from layerjam.core.command.declare import Help, Progress, PythonOnly, command, options
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import Notice
from layerjam.laboratory.commands.friction import FrictionTest
from layerjam.laboratory.commands.left_out import LeftOut, exclusion_lines
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.commands.reading import FileOptions, FileVacuum
from layerjam.laboratory.commands.stages import HowTested, compute_stages

if TYPE_CHECKING:
    from layerjam.laboratory.figures.brake_files import ReportFiles
    from layerjam.laboratory.figures.brake_report import BrakeReport


@options
class Issued:
    """Identity and form of a report, in addition to its brake and date."""

    report_number: Annotated[str, Help("Report number, printed on every page.", metavar="TEXT")] = (
        ""
    )
    customer: Annotated[str, Help("Customer, with address.", metavar="TEXT")] = ""
    live: Annotated[
        bool, Help("Add a part to report.html that computes the brake in the reader's browser.")
    ] = False


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
        "files left out, with reasons; `automatic` if no user named them", listed=False
    )
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield the files left out by the user."""
        yield from exclusion_lines(self.excluded)


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
    `report_number` and `customer` appear on the pages; sidecars may state them instead. With
    `live`, report.html computes the calibrated brake, as the page of `export html` does. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}. Raises
    FileError if a report exists and `overwrite` is not set.
    """
    from layerjam.core.drawing.page import require_extras
    from layerjam.laboratory.figures.brake_files import check_folder, write_report

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
    files = None
    if not content.verdict.failed:
        files = write_report(content, out, overwrite, lambda w: tell(w, 0.9), live=issued.live)
    return _make_report_result(content, files)


def _make_report_result(content: "BrakeReport", files: "ReportFiles | None") -> Report:
    """Return the paths of the files, and the keys of each stage (None if it was omitted)."""
    from layerjam.laboratory.figures.brake_report import list_excluded

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
        excluded=list_excluded(content.excluded),
        refused={Path(path).name: reason for path, _, reason in content.refused},
        warnings=[*warnings, *(files.warnings if files else ())],
        record=content,
    )
