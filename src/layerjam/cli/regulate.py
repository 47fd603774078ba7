"""`regulate` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import line_options as line_opt
from layerjam.cli import options as opt


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("regulate")(regulate)


def regulate(
    line: line_opt.Line,
    target: Annotated[str, typer.Option(metavar="Q", help="Vacuum to hold, e.g. 60kPa.")],
    safe_state: line_opt.Safe = "",
    kind: line_opt.Kind = "pi",
    fluid: line_opt.Fluid = "air",
    duration: Annotated[
        str | None, typer.Option(metavar="Q", help="Time to simulate; 12 time constants.")
    ] = None,
    sample_time: line_opt.Sample = None,
    sensor_range: line_opt.Range = None,
    noise: line_opt.Noise = None,
    reversible: line_opt.Reversible = False,
    least_run: line_opt.LeastRun = None,
    atmosphere: opt.Atmosphere = None,
    seed: line_opt.Seed = 0,
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
