"""One self-contained page for every report, as HTML and as a PDF typeset by typst."""

import base64
import hashlib
import json
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from layerjam.core.drawing import style
from layerjam.core.drawing.style import format_svg
from layerjam.core.errors import MissingExtraError

if TYPE_CHECKING:
    import jinja2

NONE = "–"
_NUMBER = r"(≈ )?−?\d+(\.\d+)?"
NUMERIC = re.compile(rf"{NONE}|{_NUMBER}( to {_NUMBER})?( [^ ]{{1,8}})?")
"""Pattern of cell texts that are treated as numbers; it excludes dates and file names."""
LEVELS = {
    "passed": ("ok", "yes"),
    "note": ("note", "note"),
    "warning": ("LOOK", "no"),
    "failed": ("FAILED", "no"),
}
"""Level of a check: its mark on a page, and the CSS class of the mark."""
NO_DATE = datetime(1980, 1, 1, tzinfo=UTC)
"""Default date of a PDF, fixed so that its bytes do not depend on the day."""


def typeset_text(text: str) -> str:
    """Return a text with typographic minus and percent signs: −0.2 % for -0.2%."""
    return re.sub(r"(?<![^\s(±])-(?=\d)", "−", re.sub(r"(?<=\d)%", " %", text))


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure with its drawing function, file name and caption."""

    name: str
    figure: Callable[[], style.Figure]
    caption: str


@dataclass(frozen=True)
class Word:
    """A cell that is not a number, with its class in the style sheet."""

    text: str
    kind: str = ""

    def template_data(self, with_unit: bool) -> dict[str, str]:
        """Return the data for the templates."""
        return {"text": self.text, "kind": self.kind}


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a page; its cells are texts, Words and Numbers.

    The last `total` rows are separated from the others; `groups` are (title, columns).

    `extra` are numbers that appear in the note or in an interval, but in no cell of their own. A
    table that is `whole` stays on one page.
    """

    id: str
    head: Sequence[str]
    rows: Sequence[Sequence[Any]]
    caption: str = ""
    groups: Sequence[tuple[str, int]] = ()
    total: int = 0
    note: str = ""
    unit_in_head: bool = False
    extra: Sequence[Any] = ()
    whole: bool = False

    def template_data(self) -> dict[str, Any]:
        """Return the data for the templates, as text."""
        rows = [[self._cell_data(cell) for cell in row] for row in self.rows]
        return {
            "id": self.id,
            "caption": self.caption,
            "head": list(self.head),
            "groups": [{"title": title, "span": span} for title, span in self.groups],
            "rows": rows,
            "right": [self._is_numeric_column(i, rows) for i in range(len(self.head))],
            "total": self.total,
            "note": typeset_text(self.note),
            "whole": self.whole,
        }

    def _is_numeric_column(self, column: int, rows: Sequence[Sequence[Mapping[str, str]]]) -> bool:
        """Return whether a column contains numbers, some of which may be missing."""
        cells = [row[column] for row in self.rows]
        first = bool(rows) and rows[0][column]["kind"] == "number"
        return first or any(not isinstance(cell, str | Word) for cell in cells)

    def _cell_data(self, cell: Any) -> dict[str, str]:
        if not isinstance(cell, str):
            return dict(cell.template_data(not self.unit_in_head))
        numeric = NUMERIC.fullmatch(cell) is not None
        digest = len(cell) == 64 and " " not in cell
        return {"text": cell, "kind": "sha" if digest else "number" if numeric else ""}


@dataclass(frozen=True, kw_only=True)
class Part:
    """A section of a page; each of `checks` has name, level and sentence."""

    id: str
    title: str
    text: Sequence[str] = ()
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()
    checks: Sequence[Any] = ()
    notes: Sequence[str] = ()

    def template_data(self) -> dict[str, Any]:
        """Return the data for the templates, as text."""
        return {
            "id": self.id,
            "title": self.title,
            "text": [typeset_text(text) for text in self.text],
            "tables": [table.template_data() for table in self.tables],
            "figures": [{"name": p.name, "caption": p.caption} for p in self.pictures],
            "checks": [
                {"name": c.name, "mark": mark, "kind": kind, "sentence": typeset_text(c.sentence)}
                for c in self.checks
                for mark, kind in [LEVELS[c.level]]
            ],
            "notes": list(dict.fromkeys(self.notes)),
        }


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page: `numbers` are (value, text) at the top; `verdicts` are texts with their class.

    `key` explains the numbers; `identity` {label: text} identifies the document. `mark` appears on
    every printed page.
    """

    title: str
    lead: str
    parts: Sequence[Part]
    footer: str
    numbers: Sequence[tuple[str, str]] = ()
    verdicts: Sequence[Word] = ()
    banner: Sequence[str] = ()
    navigation: bool = False
    key: str = ""
    identity: Mapping[str, str] = field(default_factory=dict)
    mark: str = ""
    more: Mapping[str, str] = field(default_factory=dict)
    """Additional template data for a special kind of page."""

    def pictures(self) -> list[Picture]:
        """Return every picture, in reading order."""
        return [picture for part in self.parts for picture in part.pictures]

    def template_data(self) -> dict[str, Any]:
        """Return the data for the templates of HTML and PDF, as text."""
        return {
            **vars(self),
            "parts": [part.template_data() for part in self.parts],
            "numbers": [{"value": value, "words": words} for value, words in self.numbers],
            "verdicts": [word.template_data(False) for word in self.verdicts],
            "banner": list(self.banner),
            "identity": [{"words": words, "text": text} for words, text in self.identity.items()],
            **self.more,
        }


class Live(NamedTuple):
    """Part of a page that computes in the reader's browser."""

    markup: str
    style: str = ""
    script: str = ""


