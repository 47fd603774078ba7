"""Published numbers beside recomputed ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

SAME = 1e-6
"""Relative difference up to which two numbers are the same: other processors and libraries round
otherwise, and a fit ends within its own tolerance."""
MISSING = object()
Number = float | int | bool | None


@dataclass(frozen=True)
class Difference:
    """A number that came out otherwise; `share` is the difference over the published one.

    `recomputed` is None where this version has no such number, `share` where there is no ratio.
    """

    number: str
    file: str
    published: Number
    recomputed: Number
    share: float | None


def differences(published: Any, recomputed: Any, file: str) -> Iterator[Difference]:
    """The numbers of `published` (JSON) that `recomputed` does not hold, in order.

    Words are not compared, and what is new is not missed.
    """
    for path, one in _numbers(published, ""):
        other = _at(recomputed, path)
        known = None if other is MISSING else other
        if other is MISSING or not _same(one, known):
            yield Difference(path[1:].replace("\0", "."), file, one, known, _share(one, known))


def count(published: Any) -> int:
    """How many numbers there are to compare."""
    return sum(1 for _ in _numbers(published, ""))


def _numbers(value: Any, path: str) -> Iterator[tuple[str, Number]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _numbers(inner, f"{path}\0{key}")
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _numbers(inner, f"{path}\0{index}")
    elif value is None or isinstance(value, bool | int | float):
        yield path, value


def _at(value: Any, path: str) -> Any:
    """What stands at a path; MISSING where nothing or no number does."""
    for key in path.split("\0")[1:]:
        if isinstance(value, Mapping) and key in value:
            value = value[key]
        elif isinstance(value, list) and key.isdigit() and int(key) < len(value):
            value = value[int(key)]
        else:
            return MISSING
    return value if value is None or isinstance(value, bool | int | float) else MISSING


def _same(one: Number, other: Number) -> bool:
    if one is None or other is None or isinstance(one, bool) or isinstance(other, bool):
        return one is other
    return one == other or abs(one - other) <= SAME * max(abs(one), abs(other))


def _share(one: Number, other: Number) -> float | None:
    plain = (v for v in (one, other) if v is not None and not isinstance(v, bool))
    pair = list(plain)
    return None if len(pair) < 2 or not pair[0] else abs(pair[1] - pair[0]) / abs(pair[0])
