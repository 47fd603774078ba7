"""Sums over numbers, and over the numbers in texts, whatever the words of these."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

NUMBER = re.compile(r"(?<![\w.#-])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.-])")
HUGE = 1e12


def sums(numbers: Sequence[float], path: str) -> dict[str, float | str]:
    """Return the count of some numbers, their sum of sizes, and one with weights by place.

    The sums leave out digests and placeholders of formats, beside which all others vanish.
    """
    finite = [x for x in numbers if abs(x) < HUGE]
    return {
        f"{path}.count": float(len(numbers)),
        f"{path}.sizes": math.fsum(map(abs, finite)),
        f"{path}.places": math.fsum(x * (1 + i / len(finite)) for i, x in enumerate(finite)),
    }


def sums_said(texts: Sequence[str], path: str) -> dict[str, float | str]:
    """Return how many texts there are, and sums over the numbers in them."""
    return {f"{path}.texts": float(len(texts)), **sums(find_numbers(texts), path)}


def find_numbers(texts: Sequence[str]) -> list[float]:
    return [float(number) for text in texts for number in NUMBER.findall(text)]
