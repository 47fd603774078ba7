"""What the laboratory computes: friction, calibration, validation, report, each as a verb's call.

A step's files lie under made-up names; what is shown and copied names them as the user does.
"""

from __future__ import annotations

import importlib
import json
import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from layerjam.commands.results import Result
from layerjam.device.file import BrakeFile
from layerjam.errors import LayerjamError
from layerjam.identify.provenance import renamed
from layerjam.workbench.call import VERBS, Subject
from layerjam.workbench.uploads import Upload, in_users_toml

NOTE = "the sidecars NAME.toml lie beside the files: the page's button 'Sidecars' downloads them"
"""Above what is copied, where the page wrote facts or answers of its own."""


@dataclass(frozen=True)
class Used:
    """A file of a step, and the text of its sidecar, on which the result depends as well."""

    upload: Upload
    sidecar: str
    edited: bool = False
    """Whether the page wrote the sidecar."""


@dataclass(frozen=True)
class Step:
    """A verb on files. Two equal steps give the same numbers.

    `files` maps an option ("" for the files that stand alone) to what it takes; `out` is the file
    or folder that is written, as the user would call it; `brake` is written with `first` unset
    where it is an option and not the subject.
    """

    verb: str
    files: tuple[tuple[str, tuple[Used, ...]], ...]
    brake: Subject | None = None
    options: tuple[tuple[str, str | bool | tuple[str, ...]], ...] = ()
    out: str = ""
    edited: bool = False
    """Whether the page wrote sidecars."""
    made: bool = False
    """Whether the brake's file is written by the step before."""

    @property
    def subjects(self) -> tuple[Subject, ...]:
        """The brake the user has to save; none where a step before writes it."""
        return () if self.brake is None or self.made else (self.brake,)

    @property
    def names(self) -> dict[str, str]:
        """{made-up name: the user's}."""
        return {u.upload.path.name: u.upload.name for _, some in self.files for u in some}

    def run(self, folder: Path | None, progress: Callable[[str, float], None]) -> Result:
        """The answer in the user's words; what is written goes into `folder` (made up).

        Raises LayerjamError as the verb does, with the user's names in it.
        """
        verb = getattr(importlib.import_module(f"layerjam.commands.{self._module}"), self.verb)
        subject = self.brake and (self.brake.file or self.brake.name)
        more: dict[str, Any] = dict(self.options)
        args: list[Any] = [subject] if subject and not self._brake_is_option else []
        if subject and self._brake_is_option:
            more["brake"] = subject
        for option, some in self.files:
            paths = [u.upload.path for u in some]
            if option:
                more[option] = paths
            else:
                args.append(paths)
        if self.out and folder is not None:
            more |= {"out": folder / self.out, "force": True}
        if self.verb == "report":
            more |= {"names": self.names, "command": self.command()}
        try:
            answer: Result = verb(*args, progress=progress, **more)
        except LayerjamError as error:
            raise LayerjamError(renamed(str(error), self.names)) from None
        names = {**self.names, self.out: self.out} if self.out else self.names
        said = dict.fromkeys(renamed(list(answer.warnings), names))
        return replace(answer, **renamed(dict(answer.values), names), warnings=tuple(said))

    @property
    def _module(self) -> str:
        return VERBS.get(self.verb, self.verb)

    @property
    def _brake_is_option(self) -> bool:
        return self.verb == "friction"

    def python(self) -> str:
        """Lines that give the same numbers from the user's files."""
        parts = [_said(self.brake.name)] if self.brake and not self._brake_is_option else []
        for option, some in self.files:
            names = _said([u.upload.name for u in some])
            parts.append(f"{option}={names}" if option else names)
        if self.brake and self._brake_is_option:
            parts.append(f"brake={_said(self.brake.name)}")
        parts += [f"{key}={_said(value)}" for key, value in self.options]
        parts += [f"out={_said(self.out)}"] if self.out else []
        head = f"# {NOTE}\n" if self.edited else ""
        return (
            f"{head}import layerjam\n\nanswer = layerjam.{self.verb}({', '.join(parts)})\n"
            "print(answer.values)\n"
        )

    def command(self) -> str:
        """The same on the command line."""
        words = ["layerjam", self.verb]
        words += [self.brake.name] if self.brake and not self._brake_is_option else []
        for option, some in self.files:
            words += [f"--{option}"] if option else []
            words += [f"./{n}" if n.startswith("-") else n for n in (u.upload.name for u in some)]
        if self.brake and self._brake_is_option:
            words += ["--brake", self.brake.name]
        for key, value in self.options:
            if isinstance(value, tuple):
                words += [w for v in value for w in (f"--{key.replace('_', '-')}", v)]
            elif value is not False:
                words.append("--" + key.replace("_", "-"))
                words += [] if value is True else [str(value)]
        words += ["--out", self.out] if self.out else []
        line = " ".join(shlex.quote(word) for word in words)
        return f"# {NOTE}\n{line}" if self.edited and self.verb != "report" else line


def _said(value: object) -> str:
    """A Python literal with double quotes."""
    if isinstance(value, bool):
        return repr(value)
    if isinstance(value, tuple | list):
        inside = ", ".join("None" if v == "" else _said(v) for v in value)
        alone = "," if isinstance(value, tuple) and len(value) == 1 else ""
        return f"[{inside}]" if isinstance(value, list) else f"({inside}{alone})"
    return json.dumps(value, ensure_ascii=False)


@dataclass(frozen=True)
class Done:
    """A step that was computed: its answer and picture (SVG), the brake it wrote; or why not."""

    step: Step
    answer: Result | None = None
    text: str = ""
    brake: BrakeFile | None = None
    picture: str = ""
    problem: str = ""
    pages: Mapping[str, bytes] = field(default_factory=dict)
    """Files of a report."""


def stem_of(name: str) -> str:
    """The name that files of this brake begin with: safe in a path, without what steps append."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-")[:60] or "brake"
    return re.sub(r"(-tested|-calibrated)+$", "", plain) or "brake"


def written(step: Step, folder: Path) -> str:
    """The brake that a step wrote, in the user's words; "" where it wrote none."""
    path = folder / step.out
    if not step.out or not path.is_file():
        return ""
    return in_users_toml(path.read_text(encoding="utf-8"), step.names)


def pages_of(folder: Path) -> dict[str, bytes]:
    """The files of a report by name."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*")) if path.is_file()
    }  # fmt: skip
