"""Plain tables: a head, rows of text, numbers to the right."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

STYLE = """
.plain-table { border-collapse: collapse; font-size: 0.875rem }
.plain-table .td { padding: 3px 12px 3px 0; vertical-align: top; text-align: left;
  border-bottom: 1px solid rgba(128, 128, 128, 0.3) }
.plain-table .num { text-align: right; white-space: nowrap }
"""

Cell = str | tuple[str, str]
"""A text, or a text and the classes it has besides."""


def html(
    ident: str, heads: Sequence[str], rows: Iterable[Sequence[Cell]], numbers: Sequence[int] = ()
) -> str:
    """The table; `numbers` are the columns that stand right. Nothing in it is taken as HTML."""
    made = "".join(
        f'<th scope="col" class="{_kind(place, numbers)}">{escape(head)}</th>'
        for place, head in enumerate(heads)
    )
    body = "".join(
        f"<tr>{''.join(_cell(cell, place, numbers) for place, cell in enumerate(row))}</tr>"
        for row in rows
    )
    return (
        f'<table class="plain-table" data-testid="{escape(ident)}">'
        f"<thead><tr>{made}</tr></thead><tbody>{body}</tbody></table>"
    )


def _kind(place: int, numbers: Sequence[int]) -> str:
    return "td num" if place in numbers else "td"


def _cell(cell: Cell, place: int, numbers: Sequence[int]) -> str:
    text, more = (cell, "") if isinstance(cell, str) else cell
    return f'<td class="{f"{_kind(place, numbers)} {more}".strip()}">{escape(text)}</td>'
