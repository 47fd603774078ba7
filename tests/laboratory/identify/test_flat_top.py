"""What an end of a converter looks like, and what chance makes of a gentle pulse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from counts import cases
from layerjam.laboratory.identify.logs.crash import reduce_crash
from layerjam.laboratory.identify.logs.flat_top import CHANCE, find_flat_top

STILL = 0.07
"""Quiet at the beginning [s]."""


def shape(x, kind):
    """A half-sine, a haversine, one that rises faster than it falls; x from 0 to 1."""
    skew = np.where(x < 0.35, np.sin(np.pi * x / 0.7), np.sin(np.pi * (x + 0.3) / 1.3))
    pulse = [np.sin(np.pi * x), np.sin(np.pi * x) ** 2, skew][kind]
    return np.where((x >= 0) & (x <= 1), pulse, 0.0)


def gentle(draw, over=None, noise=None):
    """Record of a converter of 8 to 16 bits, noise of 0.2 to 3 quanta; samples before the pulse.

    Its peak is at 10 to 95 % of the end, or by the part `over` beyond it.
    """
    full = 2 ** (int(draw.integers(8, 17)) - 1)
    noise = draw.uniform(0.2, 3.0) if noise is None else noise
    rate, length = draw.choice([5e3, 8e3, 10e3, 20e3]), draw.uniform(0.005, 0.06)
    height = full * (draw.uniform(0.1, 0.95) if over is None else 1 + over)
    time = np.arange(0, 0.15 + length, 1 / rate)
    begin = 0.08 + draw.uniform() / rate
    true = height * shape((time - begin) / length, draw.integers(3)) + draw.uniform(-0.5, 0.5)
    codes = np.clip(np.round(true + draw.normal(0, noise, len(time))), -full, full - 1)
    return codes * draw.choice([-1, 1]) * draw.uniform(0.01, 10), int(STILL * rate)


def judged(count, seed, over=None):
    """How many records show an end, and how many cannot tell."""
    draw = np.random.default_rng(seed)
    found = [
        find_flat_top(*gentle(draw, None if over is None else draw.uniform(*over)))
        for _ in range(count)
    ]
    there = [one for one in found if one is not None]
    return sum(one.certain for one in there), sum(not one.certain for one in there)


def test_gentle_pulses_and_cut_off_ones():
    assert judged(250, 1) == (0, 0)
    assert judged(250, 2, over=(0.05, 1.0)) == (250, 0)


@pytest.mark.slow
def test_false_alarms_in_a_thousand_and_ends_found():
    """At most 1 in 1,000, at least 99 %."""
    false, unknown = judged(count := cases(3000, 1000), 3)
    assert false + unknown <= count // 1000
    count = cases(2000, 700)
    assert judged(count, 4, over=(0.05, 1.0))[0] >= 0.99 * count


def test_three_equal_samples_happen_by_chance():
    """What this replaces: among gentle pulses they are common."""
    draw, three = np.random.default_rng(5), 0
    for _ in range(300):
        record, quiet = gentle(draw)
        at = np.abs(record - record[:quiet].mean())
        top = (at == at.max()).astype(int)
        three += bool((np.convolve(top, [1, 1, 1]) == 3).any())
    assert three > 8


def plateau(draw, height, noise, count=200, corner=8):
    """A pulse that is really flat, for so many samples."""
    places = np.array([0, corner, corner + count, 2 * corner + count]) + 800
    true = np.interp(np.arange(2000), places, [0.0, height, height, 0.0])
    return np.round(true + draw.uniform(-0.5, 0.5) + draw.normal(0, noise, 2000))


@pytest.mark.parametrize("height", [3, 10, 40])
def test_a_flat_pulse_of_few_steps_is_not_called_an_end(height):
    """Its noise goes on, or it stays within one step and nobody can tell."""
    draw = np.random.default_rng(6)
    for noise in (0.2, 0.5, 1.0):
        for _ in range(20):
            found = find_flat_top(plateau(draw, height * draw.uniform(1, 1.3), noise), 700)
            assert found is None or not found.certain
    still = plateau(draw, height, 0.0)
    found = find_flat_top(still, 700)
    assert found is not None and not found.certain and found.count >= 200


def test_noise_that_goes_at_the_top_is_an_end_however_coarse():
    """Of a constant value in the middle of a step, n samples are equal with the chance p^n."""
    draw = np.random.default_rng(7)
    chance = norm.cdf(0.5 / 0.7) - norm.cdf(-0.5 / 0.7)
    enough = int(np.log(CHANCE) / np.log(chance))
    for count, certain in ((3 * enough, True), (enough // 2, False)):
        record = np.round(draw.normal(0, 0.7, 2000))
        record[800 : 800 + count] = 12.0
        found = find_flat_top(record, 700)
        assert found is not None and (found.count, found.certain) == (count, certain)


def test_noise_with_a_memory_makes_longer_runs():
    """White noise smoothed over 15 samples, behind a coarse converter: no end."""
    draw, window = np.random.default_rng(8), np.ones(15) / 15
    for _ in range(40):
        noise = np.convolve(draw.normal(0, 4.0, 2014), window, "valid")
        level = np.interp(np.arange(2000), [800, 808, 1100, 1108], [0, 40.0, 40.0, 0])
        found = find_flat_top(np.round(level + noise), 700)
        assert found is None or not found.certain


def test_the_scale_and_the_digits_of_a_file_do_not_matter():
    draw = np.random.default_rng(9)
    for over in (None, 0.2):
        record, quiet = gentle(draw, over, noise=0.8)
        for other in (record * -3.7, np.array([float(f"{v:.6g}") for v in record])):
            one, two = find_flat_top(record, quiet), find_flat_top(other, quiet)
            assert (one is None) == (two is None) == (over is None)
            assert one is None or two is None or (one.count, one.certain) == (two.count, True)


def test_what_was_computed_without_noise_is_not_judged():
    time = np.arange(0, 0.2, 1e-4)
    pulse = np.clip(500 * shape((time - 0.08) / 0.02, 0), None, 400)
    found = reduce_crash(time, pulse)
    assert not found.saturated and found.saturation is None
    assert [w.key for w in found.warnings if hasattr(w, "key")] == ["flat-top"]
    noisy = reduce_crash(
        time, np.clip(pulse + np.random.default_rng(1).normal(0, 0.1, 2000), None, 400)
    )
    assert noisy.saturated and noisy.saturation == 400
    assert reduce_crash(time, pulse, limit=400.0).saturated
    assert not reduce_crash(time, 500 * shape((time - 0.08) / 0.02, 0)).warnings[1:]
    coarse = reduce_crash(time, np.round(pulse))
    assert coarse.saturated and coarse.saturation == 400
