"""The regulator behind a tube, against the network of `fluid` and an integrator of high order."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant, linearise_line, match_line
from layerjam.bench.control.settings import KINDS, SAFELY, Regulator, validate
from layerjam.brake.fluid.line import Chamber, Leak, Line, Pump, Sensor, Tube, Valve
from layerjam.brake.fluid.network import Drive, advance, state_at_pressure
from layerjam.brake.fluid.timing import air_rise_time as pumped
from layerjam.brake.fluid.tube import tube_area
from layerjam.core.errors import QuantityError

NOISY = Sensor(range=110e3, lag=0.005, noise=50.0, resolution=25.0)
EXACT = Sensor(range=110e3)


def line(
    length: float = 5.0, bore: float = 0.8e-3, volume: float = 7.5e-6, flow: float = 3.33e-6,
    leak: float = 0.0, exponent: float = 1.0,
) -> Line:  # fmt: skip
    """The line of the issue unless told otherwise."""
    return Line(
        chamber=Chamber(volume=volume), pump=Pump(flow=flow), leak=Leak(laminar=leak),
        tube=Tube(length=length, bore=bore), valve=Valve(conductance=5 * volume / 1e5),
        polytropic=exponent,
    )  # fmt: skip


def random_lines(count: int, seed: int) -> list[tuple[Line, float]]:
    """Lines whose tubes pass a third to 300 times what the pump does, each with a target [Pa]."""
    random, made = np.random.default_rng(seed), []
    while len(made) < count:
        volume, length = 10 ** random.uniform(-6, -4), 10 ** random.uniform(-1, 1.2)
        flow, eased = volume * 10 ** random.uniform(-1, 0.8), 10 ** random.uniform(-0.5, 2.5)
        bore = (eased * flow / 2 / 101325 * 256 * 1.81e-5 * length / math.pi) ** 0.25
        leak = volume * random.choice([0.0, 0.001, 0.004])
        found = line(length, bore, volume, flow, leak)
        target = 101325 * random.uniform(0.2, 0.9)
        if found.tube is None or bore < 1e-4 or tube_area(found.tube) * length > 2 * volume:
            continue
        if target < 0.98 * linearise_line(found, vacuum=target).reach:
            made.append((found, target))
    return made


def regulator(
    of: Line, target: float, kind: str = "bang-bang", sensor: Sensor = NOISY
) -> Regulator:
    plant = linearise_line(of, vacuum=target)
    return Regulator(
        plant=plant, sensor=sensor, kind=kind, safe_state="release", tuned_at=target,
        sample_time=min(0.01, 0.09 / (plant.rate + plant.leak)),
    )  # fmt: skip


def rise(loop: Regulator, target: float, seed: int = 0) -> tuple[float, str]:
    made = simulate_run(loop, [(12 * loop.plant.time_constant(target), target)], seed=seed)
    return made.rise_time, made.outcome


@pytest.mark.parametrize("target", [60e3, 85e3, 92e3])
def test_the_issues_line_rises_as_its_file_says(target: float) -> None:
    """7.5 mL, 3.33 mL/s, 5 m of 0.8 mm: 6.40 s to 85 kPa, not 2.97 s; and no fault is said.

    PI leaves full command before the target, so that it takes somewhat longer.
    """
    for kind in KINDS:
        took, outcome = rise(regulator(line(), target, kind), target)
        assert outcome == "HEALTHY"
        longer = took / pumped(target, line())[0]
        assert 0.999 < longer < (1.001 if kind == "bang-bang" else 1.15)


@pytest.mark.parametrize("exponent", [1.0, 1.3])
@pytest.mark.parametrize("bore", [0.5e-3, 1e-3, 4e-3, 10e-3])
def test_stiff_and_slow_tubes_rise_alike(bore: float, exponent: float) -> None:
    """A tube wide and short evens out in microseconds, a narrow one in seconds."""
    for length in (2e-3, 0.3, 3.0):
        of = line(length, bore, exponent=exponent)
        took, outcome = rise(regulator(of, 80e3, sensor=EXACT), 80e3)
        assert outcome == "HEALTHY"
        assert took == pytest.approx(pumped(80e3, of)[0], rel=2e-3)


def test_random_tubes_rise_as_their_lines_do_and_no_fault_is_said() -> None:
    """The controller's pump runs full until the target: the line's own rise, leak aside."""
    for of, target in random_lines(40, 1):
        took, outcome = rise(regulator(of, target), target)
        assert outcome == "HEALTHY", of
        assert took == pytest.approx(pumped(target, of)[0], rel=0.03), of


def test_the_same_commands_through_the_network_give_the_same_vacuum() -> None:
    """A PI loop's commands, sample by sample, by the network's Runge-Kutta steps."""
    of = line()
    made = simulate_run(regulator(of, 80e3, "pi", EXACT), [(6.0, 40e3), (8.0, 80e3)])
    state, worst = state_at_pressure(of), 0.0
    for n in range(len(made.time) - 1):
        assert made.vent[n] == 0
        state = advance(state, Drive(pump=float(made.pump[n])), of, 0.01, 2)
        worst = max(worst, abs(of.site.atmosphere - state[0] - made.vacuum[n + 1]))
    assert worst < 1.0


@pytest.mark.parametrize("lag", [0.0, 0.03])
def test_vent_leak_and_sensor_behind_a_tube(lag: float) -> None:
    """Two volumes and a sensor of first order, integrated to 1e-10 between the samples."""
    loop = regulator(line(leak=2e-8), 60e3, "pi", Sensor(range=110e3, lag=lag))
    made = simulate_run(loop, [(3.0, 60e3), (1.0, 20e3), (1.0, 0.0)])
    assert made.vent.max() == 1
    plant = loop.plant
    tube = plant.passage
    assert tube is not None
    state = np.zeros(3)
    for n in range(len(made.time) - 1):
        u, z = float(made.pump[n]), float(made.vent[n])

        def slope(t: float, y: np.ndarray, u: float = u, z: float = z) -> list[float]:
            p, s = tube.atmosphere - y[0], tube.atmosphere - y[1]
            along = tube.passes * (p * p - s * s)
            drawn = u * plant.rate * (plant.top - y[1]) - z * plant.vent * y[1]
            shown = (y[0] - y[2]) / lag if lag else 0.0
            return [along - plant.leak * y[0], (drawn - along) / tube.volume, shown]

        state = solve_ivp(slope, (0, 0.01), state, method="Radau", rtol=1e-10, atol=1e-5).y[:, -1]
        assert made.vacuum[n + 1] == pytest.approx(state[0], abs=2.0)
        assert made.measured[n + 1] == pytest.approx(state[2] if lag else state[0], abs=2.0)


def test_a_tube_of_no_length_is_no_tube() -> None:
    """The limit of a short and wide tube is the line without, its detectors alike."""
    bare = dataclasses.replace(line(leak=2e-8), tube=None)
    short = line(1e-3, 1e-3, leak=2e-8)
    for kind in KINDS:
        one, two = regulator(bare, 60e3, kind), regulator(short, 60e3, kind)
        assert two.owed_rise.rate == pytest.approx(one.owed_rise.rate, rel=1e-3)
        times = detection_times(two, 60e3)
        for name, time in detection_times(one, 60e3).items():
            assert times[name] == pytest.approx(time, rel=0.02, abs=one.sample_time), name
        a = simulate_run(one, [(8.0, 60e3), (1.0, 0.0)], seed=1)
        b = simulate_run(two, [(8.0, 60e3), (1.0, 0.0)], seed=1)
        assert np.abs(a.vacuum - b.vacuum).max() < 200
        assert linearise_line(bare, vacuum=60e3).passage is None


def test_what_the_line_holds_and_how_it_changes_is_the_tubes_too() -> None:
    """The full pump's balance and rise, by integrating the two volumes until they stand."""
    plant = linearise_line(line(leak=5e-7), vacuum=60e3)
    loop = Regulator(plant=plant, sensor=EXACT, kind="bang-bang", safe_state="hold")
    stood = simulate_run(
        dataclasses.replace(loop, weak_ratio=0.01, no_vacuum_ratio=0.01),
        [(200.0, min(0.999 * plant.reach, 60e3))],
    )
    assert stood.vacuum.max() <= plant.reach
    tube = plant.passage
    assert tube is not None
    p, s = tube.atmosphere - plant.reach, tube.atmosphere - plant.top
    s += plant.leak * plant.reach / plant.rate
    assert tube.passes * (p * p - s * s) == pytest.approx(plant.leak * plant.reach, rel=1e-9)


