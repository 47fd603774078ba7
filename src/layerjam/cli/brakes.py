"""`new` and `show`: a brake's file and its figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from layerjam.cli import options as opt
from layerjam.cli.output import Answer
from layerjam.errors import QuantityError


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("new")(new)
    app.command("show")(show)


def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new brake.")],
    start: Annotated[str, typer.Option("--from", metavar="BRAKE", help="Brake to start from.")],
    out: Annotated[Path, typer.Option(metavar="FILE.toml", help="File to write.")],
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> None:
    """Write a commented brake file to edit, starting from another brake."""
    from layerjam.device.file import read_brake, render
    from layerjam.device.load import load, materials, write_whole

    if out.suffix != ".toml":
        raise QuantityError(f"--out: '{out}' does not end in .toml")
    text = render(load(start), name)
    read_brake(text, f"brake named '{name[:80]}'", materials())
    write_whole(out, lambda p: _fill(p, text), force)
    Answer(
        values={"name": name, "file": str(out)},
        units={},
        lines=["", f"Edit it, then: layerjam show {out}"],
    ).print(as_json)


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def show(
    brake: opt.BrakeName,
    atmosphere: opt.Atmosphere = None,
    as_json: opt.AsJson = False,
) -> None:
    """What a brake weighs, holds, stores and bears, and where its numbers come from."""
    opt.engine()
    from layerjam.device.brake import mass
    from layerjam.mechanics import energy, friction, limits, pull, stiffness

    file = opt.brake_at(brake, atmosphere)
    device = file.brake
    full = device.site.atmosphere
    peak = pull.peak(full, device.sheets.usable_travel, device)
    weight = mass(device)
    strength = device.film.strength
    values = {
        "name": file.name,
        "mass": weight,
        "stiffness_before_slip": float(stiffness.stiffness_before_slip(device)),
        "stiffness_sliding": float(stiffness.stiffness_sliding(0.0, device)),
        "stiffness_measured": device.stiffness_measured,
        "stiffness_mount": float(stiffness.mount_stiffness(device)),
        "usable_travel": device.sheets.usable_travel,
        "max_force": float(peak.force),
        "holding_force": float(friction.holding_force(full, device)),
        "energy_capacity": float(energy.energy_capacity(device)),
        "force_density": float(peak.force) / weight,
        "buckling_force": float(limits.buckling_force(0.0, device)),
        "sheet_stress": float(limits.sheet_stress(peak.force, device)),
        "clamp_stress": float(limits.clamp_stress(peak.force, device)),
        "film_strength": strength,
        "scale_factor": device.scale_factor,
        "peak_vacuum": float(pull.peak_vacuum(device)),
        "sources": {path: source.sentence() for path, source in file.sources.items()},
    }
    units = {
        "mass": "kg", "stiffness_before_slip": "N/m", "stiffness_sliding": "N/m",
        "stiffness_measured": "N/m", "stiffness_mount": "N/m", "usable_travel": "m",
        "max_force": "N", "holding_force": "N", "energy_capacity": "J", "force_density": "N/kg",
        "buckling_force": "N", "sheet_stress": "Pa", "clamp_stress": "Pa", "film_strength": "Pa",
        "scale_factor": "1", "peak_vacuum": "Pa",
    }  # fmt: skip
    warnings = file.warnings()
    if not bool(peak.inside):
        warnings.append("even at full vacuum a pull has no peak: the force rises to the end")
    if strength is not None and float(values["clamp_stress"]) > strength:
        warnings.append("at the greatest force the stress at the clamp exceeds the film's strength")
    lines = ["", "where the numbers come from"]
    lines += [f"  {path}: {source.sentence()}" for path, source in file.sources.items()]
    Answer(
        values=values, units=units, warnings=warnings, lines=lines, hidden=("sources",)
    ).print(as_json)
