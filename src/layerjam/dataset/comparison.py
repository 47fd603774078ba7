"""Comparison of published with recomputed files, number by number and word by word."""

from __future__ import annotations

import csv
import io
import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from layerjam.dataset import printed

SAME = 1e-6
"""Relative difference up to which two numbers are the same: other processors and libraries round
otherwise, and a fit ends within its own tolerance."""
MISSING = object()
Number = float | int | bool | None
Leaf = Number | str
DRAWN = 0.01
"""Distance up to which two points of a drawing are the same [pt]."""
_SVG = re.compile(r"(<svg\b.*?</svg>)", re.DOTALL)
_ID = re.compile(r"\b[a-zA-Z]\w*?[0-9a-f]{10}\b")
"""Names in a drawing that are digests of the shape they name."""


@dataclass(frozen=True)
class Difference:
    """A number or word that came out otherwise; `share` is the difference over the published one.

    `number` names it inside the file. `recomputed` is None if this version has no such number,
    `share` if there is no ratio.
    """

    number: str
    file: str
    published: Leaf
    recomputed: Leaf
    share: float | None = None


def file_differences(file: str, published: bytes, recomputed: bytes) -> Iterator[Difference]:
    """Yield all differences between a published file and the same file computed here.

    In drawings points may differ by `DRAWN`, and only the first difference is named.
    """
    if published == recomputed:
        return
    kind = PurePosixPath(file).suffix
    if kind == ".pdf":
        yield from _pdf_differences(file, published, recomputed)
        return
    try:
        one, other = published.decode(), recomputed.decode()
        if kind in _READERS:
            yield from differences(_READERS[kind](one), _READERS[kind](other), file, words=True)
        else:
            yield from _page_differences(file, one, other)
    except (ValueError, RecursionError):
        yield Difference("text", file, "cannot be read", None)


def number_differences(file: str, published: bytes, recomputed: bytes) -> Iterator[Difference]:
    """Yield the published numbers that other versions of the programs do not reproduce.

    Words, drawings, and the order of numbers on a page or in a table are not compared.
    """
    kind = PurePosixPath(file).suffix
    if kind in _READERS and kind != ".csv":
        was, now = (_READERS[kind](text.decode()) for text in (published, recomputed))
        yield from differences(was, now, file)
        return
    left = Counter(printed.numbers(file, recomputed))
    for number in printed.numbers(file, published):
        others = (n for n in left if left[n] and _same(number, n))
        near = number if left[number] else next(others, None)
        if near is None:
            yield Difference("a number", file, number, None)
        else:
            left[near] -= 1


def differences(
    published: Any, recomputed: Any, file: str, words: bool = False
) -> Iterator[Difference]:
    """Yield the numbers of `published` (JSON) that `recomputed` does not hold, in order.

    With `words` words are compared too, and what only `recomputed` holds is a difference.
    """
    was: dict[str, Any] = dict(_leaves(published))
    now: dict[str, Any] = dict(_leaves(recomputed))
    for path in dict.fromkeys((*was, *(now if words else ()))):
        one, other = was.get(path, MISSING), now.get(path, MISSING)
        if isinstance(one, str) and not words:
            continue
        if isinstance(other, str) and not words:
            other = MISSING
        if not _same(one, other):
            name, share = path[1:].replace("\0", "."), _share(one, other)
            was_leaf, now_leaf = (None if leaf is MISSING else leaf for leaf in (one, other))
            yield Difference(name, file, was_leaf, now_leaf, share)


def count(file: str, content: bytes) -> int:
    """Return how many numbers of a file are compared; those of drawings are not counted."""
    kind = PurePosixPath(file).suffix
    if kind in _READERS:
        leaves = _leaves(_READERS[kind](content.decode()))
        return sum(not isinstance(leaf, str) for _, leaf in leaves)
    return len(printed.numbers(file, content)) if kind in (".html", ".md") else 0


def by_name(document: Any) -> Any:
    """A linked document with its entries by their name instead of their place."""
    graph = document.get("@graph") if isinstance(document, dict) else None
    if isinstance(graph, list) and all(isinstance(e, dict) and "@id" in e for e in graph):
        return {str(entry["@id"]): entry for entry in graph}
    return document


def without(document: Any, names: Collection[str]) -> Any:
    """A linked document without the entries of these names and all references to them."""
    if isinstance(document, dict):
        return {key: without(inner, names) for key, inner in document.items()}
    if isinstance(document, list):
        kept = (v for v in document if not (isinstance(v, dict) and v.get("@id") in names))
        return [without(inner, names) for inner in kept]
    return document


