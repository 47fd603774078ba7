"""`report`: measurements of one brake as a page for the appendix."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.commands.calibration import calibrate as run_calibration
from layerjam.commands.declare import Help, Progress, PythonOnly, command, options
from layerjam.commands.friction import FrictionTest
from layerjam.commands.friction import friction as run_friction
from layerjam.commands.left_out import LeftOut, excluded_lines
from layerjam.commands.quantities import (
    Atmosphere,
    BrakeInput,
    Overwrite,
    brake_file,
)
from layerjam.commands.reading import FileOptions, FileVacuum, Measured, several
from layerjam.commands.results import Result, fact, result
from layerjam.commands.validation import validate as run_validation
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.errors import FitError, LayerjamError, Notice, QuantityError
from layerjam.measure.trace import Trace
from layerjam.report.folder import plain
from layerjam.simulate.quantities import VACUUM
from layerjam.units import QuantitySpec, show

if TYPE_CHECKING:
    from layerjam.report.brake_files import Written
    from layerjam.report.brake_report import BrakeReport

SPEED = QuantitySpec("m/s", "speed of the crosshead", open_lo=True)
NEAR = 0.03
"""Part by which a held back vacuum or speed may differ from the one given."""
Paths = Sequence[Measured] | Measured


@options
class Measurements:
    """The files of a report, and which of them serve what."""

    friction: Annotated[Paths, Help("Friction tests.", metavar="FILE...", greedy=True)] = ()
    pulls: Annotated[Paths, Help("Pulls to calibrate on.", metavar="FILE...", greedy=True)] = ()
    validate: Annotated[Paths, Help("Pulls to validate on.", metavar="FILE...", greedy=True)] = ()
    calibrate_on: Annotated[
        Paths,
        Help(
            "Calibrate on these alone; the other pulls serve the validation.",
            metavar="FILE...",
            greedy=True,
        ),
    ] = ()
    holdout: Annotated[
        Sequence[str],
        Help(
            "Keep the pulls at this vacuum, speed or 'repeat N' for the validation.",
            metavar="Q...",
            greedy=True,
        ),
    ] = ()

    def divided(
        self, reading: FileOptions, tell: Progress
    ) -> tuple[Sequence[Measured], Sequence[Measured]]:
        """Which pulls to calibrate on, and which to validate on."""
        pulls, others = several(self.pulls), several(self.validate)
        chosen = several(self.calibrate_on)
        holdout = [self.holdout] if isinstance(self.holdout, str) else list(self.holdout)
        if chosen and holdout:
            raise QuantityError("--calibrate-on and --holdout: give one of them")
        if holdout and not pulls:
            raise QuantityError("--holdout: there are no --pulls to hold back from")
        if holdout:
            kept, held = _held_back(pulls, holdout, reading, tell)
            return kept, [*held, *others]
        if chosen:
            known = {_identity(p) for p in chosen}
            rest = [p for p in pulls if _identity(p) not in known]
            if not (rest or others):
                raise QuantityError("--calibrate-on: names every pull, none is left to validate on")
            return chosen, [*rest, *others]
        return pulls, others or pulls


@result
class Report(Result):
    """Where the report's files are, and each stage's keys; `record` is the BrakeReport."""

    report: str = fact("the page")
    pdf: str | None = fact("the page as PDF; null without the extra 'pdf'")
    numbers: str = fact("every number, as CSV")
    results: str = fact("everything, as JSON")
    figures: Sequence[str] = fact(
        "the figures", shown=lambda found: found and f"{len(found)} in {Path(found[0]).parent}"
    )
    friction: Mapping[str, Any] | None = fact("keys of friction", listed=False)
    calibration: Mapping[str, Any] | None = fact("keys of calibrate", listed=False)
    validation: Mapping[str, Any] | None = fact("keys of validate", listed=False)
    calibrated_on_the_same: Sequence[str] = fact(
        "files that were both calibrated and validated on", listed=False
    )
    excluded: Sequence[Mapping[str, Any]] = fact("files left out by hand, and why", listed=False)
    refused: Mapping[str, str] = fact("files that were not used, and why", listed=False)

    def lines(self) -> Iterator[str]:
        """What was left out by hand."""
        yield from excluded_lines(self.excluded)


@dataclass(frozen=True, kw_only=True)
class _Work:
    """What the stages take, and the report that they fill."""

    report: BrakeReport
    how: HowTested
    tell: Progress

    def keep(self, stage: str, found: Result, traces: Sequence[Trace], *left_out: str) -> None:
        """Take a command's result into the report, without warnings of the keys left out."""
        from layerjam.report.brake_tables import file_used

        report = self.report
        values = {k: v for k, v in found.values.items() if k not in ("file", "refused", "excluded")}
        report.stages[stage] = {**plain(values), "units": dict(found.units)}
        said = (w for w in found.warnings if getattr(w, "key", "") not in ("synthetic", *left_out))
        report.warnings[stage] = list(dict.fromkeys(said))
        refused: Mapping[str, str] = found.values["refused"]
        report.refused += [(Path(p).name, stage, why) for p, why in refused.items()]
        excluded: Sequence[Mapping[str, Any]] = found.values.get("excluded", ())
        report.excluded += [(Path(e["file"]).name, stage, e["because"]) for e in excluded]
        report.files += [file_used(trace, stage) for trace in traces]

    def take_over(self, file: BrakeFile) -> None:
        """The brake that a stage has made, at the site's atmosphere."""
        self.report.file = brake_file(file, self.how.atmosphere)