DAY = [(60.0, 1.0), (30.0, 0.5), (30.0, 0.0), (60.0, 1.0), (20.0, 0.1), (10.0, 0.0), (30.0, 0.8)]
"""Share of the target over time, in time constants of the line."""


@pytest.mark.parametrize("kind", list(KINDS))
def test_no_false_alarm_behind_random_tubes(kind: str) -> None:
    """Rises, releases half way and whole; the pump a tenth weaker, a fifth stronger."""
    for i, (of, target) in enumerate(random_lines(8, 2)):
        loop = regulator(of, target, kind)
        slow = max(loop.plant.time_constant(target), 1.0)
        path = [(slow * lasting / 10, share * target) for lasting, share in DAY]
        for flow in (0.9, 1.2):
            true = dataclasses.replace(loop.plant, rate=flow * loop.plant.rate)
            made = simulate_runs(loop, path, runs=2, plant=true, seed=i)
            assert (made.fault == 0).all(), (of, target, made.fault, made.fault_time)


@pytest.mark.slow
def test_faults_behind_random_tubes_are_said_in_their_time() -> None:
    """What is promised of a fault while the pump runs full is kept, whenever it begins."""
    random, tried = np.random.default_rng(3), dict.fromkeys(("NO_VACUUM", "WEAK_PUMP"), 0)
    for of, target in random_lines(25, 4):
        loop = regulator(of, target)
        times = detection_times(loop, target)
        healthy = simulate_run(loop, [(12 * loop.plant.time_constant(target), target)])
        for name, pump in (("NO_VACUUM", 0.0), ("WEAK_PUMP", loop.weak_ratio / 2)):
            if math.isinf(times[name]):
                continue
            tried[name] += 1
            at = random.uniform(0, healthy.time[np.argmax(healthy.vacuum > 0.7 * target)])
            made = simulate_run(
                loop, [(at + times[name] + 1.0, target)], injected=FaultInjection(at=at, pump=pump)
            )
            assert made.outcome in {"NO_VACUUM", "WEAK_PUMP", "SENSOR_STUCK"}, (of, target, at)
            assert made.fault_time - at <= times[name] + 1e-9, (of, target, at)
    assert tried["NO_VACUUM"] >= 20
    assert tried["WEAK_PUMP"] >= 8


