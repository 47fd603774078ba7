"""Friction, then calibration, then validation: each on the brake that the one before has made.

A report of them all is made where it is asked for.
"""

import re
import shutil
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from layerjam.commands.declare import Progress
from layerjam.device.file import BrakeFile
from layerjam.errors import LayerjamError
from layerjam.report.page import svg_of, themed
from layerjam.report.style import drawn
from layerjam.workbench.call import Call, DataFile, Options, Subject, parameters
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.uploads import in_users_toml
from layerjam.workbench.widgets import one_line

STEPS = ("friction", "calibrate", "validate")
SAMPLE = "Sampling takes minutes: press 'Sample' to begin."
WAITS = "It waits for the calibration."
STOPPED = "It was stopped before it was done."
KEPT = 12
"""Results that are kept: what was asked before is not computed again."""
_drawing = threading.Lock()
"""Matplotlib's settings are the process's: one figure at a time."""


@dataclass(frozen=True)
class Done:
    """A call that was computed: its result and picture (SVG), the brake it wrote; or why not."""

    call: Call
    result: Any = None
    brake: BrakeFile | None = None
    picture: str = ""
    problem: str = ""
    pages: Mapping[str, bytes] = field(default_factory=dict)
    """Files of a report."""


@dataclass(frozen=True)
class Campaign:
    """What the chain is computed from: files, the desk's brake, and options of the commands."""

    rows: Sequence[Row]
    brake: Subject
    asked: Options
    folder: Path
    tell: Progress

    def used(self, role: str) -> tuple[DataFile, ...]:
        """The files that a step takes."""
        return tuple(r.upload for r in self.rows if r.good and r.role == role)

    def options(self, command: str) -> Options:
        """What is asked of a command, where it differs from what that does by itself."""
        known = parameters(command)
        return {k: v for k, v in self.asked.items() if k in known and v != known[k].default}

    @property
    def stem(self) -> str:
        """The name that files written here begin with."""
        stem = stem_of(self.brake)
        if self.brake.name in (f"{stem}-tested.toml", f"{stem}-calibrated.toml"):
            return f"{stem}-again"  # what is written does not replace what it is made from
        return stem

    def friction(self) -> list[Call]:
        """The tests with the brake that takes them over, and alone, for such as stick and slip."""
        files, own = self.used("friction"), self.options("friction")
        writing: Options = {**own, "brake": self.brake, "partial": True}
        return [
            Call("friction", options=writing, files=files, out=f"{self.stem}-tested.toml"),
            Call("friction", options=own, files=files),
        ]

    def calibration(self, brake: Subject) -> Call:
        """A brake fitted to its pulls."""
        options = {**self.options("calibrate"), "partial": True}
        out, made = f"{self.stem}-calibrated.toml", brake is not self.brake
        return Call("calibrate", (brake,), options, self.used("calibrate"), out, made)

    def validation(self, brake: Subject) -> Call:
        """A brake beside pulls that were held back."""
        files, made = self.used("validate"), brake is not self.brake
        return Call("validate", (brake,), self.options("validate"), files, made=made)

    def report(self) -> Call:
        """All files as pages."""
        taken = (("friction", "friction"), ("pulls", "calibrate"), ("validate", "validate"))
        files: Options = {key: self.used(role) for key, role in taken if self.used(role)}
        options = {**files, **self.options("report")}
        return Call("report", (self.brake,), options, out=f"{stem_of(self.brake)}-report")


