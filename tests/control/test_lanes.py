"""Runs side by side in vector instructions: the same bits as the law's text, the plant exact."""

from __future__ import annotations

import math
import random
import struct
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.special import roots_legendre

from control.loops import AIR, IDEAL, NOISY, regulator
from layerjam.control import closed_loop_lanes as lanes
from layerjam.control import law
from layerjam.control.noise import LANES, key_of, normal, normals
from layerjam.control.settings import KINDS, SAFE_STATES
from layerjam.fluid.line import Sensor

STATE = sum(len(part) for part in law.fresh())
SPAN = STATE * LANES


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def start(s: Any, state: Any) -> None:
    for i in range(LANES):
        lanes._put(s, i, state)


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def regulate(s: Any, settings: Any, target: float) -> None:
    lanes._regulate(s, settings, target)


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def decays(x: Any) -> Any:
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = lanes._decay(x[i])
    return out


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def factors(plant: Any, pump: float, vent: float, dt: float, lag: float, left: float) -> Any:
    return lanes._factors(plant, pump, vent, dt, lag, left)


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("safe", list(SAFE_STATES))
@pytest.mark.parametrize("sensor", [NOISY, IDEAL])
def test_every_lane_has_the_bits_of_the_laws_own_text(kind: str, safe: str, sensor: Sensor) -> None:
    """Readings that wander, stand still, leave the range or are missing, apart in each lane."""
    loop = regulator(kind=kind, safe_state=safe, sensor=sensor, minimum_on=0.03)
    settings, draw = loop.packed(), random.Random(7)
    s = np.zeros(lanes._END)
    start(s, law.fresh())
    plain: list[Any] = [law.fresh()] * LANES
    v, pumps, target, faults = [0.0] * LANES, [0.0] * LANES, 60e3, set()
    for n in range(600):
        if draw.random() < 0.01:
            target = draw.choice([0.0, 30e3, 60e3, 80e3])
        for i in range(LANES):
            rise = loop.plant.rise_at(v[i]) if pumps[i] > 0 else -300.0
            rise *= 0.1 if i == 3 else 8.0 if i == 4 else 1.0  # a weak pump, a blocked line
            v[i] = max(v[i] + 0.01 * rise * abs(pumps[i]) + draw.gauss(0, 30), 0.0)
            y = v[i]
            if draw.random() < 2e-4:
                y = math.nan
            elif i in (5, 6) and n > 300:  # at its end, or still
                y = 2e5 if i == 5 else 59e3
            s[lanes._READING + i] = y
            plain[i], pumps[i], _vent, fault = law.step(settings, plain[i], y, target)
            faults.add(fault)
        regulate(s, settings, target)
        for i in range(LANES):
            drive, seen = plain[i]
            wanted = struct.pack(f"<{STATE}d", *drive, *seen)
            assert s[:SPAN].reshape(STATE, LANES)[:, i].tobytes() == wanted, (n, i)
    assert {law.HEALTHY, law.NOT_A_NUMBER, law.OUT_OF_RANGE} < faults


def test_the_decay_is_exp_to_the_last_digits() -> None:
    x = np.concatenate([np.linspace(0, 3, 3001), np.geomspace(1e-12, 700, 3001)])
    np.testing.assert_allclose(decays(x), np.exp(-x), rtol=5e-16)
    assert (decays(np.array([701.0, 1e6, math.inf])) < 1e-303).all()


@given(
    pump=st.one_of(st.just(0.0), st.floats(0.02, 1)), vent=st.sampled_from([0.0, 1.0]),
    rate=st.floats(0.01, 100), leak=st.one_of(st.just(0.0), st.floats(1e-6, 10)),
    venting=st.floats(0.1, 1000), dt=st.floats(1e-4, 0.05), ratio=st.floats(1e-4, 40),
    water=st.booleans(),
)  # fmt: skip
def test_a_sample_is_the_integral_of_its_slope(
    pump: float, vent: float, rate: float, leak: float, venting: float, dt: float, ratio: float,
    water: bool,
) -> None:  # fmt: skip
    """The slope decays as exp(-b t); the sensor sees it through exp(-(dt - t)/lag)."""
    top, weight, lag = 101325.0, 0.0 if water else 1.0, dt / ratio
    a, b, gain, sensed = factors(
        (rate, top, weight, leak, venting, 0.0), pump, vent, dt, lag, -math.expm1(-ratio)
    )
    assert a == pytest.approx(rate * pump * top, rel=1e-14)
    assert b == pytest.approx(leak + rate * pump * weight + venting * vent, rel=1e-14)
    assume(b * dt < 60)
    nodes, weights = roots_legendre(80)
    t = 0.5 * dt * (nodes + 1)
    whole = 0.5 * dt * weights @ np.exp(-b * t)
    through = 0.5 * dt * weights @ (np.exp(-b * t) * -np.expm1(-(dt - t) / lag))
    assert gain == pytest.approx(whole, rel=1e-12)
    assert sensed == pytest.approx(through, abs=1e-11 * gain)


@pytest.mark.parametrize("shift", [0.0, 1e-12, -1e-7, 9.9e-4, -9.9e-4, 1.01e-3, -1.01e-3, 0.05])
def test_the_factors_where_the_rates_meet(shift: float) -> None:
    """Around b = 1/lag, a removable singularity: sensed = (1 - exp(-x) (1 + x))/b there."""
    dt, b = 0.01, 12.0
    ratio = b * dt + shift
    _a, _b, gain, sensed = factors(
        (1.0, AIR.top, 1.0, b, 0.0, 0.0), 0.0, 0.0, dt, dt / ratio, -math.expm1(-ratio)
    )
    nodes, weights = roots_legendre(40)
    t = 0.5 * dt * (nodes + 1)
    through = 0.5 * dt * weights @ (np.exp(-b * t) * -np.expm1(-(dt - t) * ratio / dt))
    assert sensed == pytest.approx(through, abs=1e-11 * gain)
    if shift == 0.0:
        closed = (1 - math.exp(-b * dt) * (1 + b * dt)) / b
        assert sensed == pytest.approx(closed, abs=1e-11 * gain)


def test_a_pump_that_turns_back_falls_at_its_own_rate() -> None:
    a, b, gain, _sensed = factors((2.0, 1e5, 1.0, 0.5, 7.0, 4e4), -0.3, 0.0, 0.01, 0.0, 1.0)
    assert a == pytest.approx(-0.3 * 4e4)
    assert b == 0.5
    assert gain == pytest.approx(-math.expm1(-0.005) / 0.5, rel=1e-14)


@numba.njit  # type: ignore[untyped-decorator]
def both(seed: int, count: int) -> Any:
    """Numbers of LANES streams drawn together and one by one."""
    keys, out = np.zeros(LANES, np.uint64), np.zeros(2 * LANES)
    together, single = np.zeros((count, LANES)), np.zeros((count, LANES))
    for i in range(LANES):
        keys[i] = key_of(seed, i)
    for n in range(count):
        normals(keys, n, out, 0, LANES)
        together[n] = out[:LANES]
        for i in range(LANES):
            single[n, i] = normal(keys[i], n)
    return together, single


def test_noise_drawn_together_is_the_noise_of_each_stream() -> None:
    together, single = both(4, 20_000)
    np.testing.assert_array_equal(together, single)
    assert np.abs(single).max() > 3.7  # the tail was reached
