"""Friction, calibration and validation; each step uses the brake from the previous one.

A report of all steps is written on request.
"""

import re
import shutil
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.command.declare import Progress
from layerjam.core.drawing.page import apply_theme, read_inline_svg
from layerjam.core.drawing.style import format_svg
from layerjam.core.errors import LayerjamError
from layerjam.workbench.call import Call, DataFile, Options, Subject, parameters
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.uploads import restore_names
from layerjam.workbench.widgets import one_line

STEPS = ("friction", "calibrate", "validate")
SAMPLE = "Sampling takes minutes: press 'Sample' to begin."
WAITS = "Waiting for the calibration."
STOPPED = "Stopped before completion."
KEPT = 12
"""Number of results that are cached."""
_drawing = threading.Lock()
"""Lock that serialises drawing, because Matplotlib's settings are global."""


@dataclass(frozen=True)
class StepResult:
    """A call that was run: its result, picture (SVG) and written brake, or its error."""

    call: Call
    result: Any = None
    brake: BrakeFile | None = None
    picture: str = ""
    problem: str = ""
    notice: str = ""
    """Key of the notice whose remedy solves the problem."""
    pages: Mapping[str, bytes] = field(default_factory=dict)
    """{name: content} of a report's files; empty for other steps."""


@dataclass(frozen=True)
class Campaign:
    """Inputs of the chain: files, the desk's brake, and options of the commands."""

    rows: Sequence[Row]
    brake: Subject
    asked: Options
    folder: Path
    tell: Progress

    def select_files(self, role: str) -> tuple[DataFile, ...]:
        """Return the input files of a step."""
        return tuple(r.upload for r in self.rows if r.is_usable and r.role == role)

    def options(self, command: str) -> Options:
        """Return the options of a command that differ from its defaults."""
        specs = parameters(command)
        return {k: v for k, v in self.asked.items() if k in specs and v != specs[k].default}

    @property
    def stem(self) -> str:
        """Prefix of the names of the files that the steps write."""
        stem = file_stem(self.brake)
        if self.brake.name in (f"{stem}-tested.toml", f"{stem}-calibrated.toml"):
            return f"{stem}-again"  # outputs must not replace their own inputs
        return stem

    def friction(self) -> list[Call]:
        """Return a call that writes its result into the brake, and one that needs no brake."""
        files, options = self.select_files("friction"), self.options("friction")
        writing: Options = {**options, "brake": self.brake, "partial": True}
        return [
            Call("friction", options=writing, files=files, out=f"{self.stem}-tested.toml"),
            Call("friction", options=options, files=files),
        ]

    def calibration(self, brake: Subject) -> Call:
        """Return the call that fits a brake to the calibration pulls."""
        options = {**self.options("calibrate"), "partial": True}
        out, is_written = f"{self.stem}-calibrated.toml", brake is not self.brake
        return Call("calibrate", (brake,), options, self.select_files("calibrate"), out, is_written)

    def validation(self, brake: Subject) -> Call:
        """Return the call that compares a brake with the validation pulls."""
        files, is_written = self.select_files("validate"), brake is not self.brake
        return Call("validate", (brake,), self.options("validate"), files, made=is_written)

    def report(self) -> Call:
        """Return the call that writes a report of all files."""
        uses = (("friction", "friction"), ("pulls", "calibrate"), ("validate", "validate"))
        files: Options = {key: f for key, role in uses if (f := self.select_files(role))}
        options = {**files, **self.options("report")}
        return Call("report", (self.brake,), options, out=f"{file_stem(self.brake)}-report")


