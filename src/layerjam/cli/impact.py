"""`drop` and `tune` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.cli.ticker import Ticker
from layerjam.errors import QuantityError

Mass = Annotated[str, typer.Option(metavar="Q", help="Mass to stop, e.g. 1kg.")]
Rope = Annotated[
    str | None, typer.Option(metavar="Q", help="Stiffness of the rope, e.g. 16.8kN/m.")
]
Horizontal = Annotated[bool, typer.Option("--horizontal", help="No gravity along the pull.")]


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for command in (drop, tune):
        app.command(command.__name__)(command)


def drop(
    brake: opt.BrakeName,
    mass: Mass,
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Speed on arrival.")] = None,
    height: Annotated[str | None, typer.Option(metavar="Q", help="Height of the fall.")] = None,
    vacuum: Annotated[
        str | None, typer.Option(metavar="Q", help="Vacuum, or 'tuned' with --travel.")
    ] = None,
    travel: Annotated[
        str | None, typer.Option(metavar="Q", help="Slip to stop within, for a tuned vacuum.")
    ] = None,
    rope_stiffness: Rope = None,
    rope_damping: Annotated[
        str | None, typer.Option(metavar="Q", help="Damping of the rope, e.g. '20 N s/m'.")
    ] = None,
    vacuum_history: Annotated[
        Path | None, typer.Option(metavar="FILE", help="CSV of time and vacuum, instead of one.")
    ] = None,
    reading: Annotated[
        str | None,
        typer.Option(metavar="KIND", help="Its pressure is absolute, gauge or vacuum."),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(metavar="ROLE:UNIT,...", help="Its columns: time:ms,skip,pressure:kPa."),
    ] = None,
    decimal: opt.Decimal = None,
    duration: Annotated[
        str | None, typer.Option(metavar="Q", help="Follow the rebound up to this time.")
    ] = None,
    accelerometer: Annotated[
        str, typer.Option(metavar="NAME", help="What measures the stop: ideal or adxl193.")
    ] = "ideal",
    filter_class: Annotated[
        str | None,
        typer.Option("--filter", metavar="CLASS", help="SAE J211: cfc60, 180, 600 or 1000."),
    ] = None,
    low_pass: Annotated[
        str | None, typer.Option(metavar="Q", help="Low-pass of the accelerometer, e.g. 400Hz.")
    ] = None,
    sampling: Annotated[
        str | None, typer.Option(metavar="Q", help="Sampling of the accelerometer, e.g. 10kHz.")
    ] = None,
    allowed_rise: Annotated[
        str | None, typer.Option(metavar="Q", help="Warmth the sheets may reach, 20K if not given.")
    ] = None,
    film_coefficient: Annotated[
        str | None, typer.Option(metavar="Q", help="Heat to the air, e.g. '10 W/(m^2 K)'.")
    ] = None,
    no_brake: Annotated[bool, typer.Option("--no-brake", help="The rope alone.")] = False,
    horizontal: Horizontal = False,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the record: .csv or .nc.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Stop a falling mass with the brake."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".csv", ".nc"))
    if no_brake and (out is not None or figure is not None):
        raise QuantityError("--no-brake: has no record to write or draw")
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.commands import impact, sensor
    from layerjam.units import parse

    with Ticker() as ticker:

        def tell(now: float) -> None:
            ticker("the drop in time", now / span if span else 1.0)

        span = 0.0 if duration is None else parse(duration, "s", "duration")
        answer = impact.drop(
            brake, mass=mass, speed=speed, height=height, vacuum=vacuum, travel=travel,
            rope_stiffness=rope_stiffness, rope_damping=rope_damping,
            vacuum_history=vacuum_history, reading=reading, columns=columns, decimal=decimal,
            duration=duration, no_brake=no_brake,
            horizontal=horizontal, atmosphere=atmosphere, progress=tell if span else None,
        )  # fmt: skip
    answer = sensor.observed(
        answer, accelerometer=accelerometer, filter=filter_class, low_pass=low_pass,
        sampling=sampling, allowed_rise=allowed_rise, film_coefficient=film_coefficient,
    )  # fmt: skip
    done = not no_brake and answer.record is not None and answer.values.get("feasible") is not False
    if out is not None and done:
        answer.record.save(out, force=force)
    if figure and done:
        from layerjam.report import impact_figures

        impact_figures.save(impact_figures.drop(answer.record), figure, force)
    unknown = tuple(key for key, value in answer.values.items() if value is None)
    extra: tuple[str, ...] = ()
    if answer.feasible:
        extra = ("feasible", "least_stiffness", "allowed_rise", "film_coefficient", "saturated")
    if accelerometer == "ideal" and (filter_class, low_pass, sampling) == (None, None, None):
        # nothing to tell beside the peak that stands there already
        extra += ("measured_peak", "measured_peak_g", "measured_peak_time", "peak_loss", "filter",
                  "accelerometer")  # fmt: skip
    return say(answer, as_json, hidden=unknown + extra)


def tune(
    brake: opt.BrakeName,
    mass: Mass,
    travel: Annotated[str, typer.Option(metavar="Q", help="Slip to stop within.")],
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Speed on arrival.")] = None,
    height: Annotated[str | None, typer.Option(metavar="Q", help="Height of the fall.")] = None,
    rope_stiffness: Rope = None,
    horizontal: Horizontal = False,
    atmosphere: opt.Atmosphere = None,
    as_json: opt.AsJson = False,
) -> int:
    """Vacuum that stops a mass within a travel."""
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.commands import tuning

    answer = tuning.tune(
        brake, mass=mass, speed=speed, height=height, travel=travel,
        rope_stiffness=rope_stiffness, horizontal=horizontal, atmosphere=atmosphere,
    )  # fmt: skip
    unknown = tuple(key for key, value in answer.values.items() if value is None)
    return say(answer, as_json, hidden=unknown)
