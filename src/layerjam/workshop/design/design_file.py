"""File of a designed brake: chosen values, values of the base brake, and unknown values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile, load_film_cutting
from layerjam.brake.device.workshop import Making
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.changes import collect_values
from layerjam.core.toml_files.plugin_tables import known_entries
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.values import entries
from layerjam.core.units import quantities
from layerjam.core.verdict import Acceptance, remaining
from layerjam.workshop.design.merit import OF_A_FIT, Point, Stock, make_brake
from layerjam.workshop.design.requirements import DesignSpecification

CARRIED = (*OF_A_FIT, "stiffness_measured", "fittings_mass")
"""Quantities calibrated or measured on one brake, which may differ for a new brake."""


def make_design_file(
    spec: DesignSpecification,
    point: Point,
    film: str,
    name: str,
    acceptances: Sequence[Acceptance] = (),
) -> BrakeFile:
    """Return the file of one brake of a design, parsed from its own TOML text.

    `acceptances` are the design's failed checks that the user has accepted. Those of the base
    brake, and of the brake from which the film comes, are kept. Raises FileError for a design that
    cannot be built.
    """
    file = compose_design_file(spec, point, film, name, acceptances)
    return BrakeFile.read(file.render(name), name)


def compose_design_file(
    spec: DesignSpecification,
    point: Point,
    film: str,
    name: str,
    acceptances: Sequence[Acceptance] = (),
) -> BrakeFile:
    """Return the file of one brake of a design without its text, also if it cannot be built.

    Evidence of tests is kept if it holds for the design.
    """
    base, brake = spec.brake, design_brake(spec, point)
    origin = spec.films.get(film)
    film_sources = _film_sources(film) if origin is None else origin.sources
    sources = {}
    old_values, new_values = collect_values(base.brake), collect_values(brake)
    for path in (*(path for path, _, _ in quantities(Brake)), *known_entries(brake)):
        new, old = new_values.get(path), old_values.get(path)
        if new is None:
            continue
        if path in CARRIED:
            owner = base if path not in OF_A_FIT or origin is None else origin
            sources[path] = _inherit_sources(path, owner)
        elif path.startswith("film."):
            sources[path] = film_sources.get(path, Source(text=f"film of {film}"))
        elif new == old:
            sources[path] = base.sources.get(path, Source())
        else:
            sources[path] = Source(kind="inferred", text=f"chosen by the design {spec.name}")
    making, making_sources = _making_values(film, base, origin)
    of_film = {path for path in sources if path.startswith("film.") or path in OF_A_FIT}
    if origin is base:
        earlier = base.accepted
    else:
        others = {path for entry in origin.accepted for path in entry.numbers} if origin else set()
        earlier = remaining(base.accepted, removals=of_film)
        earlier += remaining(origin.accepted, removals=others - of_film) if origin else ()
    earlier_kept = [entry for entry in earlier if entry not in acceptances]
    file = BrakeFile(
        name=name,
        brake=brake,
        making=making,
        sources=sources | making_sources,
        text="",
        accepted=(*earlier_kept, *acceptances),
        title=f"{spec.name}, designed from {base.name}",
    )
    owners = [base] if origin is None or origin is base else [base, origin]
    entries = (entry for owner in owners for entry in owner.evidence)
    valid = tuple(entry for entry in entries if not entry.find_changes(file.known_values))
    return evolve(file, evidence=valid)


def design_brake(spec: DesignSpecification, point: Point) -> Brake:
    """Return one brake of a design as a record of plain numbers."""
    brake = _flatten_record(make_brake(point, spec.brake.brake))
    sheets = evolve(brake.sheets, count=int(brake.sheets.count))
    return evolve(brake, sheets=sheets, rope=spec.brake.brake.rope)


def plain_name(text: str) -> str:
    """Return a valid name for a brake file, derived from any text."""
    name = re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-.+")
    return name[:60] or "design"


def _flatten_record(record: Any) -> Any:
    values = {}
    for f in fields(record):
        value = getattr(record, f.name)
        if is_dataclass(value):
            values[f.name] = _flatten_record(value)
        elif value is None or value != value:  # NaN means an unknown strength
            values[f.name] = None
        else:
            values[f.name] = value if isinstance(value, tuple) else float(value)
    return type(record)(**values)


def _film_sources(film: str) -> Mapping[str, Source]:
    """Return the sources of a film of the catalogue."""
    source = Source(kind="handbook", text=f"catalogue film {film}")
    return {f"film.{n}": source for n in Stock._fields if n not in OF_A_FIT}


def _making_values(
    film: str, base: BrakeFile, origin: BrakeFile | None
) -> tuple[Making, dict[str, Source]]:
    """Return the base file's values for building and casting, and the film's for cutting."""
    paths = dict(entries(Making))
    origins = {path: source for path, source in base.sources.items() if path in paths}
    if origin is base:
        return base.making, origins
    origins = {path: source for path, source in origins.items() if not path.startswith("film.")}
    cutting, sources = (
        load_film_cutting(film) if origin is None else (origin.making.film, origin.sources)
    )
    origins |= {p: s for p, s in sources.items() if p in paths and p.startswith("film.")}
    return evolve(base.making, film=cutting), origins


def _inherit_sources(path: str, owner: BrakeFile) -> Source:
    """Return the source of a number that was fitted or measured on another brake."""
    old = owner.sources.get(path)
    origin = f" ({old.sentence()})" if old else ""
    if path == "stiffness_measured":
        words = f"stiffness of the sheets on the mount of {owner.name}{origin}"
    else:
        words = f"as for {owner.name}{origin}"
    return Source(kind="assumed", text=words, conflict=old.conflict if old else "")
