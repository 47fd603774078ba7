"""`new`, `show`, `force`, `vacuum`, `tensile`: what a brake is and will do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.commands.answer import (
    FORCE,
    SPEED,
    TRAVEL,
    Answer,
    AnyBrake,
    Quantity,
    brake_at,
    si,
    slip_of,
    vacuum_of,
)
from layerjam.device.brake import mass
from layerjam.device.file import BrakeFile, read_brake, render
from layerjam.device.load import load, materials, write_whole
from layerjam.errors import ProcedureError, QuantityError
from layerjam.mechanics import energy, friction, limits, pull, stiffness
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.simulate.procedure import Procedure, parse_procedure, simple_pull
from layerjam.simulate.tensile import tensile as run_tensile
from layerjam.units import QuantitySpec
from layerjam.units import show as in_words

if TYPE_CHECKING:
    from layerjam.simulate.stack_layout import Housing, Interfaces

MODELS = ("lumped", "stack")
_SCATTER = QuantitySpec("1", "relative scatter of the interfaces' friction", hi=2)
_SAMPLES = QuantitySpec("1", "stacks pulled", lo=2, hi=10_000_000, whole=True)
_SEED = QuantitySpec("1", "seed", hi=2**63 - 1, whole=True)


def new(name: str, start: str, out: str | Path, *, force: bool = False) -> Answer:
    """Write a complete, commented brake file named `name` to `out`, starting from another brake.

    Raises FileError where `out` exists and `force` is not set, or the name will not do.
    """
    if Path(out).suffix != ".toml":
        raise QuantityError(f"out: '{out}' does not end in .toml")
    # the title names the brake it was; the new one is its owner's to name
    text = render(replace(load(start), title=""), name)
    read_brake(text, f"brake named '{name[:80]}'", materials())
    write_whole(out, lambda p: _fill(p, text), force)
    return Answer(values={"name": name, "file": str(out)}, units={})


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def show(brake: AnyBrake, *, atmosphere: Quantity | None = None) -> Answer:
    """What a brake weighs, holds, stores and bears, and where each of its numbers comes from."""
    file = brake_at(brake, atmosphere)
    device = file.brake
    full = device.site.atmosphere
    peak = pull.peak(full, device.sheets.usable_travel, device)
    weight, strength = mass(device), device.film.strength
    clamped = float(limits.clamp_stress(peak.force, device))
    values = {
        "name": file.name,
        "mass": weight,
        "stiffness_before_slip": float(stiffness.stiffness_before_slip(device)),
        "stiffness_sliding": float(stiffness.stiffness_sliding(0.0, device)),
        "stiffness_measured": device.stiffness_measured,
        "stiffness_mount": _known(stiffness.mount_stiffness(device)),
        "usable_travel": device.sheets.usable_travel,
        "max_force": float(peak.force),
        "holding_force": float(friction.holding_force(full, device)),
        "energy_capacity": float(energy.energy_capacity(device)),
        "force_density": float(peak.force) / weight,
        "buckling_force": float(limits.buckling_force(0.0, device)),
        "sheet_stress": float(limits.sheet_stress(peak.force, device)),
        "clamp_stress": clamped,
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
    if strength is not None and clamped > strength:
        warnings.append("at the greatest force the stress at the clamp exceeds the film's strength")
    return Answer(values=values, units=units, warnings=warnings, record=file)


def _known(value: object) -> float | None:
    number = float(value)  # type: ignore[arg-type]
    return number if math.isfinite(number) else None


def force(
    brake: AnyBrake, *, slip: Quantity, vacuum: Quantity, atmosphere: Quantity | None = None
) -> Answer:
    """Force of the sliding brake at a slip and a vacuum: of the sheets, of the sleeve, of both.

    Raises QuantityError for a slip beyond the overlap or a vacuum above the atmosphere.
    """
    file = brake_at(brake, atmosphere)
    pressure = vacuum_of(vacuum, file.brake)
    x, warnings = slip_of(slip, file.brake)
    sheets = float(friction.sheet_friction(x, pressure, file.brake))
    sleeve = float(enclosure_force(x, pressure, file.brake))
    keys = ("sheet_friction", "enclosure_force", "force")
    return Answer(
        values=dict(zip(keys, (sheets, sleeve, sheets + sleeve), strict=True)),
        units=dict.fromkeys(keys, "N"),
        warnings=file.warnings() + warnings,
        record=(file, pressure, x),
    )


def vacuum(
    brake: AnyBrake, *, slip: Quantity, force: Quantity, atmosphere: Quantity | None = None
) -> Answer:
    """Vacuum that makes the sliding brake resist with a force at a slip.

    `feasible` is False, with a `reason`, for a force below the sleeve's own or above that at the
    site's full vacuum.
    """
    file = brake_at(brake, atmosphere)
    x, warnings = slip_of(slip, file.brake)
    wanted = si(force, FORCE, "force")
    pressure = float(pull.vacuum_for_force(wanted, x, file.brake))
    low, high = (float(f) for f in pull.force_limits(x, file.brake))
    feasible = math.isfinite(pressure)
    reason = None
    if not feasible:
        where = f"at {in_words(x, 'm')}"
        full = in_words(file.brake.site.atmosphere, "Pa", 6)
        reason = (
            f"{where} the sleeve alone resists with {in_words(low, 'N')}; no vacuum makes it less"
            if wanted < low
            else f"{where} this brake reaches {in_words(high, 'N')} at most, at the site's full "
            f"vacuum of {full}"
        )
    return Answer(
        values={
            "vacuum": pressure if feasible else None,
            "feasible": feasible,
            "reason": reason,
            "least_force": low,
            "greatest_force": high,
        },
        units={"vacuum": "Pa", "least_force": "N", "greatest_force": "N"},
        warnings=file.warnings() + warnings,
        record=(file, x, wanted, pressure),
    )


def tensile(
    brake: AnyBrake,
    *,
    vacuum: Quantity | None = None,
    speed: Quantity | None = None,
    travel: Quantity | None = None,
    procedure: str | Procedure | None = None,
    model: str = "lumped",
    static: bool = False,
    interfaces: Interfaces | None = None,
    housing: Housing | None = None,
    scatter: Quantity | None = None,
    samples: int | None = None,
    seed: int | None = None,
    progress: Callable[[str, float], None] | None = None,
    atmosphere: Quantity | None = None,
) -> Answer:
    """Pull a brake in a simulated test machine; `record` is the TensileRecord.

    Either vacuum, speed and travel (elongation of the crosshead), or a procedure. Only for the
    model "stack": `static` friction before an interface slides, `interfaces` that differ, a
    `housing` that rubs, and `scatter`, the relative SD of the interfaces' friction: then `samples`
    (1000) stacks, drawn from `seed` (1), tell mean and SD of peak, stiffness and onset; interrupted
    from the keyboard, of those that are done. `progress` is told (what, share done). Raises
    ProcedureError or QuantityError for what contradicts itself.
    """
    if model not in MODELS:
        raise QuantityError(f"model: '{model[:40]}' is not known; {' and '.join(MODELS)} are")
    if scatter is None and (samples is not None or seed is not None):
        raise QuantityError("samples and seed belong to scatter; give it too")
    file = brake_at(brake, atmosphere)
    steps = _steps(file.brake, vacuum, speed, travel, procedure)
    more: dict[str, Any] = {}
    units: dict[str, str] = {}
    notes: list[str] = []
    if model == "stack":
        from layerjam.simulate.stack import tensile_stack  # compiled loops, only where asked for

        vacuum_of(steps.highest_vacuum(), file.brake)
        wide = None if scatter is None else si(scatter, _SCATTER, "scatter")
        layout: dict[str, Any] = {"static": static, "interfaces": interfaces, "housing": housing}
        tell = progress or (lambda _what, _share: None)
        tell("pull", 0.0)
        record, _ = tensile_stack(file, steps, **layout, progress=lambda p: tell("pull", p))
        if wide is not None:
            count, start = 1000 if samples is None else samples, 1 if seed is None else seed
            _SAMPLES.check(count, "samples")
            _SEED.check(start, "seed")
            more, units, notes = _spread(file, steps, wide, count, start, layout, tell)
    elif static or scatter is not None or interfaces is not None or housing is not None:
        raise QuantityError(
            "static, scatter, interfaces and housing belong to the model 'stack'; the lumped brake "
            "has one friction"
        )
    else:
        record = run_tensile(file, steps)
    top = int(np.argmax(record.force))
    return Answer(
        values={
            "peak_force": float(record.force[top]),
            "peak_elongation": float(record.elongation[top]),
            "force_at_end": float(record.force[-1]),
            "work": float(record.work[-1]),
            "dissipated_energy": float(record.dissipated_energy[-1]),
            "outcome": str(record.outcome),
            "procedure": record.procedure,
            **more,
        },
        units={
            "peak_force": "N",
            "peak_elongation": "m",
            "force_at_end": "N",
            "work": "J",
            "dissipated_energy": "J",
            **units,
        },
        warnings=[*record.warnings, *notes],
        record=record,
    )


def _spread(
    file: BrakeFile,
    steps: Procedure,
    scatter: float,
    samples: int,
    seed: int,
    layout: dict[str, Any],
    tell: Callable[[str, float], None],
) -> tuple[dict[str, Any], dict[str, str], list[str]]:
    """Mean and sample SD over stacks whose interfaces scatter; units; what there is to say."""
    from layerjam.simulate.stack_spread import peak_spread

    tell("scatter", 0.0)
    spread = peak_spread(
        file, steps.highest_vacuum(), scatter, samples, seed, **layout,
        progress=lambda done, asked: tell("scatter", done / asked),
    )  # fmt: skip
    values: dict[str, Any] = {"samples": spread.done, "seed": seed, "scatter": scatter}
    units = {"samples": "1", "seed": "1", "scatter": "1"}
    for name, unit in (("peak", "N"), ("stiffness", "N/m"), ("onset", "N")):
        found = getattr(spread, name)
        found = found[np.isfinite(found)]
        values[f"{name}_mean"] = float(found.mean()) if len(found) else None
        values[f"{name}_sd"] = float(found.std(ddof=1)) if len(found) > 1 else None
        units |= {f"{name}_mean": unit, f"{name}_sd": unit}
    notes = []
    if spread.done < samples:
        notes.append(f"stopped: {spread.done} of {samples} stacks were pulled, and those count")
    if not np.isfinite(spread.peak).all():
        lost = int((~np.isfinite(spread.peak)).sum())
        notes.append(f"{lost} of {spread.done} stacks could not be followed to their peak")
    return values, units, notes


def _steps(
    brake: object,
    vacuum: Quantity | None,
    speed: Quantity | None,
    travel: Quantity | None,
    procedure: str | Procedure | None,
) -> Procedure:
    given = {"vacuum": vacuum, "speed": speed, "travel": travel}
    if procedure is not None:
        both = [name for name, value in given.items() if value is not None]
        if both:
            raise ProcedureError(f"give a procedure or {', '.join(both)}, not both")
        return procedure if isinstance(procedure, Procedure) else parse_procedure(procedure)
    if vacuum is None or speed is None or travel is None:
        missing = [name for name, value in given.items() if value is None]
        raise ProcedureError(f"{', '.join(missing)} missing (or give a procedure)")
    return simple_pull(
        vacuum_of(vacuum, brake),  # type: ignore[arg-type]
        si(speed, SPEED, "speed"),
        si(travel, TRAVEL, "travel"),
    )
