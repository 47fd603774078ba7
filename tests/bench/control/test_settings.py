"""What a regulator refuses, in one sentence each."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.control.loops import AIR, IDEAL, NOISY, WATER, regulator
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.settings import FAULTS, Regulator, validate
from layerjam.brake.device.mount import Site
from layerjam.brake.fluid.line import Chamber, Leak, Line, Pump, Sensor, Valve
from layerjam.core.errors import QuantityError


def test_a_safe_state_must_be_declared() -> None:
    """There is no default, and the sentence names both."""
    with pytest.raises(QuantityError, match="required") as told:
        Regulator(plant=AIR, sensor=NOISY)
    assert "'release'" in str(told.value)
    assert "'hold'" in str(told.value)
    with pytest.raises(QuantityError, match="'open' is not allowed"):
        regulator(safe_state="open")
    with pytest.raises(QuantityError, match="kind: 'pid' is not allowed"):
        regulator(kind="pid")


@pytest.mark.parametrize(
    ("changes", "target", "said"),
    [
        ({}, 101e3, "target: 101 kPa is not allowed; the pump reaches 100.9 kPa against its leak"),
        ({"plant": dataclasses.replace(AIR, leak=0.0)}, 102e3, "the pump reaches 101.3 kPa, and"),
        ({"plant": WATER}, 99e3, "the pump reaches 98 kPa"),
        ({}, -1.0, "target: -1 Pa is not allowed"),
        ({}, float("nan"), "target: nan"),
        ({"sample_time": 0.5}, 60e3, "sample_time: 0.5 s is not allowed; the line's time"),
        ({"sensor": dataclasses.replace(NOISY, range=60e3)}, 60e3, "sensor.range: 60 kPa is not"),
        ({"reversible": True}, 60e3, "reversible: the plant's pump cannot run backwards"),
        ({"kind": "bang-bang", "hysteresis": 300.0}, 60e3, "hysteresis: 0.3 kPa is too small"),
        (
            {
                "kind": "bang-bang",
                "hysteresis": 2e4,
                "sensor": dataclasses.replace(NOISY, range=12e4),
            },
            95e3,
            "hysteresis: 20 kPa is not allowed",
        ),
        ({"decision_step": 500.0}, 60e3, "decision_step: 0.5 kPa is too small for a sensor"),
        ({"offset_limit": 100.0}, 60e3, "offset_limit: 0.1 kPa is too small"),
        ({"lost_band": 200.0}, 60e3, "lost_band: .* is too small"),
        ({"vent_band": 200.0}, 60e3, "vent_band: .* is too small"),
        ({"floor": -10.0}, 60e3, "floor: 10 Pa is too small"),
        ({"no_vacuum_ratio": 0.7}, 60e3, "no_vacuum_ratio: 0.7 is not allowed"),
        ({"weak_ratio": 2.0}, 60e3, "weak_ratio: 2 is not allowed"),
    ],
)
def test_each_is_refused_with_a_sentence(changes: dict[str, Any], target: float, said: str) -> None:
    with pytest.raises(QuantityError, match=said) as told:
        validate(regulator(**changes), target)
    assert "\n" not in str(told.value)


@given(
    st.floats(0.05, 5), st.floats(0, 0.01), st.floats(0, 200), st.floats(0, 100),
    st.floats(0, 0.05), st.sampled_from(["bang-bang", "pi", "scheduled"]), st.booleans(),
)  # fmt: skip
def test_what_is_left_out_is_worked_out_so_that_it_passes(
    rate: float, leak: float, noise: float, step: float, lag: float, kind: str, water: bool
) -> None:
    plant = Plant(rate=rate, top=1e5, leak=leak, vent=5.0, water=water)
    sensor = Sensor(range=12e4, noise=noise, resolution=step, lag=lag)
    loop = regulator(plant=plant, sensor=sensor, kind=kind, sample_time=min(0.01, 0.09 / rate))
    validate(loop, 0.5 * plant.reach)
    assert set(detection_times(loop, 0.5 * plant.reach)) == set(FAULTS.values()) - {"HEALTHY"}


def test_detection_times_go_with_the_settings() -> None:
    loop = regulator()
    times = detection_times(loop, 60e3)
    slower = detection_times(regulator(lost_time=3.0, stuck_time=2.0, confirm=10), 60e3)
    assert slower["VACUUM_LOST"] - times["VACUUM_LOST"] == pytest.approx(2.0)
    assert slower["SENSOR_STUCK"] - times["SENSOR_STUCK"] == pytest.approx(1.0)
    assert slower["SENSOR_OUT_OF_RANGE"] - times["SENSOR_OUT_OF_RANGE"] == pytest.approx(0.07)
    leaky = regulator(plant=dataclasses.replace(AIR, leak=0.3))
    assert detection_times(leaky, 55e3)["NO_VACUUM"] == float("inf")


def test_a_plant_comes_from_a_fluid_line() -> None:
    """The paper's line: Q = 3.33 mL/s, V = 7.503 mL; and its leak right at the vacuum named."""
    line = Line(
        chamber=Chamber(volume=7.503e-6, compliance=0.06607e-9),
        pump=Pump(flow=1.665e-6, count=2), valve=Valve(conductance=1e-9),
        leak=Leak(laminar=1e-9), site=Site(),
    )  # fmt: skip
    made = linearise_line(line, vacuum=60e3)
    atmosphere = line.site.atmosphere
    assert made.rate == pytest.approx(3.33 / 7.503)
    assert made.top == atmosphere
    p = atmosphere - 60e3
    leak = 1e-9 * (atmosphere**2 - p**2) / (2 * atmosphere) / 7.503e-6
    assert made.leak * 60e3 == pytest.approx(leak)
    wet = linearise_line(line, vacuum=60e3, water=True)
    assert wet.rate * wet.top == pytest.approx(3.33e-6 / 0.06607e-9)
    shut = dataclasses.replace(line, valve=None)
    with pytest.raises(QuantityError, match="nothing can release"):
        linearise_line(shut, vacuum=60e3)
    dry = dataclasses.replace(line, chamber=Chamber(volume=7.503e-6))
    with pytest.raises(QuantityError, match=r"chamber\.compliance: not given"):
        linearise_line(dry, vacuum=60e3, water=True)


def test_ideal_sensors_need_no_margin() -> None:
    validate(regulator(sensor=IDEAL, kind="bang-bang", hysteresis=10.0), 60e3)
