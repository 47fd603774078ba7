"""`force`, `vacuum` and `tensile`: what a brake will do."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.cli.output import Answer
from layerjam.errors import ProcedureError, QuantityError
from layerjam.units import show


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("force")(force)
    app.command("vacuum")(vacuum)
    app.command("tensile")(tensile)


def force(
    brake: opt.BrakeName,
    slip: opt.Slip,
    vacuum: opt.Vacuum,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    replace: opt.Force = False,
) -> None:
    """Force of the sliding brake at a slip and a vacuum."""
    opt.check_figure(figure, replace)
    file = opt.brake_at(brake, atmosphere)
    pressure = opt.read_vacuum(vacuum, file.brake)
    x, warnings = opt.read_slip(slip, file.brake)
    opt.engine()
    from layerjam.mechanics.enclosure import enclosure_force
    from layerjam.mechanics.friction import sheet_friction

    sheets = float(sheet_friction(x, pressure, file.brake))
    sleeve = float(enclosure_force(x, pressure, file.brake))
    if figure:
        from layerjam.report import figures

        figures.save(figures.force_over_slip(file, pressure, x), figure, replace)
    keys = ("sheet_friction", "enclosure_force", "force")
    Answer(
        values=dict(zip(keys, (sheets, sleeve, sheets + sleeve), strict=True)),
        units=dict.fromkeys(keys, "N"),
        warnings=file.warnings() + warnings,
    ).print(as_json)


def vacuum(
    brake: opt.BrakeName,
    slip: opt.Slip,
    force: Annotated[str, typer.Option(metavar="Q", help="Force wanted, e.g. 100N.")],
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    replace: opt.Replace = False,
) -> int:
    """Vacuum that makes the sliding brake resist with a force at a slip."""
    opt.check_figure(figure, replace)
    file = opt.brake_at(brake, atmosphere)
    x, warnings = opt.read_slip(slip, file.brake)
    wanted = opt.FORCE.read(force, "--force")
    opt.engine()
    import math

    from layerjam.mechanics.pull import force_limits, vacuum_for_force

    pressure = float(vacuum_for_force(wanted, x, file.brake))
    low, high = (float(f) for f in force_limits(x, file.brake))
    feasible = math.isfinite(pressure)
    reason = None
    if not feasible and wanted < low:
        reason = (
            f"at {show(x, 'm')} the sleeve alone resists with {show(low, 'N')}; no vacuum makes "
            f"it less"
        )
    elif not feasible:
        reason = (
            f"at {show(x, 'm')} this brake reaches {show(high, 'N')} at most, at the site's full "
            f"vacuum of {show(file.brake.site.atmosphere, 'Pa', 6)}"
        )
    if figure:
        from layerjam.report import figures

        figures.save(figures.force_over_vacuum(file, x, wanted, pressure), figure, replace)
    Answer(
        values={
            "vacuum": pressure if feasible else None,
            "feasible": feasible,
            "reason": reason,
            "least_force": low,
            "greatest_force": high,
        },
        units={"vacuum": "Pa", "least_force": "N", "greatest_force": "N"},
        warnings=file.warnings() + warnings,
    ).print(as_json)
    return 0 if feasible else 1


def tensile(
    brake: opt.BrakeName,
    vacuum: Annotated[str | None, typer.Option(metavar="Q", help="Vacuum, e.g. 94.5kPa.")] = None,
    speed: Annotated[str | None, typer.Option(metavar="Q", help="Crosshead speed.")] = None,
    travel: Annotated[str | None, typer.Option(metavar="Q", help="Elongation to pull to.")] = None,
    procedure: Annotated[
        str | None,
        typer.Option(metavar="TEXT", help="Steps instead, e.g. 'evacuate to 50 kPa; pull at 1 "
                     "mm/s until 20 mm; return at 1 mm/s to 0 mm'."),  # fmt: skip
    ] = None,
    model: Annotated[str, typer.Option(help="lumped, or stack (not yet).")] = "lumped",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the record: .csv or .nc.")
    ] = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> None:
    """Pull the brake in a simulated test machine."""
    from layerjam.simulate import procedure as proc

    opt.check_figure(figure, force)
    opt.check_target(out, force)
    if out is not None and out.suffix.lower() not in (".csv", ".nc"):
        raise QuantityError(f"--out: the ending '{out.suffix}' is not known; use .csv or .nc")
    if model != "lumped":
        known = "is not part of this version yet" if model == "stack" else "is not known"
        raise QuantityError(f"--model: '{model}' {known}; lumped is")
    file = opt.brake_at(brake, atmosphere)
    given = {"--vacuum": vacuum, "--speed": speed, "--travel": travel}
    if procedure is not None:
        both = [name for name, value in given.items() if value is not None]
        if both:
            raise ProcedureError(f"give --procedure or {', '.join(both)}, not both")
        steps = proc.parse_procedure(procedure)
    else:
        if vacuum is None or speed is None or travel is None:
            missing = [name for name, value in given.items() if value is None]
            raise ProcedureError(f"{', '.join(missing)} missing (or give --procedure)")
        steps = proc.simple_pull(
            opt.read_vacuum(vacuum, file.brake),
            opt.SPEED.read(speed, "--speed"),
            opt.TRAVEL.read(travel, "--travel"),
        )
    opt.engine()
    import numpy as np

    from layerjam.simulate.tensile import tensile as run

    record = run(file, steps)
    top = int(np.argmax(record.force))
    if out is not None:
        record.save(out, force=force)
    if figure:
        from layerjam.report import figures

        figures.save(figures.tensile(record), figure, force)
    Answer(
        values={
            "peak_force": float(record.force[top]),
            "peak_elongation": float(record.elongation[top]),
            "force_at_end": float(record.force[-1]),
            "work": float(record.work[-1]),
            "dissipated_energy": float(record.dissipated_energy[-1]),
            "outcome": str(record.outcome),
            "procedure": record.procedure,
            "file": str(out) if out else None,
        },
        units={
            "peak_force": "N", "peak_elongation": "m", "force_at_end": "N", "work": "J",
            "dissipated_energy": "J",
        },  # fmt: skip
        warnings=record.warnings,
    ).print(as_json)
