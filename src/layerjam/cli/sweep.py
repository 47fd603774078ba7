"""`sweep` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.cli.design import HIDDEN, SpecFile, lines

STOPPED = 130


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("sweep")(sweep)


def sweep(
    spec: SpecFile,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for the blocks; the same one to go on.")
    ],
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask cluster, e.g. tcp://10.0.0.1:8786."),
    ] = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Every design of a specification in blocks on disk; can be stopped, and goes on."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import sweep as verb

    with Ticker() as ticker:
        answer = verb.sweep(spec, out=out, scheduler=scheduler, progress=ticker)
    if figure and answer.feasible:
        from layerjam.report.design_figures import front, save

        save(front(answer), figure, force)
    known = answer.feasible is not None
    hidden = (*HIDDEN, *(("killed_by", "reason") if answer.feasible or not known else ()))
    shown = {"bytes": f"{answer.values['bytes'] / 1e6:.3g} MB"}
    code = say(answer, as_json, hidden=hidden, lines=lines(answer) if known else [], shown=shown)
    return code if known else STOPPED
