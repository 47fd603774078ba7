"""Impacts in accelerometer logs against pulses whose peak and velocity change are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.brake.simulate.accelerometer import STANDARD_GRAVITY as G
from layerjam.brake.simulate.accelerometer import cfc_filter
from layerjam.core.errors import FitError, QuantityError
from layerjam.laboratory.identify.logs.crash import head_injury_criterion, reduce_crash
from layerjam.laboratory.identify.logs.log_checks import check_crash
from layerjam.laboratory.identify.logs.sampling import find_gaps, sample_evenly


def half_sine(height, length=0.02, rate=10e3, start=0.08, end=0.2, noise=0.0, offset=0.0, seed=0):
    t = np.arange(0, end, 1 / rate)
    inside = (t >= start) & (t <= start + length)
    pulse = np.where(inside, height * np.sin(np.pi * (t - start) / length), 0.0)
    return t, pulse + offset + np.random.default_rng(seed).normal(0, noise, len(t))


@pytest.mark.parametrize("height", [50 * G, -30 * G])
def test_a_half_sine_gives_its_peak_and_its_area(height):
    t, a = half_sine(height, offset=3.0)
    found = reduce_crash(t, a, cfc=1000)
    assert found.offset == pytest.approx(3.0)
    assert found.peak == pytest.approx(height, rel=1e-4)
    assert found.filtered_peak == pytest.approx(height, rel=2e-3)
    assert found.velocity_change == pytest.approx(height * 2 * 0.02 / np.pi, rel=2e-3)
    length = 0.02 * (1 - 2 * np.arcsin(0.05) / np.pi)  # over 5 %
    assert found.pulse[1] - found.pulse[0] == pytest.approx(length,
                                                            abs=3e-4)  # fmt: skip
    assert not found.saturated


def test_the_velocity_change_starts_at_zero_and_is_the_integral() -> None:
    """Half a sine of height h and length L: h L/pi (1 - cos(pi (t - start)/L))."""
    t, a = half_sine(50 * G)
    velocity = reduce_crash(t, a).velocity()
    phase = np.clip((t - 0.08) / 0.02, 0, 1)
    half = np.pi / 200 / 2  # of a step of the phase: trapezia under a sine are short by x/tan x
    due = 50 * G * 0.02 / np.pi * (1 - np.cos(np.pi * phase)) * half / np.tan(half)
    assert velocity[0] == 0.0
    np.testing.assert_allclose(velocity, due, rtol=0, atol=1e-11)


def test_the_standard_error_of_the_velocity_change_is_its_scatter():
    due = 50 * G * 2 * 0.02 / np.pi
    off = []
    for seed in range(60):
        found = reduce_crash(*half_sine(50 * G, noise=2.0, offset=1.0, seed=seed))
        off.append((found.velocity_change - due) / found.velocity_change_se)
    assert abs(np.mean(off)) < 0.5
    assert 0.7 < np.std(off) < 1.4


def test_the_filter_is_the_one_of_the_standard():
    t, a = half_sine(40 * G, length=0.004)
    found = reduce_crash(t, a, cfc=180)
    np.testing.assert_array_equal(
        found.filtered, cfc_filter(found.acceleration, found.sampling, 180)
    )
    assert abs(found.filtered_peak) < abs(found.peak)
    assert reduce_crash(t, a, cfc=None).filtered_peak == found.peak


@settings(max_examples=25, deadline=None)
@given(scale=st.floats(0.01, 100), shift=st.floats(-1e3, 1e3))
def test_scales_with_the_signal_and_not_with_the_clock(scale, shift):
    t, a = half_sine(20 * G, noise=0.5)
    one, other = reduce_crash(t, a), reduce_crash(t + shift, a * scale)
    assert other.filtered_peak == pytest.approx(one.filtered_peak * scale, rel=1e-6)
    assert other.velocity_change == pytest.approx(one.velocity_change * scale, rel=1e-5)
    assert other.peak_time - shift == pytest.approx(one.peak_time, abs=1e-6)


def test_a_stop_that_began_in_free_fall():
    """Mass at 2 m/s stopped by a constant 10 g along gravity: specific force 10 g, 2 m/s lost."""
    t = np.arange(0, 0.3, 1e-4)
    length = 2.0 / (9 * G)
    a = np.where((t > 0.1) & (t < 0.1 + length), 10 * G, 0.0)
    resting = reduce_crash(t, a, cfc=1000)
    falling = reduce_crash(t, a, cfc=1000, falling=True)
    assert resting.velocity_change == pytest.approx(10 * G * length, rel=0.01)
    assert falling.velocity_change == pytest.approx(2.0, rel=0.02)


def test_saturation_is_recognised():
    t, a = half_sine(60 * G, noise=0.1)
    cut = reduce_crash(t, np.clip(a, -50 * G, 50 * G))
    assert cut.saturated and cut.saturation == pytest.approx(50 * G)
    first = next(check_crash(cut))
    assert first.level == "failed" and "lower bounds" in first.sentence
    assert not reduce_crash(t, a).saturated
    assert reduce_crash(t, a, limit=59.9 * G).saturated


def test_hic_of_a_block_and_its_limit_window():
    rate = 10e3
    block = np.where((np.arange(2000) >= 500) & (np.arange(2000) < 600), 100 * G, 0.0)
    value, (first, last) = head_injury_criterion(block, rate, 0.015)
    assert value == pytest.approx(0.0099 * 100**2.5, rel=0.02)
    assert last - first == pytest.approx(99, abs=2)
    short, _ = head_injury_criterion(block, rate, 0.005)
    assert short == pytest.approx(0.005 * 100**2.5, rel=1e-6)


def test_gravity_along_another_axis_afterwards_is_said():
    t, a = half_sine(30 * G, noise=0.2)
    assert any(
        "after the event" in w for w in reduce_crash(t, a + np.where(t > 0.1, G, 0.0)).warnings
    )
    assert not any("after the event" in w for w in reduce_crash(t, a).warnings)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_the_rate_is_checked(noise):
    t, a = half_sine(30 * G)
    uneven = t + np.random.default_rng(1).uniform(-noise, noise, len(t)) * 1e-4
    assert reduce_crash(np.sort(uneven), a).sampling == pytest.approx(10e3, rel=1e-3)
    with pytest.raises(FitError, match="too slow for CFC 180"):
        reduce_crash(t[::10], a[::10])
    assert reduce_crash(t[::10], a[::10], cfc=60).sampling == pytest.approx(1e3)
    with pytest.raises(QuantityError, match="not an SAE J211-1 class"):
        reduce_crash(t, a, cfc=100)


def test_stamps_of_whole_milliseconds_are_even():
    t = np.arange(200) / 3000.0
    found = sample_evenly(np.round(t, 3), t)
    assert found.rate == pytest.approx(3000, rel=0.01)
    assert "rounded" in found.notes[0]


@pytest.mark.parametrize("jitter", [0.0, 0.04, 0.3])
def test_uneven_stamps_keep_peak_and_area(jitter):
    """Steps that drift and jitter; above a tenth of a step the record is resampled, and says so."""
    t, _ = half_sine(30 * G, rate=4e3)
    rng = np.random.default_rng(3)
    own = np.sort(t * 1.004 + rng.uniform(-jitter, jitter, len(t)) / 4e3)
    inside = (own >= 0.08) & (own <= 0.1)
    values = np.where(inside, 30 * G * np.sin(np.pi * (own - 0.08) / 0.02), 0.0)
    found = reduce_crash(own, values)
    assert found.peak == pytest.approx(30 * G, rel=3e-3)
    assert found.peak_time == pytest.approx(0.09, abs=4e-4)
    assert found.velocity_change == pytest.approx(30 * G * 2 * 0.02 / np.pi, rel=5e-3)
    assert any("resampled" in note for note in found.warnings) == (jitter > 0.1)


@pytest.mark.parametrize("rate", [1e4, 3e3])
@pytest.mark.parametrize(("first", "count"), [(900, 10), (850, 1), (400, 20), (700, 0)])
def test_missing_samples_are_found_and_judged_where_they_are(rate, first, count):
    t, a = half_sine(30 * G, noise=0.1)
    keep = np.ones(len(t), bool)
    keep[first : first + count] = False
    if rate < 1e4:  # a clock of whole milliseconds, with several samples in each
        assert find_gaps(np.round(t, 3)) == ()
        return
    gaps = find_gaps(t[keep])
    assert sum(gap.missing for gap in gaps) == count
    found = {c.name: c for c in check_crash(reduce_crash(t[keep], a[keep]))}["gaps"]
    in_pulse = count and 0.08 <= t[first] <= 0.1
    assert found.level == ("passed" if not in_pulse else "failed" if count > 1 else "warning")


def test_without_a_quiet_part_the_offset_is_not_known():
    t, a = half_sine(30 * G, start=0.0)
    with pytest.raises(FitError, match="--before"):
        reduce_crash(t, a)
    t, a = half_sine(30 * G, offset=4.0)
    assert reduce_crash(t, a, before=0.05).offset == pytest.approx(4.0)
    with pytest.raises(FitError, match="at least 5"):
        reduce_crash(t, a, before=1e-5)
    with pytest.raises(FitError, match="20 samples"):
        reduce_crash(t[:9], a[:9])


def test_a_pulse_cut_off_is_said():
    t, a = half_sine(30 * G, end=0.09)
    checks = {c.name: c for c in check_crash(reduce_crash(t, a))}
    assert (
        checks["whole pulse"].level == "failed" and "incomplete" in checks["whole pulse"].sentence
    )


@pytest.mark.parametrize(
    ("rest", "falling", "level"),
    [
        (0.0, False, "passed"),
        (0.0, True, "passed"),
        (1.0, False, "passed"),
        (-1.0, False, "passed"),
        (0.4, False, "note"),
        (1.0, True, "warning"),
    ],
)
def test_a_sensor_at_rest_reads_nothing_or_gravity(rest: float, falling: bool, level: str) -> None:
    """The reading before the event is subtracted, so it does not change the peak."""
    t, a = half_sine(50 * G, noise=0.1, offset=rest * G)
    found = reduce_crash(t, a, falling=falling)
    assert found.peak == pytest.approx(50 * G, rel=0.01)
    [row] = [row for row in check_crash(found, falling) if row.name == "zero"]
    assert row.level == level
    if level == "warning":  # gravity over 19 of 20 ms of a half sine of 50 g
        share = 0.95 * np.pi / 2 / 50
        assert f"changes the velocity change by {share:.0%}" in row.sentence


def test_gravity_that_is_subtracted_from_a_weak_pulse_at_rest_fails() -> None:
    t, a = half_sine(8 * G, noise=0.05, offset=G)
    found = check_crash(reduce_crash(t, a, falling=True), falling=True)
    levels = {row.name: row.level for row in found}
    assert levels["zero"] == "failed"
