"""Friction, then calibration, then validation: each on the brake that the one before has made."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from layerjam.device.file import BrakeFile
from layerjam.errors import LayerjamError
from layerjam.workbench.call import Subject
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.pages.laboratory_results import picture_of
from layerjam.workbench.pages.laboratory_steps import (
    Done,
    Step,
    Used,
    pages_of,
    stem_of,
    written,
)

Tell = Callable[[str, float], None]
Option = tuple[str, str | bool | tuple[str, ...]]


@dataclass(frozen=True)
class Asked:
    """What the page's controls say, in the words of the verbs."""

    standard: str = "paper"
    accept_stick_slip: bool = False
    depth: str = "exact"
    free: tuple[str, ...] = ()

    def of_friction(self) -> tuple[Option, ...]:
        """Options of `friction` that differ from its own."""
        made: list[Option] = []
        if self.standard != "paper":
            made.append(("standard", self.standard))
        if self.accept_stick_slip:
            made.append(("accept_stick_slip", True))
        return tuple(made)

    def of_calibration(self) -> tuple[Option, ...]:
        """Options of `calibrate` that differ from its own."""
        made: list[Option] = [("depth", self.depth)] if self.depth != "exact" else []
        if self.free and self.depth == "curves":
            made.append(("free", self.free))
        return tuple(made)


@dataclass
class Chain:
    """The steps that were computed last; a step whose inputs stand is not computed again."""

    done: dict[str, Done] = field(default_factory=dict)
    instead: dict[str, str] = field(default_factory=dict)
    sampled: Step | None = None
    """The Bayesian calibration that was asked for: it takes minutes and is never begun unasked."""

    def run(
        self, rows: Sequence[Row], brake: Subject, name: str, asked: Asked, folder: Path,
        tell: Tell, sample: bool = False,
    ) -> None:  # fmt: skip
        """Bring all steps up to date. `brake` is the desk's, `name` what its file is called."""
        stem, given = stem_of(name), brake
        if brake.name in (f"{stem}-tested.toml", f"{stem}-calibrated.toml"):
            stem += "-again"  # what is written does not take the place of what it is made from
        self.instead = {}
        waits = "It waits for the calibration."
        self.instead |= {"validate": waits} if used(rows, "validate") else {}
        self._friction(used(rows, "friction"), brake, stem, asked, folder, tell)
        tested = self.done.get("friction")
        if tested is not None and tested.brake is not None:
            brake = Subject(tested.step.out, tested.brake)
        files = used(rows, "calibrate")
        made = brake is not given
        self._calibration(files, brake, made, stem, asked, folder, tell, sample)
        fitted = self.done.get("calibrate")
        if fitted is not None and fitted.brake is not None:
            brake = Subject(fitted.step.out, fitted.brake)
        lacking = bool(files) and (fitted is None or fitted.brake is None)
        files = used(rows, "validate")
        if lacking or not files:
            self._none("validate", waits if files else "")
        else:
            step = Step("validate", (("", files),), brake, edited=_edited(files),
                        made=brake is not given)  # fmt: skip
            self._do(step, folder, tell)

    def _friction(
        self, files: tuple[Used, ...], brake: Subject, stem: str, asked: Asked, folder: Path,
        tell: Tell,
    ) -> None:  # fmt: skip
        if not files:
            self._none("friction", "")
            return
        alone = Step("friction", (("", files),), None, asked.of_friction(),
                     edited=_edited(files))  # fmt: skip
        step = replace(alone, brake=brake, out=f"{stem}-tested.toml",
                       options=(*alone.options, ("partial", True)))  # fmt: skip
        known = self.done.get("friction")
        juddered = known is not None and known.answer and known.answer.values["kinetic"] is None
        if known is not None and juddered and known.step == alone:
            return
        self._do(step, folder, tell)
        if self.done["friction"].answer is None:
            self._do(alone, folder, tell)  # judder: numbers, and no kinetic friction to write

    def _calibration(
        self, files: tuple[Used, ...], brake: Subject, made: bool, stem: str, asked: Asked,
        folder: Path, tell: Tell, sample: bool,
    ) -> None:  # fmt: skip
        if not files:
            self._none("calibrate", "")
            return
        step = Step("calibrate", (("", files),), brake,
                    (*asked.of_calibration(), ("partial", True)), f"{stem}-calibrated.toml",
                    edited=_edited(files), made=made)  # fmt: skip
        if asked.depth == "bayesian":
            self.sampled = step if sample else self.sampled
            if self.sampled != step:
                self._none("calibrate", "Sampling takes minutes: press 'Sample' to begin.")
                return
        self._do(step, folder, tell)

    def _none(self, verb: str, why: str) -> None:
        self.done.pop(verb, None)
        if why:
            self.instead[verb] = why

    def _do(self, step: Step, folder: Path, tell: Tell) -> None:
        """Compute a step unless it was; a refusal is a result too."""
        known = self.done.get(step.verb)
        if known is not None and known.step == step and (known.picture or known.answer is None):
            return
        self.done.pop(step.verb, None)
        self.instead[step.verb] = "It was stopped before it was done."
        begun, self.sampled = self.sampled, None  # sampling that is stopped is not begun unasked
        made = self.done[step.verb] = carried_out(step, folder, tell)
        self.sampled = begun
        self.instead.pop(step.verb)
        if made.answer is not None:  # the numbers are shown while the figure is drawn
            tell(f"{step.verb}: drawing", 1.0)
            self.done[step.verb] = replace(made, picture=picture_of(step.verb, made.answer))


