"""`new`, `show`, `force` and `vacuum`: data of a brake and predictions."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from layerjam.commands.declare import Help, command
from layerjam.commands.quantities import (
    Array,
    Atmosphere,
    BrakeInput,
    Forces,
    OutBrake,
    Overwrite,
    Slips,
    Vacuums,
    check_vacuum,
    slip_notices,
)
from layerjam.commands.results import Figure, Result, fact, number, result
from layerjam.device.file import BrakeFile
from layerjam.device.load import load, store_file
from layerjam.errors import Notice, QuantityError
from layerjam.system import quote_word
from layerjam.units import QuantitySpec
from layerjam.units import show as in_words

SLIDING_SPEED = QuantitySpec("m/s", "sliding speed of the sheets", hi=100, example="500mm/s")
SlidingSpeed = Annotated[float | None, SLIDING_SPEED, Help("Sliding speed of the sheets.")]

FRICTION = ("scale_factor", "film.kinetic", "film.static", "pressure_exponent")
ENCLOSURE = ("enclosure.modulus", "film.friction_on_silicone")
RESTS_ON = {
    "scale_factor": ("scale_factor",),
    "stiffness_measured": ("stiffness_measured",),
    "stiffness_mount": ("stiffness_measured",),
    "holding_force": FRICTION,
    **dict.fromkeys(
        ("max_force", "energy_capacity", "force_density", "sheet_stress", "clamp_stress"),
        (*FRICTION, *ENCLOSURE),
    ),
    "peak_vacuum": (*FRICTION, *ENCLOSURE),
}
"""{measured key of `show`: numbers in a brake file on which it depends}."""


@result
class NewBrake(Result):
    """Result of writing a new brake file."""

    name: str = fact("name of the new brake")
    file: str = fact("path of its file")

    def lines(self) -> Iterator[str]:
        """Yield the command to run next."""
        yield from ("", f"Edit it, then: layerjam show {quote_word(self.file)}")


@command("predict", computes=False)
def new(
    name: Annotated[str, Help("Name of the new brake.", metavar="NAME")],
    start: Annotated[str | Path, Help("Brake to start from.", metavar="BRAKE", option="--from")],
    out: OutBrake,
    *,
    overwrite: Overwrite = False,
) -> NewBrake:
    """Write a commented brake file to edit, starting from an existing brake.

    Raises FileError if `out` exists and `overwrite` is not set, or if the name is not allowed.
    """
    # the title names the original brake; the user chooses the name of the new brake
    file = replace(load(start), title="")
    text = file.render(name)
    BrakeFile.read(text, f"brake named '{name[:80]}'")
    store_file(out, text, overwrite)
    return NewBrake(name=name, file=str(out)).with_verdicts([file])


@result
class BrakeSummary(Result):
    """Mass, forces, energy and strength of a brake; `record` is its BrakeFile."""

    record: BrakeFile
    name: str = fact("name of the brake")
    mass: float = number("kg", "mass of the brake")
    drawn_mass: float | None = number(
        "kg", ("mass of the brake as drawn by `build`; null if it cannot be drawn")
    )
    stiffness_before_slip: float = number("N/m", "stiffness before slip, eq. 1")
    stiffness_sliding: float = number("N/m", "stiffness while sliding, eq. 6, at rest lengths")
    stiffness_measured: float | None = number("N/m", "measured stiffness of the brake and rig")
    stiffness_mount: float | None = number("N/m", "stiffness of the mount, inferred from both")
    usable_travel: float = number("m", "usable slip of the brake")
    max_force: float = number("N", "peak force of a pull at the site's full vacuum")
    holding_force: float = number("N", "static holding force at the same vacuum")
    energy_capacity: float = number("J", "work over the usable travel at the same vacuum")
    force_density: float = number("N/kg", "ratio of maximum force to mass")
    buckling_force: float = number("N", "compression at which one sheet buckles, fixed–free")
    sheet_stress: float = number("Pa", "stress in the sheets at the maximum force")
    clamp_stress: float = number("Pa", "stress in the sheets next to the screw holes")
    film_strength: float | None = number("Pa", "yield stress of the film")
    scale_factor: float = number("1", "calibration factor on the sheets' friction")
    peak_vacuum: float = number("Pa", "vacuum above which a pull has a peak")
    sources: Mapping[str, str] = fact("source of each number", listed=False)

    def rows(self) -> list[tuple[str, str]]:
        """Yield the numbers; those that depend on an accepted failed check name the check."""
        rows = []
        for name, text in super().rows():
            paths = RESTS_ON.get(name.replace(" ", "_"), ())
            checks = [
                f"{acceptance['check']}, accepted {acceptance['date']}"
                for acceptance in self.accepted
                if not acceptance["numbers"] or {*paths} & {*acceptance["numbers"]}
            ]
            rows.append((name, f"{text} (failed check: {'; '.join(checks)})" if checks else text))
        return rows

    def draw(self) -> Figure:
        """Return the figure of the brake with every named length and force."""
        from layerjam.report.device_drawing import draw_device

        return draw_device(self.record)

    def lines(self) -> Iterator[str]:
        """Yield the sources of the numbers."""
        yield from ("", "sources of the numbers")
        for path, text in self.sources.items():
            yield f"  {path}: {text}"


@command("predict")
def show(brake: BrakeInput, *, atmosphere: Atmosphere = None) -> BrakeSummary:
    """Show mass, forces, energy and strength of a brake, and the source of each number."""
    from layerjam.device.brake import mass
    from layerjam.device.gauge import gauge_notices
    from layerjam.fabricate.drawn_mass import drawn_mass
    from layerjam.mechanics import energy, friction, limits, pull, stiffness

    device = replace(brake.brake, hyperelastic=None)
    full = device.site.atmosphere
    peak = pull.peak(full, device.sheets.usable_travel, device)
    weight, strength = mass(device), device.film.strength
    stress = float(limits.clamp_stress(peak.force, device))
    mount = float(stiffness.mount_stiffness(device))
    notices = [*brake.warnings(), *gauge_notices(brake)]
    if brake.brake.hyperelastic is not None:
        sentence = (
            "these numbers use the single modulus of the enclosure, not its [hyperelastic] law"
        )
        notices.append(Notice(sentence, "one-modulus"))
    if not bool(peak.inside):
        notices.append(
            Notice("even at full vacuum a pull has no peak: the force rises to the end", "no-peak")
        )
    if strength is not None and stress > strength:
        notices.append(
            Notice(
                "at the maximum force the stress at the clamp exceeds the film's strength",
                "clamp-stress",
            )
        )
    return BrakeSummary(
        name=brake.name,
        mass=weight,
        drawn_mass=drawn_mass(brake),
        stiffness_before_slip=float(stiffness.stiffness_before_slip(device)),
        stiffness_sliding=float(stiffness.stiffness_sliding(0.0, device)),
        stiffness_measured=device.stiffness_measured,
        stiffness_mount=mount if math.isfinite(mount) else None,
        usable_travel=device.sheets.usable_travel,
        max_force=float(peak.force),
        holding_force=float(friction.holding_force(full, device)),
        energy_capacity=float(energy.energy_capacity(device)),
        force_density=float(peak.force) / weight,
        buckling_force=float(limits.buckling_force(0.0, device)),
        sheet_stress=float(limits.sheet_stress(peak.force, device)),
        clamp_stress=stress,
        film_strength=strength,
        scale_factor=device.scale_factor,
        peak_vacuum=float(pull.peak_vacuum(device)),
        sources={path: source.sentence() for path, source in brake.sources.items()},
        warnings=notices,
        record=brake,
    )


@result
class BrakeForce(Result):
    """Forces of the sliding brake, numbers or arrays of the broadcast shape.

    `record` is (BrakeFile, vacuum, slip).
    """

    record: tuple[BrakeFile, float | Array, float | Array]
    sheet_friction: float = number("N", "friction of the jammed sheets, eq. 4 and 7")
    enclosure_force: float = number("N", "force of the enclosure, eq. 5")
    force: float = number("N", "total force of the brake")

    def draw(self) -> Figure:
        """Return force versus slip, with the slip marked; for arrays, versus their first axis."""
        from layerjam.report import figures

        if self.grid is not None:
            return self.draw_panes(self.grid.panes("force", self.force, "N"))
        file, *case = self.record
        return figures.plot_force_slip(file, *map(float, case))


@command("predict")
def force(
    brake: BrakeInput,
    *,
    slip: Slips,
    vacuum: Vacuums,
    sliding_speed: SlidingSpeed = None,
    atmosphere: Atmosphere = None,
) -> BrakeForce:
    """Compute the force of the sliding brake at a slip and a vacuum.

    Arrays of slip and vacuum broadcast. Without a `sliding_speed` it is the force at the speed at
    which friction was measured. Raises QuantityError for a slip beyond the overlap or a vacuum
    above atmospheric pressure.
    """
    from layerjam.mechanics.enclosure import enclosure_force
    from layerjam.mechanics.friction import sheet_friction, sheet_friction_at
    from layerjam.simulate.speed import list_force_notices

    check_vacuum(vacuum, brake.brake)
    notices = slip_notices(slip, brake.brake)
    sheets = _convert_to_numbers(
        sheet_friction(slip, vacuum, brake.brake)
        if sliding_speed is None
        else sheet_friction_at(slip, sliding_speed, vacuum, brake.brake)
    )
    enclosure = _convert_to_numbers(enclosure_force(slip, vacuum, brake.brake))
    _check_fitted_strain(enclosure, vacuum, brake.brake)
    return BrakeForce(
        sheet_friction=sheets,
        enclosure_force=enclosure,
        force=sheets + enclosure,
        warnings=[*brake.warnings(), *notices, *list_force_notices(brake, sliding_speed)],
        record=(brake, vacuum, slip),
    )


def _check_fitted_strain(enclosure: Any, vacuum: Any, device: Any) -> None:
    """Raise an error if a hyperelastic enclosure is stretched beyond the fitted strain."""
    import numpy as np

    if device.hyperelastic is None or np.isfinite(enclosure).all():
        return
    from layerjam.mechanics.hyperelastic import largest_slip

    greatest = float(np.min(largest_slip(vacuum, device)))
    raise QuantityError.of(
        "slip",
        f"above {in_words(greatest, 'm')} the enclosure is stretched beyond the measured "
        f"{device.hyperelastic.strain:.0%} (hyperelastic.strain)",
    )


def _convert_to_numbers(value: Any) -> Any:
    import numpy as np

    array = np.asarray(value)
    return array if array.shape else float(array)


@result
class VacuumForForce(Result):
    """Vacuum at which the brake resists with a given force, or why there is none.

    `record` is (BrakeFile, slip, force, vacuum).
    """

    record: tuple[BrakeFile, float | Array, float | Array, float | Array]
    vacuum: float | None = number("Pa", "vacuum that produces the force; null if there is none")
    feasible: bool = fact("for each element, whether there is such a vacuum")
    reason: str | None = fact("reason for the first element without such a vacuum")
    least_force: float = number("N", "force of the enclosure alone at that slip")
    greatest_force: float = number("N", "force at the site's full vacuum at that slip")

    def draw(self) -> Figure:
        """Return force versus vacuum, with the force marked; for arrays, vacuum versus force."""
        from layerjam.report import figures

        if self.grid is not None:
            return self.draw_panes(self.grid.panes("vacuum", self.vacuum, "Pa"))
        file, *case = self.record
        return figures.plot_force_vacuum(file, *map(float, case))


@command("predict")
def vacuum(
    brake: BrakeInput,
    *,
    slip: Slips,
    force: Forces,
    sliding_speed: SlidingSpeed = None,
    atmosphere: Atmosphere = None,
) -> VacuumForForce:
    """Find the vacuum at which the sliding brake resists with a force at a slip.

    `feasible` is False, with a `reason`, for a force below the enclosure's own or above that at the
    site's full vacuum. Arrays of slip and force broadcast; the vacuum is NaN for elements without
    one. Without a `sliding_speed` the force is that at the speed at which friction was measured.
    """
    import numpy as np

    from layerjam.mechanics.pull import force_limits, vacuum_for_force
    from layerjam.simulate.speed import list_force_notices

    notices = [*slip_notices(slip, brake.brake), *list_force_notices(brake, sliding_speed)]
    brake = _apply_sliding_speed(brake, sliding_speed)
    pressure = _convert_to_numbers(vacuum_for_force(force, slip, brake.brake))
    low, high = (_convert_to_numbers(edge) for edge in force_limits(slip, brake.brake))
    feasible = np.isfinite(pressure)
    none = np.ndim(pressure) == 0 and not feasible
    return VacuumForForce(
        vacuum=None if none else pressure,
        feasible=feasible if np.ndim(pressure) else bool(feasible),
        reason=None
        if feasible.all()
        else _explain_missing_vacuum(brake.brake, slip, force, pressure, low, high),
        least_force=low,
        greatest_force=high,
        warnings=[*brake.warnings(), *notices],
        record=(brake, slip, force, pressure),
    )


def _apply_sliding_speed(file: BrakeFile, speed: Any) -> BrakeFile:
    """Return the file with the friction at a sliding speed [m/s], if one is given."""
    from layerjam.mechanics.friction import fix_speed

    return file if speed is None else replace(file, brake=fix_speed(speed, file.brake))


def _explain_missing_vacuum(
    device: Any, slip: Any, force: Any, pressure: Any, low: Any, high: Any
) -> str:
    """Return the reason for the first case in which no vacuum exists."""
    import numpy as np

    missing = np.flatnonzero(~np.isfinite(np.ravel(pressure)))[0]
    cases = np.broadcast_arrays(slip, force, low, high)
    x, target, least, greatest = (float(np.ravel(case)[missing]) for case in cases)
    place = f"at {in_words(x, 'm')}"
    if target < least:
        return (
            f"{place} the enclosure alone resists with {in_words(least, 'N')}; no vacuum "
            "reduces this"
        )
    full = in_words(device.site.atmosphere, "Pa", 6)
    return (
        f"{place} this brake reaches at most {in_words(greatest, 'N')}, at the site's full vacuum "
        f"of {full}"
    )
