"""Closed loops against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.control.loops import AIR, IDEAL, NOISY, WATER, regulator
from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS
from layerjam.brake.fluid.line import Sensor


def test_bang_bang_rises_on_the_exact_exponential() -> None:
    """Until it first switches off the pump runs full: v = end (1 - exp(-(k + leak) t))."""
    made = simulate_run(regulator(kind="bang-bang", sensor=IDEAL), [(10.0, 94.5e3)])
    first = int(np.argmax(made.pump < 1.0))
    b = AIR.rate + AIR.leak
    exact = AIR.reach * -np.expm1(-b * made.time[: first + 1])
    assert first > 500
    np.testing.assert_allclose(made.vacuum[: first + 1], exact, rtol=1e-12)


def test_the_papers_rise_time_in_air_and_water() -> None:
    """Mechanics, section 5: 3.9 s and 1.5 s, 10 to 90 % of 94.5 kPa."""
    tight = dataclasses.replace(AIR, leak=0.0)
    air = simulate_run(regulator(kind="bang-bang", plant=tight, sensor=IDEAL), [(15.0, 94.5e3)])
    r = 94.5 / 101.325
    closed = 7.503 / 3.33 * math.log((1 - 0.1 * r) / (1 - 0.9 * r))
    assert air.rise_time == pytest.approx(closed, abs=2e-5)
    assert air.rise_time == pytest.approx(3.9, rel=0.01)
    wet = dataclasses.replace(WATER, leak=0.0)
    water = simulate_run(regulator(kind="bang-bang", plant=wet, sensor=IDEAL), [(15.0, 94.5e3)])
    assert water.rise_time == pytest.approx(0.8 * 94.5e3 / (wet.rate * wet.top), rel=1e-9)
    assert water.rise_time == pytest.approx(1.5, rel=0.01)


@pytest.mark.parametrize("plant", [AIR, WATER, dataclasses.replace(WATER, leak=0.0)])
@pytest.mark.parametrize("lag", [0.0, 0.003, 0.2])
def test_plant_and_sensor_are_exact_between_samples(plant: Plant, lag: float) -> None:
    """The same commands through an integrator of high order give the same vacuum and reading."""
    made = simulate_run(
        regulator(plant=plant, sensor=Sensor(range=103e3, lag=lag)),
        [(0.6, 60e3), (0.2, 20e3), (0.2, 0.0)],
    )
    state, dt = np.zeros(2), 0.01
    for n in range(len(made.time) - 1):
        u, z = float(made.pump[n]), float(made.vent[n])

        def slope(t: float, y: np.ndarray, u: float = u, z: float = z) -> list[float]:
            v, m = y
            up = u * plant.rate * (plant.top - plant.weight * v)
            return [up - (plant.leak + z * plant.vent) * v, (v - m) / lag if lag else 0.0]

        state = solve_ivp(slope, (0, dt), state, method="DOP853", rtol=1e-12, atol=1e-7).y[:, -1]
        if not lag:
            state[1] = state[0]
        assert made.vacuum[n + 1] == pytest.approx(state[0], rel=1e-9, abs=1e-5)
        assert made.measured[n + 1] == pytest.approx(state[1], rel=1e-9, abs=1e-5)


def test_the_rate_that_meets_the_sensors_lag_is_no_special_case() -> None:
    """b tau = 1 is a removable singularity of the sensor's closed form."""
    ends = []
    for shift in (-1e-6, 0.0, 1e-6):
        plant = Plant(rate=2.0, top=1e5, vent=10.0 * (1 + shift))
        wide = Sensor(range=103e3, lag=0.1)
        made = simulate_run(regulator(plant=plant, sensor=wide), [(1.0, 50e3), (0.1, 0.0)])
        ends.append(made.measured[-1])
    assert ends[1] == pytest.approx(0.5 * (ends[0] + ends[2]), rel=1e-9)


