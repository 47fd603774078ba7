"""Size of the documentation: a reader must find a page and finish it."""

from __future__ import annotations

import re

from docs.examples import ROOT
from docs.test_redirects import navigation

PAGES = 40
WORDS = 80_000
"""Words of the pages, README and CONTRIBUTING, code and generated parts included.

It may only fall.
"""


def test_the_menu_has_few_pages() -> None:
    pages = navigation()
    print(len(pages), "pages")
    assert len(set(pages)) == len(pages) <= PAGES


def test_the_menu_has_every_page() -> None:
    pages = {path.name for path in (ROOT / "docs").glob("*.md")}
    assert pages == {name for name in navigation() if "/" not in name}


def test_the_pages_have_few_words() -> None:
    """A bar or a dash of a table is not a word."""
    places = [*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    counts = {
        path.name: sum(bool(re.search(r"\w", word)) for word in path.read_text("utf-8").split())
        for path in places
    }
    print(sum(counts.values()), "words;", *sorted(counts.items(), key=lambda c: -c[1])[:8])
    assert sum(counts.values()) <= WORDS