@command(
    "test",
    place=50,
    examples=(
        "layerjam report choi2018-kapton --friction friction-*.csv --pulls pull-*.csv "
        "--holdout 46.1kPa --out report",
    ),
)
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
    options: FileOptions = FileOptions(),
    force: Overwrite = False,
    command: Annotated[
        str, PythonOnly("What the page says it was made with.", typed=True)
    ] = "layerjam.report(...) in Python",
    date: Annotated[str | None, PythonOnly("Date (ISO) instead of today.")] = None,
    names: Annotated[
        Mapping[str, str] | None, PythonOnly("What the page calls files, by their name.")
    ] = None,
    progress: Progress | None = None,
) -> Report:
    """Measurements of one brake as a page: friction, calibration, validation, HTML and PDF.

    Writes report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.
    `friction` tests give the friction, `pulls` the calibration, `validate` is what the calibrated
    brake is compared with; each may be left out. Of `pulls` alone some can be kept for validation:
    `calibrate_on` names those to calibrate on, or `holdout` holds back a vacuum ("46.1 kPa"), a
    speed ("19 mm/s") or a repeat ("repeat 3"). Without any of these the brake is compared with the
    pulls it was calibrated on, and the page says so. `vacuum` serves files without a sidecar; the
    options of friction tests, `depth` and `exclude` are as in `friction` and `calibrate`. `command`
    is what the page says it was made with, `date` (ISO) is today unless given; `names` {file name:
    what the report calls it} serves files that lie under other names than their own. Raises
    FileError where a report exists and `force` is not set.
    """
    from layerjam.report.brake_files import check_folder, write
    from layerjam.report.page import check_extras

    out, tell = Path(out), progress or (lambda _what, _share: None)
    check_extras()
    check_folder(out, force)
    content = stages(
        brake,
        measurements,
        HowTested(
            test=test,
            depth=depth,
            vacuum=vacuum,
            atmosphere=atmosphere,
            left_out=left_out,
            options=options,
        ),
        tell,
        command=command,
        date=date,
        names=names,
    )
    return _written(content, write(content, out, force, lambda what: tell(what, 0.9)))


@dataclass(frozen=True, kw_only=True)
class HowTested:
    """How the files of a report are read and fitted; the fields are those of the command."""

    test: FrictionTest = FrictionTest()
    depth: Literal["exact", "curves"] = "exact"
    vacuum: float | None = None
    atmosphere: float | None = None
    left_out: LeftOut = LeftOut()
    options: FileOptions = FileOptions()


def stages(
    brake: BrakeFile,
    measurements: Measurements,
    how: HowTested,
    tell: Progress,
    *,
    command: str,
    date: str | None = None,
    names: Mapping[str, str] | None = None,
) -> BrakeReport:
    """The stages of a report, computed and not written; `publish` and `recompute` take them too.

    `command`, `date` and `names` as in `report`. Raises FitError where no file is given.
    """
    from layerjam.report.brake_report import BrakeReport

    content = BrakeReport(
        file=brake,
        command=command,
        date=date or datetime.now(UTC).date().isoformat(),
        brake_sha256=brake.sha256,
        names=names or {},
    )
    work = _Work(report=content, how=how, tell=tell)
    fitted_on, tested_on = measurements.divided(how.options, tell)
    tests = several(measurements.friction)
    if not (tests or fitted_on or tested_on):
        raise FitError("nothing was given to report: --friction, --pulls or --validate")
    without = [*how.left_out.among(fitted_on, tested_on)]
    if tests:
        _friction(work, tests)
    if fitted_on:
        _calibration(work, fitted_on, without[0])
    if tested_on:
        _validation(work, tested_on, without[1])
    return content


def _written(content: BrakeReport, written: Written) -> Report:
    """Where the files are, and each stage's keys (None where there is no stage)."""
    warnings: list[str] = [w for some in content.warnings.values() for w in some]
    if content.synthetic:
        said = "synthetic: written by a program, not measured"
        warnings.insert(0, Notice(said, "synthetic"))
    if content.seen:
        said = (
            "validated on pulls that were also calibrated on, which is no test of the model: hold "
            "some back with --holdout or --calibrate-on, or give others with --validate"
        )
        warnings.append(Notice(said, "calibrated-on"))
    stages = {s: content.stages.get(s) for s in ("friction", "calibration", "validation")}
    return Report.of(
        written,
        **stages,
        calibrated_on_the_same=list(content.seen),
        excluded=[{"file": f, "stage": s, "because": why} for f, s, why in content.excluded],
        refused={name: why for name, _, why in content.refused},
        warnings=[*warnings, *written.warnings],
        record=content,
    )


