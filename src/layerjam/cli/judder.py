"""`judder` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("judder")(judder)


def judder(
    brake: opt.BrakeName,
    vacuum: opt.Vacuum,
    speed: Annotated[str, typer.Option(metavar="Q", help="Speed of the pull, e.g. 1mm/s.")],
    mass: Annotated[
        str | None, typer.Option(metavar="Q", help="Moving mass; half of the brake unless given.")
    ] = None,
    mount_stiffness: Annotated[
        str | None,
        typer.Option(metavar="Q", help="Stiffness of your mount, instead of the measured one."),
    ] = None,
    damping: Annotated[
        str | None, typer.Option(metavar="Q", help="Damping beside the spring, e.g. '5 N s/m'.")
    ] = None,
    stribeck_speed: Annotated[
        str | None,
        typer.Option(metavar="Q", help="Speed over which static friction is lost, e.g. 1mm/s."),
    ] = None,
    static: Annotated[
        str | None, typer.Option(metavar="NUMBER", help="Static friction, instead of the film's.")
    ] = None,
    slip: Annotated[str | None, typer.Option(metavar="Q", help="Slip at the start.")] = None,
    travel: Annotated[
        str | None, typer.Option(metavar="Q", help="Travel of the crosshead; a dozen slips.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the record: .csv or .nc.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Stick–slip of a pull at one speed, and what would stop it."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".csv", ".nc"))
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import stick_slip as verb

    given = {"damping": damping, "stribeck_speed": stribeck_speed, "slip": slip}
    answer = verb.judder(
        brake, vacuum=vacuum, speed=speed, mass=mass, mount_stiffness=mount_stiffness,
        static=static, travel=travel, atmosphere=atmosphere,
        **{key: value for key, value in given.items() if value is not None},
    )  # fmt: skip
    if out is not None:
        answer.record.save(out, force=force)
    if figure:
        from layerjam.studies.choi2018 import speed_figures

        speed_figures.save(speed_figures.judder(answer.record), figure, force)
    unknown = tuple(key for key, value in answer.values.items() if value is None)
    return say(answer, as_json, hidden=unknown)
