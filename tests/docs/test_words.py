"""The words of docs/contribute.md#style that must not come back."""

from __future__ import annotations

import re
import sys

import pytest

from docs.words import ROOT, in_notebooks, in_pages, in_source


@pytest.mark.slow
def test_what_users_read_is_free_of_them() -> None:
    found = [*in_pages(), *in_notebooks(), *in_source()]
    assert not found, "\n".join(found)


def test_the_finder_finds() -> None:
    """A check that finds nothing anywhere would pass for ever."""
    words = sys.modules["docs.words"].WORDS
    for text in (
        "the sleeve's force",
        "it judders",
        "the answer is told",
        "a standing vacuum",
        "holds 100 N",
    ):
        assert words.search(text), text
    for text in ("the enclosure's force", "told apart", "CLOSED_BY_SLEEVE"):
        assert not words.search(text), text


def test_no_text_asks_an_index_for_the_package() -> None:
    """No index has it: every printed command installs from the checkout or the wheel at hand."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*"), *(ROOT / "examples").rglob("*.py")]
    texts = [
        p for p in [*pages, *(ROOT / "src").rglob("*.py")] if p.suffix in (".md", ".py", ".txt")
    ]
    wrong = re.compile(r"pip install[^\n`]* \"?layerjam\b")
    found = [p.name for p in texts if wrong.search(p.read_text("utf-8"))]
    assert len(texts) > 100 and not found
