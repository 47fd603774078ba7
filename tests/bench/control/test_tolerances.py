"""Healthy lines within the stated tolerances cause no fault; faults of such lines are detected."""

from __future__ import annotations

import dataclasses
import itertools
import random

import numpy as np
import pytest

from bench.control.loops import AIR, NOISY, regulator
from counts import cases
from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS, Regulator, validate
from layerjam.bench.control.tolerances import Tolerances
from layerjam.brake.fluid.line import Sensor
from layerjam.core.errors import QuantityError

SPAN = NOISY.range
PATH = [(12.0, 60e3), (4.0, 30e3), (6.0, 0.0), (8.0, 10e3), (4.0, 0.0), (12.0, 85e3), (6.0, 0.0)]
"""Rises, a release half way, and whole releases."""
ATTACKS = {
    "vent at 0.7 of the model": (dataclasses.replace(AIR, vent=0.7 * AIR.vent), NOISY),
    "lag of 50 ms": (AIR, dataclasses.replace(NOISY, lag=0.05)),
    "zero at 1 kPa": (AIR, dataclasses.replace(NOISY, offset=1e3)),
    "zero at -1 % of span": (AIR, dataclasses.replace(NOISY, offset=-0.01 * SPAN)),
    "noise of 4 times the stated": (AIR, dataclasses.replace(NOISY, noise=4 * NOISY.noise)),
    "pump at 0.8": (dataclasses.replace(AIR, rate=0.8 * AIR.rate), NOISY),
    "pump at 1.2 without leak": (dataclasses.replace(AIR, rate=1.2 * AIR.rate, leak=0.0), NOISY),
}


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("attack", list(ATTACKS))
def test_twelve_healthy_runs_without_a_false_fault(attack: str, kind: str) -> None:
    plant, sensor = ATTACKS[attack]
    made = simulate_runs(regulator(kind=kind), PATH, runs=12, plant=plant, sensor=sensor, seed=4)
    assert (made.fault == 0).all(), np.unique(made.fault)


def corners() -> list[tuple[Plant, Sensor]]:
    """Every combination of the ends of the tolerances."""
    made = []
    for pump, vent, zero, lag, noise in itertools.product(
        (0.8, 1.2), (0.7, 1.3), (-0.01, 0.01), (0.0, 0.05), (1.0, 4.0)
    ):
        plant = dataclasses.replace(AIR, rate=pump * AIR.rate, vent=vent * AIR.vent)
        sensor = dataclasses.replace(NOISY, offset=zero * SPAN, lag=lag, noise=noise * NOISY.noise)
        made.append((plant, sensor))
    return made


@pytest.mark.parametrize("kind", list(KINDS))
def test_all_tolerances_at_once(kind: str) -> None:
    for seed, (plant, sensor) in enumerate(corners()):
        made = simulate_run(regulator(kind=kind), PATH, plant=plant, sensor=sensor, seed=seed)
        assert made.outcome == "HEALTHY", (plant, sensor, made.fault_time)


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(KINDS))
def test_random_lines_within_the_tolerances_for_hours(kind: str) -> None:
    """Ten hours of each line; the leak is the declared one or less."""
    draw = random.Random(kind)
    for seed in range(cases(200, 25)):
        plant = dataclasses.replace(
            AIR,
            rate=AIR.rate * draw.uniform(0.8, 1.2),
            vent=AIR.vent * draw.uniform(0.7, 1.3),
            leak=AIR.leak * draw.random(),
        )
        sensor = dataclasses.replace(
            NOISY,
            offset=SPAN * draw.uniform(-0.01, 0.01),
            lag=draw.uniform(0.0, 0.05),
            noise=NOISY.noise * draw.uniform(1.0, 4.0),
        )
        made = simulate_runs(
            regulator(kind=kind), PATH, runs=10, duration=3600.0, plant=plant, sensor=sensor,
            seed=seed,
        )  # fmt: skip
        assert (made.fault == 0).all(), (plant, sensor, made.fault)


