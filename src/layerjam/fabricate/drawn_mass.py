"""What a brake weighs as it would be drawn, by closed forms alone: no file, no mesh, no library."""

from __future__ import annotations

from layerjam.device.file import BrakeFile
from layerjam.errors import FileError, QuantityError
from layerjam.fabricate.checks import agree_drawn, clamp_checks, wall_check
from layerjam.fabricate.choices import choices
from layerjam.fabricate.lengths import CannotBuildError, lengths
from layerjam.fabricate.masses import mass_rows
from layerjam.fabricate.parts import parts
from layerjam.fabricate.verdicts import refusals


def drawn_mass(file: BrakeFile) -> float | None:
    """Mass [kg] of one brake as `build` draws it, of the parts that have a mass before weighing.

    None where its parts would not fit together, so that volumes by closed form would mean nothing;
    `build` then says why.
    """
    try:
        build = choices(file).build
        found = lengths(file.brake, build)
        agree_drawn(build, found)
        if refusals([*clamp_checks(build, found), wall_check(build, found)]):
            return None
        rows = mass_rows(file.brake, build, found, parts(found, build))
    except (CannotBuildError, FileError, QuantityError):
        return None
    return sum(row.mass for row in rows)
