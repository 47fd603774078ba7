"""`report`: measurements of one brake as a page for the appendix."""

from __future__ import annotations

import contextlib
import hashlib
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from layerjam.commands import calibration as calibration_verb
from layerjam.commands import friction as friction_verb
from layerjam.commands import validation as validation_verb
from layerjam.commands.answer import VACUUM, Answer, AnyBrake, Quantity, brake_at
from layerjam.commands.files import Paths, Progress
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.errors import FitError, LayerjamError, QuantityError
from layerjam.identify.calibration.peaks import Calibration, PullFit, fit_pull
from layerjam.identify.curves import speed_of
from layerjam.identify.friction.reduction import FrictionResult, with_friction
from layerjam.identify.provenance import calibrated_on, sha256
from layerjam.identify.validation.metrics import Validation
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.read import read_trace
from layerjam.measure.trace import Trace
from layerjam.report.brake_files import Written, check_folder, write
from layerjam.report.brake_report import BrakeReport
from layerjam.report.brake_tables import Calibrated, FileUsed
from layerjam.report.page import check_extras
from layerjam.units import QuantitySpec

DEPTHS = ("exact", "curves")
SPEED = QuantitySpec("m/s", "speed of the crosshead", open_lo=True)
NEAR = 0.03
"""Part by which a held back vacuum or speed may differ from the one given."""


@dataclass(kw_only=True)
class _Work:
    """What the stages leave behind."""

    file: BrakeFile
    choices: ReadingOptions | None
    vacuum: Quantity | None
    atmosphere: Quantity | None
    say: Callable[[str], None]
    progress: Progress | None
    stages: dict[str, dict[str, Any]] = field(default_factory=dict)
    warnings: dict[str, list[str]] = field(default_factory=dict)
    refused: list[tuple[str, str, str]] = field(default_factory=list)
    files: list[FileUsed] = field(default_factory=list)

    def keep(self, stage: str, answer: Answer, traces: Sequence[Trace]) -> None:
        """Take a verb's answer into the report."""
        values = {k: v for k, v in answer.values.items() if k not in ("file", "refused")}
        self.stages[stage] = {**values, "units": dict(answer.units)}
        said = (w for w in answer.warnings if not w.startswith("synthetic:"))
        self.warnings[stage] = list(dict.fromkeys(said))
        self.refused += [(Path(p).name, stage, why) for p, why in answer.refused.items()]
        for trace in traces:
            facts = trace.facts
            self.files.append(
                FileUsed(
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
            )


def report(
    brake: AnyBrake,
    *,
    out: str | Path,
    friction: Paths = (),
    pulls: Paths = (),
    validate: Paths = (),
    calibrate_on: Paths = (),
    holdout: Sequence[str] = (),
    normal_force: Quantity | None = None,
    window: tuple[Quantity | None, Quantity | None] | None = None,
    standard: str = "paper",
    area: Quantity | None = None,
    accept_judder: bool = False,
    depth: str = "exact",
    vacuum: Quantity | None = None,
    atmosphere: Quantity | None = None,
    choices: ReadingOptions | None = None,
    force: bool = False,
    command: str = "layerjam.report(...) in Python",
    date: str | None = None,
    say: Callable[[str], None] | None = None,
    progress: Progress | None = None,
    names: Mapping[str, str] | None = None,
) -> Answer:
    """Write report.html, report.pdf, figures, numbers.csv and results.json into the folder `out`.

    `friction` tests give the friction, `pulls` the calibration, `validate` is what the calibrated
    brake is compared with; each may be left out. Of `pulls` alone some can be kept for validation:
    `calibrate_on` names those to calibrate on, or `holdout` holds back a vacuum ("46.1 kPa"), a
    speed ("19 mm/s") or a repeat ("repeat 3"). Without any of these the brake is compared with the
    pulls it was calibrated on, and the page says so. `vacuum` serves files without a sidecar;
    `normal_force`, `window`, `standard`, `area`, `accept_judder` belong to the friction tests and
    `depth` ("exact" or "curves") to the calibration, as in their own verbs; `date` (ISO) is
    today unless given; `progress` is told (what, share done) of the files read; `names` {file name:
    what the report calls it} serves files that lie under other names than their own.
    `record` is the BrakeReport. Raises FileError where a report exists and `force` is not set.
    """
    out = Path(out)
    check_extras()
    check_folder(out, force)
    work = _Work(
        file=brake_at(brake, atmosphere), choices=choices, vacuum=vacuum, atmosphere=atmosphere,
        say=say or (lambda _: None), progress=progress,
    )  # fmt: skip
    given = work.file
    fitted_on, tested_on = _divided(pulls, validate, calibrate_on, holdout, work)
    if depth not in DEPTHS:
        raise QuantityError(f"depth: '{depth[:40]}' is not allowed here; use {' or '.join(DEPTHS)}")
    if not (friction or fitted_on or tested_on):
        raise FitError("nothing was given to report: --friction, --pulls or --validate")
    made: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / f"{given.name}.toml"
        if friction:
            made["friction"] = _friction(
                work, friction, normal_force=normal_force, window=window, standard=standard,
                area=area, accept_judder=accept_judder,
            )  # fmt: skip
        if fitted_on:
            made["calibration"] = _calibration(work, fitted_on, depth, place)
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
        brake_sha256=hashlib.sha256(given.text.encode()).hexdigest(),
        names=names or {},
        **made,
    )
    written = write(content, out, force, work.say)
    return _answer(content, written)


