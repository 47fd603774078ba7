"""`calibrate` on the command line."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from layerjam.cli import options as opt
from layerjam.units import show

UNITS = {"stiffness": "N/m"}


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command("calibrate")(calibrate)


def calibrate(
    brake: opt.BrakeName,
    files: opt.Files,
    depth: Annotated[
        str, typer.Option(metavar="exact|curves|bayesian", help="Peaks, whole curves, or samples.")
    ] = "exact",
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="pressure_exponent|speed|force_offset", help="Fit this too (depth curves)."
        ),
    ] = None,
    vacuum: opt.FileVacuum = None,
    out: opt.OutBrake = None,
    partial: opt.Partial = False,
    atmosphere: opt.Atmosphere = None,
    negative: opt.Negative = None,
    column: opt.Column = None,
    columns: opt.Columns = None,
    decimal: opt.Decimal = None,
    specimen: opt.Specimen = None,
    sheet: opt.Sheet = None,
    draws: Annotated[
        int, typer.Option(min=100, max=100_000, help="Draws a chain (depth bayesian).")
    ] = 1000,
    chains: Annotated[int, typer.Option(min=1, max=64, help="Chains (depth bayesian).")] = 2,
    seed: Annotated[int, typer.Option(min=0, help="Of the draws (depth bayesian).")] = 1,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Scale factor and stiffness of a brake from one or several pulls."""
    opt.check_figure(figure, force)
    opt.check_target(out, force, (".toml",))
    opt.engine()
    from layerjam.cli.old_output import say
    from layerjam.cli.ticker import Ticker
    from layerjam.commands import calibration

    with Ticker() as ticker:
        answer = calibration.calibrate(
            brake, files, depth=depth, free=tuple(dict.fromkeys(free or ())), vacuum=vacuum,
            out=out, partial=partial, atmosphere=atmosphere,
            choices=opt.choices(negative, column, decimal, columns, specimen, sheet),
            draws=draws, chains=chains, seed=seed, progress=ticker, force=force,
        )  # fmt: skip
    if figure:
        from layerjam.report import figures

        synthetic = any("synthetic" in w for w in answer.warnings)
        file, fit = answer.record
        figures.save(figures.calibration(file, fit, synthetic), figure, force)
    errors = answer.standard_errors
    shown = {
        name: _value(name, answer.values[name], answer.intervals.get(name), errors[name])
        for name in answer.intervals
    }
    lines = ["", f"standard errors rest on {errors['rests_on']}", *_influence(answer)]
    lines += ["", "checks"]
    lines += [
        f"  {'ok  ' if c['passed'] else 'LOOK'}  {c['name']}: {c['sentence']}"
        for c in answer.checks
    ]
    hidden = opt.hidden_keys(
        answer.file, "standard_errors", "checks", "understood", "refused", "intervals",
        "bootstrap", "leave_one_out", "identifiability", "posterior",
        *(["depth"] if depth == "exact" else []),
        *(n for n in calibration.DEEPER if answer.values[n] is None),
    )  # fmt: skip
    return say(answer, as_json, lines=lines, hidden=hidden, shown=shown)


def _value(name: str, value: float, interval: dict[str, Any] | None, error: float | None) -> str:
    """A number with its interval, or with the standard error where there is no more."""
    unit = UNITS.get(name, "1")
    text = f"{value:.4f}" if unit == "1" else show(value, unit)
    if interval is not None:
        low, high = (
            f"{interval[end]:.4f}" if unit == "1" else show(interval[end], unit)
            for end in ("low", "high")
        )
        return f"{text} (95 %: {low} to {high})"
    return text if error is None else f"{text} ± {show(error, unit, 2)} standard error"


def _influence(answer: Any) -> list[str]:
    """The file that moves the scale factor most, where several were given."""
    found = (answer.leave_one_out or {}).get("scale_factor")
    if not found or not found["most_influential"]:
        return []
    name = found["most_influential"]
    return [f"without {name} the scale factor would move by {found['files'][name]:+.2g}, the most"]
