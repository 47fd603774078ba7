"""Quantities of a batch and the function that evaluates its cases."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
Run = Callable[[int, int, Mapping[str, Array]], None]
"""Function that evaluates `count` flat cases, starting with `first`, into arrays of that length."""


@dataclass(frozen=True)
class Sweep:
    """One quantity of a batch: its dimension, its values and its stride over the flat grid."""

    name: str
    dimension: str | None
    values: Array = field(repr=False)
    stride: int = 1

    def take_cases(self, cases: Array) -> Array:
        """Return the values of the flat cases."""
        return self.values[(cases // self.stride) % len(self.values)]
