"""The ratios that docs/bending.md prints next to two papers' laws."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2]))  # where pytest was not started in the root
from benchmarks import bending


def test_the_ratios_of_the_page() -> None:
    for way, ratio in ((4e-3, 0.89), (8e-3, 0.91)):
        mine = bending.ours_as_caruso(way)
        assert float(mine / bending.caruso(way)) == pytest.approx(ratio, abs=0.005)
    for way, ratio in ((10e-3, 0.74), (50e-3, 0.35)):
        mine = bending.ours_as_zhang(way)
        assert float(mine / bending.zhang(way)) == pytest.approx(ratio, abs=0.005)


def test_all_transition_loads_of_caruso_add_up_to_our_full_slip() -> None:
    n, h, b, _, mu = bending.CARUSO.values()
    ours = 2 * mu * bending.CARUSO_VACUUM * b * h * (13 * n / 12 - 1)
    assert bending.caruso(1.0) == pytest.approx(ours, rel=1e-12)


def test_large_angles_need_more_force_than_small_ones() -> None:
    assert bending.bent_far(50e-3) == pytest.approx(3.847, abs=0.002)
    assert bending.bent_far(5e-3) == pytest.approx(3.135 * 1.01, rel=0.01)  # q t (n - 1)
