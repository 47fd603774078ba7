"""The command line of a declared command: its options for click, and the call."""

import os
import shlex
import sys
import tempfile
import time
from collections.abc import Container, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from layerjam.brake.commands.arguments import Overwrite
from layerjam.cli import TYPED
from layerjam.cli.interrupts import handle_interrupts
from layerjam.core.command.declare import (
    Command,
    OutFile,
    Parameter,
    Progress,
    PythonOnly,
    declare_parameter,
    load_command,
)
from layerjam.core.command.results import STOPPED
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.store import Appearing
from layerjam.core.system import (
    check_file_name,
    format_command_line,
    is_reader_gone,
    report_failure,
)


def print_result(result: Any, as_json: bool) -> int:
    """Print a result as text or JSON, and return the exit code."""
    try:
        print(result.json() if as_json else result, flush=True)
    except OSError as error:
        if not is_reader_gone(error):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    code: int = result.exit_code
    return code


PATIENCE = 2.0


class Ticker:
    """Progress, called with (stage, share); after two seconds it prints once per second.

    The first call starts the clock, so that loading does not count.
    """

    def __init__(self) -> None:
        self.started: float | None = None
        self.said = 0.0

    def __call__(self, stage: str, share: float) -> None:
        """Report the stage and the completed fraction of it."""
        time_now = time.monotonic()
        self.started = self.started or time_now
        if share > 0 and time_now - self.started > PATIENCE and time_now - self.said > 1:
            self.said = time_now
            print(f"layerjam: {stage} {share:.0%}", file=sys.stderr, flush=True)


PICTURES = (".svg", ".png", ".pdf")


def check_figure(path: Path | None, overwrite: bool) -> None:
    """Reject a figure that cannot be drawn or written, before any computation."""
    check_target(path, overwrite, PICTURES)
    if path is not None:
        from layerjam.core.drawing.style import apply_style

        with apply_style():
            pass


def check_target(path: Path | None, overwrite: bool, endings: tuple[str, ...]) -> None:
    """Reject an output file of the wrong kind, or one that exists unless `overwrite`."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        choices = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
        raise FileError(path, f"extension '{path.suffix}' is unknown; use {choices}")
    check_file_name(path)
    with report_failure(path, "cannot be written"):
        exists = os.path.lexists(path)
        if exists and not path.is_file():
            raise FileError(path, "is a folder or not a regular file")
        if exists and not overwrite:
            raise FileError(path, "already exists; --overwrite replaces it")
        if not path.parent.is_dir():
            raise FileError(path, f"cannot be written: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK):
            raise FileError(path, f"cannot be written: the folder {path.parent} is read-only")
        if len(os.fsencode(path.name)) > 200:
            raise FileError(f"{path.name[:60]}...", "cannot be written: the name is too long")
        with tempfile.TemporaryFile(dir=path.parent):
            pass


FIGURE, RECORD, JSON = "figure_", "record_", "json_"
"""Options that the command line adds to those of the function."""


class EntryCommand(click.Command):
    """A declared command with its arguments and options."""

    def __init__(self, entry: Command, options: Sequence[Parameter]) -> None:
        # the mark keeps each example on its own line
        lines = "\b\n" + "\n".join(f"$ {example}" for example in entry.examples)
        places = [_convert_parameter(p) for p in options]
        places += [_former_option(p, old) for p in options for old in p.help.old]
        places += _common_options(entry, {p.name for p in options})
        super().__init__(
            entry.name,
            params=sorted(places, key=lambda place: not place.required),
            callback=lambda **values: _run_command(entry, options, values),
            help=entry.summary,
            epilog=lines if entry.examples else None,
            context_settings={"help_option_names": ["-h", "--help"]},
        )
        self.entry = entry
        self.greedy = {p.option for p in entry.parameters if p.help.greedy}

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse; some options accept all words up to the next option."""
        return super().parse_args(ctx, repeat_options(args, self.greedy))


def build_command(name: str) -> EntryCommand:
    """Return the command of the given name for click, after importing its module."""
    entry = load_command(name)
    options = [p for p in entry.parameters if p.is_offered]
    names = {p.name for p in options}
    if "overwrite" not in names and (entry.result.is_drawable() or entry.record_endings):
        overwrite = declare_parameter("overwrite", Overwrite, False)
        # in `vacuum`, --force is a force in newtons
        old = tuple(o for o in overwrite.help.old if o not in {p.option for p in options})
        options.append(replace(overwrite, help=replace(overwrite.help, old=old)))
    return EntryCommand(entry, options)


def repeat_options(args: Sequence[str], greedy: Container[str]) -> list[str]:
    """Return `--pulls a b --json` as `--pulls a --pulls b --json`."""
    out: list[str] = []
    current, fresh = None, False
    for index, word in enumerate(args):
        if word == "--":
            return [*out, *args[index:]]
        if word.startswith("--") or (word.startswith("-") and len(word) == 2):
            current, fresh = (word if word in greedy else None), True
        else:
            out += [current] if current and not fresh else []
            fresh = False
        out.append(word)
    return out


