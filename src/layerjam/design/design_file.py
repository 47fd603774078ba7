"""File of a designed brake: chosen values, values of the base brake, and unknown values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from layerjam.design.merit import OF_A_FIT, Point, Stock, make_brake
from layerjam.design.requirements import DesignSpecification
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile, load_film_cutting
from layerjam.device.load import catalogue, load, materials
from layerjam.device.workshop import FilmCutting, Making
from layerjam.toml_files.source import Source
from layerjam.toml_files.values import entries
from layerjam.units import get, quantities
from layerjam.verdict import Acceptance, remaining

CARRIED = (*OF_A_FIT, "stiffness_measured", "fittings_mass")
"""Quantities calibrated or measured on one brake, which may differ for a new brake."""


def make_design_file(
    spec: DesignSpecification,
    point: Point,
    values: Mapping[str, Any],
    name: str,
    acceptances: Sequence[Acceptance] = (),
) -> BrakeFile:
    """Return the file of one brake of a design, parsed from its own TOML text.

    `values` is the design as text. `acceptances` are the design's failed checks that the user has
    accepted. Those of the base brake are kept if their numbers are unchanged.
    """
    base, brake = spec.brake, design_brake(spec, point)
    film = str(values["film"])
    film_sources = _film_sources(film, base)
    sources = {}
    for path, _, _ in quantities(Brake):
        new, old = get(brake, path), get(base.brake, path)
        if new is None:
            continue
        if path in CARRIED:
            sources[path] = _inherit_sources(
                path, film_sources if path in OF_A_FIT else base.sources, base
            )
        elif path.startswith("film."):
            sources[path] = film_sources.get(path, Source(text=f"film of {film}"))
        elif new == old:
            sources[path] = base.sources.get(path, Source())
        else:
            sources[path] = Source(kind="inferred", text=f"chosen by the design {spec.name}")
    making, making_sources = _making_values(film, base)
    changes = {path for path, source in sources.items() if source != base.sources.get(path)}
    earlier = remaining(base.accepted, changes - {*CARRIED})
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
    return BrakeFile.read(file.render(name), name)


def design_brake(spec: DesignSpecification, point: Point) -> Brake:
    """Return one brake of a design as a record of plain numbers."""
    brake = _plain_record(make_brake(point, spec.brake.brake))
    sheets = replace(brake.sheets, count=int(brake.sheets.count))
    return replace(brake, sheets=sheets, rope=spec.brake.brake.rope)


def plain_name(text: str) -> str:
    """Return a valid name for a brake file, derived from any text."""
    name = re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-.+")
    return name[:60] or "design"


def _plain_record(record: Any) -> Any:
    values = {}
    for f in fields(record):
        value = getattr(record, f.name)
        if is_dataclass(value):
            values[f.name] = _plain_record(value)
        elif value is None or value != value:  # NaN means an unknown strength
            values[f.name] = None
        else:
            values[f.name] = value if isinstance(value, tuple) else float(value)
    return type(record)(**values)


def _film_sources(film: str, base: BrakeFile) -> Mapping[str, Source]:
    if film in catalogue():
        return load(film).sources
    if film in materials()["films"]:
        source = Source(kind="handbook", text=f"catalogue film {film}")
        return {f"film.{n}": source for n in Stock._fields if n not in OF_A_FIT}
    return base.sources if film == base.name else {}


def _making_values(film: str, base: BrakeFile) -> tuple[Making, dict[str, Source]]:
    """Return the base file's values for building and casting, and the film's for cutting."""
    paths = dict(entries(Making))
    origins = {path: source for path, source in base.sources.items() if path in paths}
    if film == base.name:
        return base.making, origins
    origins = {path: source for path, source in origins.items() if not path.startswith("film.")}
    if film in catalogue():
        film_file = load(film)
        cutting, sources = film_file.making.film, film_file.sources
    elif film in materials()["films"]:
        cutting, sources = load_film_cutting(film)
    else:
        cutting, sources = FilmCutting(), {}
    origins |= {p: s for p, s in sources.items() if p in paths and p.startswith("film.")}
    return replace(base.making, film=cutting), origins


def _inherit_sources(path: str, sources: Mapping[str, Source], base: BrakeFile) -> Source:
    old = sources.get(path)
    origin = f" ({old.sentence()})" if old else ""
    if path == "stiffness_measured":
        words = f"stiffness of the sheets on the mount of {base.name}{origin}"
    else:
        words = f"as for {base.name}{origin}"
    return Source(kind="assumed", text=words, conflict=old.conflict if old else "")
