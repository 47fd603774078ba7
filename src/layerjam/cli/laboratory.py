"""`friction`, `calibrate` and `validate` on the command line."""

from __future__ import annotations

from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.units import show


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for command in (friction, calibrate, validate):
        app.command(command.__name__)(command)


def friction(
    files: opt.Files,
    normal_force: Annotated[
        str | None, typer.Option(metavar="Q", help="Force pressing the films together, 2.45N.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="Q", help="Travel where the kinetic window starts.")
    ] = "40 mm",
    end: Annotated[
        str, typer.Option("--to", metavar="Q", help="Travel where the kinetic window ends.")
    ] = "100 mm",
    brake: Annotated[
        str | None, typer.Option(metavar="BRAKE", help="Brake to write the friction into.")
    ] = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Static and kinetic friction from friction tests, as the paper reduces them."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import laboratory

    answer = laboratory.friction(
        files, normal_force=normal_force, window=(start, end), brake=brake, out=out,
        partial=partial, choices=opt.choices(negative, column, decimal), force=force,
    )  # fmt: skip
    if figure:
        from layerjam.report import figures

        figures.save(figures.friction(*answer.record), figure, force)
    return say(answer, as_json, hidden=_hidden(answer.file, "understood", "refused"))


def calibrate(
    brake: opt.BrakeName,
    files: opt.Files,
    vacuum: opt.FileVacuum = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    atmosphere: opt.Atmosphere = None,
    negative: opt.Negative = None,
    column: opt.Column = None,
    decimal: opt.Decimal = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Scale factor and stiffness of a brake from one or several pulls."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.output import say
    from layerjam.verbs import laboratory

    answer = laboratory.calibrate(
        brake, files, vacuum=vacuum, out=out, partial=partial, atmosphere=atmosphere,
        choices=opt.choices(negative, column, decimal), force=force,
    )  # fmt: skip
    if figure:
        from layerjam.report import figures

        figures.save(figures.calibration(*answer.record), figure, force)
    errors = answer.standard_errors
    shown = {
        "scale_factor": f"{answer.scale_factor:.4f}{_error(errors['scale_factor'], '1')}",
        "stiffness": show(answer.stiffness, "N/m") + _error(errors["stiffness"], "N/m"),
    }
    lines = ["", f"standard errors rest on {errors['rests_on']}", "", "checks"]
    lines += [
        f"  {'ok  ' if c['passed'] else 'LOOK'}  {c['name']}: {c['sentence']}"
        for c in answer.checks
    ]
    hidden = _hidden(answer.file, "standard_errors", "checks", "understood", "refused")
    return say(answer, as_json, lines=lines, hidden=hidden, shown=shown)


def _hidden(file: str | None, *keys: str) -> tuple[str, ...]:
    return keys if file else (*keys, "file")


def _error(value: float | None, unit: str) -> str:
    return "" if value is None else f" ± {show(value, unit, 2)} standard error"


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
    from layerjam.verbs import laboratory

    answer = laboratory.validate(
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
