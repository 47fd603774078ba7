"""Content of a result as blocks, which a terminal and a notebook show in their own form."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import groupby

from layerjam.core.command import wording

_LEFT = 'style="text-align:left"'
_TEXT = 'style="white-space:pre-wrap"'


@dataclass(frozen=True)
class Rows:
    """Rows of (name, text)."""

    pairs: Sequence[tuple[str, str]]

    def format_text(self, width: int) -> list[str]:
        """Return lines with the names in one column."""
        wide = max((len(name) for name, _ in self.pairs), default=0)
        return [
            line
            for name, text in self.pairs
            for line in wording.wrap_text(text, f"{name:<{wide}}  ", width)
        ]

    def format_html(self) -> str:
        """Return a table."""
        body = "".join(
            f"<tr><th {_LEFT}>{escape(name)}</th>"
            f"<td {_LEFT}>{escape(wording.raise_powers(text))}</td></tr>"
            for name, text in self.pairs
        )
        return f"<table>{body}</table>" if body else ""


@dataclass(frozen=True)
class Lines:
    """Lines of text, in which empty ones separate paragraphs; none is wrapped if `is_fixed`."""

    lines: Sequence[str]
    is_fixed: bool = False

    def format_text(self, width: int) -> list[str]:
        """Return the lines, wrapped unless that would break a table or a command."""
        out: list[str] = []
        for line in self.lines:
            # a command stays on one line, because a line break would end it when pasted
            is_whole = self.is_fixed or not line or line.startswith("  layerjam ")
            out += [line] if is_whole else wording.wrap_text(line, "", width)
        return out

    def format_html(self) -> str:
        """Return a paragraph of monospaced lines for each group between empty lines."""
        groups = ("\n".join(lines) for has_text, lines in groupby(self.lines, bool) if has_text)
        return "".join(f"<pre {_TEXT}>{escape(_clean(text))}</pre>" for text in groups)


@dataclass(frozen=True)
class Section:
    """A title with entries; nothing if there are none."""

    title: str
    entries: Sequence[str]

    def format_text(self, width: int) -> list[str]:
        """Return the title and its indented entries."""
        return wording.list_section(self.title, self.entries, width)

    def format_html(self) -> str:
        """Return the title and a list."""
        items = "".join(f"<li>{escape(_clean(entry))}</li>" for entry in self.entries)
        return f"<p>{escape(self.title)}</p><ul>{items}</ul>" if items else ""


@dataclass(frozen=True)
class Remark:
    """A sentence after its label, such as "note: "."""

    label: str
    text: str

    def format_text(self, width: int) -> list[str]:
        """Return the sentence, wrapped behind its label."""
        return wording.wrap_text(self.text, self.label, width)

    def format_html(self) -> str:
        """Return one paragraph."""
        return f"<p>{escape(_clean(self.label + self.text))}</p>"


Block = Rows | Lines | Section | Remark


def format_text(blocks: Iterable[Block], width: int) -> str:
    """Return the blocks as lines of at most `width` characters, if words allow it."""
    lines = (line for block in blocks for line in block.format_text(width))
    return "\n".join(wording.strip_control_codes(line) for line in lines)


def format_html(blocks: Iterable[Block]) -> str:
    """Return the blocks as HTML for a notebook."""
    return "".join(block.format_html() for block in blocks)


def _clean(text: str) -> str:
    return "\n".join(wording.strip_control_codes(line) for line in text.split("\n"))