def _convert_parameter(p: Parameter) -> click.Parameter:
    kind, several = _find_type(p)
    if p.is_positional:
        words = f"{p.sentence}  [default: {p.default_text}]" if p.default_text else p.sentence
        return click.Argument(
            [p.name], metavar=p.metavar, help=words, type=kind, nargs=-1 if several else 1,
            required=p.required, **({"default": p.default_text} if p.default_text else {}),
        )  # fmt: skip
    if kind is bool:
        return click.Option([p.name, p.option], is_flag=True, default=p.default, help=p.sentence)
    has_default = p.default_text and not (p.required or several)
    default: dict[str, Any] = {"default": p.default_text} if has_default else {}
    return click.Option(
        [p.name, p.option], metavar=p.metavar or None, help=p.sentence, type=kind, multiple=several,
        required=p.required, show_default=True, **default,
    )  # fmt: skip


def _find_type(p: Parameter) -> tuple[Any, bool]:
    """Return the type for click (text for a quantity), and whether there are several values."""
    if p.type is bool:
        return bool, False
    text, kind = str(p.type), click.Path(path_type=Path)
    if p.several or p.spec is not None:
        return str, p.several
    several = any(word in text for word in ("Sequence[", "list[", "Iterable[", "tuple["))
    is_path = "Path" in text and (several or not hasattr(p.help, "convert"))
    return (kind if is_path else str), several


def _former_option(p: Parameter, old: str) -> click.Option:
    is_flag = _find_type(p)[0] is bool
    return click.Option([_former_name(p, old), old], is_flag=is_flag, hidden=True)


def _former_name(p: Parameter, old: str) -> str:
    return f"former_{old.lstrip('-').replace('-', '_')}"


def _common_options(entry: Command, names_used: set[str]) -> list[click.Parameter]:
    """Return the options --out (for a record), --figure and --json."""
    draws, endings = entry.result.is_drawable(), entry.record_endings
    file: dict[str, Any] = {"metavar": "FILE", "type": click.Path(path_type=Path)}
    options: list[click.Parameter] = []
    if endings and "out" not in names_used:
        words = f"Write the record to a file: {' or '.join(endings)}."
        options.append(click.Option([RECORD, "--out"], help=words, **file))
    if draws:
        words = "Draw the result: .svg, .png or .pdf."
        options.append(click.Option([FIGURE, "--figure"], help=words, **file))
    words = "Print only one JSON object, in SI units."
    return [*options, click.Option([JSON, "--json"], is_flag=True, help=words)]


def _run_command(entry: Command, options: Sequence[Parameter], values: dict[str, Any]) -> int:
    # several values that were not given are an empty tuple
    values = {k: list(v) or None if isinstance(v, tuple) else v for k, v in values.items()}
    figure, record = values.pop(FIGURE, None), values.pop(RECORD, None)
    as_json = values.pop(JSON)
    _apply_former_options(options, values)
    overwrite = values.get("overwrite", False)
    check_figure(figure, overwrite)
    check_target(record, overwrite, entry.record_endings)
    for p in options:
        if isinstance(p.help, OutFile):
            check_target(values[p.name], overwrite, p.help.endings)
    Appearing.reset(
        value for value in (figure, record, *values.values()) if isinstance(value, Path)
    )
    handle_interrupts()
    arguments = {
        p.name: values[p.name]
        for p in entry.parameters
        if p.name in values and (values[p.name] is not None or p.required)
    }
    ticker = Ticker()
    for p in entry.parameters:
        if p.type is Progress:
            arguments[p.name] = ticker
        elif isinstance(p.help, PythonOnly) and p.help.typed:
            arguments[p.name] = format_command_line(["layerjam", *TYPED.get()])
    result = entry(**arguments)
    if result.exit_code != STOPPED:
        Appearing.raise_lost_interrupt()
    if result.record is not None and not result.failed_checks:
        if record is not None:
            if not hasattr(result.record, "save"):
                raise QuantityError("out: this result has no record to write")
            result.record.save(record, overwrite=overwrite)
        if figure is not None and result.has_curve:
            result.plot(figure, overwrite=overwrite)
    return print_result(result, as_json)


def _apply_former_options(options: Sequence[Parameter], values: dict[str, Any]) -> None:
    for p in options:
        for old in p.help.old:
            value = values.pop(_former_name(p, old))
            if value:
                print(f"layerjam: {old} is now called {p.option}", file=sys.stderr)
                values[p.name] = value


def describe_missing(error: click.ClickException) -> str:
    """Return the missing parameter, its meaning and the line to type; "" for other errors."""
    if not isinstance(error, click.MissingParameter):
        return ""
    command, place = error.ctx and error.ctx.command, error.param
    if not isinstance(command, EntryCommand) or place is None:
        return ""
    entry, option = command.entry, place.opts[0]
    if not option.startswith("-"):
        option, lines = str(place.metavar), entry.examples
    else:
        options = {word.partition("=")[0] for word in TYPED.get()}
        missing = [p for p in entry.parameters if p.required and not p.is_positional]
        words = [
            w
            for p in missing
            if p.option not in options
            for w in (p.option, _sample_value(entry, p))
        ]
        lines = [format_command_line(["layerjam", *TYPED.get(), *words])]
    return f"{option} is missing ({str(place.help).rstrip('.')}); type, for example: {lines[0]}"


def _sample_value(entry: Command, p: Parameter) -> str:
    """Return a value of an option as it is typed, if possible from the command's examples."""
    for words in map(shlex.split, entry.examples):
        if p.option in words[:-1]:
            return words[words.index(p.option) + 1]
    return p.spec.example if p.spec and p.spec.example else p.metavar or p.name.upper()
