"""`reproduce` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("reproduce")(reproduce)


def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report.")],
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Recompute the paper: report.html, results.json and figures, every claim beside ours."""
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands.answer import Answer
    from layerjam.studies.choi2018.reproduce import reproduce as run

    result = run(out, force=force, say=None if as_json else print)
    values = {"report": str(result.report), "results": str(result.results), **result.counts}
    return say(Answer(values=values, units={}), as_json)
