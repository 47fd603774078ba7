"""The drop marched in time: rebound, slack rope, histories, and the record of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from layerjam.brake.device.load import load
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.drop_in_time import History, drop_in_time
from layerjam.brake.simulate.record import Outcome
from layerjam.brake.simulate.rope_alone import simulate_damped_rope
from layerjam.core.errors import QuantityError

FILE = load("choi2018-kapton")
CASE = {"mass": 1.0, "speed": 2.5, "rope_stiffness": 16.8e3}
G, SPRING = 9.80665, 1 / (1 / 131e3 + 1 / 16.8e3)


@pytest.fixture
def few_samples(monkeypatch):
    """A record of few samples leaves most of the time to the stop."""
    monkeypatch.setattr("layerjam.brake.simulate.drop_in_time.SAMPLES", 60)


def test_at_constant_vacuum_it_is_the_exact_one():
    timed, record = drop_in_time(FILE, vacuum=94.5e3, **CASE)
    exact, other = drop(FILE, vacuum=94.5e3, **CASE)
    assert timed.slip == pytest.approx(exact.slip, abs=1e-8 * 0.06)
    assert timed.peak_force == pytest.approx(exact.peak_force, rel=1e-9)
    assert timed.time == pytest.approx(other.time[-1], rel=1e-6)
    assert record.outcome is other.outcome is Outcome.STOPPED
    there = np.interp(other.slip[150:-1], record.slip, record.dissipated_energy)
    np.testing.assert_allclose(there, other.dissipated_energy[150:-1], rtol=2e-3, atol=1e-3)


def test_the_rebound_swings_on_the_spring_and_comes_back_without_sliding():
    timed, record = drop_in_time(FILE, vacuum=94.5e3, duration=0.2, **CASE)
    assert timed.outcome is Outcome.STOPPED
    assert timed.outcome_at_end is Outcome.FINISHED
    assert timed.slip_at_end == pytest.approx(timed.slip, rel=1e-9)
    after = record.time > timed.time
    # thrown back: taut up to force zero, then free flight, and nothing is lost
    energy = record.speed_of_mass**2 / 2 - G * record.travel + record.force**2 / (2 * SPRING)
    np.testing.assert_allclose(energy[after], energy[after][0], rtol=1e-9)
    slack = after & (record.force == 0)
    assert slack.sum() > 20
    flight = np.polyfit(record.time[slack][:10], record.travel[slack][:10], 2)
    assert 2 * flight[0] == pytest.approx(G, rel=1e-6)
    assert (record.travel[slack] <= record.slip[slack] + 1e-15).all()


@pytest.mark.usefixtures("few_samples")
def test_a_damped_rope_comes_to_rest_at_the_weight():
    timed, record = drop_in_time(FILE, vacuum=94.5e3, rope_damping=60.0, duration=1.0, **CASE)
    assert record.force[-1] == pytest.approx(G, rel=1e-3)
    assert abs(record.speed_of_mass[-1]) < 1e-4
    assert timed.slip < drop(FILE, vacuum=94.5e3, **CASE)[0].slip
    assert (np.diff(record.dissipated_energy) >= -1e-15).all()
    assert (np.diff(record.slip) >= 0).all()


@pytest.mark.slow
def test_venting_after_the_stop_lets_the_weight_down():
    vent = History(np.array([0.0, 0.05, 0.15, 1.0]), np.array([94.5e3, 94.5e3, 3e3, 3e3]))
    timed, record = drop_in_time(
        FILE, mass=3.0, speed=1.0, vacuum=vent, rope_stiffness=16.8e3, rope_damping=100.0,
        duration=1.0,
    )  # fmt: skip
    assert timed.outcome is Outcome.STOPPED
    assert timed.outcome_at_end is Outcome.BOTTOMED_OUT
    assert timed.slip_at_end == FILE.brake.sheets.usable_travel
    assert any("slid on" in words for words in record.warnings)
    np.testing.assert_allclose(
        record.vacuum_in_time, np.interp(record.time, vent.time, vent.vacuum)
    )
    assert record.conditions()["vacuum"] == "as in the column"


def test_progress_is_told_and_can_stop_it():
    told: list[float] = []
    drop_in_time(FILE, vacuum=94.5e3, duration=0.1, progress=told.append, **CASE)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(0.1, rel=0.05)

    def stop_it(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drop_in_time(FILE, vacuum=94.5e3, duration=0.1, progress=stop_it, **CASE)


def test_damping_without_a_rope_is_refused():
    with pytest.raises(QuantityError, match="there is no rope"):
        drop_in_time(FILE, mass=1.0, speed=1.0, vacuum=5e4, rope_damping=3.0)


@pytest.mark.parametrize("damping", [1e-6, 30.0, 2 * np.sqrt(16.8e3), 900.0])
def test_a_damped_rope_alone(damping):
    force, time, heat = simulate_damped_rope(1.0, 2.5, 16.8e3, damping, G)
    # the mass at its standstill: came in = weight's work + energy of motion = heat + spring
    from scipy.integrate import solve_ivp

    def standstill(_, y):
        return y[1]

    standstill.terminal = True
    run = solve_ivp(
        lambda _, y: [y[1], G - 16.8e3 * y[0] - damping * y[1], damping * y[1] ** 2], (0, 1),
        [0, 2.5, 0], events=[standstill], rtol=1e-11, atol=1e-14, method="Radau",
        dense_output=True,
    )  # fmt: skip
    assert time == pytest.approx(run.t_events[0][0], rel=1e-7)
    assert heat == pytest.approx(run.y_events[0][0][2], rel=1e-6, abs=1e-12)
    fine = run.sol(np.linspace(0, time, 4001))
    assert force == pytest.approx((16.8e3 * fine[0] + damping * fine[1]).max(), rel=1e-6)
    if damping < 1e-3:
        assert force == pytest.approx(G + np.sqrt(G**2 + 16.8e3 * 2.5**2), rel=1e-6)


BAD = [
    ({"vacuum": np.nan}, "vacuum: nan"),
    ({"vacuum": -1.0}, "vacuum: -"),
    ({"vacuum": 2e5}, "vacuum: 200 kPa"),
    ({"mass": 0.0}, "mass: 0"),
    ({"mass": np.nan}, "mass: nan"),
    ({"mass": -1.0}, "mass: -1 kg"),
    ({"mass": 1e-300}, "mass: "),
    ({"speed": -1.0}, "speed: -1 m/s"),
    ({"speed": np.nan}, "speed: nan"),
    ({"rope_stiffness": 0.0}, "rope stiffness: 0"),
    ({"rope_damping": -1.0}, "rope damping: -1"),
    ({"step": 0.0}, "step: 0"),
    ({"step": -1e-5}, "step: -"),
    ({"step": 0.1}, "step: 0.1 s is not allowed; .* at most"),
    ({"duration": np.nan}, "duration: nan"),
    ({"speed": 0.0, "gravity": 0.0}, "speed: 0 m/s"),
]


@pytest.mark.parametrize(("change", "words"), BAD)
def test_what_is_no_drop_is_refused(change, words):
    with pytest.raises(QuantityError, match=words):
        drop_in_time(FILE, **({"vacuum": 94.5e3} | CASE | change))


@pytest.mark.parametrize(
    ("time", "vacuum", "words"),
    [
        ([0, 1], [5e4, np.nan], "vacuum of sample 2: nan"),
        ([0, 1], [-1, 5e4], "vacuum of sample 1: -1 Pa"),
        ([0, 1, 0.5], [1, 2, 3], "times must increase"),
        ([0, 0], [1, 2], "times must increase"),
        ([0, np.inf], [1, 2], "time of sample 2"),
        ([0], [1], "at least two"),
        ([0, 1], [1, 2, 3], "same length"),
        ([0, 1], ["a", "b"], "not a row of numbers"),
    ],
)
def test_a_history_checks_itself(time, vacuum, words):
    with pytest.raises(QuantityError, match=words):
        History(time, vacuum)


def test_a_history_above_the_atmosphere_is_refused():
    with pytest.raises(QuantityError, match="sample 2, 120 kPa, exceeds atmospheric pressure"):
        drop_in_time(FILE, vacuum=History([0, 1], [5e4, 1.2e5]), **CASE)


def test_a_duration_shorter_than_the_stop_ends_there():
    timed, record = drop_in_time(FILE, vacuum=94.5e3, duration=0.005, **CASE)
    assert timed.outcome is Outcome.FINISHED
    assert record.time[-1] == timed.time == 0.005
    assert record.speed_of_mass[-1] > 0


@pytest.mark.slow
def test_a_mass_at_rest_is_not_marched_on():
    """An hour of hanging takes no longer than the swings before; the state stays bit for bit."""
    how = {"vacuum": 94.5e3, "rope_damping": 60.0, **CASE}
    _, long = drop_in_time(FILE, duration=3600.0, **how)
    assert long.time[-1] == 3600.0
    assert len(long.time) < 3000
    for column in (long.force, long.slip, long.travel, long.dissipated_energy):
        assert column[-1] == column[-2]
    assert long.force[-1] == pytest.approx(G, rel=1e-9)


def test_a_history_that_does_not_change_is_the_constant_vacuum_bit_for_bit():
    held = History([0.0, 0.01, 1.0], [94.5e3] * 3)
    constant, _ = drop_in_time(FILE, vacuum=94.5e3, **CASE)
    assert drop_in_time(FILE, vacuum=held, **CASE)[0] == constant


@pytest.mark.slow
def test_a_step_up_within_the_stop_converges():
    """Steps end at the samples, so that the jump does not lie anywhere within one."""
    jump = History([0.0, 0.01, 0.010001, 1.0], [60e3, 60e3, 94.5e3, 94.5e3])
    timed, record = drop_in_time(FILE, vacuum=jump, **CASE)
    assert not any("relative error" in words for words in record.warnings)
    fine, _ = drop_in_time(FILE, vacuum=jump, step=record.step / 8, **CASE)
    assert timed.slip == pytest.approx(fine.slip, rel=2e-6)


@pytest.mark.slow
def test_a_snap_in_a_rising_history_says_what_it_takes_there():
    soft = {"mass": 30.0, "speed": 2.5, "rope_stiffness": 2.4e3}
    rising = History([0.0, 0.03], [20e3, 94.5e3])
    timed, record = drop_in_time(FILE, vacuum=rising, **soft)
    assert timed.outcome is Outcome.SNAPS
    assert "the brake snaps" in timed.reason
    there = float(rising.interpolate(timed.time))
    assert 80e3 < there < 94e3
    assert timed.least_stiffness == pytest.approx(2.5798e3 * there / 94.5e3, rel=1e-3)
    assert timed.reason in record.warnings


@pytest.mark.slow
def test_a_history_that_begins_late_says_so():
    late = History([0.01, 0.05], [94.5e3, 40e3])
    _, record = drop_in_time(FILE, vacuum=late, **CASE)
    assert any("until then its first vacuum" in words for words in record.warnings)
    early = History([-1.0, 0.05], [10e3, 94.5e3])
    _, record = drop_in_time(FILE, vacuum=early, **CASE)
    assert record.vacuum_in_time[0] == pytest.approx(float(early.interpolate(0.0)))
    assert record.vacuum == record.vacuum_in_time[0]


def by_small_moves(mass, speed, history, spring, brake, count):
    """Slip at the standstill [m], by leapfrog: friction and backbone of each instant.

    Holds while the sheets slip under a falling vacuum and stick once it rises; `count` steps lead
    up to the turn.
    """
    sheets, film, skin = brake.sheets, brake.film, brake.enclosure
    one = brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width
    sleeve = 2 * sheets.width
    sleeve *= math.sqrt(skin.modulus * skin.wall * film.friction_on_silicone)
    (_, turn, late), (high, low, last) = history.time, history.vacuum
    step, place, v, slip, done = turn / count, 0.0, speed, 0.0, 0
    while v > 0:
        t = done * step
        if done < count:
            p = high + (low - high) * t / turn
        else:
            p = min(low + (last - low) * (t - turn) / (late - turn), last)
        # k (u - x) = c (L2 - x) + e sqrt(x) is a quadratic in sqrt(x)
        c, e = one * p, sleeve * math.sqrt(p)
        drive = spring * place - c * sheets.overlap
        if drive > 0:
            soft = spring - c
            slip = max(slip, ((math.sqrt(e * e + 4 * soft * drive) - e) / (2 * soft)) ** 2)
        v += (G - spring * (place - slip) / mass) * step * (1.0 if done else 0.5)
        place, done = place + v * step, done + 1
    return slip


TURN = History([0.0, 7.65e-3, 10.71e-3], [38.95e3, 21.56e3, 60.43e3])
TURNED = {"mass": 0.328, "speed": 2.034}
STEPS = ((None, 1e-6), (2e-5, 4e-6), (1.43e-5, 2e-6), (5e-6, 3e-7))


@pytest.mark.slow
@pytest.mark.parametrize(("step", "most"), STEPS)
@pytest.mark.usefixtures("few_samples")
def test_slip_up_to_where_a_falling_vacuum_turns_is_not_lost(step, most):
    """The last half step of the fall counts, however the steps meet the turn."""
    there = by_small_moves(*TURNED.values(), TURN, SPRING, FILE.brake, 20_000)
    half = by_small_moves(*TURNED.values(), TURN, SPRING, FILE.brake, 10_000)
    assert half == pytest.approx(there, rel=2e-8)
    timed, record = drop_in_time(FILE, vacuum=TURN, rope_stiffness=16.8e3, step=step, **TURNED)
    assert timed.slip == pytest.approx(there, rel=most)
    assert not any("relative error" in words for words in record.warnings)


@pytest.mark.slow
def test_the_peak_is_that_of_the_record_where_the_vacuum_rises_after_it():
    """Past the top of the force a later, higher vacuum would have had another top."""
    rising = History(np.array([0.0, 0.1]), np.array([30e3, 94.5e3]))
    timed, record = drop_in_time(FILE, vacuum=rising, step=2e-5, **(CASE | {"speed": 3.0}))
    assert record.force[-1] < 0.5 * timed.peak_force
    assert timed.peak_force == pytest.approx(record.force.max(), rel=1e-5)