@pytest.mark.parametrize("kind", ["pi", "scheduled"])
@pytest.mark.parametrize("plant", [AIR, WATER])
def test_pi_holds_without_steady_error_or_windup(kind: str, plant: Plant) -> None:
    """The rise saturates for seconds; the integral must not have grown meanwhile."""
    made = simulate_run(
        regulator(kind=kind, plant=plant, sensor=IDEAL, least_command=1e-6), [(30.0, 80e3)]
    )
    assert made.outcome == "HEALTHY"
    assert abs(made.steady_error) < 1.0
    assert made.overshoot < 0.01 * 80e3
    assert made.vent_switches == 0


def test_the_scheduled_loop_answers_alike_at_every_vacuum() -> None:
    """A small step follows PI on an integrator, 1 - (1 - s) exp(-s), s = t/(2 (T_c + theta))."""
    for low in (20e3, 50e3, 80e3):
        loop = regulator(
            kind="scheduled", sensor=IDEAL, least_command=1e-6, feed_forward=False, dead_band=0.0,
            sample_time=1e-3, plant=dataclasses.replace(AIR, leak=0.05),
        )  # fmt: skip
        made = simulate_run(loop, [(20.0, low), (1.0, low + 100.0)])
        gains = loop.gains()
        s = made.time[:1000] / (2 * (gains.closed_loop_time + gains.dead_time))
        exact = 100 * (1 - (1 - s) * np.exp(-s))
        assert np.abs(made.vacuum[20000:] - low - exact).max() < 6.0


def test_feed_forward_holds_against_the_leak_from_the_first_sample() -> None:
    """Without any gain the feed-forward alone ends at the target: the plant's own balance."""
    loop = regulator(sensor=IDEAL, gain=1e-15, integral_time=1e6, least_command=1e-6)
    made = simulate_run(loop, [(4000.0, 50e3)])
    assert made.vacuum[-1] == pytest.approx(50e3, rel=1e-6)


def test_bang_bang_switches_as_often_as_the_closed_form_says() -> None:
    """A cycle is a rise through the band at full pump and a decay by the leak."""
    loop = regulator(kind="bang-bang", sensor=IDEAL, hysteresis=2e3, sample_time=1e-3)
    made = simulate_run(loop, [(400.0, 60e3)])
    low, high, b = 59e3, 61e3, AIR.rate + AIR.leak
    on = math.log((AIR.reach - low) / (AIR.reach - high)) / b
    off = math.log(high / low) / AIR.leak
    assert made.pump_switches == pytest.approx(2 * 400 / (on + off), abs=4)
    assert made.ripple == pytest.approx(2e3, rel=0.05)


def test_minimum_times_are_kept_and_switches_counted() -> None:
    loop = regulator(kind="pi", minimum_on=0.3, minimum_off=0.5)
    made = simulate_run(loop, [(60.0, 60e3), (5.0, 0.0)])
    on = made.pump > 0
    edges = np.flatnonzero(np.diff(on.astype(int)))
    assert made.pump_switches == len(edges) + int(on[0])
    lengths = np.diff(edges)
    first_is_off = not on[edges[0] + 1]
    rests, runs = (lengths[::2], lengths[1::2]) if first_is_off else (lengths[1::2], lengths[::2])
    assert runs.min() >= 30
    assert rests.min() >= 50


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_lower_target_is_reached_through_the_vent_or_the_reversed_pump(kind: str) -> None:
    steps = [(8.0, 80e3), (8.0, 30e3), (3.0, 0.0)]
    vented = simulate_run(regulator(kind=kind), steps)
    assert vented.outcome == "HEALTHY"
    assert vented.vacuum[1590] == pytest.approx(30e3, rel=0.05)
    assert vented.vacuum[-1] < 100
    back = dataclasses.replace(AIR, backwards=AIR.rate * 101325.0)
    turned = simulate_run(regulator(kind=kind, plant=back, reversible=True), steps[:2])
    assert turned.outcome == "HEALTHY"
    assert turned.vacuum[-1] == pytest.approx(30e3, rel=0.05)
    assert turned.vent_switches == 0
    assert turned.pump.min() < 0


