"""The noise is normal, reproducible and without memory."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from bench.control.in_c import mix
from bench.control.in_c import noise as drawn
from layerjam.bench.control.noise import LAYERS, make_key, mix_bits, normal


def test_it_is_the_standard_normal_distribution() -> None:
    z = drawn(1, 0, 0, 2_000_000)
    assert stats.kstest(z, "norm").pvalue > 1e-3
    assert stats.skew(z) == pytest.approx(0, abs=0.01)
    assert stats.kurtosis(z) == pytest.approx(0, abs=0.02)
    for edge in (2.0, 3.0, 3.6541528853610088, 4.0, 4.5):
        wanted = 2 * stats.norm.sf(edge) * len(z)
        assert (np.abs(z) > edge).sum() == pytest.approx(wanted, abs=4 * np.sqrt(wanted))
    assert (z > 0).mean() == pytest.approx(0.5, abs=0.002)


def test_the_layers_close_at_the_top() -> None:
    """256 layers of one area end at the peak: over the last edge lies exactly that area."""
    area = LAYERS.edges[0] * np.exp(-0.5 * LAYERS.edges[1] ** 2)
    last = LAYERS.edges[255] * (1 - np.exp(-0.5 * LAYERS.edges[255] ** 2))
    assert last == pytest.approx(area, rel=1e-9)


def test_a_number_depends_on_seed_stream_and_count_alone() -> None:
    a = drawn(5, 2, 0, 1000)
    np.testing.assert_array_equal(a[400:], drawn(5, 2, 400, 600))
    assert not np.intersect1d(a, drawn(5, 3, 0, 1000)).size
    assert not np.intersect1d(a, drawn(6, 2, 0, 1000)).size


def test_neighbours_and_streams_are_not_correlated() -> None:
    n = 400_000
    a, b = drawn(9, 0, 0, n), drawn(9, 1, 0, n)
    for lag in (1, 2, 3, 10):
        assert abs(np.corrcoef(a[lag:], a[:-lag])[0, 1]) < 5 / np.sqrt(n)
    assert abs(np.corrcoef(a, b)[0, 1]) < 5 / np.sqrt(n)
    assert abs(np.corrcoef(a[1:] ** 2, a[:-1] ** 2)[0, 1]) < 5 / np.sqrt(n)


def test_the_mixer_is_splitmix64() -> None:
    """First outputs of the published generator from the state 1234567."""
    golden, state = 0x9E3779B97F4A7C15, 1234567
    wanted = (6457827717110365317, 3203168211198807973, 9817491932198370423)
    for out in wanted:
        state = (state + golden) % 2**64
        assert mix_bits(state) == mix(state) == out


@pytest.mark.parametrize("seed", [0, 7, -3, 2**63])
def test_python_draws_the_numbers_of_c(seed: int) -> None:
    """Bit for bit; some of 20,000 numbers come from the tail, 200 from the edge of a layer."""
    key = make_key(seed, 3)
    plain = [normal(key, n, LAYERS) for n in range(20_000)]
    assert plain == drawn(seed, 3, 0, 20_000).tolist()
