"""Friction, then calibration, then validation: each on the brake that the one before has made."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from layerjam.device.file import BrakeFile
from layerjam.errors import LayerjamError
from layerjam.workbench.call import Call, DataFile, Options, Subject
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.pages.laboratory_results import picture_of
from layerjam.workbench.pages.laboratory_steps import Done, pages_of, stem_of, written
from layerjam.workbench.widgets import one_line

Tell = Callable[[str, float], None]
SAMPLE = "Sampling takes minutes: press 'Sample' to begin."


@dataclass(frozen=True)
class Asked:
    """What the page's controls say, in the words of the commands."""

    standard: str = "paper"
    accept_stick_slip: bool = False
    depth: str = "exact"
    free: tuple[str, ...] = ()

    def of_friction(self) -> Options:
        """Options of `friction` that differ from its own."""
        made: Options = {} if self.standard == "paper" else {"standard": self.standard}
        return made | ({"accept_stick_slip": True} if self.accept_stick_slip else {})

    def of_calibration(self) -> Options:
        """Options of `calibrate` that differ from its own."""
        made: Options = {} if self.depth == "exact" else {"depth": self.depth}
        return made | ({"free": self.free} if self.free and self.depth == "curves" else {})


@dataclass(frozen=True)
class Campaign:
    """What the chain is computed from: files, the desk's brake and its name, what is asked."""

    rows: Sequence[Row]
    brake: Subject
    name: str
    asked: Asked
    folder: Path
    tell: Tell

    def used(self, role: str) -> tuple[DataFile, ...]:
        """The files that a step takes."""
        return tuple(r.data for r in self.rows if r.good and r.role == role)

    @property
    def stem(self) -> str:
        """The name that files written here begin with."""
        stem = stem_of(self.name)
        if self.brake.name in (f"{stem}-tested.toml", f"{stem}-calibrated.toml"):
            return f"{stem}-again"  # what is written does not replace what it is made from
        return stem


@dataclass
class Chain:
    """The steps that were computed last; a step whose inputs stand is not computed again."""

    done: dict[str, Done] = field(default_factory=dict)
    instead: dict[str, str] = field(default_factory=dict)
    sampled: Call | None = None
    """The Bayesian calibration that was asked for: it takes minutes and is never begun unasked."""

    def run(self, given: Campaign, sample: bool = False) -> None:
        """Bring all steps up to date."""
        waits = "It waits for the calibration."
        self.instead = {"validate": waits} if given.used("validate") else {}
        self._friction(given)
        brake = self._written("friction") or given.brake
        self._calibration(given, brake, sample)
        fitted = self._written("calibrate")
        files = given.used("validate")
        if not files or (given.used("calibrate") and fitted is None):
            self._none("validate", waits if files else "")
            return
        brake = fitted or brake
        self._do(given, Call("validate", (brake,), files=files, made=brake is not given.brake))

    def _written(self, name: str) -> Subject | None:
        """The brake that a step wrote."""
        step = self.done.get(name)
        return None if step is None or step.brake is None else Subject(step.call.out, step.brake)

    def _friction(self, given: Campaign) -> None:
        files = given.used("friction")
        if not files:
            self._none("friction", "")
            return
        alone = Call("friction", options=given.asked.of_friction(), files=files)
        more: Options = {"brake": given.brake, "partial": True}
        options = {**alone.options, **more}
        writing = replace(alone, options=options, out=f"{given.stem}-tested.toml")
        known = self.done.get("friction")
        sticks = known is not None and known.result is not None and known.result.kinetic is None
        if sticks and known is not None and known.call == alone:
            return
        self._do(given, writing)
        if self.done["friction"].result is None:
            self._do(given, alone)  # stick–slip: numbers, and no kinetic friction to write

    def _calibration(self, given: Campaign, brake: Subject, sample: bool) -> None:
        files = given.used("calibrate")
        if not files:
            self._none("calibrate", "")
            return
        options = {**given.asked.of_calibration(), "partial": True}
        out, made = f"{given.stem}-calibrated.toml", brake is not given.brake
        step = Call("calibrate", (brake,), options, files, out, made)
        if given.asked.depth == "bayesian":
            self.sampled = step if sample else self.sampled
            if self.sampled != step:
                self._none("calibrate", SAMPLE)
                return
        self._do(given, step)

    def _none(self, name: str, why: str) -> None:
        self.done.pop(name, None)
        if why:
            self.instead[name] = why

    def _do(self, given: Campaign, step: Call) -> None:
        """Compute a step unless it was; a refusal is a result too."""
        known = self.done.get(step.name)
        if known is not None and known.call == step and (known.picture or known.result is None):
            return
        self.done.pop(step.name, None)
        self.instead[step.name] = "It was stopped before it was done."
        begun, self.sampled = self.sampled, None  # sampling that is stopped is not begun unasked
        made = self.done[step.name] = carried_out(step, given.folder, given.tell)
        self.sampled = begun
        self.instead.pop(step.name)
        if made.result is not None:  # the numbers are shown while the figure is drawn
            given.tell(f"{step.name}: drawing", 1.0)
            self.done[step.name] = replace(made, picture=picture_of(step.name, made.result))


def carried_out(step: Call, folder: Path, tell: Tell) -> Done:
    """A step's result and brake, or its refusal. Stopped and the like pass through."""

    def told(what: str, share: float) -> None:
        tell(f"{step.name}: {what}", share)

    more = {"out": folder / step.out, "force": True} if step.out else {}
    try:
        result = step.run(progress=told, **more)
        text = written(step, folder)
        brake = BrakeFile.read(text, step.out) if text else None
        return Done(step, result, text, brake)
    except LayerjamError as err:
        return Done(step, problem=one_line(err))


def report(given: Campaign) -> Done:
    """The report of all files as pages; raises LayerjamError."""
    taken = (("friction", "friction"), ("pulls", "calibrate"), ("validate", "validate"))
    files: Options = {key: given.used(role) for key, role in taken if given.used(role)}
    asked = given.asked
    depth: Options = {} if asked.depth == "exact" else {"depth": asked.depth}
    options = {**files, **asked.of_friction(), **depth}
    step = Call("report", (given.brake,), options, out=f"{stem_of(given.name)}-report")
    place = given.folder / step.out
    shutil.rmtree(place, ignore_errors=True)
    try:
        about = {"names": step.names, "command": step.command().splitlines()[-1]}
        result = step.run(out=place, force=True, progress=given.tell, **about)
        return Done(step, result, pages=pages_of(place))
    finally:
        shutil.rmtree(place, ignore_errors=True)


def taken_roles(rows: Sequence[Row]) -> Mapping[str, str]:
    """Of the pulls, those at the highest vacuum to calibrate on, the others to validate on."""
    pulls = [r for r in rows if r.role in ("calibrate", "validate") and r.vacuum is not None]
    most = max((r.vacuum or 0.0 for r in pulls), default=0.0)
    return {
        r.upload.key: "calibrate" if (r.vacuum or 0.0) > 0.97 * most else "validate" for r in pulls
    }
