"""`array` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("array")(array)


def array(
    brake: opt.BrakeName,
    parallel: Annotated[
        str, typer.Option(metavar="N", help="Chains of brakes side by side.")
    ] = "1",
    series: Annotated[
        str, typer.Option(metavar="N", help="Brakes one behind the other in a chain.")
    ] = "1",
    vacuum: Annotated[
        str | None, typer.Option(metavar="Q", help="Vacuum of all; the site's full vacuum.")
    ] = None,
    until: Annotated[
        str | None, typer.Option(metavar="Q", help="Elongation to pull to; the end of the travel.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    as_json: opt.AsJson = False,
) -> int:
    """Equal brakes side by side and in series: totals, and the force of one slow pull."""
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands.array import array as verb

    answer = verb(
        brake, parallel=parallel, series=series, vacuum=vacuum, until=until, atmosphere=atmosphere
    )
    hidden = () if answer.until is not None else ("until",)
    return say(answer, as_json, hidden=hidden)
