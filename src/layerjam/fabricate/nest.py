"""Film parts in rows on the stock, in mm: never turned, for film differs along and across."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from layerjam.fabricate.outline import Outline, around

SLACK = 1e-9
"""What rounding may take from a stock that just fits [mm]."""


@dataclass(frozen=True)
class Wanted:
    """Equal parts to be cut, their kerf included."""

    name: str
    outline: Outline
    count: int


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A piece of film [mm] with the parts that lie on it; its lower left corner is the origin."""

    name: str
    length: float
    width: float
    parts: Sequence[Outline]
    counts: Sequence[tuple[str, int]]
    """How many of each part, in the order in which they were wanted."""

    def used(self) -> tuple[float, float]:
        """Length and width [mm] up to the last part, from the origin."""
        return around(self.parts)[2:]


def too_large(
    parts: Sequence[Wanted], stock: tuple[float, float], margin: float
) -> tuple[str, str, float] | None:
    """(part, "length" or "width", by how much [mm]) of a part that the stock cannot hold."""
    for part in parts:
        for axis, has in zip(("length", "width"), stock, strict=True):
            over = getattr(part.outline, axis) + 2 * margin - has
            if over > SLACK:
                return part.name, axis, over
    return None


def nest(
    parts: Sequence[Wanted], *, stock: tuple[float, float], margin: float, gap: float
) -> list[Piece]:
    """The parts on as many pieces of `stock` (length, width) as they take.

    A part goes into the first row that has room for it and is as wide, else begins a row. Raises
    ValueError for a part that `too_large` names.
    """
    if too_large(parts, stock, margin):
        raise ValueError("a part is larger than the stock")
    return _Filling(parts, stock, margin, gap).pieces()


def nest_least(
    parts: Sequence[Wanted], *, margin: float, gap: float, most: tuple[float, float]
) -> list[Piece]:
    """The parts on the least rectangle that holds all, where the stock is not given.

    Where that would be larger than `most` (length, width), pieces of `most` and a least rest. A
    part longer or wider than `most` gets what it needs.
    """
    longest = max(part.outline.length for part in parts) + 2 * margin
    widest = max(part.outline.width for part in parts) + 2 * margin
    limit = max(most[0], longest), max(most[1], widest)
    steps = {part.outline.length + gap: part.count for part in parts}
    lengths = _sums(steps, 2 * margin - gap, longest, limit[0])
    tries = [_Filling(parts, (length, limit[1]), margin, gap) for length in lengths]
    best = min(tries, key=lambda filling: sum(long * wide for long, wide in filling.least()))
    sizes = zip(best.pieces(), best.least(), strict=True)
    return [replace(piece, length=long, width=wide) for piece, (long, wide) in sizes]


def _sums(
    steps: Mapping[float, int], start: float, least: float, most: float, enough: int = 150
) -> list[float]:
    """Lengths of a row of some of each part, from `least` to `most`; the shortest ones if many."""
    found = {start}
    for step, count in steps.items():
        rows = int(min(count, (most - start) // step))
        found |= {length + i * step for length in found for i in range(1, rows + 1)}
    return sorted(length for length in found if least - SLACK <= length <= most + SLACK)[:enough]


@dataclass
class _Row:
    """A row while it fills [mm]."""

    piece: int
    low: float
    height: float
    free: float


class _Filling:
    def __init__(
        self, parts: Sequence[Wanted], stock: tuple[float, float], margin: float, gap: float
    ) -> None:
        self.parts, self.stock, self.margin, self.gap = parts, stock, margin, gap
        self.rows: list[_Row] = []
        self.laid: list[list[tuple[Wanted, float, float]]] = []
        for part in sorted(parts, key=lambda p: (-p.outline.width, -p.outline.length)):
            self._lay(part)

    def _lay(self, part: Wanted) -> None:
        """All parts of one kind; a row too short for one is too short for the next."""
        long, wide = part.outline.length, part.outline.width
        row = 0
        for _ in range(part.count):
            while row < len(self.rows) and not self._room(self.rows[row], long, wide):
                row += 1
            if row == len(self.rows):
                self.rows.append(self._new(wide))
            at = self.rows[row]
            self.laid[at.piece].append((part, at.free, at.low))
            at.free += long + self.gap

    def _room(self, row: _Row, long: float, wide: float) -> bool:
        end = self.stock[0] - self.margin
        return wide <= row.height + SLACK and row.free + long <= end + SLACK

    def _new(self, wide: float) -> _Row:
        """The row above the last, or the first of a new piece."""
        low, end = self.margin, self.stock[1] - self.margin
        if self.rows:
            low = self.rows[-1].low + self.rows[-1].height + self.gap
        if not self.rows or low + wide > end + SLACK:
            self.laid.append([])
            low = self.margin
        return _Row(len(self.laid) - 1, low, wide, self.margin)

    def least(self) -> list[tuple[float, float]]:
        """Length and width that each piece needs."""
        ends = [(0.0, 0.0)] * len(self.laid)
        for row in self.rows:
            long, wide = ends[row.piece]
            right, high = row.free - self.gap + self.margin, row.low + row.height + self.margin
            ends[row.piece] = max(long, right), max(wide, high)
        return ends

    def pieces(self) -> list[Piece]:
        """The pieces as they are."""
        return [self._piece(f"film-{i}", laid) for i, laid in enumerate(self.laid, 1)]

    def _piece(self, name: str, laid: Sequence[tuple[Wanted, float, float]]) -> Piece:
        count = Counter(part.name for part, _, _ in laid)
        placed = []
        for part, x, low in laid:
            left, bottom, _, _ = part.outline.box()
            placed.append(part.outline.moved(x - left, low - bottom))
        return Piece(
            name=name,
            length=self.stock[0],
            width=self.stock[1],
            parts=placed,
            counts=[(part.name, count[part.name]) for part in self.parts if count[part.name]],
        )
