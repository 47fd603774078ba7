"""A mass on a damped rope alone: every regime against SciPy, limits, and where it never stands."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.simulate.rope_alone import (
    simulate_bare_drop,
    simulate_damped_rope,
    standstill_time,
)

G, ROPE = 9.80665, 16.8e3
CRITICAL = 2 * np.sqrt(ROPE)


def marched(speed, damping, gravity, until):
    run = solve_ivp(
        lambda _, y: [y[1], gravity - ROPE * y[0] - damping * y[1], damping * y[1] ** 2],
        (0, until), [0, speed, 0], rtol=1e-10, atol=1e-13, method="Radau", dense_output=True,
    )  # fmt: skip
    return run.sol(np.linspace(0, until, 20001))


@pytest.mark.parametrize("gravity", [0.0, G])
@pytest.mark.parametrize("share", [1e-3, 0.3, 0.999, 1.0, 1.001, 3.0, 20.0])
def test_force_time_and_heat_in_every_regime(share, gravity):
    damping = share * CRITICAL
    force, time, heat = simulate_damped_rope(1.0, 2.5, ROPE, damping, gravity)
    until = time if np.isfinite(time) else 30 * damping / ROPE
    place, pace, warm = marched(2.5, damping, gravity, until)
    assert (pace[:-1] > -1e-9).all()
    assert force == pytest.approx((ROPE * place + damping * pace).max(), rel=1e-6)
    assert heat == pytest.approx(warm[-1], rel=1e-9)
    assert pace[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_slow_mass_on_an_overdamped_rope_never_stands_still():
    force, time, heat = simulate_damped_rope(1.0, 2.5, ROPE, 5000.0, G)
    assert np.isinf(time)
    assert force == pytest.approx(5000.0 * 2.5)
    # all it brought: energy of motion, and half of what its weight does over the sag
    assert heat == pytest.approx(2.5**2 / 2 + G**2 / ROPE / 2, rel=1e-14)
    edge = G / (2500 - np.sqrt(2500**2 - ROPE))
    assert np.isinf(standstill_time(1.0, edge * (1 - 1e-9), ROPE, 5000.0, G))
    assert np.isfinite(standstill_time(1.0, edge * (1 + 1e-9), ROPE, 5000.0, G))
    assert np.isfinite(standstill_time(1.0, 1e-6, ROPE, 5000.0, 0.0))


def test_regimes_join_and_no_damping_is_the_spring():
    near = [simulate_damped_rope(1.0, 2.5, ROPE, CRITICAL * (1 + d), G) for d in (-1e-9, 0, 1e-9)]
    np.testing.assert_allclose(near[0], near[1], rtol=1e-7)
    np.testing.assert_allclose(near[2], near[1], rtol=1e-7)
    force, time, heat = simulate_damped_rope(1.0, 2.5, ROPE, 0.0, G)
    assert force == pytest.approx(G + np.sqrt(G**2 + ROPE * 2.5**2), rel=1e-14)
    swing = np.sqrt(ROPE)
    assert time == pytest.approx(np.arctan2(2.5 * swing, -G) / swing, rel=1e-14)
    assert heat == 0.0


@pytest.mark.parametrize("damping", [0.0, 30.0, CRITICAL, 5000.0])
def test_what_is_felt_has_the_peak_and_ends_slack_or_at_the_weight(damping):
    bare = simulate_bare_drop(1.0, 2.5, ROPE, damping, G, G)
    force, _, _ = simulate_damped_rope(1.0, 2.5, ROPE, damping, G)
    assert bare.acceleration.max() == pytest.approx(force, rel=1e-5)
    assert bare.acceleration[0] == 0.0
    assert (np.diff(bare.time) > 0).all()
    last = bare.acceleration[-1]
    assert last == 0.0 or last == pytest.approx(G, rel=1e-3)
