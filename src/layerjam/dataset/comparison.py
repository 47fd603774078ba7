"""Comparison of published files with recomputed ones, number by number and word by word."""

import csv
import html
import importlib.util
import io
import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

SAME = 1e-6
"""Relative difference below which two numbers count as identical, because processors and libraries
round differently and a fit ends within its own tolerance."""
MISSING = object()
Number = float | int | bool | None
Leaf = Number | str
DRAWN = 0.01
"""Distance [pt] below which two points in a drawing count as identical."""
_SVG = re.compile(r"(<svg\b.*?</svg>)", re.DOTALL)
_ID = re.compile(r"\b[a-zA-Z]\w*?[0-9a-f]{10}\b")
"""Pattern of names in a drawing that are digests of the shapes that they name."""


@dataclass(frozen=True)
class Difference:
    """A number or word that differs; `share` is the relative difference.

    `number` is its name in the file. `recomputed` is None if this version has no such number,
    `share` if there is no ratio.
    """

    number: str
    file: str
    published: Leaf
    recomputed: Leaf
    share: float | None = None


def diff_files(file: str, old: bytes, new: bytes) -> Iterator[Difference]:
    """Yield all differences between a published file and the same file recomputed here.

    In drawings, points may differ by `DRAWN`; only the first difference is reported.
    """
    if old == new:
        return
    kind = PurePosixPath(file).suffix
    if kind == ".pdf":
        yield from _diff_pdfs(file, old, new)
        return
    try:
        left, right = old.decode(), new.decode()
        if kind in _READERS:
            yield from diff_values(_READERS[kind](left), _READERS[kind](right), file, words=True)
        else:
            yield from _diff_pages(file, left, right)
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
    left = Counter(find_printed_numbers(file, new))
    for number in find_printed_numbers(file, old):
        others = (n for n in left if left[n] and _are_equal(number, n))
        match = number if left[number] else next(others, None)
        if match is None:
            yield Difference("a number", file, number, None)
        else:
            left[match] -= 1


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
        if not _are_equal(left, right):
            name, share = path[1:].replace("\0", "."), _relative_difference(left, right)
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


def _are_equal(a: Any, b: Any) -> bool:
    if not (_is_number(a) and _is_number(b)):
        return a is b or (isinstance(a, str) and a == b)
    return a == b or abs(a - b) <= SAME * max(abs(a), abs(b))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _relative_difference(a: Any, b: Any) -> float | None:
    if not (_is_number(a) and _is_number(b) and a):
        return None
    return abs(b - a) / abs(a)


