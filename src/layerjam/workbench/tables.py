"""Plain tables: a head, rows of text, numbers to the right."""

from __future__ import annotations

from collections.abc import Sequence

from nicegui import ui

STYLE = """
.plain-table { border-collapse: collapse; font-size: 0.875rem }
.plain-table .td { padding: 3px 12px 3px 0; vertical-align: top; text-align: left;
  border-bottom: 1px solid rgba(128, 128, 128, 0.3) }
.plain-table .num { text-align: right; white-space: nowrap }
"""


def table(ident: str, heads: Sequence[str], numbers: Sequence[int] = ()) -> ui.element:
    """An empty table with its head; `numbers` are the columns that stand right."""
    made = ui.element("table").classes("plain-table").props(f'data-testid="{ident}"')
    with made, ui.element("tr"):
        for place, head in enumerate(heads):
            with (
                ui.element("th")
                .classes("td num" if place in numbers else "td")
                .props('scope="col"')
            ):
                ui.label(head)
    return made


def cell(text: str, classes: str = "") -> None:
    """One cell of the row that is open."""
    with ui.element("td").classes(f"td {classes}"):
        ui.label(text)