def _friction(work: _Work, files: Sequence[Measured]) -> None:
    """Friction into the report; the brake takes it over."""
    from layerjam.identify.friction.reduction import with_friction

    work.tell(f"friction: {len(files)} files", 0.1)
    found = run_friction(files, test=work.how.test, options=work.how.options, progress=work.tell)
    traces, fit = work.report.friction = found.record
    work.keep("friction", found, traces)
    name = work.report.file.name
    if fit.kinetic is None:
        stands = f"the kinetic friction of {name}'s file stands: these tests give none"
        work.report.warnings["friction"].append(Notice(stands, "kinetic-stands"))
    else:
        text, _ = with_friction(work.report.file, fit, name)
        work.take_over(BrakeFile.read(text, name))


def _calibration(work: _Work, files: Sequence[Measured], without: LeftOut) -> None:
    """The fit into the report; the brake takes it over."""
    work.tell(f"calibration: {len(files)} pulls", 0.3)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"{work.report.file.name}.toml"
        found = run_calibration(
            work.report.file,
            files,
            depth=work.how.depth,
            vacuum=work.how.vacuum,
            out=place,
            partial=True,
            left_out=without,
            options=work.how.options,
            progress=work.tell,
        )
        work.take_over(load(place))
    work.keep("calibration", found, found.traces)
    work.report.calibration = found.record[1]


def _validation(work: _Work, files: Sequence[Measured], without: LeftOut) -> None:
    """The validation into the report, also before calibration, and what was calibrated on."""
    work.tell(f"validation: {len(files)} pulls", 0.6)
    report = work.report
    found = run_validation(
        report.file,
        files,
        vacuum=work.how.vacuum,
        left_out=without,
        options=work.how.options,
        progress=work.tell,
    )
    work.keep("validation", found, found.traces, "calibrated-on")
    report.validation = found.record[1]
    if report.calibration is not None or report.brake.scale_factor != 1.0:
        report.before = found.before
    report.seen = [Path(p).name for p in found.calibrated_on]


def _identity(source: Measured) -> str:
    return str(Path(source.path if isinstance(source, Trace) else source).resolve())


def _held_back(
    pulls: Sequence[Measured], holdout: Sequence[str], reading: FileOptions, tell: Progress
) -> tuple[list[Measured], list[Measured]]:
    """The pulls apart: to calibrate on, and those at a vacuum, speed or repeat of `holdout`."""
    from layerjam.identify.curves import speed_of
    from layerjam.measure.readers.read import read_trace

    wanted = [_condition(text) for text in holdout]
    tell(f"holding back {', '.join(holdout)}", 0.05)
    kept: list[Measured] = []
    held: list[Measured] = []
    levels: set[float] = set()
    for source in pulls:
        try:
            trace = source if isinstance(source, Trace) else read_trace(source, reading)
        except LayerjamError:
            kept.append(source)  # refused, with its reason, where it would be used
            continue
        facts = asdict(replace(trace.facts, speed=speed_of(trace)))
        if facts["vacuum"] is not None:
            levels.add(facts["vacuum"])
        away = any(_is(facts[what], value, what) for what, value in wanted)
        (held if away else kept).append(source)
    for side, word in ((kept, "to calibrate on"), (held, "held back")):
        if not side:
            said = f"--holdout {', '.join(holdout)}: of {len(pulls)} pulls none is {word}"
            at = ", ".join(show(level, "Pa") for level in sorted(levels))
            raise FitError(f"{said}; they state {f'vacuums of {at}' if at else 'no vacuum'}")
    return kept, held


def _is(value: float | None, wanted: float, what: str) -> bool:
    near = 0.0 if what == "repeat" else NEAR * wanted
    return value is not None and abs(value - wanted) <= near


def _condition(text: str) -> tuple[str, float]:
    """("vacuum", Pa), ("speed", m/s) or ("repeat", number) of what is to be held back."""
    match = re.fullmatch(r"\s*repeat\s*(\d{1,6})\s*", text)
    if match:
        return "repeat", float(match.group(1))
    for what, spec in (("vacuum", VACUUM), ("speed", SPEED)):
        try:
            return what, float(spec.read(text, "holdout"))
        except QuantityError:
            continue
    raise QuantityError(
        f"holdout: '{text[:60]}' is no vacuum, speed or repeat; write such as 46.1kPa, 19mm/s or "
        "'repeat 3'"
    )
