"""What every self-contained HTML page needs: pictures inside, one style, no outside address."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING

from layerjam.errors import MissingExtraError
from layerjam.report.style import look

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure, how to draw it, its file name and caption."""

    name: str
    figure: Callable[[], Figure]
    caption: str


def drawn(figure: Figure) -> str:
    """The figure as an SVG file's text; the same figure gives the same bytes."""
    buffer = io.StringIO()
    with look():
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def svg_of(file: str, name: str) -> str:
    """A drawn SVG to stand inside a page; ids carry `name` so that two do not clash."""
    text = re.sub(r"^.*?(?=<svg)", "", file, flags=re.DOTALL)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    width = re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    # every figure at one scale: its own width on paper, smaller only where the window is
    points = float(width.group(1)) if width else 600.0
    return re.sub(
        r'(<svg[^>]*?) width="[^"]*"', rf'\1 style="max-width:{points * 1.45:.0f}px"', text, count=1
    )


def page_style() -> str:
    """The style sheet that all pages share."""
    return (files("layerjam.report") / "page.css").read_text(encoding="utf-8")


def check_extras() -> None:
    """Raise MissingExtraError where the page could not be drawn or written."""
    page_environment()
    with look():
        pass


def page_environment() -> jinja2.Environment:
    """The templates' environment; raises MissingExtraError without jinja2."""
    try:
        import jinja2
    except ImportError:
        raise MissingExtraError("the report (jinja2)", "report") from None
    return jinja2.Environment(autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined)