class Chain:
    """Steps by name: `done` contains their results, `instead` sentences for those without one.

    Results are cached, so that no step is computed twice.
    """

    def __init__(self) -> None:
        self.done: dict[str, StepResult] = {}
        self.messages: dict[str, str] = {}
        self._known: list[StepResult] = []

    def run(self, campaign: Campaign, *requested: str) -> None:
        """Update all steps; start "sample" (sampling) and "report" only if `requested`."""
        has_files = {name: bool(campaign.select_files(name)) for name in STEPS}
        self.done = {name: step for name, step in self.done.items() if has_files.get(name, True)}
        self.messages = {"validate": WAITS} if has_files["validate"] else {}
        brake, calibrated_brake = campaign.brake, None
        if has_files["friction"]:
            brake = self._run_friction(campaign) or brake
        if has_files["calibrate"]:
            calibrated_brake = self._run_calibration(campaign, brake, "sample" in requested)
        if has_files["calibrate"] and calibrated_brake is None:
            self.done.pop("validate", None)
        elif has_files["validate"]:
            self._run_step(campaign, campaign.validation(calibrated_brake or brake))
        report = campaign.report()
        if "report" in requested or self._cached_step(report):
            self._run_step(campaign, report)
        else:
            self.done.pop("report", None)

    def _run_friction(self, campaign: Campaign) -> Subject | None:
        for call in campaign.friction():
            step = self._run_step(campaign, call)
            if step.result is not None:
                break
        return _written_brake(step)

    def _run_calibration(self, campaign: Campaign, brake: Subject, sample: bool) -> Subject | None:
        call = campaign.calibration(brake)
        if call.options.get("depth") == "bayesian" and not (sample or self._cached_step(call)):
            self.done.pop("calibrate", None)
            self.messages["calibrate"] = SAMPLE
            return None
        return _written_brake(self._run_step(campaign, call))

    def _cached_step(self, call: Call) -> StepResult | None:
        return next((step for step in self._known if step.call == call), None)

    def _run_step(self, campaign: Campaign, call: Call) -> StepResult:
        """Compute a step unless its result, which may be an error, is cached."""
        step = self._cached_step(call)
        if step is None:
            # also discard the dependent steps, which would appear to belong to the new result
            steps = (*STEPS, "report")
            for name in steps[steps.index(call.name) :]:
                self.done.pop(name, None)
            self.messages[call.name] = STOPPED
            step = run_call(call, campaign.folder, campaign.tell)
            if step.result is not None and call.name in STEPS:
                self.done[call.name] = step  # the numbers are shown while the figure is drawn
                campaign.tell(f"{call.name}: drawing", 1.0)
                step = replace(step, picture=draw_picture(call.name, step.result))
            self._known = [*self._known[1 - KEPT :], step]
        self.messages.pop(call.name, None)
        self.done[call.name] = step
        return step


def _written_brake(step: StepResult) -> Subject | None:
    return None if step.brake is None else Subject(step.call.out, step.brake)


def run_call(call: Call, folder: Path, progress: Progress) -> StepResult:
    """Run a call; return its result with the files that it writes, or its error.

    Other exceptions, such as a stop request, pass through.
    """

    def report(phase: str, share: float) -> None:
        progress(f"{call.name}: {phase}", share)

    place = folder / call.out
    out_options: dict[str, Any] = {"out": place, "overwrite": True} if call.out else {}
    if call.name == "report":
        out_options |= {"names": call.names, "command": call.command_line().splitlines()[-1]}
    try:
        result = call.run(progress=report, **out_options)
        if call.out and place.is_file():
            text = restore_names(place.read_text(encoding="utf-8"), call.names)
            return StepResult(call, result, BrakeFile.read(text, call.out))
        return StepResult(call, result, pages=read_report_files(place) if call.out else {})
    except LayerjamError as err:
        return StepResult(call, problem=one_line(err), notice=getattr(err, "notice", ""))
    finally:
        if call.name == "report":
            shutil.rmtree(place, ignore_errors=True)


def read_report_files(folder: Path) -> dict[str, bytes]:
    """Return {name: content} of a report's files."""
    paths = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def draw_picture(name: str, result: Any) -> str:
    """Return a result's figure as SVG in the page's colours."""
    with _drawing:
        return apply_theme(read_inline_svg(format_svg(result.draw(), words=True), name))


def file_stem(brake: Subject) -> str:
    """Return a brake's name as a safe file prefix, without the suffixes that steps add."""
    name = brake.name.removesuffix(".toml")
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:60] or "brake"
    return re.sub(r"(-tested|-calibrated)+$", "", stem) or "brake"


def split_roles(rows: Sequence[Row]) -> dict[str, dict[str, str]]:
    """Return the roles of pulls: calibration at the highest vacuum, validation at lower ones."""
    pulls = [r for r in rows if r.role in ("calibrate", "validate") and r.vacuum is not None]
    highest = max((r.vacuum or 0.0 for r in pulls), default=0.0)
    return {
        r.upload.key: {"role": "calibrate" if (r.vacuum or 0.0) > 0.97 * highest else "validate"}
        for r in pulls
    }
