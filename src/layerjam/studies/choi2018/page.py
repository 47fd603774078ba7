"""One self-contained HTML page: no script, no outside address, pictures inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from layerjam.report.page import Picture, page_environment, page_style, svg_of
from layerjam.studies.choi2018.claims import Claim, Verdict

MARKS = {
    Verdict.REPRODUCED: "✓",
    Verdict.DIFFERS: "≠",
    Verdict.NOT_REPRODUCIBLE: "?",
    Verdict.NOT_YET: "…",
}


@dataclass(frozen=True, kw_only=True)
class Part:
    """A section of the page."""

    id: str
    title: str
    text: Sequence[str] = ()
    claims: Sequence[Claim] = ()
    pictures: Sequence[Picture] = field(default_factory=tuple)


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
    environment = page_environment()
    environment.filters["value"] = _value
    environment.filters["cell"] = lambda v: "value" if isinstance(v, int | float) else "words"
    template = (files("layerjam.studies.choi2018") / "page.html.j2").read_text(encoding="utf-8")
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
        style=page_style(),
        footer=footer,
        counts=tally(parts),
        marks=MARKS,
    )


def tally(parts: Sequence[Part]) -> dict[str, int]:
    """How many claims got each verdict."""
    verdicts = [claim.verdict for part in parts for claim in part.claims]
    return {str(v): verdicts.count(v) for v in Verdict}
