"""Numbers set by hand: what stood there before is kept as words of their source."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layerjam.records.source import Source
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
