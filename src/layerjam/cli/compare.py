"""`compare` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("compare")(compare)


def compare(
    brakes: Annotated[
        list[str] | None,
        typer.Argument(metavar="[BRAKE...]", help="Brakes to compare; the catalogue's."),
    ] = None,
    vacuum: Annotated[
        str | None, typer.Option(metavar="Q", help="Vacuum of ours; the site's full vacuum.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Force over mass of brakes, beside what could be bought instead, each with its source."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import compare as verb

    answer = verb.compare(*(brakes or ()), vacuum=vacuum, atmosphere=atmosphere)
    rows, lines, others = answer.record
    if figure:
        from layerjam.report.density_figures import density, save

        save(density(rows, lines, answer.sheet, list(others.looked_for)), figure, force)
    return say(
        answer, as_json, hidden=tuple(answer.values), lines=verb.listing(rows, answer.sheet, others)
    )
