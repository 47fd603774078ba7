"""Vacuum for a force: the inverse of the force law, over thousands of random brakes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from layerjam.brake.mechanics.enclosure import enclosure_force, saturation_slip
from layerjam.brake.mechanics.limits import self_closing_vacuum
from layerjam.brake.mechanics.pull import (
    brake_force,
    force_limits,
    peak,
    peak_vacuum,
    slip_at_elongation,
    vacuum_for_force,
)
from strategies import KAPTON, points, random_brakes, seeds

N = 2000


@given(seed=seeds)
def test_inverse_of_force_is_the_vacuum(seed):
    brakes = random_brakes(seed, N)
    slip, vacuum = points(seed, brakes)
    vacuum[::3] *= 1e-3
    back = vacuum_for_force(brake_force(slip, vacuum, brakes), slip, brakes)
    low, _ = force_limits(slip, brakes)
    lost = 1e-15 * (1 + np.asarray(low) / np.asarray(brake_force(slip, vacuum, brakes) - low))
    assert (np.abs(np.asarray(back) / vacuum - 1) < 1e-11 + 8 * lost).all()


def test_the_random_points_cover_both_branches():
    brakes = random_brakes(0, N)
    slip, vacuum = points(0, brakes)
    whole = slip > np.asarray(saturation_slip(vacuum, brakes))
    assert 50 < whole.sum() < N - 50


@pytest.mark.parametrize("seed", range(3))
def test_force_of_the_inverse_is_the_force_with_a_pressure_exponent(seed):
    brakes = random_brakes(seed, N, exponent=True)
    slip, vacuum = points(seed, brakes)
    force = brake_force(slip, vacuum, brakes)
    back = vacuum_for_force(force, slip, brakes)
    assert np.asarray(brake_force(slip, back, brakes)) == pytest.approx(
        np.asarray(force), rel=1e-12
    )
    assert np.asarray(back) == pytest.approx(vacuum, rel=1e-9)


@given(seed=seeds)
def test_not_reachable_is_nan_and_reachable_is_not(seed):
    brakes = random_brakes(seed, N)
    slip, _ = points(seed, brakes)
    low, high = (np.asarray(v) for v in force_limits(slip, brakes))
    assert (low < high).all()
    for force in (low * (1 - 1e-9), high * (1 + 1e-9), -high):
        assert np.isnan(vacuum_for_force(force, slip, brakes)).all()
    inner = low + (high - low) * np.random.default_rng(seed).uniform(1e-3, 1 - 1e-9, N)
    vacuum = np.asarray(vacuum_for_force(inner, slip, brakes))
    assert ((vacuum > 0) & (vacuum <= brakes.site.atmosphere)).all()


def test_ends_of_the_inverse():
    assert float(vacuum_for_force(0.0, 0.0, KAPTON)) == 0.0
    onset = float(brake_force(0.0, 5e4, KAPTON))
    assert float(vacuum_for_force(onset, 0.0, KAPTON)) == pytest.approx(5e4, rel=1e-14)
    alone = float(brake_force(0.068, 5e4, KAPTON))
    assert float(vacuum_for_force(alone, 0.068, KAPTON)) == pytest.approx(5e4, rel=1e-12)
    assert np.isnan(float(vacuum_for_force(alone, 0.08, KAPTON)))
    assert np.isnan(float(vacuum_for_force(1.0, -0.01, KAPTON)))
    low = float(force_limits(0.03, KAPTON)[0])
    assert float(vacuum_for_force(low, 0.03, KAPTON)) == pytest.approx(0.0, abs=1e-9)


def test_full_vacuum_itself_is_reachable():
    """The greatest force of `force_limits` gives the atmosphere back, at every slip."""
    x = np.linspace(0, 0.067, 200)
    high = force_limits(x, KAPTON)[1]
    assert np.asarray(vacuum_for_force(high, x, KAPTON)) == pytest.approx(101325.0, rel=1e-12)


@pytest.mark.parametrize("exponent", [False, True])
def test_self_closing_vacuum_balances_friction_and_sleeve(exponent):
    brakes = random_brakes(3, N, exponent=exponent)
    slip, _ = points(3, brakes)
    vacuum = np.asarray(self_closing_vacuum(slip, brakes))
    # above the site's vacuum an exponent's law is not searched: it says "never"
    there = np.isfinite(vacuum) & (vacuum < brakes.site.atmosphere)
    assert there.sum() > N / 4
    sleeve = np.asarray(enclosure_force(slip, vacuum, brakes))[there]
    total = np.asarray(brake_force(slip, vacuum, brakes))[there]
    assert total - sleeve == pytest.approx(sleeve, rel=1e-9)


@pytest.mark.parametrize("exponent", [False, True])
def test_peak_exists_only_above_the_peak_vacuum(exponent):
    brakes = random_brakes(4, N, exponent=exponent)
    bound = np.asarray(peak_vacuum(brakes))
    far = np.full(N, 1e9)
    assert not np.asarray(peak(bound * (1 - 1e-9), far, brakes).inside).any()
    assert np.asarray(peak(bound * (1 + 1e-9), far, brakes).inside).all()


@pytest.mark.parametrize("exponent", [False, True])
def test_elongation_and_slip_agree_over_random_brakes(exponent):
    """u = x + F(x)/k put in gives x back."""
    brakes = random_brakes(5, N, exponent=exponent)
    slip, vacuum = points(5, brakes)
    force = np.asarray(brake_force(slip, vacuum, brakes))
    u = slip + force / brakes.stiffness_measured
    assert np.asarray(slip_at_elongation(u, vacuum, brakes)) == pytest.approx(slip, rel=1e-8)


def test_nothing_exceeds_the_peak():
    brakes = random_brakes(6, N)
    slip, vacuum = points(6, brakes)
    top = peak(vacuum, brakes.sheets.usable_travel, brakes)
    slip = np.minimum(slip, brakes.sheets.usable_travel)
    assert (
        np.asarray(brake_force(slip, vacuum, brakes)) <= np.asarray(top.force) * (1 + 1e-12)
    ).all()
    at = np.asarray(brake_force(top.slip, vacuum, brakes))
    assert at == pytest.approx(np.asarray(top.force), rel=1e-12)
