"""`validate` on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

from layerjam.cli import options as opt
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.commands.answer import Answer


HIDDEN = (
    "files", "refused", "conditions", "scatter", "uncalibrated", "mape_conditions",
    "mape_conditions_sd", "checks",
)  # fmt: skip


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
    columns: opt.Columns = None,
    specimen: opt.Specimen = None,
    sheet: opt.Sheet = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """How far the brake's model lies from measured pulls."""
    opt.check_figure(figure, force)
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import validation

    with Ticker() as ticker:
        answer = validation.validate(
            brake, files, vacuum=vacuum, atmosphere=atmosphere, progress=ticker,
            choices=opt.choices(negative, column, decimal, columns, specimen, sheet),
        )  # fmt: skip
    if figure:
        from layerjam.report import figures

        synthetic = any("synthetic" in w for w in answer.warnings)
        file, result = answer.record
        figures.save(figures.validation(file, result, synthetic), figure, force)
    return say(answer, as_json, lines=_lines(answer), hidden=HIDDEN, shown=_shown(answer))


def _shown(answer: Answer) -> dict[str, str]:
    shown = {key: f"{answer.values[key]:.2%}" for key in ("mape", "mape_sd") if answer.values[key]}
    if answer.r_squared is not None:
        shown["r_squared"] = f"{answer.r_squared:.4f}"
    return shown


def _lines(answer: Answer) -> list[str]:
    """Tables per file and per condition, and what the repeats explain."""
    lines = ["", "MAPE    RMSE      vacuum     file"]
    for row in answer.files:
        note = f" ({row['note']})" if row["note"] else ""
        lines.append(
            f"{row['mape']:<6.2%}  {show(row['rmse'], 'N', 3):<8}  {show(row['vacuum'], 'Pa'):<9}  "
            f"{row['path']}{note}"
        )
    before = answer.uncalibrated
    lines += ["", "vacuum     speed      pulls  MAPE    before calibration  scatter's share"]
    for index, row in enumerate(answer.conditions):
        was = f"{before['conditions'][index]['mape']:.2%}" if before else "-"
        speed = "-" if row["speed"] is None else show(row["speed"], "m/s", 3)
        lines.append(
            f"{show(row['vacuum'], 'Pa'):<9}  {speed:<9}  {row['repeats']:<5}  "
            f"{row['mape']:<6.2%}  {was:<18}  {_share(row['scatter'])}"
        )
    if before:
        lines += ["", f"before calibration: MAPE {before['mape']:.2%}"]
    if answer.scatter:
        lines.append(_said(answer.scatter))
    lines += ["", "checks"]
    lines += [
        f"  {'ok  ' if c['passed'] else 'LOOK'}  {c['name']}: {c['sentence']}"
        for c in answer.checks
    ]
    return lines


def _share(scatter: dict[str, Any] | None) -> str:
    if scatter is None or scatter["share"] is None:
        return "-"
    return "all of it" if scatter["model_mse"] <= 0 else f"{scatter['share']:.0%}"


def _said(scatter: dict[str, Any]) -> str:
    if scatter["share"] is None:
        return "the model meets every pull exactly"
    if scatter["model_mse"] <= 0:
        return "the model's own error cannot be told from none: the repeats scatter as much"
    return (
        f"of the mean squared error {scatter['share']:.0%} is scatter between repeats, which no "
        "model can take away"
    )