def _answer(content: BrakeReport, written: Written) -> Answer:
    """The verb's answer: where the files are, and each stage's keys (None where there is none)."""
    refused = {name: why for name, _, why in content.refused}
    values: dict[str, Any] = {
        "report": str(written.report),
        "pdf": None if written.pdf is None else str(written.pdf),
        "numbers": str(written.numbers),
        "results": str(written.results),
        "figures": [str(p) for p in written.figures],
        **{s: content.stages.get(s) for s in ("friction", "calibration", "validation")},
        "calibrated_on_the_same": list(content.seen),
        "refused": refused,
    }
    warnings = [w for some in content.warnings.values() for w in some]
    if content.synthetic:
        warnings.insert(0, "synthetic: written by a program, not measured")
    if content.seen:
        warnings.append(
            "validated on pulls that were also calibrated on, which is no test of the model: "
            "hold some back with --holdout or --calibrate-on, or give others with --validate"
        )
    return Answer(
        values=values,
        units={},
        warnings=[*warnings, *written.warnings],
        refused=refused,
        record=content,
    )


def _friction(work: _Work, files: Paths, **how: Any) -> tuple[Sequence[Trace], FrictionResult]:
    work.say(f"friction: {len(files)} files")
    answer = friction_verb.friction(files, choices=work.choices, progress=work.progress, **how)
    traces, result = answer.record
    work.keep("friction", answer, traces)
    if result.kinetic is None:
        work.warnings["friction"].append(
            f"the kinetic friction of {work.file.name}'s file stands: these tests give none"
        )
    else:
        text, _ = with_friction(work.file, result, work.file.name)
        made = BrakeFile.read(text, work.file.name)
        work.file = brake_at(made, work.atmosphere)
    return traces, result


def _calibration(work: _Work, files: Paths, depth: str, place: Path) -> Calibrated:
    work.say(f"calibration: {len(files)} pulls")
    brake = work.file.brake
    answer, traces = calibration_verb.calibrated(
        work.file, files, depth, (), work.vacuum, place, True, None, work.choices, (0, 0, 0),
        work.progress, True,
    )  # fmt: skip
    result = answer.record[1]
    fits: list[PullFit] = list(result.fits) if isinstance(result, Calibration) else []
    for curve in () if isinstance(result, Calibration) else result.curves:
        with contextlib.suppress(FitError):
            fits.append(fit_pull(curve.pull, curve.vacuum, brake))
    work.file = brake_at(load(place), work.atmosphere)
    work.keep("calibration", answer, traces)
    return Calibrated(
        values=answer.values,
        fits=fits,
        checks=result.checks,
        count=len(result.files),
        record=result,
    )


def _validation(work: _Work, files: Paths) -> dict[str, Any]:
    work.say(f"validation: {len(files)} pulls")
    answer, before, traces = validation_verb.validated(
        work.file, files, work.vacuum, None, work.choices, work.progress
    )
    result: Validation = answer.record[1]
    seen = calibrated_on(work.file, [t.path for t in traces])
    work.keep("validation", answer, traces)
    kept = [w for w in work.warnings["validation"] if "was calibrated on it" not in w]
    work.warnings["validation"] = kept
    calibrated = "calibration" in work.stages or work.file.brake.scale_factor != 1.0
    return {
        "validation": result,
        "before": before if calibrated else None,
        "seen": [Path(p).name for p in seen],
    }


def _divided(
    pulls: Paths, validate: Paths, calibrate_on: Paths, holdout: Sequence[str], work: _Work
) -> tuple[Paths, Paths]:
    """Which files to calibrate on, and which to validate on."""
    if calibrate_on and holdout:
        raise QuantityError("--calibrate-on and --holdout: give one of them")
    if holdout and not pulls:
        raise QuantityError("--holdout: there are no --pulls to hold back from")
    if holdout:
        kept, held = _held_back(pulls, holdout, work)
        return kept, [*held, *validate]
    if calibrate_on:
        chosen = {_identity(p) for p in calibrate_on}
        rest = [p for p in pulls if _identity(p) not in chosen]
        if not (rest or validate):
            raise QuantityError("--calibrate-on: names every pull, none is left to validate on")
        return calibrate_on, [*rest, *validate]
    return pulls, validate or pulls


def _identity(path: str | Path) -> str:
    return str(Path(path).resolve())


def _held_back(
    pulls: Paths, holdout: Sequence[str], work: _Work
) -> tuple[list[str | Path], list[str | Path]]:
    """The pulls apart: to calibrate on, and those at a vacuum, speed or repeat of `holdout`."""
    wanted = [_condition(text) for text in holdout]
    work.say(f"holding back {', '.join(holdout)}")
    kept: list[str | Path] = []
    held: list[str | Path] = []
    for path in pulls:
        try:
            trace = read_trace(path, work.choices)
        except LayerjamError:
            kept.append(path)  # refused, with its reason, where it would be used
            continue
        facts = {"vacuum": trace.facts.vacuum, "speed": speed_of(trace)}
        facts["repeat"] = trace.facts.repeat
        away = any(_is(facts[what], value, what) for what, value in wanted)
        (held if away else kept).append(path)
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
