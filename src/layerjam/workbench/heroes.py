"""The two or three numbers that a page is about, large, before all the others."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from layerjam.workbench import live
from layerjam.workbench.widgets import dressed

Hero = tuple[str, str, str]
"""A key, what it is, and its value with its unit."""


class Heroes:
    """Large numbers that change with every move; each is found by its page and key."""

    def __init__(self, page: str) -> None:
        self._page = page
        self._table = dressed(live.Table(), f"{page}-heroes", "w-full")

    def fill(self, numbers: Sequence[Hero]) -> None:
        """Show them in their order."""
        self._table.set_content(html(self._page, numbers))


def html(page: str, numbers: Sequence[Hero]) -> str:
    """HTML of large numbers; the unit stands smaller behind its number."""
    cells = []
    for key, name, text in numbers:
        value, _, unit = text.partition(" ")
        small = f" <small>{escape(unit)}</small>" if unit else ""
        ident = escape(f"{page}-{key}")
        said = f'<dd data-testid="{ident}">{escape(value)}{small}</dd>'
        cells.append(f"<div><dt>{escape(name)}</dt>{said}</div>")
    return f'<dl class="heroes">{"".join(cells)}</dl>'