def rising(plant: Plant, command: float) -> tuple[np.ndarray, np.ndarray]:
    """The chamber's vacuum and its rise at 50 moments after the tube's flow has come."""
    tube = plant.passage
    assert tube is not None

    def slope(_t: float, y: np.ndarray) -> list[float]:
        p, s = tube.atmosphere - y[0], tube.atmosphere - y[1]
        along = tube.passes * (p * p - s * s)
        return [along, (command * plant.rate * (plant.top - y[1]) - along) / tube.volume]

    begins = 4 * (float(tube.pump_lag(plant.rate, tube.atmosphere)) + 1e-3)
    times = np.linspace(begins, begins + 3 / plant.rate, 50)
    made = solve_ivp(
        slope, (0, times[-1]), [0.0, 0.0], "LSODA", rtol=1e-9, atol=1e-3, t_eval=times
    )  # fmt: skip
    return made.y[0], np.array([slope(0.0, y)[0] for y in made.y.T])


@pytest.mark.parametrize("kind", ["bang-bang", "pi"])
def test_the_rise_owed_is_below_the_true_one_by_its_ratio_at_most(kind: str) -> None:
    """By the two volumes integrated; what the ratio leaves out fits between 1.2 and `SAFELY`."""
    for of, target in random_lines(6, 9):
        loop = regulator(of, target, kind)
        for command in (1.0,) if kind == "bang-bang" else (1.0, 0.4, 0.1):
            vacuum, true = rising(loop.plant, command)
            within = vacuum < target
            ratio = true[within] / loop.owed_rise.rise_at(vacuum[within], command)
            assert ratio.min() > 0.97, (of, target, command)
            assert ratio.max() < SAFELY / 1.2 * loop.owed_rise.ratio, (of, target, command)
        assert loop.owed_rise.ratio < (1.2 if kind == "bang-bang" else 1.8)


