"""Layout of film parts in rows on the stock [mm]; no part is turned, as film is anisotropic."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from layerjam.core.evolve import evolve
from layerjam.workshop.fabricate.outline import Outline, bounding_box

SLACK = 1e-9
"""Rounding error allowed for a stock of exactly the required size [mm]."""


@dataclass(frozen=True)
class CutPart:
    """Identical parts to cut, kerf included."""

    name: str
    outline: Outline
    count: int


@dataclass(frozen=True, kw_only=True)
class Piece:
    """Piece of film [mm] with the parts on it; its lower left corner is the origin."""

    name: str
    length: float
    width: float
    parts: Sequence[Outline]
    counts: Sequence[tuple[str, int]]
    """Name and number of each part, in the order in which the parts were given."""

    def used(self) -> tuple[float, float]:
        """Return the length and width [mm] that the parts use, from the origin."""
        return bounding_box(self.parts)[2:]


def find_excess(
    parts: Sequence[CutPart], stock: tuple[float, float], margin: float
) -> tuple[str, str, float] | None:
    """Return (part, "length" or "width", excess [mm]) of the first part too large for the stock."""
    for part in parts:
        for axis, limit in zip(("length", "width"), stock, strict=True):
            excess = getattr(part.outline, axis) + 2 * margin - limit
            if excess > SLACK:
                return part.name, axis, excess
    return None


def nest_parts(
    parts: Sequence[CutPart], *, stock: tuple[float, float], margin: float, gap: float
) -> list[Piece]:
    """Return the parts on as many pieces of `stock` (length, width) as needed.

    A part is placed in the first row that is wide and long enough; otherwise, it starts a new row.
    Raises ValueError if a part is too large for the stock.
    """
    if find_excess(parts, stock, margin):
        raise ValueError("a part is larger than the stock")
    return _Filling(parts, stock, margin, gap).pieces()


def nest_tightly(
    parts: Sequence[CutPart], *, margin: float, gap: float, bounds: tuple[float, float]
) -> list[Piece]:
    """Return the parts on the smallest rectangle into which all of them fit.

    If it would exceed `bounds` (length, width), the parts are divided among several pieces, each as
    small as possible. For a part that is longer or wider, `bounds` are extended.
    """
    longest = max(part.outline.length for part in parts) + 2 * margin
    widest = max(part.outline.width for part in parts) + 2 * margin
    limit = max(bounds[0], longest), max(bounds[1], widest)
    steps = {part.outline.length + gap: part.count for part in parts}
    lengths = _row_lengths(steps, 2 * margin - gap, longest, limit[0])
    tries = [_Filling(parts, (length, limit[1]), margin, gap) for length in lengths]
    best = min(tries, key=lambda filling: sum(long * wide for long, wide in filling.sizes()))
    sizes = zip(best.pieces(), best.sizes(), strict=True)
    return [evolve(piece, length=long, width=wide) for piece, (long, wide) in sizes]


def _row_lengths(
    steps: Mapping[float, int], start: float, shortest: float, longest: float, enough: int = 150
) -> list[float]:
    """Return the shortest lengths of rows with some parts of each kind, `shortest` to `longest`."""
    sums = {start}
    for step, count in steps.items():
        rows = int(min(count, (longest - start) // step))
        sums |= {length + i * step for length in sums for i in range(1, rows + 1)}
    return sorted(length for length in sums if shortest - SLACK <= length <= longest + SLACK)[
        :enough
    ]


@dataclass
class _Row:
    piece: int
    low: float
    height: float
    free: float
    end: float

    def has_room(self, long: float, wide: float) -> bool:
        return wide <= self.height + SLACK and self.free + long <= self.end + SLACK


class _Filling:
    def __init__(
        self, parts: Sequence[CutPart], stock: tuple[float, float], margin: float, gap: float
    ) -> None:
        self.parts, self.stock, self.margin, self.gap = parts, stock, margin, gap
        self.rows: list[_Row] = []
        self.places: list[list[tuple[CutPart, float, float]]] = []
        for part in sorted(parts, key=lambda p: (-p.outline.width, -p.outline.length)):
            self._place_part(part)

    def _place_part(self, part: CutPart) -> None:
        """Place all parts of one kind; a row without space for one has no space for the next."""
        long, wide = part.outline.length, part.outline.width
        row = 0
        for _ in range(part.count):
            while row < len(self.rows) and not self.rows[row].has_room(long, wide):
                row += 1
            if row == len(self.rows):
                self.rows.append(self._add_row(wide))
            target = self.rows[row]
            self.places[target.piece].append((part, target.free, target.low))
            target.free += long + self.gap

    def _add_row(self, wide: float) -> _Row:
        """Return a row above the last one, or the first row of a new piece."""
        low, end = self.margin, self.stock[1] - self.margin
        if self.rows:
            low = self.rows[-1].low + self.rows[-1].height + self.gap
        if not self.rows or low + wide > end + SLACK:
            self.places.append([])
            low = self.margin
        return _Row(len(self.places) - 1, low, wide, self.margin, self.stock[0] - self.margin)

    def sizes(self) -> list[tuple[float, float]]:
        """Return the length and width that each piece needs [mm]."""
        ends = [(0.0, 0.0)] * len(self.places)
        for row in self.rows:
            long, wide = ends[row.piece]
            right, high = row.free - self.gap + self.margin, row.low + row.height + self.margin
            ends[row.piece] = max(long, right), max(wide, high)
        return ends

    def pieces(self) -> list[Piece]:
        """Return the pieces filled so far."""
        return [self._make_piece(f"film-{i}", places) for i, places in enumerate(self.places, 1)]

    def _make_piece(self, name: str, places: Sequence[tuple[CutPart, float, float]]) -> Piece:
        count = Counter(part.name for part, _, _ in places)
        outlines = []
        for part, x, low in places:
            left, bottom, _, _ = part.outline.box()
            outlines.append(part.outline.translate(x - left, low - bottom))
        return Piece(
            name=name,
            length=self.stock[0],
            width=self.stock[1],
            parts=outlines,
            counts=[(part.name, count[part.name]) for part in self.parts if count[part.name]],
        )
