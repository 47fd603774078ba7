"""Output quantities: declared once on the record that computes them, and looked up by name."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from inspect import get_annotations
from typing import TYPE_CHECKING, Any, TypeVar, dataclass_transform

from layerjam.core.units import QuantitySpec

if TYPE_CHECKING:
    from matplotlib import axes, figure

    Axes = axes.Axes
    Figure = figure.Figure
else:  # annotations need these names before Matplotlib is loaded
    Axes = Figure = Any

T = TypeVar("T")
Formatter = Callable[[Any], str]
ENDS = ("low", "high")
"""Suffixes of the names of an interval's bounds."""


def number(
    unit: str,
    text: str,
    *,
    default: Any = MISSING,
    shown: Formatter | None = None,
    listed: bool = True,
    interval: bool = False,
) -> Any:
    """Return a field for an SI number, an array or a list; None means unknown.

    `shown` formats it if the usual text is unsuitable; a field that is not `listed` is in the JSON
    but not in the table. With an `interval`, it is followed by the fields NAME_low and NAME_high,
    the ends of its 95 % interval; None marks an open end.
    """
    spec = QuantitySpec(unit, text, lo=-math.inf)
    return _make_field(spec, text, default, shown, listed, interval=interval)


def fact(
    text: str,
    *,
    default: Any = MISSING,
    shown: Formatter | None = None,
    listed: bool = True,
    key: str = "",
) -> Any:
    """Return a field without a unit: a word, a flag, a table or a file's name.

    `key` is its key in the JSON, for a key that cannot be the name of a field.
    """
    return _make_field(None, text, default, shown, listed, key=key)


def _make_field(
    spec: QuantitySpec | None,
    text: str,
    default: Any,
    formatter: Formatter | None,
    listed: bool,
    key: str = "",
    interval: bool = False,
) -> Any:
    facts = {"result": text, "quantity": spec, "shown": formatter, "listed": listed, "key": key}
    return field(default=default, metadata={**facts, "interval": interval})


def declare(cls: type[T]) -> type[T]:
    """Return a decorator that completes the fields of a class before `dataclass` processes it.

    A field that is declared again without a value keeps the unit and the text of the field in the
    base class, and its key moves to this position. The ends of an interval come after its quantity.
    """
    bases = [base for base in reversed(cls.__mro__[1:]) if is_dataclass(base)]
    inherited = {f.name: f for base in bases for f in fields(base)}
    kinds: dict[str, Any] = {}
    for name, kind in get_annotations(cls).items():
        kinds[name] = kind
        declared_field = vars(cls).get(name)
        if declared_field is None and name in inherited:
            setattr(
                cls, name, field(default=inherited[name].default, metadata=inherited[name].metadata)
            )
        elif isinstance(declared_field, Field) and declared_field.metadata.get("interval"):
            unit = declared_field.metadata["quantity"].unit
            for end in ENDS:
                kinds[f"{name}_{end}"] = kind
                text = "end of the 95 % interval"
                setattr(cls, f"{name}_{end}", number(unit, text, default=None, listed=False))
    cls.__annotations__ = kinds
    return cls


@dataclass_transform(
    kw_only_default=True, frozen_default=True, field_specifiers=(number, fact, field)
)
def outputs(cls: type[T]) -> type[T]:
    """Return a decorator for a frozen, keyword-only record of computed quantities."""
    return dataclass(frozen=True, kw_only=True)(declare(cls))


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
            has_prefix = name.startswith(record.prefix)
            value = (
                look_up(name.removeprefix(record.prefix), record.records) if has_prefix else MISSING
            )
        elif isinstance(record, Mapping):
            value = record.get(name, MISSING)
        else:
            value = getattr(record, name, MISSING)
        if value is not MISSING:
            return value
    return MISSING


def bounds(**intervals: tuple[float | None, float | None] | None) -> dict[str, float | None]:
    """Return {NAME_low: ..., NAME_high: ...} of 95 % intervals; numbers without one are omitted."""
    ends = {name: ends for name, ends in intervals.items() if ends is not None}
    return {f"{n}_{end}": v for n, pair in ends.items() for end, v in zip(ENDS, pair, strict=True)}


def field_key(f: Field[Any]) -> str:
    """Return the JSON key of a field of a result."""
    return f.metadata["key"] or f.name
