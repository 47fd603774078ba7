"""`friction` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("friction")(friction)


def friction(
    files: opt.Files,
    normal_force: Annotated[
        str | None, typer.Option(metavar="Q", help="Force pressing the films together, 2.45N.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="Q", help="Travel where the kinetic window starts.")
    ] = "40 mm",
    end: Annotated[
        str, typer.Option("--to", metavar="Q", help="Travel where the kinetic window ends.")
    ] = "100 mm",
    brake: Annotated[
        str | None, typer.Option(metavar="BRAKE", help="Brake to write the friction into.")
    ] = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Static and kinetic friction from friction tests, as the paper reduces them."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import friction as verb

    answer = verb.friction(
        files, normal_force=normal_force, window=(start, end), brake=brake, out=out,
        partial=partial, choices=opt.choices(negative, column, decimal), force=force,
    )  # fmt: skip
    if figure:
        from layerjam.report import figures

        figures.save(figures.friction(*answer.record), figure, force)
    return say(answer, as_json, hidden=opt.hidden_keys(answer.file, "understood", "refused"))
