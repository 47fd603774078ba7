"""A design as a brake's file: what was chosen, what is the given brake's, and what is unsure."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from layerjam.design.merit import OF_A_FIT, Point, Stock, brake_of
from layerjam.design.requirements import DesignSpecification
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile, film_cutting
from layerjam.device.load import catalogue, load, materials
from layerjam.device.workshop import FilmCutting, Making
from layerjam.records.source import Source
from layerjam.records.values import entries
from layerjam.units import get, quantities
from layerjam.verdict import Acceptance, remaining

CARRIED = (*OF_A_FIT, "stiffness_measured", "fittings_mass")
"""Numbers of one built brake, which another one need not share."""


def design_file(
    spec: DesignSpecification,
    point: Point,
    values: Mapping[str, Any],
    name: str,
    accepted: Sequence[Acceptance] = (),
) -> BrakeFile:
    """One brake of a design, read back from its own text; `values` are the design in words.

    `accepted` are the failed checks of the design that somebody accepted; those of the given brake
    stay as far as its numbers do.
    """
    base, made = spec.brake, design_brake(spec, point)
    film = str(values["film"])
    film_sources = _film_sources(film, base)
    sources = {}
    for path, _, _ in quantities(Brake):
        now, before = get(made, path), get(base.brake, path)
        if now is None:
            continue
        if path in CARRIED:
            sources[path] = _carried(path, film_sources if path in OF_A_FIT else base.sources, base)
        elif path.startswith("film."):
            sources[path] = film_sources.get(path, Source(text=f"film of {film}"))
        elif now == before:
            sources[path] = base.sources.get(path, Source())
        else:
            sources[path] = Source(kind="inferred", text=f"chosen by the design {spec.name}")
    making, said = _making(film, base)
    replaced = {path for path, source in sources.items() if source != base.sources.get(path)}
    earlier = remaining(base.accepted, replaced - {*CARRIED})
    kept = [one for one in earlier if one not in accepted]
    file = BrakeFile(
        name=name,
        brake=made,
        making=making,
        sources=sources | said,
        text="",
        accepted=(*kept, *accepted),
        title=f"{spec.name}, designed from {base.name}",
    )
    return BrakeFile.read(file.render(name), name)


def design_brake(spec: DesignSpecification, point: Point) -> Brake:
    """Return one brake of a design as a record of plain numbers."""
    made = _plain(brake_of(point, spec.brake.brake))
    sheets = replace(made.sheets, count=int(made.sheets.count))
    return replace(made, sheets=sheets, rope=spec.brake.brake.rope)


def plain_name(text: str) -> str:
    """A name that a brake's file may bear, from any words."""
    kept = re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-.+")
    return kept[:60] or "design"


def _plain(record: Any) -> Any:
    made = {}
    for f in fields(record):
        value = getattr(record, f.name)
        if is_dataclass(value):
            made[f.name] = _plain(value)
        elif value is None or value != value:  # NaN stands for a strength that is not known
            made[f.name] = None
        else:
            made[f.name] = value if isinstance(value, tuple) else float(value)
    return type(record)(**made)


def _film_sources(film: str, base: BrakeFile) -> Mapping[str, Source]:
    if film in catalogue():
        return load(film).sources
    if film in materials()["films"]:
        said = Source(kind="handbook", text=f"catalogue film {film}")
        return {f"film.{n}": said for n in Stock._fields if n not in OF_A_FIT}
    return base.sources if film == base.name else {}


def _making(film: str, base: BrakeFile) -> tuple[Making, dict[str, Source]]:
    """What the base's file says of building and casting, and what is known of cutting the film."""
    known = dict(entries(Making))
    said = {path: source for path, source in base.sources.items() if path in known}
    if film == base.name:
        return base.making, said
    said = {path: source for path, source in said.items() if not path.startswith("film.")}
    if film in catalogue():
        other = load(film)
        cutting, sources = other.making.film, other.sources
    elif film in materials()["films"]:
        cutting, sources = film_cutting(film)
    else:
        cutting, sources = FilmCutting(), {}
    said |= {p: s for p, s in sources.items() if p in known and p.startswith("film.")}
    return replace(base.making, film=cutting), said


def _carried(path: str, sources: Mapping[str, Source], base: BrakeFile) -> Source:
    old = sources.get(path)
    said = f" ({old.sentence()})" if old else ""
    if path == "stiffness_measured":
        words = f"the sheets' own on the mount of {base.name}{said}"
    else:
        words = f"as that of {base.name}{said}"
    return Source(kind="assumed", text=words, conflict=old.conflict if old else "")
