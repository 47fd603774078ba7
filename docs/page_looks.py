"""Details of a page's looks that Markdown cannot express; a hook of mkdocs.

A browser breaks a line after a hyphen, within code too, so that `--` ends one line and `figure`
begins the next: such words are kept in one piece. A bar within a table needs a backslash on GitHub,
which the site would show. A room of one page needs no menu next to it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.structure.pages import Page

CODE = re.compile(r"(?P<block><pre\b.*?</pre>)|<code>(?P<inline>[^<]*)</code>", re.DOTALL)
WORD = re.compile(r"(?<!\S)[^\s<]*-[^\s<]*(?!\S)")
LONGEST = 30
"""Characters of a word that still fits next to others on a phone."""
LONG = 48
"""Characters of code from which a table's first column may break it."""
ALONE = ("index.md", "gallery.md")


def looks(content: str) -> str:
    """A page's HTML whose inline code breaks where a reader would break it."""

    def word(found: re.Match[str]) -> str:
        text = found.group(0)
        return text if len(text) > LONGEST else f'<span class="kept">{text}</span>'

    def code(found: re.Match[str]) -> str:
        if found["block"] is not None:
            return found["block"]
        text = found["inline"].replace("\\|", "|")
        start = '<code class="long">' if len(text) > LONG else "<code>"
        return f"{start}{WORD.sub(word, text)}</code>"

    return CODE.sub(code, content)


def on_page_markdown(markdown: str, page: Page, **_of: object) -> str:
    """Hide the menu of pages that need none; mkdocs calls this for every page."""
    if page.file.src_uri in ALONE:
        page.meta["hide"] = ["navigation"]
    return markdown


def on_page_content(content: str, **_of: object) -> str:
    """Return the HTML of a page with its code kept in one piece; mkdocs calls this."""
    return looks(content)
