"""`report`: measurements of one brake as a page for the appendix."""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.commands.calibration import calibrate as run_calibration
from layerjam.commands.declare import Help, Progress, PythonOnly, command, options
from layerjam.commands.friction import FrictionTest
from layerjam.commands.friction import friction as run_friction
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
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.identify.calibration.record import Calibration
    from layerjam.report.brake_files import Written
    from layerjam.report.brake_report import BrakeReport
    from layerjam.report.brake_tables import FileUsed

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
    refused: Mapping[str, str] = fact("files that were not used, and why", listed=False)


@dataclass(kw_only=True)
class _Work:
    """What the stages take, and what they leave behind."""

    file: BrakeFile
    atmosphere: float | None
    vacuum: float | None
    options: FileOptions
    tell: Progress
    stages: dict[str, dict[str, Any]] = field(default_factory=dict)
    warnings: dict[str, list[str]] = field(default_factory=dict)
    refused: list[tuple[str, str, str]] = field(default_factory=list)
    files: list[FileUsed] = field(default_factory=list)

    def keep(self, stage: str, found: Result, traces: Sequence[Trace], *left_out: str) -> None:
        """Take a command's result into the report, without warnings of the keys left out."""
        values = {k: v for k, v in found.values.items() if k not in ("file", "refused")}
        self.stages[stage] = {**plain(values), "units": dict(found.units)}
        said = (w for w in found.warnings if _key(w) not in ("synthetic", *left_out))
        self.warnings[stage] = list(dict.fromkeys(said))
        refused: Mapping[str, str] = found.values["refused"]
        self.refused += [(Path(p).name, stage, why) for p, why in refused.items()]
        self.files += [_used(trace, stage) for trace in traces]

    def at_site(self, file: BrakeFile) -> BrakeFile:
        """The brake at the site's atmosphere."""
        return brake_file(file, self.atmosphere)


def _key(warning: str) -> str:
    return warning.key if isinstance(warning, Notice) else ""


def _used(trace: Trace, stage: str) -> FileUsed:
    from layerjam.identify.curves import speed_of
    from layerjam.identify.provenance import sha256
    from layerjam.report.brake_tables import FileUsed

    facts = trace.facts
    return FileUsed(
        name=Path(trace.path).name,
        role=stage,
        sha256=sha256(trace.path),
        format=trace.format,
        vacuum=facts.vacuum,
        speed=speed_of(trace) if stage != "friction" else facts.speed,
        repeat=facts.repeat,
        synthetic=facts.synthetic,
        understood=trace.understood,
    )


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
    options of friction tests and `depth` are as in `friction` and `calibrate`. `command` is what
    the page says it was made with, `date` (ISO) is today unless given; `names` {file name: what the
    report calls it} serves files that lie under other names than their own. Raises FileError where
    a report exists and `force` is not set.
    """
    from layerjam.report.brake_files import check_folder, write
    from layerjam.report.brake_report import BrakeReport
    from layerjam.report.page import check_extras

    out, tell = Path(out), progress or (lambda _what, _share: None)
    check_extras()
    check_folder(out, force)
    work = _Work(
        file=brake,
        options=options,
        vacuum=vacuum,
        atmosphere=atmosphere,
        tell=tell,
    )
    fitted_on, tested_on = measurements.divided(options, tell)
    tests = several(measurements.friction)
    if not (tests or fitted_on or tested_on):
        raise FitError("nothing was given to report: --friction, --pulls or --validate")
    made: dict[str, Any] = {}
    if tests:
        made["friction"] = _friction(work, tests, test)
    if fitted_on:
        made["calibration"] = _calibration(work, fitted_on, depth)
    if tested_on:
        made |= _validation(work, tested_on)
    content = BrakeReport(
        file=work.file,
        stages=work.stages,
        files=work.files,
        command=command,
        date=date or datetime.now(UTC).date().isoformat(),
        refused=work.refused,
        warnings=work.warnings,
        brake_sha256=hashlib.sha256(brake.text.encode()).hexdigest(),
        names=names or {},
        **made,
    )
    return _written(content, write(content, out, force, lambda what: tell(what, 0.9)))


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
    return Report(
        report=str(written.report),
        pdf=written.pdf and str(written.pdf),
        numbers=str(written.numbers),
        results=str(written.results),
        figures=[str(p) for p in written.figures],
        **stages,
        calibrated_on_the_same=list(content.seen),
        refused={name: why for name, _, why in content.refused},
        warnings=[*warnings, *written.warnings],
        record=content,
    )


def _friction(work: _Work, files: Sequence[Measured], test: FrictionTest) -> Any:
    """(traces, FrictionResult); the brake takes the friction over."""
    from layerjam.identify.friction.reduction import with_friction

    work.tell(f"friction: {len(files)} files", 0.1)
    found = run_friction(files, test=test, options=work.options, progress=work.tell)
    traces, fit = found.record
    work.keep("friction", found, traces)
    name = work.file.name
    if fit.kinetic is None:
        stands = f"the kinetic friction of {name}'s file stands: these tests give none"
        work.warnings["friction"].append(Notice(stands, "kinetic-stands"))
    else:
        text, _ = with_friction(work.file, fit, name)
        work.file = work.at_site(BrakeFile.read(text, name))
    return traces, fit


def _calibration(
    work: _Work, files: Sequence[Measured], depth: Literal["exact", "curves"]
) -> Calibration:
    """The fit; the brake takes it over."""
    work.tell(f"calibration: {len(files)} pulls", 0.3)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"{work.file.name}.toml"
        found = run_calibration(
            work.file,
            files,
            depth=depth,
            vacuum=work.vacuum,
            out=place,
            partial=True,
            options=work.options,
            progress=work.tell,
        )
        work.file = work.at_site(load(place))
    work.keep("calibration", found, found.traces)
    fit: Calibration = found.record[1]
    return fit


def _validation(work: _Work, files: Sequence[Measured]) -> dict[str, Any]:
    """The Validation, that before calibration, and the pulls that were also calibrated on."""
    work.tell(f"validation: {len(files)} pulls", 0.6)
    found = run_validation(
        work.file, files, vacuum=work.vacuum, options=work.options, progress=work.tell
    )
    work.keep("validation", found, found.traces, "calibrated-on")
    calibrated = "calibration" in work.stages or work.file.brake.scale_factor != 1.0
    return {
        "validation": found.record[1],
        "before": found.before if calibrated else None,
        "seen": [Path(p).name for p in found.calibrated_on],
    }


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
    for source in pulls:
        try:
            trace = source if isinstance(source, Trace) else read_trace(source, reading)
        except LayerjamError:
            kept.append(source)  # refused, with its reason, where it would be used
            continue
        facts = asdict(replace(trace.facts, speed=speed_of(trace)))
        away = any(_is(facts[what], value, what) for what, value in wanted)
        (held if away else kept).append(source)
    for side, word in ((kept, "to calibrate on"), (held, "held back")):
        if not side:
            raise FitError(f"--holdout {', '.join(holdout)}: of {len(pulls)} pulls none is {word}")
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
