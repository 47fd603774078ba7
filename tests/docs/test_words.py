"""The words of docs/contribute.md#style that must not come back."""

from __future__ import annotations

import sys

from docs.words import in_pages, in_source


def test_what_users_read_is_free_of_them() -> None:
    found = [*in_pages(), *in_source()]
    assert not found, "\n".join(found)


def test_the_finder_finds() -> None:
    """A check that finds nothing anywhere would pass for ever."""
    words = sys.modules["docs.words"].WORDS
    for text in ("the sleeve's force", "it judders", "the answer is told", "a standing vacuum"):
        assert words.search(text), text
    for text in ("the enclosure's force", "told apart", "CLOSED_BY_SLEEVE"):
        assert not words.search(text), text
