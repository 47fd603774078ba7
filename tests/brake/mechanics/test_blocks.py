"""Large arrays are computed in blocks: the same numbers as all at once, whatever the shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from layerjam import laws
from layerjam.brake.mechanics import blocks
from layerjam.brake.mechanics.arrays import leaves
from strategies import KAPTON, random_brakes

POINTS = 60
RANDOM = np.random.default_rng(8)
SLIP = RANDOM.uniform(-0.01, 0.08, POINTS)
VACUUM = RANDOM.uniform(-1e3, 1e5, POINTS)
SPEED = RANDOM.uniform(0.1, 4.0, POINTS)
MANY = random_brakes(3, POINTS)
CASES: dict[str, tuple[Any, ...]] = {
    "one brake": (laws.brake_force, SLIP, VACUUM, KAPTON),
    "a brake for each point": (laws.brake_force, SLIP, VACUUM, MANY),
    "a table": (laws.brake_force, SLIP.reshape(5, 12), VACUUM.reshape(5, 12), KAPTON),
    "rows and columns": (laws.brake_force, SLIP[:, None], VACUUM, KAPTON),
    "every other point": (laws.enclosure_force, SLIP[::2], 6e4, KAPTON),
    "stops": (laws.stop, 1.2, SPEED, np.abs(VACUUM), 15e3, 9.8, MANY),
    "tuned vacuums": (laws.tuned_vacuum, 1.2, SPEED, 0.03, 15e3, 9.8, KAPTON),
    "vacuums of a force": (laws.vacuum_for_force, SPEED * 50, np.abs(SLIP), KAPTON),
    "no slip": (laws.holding_force, VACUUM, KAPTON),
}


@pytest.mark.parametrize("block", [7, 20, 59, 60])
@pytest.mark.parametrize("case", CASES)
def test_blocks_give_what_all_points_at_once_give(
    case: str, block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    law, *arguments = CASES[case]
    whole = law(*arguments)
    monkeypatch.setattr(blocks, "BLOCK", block)
    part = law(*arguments)
    assert type(part) is type(whole)
    for left, right in zip(leaves(part), leaves(whole), strict=True):
        assert (left.shape, left.dtype) == (right.shape, right.dtype)
        np.testing.assert_allclose(left, right, rtol=1e-14)


def test_no_intermediate_result_is_larger_than_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    monkeypatch.setattr(blocks, "BLOCK", 16)

    def add(a: Any, b: Any) -> Any:
        sizes.append(a.size)
        return a + b

    np.testing.assert_array_equal(blocks.in_blocks(add)(SLIP, 1.0), SLIP + 1.0)
    assert sizes == [16, 16, 16, 12]
    # points that depend on each other would have another shape
    assert blocks.in_blocks(lambda a: a.sum())(SLIP) == SLIP.sum()
