"""Sentences with a number: one is not many."""

from __future__ import annotations

import pytest

from layerjam.core.errors import are_text, count_text


@pytest.mark.parametrize(
    ("number", "noun", "verb"),
    [(0, "0 samples", "are"), (1, "1 sample", "is"), (2, "2 samples", "are")],
)
def test_a_noun_and_a_verb_follow_their_number(number, noun, verb):
    assert count_text(number, "sample") == noun
    assert are_text(number, "sample") == f"{noun} {verb}"