def carried_out(step: Step, folder: Path, tell: Tell) -> Done:
    """A step's answer and brake, or its refusal. Stopped and the like pass through."""
    try:
        answer = step.run(folder, lambda what, share: tell(f"{step.verb}: {what}", share))
        text = written(step, folder)
        brake = BrakeFile.read(text, step.out) if text else None
        return Done(step, answer, text, brake)
    except LayerjamError as err:
        return Done(step, problem=" ".join(str(err).split()))


def report(
    rows: Sequence[Row], brake: Subject, name: str, asked: Asked, folder: Path, tell: Tell
) -> Done:
    """The report of all files as pages; raises LayerjamError."""
    taken = (("friction", "friction"), ("pulls", "calibrate"), ("validate", "validate"))
    files = tuple((option, used(rows, role)) for option, role in taken if used(rows, role))
    options = [*asked.of_friction()]
    options += [("depth", asked.depth)] if asked.depth != "exact" else []
    step = Step("report", files, brake, tuple(options), f"{stem_of(name)}-report",
                edited=any_edited(rows))  # fmt: skip
    place = folder / step.out
    shutil.rmtree(place, ignore_errors=True)
    try:
        answer = step.run(folder, tell)
        return Done(step, answer, pages=pages_of(place))
    finally:
        shutil.rmtree(place, ignore_errors=True)


def used(rows: Sequence[Row], role: str) -> tuple[Used, ...]:
    """The files that a step takes."""
    return tuple(Used(r.upload, r.sidecar, r.edited) for r in rows if r.good and r.role == role)


def any_edited(rows: Sequence[Row]) -> bool:
    """Whether the page wrote a sidecar of a file that is used."""
    return any(r.edited and r.good for r in rows)


def _edited(files: Sequence[Used]) -> bool:
    return any(f.edited for f in files)


def taken_roles(rows: Sequence[Row]) -> Mapping[str, str]:
    """Of the pulls, those at the highest vacuum to calibrate on, the others to validate on."""
    pulls = [r for r in rows if r.role in ("calibrate", "validate") and r.vacuum is not None]
    most = max((r.vacuum or 0.0 for r in pulls), default=0.0)
    return {
        r.upload.key: "calibrate" if (r.vacuum or 0.0) > 0.97 * most else "validate" for r in pulls
    }