def to_html(data: Mapping[str, Any], pictures: Mapping[str, str], live: Live | None = None) -> str:
    """Return the page of a `Page.template_data` and SVGs by name, without links.

    With `live` the page has that part after its most important numbers, and a policy that allows no
    other script and no request.
    """
    inline_pictures = {
        name: apply_theme(read_inline_svg(svg, name)) for name, svg in pictures.items()
    }
    template = make_environment().from_string(_read_text("page.html.j2"))
    style_sheet = _read_text("page.css") + _make_footer_rule(data["mark"])
    parts = live or Live("")
    html = template.render(
        **data, pictures=inline_pictures, style=style_sheet + parts.style, live=parts
    )
    if live is None:
        return html
    # matplotlib's figures have style attributes
    styles = "'unsafe-inline'" if pictures else _hash_contents("style", html)
    policy = f"default-src 'none'; style-src {styles}; base-uri 'none'; form-action 'none'"
    if live.script:
        policy += f"; script-src {_hash_contents('script', html)} 'wasm-unsafe-eval'"
    meta = f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n<title>'
    return html.replace("<title>", meta, 1)


def _hash_contents(kind: str, html: str) -> str:
    """Return the source for a content policy that allows the page's only element of a kind."""
    (text,) = re.findall(rf"<{kind}[^>]*>(.*?)</{kind}>", html, re.DOTALL)
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _make_footer_rule(mark: str) -> str:
    """Return the CSS rule that prints a text at the foot of every page."""
    content = "".join(c if c.isalnum() or c == " " else f"\\{ord(c):06x}" for c in mark)
    return f'@page {{ @bottom-left {{ content:"{content}"; font:9px sans-serif; }} }}\n'


def draw_all(
    pictures: Sequence[Picture],
    progress: Callable[[str, float], None],
    start: float = 0.0,
    end: float = 1.0,
) -> dict[str, str]:
    """Return {name: text of the SVG} of every picture; `progress` receives name and progress."""
    texts = {}
    for index, picture in enumerate(pictures):
        progress(f"figure {picture.name}", start + (end - start) * index / len(pictures))
        texts[picture.name] = format_svg(picture.figure())
    return texts


def read_inline_svg(file: str, name: str) -> str:
    """Return a drawn SVG for use inside a page; `name` makes its ids unique."""
    text = re.sub(r"^.*?(?=<svg)", "", file, flags=re.DOTALL)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    width = re.search(r'<svg[^>]*? width="([0-9.]+)pt"', text)
    text = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", text, count=1)
    # all figures have the scale of their paper width; only a narrower window shrinks them
    points = float(width.group(1)) if width else 600.0
    wide = rf'\1 style="max-width:{points * 1.45:.0f}px"'
    return re.sub(r'(<svg[^>]*?) width="[^"]*"', wide, text, count=1)


def apply_theme(svg: str) -> str:
    """Return an inline figure whose colours follow the page, light or dark."""
    svg = re.sub(r' xmlns(:\w+)?="[^"]*"', "", svg)
    for name, color in re.findall(r"--(\w+):(#[0-9a-f]{6})", _read_text("page.css").split("}")[0]):
        svg = re.sub(rf"{color}\b", f"var(--{name})", svg, flags=re.IGNORECASE)
    return svg


def _read_text(name: str) -> str:
    return (files("layerjam.core.drawing") / name).read_text(encoding="utf-8")


def require_extras() -> None:
    """Raise MissingExtraError if the page cannot be drawn or written."""
    make_environment()
    with style.apply_style():
        pass


def make_environment() -> "jinja2.Environment":
    """Return the templates' environment; MissingExtraError if jinja2 is not installed."""
    with MissingExtraError.raise_if_missing("the report (jinja2)", "report"):
        import jinja2
    return jinja2.Environment(autoescape=True, trim_blocks=True, undefined=jinja2.StrictUndefined)


def typeset_pdf(data: Mapping[str, Any], pictures: Mapping[str, str]) -> bytes:
    """Return a report's bytes; the same content and date produce the same bytes.

    `data` is the result of Page.template_data, with a `date` (ISO) and a `command`; `pictures` the
    figures' SVG by name.
    """
    date = datetime.fromisoformat(str(data["date"])).replace(tzinfo=UTC)
    return typeset_file("page", data, {f"{name}.svg": svg for name, svg in pictures.items()}, date)


def typeset_file(
    template: str,
    data: Mapping[str, Any],
    pictures: Mapping[str, str | bytes] | None = None,
    date: datetime = NO_DATE,
) -> bytes:
    """Return the bytes of a PDF set from a template next to this file, such as page.typ.

    The template reads `data` from data.json, and `pictures` by file name. Only the fonts of typst
    are used, so that a page does not depend on the machine's fonts.
    """
    with MissingExtraError.raise_if_missing("a page as PDF (typst)", "pdf"):
        import typst
    text = (files("layerjam.core.drawing") / f"{template}.typ").read_text(encoding="utf-8")
    inputs: dict[str, str | bytes] = {**(pictures or {}), "main.typ": text}
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (inputs | {"data.json": json.dumps(data)}).items():
            raw = content if isinstance(content, bytes) else content.encode()
            (Path(folder) / name).write_bytes(raw)
        main_file = str(Path(folder) / "main.typ")
        options: dict[str, Any] = {"root": folder, "ignore_system_fonts": True, "timestamp": date}
        return bytes(typst.compile(input=main_file, format="pdf", **options))
