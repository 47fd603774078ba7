"""`design` on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from layerjam.cli import options as opt

if TYPE_CHECKING:
    from layerjam.commands.answer import Answer

SpecFile = Annotated[
    str, typer.Argument(metavar="SPEC.toml", help="What is wanted: a file, or wrist or stop.")
]
HIDDEN = (
    "chosen", "refined", "runner_up", "forbidden", "front", "sensitivities", "robustness",
    "binding", "runner_up_lost", "excludes", "reachable",
)  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("design")(design)


def design(
    spec: SpecFile,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """From a need to a brake: the best design, the front, and why the next one lost."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import design as verb

    with Ticker() as ticker:
        answer = verb.design(spec, progress=ticker)
    if figure and answer.feasible:
        from layerjam.report.design_figures import front, save

        save(front(answer), figure, force)
    hidden = (*HIDDEN, *(("killed_by", "reason") if answer.feasible else ()))
    return say(answer, as_json, hidden=hidden, lines=lines(answer))


def lines(answer: Answer) -> list[str]:
    """The design, the runner-up, what forbids better ones, margins."""
    from layerjam.design.verdict import named
    from layerjam.units import show

    if not answer.feasible:
        return []
    spec = answer.record.spec
    chosen, told = answer.chosen, [o.name for o in spec.objectives]
    told += [c.name for c in spec.constraints if c.name not in told]
    out = ["", f"chosen: {named(chosen)}"]
    refined = answer.refined
    for name in told:
        text = show(chosen[name], answer.units[name])
        if refined and name in refined:
            text += f"   between the steps {show(refined[name], answer.units[name])}"
        out.append(f"  {name}: {text}")
    if refined:
        moved = ", ".join(f"{n} {show(refined[n], answer.units[n])}" for n in spec.grid.ranges)
        out.append(f"between the steps: {named(refined)} ({moved})")
    if answer.runner_up:
        out += ["", f"runner-up: {named(answer.runner_up)}", f"  {answer.runner_up_lost}"]
    if answer.binding:
        out += ["", "held by: " + ", ".join(answer.binding)]
    near = sorted(answer.forbidden, key=lambda f: f["short"])
    out += [f"forbidden: {f['reason']}" for f in near[:3]]
    return [*out, *_margins(answer)]


def _margins(answer: Answer) -> list[str]:
    out: list[str] = []
    if answer.robustness:
        out += ["", "chance that it holds, with the scatter in friction"]
        out += [f"  {c['probability']:>6.1%}  {name}" for name, c in answer.robustness.items()]
    first = next(iter(answer.record.spec.objectives)).name
    slopes: dict[str, Any] = answer.sensitivities.get(first, {})
    strong = sorted(slopes.items(), key=lambda item: -abs(item[1]))[:4]
    if strong:
        words = ", ".join(f"{n} {v:+.2f}" for n, v in strong if abs(v) > 0.005)
        out += ["", f"1 % more of these changes {first} by as many percent: {words}"]
    return out
