"""What a brake is made of as it would be drawn, by closed forms: no file, no mesh, no library."""

from __future__ import annotations

from dataclasses import dataclass

from layerjam.design.bill import Bill
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.workshop import Build, agree
from layerjam.errors import FileError, QuantityError
from layerjam.fabricate.checks import agree_drawn, clamp_checks, wall_check
from layerjam.fabricate.choices import choices
from layerjam.fabricate.film import film_parts
from layerjam.fabricate.lengths import CannotBuildError, lengths
from layerjam.fabricate.masses import mass_rows
from layerjam.fabricate.parts import parts
from layerjam.fabricate.verdicts import refusals


@dataclass(frozen=True)
class Draws:
    """Draws brakes by one workshop's choices and says what each is made of."""

    build: Build

    def __call__(self, brake: Brake) -> Bill | None:
        """The bill of one brake; None where its parts would not fit together.

        Volumes by closed form would then mean nothing, and `build` says what does not fit.
        """
        build = self.build
        try:
            agree(brake, build)
            found = lengths(brake, build)
            agree_drawn(brake, build, found)
            if refusals([*clamp_checks(build, found), wall_check(build, found)]):
                return None
            made = parts(found, build)
            rows = mass_rows(brake, build, found, made)
            film = film_parts(build, found)
        except (CannotBuildError, QuantityError):
            return None
        volumes = {
            stays: sum(p.solid.volume * p.count for p in made if p.printed and p.stays is stays)
            for stays in (True, False)
        }
        return Bill(
            film_area=sum(part.outline.area() * part.count for part in film) * 1e-6,
            printed=volumes[True] * 1e-9,
            tools=volumes[False] * 1e-9,
            mass=sum(row.mass for row in rows),
        )


def drawn_mass(file: BrakeFile) -> float | None:
    """Mass [kg] of one brake as `build` draws it, of the parts that have a mass before weighing.

    None where its parts would not fit together.
    """
    try:
        found = Draws(choices(file).build)(file.brake)
    except (FileError, QuantityError):
        return None
    return None if found is None else found.mass
