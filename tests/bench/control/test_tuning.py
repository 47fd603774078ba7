"""Gains by the rule, and the plant from one step."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.control.loops import AIR, NOISY, WATER, regulator
from layerjam.bench.control.closed_loop import simulate_run
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.tuning import identify_air, identify_water, simc_gains
from layerjam.core.errors import FitError


def test_the_rule_is_simc() -> None:
    """Skogestad 2003, table 1: Kc = tau/(K (T_c + theta)), integral time min(tau, 4 (...))."""
    got = simc_gains(AIR, sample_time=0.01, lag=0.005, vacuum=50e3)
    theta, closed = 0.005 + 0.005, 0.05 / AIR.rate
    assert (got.dead_time, got.closed_loop_time) == pytest.approx((theta, closed))
    assert got.gain == pytest.approx(1 / (AIR.rate * (AIR.top - 50e3) * (closed + theta)))
    assert got.integral_time == pytest.approx(4 * (closed + theta))
    assert simc_gains(AIR, sample_time=0.01, lag=1.0).closed_loop_time == pytest.approx(1.005)
    slow = simc_gains(dataclasses.replace(AIR, rate=5e-5), sample_time=0.01, lag=0.0)
    assert slow.integral_time == pytest.approx(1 / AIR.leak)


@given(st.floats(0.05, 20), st.floats(0, 0.3), st.floats(0, 0.9), st.booleans())
def test_the_tuned_loop_is_stable_with_margin(
    k: float, lag: float, share: float, water: bool
) -> None:
    """Phase margin of the linear loop at the vacuum it was tuned for: above 40 degrees."""
    plant = Plant(rate=k, top=1e5, leak=0.01 * k, vent=5.0, water=water)
    dt, v = min(0.01, 0.05 / k), share * plant.reach
    gains = simc_gains(plant, sample_time=dt, lag=lag, vacuum=v)
    room = max(plant.top - plant.weight * v, 0.05 * plant.top)
    pole = plant.leak + plant.weight * plant.rate * plant.leak * v / (plant.rate * room)
    w = np.geomspace(1e-3, 1e4, 20000)
    s = 1j * w
    loop = gains.gain * (1 + 1 / (gains.integral_time * s)) * k * room / (s + pole)
    loop = loop * np.exp(-s * dt / 2) / (1 + s * lag)
    crossing = int(np.argmax(np.abs(loop) < 1))
    assert 180 + np.degrees(np.unwrap(np.angle(loop)))[crossing] > 40


@pytest.mark.parametrize("leak", [0.0, 0.05])
def test_air_is_identified_from_a_recorded_step(leak: float) -> None:
    plant = dataclasses.replace(AIR, leak=leak)
    loop = regulator(plant=plant, kind="bang-bang", sensor=NOISY)
    run = simulate_run(loop, [(20.0, 0.97 * plant.reach)], steady=0.1)
    first = int(np.argmax(run.pump < 1.0))
    got = identify_air(run.time[:first], run.measured[:first], vent=5.0, leak=leak)
    low, high = got.rate_interval
    assert low < plant.rate + leak < high
    assert high - low < 0.05 * plant.rate
    assert got.plant.rate == pytest.approx(plant.rate, rel=0.02)
    assert got.plant.reach == pytest.approx(plant.reach, rel=0.02)
    again = simulate_run(regulator(plant=got.plant), [(20.0, 60e3)], plant=plant)
    assert again.outcome == "HEALTHY"
    # without leak a pump that turns one way cannot take an overshoot back: the vent's band does
    assert abs(again.steady_error) < (200 if leak else regulator().vent_threshold)
    with pytest.raises(FitError, match="not below the step's own rate"):
        identify_air(run.time[:first], run.measured[:first], vent=5.0, leak=2.0)


def test_water_is_identified_from_a_recorded_step() -> None:
    loop = regulator(plant=WATER, kind="bang-bang", sensor=NOISY, sample_time=0.002)
    run = simulate_run(loop, [(3.0, 80e3)])
    got = identify_water(run.time, run.measured, vent=8.0, top=98e3, leak=WATER.leak)
    assert got.plant.rate == pytest.approx(WATER.rate, rel=0.01)
    assert got.rate_interval[0] < WATER.rate < got.rate_interval[1]
    with pytest.raises(FitError):
        identify_water(run.time[:8], run.measured[:8], vent=8.0, top=98e3)
