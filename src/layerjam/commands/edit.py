"""`edit`: numbers of a brake changed in its own text, so that comments and sources stay."""

from __future__ import annotations

from collections.abc import Mapping

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at
from layerjam.commands.by_hand import BY_HAND, set_by_hand
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.units import QuantitySpec, quantities

FIELDS: dict[str, tuple[QuantitySpec, bool]] = {
    path: (spec, required) for path, spec, required in quantities(Brake)
}
"""{dotted path: (QuantitySpec, required)} of every number a brake has."""


def edit(
    brake: AnyBrake,
    changes: Mapping[str, Quantity | None] | None = None,
    *,
    name: str | None = None,
    kind: str = "assumed",
    source: str = "",
) -> Answer:
    """A brake with another name and other numbers; `record` is its BrakeFile, `text` its file.

    `changes` maps a dotted path to text with a unit, an SI number, or None: not known, or what the
    material or the default says. `kind` and `source` say where the new numbers come from; without
    a source, what stood there before is kept as words. Raises QuantityError for a bad value or
    path, FileError for values that contradict each other.
    """
    file = brake_at(brake, None)
    given = set_by_hand(file, changes or {}, FIELDS, kind, source)
    made = file.edited(given, name=name)
    warnings = [*made.warnings(), *stale(made)]
    values = {"name": made.name, "text": made.text}
    return Answer(values=values, units={}, warnings=warnings, record=made)


def stale(file: BrakeFile) -> list[str]:
    """What was measured or fitted on another brake than this one, since numbers were changed."""
    by_hand = [p for p, s in file.sources.items() if s.text.startswith(BY_HAND)]
    moved = [p for p in by_hand if p.split(".")[0] in ("sheets", "film", "enclosure", "mount")]
    kept = [
        path
        for path in ("scale_factor", "stiffness_measured", "weighed_mass", "fittings_mass")
        if path in file.sources and path not in by_hand
    ]
    if not (moved and kept):
        return []
    return [
        f"{', '.join(kept)} {'are' if len(kept) > 1 else 'is'} still of the brake as it was "
        f"before {', '.join(moved)} {'were' if len(moved) > 1 else 'was'} set by hand"
    ]


__all__ = ["BY_HAND", "FIELDS", "edit", "stale"]
