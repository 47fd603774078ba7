"""`validate` on the command line."""

from __future__ import annotations

import typer

from layerjam.cli import options as opt
from layerjam.units import show


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("validate")(validate)


def validate(
    brake: opt.BrakeName,
    files: opt.Files,
    vacuum: opt.FileVacuum = None,
    atmosphere: opt.Atmosphere = None,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """How far the brake's model lies from measured pulls."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import validation

    answer = validation.validate(
        brake, files, vacuum=vacuum, atmosphere=atmosphere,
        choices=opt.choices(negative, column, decimal),
    )  # fmt: skip
    if figure:
        from layerjam.report import figures

        figures.save(figures.validation(*answer.record), figure, force)
    lines = ["", "MAPE    RMSE      vacuum     file"]
    for row in answer.files:
        note = f" ({row['note']})" if row["note"] else ""
        lines.append(
            f"{row['mape']:<6.2%}  {show(row['rmse'], 'N', 3):<8}  {show(row['vacuum'], 'Pa'):<9}  "
            f"{row['path']}{note}"
        )
    shown = {key: f"{answer.values[key]:.2%}" for key in ("mape", "mape_sd") if answer.values[key]}
    hidden = ("files", "refused")
    return say(answer, as_json, lines=lines, hidden=hidden, shown=shown)
