"""`parts`: the catalogue of pumps, valves and sensors for a vacuum line."""

from __future__ import annotations

from typing import Any

from layerjam.commands.answer import Answer
from layerjam.errors import UnknownNameError
from layerjam.fluid.parts import FAMILIES, PRINTED, Part, family_fields
from layerjam.fluid.parts import parts as known_parts

UNITS = {
    **{name: spec.unit for name, spec in PRINTED.items()},
    **{n: m.unit for family in FAMILIES for n, m in family_fields(family).items()},
    "curve": "Pa, m^3/s",
}


def parts(name: str | None = None) -> Answer:
    """Every part of the catalogue, or one by its name, with its numbers in SI and their sources.

    `pumps`, `valves` and `sensors` are lists of mappings: `name` (what a line's file calls it),
    `title`, `kind`, `numbers` (fields of the line, assumed ones among them), `printed` (what else
    the sources print), `sources` (a sentence for each), `missing` (the number without which it
    cannot stand in a line, or None) and `note`. Raises UnknownNameError.
    """
    found = {family: known_parts(family) for family in FAMILIES}
    if name is not None:
        every = [n for family in found.values() for n in family]
        if name not in every:
            raise UnknownNameError("part", name, every)
        found = {f: {n: p for n, p in family.items() if n == name} for f, family in found.items()}
    values = {f"{f}s": [_shown(p) for p in family.values()] for f, family in found.items()}
    records = [p for family in found.values() for p in family.values()]
    used = {k for p in records for k in (*p.values, *p.printed)}
    return Answer(
        values=values, units={k: u for k, u in UNITS.items() if k in used}, record=records
    )


def _shown(part: Part) -> dict[str, Any]:
    return {
        "name": part.name,
        "title": part.title,
        "kind": part.kind,
        "numbers": dict(part.values),
        "printed": dict(part.printed),
        "sources": {key: source.sentence() for key, source in part.sources.items()},
        "missing": part.missing,
        "note": part.note or None,
    }
