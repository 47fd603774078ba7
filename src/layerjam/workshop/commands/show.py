"""`show`: mass, forces and strength of a brake, with the source of each number."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from layerjam.brake.commands.arguments import (
    Atmosphere,
    BrakeInput,
    Interval,
    OtherFilm,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.command.declare import command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Figure, fact, number, result
from layerjam.core.errors import Notice

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
class BrakeSummary(PredictionResult):
    """Mass, forces, energy and strength of a brake; `record` is its BrakeFile."""

    record: BrakeFile
    name: str = fact("name of the brake")
    mass: float = number("kg", "mass of the brake")
    drawn_mass: float | None = number(
        "kg", "mass of the brake as drawn by `build`; null if it cannot be drawn"
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
        from layerjam.brake.figures.device_drawing import draw_device

        return draw_device(self.record)

    def lines(self) -> Iterator[str]:
        """Yield the sources of the numbers."""
        yield from ("", "sources of the numbers")
        for path, text in self.sources.items():
            yield f"  {path}: {text}"


@command("predict")
def show(
    brake: BrakeInput,
    *,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
) -> BrakeSummary:
    """Show mass, forces, energy and strength of a brake, and the source of each number."""
    from layerjam.brake.device.brake import mass
    from layerjam.brake.device.gauge import gauge_notices
    from layerjam.brake.mechanics import energy, friction, limits, pull, stiffness
    from layerjam.brake.mechanics.effects import has_single_modulus, use_single_modulus
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.workshop.fabricate.drawn_mass import drawn_mass

    device = use_single_modulus(brake.brake)
    full_vacuum, travel = device.site.atmosphere, device.sheets.usable_travel
    peak = pull.peak(full_vacuum, travel, device)
    weight, strength = mass(device), device.film.strength

    def find_forces(record: Any) -> dict[str, Any]:
        max_force = pull.peak(full_vacuum, travel, record).force
        return {
            "max_force": max_force,
            "holding_force": friction.holding_force(full_vacuum, record),
            "energy_capacity": energy.energy_capacity(record),
            "force_density": max_force / weight,
            "sheet_stress": limits.sheet_stress(max_force, record),
            "clamp_stress": limits.clamp_stress(max_force, record),
            "peak_vacuum": pull.peak_vacuum(record),
        }

    forces: dict[str, Any] = {name: float(value) for name, value in find_forces(device).items()}
    mount = float(stiffness.mount_stiffness(device))
    notices = [*brake.warnings(), *gauge_notices(brake)]
    if not has_single_modulus(brake.brake):
        words = "these numbers use the single modulus of the enclosure, not its [hyperelastic] law"
        notices.append(Notice(words, "one-modulus"))
    if not bool(peak.inside):
        text = "even at full vacuum a pull has no peak: the force rises to the end"
        notices.append(Notice(text, "no-peak"))
    prediction = Prediction(brake, full_vacuum, travel, None, device, interval == "mean")
    stated = prediction.state(**find_forces(prediction.brakes))
    greatest_stress = stated["intervals"]["clamp_stress"]["high"] or math.inf
    notices += _stress_notices(forces["clamp_stress"], greatest_stress, strength)
    notices += prediction.notices()
    return BrakeSummary(
        name=brake.name,
        mass=weight,
        drawn_mass=drawn_mass(brake),
        stiffness_before_slip=float(stiffness.stiffness_before_slip(device)),
        stiffness_sliding=float(stiffness.stiffness_sliding(0.0, device)),
        stiffness_measured=device.stiffness_measured,
        stiffness_mount=mount if math.isfinite(mount) else None,
        usable_travel=travel,
        **forces,
        **stated,
        buckling_force=float(limits.buckling_force(0.0, device)),
        film_strength=strength,
        scale_factor=device.scale_factor,
        sources={path: source.sentence() for path, source in brake.sources.items()},
        warnings=notices,
        record=brake,
    )


def _stress_notices(stress: float, greatest: float, strength: float | None) -> Iterator[Notice]:
    """Yield a notice if the stress at the clamp [Pa] exceeds the film's strength, or may do so."""
    if strength is None or max(stress, greatest) <= strength:
        return
    verb = "exceeds" if stress > strength else "may exceed"
    yield Notice(
        f"at the maximum force the stress at the clamp {verb} the film's strength", "clamp-stress"
    )
