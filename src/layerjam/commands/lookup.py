"""Values of a result by name, from the underlying records."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass
from typing import Any


@dataclass(frozen=True)
class _PrefixedRecords:
    prefix: str
    records: tuple[object, ...]


def add_prefix(prefix: str, *records: object) -> object:
    """Return records with prefixed fields: with "tuned_", `slip` becomes the key `tuned_slip`."""
    return _PrefixedRecords(prefix, records)


def look_up(name: str, records: Iterable[object]) -> Any:
    """Return the value from the first record or mapping with this name; MISSING if none has it."""
    for record in records:
        if isinstance(record, _PrefixedRecords):
            mine = name.startswith(record.prefix)
            value = look_up(name.removeprefix(record.prefix), record.records) if mine else MISSING
        elif isinstance(record, Mapping):
            value = record.get(name, MISSING)
        else:
            value = getattr(record, name, MISSING)
        if value is not MISSING:
            return value
    return MISSING
