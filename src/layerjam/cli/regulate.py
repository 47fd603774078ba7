"""`regulate` and `follow` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt

Line = Annotated[
    str, typer.Argument(metavar="LINE", help="Catalogue name or path of a line's TOML file.")
]
Safe = Annotated[
    str,
    typer.Option(metavar="release|hold", help="Where a fault ends: vented, or valves closed."),
]
Kind = Annotated[str, typer.Option(metavar="bang-bang|pi|scheduled", help="The control law.")]
Fluid = Annotated[str, typer.Option(metavar="air|water", help="What fills the line.")]
Sample = Annotated[str | None, typer.Option(metavar="Q", help="Time between samples; 10 ms.")]
Range = Annotated[
    str | None, typer.Option(metavar="Q", help="Greatest vacuum the sensor shows, 103kPa.")
]
Noise = Annotated[
    str | None, typer.Option(metavar="Q", help="Standard deviation of a reading, 50Pa.")
]
Reversible = Annotated[
    bool, typer.Option("--reversible", help="The pump regulates downwards by running backwards.")
]
LeastRun = Annotated[
    str | None, typer.Option(metavar="Q", help="Shortest run and rest of the pump, 0.2s.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the sensor's noise.")]


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("regulate")(regulate)
    app.command("follow")(follow)


def regulate(
    line: Line,
    target: Annotated[str, typer.Option(metavar="Q", help="Vacuum to hold, e.g. 60kPa.")],
    safe_state: Safe = "",
    kind: Kind = "pi",
    fluid: Fluid = "air",
    duration: Annotated[
        str | None, typer.Option(metavar="Q", help="Time to simulate; 12 time constants.")
    ] = None,
    sample_time: Sample = None,
    sensor_range: Range = None,
    noise: Noise = None,
    reversible: Reversible = False,
    least_run: LeastRun = None,
    atmosphere: opt.Atmosphere = None,
    seed: Seed = 0,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Bring a vacuum line to a target and hold it, in closed loop with a noisy sensor."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import regulate as verb

    answer = verb.regulate(
        line, target=target, safe_state=safe_state, kind=kind, fluid=fluid, duration=duration,
        sample_time=sample_time, sensor_range=sensor_range, noise=noise, reversible=reversible,
        least_run=least_run, atmosphere=atmosphere, seed=seed,
    )  # fmt: skip
    if figure:
        from layerjam.report.control_figures import loop, save

        save(loop(*answer.record), figure, force)
    lines = ["", "worst time until a fault is said, at this vacuum"]
    lines += [
        f"  {name}: {'not seen' if time is None else f'{time:.3g} s'}"
        for name, time in answer.detection.items()
    ]
    return say(answer, as_json, hidden=("detection",), lines=lines)


def follow(
    line: Line,
    brake: opt.BrakeName,
    profile: Annotated[
        str,
        typer.Option(
            metavar="step|sine|rehabilitation|FILE", help="Force over time; a CSV also with slip."
        ),
    ],
    safe_state: Safe = "",
    low: Annotated[str | None, typer.Option(metavar="Q", help="Least force, 20N.")] = None,
    high: Annotated[str | None, typer.Option(metavar="Q", help="Greatest force, 80N.")] = None,
    period: Annotated[str | None, typer.Option(metavar="Q", help="Of the profile, 10s.")] = None,
    duration: Annotated[str | None, typer.Option(metavar="Q", help="Time to simulate.")] = None,
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Of the slip, 1mm/s.")] = None,
    kind: Kind = "scheduled",
    fluid: Fluid = "air",
    sample_time: Sample = None,
    sensor_range: Range = None,
    noise: Noise = None,
    slip_noise: Annotated[
        str | None, typer.Option(metavar="Q", help="Standard deviation of a measured slip.")
    ] = None,
    model_error: Annotated[
        str | None, typer.Option(metavar="X", help="True friction over the known one, 1.1.")
    ] = None,
    reversible: Reversible = False,
    least_run: LeastRun = None,
    atmosphere: opt.Atmosphere = None,
    seed: Seed = 0,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Make a sliding brake's force follow a profile, and say what it cannot follow."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import regulate as verb

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