def test_a_batch_gives_what_each_run_gives_alone() -> None:
    """Neither their number nor the cores change a run."""
    loop, steps = regulator(), [(4.0, 60e3), (2.0, 30e3), (1.0, 0.0)]
    many = simulate_runs(loop, steps, runs=37, duration=12.0, seed=3)
    fewer = simulate_runs(loop, steps, runs=19, duration=12.0, seed=3)
    alone = simulate_run(loop, steps, duration=12.0, seed=3)
    for field in dataclasses.fields(many):
        values = getattr(many, field.name)
        np.testing.assert_array_equal(values[:19], getattr(fewer, field.name))
    assert many.rise_time[0] == alone.rise_time
    assert many.overshoot[0] == alone.overshoot
    assert many.steady_error[0] == alone.steady_error
    assert many.pump_on[0] == alone.pump_on == pytest.approx(np.abs(alone.pump).sum() * 0.01)
    assert len(set(many.overshoot)) == 37


def test_the_sensor_shows_range_steps_offset_and_noise() -> None:
    off = dataclasses.replace(NOISY, offset=300.0, range=81e3)
    made = simulate_run(regulator(sensor=off), [(40.0, 80e3)], plant=AIR)
    shown = made.measured
    np.testing.assert_allclose(shown / 25.0, np.round(shown / 25.0), atol=1e-9)
    late = slice(2000, None)
    assert np.mean(shown[late] - made.vacuum[late]) == pytest.approx(300, abs=10)
    assert np.std(shown[late] - made.vacuum[late]) == pytest.approx(
        math.sqrt(50**2 + 25**2 / 12), rel=0.05
    )


def test_an_injected_fault_acts_from_its_time_on() -> None:
    loop = regulator(safe_state="hold")
    made = simulate_run(loop, [(10.0, 60e3)], injected=FaultInjection(at=5.0, sensor="nan"))
    assert made.outcome == "NOT_A_NUMBER"
    assert made.fault_time == 5.0
    assert (made.pump[500:] == 0).all()
    assert (made.vent[500:] == 0).all()
    assert np.isnan(made.measured[500:]).all()


def test_a_broken_sensor_shows_what_was_said() -> None:
    """Its number, its last one, or too much; up to then what a sound one shows."""
    loop, path = regulator(safe_state="hold"), [(10.0, 60e3)]
    sound = simulate_run(loop, path).measured
    for name, value in (("rail", 7e3), ("stuck", 0.0), ("offset", 2e3)):
        shown = simulate_run(
            loop, path, injected=FaultInjection(at=8.0, sensor=name, value=value)
        ).measured
        np.testing.assert_array_equal(shown[:800], sound[:800])
        if name == "offset":
            assert shown[800] - sound[800] == 2e3
        else:
            assert (shown[800:] == (value or sound[799])).all()
    never = simulate_run(loop, path, injected=FaultInjection(at=0.0, sensor="stuck")).measured
    assert not never.any()


@pytest.mark.parametrize(
    "injected",
    [
        FaultInjection(at=1.0, volume=1 / 8),
        FaultInjection(at=1.0, volume=1e-3),
        FaultInjection(at=1.0, leak=30.0, pump=3.0),
        FaultInjection(at=1.0, vent=100.0),
    ],
)
def test_a_broken_plant_is_exact_too(injected: FaultInjection) -> None:
    """v = end + (v - end) exp(-b dt), however much of a sample's change that is."""
    for kind in ("pi", "bang-bang"):
        made = simulate_run(regulator(kind=kind), [(2.0, 50e3), (1.0, 0.0)], injected=injected)
        rate, top, _weight, leak, vent, *_ = injected.break_plant(AIR)
        u, z, v = made.pump[100:-1], made.vent[100:-1], made.vacuum[100:]
        b = rate * u + leak + vent * z
        end = rate * u * top / b
        exact = end + (v[:-1] - end) * np.exp(-b * 0.01)
        np.testing.assert_allclose(v[1:], exact, rtol=1e-12, atol=1e-8)
