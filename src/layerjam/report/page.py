"""One self-contained HTML page: no script, no outside address, pictures inside."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from layerjam.errors import MissingExtraError
from layerjam.report.claims import Claim, Verdict
from layerjam.report.style import look

if TYPE_CHECKING:
    import jinja2
    from matplotlib.figure import Figure

MARKS = {
    Verdict.REPRODUCED: "✓",
    Verdict.DIFFERS: "≠",
    Verdict.NOT_REPRODUCIBLE: "?",
    Verdict.NOT_YET: "…",
}


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure, how to draw it, its file name and caption."""

    name: str
    figure: Callable[[], Figure]
    caption: str


@dataclass(frozen=True, kw_only=True)
class Part:
    """A section of the page."""

    id: str
    title: str
    text: Sequence[str] = ()
    claims: Sequence[Claim] = ()
    pictures: Sequence[Picture] = field(default_factory=tuple)


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


def _value(value: float | str | None, unit: str) -> str:
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    text = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return text if unit in ("", "1") else f"{text} {unit}"


def render_page(
    *,
    title: str,
    lead: str,
    parts: Sequence[Part],
    pictures: Mapping[str, str],
    footer: str,
    numbers: Sequence[tuple[str, str]] = (),
    banner: str = "",
) -> str:
    """The page's HTML, with `pictures` by name as drawn; MissingExtraError without jinja2."""
    environment = _environment()
    environment.filters["value"] = _value
    environment.filters["cell"] = lambda v: "value" if isinstance(v, int | float) else "words"
    template = (files("layerjam.report") / "page.html.j2").read_text(encoding="utf-8")
    shown: list[Mapping[str, Any]] = [
        {
            "id": part.id,
            "title": part.title,
            "text": part.text,
            "claims": part.claims,
            "figures": [
                {"svg": svg_of(pictures[p.name], p.name), "caption": p.caption}
                for p in part.pictures
            ],
        }
        for part in parts
    ]
    return environment.from_string(template).render(
        title=title,
        lead=lead,
        parts=shown,
        numbers=numbers,
        banner=banner,
        footer=footer,
        counts=tally(parts),
        marks=MARKS,
    )


def check_extras() -> None:
    """Raise MissingExtraError where the page could not be drawn or written."""
    _environment()
    with look():
        pass


def _environment() -> jinja2.Environment:
    try:
        import jinja2
    except ImportError:
        raise MissingExtraError("the report (jinja2)", "report") from None
    return jinja2.Environment(autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined)


def tally(parts: Sequence[Part]) -> dict[str, int]:
    """How many claims got each verdict."""
    verdicts = [claim.verdict for part in parts for claim in part.claims]
    return {str(v): verdicts.count(v) for v in Verdict}
