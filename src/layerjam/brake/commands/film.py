"""Another film in a brake, for one call: `--film NAME`."""

from collections.abc import Iterator, Mapping
from typing import Any

from layerjam.brake.device.brake import enclosure_mass, sheet_mass
from layerjam.brake.device.brake_file import BrakeFile, materials
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.device.sheets import Film
from layerjam.core.errors import UnknownNameError
from layerjam.core.toml_files.source import Source
from layerjam.core.units import get, quantities

FITTED = ("scale_factor", "amplification_held")
"""Quantities that a calibration determines for one film."""
OF_OLD_SHEETS = (*FITTED, "stiffness_measured", "weighed_mass")
Entry = tuple[float, Source]


def replace_film(file: BrakeFile, name: str) -> BrakeFile:
    """Return a brake with the film of another brake or of the catalogue, and the film's sources.

    A brake's film has the scale factor of that brake; one of the catalogue has the factor 1, which
    is not calibrated. A measured stiffness becomes that of the new sheets on the same mount, and a
    weighed mass becomes that of the fittings. A speed law and the evidence of tests are omitted,
    because they are valid for one film. Raises UnknownNameError for a name that is neither, and
    FileError for a brake's file.
    """
    films = materials()["films"]
    changes: dict[str, Entry | None] = dict.fromkeys(OF_OLD_SHEETS)
    tables: dict[str, Mapping[str, Any] | None] = {
        "film": {},
        "speed_law": None,
        "tested": None,
    }
    if name in films:
        tables["film"] = {"use": name}
        text = f"for the catalogue film {name}, not calibrated"
        changes["scale_factor"] = 1.0, Source(kind="assumed", text=text)
        title = name
    elif name in catalogue() or name.endswith(".toml"):
        origin = load(name)
        changes |= dict(_list_values(origin))
        title = origin.name
    else:
        raise UnknownNameError("film", name, [*films, *catalogue()], quantity="film")
    new = file.edit(changes, name=f"{file.name} with {title}"[:80], tables=tables)
    return new.edit(dict(_adapt_measurements(file, new, title)))


def _list_values(origin: BrakeFile) -> Iterator[tuple[str, Entry]]:
    """Yield the numbers of a brake's film and of its calibration, with their sources."""
    for path in (*(f"film.{name}" for name, _, _ in quantities(Film)), *FITTED):
        value = get(origin.brake, path)
        if value is not None:
            yield path, (value, origin.sources.get(path, Source(text=f"of {origin.name}")))


def _adapt_measurements(old: BrakeFile, new: BrakeFile, film: str) -> Iterator[tuple[str, Entry]]:
    """Yield stiffness and fittings mass of the new brake, from measurements on the old one."""
    from layerjam.brake.mechanics.stiffness import stiffness_before_slip

    before, after = old.brake, new.brake
    if before.stiffness_measured is not None:
        mount = 1 / before.stiffness_measured - 1 / float(stiffness_before_slip(before))
        stiffness = 1 / (1 / float(stiffness_before_slip(after)) + mount)
        text = f"sheets of {film} on the mount of {old.name}"
        yield "stiffness_measured", (stiffness, Source(kind="inferred", text=text))
    if before.weighed_mass is not None:
        other_mass = before.sheets.count * float(sheet_mass(before)) + float(enclosure_mass(before))
        text = f"weighed mass of {old.name} without sheets and enclosure"
        fittings = max(before.weighed_mass - other_mass, 0.0)
        yield "fittings_mass", (fittings, Source(kind="inferred", text=text))