def _diff_pages(file: str, old: str, new: str) -> Iterator[Difference]:
    pair = [_SVG.split(text) for text in (old, new)]
    if len(pair[0]) != len(pair[1]):
        count = [len(parts) // 2 for parts in pair]
        yield Difference("number of drawings", file, count[0], count[1])
        return
    for index, (before, after) in enumerate(zip(*pair, strict=True)):
        if index % 2:
            texts = _diff_texts(file, _replace_digests(before), _replace_digests(after), DRAWN)
            first = next(texts, None)
            if first is not None:
                name = f"drawing {index // 2 + 1}, {first.number}"
                yield Difference(name, file, first.published, first.recomputed, first.share)
        else:
            yield from _diff_texts(file, before, after)


def _replace_digests(drawing: str) -> str:
    """Return a drawing with its digests replaced by numbers, in order of appearance."""
    ids: dict[str, str] = {}
    return _ID.sub(lambda m: ids.setdefault(m[0], f"id-{len(ids)}"), drawing)


def _diff_texts(file: str, old: str, new: str, room: float = 0.0) -> Iterator[Difference]:
    """Yield the differences of two texts by line; decimals may differ by `room` or `SAME`."""
    before, after = old.split("\n"), new.split("\n")
    if len(before) != len(after):
        yield Difference("number of lines", file, len(before), len(after))
    for number, (left, right) in enumerate(zip(before, after, strict=False), 1):
        if left == right:
            continue
        pieces = [NUMBER.split(line) for line in (left, right)]
        if pieces[0][::2] != pieces[1][::2]:
            yield Difference(f"line {number}", file, *_find_changed_words(left, right))
            continue
        for a, b in zip(pieces[0][1::2], pieces[1][1::2], strict=True):
            if a == b:
                continue
            x, y = (float(text.replace("−", "-")) for text in (a, b))
            exact = not {".", "e", "E"} & {*a, *b}
            if exact or not (_are_equal(x, y) or abs(x - y) <= room):
                yield Difference(f"line {number}", file, x, y, _relative_difference(x, y))


def _find_changed_words(old: str, new: str) -> tuple[str, str]:
    """Return the parts in which two lines differ, without their common start and end."""
    left, right = old.split(" "), new.split(" ")
    while left and right and left[0] == right[0]:
        del left[0], right[0]
    while left and right and left[-1] == right[-1]:
        del left[-1], right[-1]
    return " ".join(left), " ".join(right)


def _diff_pdfs(file: str, old: bytes, new: bytes) -> Iterator[Difference]:
    """Yield the differences in text and appearance of two PDFs whose bytes differ."""
    if not can_read_pdf():
        yield Difference("bytes (pypdfium2, which reads PDFs, is not installed)", file, None, None)
        return
    before, after = read_pdf_pages(old), read_pdf_pages(new)
    if before is None or after is None:
        yield Difference("text", file, "cannot be read", None)
        return
    texts = list(_diff_texts(file, "\n".join(before), "\n".join(after)))
    yield from texts
    if not texts and (page := find_different_page(old, new)):
        yield Difference(f"appearance of page {page}", file, None, None)


NUMBER = re.compile(r"(?<![\w.])([-−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?!\w|\.\w)")
"""Pattern of a number that is not part of a word, a digest or a version."""
_HIDDEN = re.compile(r"<(style|script|svg|title)\b.*?</\1>|<!--.*?-->", re.DOTALL)
_SHOWN = re.compile(r"<!--(.*?)-->", re.DOTALL)
DPI = 100.0
SHADES = 48
"""Largest difference (of 255) between two pixels of a page that is ignored, as edges shift."""


def can_read_pdf() -> bool:
    """Return whether the library that reads PDFs is installed."""
    return importlib.util.find_spec("pypdfium2") is not None


def find_printed_numbers(file: str, content: bytes) -> list[float]:
    """Return the visible numbers in a file, in order; a drawing's text is in its comments."""
    if file.endswith(".pdf"):
        text = "\n".join(read_pdf_pages(content) or ())
    elif file.endswith(".svg"):
        text = "\n".join(_SHOWN.findall(content.decode()))
    else:
        text = html.unescape(re.sub(r"<[^>]*>", " ", _HIDDEN.sub(" ", content.decode())))
    return [float(text_.replace("−", "-")) for text_ in NUMBER.findall(text)]


def read_pdf_pages(content: bytes) -> list[str] | None:
    """Return the text of each page, or None for bytes that are not a PDF."""
    import pypdfium2

    try:
        with pypdfium2.PdfDocument(content) as document:
            return [_read_page_text(document[n]) for n in range(len(document))]
    except pypdfium2.PdfiumError:
        return None


def _read_page_text(page: Any) -> str:
    return str(page.get_textpage().get_text_range()).replace("\r\n", "\n")


def find_different_page(old: bytes, new: bytes) -> int | None:
    """Return the first page (from 1) on which two PDFs of the same text look different, or None."""
    import numpy as np
    import pypdfium2

    with pypdfium2.PdfDocument(old) as before, pypdfium2.PdfDocument(new) as after:
        for number in range(len(before)):
            pages = (before[number], after[number])
            pair = [page.render(scale=DPI / 72).to_numpy().astype(int) for page in pages]
            if pair[0].shape != pair[1].shape or np.abs(pair[0] - pair[1]).max() > SHADES:
                return number + 1
    return None
