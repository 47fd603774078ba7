"""`plan` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import line_options as line_opt
from layerjam.cli import options as opt

SPREAD = ("expected_g", "g_95", "_beyond", "_out", "g_error", "chance_error", "samples", "seed")


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("plan")(plan)


def plan(
    line: line_opt.Line,
    brake: opt.BrakeName,
    mass: Annotated[str, typer.Option(metavar="Q", help="Mass to stop, e.g. 1kg.")],
    speed: Annotated[str, typer.Option(metavar="Q", help="Speed on arrival, as estimated.")],
    warning: Annotated[str, typer.Option(metavar="Q", help="Time from warning to taut rope.")],
    travel: Annotated[str, typer.Option(metavar="Q", help="Slip to stop within.")],
    mass_sd: Annotated[
        str | None, typer.Option(metavar="Q", help="Standard deviation of the mass.")
    ] = None,
    speed_sd: Annotated[
        str | None, typer.Option(metavar="Q", help="Standard deviation of the speed.")
    ] = None,
    standing: Annotated[str, typer.Option(metavar="Q", help="Vacuum held while waiting.")] = "0Pa",
    stored: Annotated[
        str | None, typer.Option(metavar="Q", help="Vacuum in the line's reservoir beforehand.")
    ] = None,
    rope_stiffness: Annotated[
        str | None, typer.Option(metavar="Q", help="Stiffness of the rope, e.g. 16.8kN/m.")
    ] = None,
    horizontal: Annotated[
        bool, typer.Option("--horizontal", help="No gravity along the pull.")
    ] = False,
    fluid: line_opt.Fluid = "air",
    samples: Annotated[
        int, typer.Option(metavar="N", help="Masses and speeds to try, at least.")
    ] = 40_000,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of their random shifts.")] = 1,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    replace: opt.Replace = False,
    as_json: opt.AsJson = False,
) -> int:
    """Whether the vacuum is there when a collision comes, and what to build if not."""
    opt.check_figure(figure, replace, "--replace")
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.commands import plan as verb

    answer = verb.plan(
        line, brake, mass=mass, mass_sd=mass_sd, speed=speed, speed_sd=speed_sd, warning=warning,
        travel=travel, standing=standing, stored=stored, rope_stiffness=rope_stiffness,
        horizontal=horizontal, fluid=fluid, samples=samples, seed=seed, atmosphere=atmosphere,
    )  # fmt: skip
    if figure:
        from layerjam.report import plan_figures

        plan_figures.save(plan_figures.planned(answer.record), figure, replace)
    hidden = [key for key, value in answer.values.items() if value is None]
    if answer.needed is None or answer.feasible:
        hidden += [key for key in answer.values if key.endswith("_needed_reason")]
    if mass_sd is None and speed_sd is None:
        # nothing is uncertain: the stop above is all there is to tell
        hidden += [key for key in answer.values if key.endswith(SPREAD)]
    return say(answer, as_json, hidden=hidden)
