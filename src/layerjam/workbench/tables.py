"""Plain tables: a head, rows of text, numbers to the right."""

from collections.abc import Iterable, Sequence
from html import escape

from layerjam.workbench.spoken import on_page, typeset

Cell = str | tuple[str, str]
"""A text, or a text and the classes it has besides."""


def html(
    heads: Sequence[str],
    rows: Iterable[Sequence[Cell]],
    numbers: Sequence[int] = (),
    caption: str = "",
    ident: str = "",
) -> str:
    """The table; `numbers` are the columns that stand right. Nothing in it is taken as HTML.

    Where it is too wide it scrolls, by the keyboard too.
    """

    def cells(row: Sequence[Cell], tag: str) -> str:
        made = ""
        for place, cell in enumerate(row):
            text, more = (cell, "") if isinstance(cell, str) else cell
            kind = f"{'num' if place in numbers else ''} {more}".strip()
            text = typeset(text) if place in numbers else text
            # a head without words is none
            kind_of = "th" if tag == "th" and text else "td"
            scope = ' scope="col"' if kind_of == "th" else ""
            made += f"<{kind_of}{scope}{_said('class', kind)}>{escape(on_page(text))}</{kind_of}>"
        return f"<tr>{made}</tr>"

    body = "".join(cells(row, "td") for row in rows)
    about = _said("aria-label", caption) + _said("data-testid", ident)
    return (
        f'<div class="plain-scroll" tabindex="0"><table class="plain-table"{about}>'
        f"<thead>{cells(heads, 'th')}</thead><tbody>{body}</tbody></table></div>"
    )


def _said(name: str, value: str) -> str:
    return f' {name}="{escape(value)}"' if value else ""
