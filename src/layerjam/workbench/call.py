"""One question as a page asks it, and as Python and the command line would."""

from __future__ import annotations

import importlib
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.answer import Answer
from layerjam.device.file import BrakeFile
from layerjam.fluid.file import LineFile

if TYPE_CHECKING:
    from layerjam.design.requirements import DesignSpecification

VERBS = {
    "show": "predict", "force": "predict", "vacuum": "predict", "tensile": "tensile",
    "drop": "impact", "tune": "tuning", "stick_slip": "stick_slip", "rise": "vacuum_line",
    "regulate": "regulate", "follow": "follow", "plan": "plan", "friction": "friction",
    "calibrate": "calibration", "validate": "validation", "pull": "pull", "design": "design",
    "compare": "compare", "array": "array", "apply": "apply",
}  # fmt: skip
"""Verb and the module of `layerjam.commands` it lives in."""


PYTHON = 'import jax, layerjam\njax.config.update("jax_enable_x64", True)\n'
"""How copied Python begins."""


@dataclass(frozen=True)
class Subject:
    """A brake or line: how the user names it, and the object where it is not the catalogue's."""

    name: str
    file: BrakeFile | LineFile | DesignSpecification | None = None


@dataclass(frozen=True)
class DataFile:
    """A measured file: the user's name for it, and where its bytes are."""

    shown: str
    path: Path


@dataclass(frozen=True)
class Call:
    """A verb with its subjects, measured files and options.

    Options are texts with units, numbers, or flags; what is copied names files as the user does.
    """

    verb: str
    subjects: tuple[Subject, ...] = ()
    options: Mapping[str, str | float | bool] = field(default_factory=dict)
    files: tuple[DataFile, ...] = ()

    def run(self, **more: Any) -> Answer:
        """The answer; raises LayerjamError as the verb does."""
        where = VERBS[self.verb]
        home = "layerjam.studies.machines" if where == "apply" else "layerjam.commands"
        module = importlib.import_module(f"{home}.{where}")
        things: list[Any] = [s.name if s.file is None else s.file for s in self.subjects]
        if self.files:
            things.append([file.path for file in self.files])
        made: Answer = getattr(module, self.verb)(*things, **self.options, **more)
        return made

    def python(self) -> str:
        """Three lines that give the same numbers; an edited brake is the file that was saved."""
        parts = [repr(s.name) for s in self.subjects]
        if self.files:
            parts.append(repr([file.shown for file in self.files]))
        parts += [f"{key}={value!r}" for key, value in self.options.items()]
        inside = ", ".join(parts).replace("'", '"')
        return PYTHON + f"print(layerjam.{self.verb}({inside}).values)\n"

    def command(self) -> str:
        """The same on the command line."""
        words = ["layerjam", self.verb.replace("_", "-"), *(s.name for s in self.subjects)]
        words += [file.shown for file in self.files]
        for key, value in self.options.items():
            if value is False:
                continue
            words.append("--" + key.replace("_", "-"))
            if value is not True:
                words.append(str(value))
        return " ".join(shlex.quote(word) for word in words)
