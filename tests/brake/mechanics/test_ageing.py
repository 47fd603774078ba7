"""Static friction that grows with the logarithm of a hold: off by default, limits, gradients."""

from __future__ import annotations

import jax
import numpy as np
import pytest
from hypothesis import given

from layerjam.brake.device.brake import validate
from layerjam.brake.mechanics.ageing import aged_holding_force, aged_static
from layerjam.brake.mechanics.friction import holding_force
from layerjam.core.errors import QuantityError
from strategies import KAPTON, change, points, random_brakes, seeds

AGED = change(KAPTON, film__ageing=0.02, film__static_hold=10.0)


def test_off_unless_the_brake_says_how_it_ages() -> None:
    hold = np.array([0.0, 1e-3, 1.0, 1e6])
    assert np.asarray(aged_static(hold, KAPTON)) == pytest.approx(0.32, rel=1e-15)
    flat = np.asarray(aged_holding_force(hold, 5e4, KAPTON))
    assert (flat == float(holding_force(5e4, KAPTON))).all()


def test_by_hand() -> None:
    """0.32 after 10 s, 0.02 more for ten times that: 0.36 after 1000 s, never below 0.24."""
    found = np.asarray(aged_static(np.array([10.0, 100.0, 1000.0, 1.0, 1e-3, 1e-9, 0.0]), AGED))
    assert found == pytest.approx([0.32, 0.34, 0.36, 0.30, 0.24, 0.24, 0.24], rel=1e-12)
    weaker = change(AGED, film__ageing=-0.02)
    assert float(aged_static(1000.0, weaker)) == pytest.approx(0.28)
    assert float(aged_static(1e9, weaker)) == pytest.approx(0.24)
    assert np.isnan(float(aged_static(-1.0, AGED)))
    assert np.isnan(float(aged_holding_force(1.0, -1.0, AGED)))


@given(seeds)
def test_ten_times_the_hold_adds_the_same_each_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    brakes = random_brakes(seed, 30)
    growth, rest = rng.uniform(0.001, 0.05, 30), np.exp(rng.uniform(-3, 8, 30))
    brakes = change(brakes, film__ageing=growth, film__static_hold=rest)
    _, vacuum = points(seed, brakes)
    holds = rest * 10.0 ** np.arange(5)[:, None]
    static = np.asarray(aged_static(holds, brakes))
    assert static[0] == pytest.approx(brakes.film.static, rel=1e-12)
    assert np.diff(static, axis=0) == pytest.approx(np.broadcast_to(growth, (4, 30)), rel=1e-9)
    force = np.asarray(aged_holding_force(holds, vacuum, brakes))
    assert force / np.asarray(holding_force(vacuum, brakes)) == pytest.approx(
        static / brakes.film.static, rel=1e-12
    )


def test_the_gradient_over_the_hold() -> None:
    """B/(t ln 10); finite at no hold too."""
    with jax.enable_x64(True):
        slope = jax.grad(aged_static)
        assert float(slope(50.0, AGED)) == pytest.approx(0.02 / 50 / np.log(10), rel=1e-12)
        assert float(slope(0.0, AGED)) == 0


def test_growth_and_hold_belong_together() -> None:
    for half in ({"film__ageing": 0.02}, {"film__static_hold": 10.0}):
        with pytest.raises(QuantityError, match="together with film.static_hold"):
            validate(change(KAPTON, **half))
    validate(AGED)


def test_a_fan_amplifies_what_has_aged_by_more() -> None:
    """The mean of the sheets' tensions, with the friction that has grown."""
    brake = change(AGED, mount__spacers=False, sheets__count=41)
    alone = change(brake, mount__spacers=True)
    free, t = brake.sheets.free_left, brake.sheets.thickness
    for hold in (10.0, 1e4):
        static = brake.scale_factor / (brake.amplification_held or 1.0)
        static = static * float(aged_static(hold, brake))
        place = (np.arange(200_000) + 0.5) / 200_000
        alpha = 2 * static * t * (41 / 4) ** 2 / free
        factor = np.exp(alpha * (1 - place**2)).mean()
        plain = float(aged_holding_force(hold, 5e4, alone))
        found = float(aged_holding_force(hold, 5e4, brake))
        assert found == pytest.approx(plain * factor, rel=1e-6)
        if hold == 10.0:
            assert found == pytest.approx(float(holding_force(5e4, brake)), rel=1e-12)
    aged = found / float(holding_force(5e4, brake))
    assert aged > 1.1 * float(aged_static(1e4, brake)) / 0.32
