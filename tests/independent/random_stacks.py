"""Random stacks and pulls, from uniform numbers and exact arithmetic alone.

No logarithm, power or normal distribution: the numbers have the same bits on every machine.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

COUNT = 1000
Case = tuple[dict[str, Any], np.ndarray, np.ndarray]


def make_stack_fields(random: np.random.Generator) -> dict[str, Any]:
    """Return the fields of a stack of 2 to 60 sheets, many of them uneven, some on a soft mount."""

    def between(low: float, high: float, *shape: int) -> Any:
        return low + (high - low) * random.random(shape or None)

    def draw(*values: Any) -> Any:
        return values[int(random.random() * len(values))]

    count = int(draw(between(2, 6), between(6, 14), between(6, 14), between(14, 40)))
    count = 60 if random.random() < 0.01 else count
    even = random.random() < 0.2
    springs = np.full(count, 3e5) * (1.0 if even else between(0.3, 3.0, count))
    right = np.arange(count) % 2 == draw(0, 1)
    friction = between(0.5, 20.0) * (np.ones(count - 1) if even else between(0.2, 2, count - 1))
    if random.random() < 0.05:
        friction = friction * (random.random(count - 1) < 0.7)
    kinetic = random.random() < 0.5
    ratio = np.ones(count - 1) if kinetic else between(1.0, draw(1.01, 1.5, 2.5), count - 1)
    if not kinetic and random.random() < 0.2:
        ratio = np.full(count - 1, 1.2)
    length = between(0.02, 0.1) * (np.ones(count - 1) if even else between(0.7, 1.3, count - 1))
    if random.random() < 0.2:
        length = np.where(random.random(count - 1) < 0.5, np.inf, length)
    mount = draw(np.inf, np.inf, between(1e5, 5e5), between(1e5, 5e5), between(500, 3000))
    walls = 1 if count > 4 and random.random() < 0.3 else 0
    faces = [float(draw(3e3, 2e4, 2e5)), between(0.1, 300.0), between(0.02, 0.1)]
    return {
        "springs": springs,
        "right": right,
        "friction": friction,
        "ratio": ratio,
        "length": length,
        "mount": float(mount),
        "ends": np.array([walls, count - 1 - walls]),
        "face": np.array(draw(faces, faces, [0.0, 0.0, 1.0])),
        "one_by_one": not kinetic and random.random() < 0.5,
    }


def make_case(seed: int) -> Case:
    """Return a stack, a path with turns [m], and the friction of another stack [N]."""
    random = np.random.default_rng(seed)
    fields = make_stack_fields(random)
    strength = float((fields["friction"] * fields["ratio"]).sum()) + 0.1
    soft = 4 / float(fields["springs"].sum()) + 1 / fields["mount"]
    reach = strength * soft * (1.5, 5.0, 40.0)[int(random.random() * 3)]
    turns = [0.0, *(min(reach, 0.12) * random.random(int(random.random() * 5)))]
    turns = [*turns, min(reach, 0.12)]
    steps = 10 + int(20 * random.random())
    share = np.arange(1, steps + 1) / steps
    legs = [a + (b - a) * share for a, b in itertools.pairwise(turns)]
    scatter = 0.7 + 0.6 * random.random(len(fields["friction"]))
    return fields, np.concatenate([[0.0], *legs]), fields["friction"] * scatter


def summarise_pull(pull: Any) -> list[float]:
    """Return the length of a pull, its peak, sums over its arrays, and its energies at the end."""
    sums = (np.abs(getattr(pull, name)).sum() for name in SUMMED)
    ends = (getattr(pull, name)[-1] for name in ("force", "work", "heat", "stored"))
    return [len(pull.force), pull.force.max(), *sums, *ends]


SUMMED = ("force", "cap", "sheets", "interface", "slip", "sliding", "faces", "slack")