BROKEN = {
    "NO_VACUUM": FaultInjection(pump=0.0),
    "WEAK_PUMP": FaultInjection(pump=0.25),
    "LINE_BLOCKED": FaultInjection(volume=1 / 8),
}
NAMES = {"NO_VACUUM": {"NO_VACUUM", "WEAK_PUMP"}, "WEAK_PUMP": {"WEAK_PUMP", "NO_VACUUM"}}


@pytest.mark.parametrize("name", list(BROKEN))
def test_each_promise_is_kept_at_every_corner(name: str) -> None:
    """The fault begins at 5 to 30 kPa of a rise to 80 kPa, so that the pump runs full."""
    loop = regulator(kind="bang-bang")
    for seed, (plant, sensor) in enumerate(corners()):
        at = (0.12, 0.3, 0.6)[seed % 3]
        reached = float(plant.top * -np.expm1(-plant.rate * at))
        promised = detection_times(loop, reached + 5e3 + loop.zero_error)[name]
        made = simulate_run(
            loop, [(20.0, 90e3)], plant=plant, sensor=sensor, seed=seed,
            injected=dataclasses.replace(BROKEN[name], at=at),
        )  # fmt: skip
        assert made.outcome in NAMES.get(name, {name}), (plant, sensor, made.outcome)
        assert made.fault_time - at <= promised + 1e-9, (plant, sensor)


def test_what_a_wider_tolerance_costs_is_in_the_detection_times() -> None:
    exact = Tolerances(pump=0.0, vent=0.0, zero=0.0, lag=0.0, noise=1.0)
    narrow = detection_times(regulator(tolerances=exact), 60e3)
    wide = detection_times(regulator(), 60e3)
    for name in ("NO_VACUUM", "WEAK_PUMP", "LINE_BLOCKED", "SENSOR_OFFSET", "VACUUM_LOST"):
        assert wide[name] > narrow[name], name


def test_limits_leave_room_for_the_sensors_zero_and_noise() -> None:
    loop = regulator()
    assert loop.largest_zero >= 0.01 * SPAN + 5 * 4 * NOISY.noise
    for changes in ({"offset_limit": 1.5e3}, {"floor": -1.5e3}):
        with pytest.raises(
            QuantityError, match="and a zero error of up to 1.03 kPa; at least 2.055 kPa"
        ):
            validate(regulator(**changes), 60e3)
    with pytest.raises(QuantityError, match="tolerances.pump: 0.7 is not allowed"):
        validate(regulator(tolerances=Tolerances(pump=0.7)), 60e3)


def bend(vacuum: float, right_at: float) -> float:
    """Flow through an orifice (ISO 6358, b = 0.528) over a linear one that is right at a vacuum."""

    def passed(v: float) -> float:
        x = max((1 - v / 101325 - 0.528) / 0.472, 0.0)
        return (1 - x * x) ** 0.5 / v

    return passed(vacuum) / passed(right_at)


@pytest.mark.parametrize("target", [8e3, 20e3, 60e3])
def test_a_hold_against_a_leaking_orifice_is_no_weak_pump(target: float) -> None:
    """An orifice that leaks as stated at 60 kPa leaks 2.7 times as much at 8 kPa."""
    loop = regulator(kind="pi")
    leak = AIR.leak * bend(target, 60e3)
    plant = dataclasses.replace(AIR, rate=0.8 * AIR.rate, leak=leak)
    sensor = dataclasses.replace(NOISY, offset=-0.01 * SPAN)
    made = simulate_run(loop, [(600.0, target)], plant=plant, sensor=sensor)
    assert made.outcome == "HEALTHY", made.fault_time


def test_the_tolerances_are_those_of_the_page() -> None:
    made = Tolerances()
    assert isinstance(regulator(), Regulator) and regulator().tolerances == made
    assert (made.pump, made.vent, made.zero, made.lag, made.noise) == (0.2, 0.3, 0.01, 0.05, 4.0)
