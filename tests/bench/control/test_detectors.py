"""Every fault within its stated time, and none of a healthy hour."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from bench.control.loops import AIR, COARSE, IDEAL, NOISY, WATER, regulator
from counts import cases
from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS, SAFE_STATES, Regulator
from layerjam.brake.fluid.line import Sensor

PLANTS = {"air": AIR, "water": WATER}
SENSORS = {"noisy": NOISY, "coarse": COARSE, "ideal": IDEAL}
TARGET = 80e3
ONSETS = (0.31, 0.45, 0.57)
"""During the rise, where the pump runs full."""

HALVES = ((), (pytest.mark.slow,))
"""Marks: every second loop is quick, so that any two of kind, plant and sensor meet in some."""
loops = pytest.mark.parametrize(
    "loop",
    [
        pytest.param(
            regulator(kind=kind, plant=PLANTS[plant], sensor=SENSORS[sensor]),
            id=f"{kind}-{plant}-{sensor}",
            marks=HALVES[(i + j + k) % 2],
        )
        for i, kind in enumerate(KINDS)
        for j, plant in enumerate(PLANTS)
        for k, sensor in enumerate(SENSORS)
    ],
)


def found(
    loop: Regulator, injected: FaultInjection, names: set[str], name: str, **more: object
) -> None:
    """The fault is said, under one of its names, within its time; the outputs are safe then."""
    targets = more.get("targets", [(20.0, TARGET)])
    made = simulate_run(loop, targets, injected=injected)  # type: ignore[arg-type]
    assert made.outcome in names, (made.outcome, injected)
    since = max(injected.at, float(more.get("begin", 0.0)))  # type: ignore[arg-type]
    assert made.fault_time - since <= detection_times(loop, TARGET)[name] + 1e-9
    after = made.time >= made.fault_time
    assert (made.pump[after] == 0).all()
    assert (made.vent[after] == (loop.safe_state == "release")).all()


@loops
def test_a_dead_or_weak_pump(loop: Regulator) -> None:
    for at in ONSETS:
        names = {"NO_VACUUM", "WEAK_PUMP"}
        if not loop.is_noisy:  # the vacuum stands still, and so does a stuck reading
            names.add("SENSOR_STUCK")
        found(loop, FaultInjection(at=at, pump=0.0), names, "NO_VACUUM")
        found(loop, FaultInjection(at=at, pump=0.25), {"WEAK_PUMP", "NO_VACUUM"}, "WEAK_PUMP")
    found(loop, FaultInjection(at=0.0, pump=0.0), {"NO_VACUUM"}, "NO_VACUUM")


@loops
def test_a_line_blocked_while_pumping(loop: Regulator) -> None:
    for at in (0.0, *ONSETS):
        injected = FaultInjection(at=at, volume=1 / 8)
        found(loop, injected, {"LINE_BLOCKED"}, "LINE_BLOCKED")


@loops
def test_a_vent_that_does_not_open(loop: Regulator) -> None:
    down = [(10.0, TARGET), (10.0, 0.0)]
    found(
        loop,
        FaultInjection(at=9.0, vent=1e-3),
        {"LINE_BLOCKED"},
        "SENSOR_OFFSET",
        targets=down,
        begin=10.0,
    )


@loops
def test_a_sensor_that_gives_no_number_or_one_out_of_range(loop: Regulator) -> None:
    for at in (0.0, 0.4, 12.345):
        found(loop, FaultInjection(at=at, sensor="nan"), {"NOT_A_NUMBER"}, "NOT_A_NUMBER")
        for value in (-20e3, 110e3, math.inf, -math.inf):
            injected = FaultInjection(at=at, sensor="rail", value=value)
            found(loop, injected, {"SENSOR_OUT_OF_RANGE"}, "SENSOR_OUT_OF_RANGE")


@loops
def test_a_stuck_sensor(loop: Regulator) -> None:
    for at in ONSETS:
        injected = FaultInjection(at=at, sensor="stuck")
        found(loop, injected, {"SENSOR_STUCK", "NO_VACUUM", "WEAK_PUMP"}, "SENSOR_STUCK")
    if loop.is_noisy:
        found(loop, FaultInjection(at=15.0, sensor="stuck"), {"SENSOR_STUCK"}, "SENSOR_STUCK")


@loops
def test_an_offset_when_vented(loop: Regulator) -> None:
    down = [(10.0, TARGET), (10.0, 0.0)]
    off = 2.5 * loop.largest_zero
    for sign in (1.0, -1.0):
        for at in (9.0, 15.0):
            injected = FaultInjection(at=at, sensor="offset", value=sign * off)
            names = {"SENSOR_OFFSET"}
            if at < 10:  # a jump of the reading under a running pump is found at once
                names |= {"LINE_BLOCKED", "NO_VACUUM", "WEAK_PUMP"}
            found(loop, injected, names, "SENSOR_OFFSET", targets=down, begin=10.0)


@loops
def test_vacuum_lost_while_holding(loop: Regulator) -> None:
    """A leak that the pump cannot make up for: its own name, or that of the pump it looks like."""
    injected = FaultInjection(at=15.0, leak=20.0)
    made = simulate_run(loop, [(30.0, TARGET)], injected=injected)
    names = {"VACUUM_LOST", "NO_VACUUM", "WEAK_PUMP"}
    if not loop.is_noisy:  # where pump and leak balance, a coarse reading stands still
        names.add("SENSOR_STUCK")
    assert made.outcome in names
    gone = made.time[(made.time > 15.0) & (made.vacuum < TARGET - loop.loss_margin)]
    assert made.fault_time - gone[0] <= detection_times(loop, TARGET)["VACUUM_LOST"]


def test_a_slow_loss_that_the_pump_may_not_answer_is_found_by_its_time() -> None:
    """The pump rests by its minimum time, so that nothing but the lost vacuum tells."""
    loop = regulator(kind="bang-bang", minimum_off=1e3, lost_time=2.0)
    made = simulate_run(loop, [(60.0, TARGET)], injected=FaultInjection(at=10.0, leak=0.05))
    assert made.outcome == "VACUUM_LOST"
    gone = made.time[(made.time > 10.0) & (made.vacuum < TARGET - loop.loss_margin)][0]
    assert made.fault_time - gone == pytest.approx(2.0, abs=0.1)
    assert made.fault_time - gone <= detection_times(loop, TARGET)["VACUUM_LOST"]


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_pump_that_dies_while_holding(kind: str) -> None:
    """At the latest when the leak has drawn the vacuum out of the band."""
    loop = regulator(kind=kind)
    made = simulate_run(loop, [(80.0, TARGET)], injected=FaultInjection(at=15.0, pump=0.0))
    out = loop.loss_margin / (AIR.leak * (TARGET - loop.loss_margin))
    assert made.outcome in {"NO_VACUUM", "WEAK_PUMP", "VACUUM_LOST"}
    assert made.fault_time - 15.0 <= out + detection_times(loop, TARGET)["VACUUM_LOST"]


def test_the_safe_state_is_the_declared_one() -> None:
    for state in SAFE_STATES:
        made = simulate_run(
            regulator(safe_state=state),
            [(20.0, TARGET)],
            injected=FaultInjection(at=12.0, sensor="nan"),
        )
        assert made.pump[-1] == 0
        assert made.vent[-1] == (state == "release")
        assert (made.vacuum[-1] < 1.0) == (state == "release")


DAY = [(60.0, 80e3), (30.0, 40e3), (30.0, 0.0), (60.0, 92e3), (20.0, 10e3), (10.0, 0.0)]
"""What a healthy hour repeats: rises, releases half way and whole, holds high and low."""


IN_NOISE = (("scheduled", "air"), ("bang-bang", "water"))


@pytest.mark.parametrize(
    ("kind", "plant"),
    [
        pytest.param(kind, plant, id=f"{name}-{kind}", marks=HALVES[(kind, name) not in IN_NOISE])
        for name, plant in PLANTS.items()
        for kind in KINDS
    ],
)
def test_no_false_alarm_in_noisy_healthy_hours(kind: str, plant: Plant) -> None:
    """Six times 17 hours; the pump is up to a fifth off its model and the leak smaller."""
    for flow, leak in ((1.0, 1.0), (0.8, 0.2), (1.2, 0.0)):
        true = dataclasses.replace(plant, rate=plant.rate * flow, leak=plant.leak * leak)
        loop = regulator(kind=kind, plant=plant)
        made = simulate_runs(loop, DAY, runs=6, duration=3600.0, plant=true, seed=11)
        assert (made.fault == 0).all(), np.unique(made.fault)


@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("frequency", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("reversible", [False, True])
def test_no_false_alarm_where_the_target_moves(
    kind: str, frequency: float, reversible: bool
) -> None:
    """At the highest frequency neither pump nor vent can follow; that is no fault."""
    path = [(0.05, 50e3 + 30e3 * math.sin(2 * math.pi * frequency * 0.05 * n)) for n in range(400)]
    plant = dataclasses.replace(AIR, backwards=45e3 if reversible else 0.0)
    loop = regulator(kind=kind, plant=plant, reversible=reversible)
    made = simulate_runs(loop, path, runs=6, duration=600.0, seed=2)
    assert (made.fault == 0).all(), np.unique(made.fault)


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("sensor", [NOISY, COARSE], ids=["noisy", "coarse"])
def test_no_false_alarm_in_hundreds_of_hours(kind: str, sensor: Sensor) -> None:
    loop = regulator(kind=kind, sensor=sensor)
    made = simulate_runs(loop, DAY, runs=cases(1000, 150), duration=3600.0, seed=5)
    assert (made.fault == 0).all()
