"""A figure as the text of an SVG file."""

from __future__ import annotations

import io
from typing import Any

from layerjam.report import style


def drawn(figure: style.Figure, words: bool = False) -> str:
    """The figure as an SVG file's text; the same figure gives the same bytes.

    With `words` what is written in it stays text, for a page that has a typeface of its own.
    The figure is drawn once: `savefig` draws one with a layout twice, first for its layout alone.
    """
    buffer = io.StringIO()
    with style.look(words):
        from matplotlib import rcParams
        from matplotlib.backends.backend_svg import FigureCanvasSVG

        figure.set_dpi(rcParams["savefig.dpi"])
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(buffer, metadata={"Date": None})
    return buffer.getvalue()