def test_a_target_beyond_what_the_detectors_are_tuned_to_is_refused() -> None:
    loop = regulator(line(), 60e3)
    validate(loop, 60e3)
    with pytest.raises(QuantityError, match="the detectors allow for the tube only up to 60 kPa"):
        validate(loop, 61e3)
    tuned = dataclasses.replace(loop, plant=loop.plant.tune_up_to(80e3))
    validate(tuned, 80e3)


def test_without_a_tube_nothing_is_owed_otherwise() -> None:
    plant = Plant(rate=0.44, top=1e5, leak=0.002, vent=5.0)
    loop = Regulator(plant=plant, sensor=NOISY, safe_state="hold")
    assert (loop.owed_rise.rate, loop.owed_rise.top, loop.blocked_limit) == (
        0.44,
        1e5,
        loop.blocked_ratio,
    )
    assert loop.total_lag == loop.tolerances.lag > NOISY.lag
    assert loop.loss_time == loop.lost_time
    assert plant.lumped_plant is plant
    assert plant.tune_up_to(1.0) is plant


@pytest.mark.parametrize("length", [None, 5.0])
def test_a_line_that_matches_a_measured_plant(length: float | None) -> None:
    # pump 2 s, leak 50 s, vent 0.4 s; 96 kPa; exponent 1.2; both pumps together
    wanted = Plant(rate=0.5, top=96e3, leak=0.02, vent=2.5)
    old = line(exponent=1.2) if length else dataclasses.replace(line(exponent=1.2), tube=None)
    old = dataclasses.replace(
        old, valve=None,
        pump=Pump(curve=((0.0, 3e-6), (50e3, 2e-6), (90e3, 0.0)), count=2, backwards=1e-6),
    )  # fmt: skip
    made = match_line(old, wanted, vacuum=60e3)
    volume = 7.5e-6 + (5.0 * math.pi / 4 * 0.8e-3**2 if length else 0.0)
    assert made.pump.flow == pytest.approx(0.5 * volume / 1.2 / 2)
    assert made.pump.ultimate == pytest.approx(101325 - 96e3)
    assert made.valve is not None
    assert made.valve.conductance == pytest.approx(2.5 * volume / 1.2 / 1e5)
    # a laminar leak of G lets in G (p_atm^2 - p^2) / 2 p_atm
    flow = made.leak.laminar * (101325**2 - 41325**2) / (2 * 101325)
    assert 1.2 * flow / volume / 60e3 == pytest.approx(0.02)
    found = linearise_line(made, vacuum=60e3).lumped_plant
    assert (found.rate, found.top) == pytest.approx((0.5, 96e3))
    assert (found.leak, found.vent) == pytest.approx((0.02, 2.5))
