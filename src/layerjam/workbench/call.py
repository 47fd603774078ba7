"""A page's request, as a Python call and as a command line."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.command.declare import load_command
from layerjam.core.errors import LayerjamError, Notice
from layerjam.core.outputs import field_key
from layerjam.core.system import format_command_line
from layerjam.laboratory.identify.provenance import rename_files

if TYPE_CHECKING:
    from layerjam.core.command.declare import Parameter
    from layerjam.workshop.design.requirements import DesignSpecification

NOTE = (
    "save the NAME.toml sidecars in the same folder as the files; "
    "download them with the 'Sidecars' button"
)
"""Comment above the copied code if the page added metadata or corrections."""


@dataclass(frozen=True)
class Subject:
    """A brake, line or specification: its name, and its content unless it is in the catalogue."""

    name: str
    file: "BrakeFile | LineFile | DesignSpecification | None" = None
    needs: tuple[tuple[str, str], ...] = ()
    """(name, content) of each file that it refers to and that is not in the catalogue."""

    @property
    def text(self) -> str:
        """Return the name in the catalogue, or the TOML text."""
        return self.name if self.file is None else self.file.text


@dataclass(frozen=True)
class DataFile:
    """A measured file: the user's name for it, the path of its bytes, and its sidecar's text.

    `edited` is true if the page wrote the sidecar. Files that compare equal yield the same numbers.
    """

    shown: str
    path: Path
    sidecar: str = ""
    edited: bool = False


Value = str | float | bool | Subject | DataFile | tuple[str, ...] | tuple[DataFile, ...]
Options = dict[str, Value]


@dataclass(frozen=True)
class Call:
    """A command with its subjects, measured files and options.

    Calls that compare equal yield the same result.

    Options are numbers, texts with units, flags, choices, or files and subjects that are not
    positional arguments. `out` is the file or folder to write, as the user would name it; copied
    code overwrites it on each run. If `made` is true, the previous call writes the subject's file.
    """

    name: str
    subjects: tuple[Subject, ...] = ()
    options: Mapping[str, Value] = field(default_factory=dict)
    files: tuple[DataFile, ...] = ()
    out: str = ""
    made: bool = False

    @property
    def data(self) -> tuple[DataFile, ...]:
        """Return all measured files."""
        tuples = [v for v in (*self.options.values(), self.files) if isinstance(v, tuple)]
        single_files = [v for v in self.options.values() if isinstance(v, DataFile)]
        return (*single_files, *(f for group in tuples for f in group if isinstance(f, DataFile)))

    @property
    def names(self) -> dict[str, str]:
        """Return {stored name of a file: the user's name for it}."""
        return {file.path.name: file.shown for file in self.data}

    def run(self, function: Callable[..., Any] | None = None, **more: Any) -> Any:
        """Run the command, and return its result with the user's file names.

        Raises the same LayerjamError as the command.

        `function` runs instead of the command if only a part of the result is needed.
        """
        try:
            result = (function or load_command(self.name))(
                *(_python_value(v) for v in self._positional_values()),
                **{key: _python_value(v) for key, v in self.options.items()},
                **more,
            )
        except LayerjamError as error:
            if not self.names:
                raise
            raise _restore_names(error, self.names) from None
        names = self.names | ({self.out: self.out} if self.out else {})
        return _rename_in_result(result, names) if names else result

    def _positional_values(self) -> Iterator[Value]:
        yield from self.subjects
        if self.files:
            yield self.files

    def python_code(self) -> str:
        """Return code that reproduces the numbers in a new process."""
        return python_code([self])

    def python_expression(self) -> str:
        """Return the call as a Python expression that refers to files by name."""
        parts = [_python_literal(_plain_value(v)) for v in self._positional_values()]
        parts += [f"{key}={_python_literal(_plain_value(v))}" for key, v in self.options.items()]
        parts += [f"out={_python_literal(self.out)}", "overwrite=True"] if self.out else []
        return f"lj.{load_command(self.name).python_name}({', '.join(parts)})"

    def _python_block(self, file: str, others: "Mapping[str, Call]", display: bool) -> str:
        """Return code that computes, prints and draws the result; `display` also shows it."""
        text = f"result = {self.python_expression()}\nprint(result)\n"
        kind = load_command(self.name).result
        if not kind.is_drawable():
            return text
        options = "overwrite=True"
        if others:
            options += ", beside=pinned"
            pins = "".join(
                f"    {_python_literal(k)}: {call.python_expression()},\n"
                for k, call in others.items()
            )
            text += f"pinned = {{\n{pins}}}\n"
        draws = [f'result.plot("{file}.svg", {options})']
        draws += [f'display(SVG("{file}.svg"))'] if display else []
        if any(f.name == "feasible" for f in kind.keys()):  # noqa: SIM118 (it may say "cannot")
            draws = ["if result.has_curve:", *(f"    {line}" for line in draws)]
        return text + "".join(f"{line}\n" for line in draws)

    def command_line(self) -> str:
        """Return the call as a command line."""
        words = ["layerjam", load_command(self.name).name]
        for value in self._positional_values():
            words += _cli_words(_plain_value(value))
        for key, value in self.options.items():
            spec = parameters(self.name)[key]
            if value is True:
                words.append(spec.option)
            elif spec.help.greedy:
                words += [spec.option, *_cli_words(_plain_value(value))]
            elif value is not False:
                words += [
                    w for text in _cli_words(_plain_value(value)) for w in (spec.option, text)
                ]
        words += ["--out", self.out, "--overwrite"] if self.out else []
        return _file_note([self]) + format_command_line(words)


def python_code(
    calls: Sequence[Call], pinned_calls: Mapping[str, Call] = MappingProxyType({})
) -> str:
    """Return code that reproduces the numbers and figures of several calls in a new process.

    `pinned_calls` are drawn, with their labels, in the figure of the first call that allows them.
    """
    head, *blocks = python_blocks(calls, pinned_calls)
    return f"{head}\n{''.join(blocks)}" if blocks else ""


def python_blocks(
    calls: Sequence[Call],
    pinned_calls: Mapping[str, Call] = MappingProxyType({}),
    display: bool = False,
) -> list[str]:
    """Return the parts of `python_code`: the imports, then the code of each call.

    With `display`, the code shows its figures using IPython's `display` and `SVG`.
    """
    names = [load_command(call.name).name for call in calls]
    every = [*calls, *pinned_calls.values()]
    parts, pending_calls = [f"{_file_note(every)}import layerjam as lj\n"], dict(pinned_calls)
    for place, call in enumerate(calls):
        lone = names.count(names[place]) == 1
        file = names[place] if lone else f"{names[place]}-{names[: place + 1].count(names[place])}"
        takes = load_command(call.name).result.can_overlay
        pins = {
            label: pin
            for label, pin in pending_calls.items()
            if takes(load_command(pin.name).result)
        }
        pending_calls = {label: pin for label, pin in pending_calls.items() if label not in pins}
        parts.append(call._python_block(file, pins, display))
    return parts


def _file_note(calls: Sequence[Call]) -> str:
    is_edited = any(file.edited for call in calls for file in call.data)
    return f"# {NOTE}\n" if is_edited else ""


@cache
def parameters(name: str) -> "Mapping[str, Parameter]":
    """Return {name: parameter} for a declared command."""
    return MappingProxyType({p.name: p for p in load_command(name).parameters})


@cache
def result_fields(name: str) -> Mapping[str, str]:
    """Return {key of a command's result: its description}."""
    keys = load_command(name).result.keys()
    return MappingProxyType({field_key(f): f.metadata["result"] for f in keys})


def warning_key(warning: str) -> str:
    """Return the key of a warning; empty if it has none."""
    return warning.key if isinstance(warning, Notice) else ""


def _python_value(value: Value) -> Any:
    if isinstance(value, Subject):
        return value.name if value.file is None else value.file
    if isinstance(value, DataFile):
        return value.path
    if isinstance(value, tuple):
        return [_python_value(item) for item in value]
    return value


def _plain_value(value: Value) -> str | float | bool | Sequence[str]:
    if isinstance(value, Subject):
        return value.name
    if isinstance(value, DataFile):
        return value.shown
    if isinstance(value, tuple):
        return [item if isinstance(item, str) else item.shown for item in value]
    return value


def _cli_words(value: str | float | bool | Sequence[str]) -> list[str]:
    """Return a value as command-line arguments; "./" precedes file names that start with a dash."""
    if isinstance(value, str | float | int):
        return [str(value)]
    return [f"./{word}" if word.startswith("-") else word for word in value]


def _python_literal(value: object) -> str:
    return repr(value) if isinstance(value, bool) else json.dumps(value, ensure_ascii=False)


def _restore_names(error: LayerjamError, names: Mapping[str, str]) -> LayerjamError:
    """Return a copy of the error with the user's file names."""
    copy = error.__class__.__new__(error.__class__)
    copy.__dict__.update({key: rename_files(value, names) for key, value in vars(error).items()})
    copy.args = (rename_files(str(error), names),)
    return copy


def _rename_in_result(result: Any, names: Mapping[str, str]) -> Any:
    notices = (Notice(rename_files(str(w), names), warning_key(w)) for w in result.warnings)
    keys = [f.name for f in result.keys()]  # noqa: SIM118
    values = {key: rename_files(getattr(result, key), names) for key in keys}
    return replace(result, **values, warnings=list(dict.fromkeys(notices)))


@dataclass(frozen=True)
class CallExport:
    """Calls in which each file has a unique name.

    `texts` is {file name: content} of records that are not in the catalogue and must be saved.
    """

    calls: Sequence[Call]
    pinned_calls: Mapping[str, Call]
    texts: dict[str, str] = field(default_factory=dict)


def disambiguate(
    calls: Sequence[Call], pinned_calls: Mapping[str, Call] = MappingProxyType({})
) -> CallExport:
    """Return the calls with unique file names.

    Two brakes may have the same name: the edited one, and an earlier one that was pinned. A file
    that the previous call writes keeps its name.
    """
    texts: dict[str, str] = {}
    renamed_calls = [_rename_files(call, texts) for call in calls]
    return CallExport(
        renamed_calls,
        {label: _rename_files(call, texts) for label, call in pinned_calls.items()},
        texts,
    )


def _rename_files(call: Call, texts: dict[str, str]) -> Call:
    def make_unique(subject: Subject) -> Subject:
        if subject.file is None or call.made:
            return subject
        texts.update(subject.needs)
        stem, name, count = subject.name.removesuffix(".toml"), subject.name, 1
        while texts.setdefault(name, subject.file.text) != subject.file.text:
            count += 1
            name = f"{stem}-{count}.toml"
        return replace(subject, name=name)

    options = {k: make_unique(v) if isinstance(v, Subject) else v for k, v in call.options.items()}
    return replace(call, subjects=tuple(map(make_unique, call.subjects)), options=options)
