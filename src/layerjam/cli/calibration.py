"""`calibrate` on the command line."""

from __future__ import annotations

import typer

from layerjam.cli import options as opt
from layerjam.units import show


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("calibrate")(calibrate)


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
    from layerjam.verbs import calibration

    answer = calibration.calibrate(
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
    hidden = opt.hidden_keys(answer.file, "standard_errors", "checks", "understood", "refused")
    return say(answer, as_json, lines=lines, hidden=hidden, shown=shown)


def _error(value: float | None, unit: str) -> str:
    return "" if value is None else f" ± {show(value, unit, 2)} standard error"
