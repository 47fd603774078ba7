"""The command line of a declared command: its signature for typer, and the call."""

import inspect
import os
import shlex
import sys
import tempfile
import time
from collections.abc import Callable, Container, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from layerjam.cli import TYPED
from layerjam.commands.declare import (
    PYTHON_ONLY,
    Command,
    OutFile,
    Parameter,
    Progress,
    PythonOnly,
    declare_parameter,
    load_command,
)
from layerjam.commands.quantities import Overwrite
from layerjam.errors import FileError, QuantityError
from layerjam.system import check_file_name, format_command_line, is_reader_gone, report_failure


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
        from layerjam.report.style import apply_style

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


def build_command(name: str) -> Any:
    """Return the command of the given name for typer, after importing its module."""
    entry = load_command(name)
    app_ = typer.Typer(add_completion=False, rich_markup_mode=None)
    # this mark keeps each example on its own line
    lines = "\b\n" + "\n".join(f"$ {example}" for example in entry.examples)
    settings = {"help_option_names": ["-h", "--help"]}
    app_.command(
        name,
        epilog=lines if entry.examples else None,
        context_settings=settings,
        cls=_make_command_class(entry),
    )(_build_function(entry))
    return typer.main.get_command(app_)


def _build_function(entry: Command) -> Callable[..., int]:
    """Return a function for typer with one parameter for each option of a command."""
    options = [p for p in entry.parameters if p.type not in (Progress, PYTHON_ONLY)]
    names = {p.name for p in options}
    if "overwrite" not in names and (entry.result.is_drawable() or entry.record_endings):
        overwrite = declare_parameter("overwrite", Overwrite, False)
        # in `vacuum`, --force is a force in newtons
        old = tuple(o for o in overwrite.help.old if o not in {p.option for p in options})
        options.append(replace(overwrite, help=replace(overwrite.help, old=old)))
    places = [_convert_parameter(p) for p in options]
    places += [_former_parameter(p, old) for p in options for old in p.help.old]
    places += _common_parameters(entry, names)
    mandatory = [p for p in places if p.default is inspect.Parameter.empty]
    optional = [p for p in places if p.default is not inspect.Parameter.empty]

    def run_entry(**values: Any) -> int:
        return _run_command(entry, options, values)

    run_entry.__name__ = entry.python_name
    run_entry.__doc__ = entry.summary
    run_entry.__signature__ = inspect.Signature([*mandatory, *optional])  # type: ignore[attr-defined]
    run_entry.__annotations__ = {p.name: p.annotation for p in places}
    return run_entry


def _make_command_class(entry: Command) -> type[TyperCommand]:
    """Return a command class in which some options accept all words up to the next option."""
    greedy = {p.option for p in entry.parameters if p.help.greedy}

    class Greedy(TyperCommand):
        def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
            """Repeat the option before each of its words, then parse."""
            return super().parse_args(ctx, repeat_options(args, greedy))

    return Greedy


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


def _convert_parameter(p: Parameter) -> inspect.Parameter:
    kind, several = _typer_type(p)
    default: Any = inspect.Parameter.empty if p.required else p.default
    if kind is not bool and not p.required and not several:
        default = p.default_text or None
    sentence = p.sentence
    if p.is_positional:
        note = typer.Argument(metavar=p.metavar or None, help=sentence)
    else:
        note = typer.Option(
            p.option,
            metavar=None if kind is bool else p.metavar or None,
            help=sentence,
            show_default=kind is not bool,
        )
    if several and default in ((), None):
        default = None
    return _typer_parameter(p.name, kind, default, note)


def _typer_parameter(name: str, kind: Any, default: Any, note: Any) -> inspect.Parameter:
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, note]
    )


def _typer_type(p: Parameter) -> tuple[Any, bool]:
    """Return the type for typer (text for a quantity), and whether there are several values."""
    if p.type is bool:
        return bool, False
    if p.several:
        return list[str] | None, True
    text = str(p.type)
    if p.spec is None and any(
        word in text for word in ("Sequence[", "list[", "Iterable[", "tuple[")
    ):
        inner = Path if "Path" in text else str
        return (list[inner] if p.required else list[inner] | None), True  # type: ignore[valid-type]
    if p.spec is None and "Path" in text and not hasattr(p.help, "convert"):
        return (Path if p.required else Path | None), False
    return (str if p.required else str | None), False


def _former_parameter(p: Parameter, old: str) -> inspect.Parameter:
    kind, _ = _typer_type(p)
    if kind is not bool:
        kind = str | None
    default = False if kind is bool else None
    return _typer_parameter(_former_name(p, old), kind, default, typer.Option(old, hidden=True))


def _former_name(p: Parameter, old: str) -> str:
    return f"former_{old.lstrip('-').replace('-', '_')}"


def _common_parameters(entry: Command, names_used: set[str]) -> list[inspect.Parameter]:
    """Return the options --out (for a record), --figure and --json."""
    draws, endings = entry.result.is_drawable(), entry.record_endings
    options = []
    if endings and "out" not in names_used:
        text = f"Write the record to a file: {' or '.join(endings)}."
        note = typer.Option("--out", metavar="FILE", help=text)
        options.append(_typer_parameter(RECORD, Path | None, None, note))
    if draws:
        note = typer.Option("--figure", metavar="FILE", help="Draw the result: .svg, .png or .pdf.")
        options.append(_typer_parameter(FIGURE, Path | None, None, note))
    note = typer.Option("--json", help="Print only one JSON object, in SI units.")
    options.append(_typer_parameter(JSON, bool, False, note))
    return options


def _run_command(entry: Command, options: list[Parameter], values: dict[str, Any]) -> int:
    figure, record = values.pop(FIGURE, None), values.pop(RECORD, None)
    as_json = values.pop(JSON)
    _apply_former_options(options, values)
    overwrite = values.get("overwrite", False)
    check_figure(figure, overwrite)
    check_target(record, overwrite, entry.record_endings)
    for p in options:
        if isinstance(p.help, OutFile):
            check_target(values[p.name], overwrite, p.help.endings)
    if entry.computes:
        from layerjam.cli.engine import enable_double_precision

        enable_double_precision()
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
    if result.record is not None and not result.failed_checks:
        if record is not None:
            if not hasattr(result.record, "save"):
                raise QuantityError("out: this result has no record to write")
            result.record.save(record, overwrite=overwrite)
        if figure is not None and result.has_curve:
            result.plot(figure, overwrite=overwrite)
    return print_result(result, as_json)


def _apply_former_options(options: list[Parameter], values: dict[str, Any]) -> None:
    for p in options:
        for old in p.help.old:
            value = values.pop(_former_name(p, old))
            if value:
                print(f"layerjam: {old} is now called {p.option}", file=sys.stderr)
                values[p.name] = value


def describe_missing(error: Any) -> str:
    """Return the missing parameter, its meaning and the line to type; "" for other errors."""
    if not hasattr(error, "param_type"):
        return ""
    entry, option = load_command(error.ctx.command.name), error.param.opts[0]
    if not option.startswith("-"):
        option, lines = error.param.metavar, entry.examples
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
    return f"{option} is missing ({error.param.help.rstrip('.')}); type, for example: {lines[0]}"


def _sample_value(entry: Command, p: Parameter) -> str:
    """Return a value of an option as it is typed, if possible from the command's examples."""
    for words in map(shlex.split, entry.examples):
        if p.option in words[:-1]:
            return words[words.index(p.option) + 1]
    return p.spec.example if p.spec and p.spec.example else p.metavar or p.name.upper()
