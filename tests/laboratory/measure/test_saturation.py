"""The top of a record, whichever way it is read."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.laboratory.measure.saturation import _locate_top

NOISE = 0.3


@pytest.mark.parametrize("seed", range(12))
def test_the_top_of_a_record_read_backwards_is_the_same(seed: int) -> None:
    draw = np.random.default_rng(seed)
    count = int(draw.integers(80, 400))
    slope = 100 * (1 - np.abs(np.linspace(-1, 1, count) - draw.uniform(-0.4, 0.4)))
    record = np.minimum(slope, draw.uniform(50, 95)) + draw.normal(0, NOISE, count)
    first, last = _locate_top(record, NOISE)
    assert 0 <= first < last <= count
    assert _locate_top(record[::-1], NOISE) == (count - last, count - first)
