"""Numbers of a report: each with its unit, uncertainty, count and source, and how a page shows it.

Pages show nothing but what stands here, so that the CSV holds every number of a page.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from layerjam.units import show, unit_factor

NONE = "–"


@dataclass(frozen=True, kw_only=True)
class Number:
    """One number, SI. `low` and `high` bound a 95 % interval; None is what is not known.

    `shown_in` is the unit the page uses, "" for the one that reads best; `decimals` fixes the
    digits behind the point, None for those that the standard error deserves.
    """

    quantity: str
    value: float | None
    unit: str
    standard_error: float | None = None
    low: float | None = None
    high: float | None = None
    n: int | None = None
    source: str = ""
    shown_in: str = ""
    decimals: int | None = None

    def row(self) -> dict[str, Any]:
        """The columns of numbers.csv."""
        return {name: getattr(self, name) for name in COLUMNS}

    def text(self, with_unit: bool = True) -> str:
        """As a page shows it."""
        if self.value is None or not math.isfinite(self.value):
            return NONE
        unit = self.page_unit()
        number = _fixed(self.value / _factor(unit, self.unit), self._places(unit))
        return f"{number} {unit}" if with_unit and unit not in ("1", "") else number

    def error_text(self) -> str:
        """Its standard error, in the unit of `text`."""
        if self.standard_error is None:
            return NONE
        unit = self.page_unit()
        scaled = self.standard_error / _factor(unit, self.unit)
        number = _fixed(scaled, self._places(unit))
        return f"{number} {unit}" if unit not in ("1", "") else number

    def interval_text(self) -> str:
        """Its 95 % interval, in the unit of `text`."""
        if self.low is None or self.high is None:
            return NONE
        unit, places = self.page_unit(), self._places(self.page_unit())
        low, high = (_fixed(v / _factor(unit, self.unit), places) for v in (self.low, self.high))
        return f"{low} to {high}" + (f" {unit}" if unit not in ("1", "") else "")

    def page_unit(self) -> str:
        """The unit the page shows it in; "1" for a pure number."""
        if self.shown_in or self.unit == "1" or self.value is None:
            return self.shown_in or self.unit
        return show(self.value, self.unit).split(" ", 1)[1]

    def _places(self, unit: str) -> int | None:
        if self.decimals is not None:
            return self.decimals
        error = self.standard_error
        if not error or not math.isfinite(error):
            return None
        return max(0, 1 - math.floor(math.log10(error / _factor(unit, self.unit))))


COLUMNS = ("quantity", "value", "unit", "standard_error", "low", "high", "n", "source")
Cell = Number | str


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a page; a cell is a Number or a word. `total` rows at the end stand apart.

    `groups` are (title, columns) above the head. `whole` False: the printed pages leave it out
    where they run short, the HTML page and the CSV never.
    """

    id: str
    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    groups: Sequence[tuple[str, int]] = ()
    total: int = 0
    note: str = ""
    unit_in_head: bool = False
    printed: bool = True
    extra: Sequence[Number] = field(default_factory=tuple)
    """Numbers of the note or of an interval's cell that no cell holds."""

    def numbers(self) -> list[Number]:
        """Every number of it, in order of reading."""
        cells = [cell for row in self.rows for cell in row if isinstance(cell, Number)]
        return [*cells, *self.extra]

    def cells(self) -> list[list[dict[str, Any]]]:
        """Rows as the pages' templates take them."""
        return [[self._cell(cell) for cell in row] for row in self.rows]

    def _cell(self, cell: Cell) -> dict[str, Any]:
        if isinstance(cell, Number):
            return {"text": cell.text(with_unit=not self.unit_in_head), "number": True}
        return {"text": cell, "number": cell == NONE or cell[:1].isdigit() or cell[:1] == "≈"}


def estimates(identity: str, caption: str, numbers: Sequence[Number], note: str = "") -> Table:
    """A table of fitted numbers: a row each, with standard error, interval, count and source."""
    return Table(
        id=identity,
        caption=caption,
        head=["quantity", "value", "standard error", "95 % interval", "n", "rests on"],
        rows=[
            [_words(n), n, n.error_text(), n.interval_text(), str(n.n or NONE), n.source]
            for n in numbers
        ],
        note=note,
    )


def _words(number: Number) -> str:
    return number.quantity.split(": ", 1)[-1]


def _factor(unit: str, si: str) -> float:
    if unit in ("", si):
        return 1.0
    return float(unit_factor(unit, si) or 1)


def _fixed(value: float, places: int | None) -> str:
    if places is not None:
        text = f"{value:.{min(places, 12)}f}"
    else:
        text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    if text.startswith("-") and not float(text):
        text = text[1:]
    return text.replace("-", "−", 1) if text.startswith("-") else text
