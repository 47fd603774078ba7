"""`apply` on the command line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.errors import QuantityError


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("apply")(apply)


def apply(
    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="Name of a scenario, or path of its TOML file."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for a page with pictures.")
    ] = None,
    names: Annotated[
        bool, typer.Option("--list", help="Name the scenarios that come with the program.")
    ] = False,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """A machine of the paper's Fig. 13: seat belt, neck guard, ankle clutch, rehabilitation."""
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands.answer import Answer
    from layerjam.studies.machines import apply as verb

    if names:
        known = verb.machines()
        if not as_json:
            print(*known, sep="\n")
            return 0
        return say(Answer(values={"scenarios": known}, units={}), as_json)
    if scenario is None:
        raise QuantityError(f"say which scenario: {', '.join(verb.machines())}, or a TOML file")
    with Ticker() as ticker:
        ticker("machine", 0.0)
        answer = verb.apply(scenario, out=out, force=force, say=None if as_json else ticker.say)
    if as_json:
        return say(answer, as_json)
    lines = ["", "limits"]
    lines += [
        f"  {'met' if limit.met else 'MISSED'}: {limit.sentence()}"
        for limit in answer.record.limits
    ]
    hidden = ["limits", "verdict", "reason", "results", *([] if out else ["page"])]
    flat = replace(answer, values={**answer.values, **answer.results})
    return say(flat, as_json, hidden=hidden, lines=[*lines, "", answer.verdict])
