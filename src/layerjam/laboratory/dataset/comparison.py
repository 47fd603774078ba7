"""Comparison of published files with recomputed ones, number by number and word by word."""

import csv
import html
import io
import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from fractions import Fraction
from pathlib import PurePosixPath
from typing import Any

from layerjam.core.conversion import FACTORS
from layerjam.laboratory.dataset.pdf_comparison import diff_pdfs, read_pdf_pages
from layerjam.laboratory.dataset.text_comparison import (
    NUMBER,
    Difference,
    Leaf,
    are_equal,
    diff_pages,
    diff_texts,
    relative_difference,
)

MISSING = object()
_HIDDEN = re.compile(r"<(style|script|svg|title)\b.*?</\1>|<!--.*?-->", re.DOTALL)
_QUANTITY = re.compile(r'"(-?\d+\.?\d*(?:[eE][-+]?\d+)?) ([^"\s]+)"')
_SHOWN = re.compile(r"<!--(.*?)-->", re.DOTALL)


def diff_files(file: str, old: bytes, new: bytes) -> Iterator[Difference]:
    """Yield all differences between a published file and the same file recomputed here.

    A difference in values is named by its key. If the values are equal but the texts are not, as
    with a key that occurs twice or a comment, the first difference of the texts is reported.
    """
    if old == new:
        return
    kind = PurePosixPath(file).suffix
    if kind == ".pdf":
        yield from diff_pdfs(file, old, new)
        return
    try:
        left, right = old.decode(), new.decode()
        if kind == ".toml":
            left, right = _convert_units(left), _convert_units(right)
        if kind not in _READERS:
            yield from diff_pages(file, left, right)
            return
        differences = list(
            diff_values(_READERS[kind](left), _READERS[kind](right), file, words=True)
        )
        yield from differences or list(diff_texts(file, left, right))[:1]
    except (ValueError, RecursionError):
        yield Difference("text", file, "cannot be read", None)


def diff_numbers(file: str, old: bytes, new: bytes) -> Iterator[Difference]:
    """Yield the published numbers that different versions of the programs do not reproduce.

    Words, drawings and the order of numbers on a page or in a table are not compared.
    """
    kind = PurePosixPath(file).suffix
    if kind in _READERS and kind != ".csv":
        before, after = (_READERS[kind](text.decode()) for text in (old, new))
        yield from diff_values(before, after, file)
        return
    remainder = Counter(find_printed_numbers(file, new))
    for number in find_printed_numbers(file, old):
        others = (n for n in remainder if remainder[n] and are_equal(number, n))
        match = number if remainder[number] else next(others, None)
        if match is None:
            yield Difference("a number", file, number, None)
        else:
            remainder[match] -= 1


def diff_values(old: Any, new: Any, file: str, words: bool = False) -> Iterator[Difference]:
    """Yield, in order, the numbers in `old` (JSON) that `new` does not contain.

    With `words`, words are compared too, and entries that only `new` contains are included.
    """
    before: dict[str, Any] = dict(_iterate_leaves(old))
    after: dict[str, Any] = dict(_iterate_leaves(new))
    for path in dict.fromkeys((*before, *(after if words else ()))):
        left, right = before.get(path, MISSING), after.get(path, MISSING)
        if isinstance(left, str) and not words:
            continue
        if isinstance(right, str) and not words:
            right = MISSING
        if not are_equal(left, right):
            name, share = path[1:].replace("\0", "."), relative_difference(left, right)
            was_leaf, now_leaf = (None if leaf is MISSING else leaf for leaf in (left, right))
            yield Difference(name, file, was_leaf, now_leaf, share)


def count_numbers(file: str, content: bytes) -> int:
    """Return the number of values compared in a file, not counting drawings."""
    kind = PurePosixPath(file).suffix
    if kind in _READERS:
        leaves = _iterate_leaves(_READERS[kind](content.decode()))
        return sum(not isinstance(leaf, str) for _, leaf in leaves)
    return len(find_printed_numbers(file, content)) if kind in (".html", ".md") else 0


def index_entries(document: Any) -> Any:
    """Return a JSON-LD document with its entries keyed by name instead of by position."""
    graph = document.get("@graph") if isinstance(document, dict) else None
    if isinstance(graph, list) and all(isinstance(e, dict) and "@id" in e for e in graph):
        return {str(entry["@id"]): entry for entry in graph}
    return document


def prune_items(document: Any, names: Collection[str]) -> Any:
    """Return a JSON-LD document without the entries of these names and references to them."""
    if isinstance(document, dict):
        return {key: prune_items(inner, names) for key, inner in document.items()}
    if isinstance(document, list):
        others = (v for v in document if not (isinstance(v, dict) and v.get("@id") in names))
        return [prune_items(inner, names) for inner in others]
    return document


def _convert_units(text: str) -> str:
    """Return a TOML text with its quantities in SI: the last digits decide the unit in the file."""

    def convert(match: re.Match[str]) -> str:
        for si, factors in FACTORS.items():
            if match[2] in factors:
                return f'"{float(match[1]) * float(Fraction(factors[match[2]]))!r} {si}"'
        return match[0]

    return _QUANTITY.sub(convert, text)


def _parse_table(text: str) -> Any:
    """Return the rows of a CSV file keyed by first cell, with cells keyed by column name."""
    rows = list(csv.reader(io.StringIO(text)))
    counts: Counter[str] = Counter()
    table = {}
    for row in rows[1:]:
        name = row[0] if row else ""
        counts[name] += 1
        key = name if counts[name] == 1 else f"{name} ({counts[name]})"
        head = [*rows[0], *(f"column {n}" for n in range(len(rows[0]), len(row)))]
        table[key] = dict(zip(head, map(_parse_cell, row), strict=False))
    return {"columns": rows[:1], "rows": table}


def _parse_cell(text: str) -> Leaf:
    try:
        return float(text)
    except ValueError:
        return text


_READERS: Mapping[str, Callable[[str], Any]] = {
    ".json": json.loads,
    ".toml": tomllib.loads,
    ".csv": _parse_table,
}


def _iterate_leaves(value: Any, path: str = "") -> Iterator[tuple[str, Leaf]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _iterate_leaves(inner, f"{path}\0{key}")
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _iterate_leaves(inner, f"{path}\0{index}")
    elif value is None or isinstance(value, bool | int | float | str):
        yield path, value
    else:
        yield path, str(value)


def find_printed_numbers(file: str, content: bytes) -> list[float]:
    """Return the visible numbers in a file, in order; a drawing's text is in its comments."""
    if file.endswith(".pdf"):
        text = "\n".join(read_pdf_pages(content) or ())
    elif file.endswith(".svg"):
        text = "\n".join(_SHOWN.findall(content.decode()))
    else:
        text = html.unescape(re.sub(r"<[^>]*>", " ", _HIDDEN.sub(" ", content.decode())))
    return [float(text_.replace("−", "-")) for text_ in NUMBER.findall(text)]
