"""The plant between two samples in C: exact."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.special import roots_legendre

from bench.control.in_c import factors
from bench.control.loops import AIR
from layerjam.bench.control.exact import Rates


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
        Rates(rate, top, weight, leak, venting, 0.0), pump, vent, dt, lag, -math.expm1(-ratio)
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
        Rates(1.0, AIR.top, 1.0, b, 0.0, 0.0), 0.0, 0.0, dt, dt / ratio, -math.expm1(-ratio)
    )
    nodes, weights = roots_legendre(40)
    t = 0.5 * dt * (nodes + 1)
    through = 0.5 * dt * weights @ (np.exp(-b * t) * -np.expm1(-(dt - t) * ratio / dt))
    assert sensed == pytest.approx(through, abs=1e-11 * gain)
    if shift == 0.0:
        closed = (1 - math.exp(-b * dt) * (1 + b * dt)) / b
        assert sensed == pytest.approx(closed, abs=1e-11 * gain)


def test_a_pump_that_turns_back_falls_at_its_own_rate() -> None:
    plant = Rates(2.0, 1e5, 1.0, 0.5, 7.0, 4e4)
    a, b, gain, _sensed = factors(plant, -0.3, 0.0, 0.01, 0.0, 1.0)
    assert a == pytest.approx(-0.3 * 4e4)
    assert b == 0.5
    assert gain == pytest.approx(-math.expm1(-0.005) / 0.5, rel=1e-14)
