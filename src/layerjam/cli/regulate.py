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
    step: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Log of the real line at full pump, to tune by."),
    ] = None,
    reading: Annotated[
        str | None,
        typer.Option(metavar="absolute|gauge|vacuum", help="What the log's pressure counts from."),
    ] = None,
    start: Annotated[
        str | None, typer.Option("--from", metavar="Q", help="Where the step begins in the log.")
    ] = None,
    end: Annotated[
        str | None, typer.Option("--to", metavar="Q", help="Where the pump stops in the log.")
    ] = None,
    fault: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="What breaks: pump-dead, pump-weak, line-blocked, leak, sensor-nan, "
            "sensor-stuck or sensor-offset.",
        ),
    ] = None,
    fault_at: Annotated[
        str | None, typer.Option(metavar="Q", help="When it breaks, e.g. 8s.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    seed: line_opt.Seed = 0,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Bring a vacuum line to a target and hold it, in closed loop with a noisy sensor."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import regulate as verb
    from layerjam.commands.recorded_step import Recorded
    from layerjam.errors import QuantityError

    if step is None and (reading or start or end):
        raise QuantityError("reading, from, to: they go only with --step")
    recorded = None if step is None else Recorded(step, reading, start, end)
    answer = verb.regulate(
        line, target=target, safe_state=safe_state, kind=kind, fluid=fluid, duration=duration,
        sample_time=sample_time, sensor_range=sensor_range, noise=noise, reversible=reversible,
        least_run=least_run, step=recorded, fault=fault, fault_at=fault_at, atmosphere=atmosphere,
        seed=seed,
    )  # fmt: skip
    if figure:
        from layerjam.report.control_figures import loop, save

        save(loop(*answer.record), figure, force)
    lines = ["", "worst time until a fault is said, at this vacuum"]
    lines += [
        f"  {name}: {'not seen' if time is None else f'{time:.3g} s'}"
        for name, time in answer.detection.items()
    ]
    if answer.identified:
        low, high = answer.identified["pole"]
        lines = ["", f"step: rate {answer.identified['rate']:.4g} 1/s; its pole with the leak, at "
                 f"95 %, {low:.4g} to {high:.4g} 1/s", *lines]  # fmt: skip
    hidden = ["detection", "identified"]
    if fault is None:
        hidden += ["fault", "fault_at", "broken", "said_after"]
    return say(answer, as_json, hidden=hidden, lines=lines)
