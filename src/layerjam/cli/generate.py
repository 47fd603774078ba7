"""The command line of a declared command: a signature that typer reads, and what runs behind it."""

from __future__ import annotations

import inspect
import shlex
import sys
from collections.abc import Callable, Container, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from layerjam.cli.engine import engine
from layerjam.cli.output import Ticker, check_figure, check_target, say
from layerjam.cli.typed import TYPED
from layerjam.commands.declare import (
    PYTHON_ONLY,
    Command,
    OutFile,
    Parameter,
    Progress,
    PythonOnly,
)
from layerjam.errors import QuantityError

FIGURE, RECORD, JSON, REPLACE = "figure_", "record_", "json_", "replace_"
"""Options that the command line adds to those of the function."""


def build(declared: Command) -> Callable[..., int]:
    """A function for typer with one parameter for each option of a command."""
    shown = [p for p in declared.parameters if p.type not in (Progress, PYTHON_ONLY)]
    places = [_place(p) for p in shown]
    places += [_former(p, old) for p in shown for old in p.help.old]
    places += _common(declared, {p.name for p in shown})
    required = [p for p in places if p.default is inspect.Parameter.empty]
    optional = [p for p in places if p.default is not inspect.Parameter.empty]

    def run(**given: Any) -> int:
        return _run(declared, shown, given)

    run.__name__ = declared.python_name
    run.__doc__ = declared.summary
    run.__signature__ = inspect.Signature([*required, *optional])  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in places}
    return run


def command_class(declared: Command) -> type[TyperCommand]:
    """A command some of whose options take all words up to the next option."""
    greedy = {p.option for p in declared.parameters if p.help.greedy}

    class Greedy(TyperCommand):
        def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
            """Repeat the option before every word it takes."""
            return super().parse_args(ctx, spread(args, greedy))

    return Greedy


def spread(args: Sequence[str], greedy: Container[str]) -> list[str]:
    """`--pulls a b --json` as `--pulls a --pulls b --json`."""
    out: list[str] = []
    current, fresh = None, False
    for at, word in enumerate(args):
        if word == "--":
            return [*out, *args[at:]]
        if word.startswith("--") or (word.startswith("-") and len(word) == 2):
            current, fresh = (word if word in greedy else None), True
        else:
            out += [current] if current and not fresh else []
            fresh = False
        out.append(word)
    return out


def _place(p: Parameter) -> inspect.Parameter:
    kind, many = _kind(p)
    default: Any = inspect.Parameter.empty if p.required else p.default
    if kind is not bool and default is not inspect.Parameter.empty and not many:
        default = None if default is None else str(default)
    sentence = p.sentence
    if p.stands_alone:
        note = typer.Argument(metavar=p.metavar or None, help=sentence)
    else:
        names: tuple[str, ...] = (p.option,)
        if p.name == "force" and kind is bool:
            names = ("--force", "--replace")
        note = typer.Option(
            *names,
            metavar=None if kind is bool else p.metavar or None,
            help=sentence,
            show_default=kind is not bool,
        )
    if many and default in ((), None):
        default = None
    return _keyword(p.name, kind, default, note)


def _keyword(name: str, kind: Any, default: Any, note: Any) -> inspect.Parameter:
    """A parameter as typer reads it."""
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, note]
    )


def _kind(p: Parameter) -> tuple[Any, bool]:
    """What typer reads: text for a quantity, else the plain type; and whether there are several."""
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


def _former(p: Parameter, old: str) -> inspect.Parameter:
    """A hidden option of a former name."""
    kind, _ = _kind(p)
    if kind is not bool:
        kind = str | None
    default = False if kind is bool else None
    return _keyword(_former_name(p, old), kind, default, typer.Option(old, hidden=True))


def _former_name(p: Parameter, old: str) -> str:
    return f"former_{old.lstrip('-').replace('-', '_')}"


def _common(declared: Command, known: set[str]) -> list[inspect.Parameter]:
    """--out of a record, --figure, --json, and --force where something is written."""
    drawn, recorded = declared.result.drawable(), declared.record_endings
    made = []
    if recorded and "out" not in known:
        text = f"Write the record: {' or '.join(recorded)}."
        note = typer.Option("--out", metavar="FILE", help=text)
        made.append(_keyword(RECORD, Path | None, None, note))
    if drawn:
        note = typer.Option("--figure", metavar="FILE", help="Draw it: .svg, .png or .pdf.")
        made.append(_keyword(FIGURE, Path | None, None, note))
    note = typer.Option("--json", help="One JSON object in SI units, nothing else.")
    made.append(_keyword(JSON, bool, False, note))
    if (drawn or recorded) and not _overwrites(declared):
        names = ("--replace",) if "force" in known else ("--force", "--replace")
        note = typer.Option(*names, help="Replace files that exist.")
        made.append(_keyword(REPLACE, bool, False, note))
    return made


def _overwrites(declared: Command) -> bool:
    """Whether the function itself takes the flag to replace files."""
    return any(p.name == "force" and p.type is bool for p in declared.parameters)


def _run(declared: Command, shown: list[Parameter], given: dict[str, Any]) -> int:
    figure, record = given.pop(FIGURE, None), given.pop(RECORD, None)
    as_json, replaces = given.pop(JSON), given.pop(REPLACE, False)
    _take_former(shown, given)
    if _overwrites(declared):
        replaces = given["force"]
    flag = "--replace" if "force" in given and not _overwrites(declared) else "--force"
    check_figure(figure, replaces, flag)
    check_target(record, replaces, declared.record_endings, flag)
    for p in shown:
        if isinstance(p.help, OutFile):
            check_target(given[p.name], replaces, p.help.endings, flag)
    if declared.computes:
        engine()
    arguments = {k: v for k, v in given.items() if v is not None or _is_required(shown, k)}
    with Ticker() as ticker:
        for p in declared.parameters:
            if p.type is Progress:
                arguments[p.name] = ticker
            elif isinstance(p.help, PythonOnly) and p.help.typed:
                arguments[p.name] = shlex.join(["layerjam", *TYPED.get()])
        result = declared(**arguments)
    if result.record is not None and not result.failed_checks:
        if record is not None:
            if not hasattr(result.record, "save"):
                raise QuantityError("out: this result has no record to write")
            result.record.save(record, force=replaces)
        if figure is not None and result.has_curve:
            result.plot(figure, force=replaces)
    return say(result, as_json)


def _is_required(shown: list[Parameter], name: str) -> bool:
    return any(p.name == name and p.required for p in shown)


def _take_former(shown: list[Parameter], given: dict[str, Any]) -> None:
    for p in shown:
        for old in p.help.old:
            value = given.pop(_former_name(p, old))
            if value:
                print(f"layerjam: {old} is now called {p.option}", file=sys.stderr)
                given[p.name] = value
