"""`reproduce`: every number of the paper beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.cli.output import Answer


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("reproduce")(reproduce)


def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the report.")],
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> None:
    """Recompute the paper: report.html, results.json and figures."""
    opt.engine()
    from layerjam.report.reproduce import reproduce as run

    result = run(out, force=force, say=None if as_json else print)
    Answer(
        values={"report": str(result.report), "results": str(result.results), **result.counts},
        units={},
    ).print(as_json)
