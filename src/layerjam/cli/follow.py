"""`follow` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import line_options as line_opt
from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("follow")(follow)


def follow(
    line: line_opt.Line,
    brake: opt.BrakeName,
    profile: Annotated[
        str,
        typer.Option(
            metavar="step|sine|rehabilitation|FILE", help="Force over time; a CSV also with slip."
        ),
    ],
    safe_state: line_opt.Safe = "",
    low: Annotated[str | None, typer.Option(metavar="Q", help="Least force, 20N.")] = None,
    high: Annotated[str | None, typer.Option(metavar="Q", help="Greatest force, 80N.")] = None,
    period: Annotated[str | None, typer.Option(metavar="Q", help="Of the profile, 10s.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="Q", help="Time to simulate.")] = None,
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Of the slip, 1mm/s.")] = None,
    kind: line_opt.Kind = "scheduled",
    fluid: line_opt.Fluid = "air",
    sample_time: line_opt.Sample = None,
    sensor_range: line_opt.Range = None,
    noise: line_opt.Noise = None,
    slip_noise: Annotated[
        str | None, typer.Option(metavar="Q", help="Standard deviation of a measured slip.")
    ] = None,
    model_error: Annotated[
        str | None, typer.Option(metavar="X", help="True friction over the known one, 1.1.")
    ] = None,
    reversible: line_opt.Reversible = False,
    least_run: line_opt.LeastRun = None,
    atmosphere: opt.Atmosphere = None,
    seed: line_opt.Seed = 0,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Make a sliding brake's force follow a profile, and say what it cannot follow."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import follow as verb

    answer = verb.follow(
        line, brake, profile=profile if profile in verb.PROFILES else Path(profile),
        safe_state=safe_state, low=low, high=high, period=period, duration=duration, speed=speed,
        kind=kind, fluid=fluid, sample_time=sample_time, sensor_range=sensor_range, noise=noise,
        slip_noise=slip_noise, model_error=model_error, reversible=reversible,
        least_run=least_run,
        atmosphere=atmosphere, seed=seed,
    )  # fmt: skip
    if figure:
        from layerjam.report.control_figures import following, save

        save(following(*answer.record), figure, force)
    lines = ["", *(f"cannot: {reason}" for reason in answer.reasons)]
    return say(
        answer, as_json, hidden=("reasons", "bode"), lines=lines,
        shown={"possible": f"{answer.possible:.1%} of the time"},
    )  # fmt: skip
