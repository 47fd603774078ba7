"""`new`, `show`, `force`, `vacuum` and `tensile` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for command in (new, show, force, vacuum, tensile):
        app.command(command.__name__)(command)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new brake.")],
    start: Annotated[str, typer.Option("--from", metavar="BRAKE", help="Brake to start from.")],
    out: Annotated[Path, typer.Option(metavar="FILE.toml", help="File to write.")],
    as_json: opt.AsJson = False,
    replace: opt.Force = False,
) -> int:
    """Write a commented brake file to edit, starting from another brake."""
    opt.check_target(out, replace, (".toml",))
    from layerjam.cli.output import say
    from layerjam.commands import predict

    answer = predict.new(name, start, out, force=replace)
    return say(answer, as_json, lines=["", f"Edit it, then: layerjam show {out}"])


def show(
    brake: opt.BrakeName, atmosphere: opt.Atmosphere = None, as_json: opt.AsJson = False
) -> int:
    """What a brake weighs, holds, stores and bears, and where its numbers come from."""
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.commands import predict

    answer = predict.show(brake, atmosphere=atmosphere)
    lines = ["", "where the numbers come from"]
    lines += [f"  {path}: {text}" for path, text in answer.sources.items()]
    return say(answer, as_json, lines=lines, hidden=("sources",))


def force(
    brake: opt.BrakeName,
    slip: opt.Slip,
    vacuum: opt.Vacuum,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    replace: opt.Force = False,
) -> int:
    """Force of the sliding brake at a slip and a vacuum."""
    opt.check_figure(figure, replace)
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.commands import predict

    answer = predict.force(brake, slip=slip, vacuum=vacuum, atmosphere=atmosphere)
    if figure:
        from layerjam.report import figures

        figures.save(figures.force_over_slip(*answer.record), figure, replace)
    return say(answer, as_json)


def vacuum(
    brake: opt.BrakeName,
    slip: opt.Slip,
    force: Annotated[str, typer.Option(metavar="Q", help="Force wanted, e.g. 100N.")],
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    replace: opt.Replace = False,
) -> int:
    """Vacuum that makes the sliding brake resist with a force at a slip."""
    opt.check_figure(figure, replace, "--replace")
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.commands import predict

    answer = predict.vacuum(brake, slip=slip, force=force, atmosphere=atmosphere)
    if figure:
        from layerjam.report import figures

        figures.save(figures.force_over_vacuum(*answer.record), figure, replace)
    return say(answer, as_json, hidden=() if answer.reason else ("reason",))


def tensile(
    brake: opt.BrakeName,
    vacuum: Annotated[str | None, typer.Option(metavar="Q", help="Vacuum, e.g. 94.5kPa.")] = None,
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Crosshead speed.")] = None,
    travel: Annotated[str | None, typer.Option(metavar="Q", help="Elongation to pull to.")] = None,
    procedure: Annotated[
        str | None,
        typer.Option(
            metavar="TEXT",
            help="Steps instead, e.g. 'evacuate to 50 kPa; pull at 1 "
            "mm/s until 20 mm; return at 1 mm/s to 0 mm'.",
        ),
    ] = None,
    model: Annotated[str, typer.Option(help="lumped, or stack: sheet by sheet.")] = "lumped",
    static: Annotated[
        bool, typer.Option("--static", help="Stack: static friction before an interface slides.")
    ] = False,
    scatter: Annotated[
        str | None, typer.Option(metavar="Q", help="Stack: scatter of the friction, e.g. 10%.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option(help="Stack: how many stacks tell the scatter (1000).")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Stack: seed of the scatter (1).")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the record: .csv or .nc.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    replace: opt.Force = False,
) -> int:
    """Pull the brake in a simulated test machine."""
    opt.check_figure(figure, replace)
    opt.check_target(out, replace, (".csv", ".nc"))
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import predict

    with Ticker() as ticker:
        answer = predict.tensile(
            brake, vacuum=vacuum, speed=speed, travel=travel, procedure=procedure, model=model,
            static=static, scatter=scatter, samples=samples, seed=seed, progress=ticker,
            atmosphere=atmosphere,
        )  # fmt: skip
    if out is not None:
        answer.record.save(out, force=replace)
    if figure:
        from layerjam.report import figures

        figures.save(figures.tensile(answer.record), figure, replace)
    return say(answer, as_json)
