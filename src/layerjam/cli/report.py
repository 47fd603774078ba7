"""`report` on the command line."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from layerjam.cli import options as opt

MANY = ("--friction", "--pulls", "--validate", "--calibrate-on", "--holdout")
"""Options that take all words up to the next option, so that a shell's pattern can follow one."""


class Greedy(TyperCommand):
    """A command whose options of MANY take several words."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat the option before every word it takes."""
        return super().parse_args(ctx, spread(args))


def spread(args: list[str]) -> list[str]:
    """`--pulls a b --json` as `--pulls a --pulls b --json`."""
    out: list[str] = []
    current = None
    fresh = False
    for at, word in enumerate(args):
        if word == "--":
            return [*out, *args[at:]]
        if word.startswith("--") or (word.startswith("-") and len(word) == 2):
            current = word if word in MANY else None
            fresh = True
            out.append(word)
        elif current and not fresh:
            out += [current, word]
        else:
            out.append(word)
            fresh = False
            continue
        fresh = word.startswith("-")
    return out


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("report", cls=Greedy)(report)


def _files(help: str) -> Any:
    return typer.Option(metavar="FILE...", help=help)


def report(
    brake: opt.BrakeName,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report.")],
    friction: Annotated[list[Path] | None, _files("Friction tests.")] = None,
    pulls: Annotated[list[Path] | None, _files("Pulls to calibrate on.")] = None,
    validate: Annotated[list[Path] | None, _files("Pulls to validate on.")] = None,
    calibrate_on: Annotated[
        list[Path] | None,
        _files("Calibrate on these alone; the other pulls serve validation."),
    ] = None,
    holdout: Annotated[
        list[str] | None,
        typer.Option(
            metavar="Q...",
            help="Hold back from calibration the pulls at this vacuum, speed or 'repeat N'.",
        ),
    ] = None,
    normal_force: Annotated[
        str | None, typer.Option(metavar="Q", help="Force pressing the films together, 2.45N.")
    ] = None,
    start: Annotated[
        str | None,
        typer.Option("--from", metavar="Q", help="Travel where the kinetic window starts."),
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="Q", help="Travel where the kinetic window ends.")
    ] = None,
    standard: Annotated[
        str, typer.Option(metavar="paper|d1894|iso8295", help="How friction tests are read.")
    ] = "paper",
    area: Annotated[
        str | None, typer.Option(metavar="Q", help="Area under the sled, e.g. '625 mm^2'.")
    ] = None,
    accept_judder: Annotated[
        bool, typer.Option("--accept-judder", help="Take the middle of a stick-slip as kinetic.")
    ] = False,
    depth: Annotated[
        str, typer.Option(metavar="exact|curves", help="Calibrate on peaks, or on whole curves.")
    ] = "exact",
    vacuum: opt.FileVacuum = None,
    atmosphere: opt.Atmosphere = None,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    columns: opt.Columns = None,
    specimen: opt.Specimen = None,
    sheet: opt.Sheet = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Measurements of one brake as a page: friction, calibration, validation, HTML and PDF."""
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import report as verb

    with Ticker() as ticker:
        answer = verb.report(
            brake, out=out, friction=friction or (), pulls=pulls or (), validate=validate or (),
            calibrate_on=calibrate_on or (), holdout=holdout or (), normal_force=normal_force,
            window=_window(start, end), standard=standard, area=area, accept_judder=accept_judder,
            depth=depth, vacuum=vacuum, atmosphere=atmosphere,
            choices=opt.choices(negative, column, decimal, columns, specimen, sheet), force=force,
            command=shlex.join(["layerjam", *sys.argv[1:]]),
            say=None if as_json else _progress, progress=ticker,
        )  # fmt: skip
    hidden = ("friction", "calibration", "validation", "refused", "calibrated_on_the_same")
    shown = {"figures": f"{len(answer.figures)} in {out / 'figures'}"}
    return say(answer, as_json, hidden=hidden, shown=shown)


def _window(start: str | None, end: str | None) -> tuple[str | None, str | None] | None:
    return None if start is None and end is None else (start, end)


def _progress(word: str) -> None:
    print(f"layerjam: {word}", file=sys.stderr, flush=True)
