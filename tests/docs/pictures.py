"""Comparison of a committed SVG picture with the one that its program draws today."""

from __future__ import annotations

import re

import numpy as np

from docs.style_texts import read_words

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
IDENTITY = re.compile(r"\b[mp][0-9a-f]{10}\b")
"""Name of a marker or a clip path: a hash of coordinates, to the last digit."""


def compare(committed: str, drawn: str) -> str:
    """Return the difference between two pictures: words, shapes or, beyond 0.01, coordinates."""
    old, new = read_words(committed), read_words(drawn)
    if old != new:
        return f"words: {sorted(set(old) ^ set(new))}"
    texts = [IDENTITY.sub("name", text) for text in (committed, drawn)]
    if len({NUMBER.sub("#", text) for text in texts}) > 1:
        return "shapes"
    places = [np.array(NUMBER.findall(text), dtype=float) for text in texts]
    return "" if np.allclose(*places, atol=0.01) else "coordinates"