class Chain:
    """The steps as they were computed last: `done`, or a sentence `instead`, by their names.

    A step that was computed before is not computed again.
    """

    def __init__(self) -> None:
        self.done: dict[str, Done] = {}
        self.instead: dict[str, str] = {}
        self._known: list[Done] = []

    def run(self, given: Campaign, *wanted: str) -> None:
        """Bring all steps up to date; "sample" and "report" are begun only where `wanted`."""
        there = {name: bool(given.used(name)) for name in STEPS}
        self.done = {name: done for name, done in self.done.items() if there.get(name, True)}
        self.instead = {"validate": WAITS} if there["validate"] else {}
        brake, fitted = given.brake, None
        if there["friction"]:
            brake = self._friction(given) or brake
        if there["calibrate"]:
            fitted = self._calibration(given, brake, "sample" in wanted)
        if there["calibrate"] and fitted is None:
            self.done.pop("validate", None)
        elif there["validate"]:
            self._do(given, given.validation(fitted or brake))
        report = given.report()
        if "report" in wanted or self._before(report):
            self._do(given, report)
        else:
            self.done.pop("report", None)

    def _friction(self, given: Campaign) -> Subject | None:
        for call in given.friction():
            done = self._do(given, call)
            if done.result is not None:
                break
        return _written(done)

    def _calibration(self, given: Campaign, brake: Subject, sample: bool) -> Subject | None:
        call = given.calibration(brake)
        if call.options.get("depth") == "bayesian" and not (sample or self._before(call)):
            self.done.pop("calibrate", None)
            self.instead["calibrate"] = SAMPLE
            return None
        return _written(self._do(given, call))

    def _before(self, call: Call) -> Done | None:
        return next((done for done in self._known if done.call == call), None)

    def _do(self, given: Campaign, call: Call) -> Done:
        """Compute a step unless it was; a refusal is a result too."""
        made = self._before(call)
        if made is None:
            # a step that rests on this one goes too: copied, it would rest on the new one
            steps = (*STEPS, "report")
            for name in steps[steps.index(call.name) :]:
                self.done.pop(name, None)
            self.instead[call.name] = STOPPED
            made = carried_out(call, given.folder, given.tell)
            if made.result is not None and call.name in STEPS:
                self.done[call.name] = made  # the numbers are shown while the figure is drawn
                given.tell(f"{call.name}: drawing", 1.0)
                made = replace(made, picture=picture_of(call.name, made.result))
            self._known = [*self._known[1 - KEPT :], made]
        self.instead.pop(call.name, None)
        self.done[call.name] = made
        return made


def _written(done: Done) -> Subject | None:
    return None if done.brake is None else Subject(done.call.out, done.brake)


def carried_out(call: Call, folder: Path, tell: Progress) -> Done:
    """A call's result with what it wrote, or its refusal. Stopped and the like pass through."""

    def told(what: str, share: float) -> None:
        tell(f"{call.name}: {what}", share)

    place = folder / call.out
    more: dict[str, Any] = {"out": place, "overwrite": True} if call.out else {}
    if call.name == "report":
        more |= {"names": call.names, "command": call.command().splitlines()[-1]}
    try:
        result = call.run(progress=told, **more)
        if call.out and place.is_file():
            text = in_users_toml(place.read_text(encoding="utf-8"), call.names)
            return Done(call, result, BrakeFile.read(text, call.out))
        return Done(call, result, pages=pages_of(place) if call.out else {})
    except LayerjamError as err:
        return Done(call, problem=one_line(err))
    finally:
        if call.name == "report":
            shutil.rmtree(place, ignore_errors=True)


def pages_of(folder: Path) -> dict[str, bytes]:
    """The files of a report by name."""
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def picture_of(name: str, result: Any) -> str:
    """The figure of a result as SVG whose colours follow the page."""
    with _drawing:
        return themed(svg_of(drawn(result.draw(), words=True), name))


def stem_of(brake: Subject) -> str:
    """The name that files of a brake begin with: safe in a path, without what steps append."""
    name = brake.name.removesuffix(".toml")
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:60] or "brake"
    return re.sub(r"(-tested|-calibrated)+$", "", plain) or "brake"


def taken_roles(rows: Sequence[Row]) -> dict[str, dict[str, str]]:
    """Of the pulls, those at the highest vacuum to calibrate on, the others to validate on."""
    pulls = [r for r in rows if r.role in ("calibrate", "validate") and r.vacuum is not None]
    most = max((r.vacuum or 0.0 for r in pulls), default=0.0)
    return {
        r.upload.key: {"role": "calibrate" if (r.vacuum or 0.0) > 0.97 * most else "validate"}
        for r in pulls
    }
