"""`friction` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from layerjam.cli import options as opt
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.commands.answer import Answer


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("friction")(friction)


def friction(
    files: opt.Files,
    normal_force: Annotated[
        str | None, typer.Option(metavar="Q", help="Force pressing the films together, 2.45N.")
    ] = None,
    standard: Annotated[
        str, typer.Option(metavar="paper|d1894|iso8295", help="How the records are read.")
    ] = "paper",
    start: Annotated[
        str | None,
        typer.Option(
            "--from", metavar="Q", help="Travel where the kinetic window starts; paper: 40 mm."
        ),
    ] = None,
    end: Annotated[
        str | None,
        typer.Option(
            "--to", metavar="Q", help="Travel where the kinetic window ends; paper: 100 mm."
        ),
    ] = None,
    area: Annotated[
        str | None, typer.Option(metavar="Q", help="Area under the sled, 625mm^2.")
    ] = None,
    accept_judder: Annotated[
        bool,
        typer.Option(
            "--accept-judder", help="Take the middle of stick-slip as the kinetic friction."
        ),
    ] = False,
    brake: Annotated[
        str | None, typer.Option(metavar="BRAKE", help="Brake to write the friction into.")
    ] = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    columns: opt.Columns = None,
    specimen: opt.Specimen = None,
    sheet: opt.Sheet = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Static and kinetic friction from friction tests: the paper's way, ASTM D1894, ISO 8295."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import friction as verb

    with Ticker() as ticker:
        answer = verb.friction(
            files, normal_force=normal_force, window=(start, end), standard=standard, area=area,
            accept_judder=accept_judder, brake=brake, out=out, partial=partial, progress=ticker,
            choices=opt.choices(negative, column, decimal, columns, specimen, sheet), force=force,
        )  # fmt: skip
    if figure:
        from layerjam.report import figures

        figures.save(figures.friction(*answer.record), figure, force)
    hidden = opt.hidden_keys(
        answer.file, "understood", "refused", "standard", "window", "intervals", "pressure",
        "stick_slip", "repeats_table",
    )  # fmt: skip
    return say(answer, as_json, hidden=hidden, lines=_lines(answer))


def _lines(answer: Answer) -> list[str]:
    """Interval of the means and one line a repeat."""
    out = [""]
    for name, over in answer.intervals.items():
        if over is not None and over["low"] is not None:
            out.append(
                f"{name} {over['mean']:.4f}, 95 % interval {over['low']:.4f} to "
                f"{over['high']:.4f} (t over {over['repeats']} repeats)"
            )
    saw = answer.stick_slip
    if saw is not None:
        every = show(saw["spacing"], "m", 3)
        if saw["period"] is not None:
            every += f", {show(saw['period'], 's', 3)}"
        out.append(f"stick-slip between {saw['lower']:.4f} and {saw['upper']:.4f}, every {every}")
    out.append("file: static, kinetic, travel of the kinetic mean")
    for row in answer.repeats_table:
        kinetic = "judders" if row["kinetic"] is None else f"{row['kinetic']:.4f}"
        start, end = (show(w, "m") for w in row["window"])
        out.append(f"  {Path(row['file']).name}: {row['static']:.4f}, {kinetic}, {start} to {end}")
    return out
