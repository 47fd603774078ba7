"""Stick-slip in a record: told from noise, roughness and vibration, and measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from laboratory.campaigns import bench as virtual
from laboratory.identify.saw import teeth
from layerjam.laboratory.identify.stick_slip import (
    find_saw_teeth,
    noise_sd,
    running_mean,
    turning_points,
)

seeds = st.integers(0, 2**32 - 1)
FAR = 0.06


def test_turning_points_by_hand() -> None:
    values = np.array([0.0, 3, 2.5, 3.2, 0, 0.4, -1, 5, 5, 4.9, 1])
    peaks, troughs = turning_points(values, 1.0)
    assert peaks.tolist() == [3, 7] and troughs.tolist() == [0, 6]
    assert [len(p) for p in turning_points(np.ones(9), 0.1)] == [0, 0]


def test_running_mean_of_a_line_is_the_line() -> None:
    line = np.linspace(1, 2, 50)
    np.testing.assert_allclose(running_mean(line, 5)[2:-2], line[2:-2], rtol=1e-12)
    assert running_mean(line, 1) is line


@given(seeds)
@settings(max_examples=30)
def test_the_noise_is_seen_through_lines_and_jumps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sigma = 10 ** rng.uniform(-4, 0)
    u, force = teeth(rows=20000, noise=sigma, seed=seed % 1000)
    assert noise_sd(force) == pytest.approx(sigma, rel=0.06)
    assert noise_sd(u) < 1e-12


@given(seeds)
@settings(max_examples=60, deadline=None)
def test_teeth_come_back_within_their_stated_error(seed: int) -> None:
    """Swing 10 times the noise or more, 12 samples a tooth or more."""
    rng = np.random.default_rng(seed)
    spacing = 10 ** rng.uniform(-3.2, -2.1)
    rows = int(FAR / spacing * rng.uniform(12, 300))
    swing = 10 ** rng.uniform(-1.5, -0.3)
    noise = swing / 10 ** rng.uniform(1, 4)
    u, force = teeth(
        rows=rows, spacing=spacing, swing=swing, noise=noise, seed=seed % 9999, fall=0.02
    )
    found, why = find_saw_teeth(u, force, u / 2.5e-3)
    assert found is not None, why
    # teeth that differ by 10 % each, all ending at one level
    assert found.upper == pytest.approx(0.6 + swing / 2, abs=0.03 * swing + 5 * found.upper_se)
    assert found.lower == pytest.approx(0.6 - swing / 2, abs=0.03 * swing + 5 * found.lower_se)
    assert found.spacing == pytest.approx(spacing, rel=0.15)
    assert found.period == pytest.approx(found.spacing / 2.5e-3, rel=1e-6)
    assert found.teeth == pytest.approx(FAR / spacing, rel=0.2, abs=3)
    assert found.rising_share > 0.75


def test_a_known_saw_exactly() -> None:
    u, force = teeth(rows=60001, spacing=3e-3, swing=0.3, uneven=0.0, fall=0.02)
    found = find_saw_teeth(u, force).teeth
    assert found is not None and found.period is None
    assert found.upper == pytest.approx(0.75, abs=2e-3)
    assert found.lower == pytest.approx(0.45, abs=2e-3)
    assert found.spacing == pytest.approx(3e-3, rel=1e-2)
    assert found.rising_share == pytest.approx(0.98, abs=2e-3)
    assert found.amplitude == pytest.approx(0.15, abs=1e-3)
    assert found.middle == pytest.approx(0.6, abs=1e-3)
    assert found.irregularity < 0.01


def test_small_teeth_under_the_noise_of_a_sample_are_found() -> None:
    """A swing of 2 standard deviations, where 600 samples make a tooth."""
    u, force = teeth(rows=24000, spacing=1.5e-3, swing=0.06, noise=0.03, uneven=0.02, fall=0.02)
    found = find_saw_teeth(u, force).teeth
    assert found is not None
    assert found.spacing == pytest.approx(1.5e-3, rel=0.1)
    assert found.amplitude == pytest.approx(0.03, rel=0.25)


def _rough(rng: np.random.Generator, seed: int) -> tuple[np.ndarray, np.ndarray]:
    machine = virtual.Machine(
        sampling_rate=float(rng.choice([20, 100, 1000])), seed=seed, load_cell_range=10.0,
        load_cell_noise=10 ** rng.uniform(-4, -1.7),
    )  # fmt: skip
    texture = 10 ** rng.uniform(-2.3, -0.7)
    trace = virtual.friction(0.32, 0.24, 2.45, machine=machine, texture=texture)
    inside = trace.elongation > 0.04
    return trace.elongation[inside], trace.force[inside]


def _innocent(seed: int) -> tuple[str, np.ndarray, np.ndarray]:
    """White and coloured noise, a walk, a rough film, a vibration; no stick-slip."""
    rng = np.random.default_rng(seed)
    rows = int(rng.integers(300, 8000))
    u, white = np.linspace(0, FAR, rows), rng.standard_normal(rows)
    kind = ("white", "coloured", "walk", "rough", "vibration")[seed % 5]
    if kind == "rough":
        return kind, *_rough(rng, seed)
    if kind == "white":
        return kind, u, 0.6 + 10 ** rng.uniform(-4, -1) * white
    if kind == "coloured":
        noise = lfilter([1.0], [1.0, -rng.uniform(0.5, 0.995)], white)
        return kind, u, 0.6 + 0.05 * noise / noise.std()
    if kind == "walk":
        walk = np.cumsum(white)
        return kind, u, 0.6 + 0.1 * walk / np.abs(walk).max()
    wave = np.sin(2 * np.pi * rng.uniform(4, 40) * u / FAR + rng.uniform(0, 6))
    return kind, u, 0.6 + 0.1 * wave + 10 ** rng.uniform(-4, -1.5) * white


@pytest.mark.slow
def test_nothing_else_passes_for_stick_slip() -> None:
    """500 records without it: at most 2 are taken for it."""
    wrong = []
    for seed in range(500):
        kind, u, force = _innocent(seed)
        if find_saw_teeth(u, force).teeth is not None:
            wrong.append(f"{kind} {seed}")
    assert len(wrong) <= 2, wrong


def test_reasons_say_what_was_missing() -> None:
    u = np.linspace(0, FAR, 4000)
    wave = find_saw_teeth(u, 0.6 + 0.1 * np.sin(2 * np.pi * u / 3e-3))
    assert wave.teeth is None and "a vibration or a rough film" in wave.reason
    assert "no swing exceeds the noise" in find_saw_teeth(u, np.full(4000, 0.6)).reason
    assert "too small to matter" in find_saw_teeth(*teeth(swing=0.008)).reason
    assert "only 5 samples" in find_saw_teeth(u[:5], u[:5]).reason
    few = find_saw_teeth(*teeth(spacing=0.04, swing=0.05))
    assert few.teeth is None


def equal_teeth(count: int, samples: int, swing: float, middle: float = 0.6) -> np.ndarray:
    """Force of `count` equal teeth of `samples` samples, the fall in the last of them."""
    return middle + swing * (np.arange(count * samples) % samples / (samples - 1) - 0.5)


def test_five_small_teeth_are_enough_and_four_are_not() -> None:
    """A swing of 3 % of the force; the record begins and ends within a tooth."""
    for count in (4, 5):
        force = equal_teeth(count + 2, 40, swing=0.018)[20:-10]
        found, reason = find_saw_teeth(np.arange(len(force)) * 1e-4, force)
        assert (found is not None) == (count == 5), reason
        assert found is None or found.teeth == 5


def test_both_ends_of_equal_teeth_are_known_to_a_quarter_of_the_rise_per_sample() -> None:
    """The ends do not scatter; half a sample's rise to either side counts as two standard errors.

    20 samples make a tooth of 0.2 N, hence 10 mN per sample.
    """
    force = equal_teeth(12, 20, swing=0.2)
    found = find_saw_teeth(np.arange(len(force)) * 1e-4, force).teeth
    assert found is not None
    assert (found.upper_se, found.lower_se) == pytest.approx((0.01 / 4, 0.01 / 4), rel=1e-6)


def test_a_swing_is_not_reported_if_the_smoothing_that_shows_it_shrinks_it() -> None:
    """A swing of 6 standard deviations shows only in means of 5 samples, as a third less if 16
    samples make a tooth."""
    for samples, is_reported in ((16, False), (30, True)):
        force = equal_teeth(200, samples, swing=0.2)
        force = force + 0.2 / 6 * np.random.default_rng(0).standard_normal(len(force))
        found, reason = find_saw_teeth(np.arange(len(force)) * 1e-4, force)
        assert (found is not None) == is_reported, reason
        assert found is None or found.swing == pytest.approx(0.2, rel=0.05)


def test_long_records_are_thinned_and_keep_their_indices() -> None:
    u, force = teeth(rows=200_000, spacing=3e-3, swing=0.3, uneven=0.0)
    found = find_saw_teeth(u, force).teeth
    assert found is not None and found.peaks.max() > 150_000
    assert force[found.peaks].min() > 0.7 and force[found.troughs].max() < 0.5
