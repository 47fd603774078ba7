"""Plain HTML tables: a header, rows of text, and right-aligned numbers."""

from collections.abc import Iterable, Sequence
from html import escape

from layerjam.workbench.spoken import page_text, typeset_symbols

Cell = str | tuple[str, str]
"""A text, or a text and additional CSS classes."""


def html_table(
    heads: Sequence[str],
    rows: Iterable[Sequence[Cell]],
    numbers: Sequence[int] = (),
    caption: str = "",
    ident: str = "",
) -> str:
    """Return a table as HTML; `numbers` are the right-aligned columns, and all text is escaped.

    A table that is too wide can be scrolled, also with the keyboard.
    """

    def cells(row: Sequence[Cell], tag: str) -> str:
        markup = ""
        for place, cell in enumerate(row):
            text, classes = (cell, "") if isinstance(cell, str) else cell
            kind = f"{'num' if place in numbers else ''} {classes}".strip()
            text = typeset_symbols(text) if place in numbers else text
            # an empty header is not a heading for screen readers
            name = "th" if tag == "th" and text else "td"
            scope = ' scope="col"' if name == "th" else ""
            markup += (
                f"<{name}{scope}{_attribute_text('class', kind)}>{escape(page_text(text))}</{name}>"
            )
        return f"<tr>{markup}</tr>"

    body = "".join(cells(row, "td") for row in rows)
    attributes = _attribute_text("aria-label", caption) + _attribute_text("data-testid", ident)
    return (
        f'<div class="plain-scroll" tabindex="0"><table class="plain-table"{attributes}>'
        f"<thead>{cells(heads, 'th')}</thead><tbody>{body}</tbody></table></div>"
    )


def _attribute_text(name: str, value: str) -> str:
    return f' {name}="{escape(value)}"' if value else ""
