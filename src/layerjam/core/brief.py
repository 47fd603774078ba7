"""Short representations of records, which contain arrays and other records."""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

T = TypeVar("T")
LONGEST = 300
"""Number of characters of a representation."""
LISTED = 3
"""Number of elements of a list that are named."""


def brief(cls: type[T]) -> type[T]:
    """Give a dataclass or a named tuple a representation of one short paragraph."""
    cls.__repr__ = _describe_record  # type: ignore[assignment, method-assign]
    return cls


def shorten_group(value: Any) -> Any:
    """Return an equal tuple, list or dict with a short representation; other values as they are."""
    kinds: dict[type, type] = {tuple: _BriefTuple, list: _BriefList, dict: _BriefDict}
    kind = kinds.get(type(value))
    return value if kind is None else kind(value)


class _BriefTuple(tuple[Any, ...]):
    def __repr__(self) -> str:
        return _describe_group(self)


class _BriefList(list[Any]):
    def __repr__(self) -> str:
        return _describe_group(self)


class _BriefDict(dict[Any, Any]):
    def __repr__(self) -> str:
        return _describe_group(self)


def _describe_record(record: Any) -> str:
    parts = ((name, _describe_value(value)) for name, value in _list_fields(record))
    text = ", ".join(f"{name} {part}" for name, part in parts if part)
    return _shorten(f"{type(record).__name__}: {text}")


def _list_fields(record: Any) -> Iterator[tuple[str, Any]]:
    if is_dataclass(record):
        yield from ((f.name, getattr(record, f.name)) for f in fields(record))
    else:
        yield from record._asdict().items()


def _describe_group(group: Any) -> str:
    is_mapping = isinstance(group, Mapping)
    parts = [
        f"{key}: {_describe_part(value)}" if is_mapping else _describe_part(value)
        for key, value in list(group.items() if is_mapping else enumerate(group))[:LISTED]
    ]
    ending = f", and {len(group) - LISTED} more" * (len(group) > LISTED)
    return _shorten(f"{'; '.join(parts)}{ending}")


def _describe_part(value: Any) -> str:
    """Return a record as its own paragraph, and any other value briefly."""
    return repr(value) if is_dataclass(value) else _describe_value(value)


def _describe_value(value: Any) -> str:
    """Return a value in a few words; empty if it is unknown or empty."""
    if value is None:
        return ""
    if isinstance(value, str | bool):
        return textwrap.shorten(str(value), LONGEST // 4, placeholder=" …")
    if isinstance(value, int | float):
        return f"{value:.4g}"
    if shape := getattr(value, "shape", None):
        return f"[{' × '.join(map(str, shape))} values]"
    if isinstance(value, list | tuple | Mapping) and not hasattr(value, "_fields"):
        return f"[{len(value)}]" if value else ""
    represent: Any = type(value).__repr__
    is_nested = is_dataclass(value) or represent is object.__repr__
    return f"({type(value).__name__})" if is_nested else str(value)


def _shorten(text: str) -> str:
    return textwrap.shorten(text, LONGEST, placeholder=" …")
