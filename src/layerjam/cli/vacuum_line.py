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
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """How fast a line brings a vacuum, and lets go of it."""
    opt.check_figure(figure, force)
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import vacuum_line

    with Ticker() as ticker:
        answer = vacuum_line.rise(
            line, target=target, fluid=fluid, atmosphere=atmosphere, progress=ticker
        )
    if figure:
        from layerjam.report.fluid_figures import rise_figure, save

        file = vacuum_line.line_at(line, atmosphere)
        save(rise_figure(file.line, answer.target, fluid == "water", file.name), figure, force)
    hidden = [] if answer.feasible is False else ["reason"]
    if answer.tube_delay is None:
        hidden += ["tube_delay", "tube_lag"]
    return say(answer, as_json, hidden=hidden)
