"""`edit`: numbers of a brake changed in its own text, so that comments and sources stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.commands.by_hand import BY_HAND, what_it_was
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile, read_brake, updated_text
from layerjam.device.load import materials
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.records.source import KINDS, Source
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
    if kind not in KINDS:
        raise UnknownNameError("kind", kind, KINDS)
    made = file
    for path, value in (changes or {}).items():
        if path not in FIELDS:
            raise UnknownNameError("key", path, FIELDS)
        made = _changed(made, path, value, kind, source)
    if name is not None:
        made = _read(updated_text(made, name, {}, made.notes), name)
    return Answer(
        values={"name": made.name, "text": made.text}, units={},
        warnings=[*made.warnings(), *stale(made)],
        record=made,
    )  # fmt: skip


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


def _changed(
    file: BrakeFile, path: str, value: Quantity | None, kind: str, source: str
) -> BrakeFile:
    spec, _ = FIELDS[path]
    if value is None:
        return _read(_without(file.text, path), file.name)
    number = si(value, spec, path)
    words = source or what_it_was(file.brake, file.sources, path, spec)
    changed = {path: (int(number) if spec.whole else number, Source(kind=kind, text=words))}
    return _read(updated_text(file, file.name, changed, file.notes), file.name)


def _read(text: str, name: str) -> BrakeFile:
    return read_brake(text, f"brake {name[:80]}", materials())


def _without(text: str, path: str) -> str:
    """The text without one key."""
    import tomlkit

    document = tomlkit.parse(text)
    table, _, key = path.rpartition(".")
    place: Any = document.get(table, {}) if table else document
    if key not in place:
        raise QuantityError(f"{path}: the material or a default says it; give another value")
    place.remove(key)
    return tomlkit.dumps(document)
