"""`lab` on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.errors import QuantityError


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("lab")(lab)


def lab(
    spec: Annotated[
        Path | None,
        typer.Argument(
            metavar="SPEC", help="The campaign's TOML file, or practice, which is built in."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Folder to write, new or empty; with --example a .toml file."
        ),
    ] = None,
    example: Annotated[
        bool,
        typer.Option("--example", help="Print a commented campaign to edit, or write it to --out."),
    ] = False,
    seed: Annotated[
        int | None, typer.Option(metavar="N", help="Seed instead of the campaign's own.")
    ] = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Practice files of a virtual laboratory: the truth is known, the machine has its faults."""
    from layerjam.commands import lab as verb

    if example:
        if spec is not None or seed is not None or as_json:
            raise QuantityError("--example: takes --out and --force only")
        text = verb.lab_example(out, force=force)
        print(f"Edit it, then: layerjam lab {out} --out DIR\n" if out else text, end="")
        return 0
    if spec is None or out is None:
        raise QuantityError(
            "lab: SPEC and --out are needed; layerjam lab --example --out SPEC.toml makes one to "
            "edit, and layerjam lab practice --out DIR needs none"
        )
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker

    with Ticker() as ticker:
        answer = verb.lab(spec, out=out, seed=seed, force=force, progress=ticker)
    lines = ["", "try:", *(f"  {command}" for command in answer.next)]
    code = say(
        answer, as_json, lines=lines, hidden=("next", "stopped"),
        shown={"files": f"{len(answer.files)}, each with its sidecar"},
    )  # fmt: skip
    return 130 if answer.stopped else code
