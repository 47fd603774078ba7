"""Values of a result by name, from the records behind it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass
from typing import Any


@dataclass(frozen=True)
class _Prefixed:
    prefix: str
    records: tuple[object, ...]


def prefixed(prefix: str, *records: object) -> object:
    """Records for `Result.of` whose field `slip` is the key `tuned_slip`, with "tuned_"."""
    return _Prefixed(prefix, records)


def value_of(name: str, records: Iterable[object]) -> Any:
    """What the first record or mapping that has this name has by it; MISSING where none has."""
    for one in records:
        if isinstance(one, _Prefixed):
            mine = name.startswith(one.prefix)
            value = value_of(name.removeprefix(one.prefix), one.records) if mine else MISSING
        elif isinstance(one, Mapping):
            value = one.get(name, MISSING)
        else:
            value = getattr(one, name, MISSING)
        if value is not MISSING:
            return value
    return MISSING
