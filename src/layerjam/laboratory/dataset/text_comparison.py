"""Comparison of two texts: every word must be equal, and every number up to rounding."""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from layerjam.core.brief import brief

SAME = 1e-6
"""Relative difference below which two numbers count as identical, because processors and libraries
round differently and a fit ends within its own tolerance."""
DRAWN = 0.01
"""Distance [pt] below which two points in a drawing count as identical."""
NUMBER = re.compile(r"(?<![\w.])([-−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?!\w|\.\w)")
"""Pattern of a number that is not part of a word, a digest or a version."""
Number = float | int | bool | None
Leaf = Number | str
Margins = Callable[[str], Iterable[float]]
"""Absolute tolerance of each number in a text, in the order of NUMBER."""
_SVG = re.compile(r"(<svg\b.*?</svg>)", re.DOTALL)
_ID = re.compile(r"\b[a-zA-Z]\w*?[0-9a-f]{10}\b")
"""Pattern of names in a drawing that are digests of the shapes that they name."""
_PLACES = {"d", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "points", "translate"}
"""Attributes and functions of SVG whose numbers are coordinates."""
_KEY = re.compile(r'([\w-]+)(?:="|\(|:)')


@brief
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


def are_equal(a: Any, b: Any) -> bool:
    """Return whether two values are the same; numbers, also in words, may differ by SAME."""
    if isinstance(a, str) and isinstance(b, str):
        return a == b or next(diff_texts("", a, b), None) is None
    if not (_is_number(a) and _is_number(b)):
        return a is b
    return bool(a == b or abs(a - b) <= SAME * max(abs(a), abs(b)))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def relative_difference(a: Any, b: Any) -> float | None:
    """Return the difference of two numbers relative to the first, or None if there is none."""
    if not (_is_number(a) and _is_number(b) and a):
        return None
    return float(abs(b - a) / abs(a))


def no_margins(text: str) -> Iterator[float]:
    """Yield the tolerance 0 for every number of a text."""
    yield from (0.0 for _ in NUMBER.finditer(text))


def diff_texts(
    file: str, old: str, new: str, margins: Margins = no_margins
) -> Iterator[Difference]:
    """Yield the differences of two texts by line; decimals may differ by SAME or their margin."""
    before, after = old.split("\n"), new.split("\n")
    if len(before) != len(after):
        yield Difference("number of lines", file, len(before), len(after))
    rooms = iter(margins(old))
    for number, (left, right) in enumerate(zip(before, after, strict=False), 1):
        pieces = [NUMBER.split(line) for line in (left, right)]
        limits = [next(rooms) for _ in pieces[0][1::2]]
        if left == right:
            continue
        if pieces[0][::2] != pieces[1][::2]:
            yield Difference(f"line {number}", file, *_find_changed_words(left, right))
            continue
        for a, b, room in zip(pieces[0][1::2], pieces[1][1::2], limits, strict=True):
            if a == b:
                continue
            x, y = (float(text.replace("−", "-")) for text in (a, b))
            exact = not {".", "e", "E"} & {*a, *b}
            if exact or not (are_equal(x, y) or abs(x - y) <= room):
                yield Difference(f"line {number}", file, x, y, relative_difference(x, y))


def _find_changed_words(old: str, new: str) -> tuple[str, str]:
    """Return the parts in which two lines differ, without their common start and end."""
    left, right = old.split(" "), new.split(" ")
    while left and right and left[0] == right[0]:
        del left[0], right[0]
    while left and right and left[-1] == right[-1]:
        del left[-1], right[-1]
    return " ".join(left), " ".join(right)


def diff_pages(file: str, old: str, new: str) -> Iterator[Difference]:
    """Yield the differences of two pages or drawings; coordinates may differ by DRAWN.

    Only the first difference in each drawing is reported.
    """
    pair = [_SVG.split(text) for text in (old, new)]
    if len(pair[0]) != len(pair[1]):
        count = [len(parts) // 2 for parts in pair]
        yield Difference("number of drawings", file, count[0], count[1])
        return
    for index, (before, after) in enumerate(zip(*pair, strict=True)):
        if index % 2:
            drawings = (_replace_digests(before), _replace_digests(after))
            first = next(diff_texts(file, *drawings, _svg_margins), None)
            if first is not None:
                name = f"drawing {index // 2 + 1}, {first.number}"
                yield Difference(name, file, first.published, first.recomputed, first.share)
        else:
            yield from diff_texts(file, before, after)


def _svg_margins(drawing: str) -> Iterator[float]:
    """Yield DRAWN for each coordinate, and 0 for sizes, scales and other numbers."""
    key = ""
    for index, piece in enumerate(NUMBER.split(drawing)):
        if index % 2:
            yield DRAWN if key in _PLACES else 0.0
        else:
            key = (_KEY.findall(piece) or [key])[-1]


def _replace_digests(drawing: str) -> str:
    """Return a drawing with its digests replaced by numbers, in order of appearance."""
    ids: dict[str, str] = {}
    return _ID.sub(lambda m: ids.setdefault(m[0], f"id-{len(ids)}"), drawing)
