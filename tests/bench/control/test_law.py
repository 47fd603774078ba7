"""The law by itself: what it answers, and the same bits wherever it runs."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import math
import random
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.control.in_c import step as compiled
from bench.control.loops import AIR, COARSE, IDEAL, NOISY, WATER, regulator
from layerjam.bench.control import law
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS, LawSettings, Regulator
from layerjam.brake.fluid.line import Sensor


def bits(answer: Any) -> bytes:
    """All numbers of an answer as packed doubles: equal only if equal bit for bit."""
    (drive, seen), pump, vent, fault = answer
    assert isinstance(vent, int)
    assert isinstance(fault, int)
    return struct.pack(f"<{len(drive) + len(seen) + 3}d", *drive, *seen, pump, vent, fault)


numbers = st.one_of(
    st.floats(-1e4, 1.1e5), st.floats(0, 9e4).map(round).map(float), st.floats(),
    st.sampled_from([0.0, -0.0, math.nan, math.inf, -math.inf, 5e-324, 103e3, 60e3]),
)  # fmt: skip


def _made(kind: str, plant: Plant, sensor: Sensor, safe: str, on: float, back: bool) -> Regulator:
    turning = dataclasses.replace(plant, backwards=4e4 * back)
    return regulator(
        kind=kind, plant=turning, sensor=sensor, safe_state=safe, minimum_on=on, minimum_off=on,
        minimum_vent=on, reversible=back,
    )  # fmt: skip


choices = st.builds(
    _made,
    st.sampled_from(list(KINDS)),
    st.sampled_from([AIR, WATER]),
    st.sampled_from([NOISY, COARSE, IDEAL]),
    st.sampled_from(["release", "hold"]),
    st.sampled_from([0.0, 0.05]),
    st.booleans(),
)


@given(choices, st.lists(st.tuples(numbers, numbers), max_size=80))
def test_compiled_and_plain_agree_bit_for_bit(
    loop: Regulator, samples: list[tuple[float, float]]
) -> None:
    settings = loop.pack()
    plain = fast = law.fresh()
    for y, target in samples:
        one = law.step(settings, plain, y, target)
        two = compiled(settings, fast, y, target)
        assert bits(one) == bits(two)
        plain, fast = one[0], two[0]


@given(choices, st.integers(0, 2**32 - 1))
def test_compiled_and_plain_agree_along_a_walk(loop: Regulator, seed: int) -> None:
    """Readings that a healthy sensor could give, so that no fault ends the sequence early."""
    settings, draw = loop.pack(), random.Random(seed)
    plain = fast = law.fresh()
    v, pump, target = 0.0, 0.0, 60e3
    for _ in range(300):
        if draw.random() < 0.02:
            target = draw.choice([0.0, 30e3, 60e3, 80e3])
        full = loop.plant.rate * (loop.plant.top - loop.plant.weight * v) - loop.plant.leak * v
        rise = full if pump > 0 else -300.0
        v = max(v + 0.01 * rise * abs(pump) * draw.uniform(0.8, 1.2) + draw.gauss(0, 30), 0.0)
        one = law.step(settings, plain, v, target)
        two = compiled(settings, fast, v, target)
        assert bits(one) == bits(two)
        plain, fast, pump = one[0], two[0], one[1]


@given(choices, st.lists(st.tuples(numbers, numbers), max_size=40))
def test_whatever_comes_in_the_commands_are_commands(
    loop: Regulator, samples: list[tuple[float, float]]
) -> None:
    settings, state, latched = loop.pack(), law.fresh(), 0
    for y, target in samples:
        state, pump, vent, fault = law.step(settings, state, y, target)
        assert (-1.0 if loop.reversible else 0.0) <= pump <= 1.0
        assert vent in (0, 1)
        assert not latched or fault == latched
        latched = fault
        if math.isnan(y) or math.isnan(target):
            assert fault
        if fault:
            assert (pump, vent) == (0.0, int(loop.safe_state == "release"))
        assert all(math.isfinite(x) for x in state[1])
        assert all(math.isfinite(x) for x in state[0][:7])


@pytest.mark.parametrize("kind", list(KINDS))
def test_nan_is_a_fault_and_stays_one_until_the_state_is_fresh(kind: str) -> None:
    settings, state = regulator(kind=kind, safe_state="hold").pack(), law.fresh()
    state, pump, vent, fault = law.step(settings, state, 100.0, 60e3)
    assert (pump, vent, fault) == (1.0, 0, law.HEALTHY)
    state, pump, vent, fault = law.step(settings, state, math.nan, 60e3)
    assert (pump, vent, fault) == (0.0, 0, law.NOT_A_NUMBER)
    state, pump, vent, fault = law.step(settings, state, 100.0, 60e3)
    assert (pump, vent, fault) == (0.0, 0, law.NOT_A_NUMBER)
    assert law.step(settings, law.fresh(), 100.0, 60e3)[3] == law.HEALTHY


def test_the_integral_stands_still_while_the_pump_is_full() -> None:
    settings, state = regulator(sensor=IDEAL, feed_forward=False).pack(), law.fresh()
    for n in range(300):
        v = AIR.reach * -math.expm1(-(AIR.rate + AIR.leak) * 0.01 * n)
        state, pump, _vent, _fault = law.step(settings, state, v, 80e3)
        assert pump == 1.0
        assert state[0][0] == 0.0


def test_the_feed_forward_is_the_flow_for_leak_and_rise() -> None:
    """At the target, ramped: u k (top - v) = leak v + dv/dt."""
    settings, state = regulator(sensor=IDEAL, gain=1e-12, least_command=1e-6).pack(), law.fresh()
    ramp, dt = 2e3, 0.01
    for n in range(100):
        v = ramp * dt * n
        state, pump, _vent, _fault = law.step(settings, state, v, v)
    assert pump == pytest.approx((AIR.leak * v + ramp) / (AIR.rate * (AIR.top - v)), rel=1e-6)


def test_out_of_range_waits_for_its_samples_and_goes_by_the_last_good_one() -> None:
    settings, state = regulator(confirm=3).pack(), law.fresh()
    state = law.step(settings, state, 59e3, 60e3)[0]
    for n in range(2):
        state, pump, _vent, fault = law.step(settings, state, math.inf, 60e3)
        assert fault == law.HEALTHY
        assert pump > 0, n
    state, pump, _vent, fault = law.step(settings, state, 59e3, 60e3)
    assert fault == law.HEALTHY
    for _ in range(3):
        state, pump, _vent, fault = law.step(settings, state, math.inf, 60e3)
    assert fault == law.OUT_OF_RANGE


def test_a_target_of_nothing_releases() -> None:
    for kind in KINDS:
        settings = regulator(kind=kind, minimum_vent=5.0).pack()
        _state, pump, vent, fault = law.step(settings, law.fresh(), 50e3, 0.0)
        assert (pump, vent, fault) == (0.0, 1, law.HEALTHY)


def test_the_law_imports_nothing_and_its_numbers_are_short() -> None:
    """What MicroPython reads as the same double: no literal of more than 12 digits."""
    tree = ast.parse(inspect.getsource(law))
    assert not [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, float):
            assert len(repr(node.value).replace(".", "").strip("0")) <= 12


def test_the_layouts_are_those_of_the_settings() -> None:
    packed: LawSettings = regulator().pack()
    assert all(isinstance(x, float) for part in packed for x in part)
    assert [len(part) for part in packed] == [15, 24]
    assert [len(part) for part in law.fresh()] == [8, 14]