def _table(text: str) -> Any:
    """The rows of a CSV file by their first cell, the cells by the names of the columns."""
    rows = list(csv.reader(io.StringIO(text)))
    seen: Counter[str] = Counter()
    table = {}
    for row in rows[1:]:
        name = row[0] if row else ""
        seen[name] += 1
        key = name if seen[name] == 1 else f"{name} ({seen[name]})"
        head = [*rows[0], *(f"column {n}" for n in range(len(rows[0]), len(row)))]
        table[key] = dict(zip(head, map(_cell, row), strict=False))
    return {"columns": rows[:1], "rows": table}


def _cell(text: str) -> Leaf:
    try:
        return float(text)
    except ValueError:
        return text


_READERS: Mapping[str, Callable[[str], Any]] = {
    ".json": json.loads,
    ".toml": tomllib.loads,
    ".csv": _table,
}


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Leaf]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, f"{path}\0{key}")
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _leaves(inner, f"{path}\0{index}")
    elif value is None or isinstance(value, bool | int | float | str):
        yield path, value
    else:
        yield path, str(value)


def _same(one: Any, other: Any) -> bool:
    if not (_plain(one) and _plain(other)):
        return one is other or (isinstance(one, str) and one == other)
    return one == other or abs(one - other) <= SAME * max(abs(one), abs(other))


def _plain(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _share(one: Any, other: Any) -> float | None:
    if not (_plain(one) and _plain(other) and one):
        return None
    return abs(other - one) / abs(one)


def _page_differences(file: str, one: str, other: str) -> Iterator[Difference]:
    """Text and drawings of a page, in turn."""
    pair = [_SVG.split(text) for text in (one, other)]
    if len(pair[0]) != len(pair[1]):
        count = [len(parts) // 2 for parts in pair]
        yield Difference("number of drawings", file, count[0], count[1])
        return
    for index, (was, now) in enumerate(zip(*pair, strict=True)):
        if index % 2:
            found = _text_differences(file, _renamed(was), _renamed(now), DRAWN)
            first = next(found, None)
            if first is not None:
                name = f"drawing {index // 2 + 1}, {first.number}"
                yield Difference(name, file, first.published, first.recomputed, first.share)
        else:
            yield from _text_differences(file, was, now)


def _renamed(drawing: str) -> str:
    """A drawing whose digests are replaced by the order in which they appear."""
    known: dict[str, str] = {}
    return _ID.sub(lambda m: known.setdefault(m[0], f"id-{len(known)}"), drawing)


def _text_differences(file: str, one: str, other: str, room: float = 0.0) -> Iterator[Difference]:
    """Differences of two texts line by line; decimals may differ by `room` or `SAME`."""
    was, now = one.split("\n"), other.split("\n")
    if len(was) != len(now):
        yield Difference("number of lines", file, len(was), len(now))
    for number, (left, right) in enumerate(zip(was, now, strict=False), 1):
        if left == right:
            continue
        pieces = [printed.NUMBER.split(line) for line in (left, right)]
        if pieces[0][::2] != pieces[1][::2]:
            yield Difference(f"line {number}", file, *_apart(left, right))
            continue
        for a, b in zip(pieces[0][1::2], pieces[1][1::2], strict=True):
            if a == b:
                continue
            x, y = (float(text.replace("−", "-")) for text in (a, b))
            exact = not {".", "e", "E"} & {*a, *b}
            if exact or not (_same(x, y) or abs(x - y) <= room):
                yield Difference(f"line {number}", file, x, y, _share(x, y))


def _apart(one: str, other: str) -> tuple[str, str]:
    """The words in which two lines differ: without what they share at start and end."""
    left, right = one.split(" "), other.split(" ")
    while left and right and left[0] == right[0]:
        del left[0], right[0]
    while left and right and left[-1] == right[-1]:
        del left[-1], right[-1]
    return " ".join(left), " ".join(right)


def _pdf_differences(file: str, published: bytes, recomputed: bytes) -> Iterator[Difference]:
    """Text and looks of two PDFs whose bytes differ."""
    if not printed.reads_pdf():
        yield Difference("bytes (pypdfium2, which reads PDFs, is not installed)", file, None, None)
        return
    was, now = printed.pdf_pages(published), printed.pdf_pages(recomputed)
    if was is None or now is None:
        yield Difference("text", file, "cannot be read", None)
        return
    found = list(_text_differences(file, "\n".join(was), "\n".join(now)))
    yield from found
    if not found and (page := printed.other_looks(published, recomputed)):
        yield Difference(f"looks of page {page}", file, None, None)
