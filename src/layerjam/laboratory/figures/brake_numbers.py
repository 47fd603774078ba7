"""Numbers of a report, each with its unit, uncertainty, count, source and format.

Pages show only these numbers, so that the CSV contains every number of a page.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from layerjam.core.conversion import unit_factor
from layerjam.core.drawing.page import NONE, Table
from layerjam.core.units import get, show


@dataclass(frozen=True, kw_only=True)
class Number:
    """One number, SI. `low` and `high` bound a 95 % interval; unknown values are None.

    `shown_in` is the unit on the page, "" for the most readable one. `decimals` is the number of
    decimals; None means as many as the standard error justifies.
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
        """Return the columns of numbers.csv."""
        return {name: getattr(self, name) for name in COLUMNS}

    def template_data(self, with_unit: bool) -> dict[str, str]:
        """Return the number as the cell of a table."""
        return {"text": self.text(with_unit), "kind": "number"}

    def text(self, with_unit: bool = True) -> str:
        """Return the number as a page shows it."""
        if self.value is None or not math.isfinite(self.value):
            return NONE
        return self._scale(self.value) + (self._text_after() if with_unit else "")

    def error_text(self) -> str:
        """Return the standard error, in the unit of `text`."""
        error = self.standard_error
        return NONE if error is None else self._scale(error) + self._text_after()

    def interval_text(self) -> str:
        """Return the 95 % interval, in the unit of `text`."""
        if self.low is None or self.high is None:
            return NONE
        return f"{self._scale(self.low)} to {self._scale(self.high)}{self._text_after()}"

    def page_unit(self) -> str:
        """Unit shown on the page; "1" for a pure number."""
        if self.shown_in or self.unit == "1" or self.value is None:
            return self.shown_in or self.unit
        return show(self.value, self.unit).split(" ", 1)[1]

    def _text_after(self) -> str:
        unit = self.page_unit()
        return "" if unit in ("1", "") else f" {unit}"

    def _scale(self, value: float) -> str:
        """Return the digits of a value in the page's unit."""
        factor, error, places = self._display_factor(), self.standard_error, self.decimals
        if places is None and error and math.isfinite(error):
            places = max(0, 1 - math.floor(math.log10(error / factor)))
        return _format_fixed(value / factor, places)

    def _display_factor(self) -> float:
        unit = self.page_unit()
        return 1.0 if unit in ("", self.unit) else float(unit_factor(unit, self.unit) or 1)


class Column(NamedTuple):
    """A number that every record of one kind contains: its name, its path there, and its format.

    `path` and `error` (for its standard error) are dotted names in the record; the other fields are
    as in a Number.
    """

    words: str
    path: str
    unit: str = "1"
    shown_in: str = ""
    decimals: int | None = None
    error: str = ""

    def number(self, record: object, stem: str, detail: str = "", **more: Any) -> Number:
        """Return this number of a record, named "stem: words, detail".

        `more` are the other fields of a Number.
        """
        if self.error:
            more["standard_error"] = get(record, self.error)
        return Number(
            quantity=f"{stem}: {self.words}{detail and ', '}{detail}",
            value=get(record, self.path),
            unit=self.unit,
            shown_in=self.shown_in,
            decimals=self.decimals,
            **more,
        )


COLUMNS = ("quantity", "value", "unit", "standard_error", "low", "high", "n", "source")
Cell = Number | str


def table_numbers(table: Table) -> list[Number]:
    """Return every number of a table, in reading order."""
    cells = [cell for row in table.rows for cell in row if isinstance(cell, Number)]
    return [*cells, *table.extra]


def estimates_table(numbers: Sequence[Number], **table: Any) -> Table:
    """Return a table of fitted numbers with their standard error, interval, count and source."""
    return Table(
        head=["quantity", "value", "standard error", "95 % interval", "n", "based on"],
        rows=[
            [_describe_number(n), n, n.error_text(), n.interval_text(), str(n.n or NONE), n.source]
            for n in numbers
        ],
        **table,
    )


def _describe_number(number: Number) -> str:
    return number.quantity.split(": ", 1)[-1]


def _format_fixed(value: float, places: int | None) -> str:
    if places is not None:
        text = f"{value:.{min(places, 12)}f}"
    else:
        text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    if text.startswith("-") and not float(text):
        text = text[1:]
    return text.replace("-", "−", 1) if text.startswith("-") else text
