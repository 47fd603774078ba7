"""Records without checks, for numbers of layerjam's own code: steps of a fit or a search."""

import functools
from collections.abc import Callable
from dataclasses import MISSING, fields, replace
from typing import Any, TypeVar

from layerjam.core.record_classes import RECORDS

T = TypeVar("T")


def _list_names(cls: Any) -> tuple[str, ...]:
    return tuple(f.name for f in fields(cls))


field_names: Callable[[Any], tuple[str, ...]] = functools.cache(_list_names)
"""Function that returns the names of the fields of a record class, without its ClassVars."""


def assemble(cls: type[T], **values: Any) -> T:
    """Return a record of some values and of its defaults, without checks."""
    defaults = {f.name: f.default for f in fields(cls)}  # type: ignore[arg-type]
    complete = defaults | values
    wrong = values.keys() - defaults or {n for n, v in complete.items() if v is MISSING}
    if wrong:
        raise TypeError(f"{cls.__name__} has, or lacks, the fields {', '.join(sorted(wrong))}")
    new = object.__new__(cls)
    new.__dict__.update(complete)
    return new


def evolve(rec: T, **changes: Any) -> T:
    """Return a record with some fields changed, without checks.

    Other dataclasses are changed as by `dataclasses.replace`.
    """
    if type(rec) not in RECORDS:
        return replace(rec, **changes)  # type: ignore[type-var]
    values = {name: getattr(rec, name) for name in field_names(type(rec))}
    if unknown := changes.keys() - values:
        raise TypeError(f"{type(rec).__name__} has no field {', '.join(sorted(unknown))}")
    new = object.__new__(type(rec))
    new.__dict__.update(values | changes)
    return new
