"""`rise` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import line_options as line_opt
from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("rise")(rise)


def rise(
    line: line_opt.Line,
    target: Annotated[str, typer.Option(metavar="Q", help="Vacuum to reach, e.g. 94.5kPa.")],
    fluid: line_opt.Fluid = "air",
    atmosphere: opt.Atmosphere = None,
    as_json: opt.AsJson = False,
) -> int:
    """How fast a line brings a vacuum, and lets go of it."""
    from layerjam.cli.output import say
    from layerjam.verbs import vacuum_line

    answer = vacuum_line.rise(line, target=target, fluid=fluid, atmosphere=atmosphere)
    return say(answer, as_json, hidden=("reason",) if answer.feasible else ())
