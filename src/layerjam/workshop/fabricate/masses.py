"""Mass of each part of a build as drawn, and parts whose mass must be weighed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.film import film_parts
from layerjam.workshop.fabricate.lengths import Lengths
from layerjam.workshop.fabricate.parts import Part

STEEL = 7850.0
"""Density of screws and nuts [kg/m³]."""
SOCKET_AND_THREAD = 0.1
"""Fraction by which socket and thread reduce the volume of a screw's cylinders."""
UNWEIGHED = ("cable ties", "tube fittings", "tube", "dowel pins")
"""Parts whose mass is unknown, because the builder chooses the make."""


@dataclass(frozen=True)
class MassRow:
    """Identical parts of the brake: their number, the mass of each [kg] and its basis."""

    name: str
    count: int
    unit_mass: float
    basis: str
    fitting: bool = True
    """Whether they are fittings: neither sheets nor the enclosure between the caps."""

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return self.count * self.unit_mass


def mass_rows(brake: Brake, build: Build, lengths: Lengths, parts: Sequence[Part]) -> list[MassRow]:
    """Return the parts of one brake whose mass can be computed, in the order of the parts list."""
    film = brake.film.density * lengths.thickness * 1e-9
    rows = [
        MassRow(
            part.name,
            part.count,
            part.outline.area() * film,
            "drawn",
            not part.name.startswith("sheet"),
        )
        for part in film_parts(build, lengths)
    ]
    outer = lengths.inner_width + 2 * lengths.wall, lengths.inner_height + 2 * lengths.wall
    section = outer[0] * outer[1] - lengths.inner_width * lengths.inner_height
    silicone = section * brake.enclosure.density * 1e-9
    cap_reach = lengths.left.reach + lengths.right.reach
    rows += [
        MassRow("enclosure, cap to cap", 1, silicone * lengths.free, "drawn", False),
        MassRow("enclosure over the caps", 1, silicone * cap_reach, "drawn"),
    ]
    rows += [
        MassRow(part.name, part.count, part.solid.volume * build.print_density * 1e-9, "drawn")
        for part in parts
        if part.printed and part.stays
    ]
    count = 2 * lengths.screws
    return [
        *rows,
        MassRow(f"screw {screw_name(lengths)}", count, screw_mass(lengths), "nominal"),
        MassRow(f"nut {lengths.thread.name}", count, nut_mass(lengths), "nominal"),
    ]


def screw_name(lengths: Lengths) -> str:
    """Return the designation of the clamp screw, such as M3 × 20; only M3 for many brakes."""
    if np.ndim(lengths.screw_length):
        return lengths.thread.name
    return f"{lengths.thread.name} × {lengths.screw_length}"


def screw_mass(lengths: Lengths) -> float:
    """Return the mass of a steel cap screw, two cylinders minus a tenth [kg]."""
    thread = lengths.thread
    head = math.pi / 4 * thread.head**2 * thread.head_height
    shank = math.pi / 4 * thread.size**2 * lengths.screw_length
    return (1 - SOCKET_AND_THREAD) * (head + shank) * STEEL * 1e-9


def nut_mass(lengths: Lengths) -> float:
    """Return the mass of a nut, a steel hexagon with a hole [kg]."""
    thread = lengths.thread
    area = math.sqrt(3) / 2 * thread.nut**2 - math.pi / 4 * thread.size**2
    return area * thread.nut_height * STEEL * 1e-9
