"""Numbers set by hand: what stood there before is kept as words of their source."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layerjam.commands.answer import Quantity
from layerjam.errors import UnknownNameError
from layerjam.records.changes import RecordFile
from layerjam.records.source import KINDS, Source
from layerjam.units import QuantitySpec, get, show

BY_HAND = "set by hand"


def what_it_was(rec: Any, sources: Mapping[str, Source], path: str, spec: QuantitySpec) -> str:
    """That a number of a record was set by hand, and what a source had said before."""
    was, old = get(rec, path), sources.get(path)
    if old is not None and old.text.startswith(BY_HAND):
        return old.text
    if was is None:
        return BY_HAND
    said = old.sentence() if old is not None else "the default"
    return f"{BY_HAND}; was {show(was, spec.unit)}, {said}"


def set_by_hand(
    file: RecordFile[Any],
    changes: Mapping[str, Quantity | None],
    known: Mapping[str, tuple[QuantitySpec, bool]],
    kind: str,
    source: str,
) -> dict[str, tuple[Any, Source] | None]:
    """{dotted path: (SI value, its source), or None} of numbers to set in a file.

    Without a `source` the words of the number that stood there are kept. Raises UnknownNameError,
    or QuantityError for a bad value.
    """
    if kind not in KINDS:
        raise UnknownNameError("kind", kind, KINDS)
    made: dict[str, tuple[Any, Source] | None] = {}
    for path, value in changes.items():
        if path not in known:
            raise UnknownNameError("key", path, known)
        spec, _ = known[path]
        if value is None:
            made[path] = None
            continue
        words = source or what_it_was(file.record, file.sources, path, spec)
        made[path] = spec.si(value, path), Source(kind=kind, text=words)
    return made
