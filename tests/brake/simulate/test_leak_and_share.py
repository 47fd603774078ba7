"""A vacuum that leaks away while it is held, and one that presses the sheets with a share of it.

Against the leak's differential equation, a root for each instant and the paper's own formulas, all
written here.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tests.strategies import KAPTON, change, points, random_brakes, seeds

import layerjam as lj
from layerjam.bench.commands.plan import _add_leak
from layerjam.bench.control.plan import Arrival, needed_vacuum, plan_stop
from layerjam.brake.fluid.closed_forms import held_vacuum, leak_down_time
from layerjam.brake.mechanics import friction, pull
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.stick_slip.wet import ILLUSTRATIVE, wet_force
from layerjam.brake.simulate.drop_in_time import History, drop_in_time
from layerjam.brake.simulate.procedure import parse_procedure
from layerjam.brake.simulate.stack_layout import make_stack
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import LayerjamError, QuantityError

FILE = lj.load("choi2018-kapton")
A, FULL = 101325.0, 94.5e3


def leaked(time, start, leak_time, a=A):
    """V p' = G (a^2 - p^2)/(2a) by a Runge-Kutta of order 8."""

    def rate(_, vacuum):
        # a^2 - p^2 without the difference of nearly equal squares, which a small vacuum would lose
        return -vacuum * (2 * a - vacuum) / (2 * a) / leak_time

    time = np.atleast_1d(time)
    made = solve_ivp(rate, (0, time[-1]), [start], "DOP853", time, rtol=1e-12, atol=1e-16 * start)
    return made.y[0]


@settings(max_examples=25)
@given(st.floats(1.0, 0.999 * A), st.floats(1e-2, 1e6), st.floats(0.01, 8.0))
def test_a_held_vacuum_follows_the_leak(start, leak_time, spans):
    time = np.array([0.3, 1.0]) * spans * leak_time
    held = held_vacuum(time, start, 1 / leak_time, A)
    np.testing.assert_allclose(held, leaked(time, start, leak_time), rtol=1e-8)
    np.testing.assert_allclose(leak_down_time(held, start, 1 / leak_time, A), time, rtol=1e-9)


def test_a_small_vacuum_falls_exponentially_and_a_perfect_one_no_faster_than_half_of_it():
    small = held_vacuum(np.array([100.0, 300.0]), 1e-3, 1 / 100, A)
    np.testing.assert_allclose(small, 1e-3 * np.exp([-1.0, -3.0]), rtol=1e-7)
    # p = 0 fills with a G/2V, and follows a tanh(t G/2V)
    np.testing.assert_allclose(
        A - held_vacuum(70.0, A, 1 / 100, A), A * math.tanh(0.35), rtol=1e-12
    )


@given(st.floats(50.0, A), st.floats(1e-3, 1e5), st.floats(0, 1e4))
@settings(max_examples=30)
def test_a_leaking_history_says_how_exact_it_is(start, leak_time, held):
    history = History.leaking(start, leak_time, A, held)
    time = np.linspace(0, 14 * leak_time, 3001) - held
    exact = held_vacuum(time + held, start, 1 / leak_time, A)
    late = time > history.time[-1]
    assert np.abs(history.interpolate(time) - exact)[~late].max() <= 1.3e-7 * start
    assert exact[late].max(initial=0.0) <= 2.4e-7 * start
    assert history.time[0] == -held


def test_a_pull_with_a_leak_follows_the_root_of_every_instant():
    procedure = "evacuate to 94.5 kPa and hold 5 s; pull at 13 mm/s until 20 mm; hold 90 s; "
    procedure += "pull at 0.5 mm/s until 40 mm"
    record = tensile(FILE, parse_procedure(procedure), leak_time=120.0)
    after = record.time > 5.0
    vacuum = leaked(record.time[after] - 5.0, FULL, 120.0)
    np.testing.assert_allclose(record.vacuum[after], vacuum, rtol=1e-9)
    assert np.all(record.vacuum[~after] == FULL)
    k = KAPTON.stiffness_measured
    cut = 0.24 * 0.875 * 10 * 13e-3
    assert cut == pytest.approx(
        KAPTON.film.kinetic * KAPTON.scale_factor * 10 * KAPTON.sheets.width, rel=1e-12
    )

    def force(x, p):
        return cut * p * (KAPTON.sheets.overlap - x) + float(enclosure_force(x, p, KAPTON))

    pulled, places = record.slip[after], record.elongation[after]
    sliding = np.flatnonzero(pulled > 1e-3)
    for i in sliding[:: len(sliding) // 40]:
        p, u = vacuum[i], places[i]
        slip = brentq(lambda x, p=p, u=u: x + force(x, p) / k - u, 0, 0.06, xtol=1e-15)
        assert pulled[i] == pytest.approx(slip, rel=1e-6)
        assert record.force[after][i] == pytest.approx(force(slip, p), rel=1e-6)
    held = (places == 0.02) & (record.time[after] > 7)
    assert np.ptp(record.work[after][held]) <= 1e-12
    assert np.all(np.diff(record.dissipated_energy) >= -1e-9)


def test_an_evacuation_and_a_vent_end_a_leak():
    text = "evacuate to 50 kPa; hold 30 s; evacuate to 80 kPa and hold 10 s; hold 20 s; vent; "
    record = tensile(FILE, parse_procedure(text + "hold 5 s"), leak_time=60.0)
    at = dict(zip(record.time.round(9), record.vacuum, strict=True))
    assert at[40.0] == 80e3
    assert at[29.7] == pytest.approx(leaked(29.7, 50e3, 60.0)[0], rel=1e-9)
    assert record.vacuum[record.time < 60].min() == pytest.approx(
        leaked(30.0, 50e3, 60.0)[0], rel=1e-9
    )
    assert leaked(20.0, 80e3, 60.0)[0] == pytest.approx(
        record.vacuum[np.flatnonzero(record.vacuum > 0)[-1]], rel=1e-9
    )
    assert record.vacuum[-1] == 0.0


def test_without_leak_and_share_all_is_bit_for_bit_as_before():
    procedure = parse_procedure("evacuate to 94.5 kPa; pull at 13 mm/s until 20 mm; hold 9 s")
    plain, slow = (tensile(FILE, procedure, leak_time=t) for t in (None, 1e7))
    assert len(slow.time) > len(plain.time)
    assert slow.force[-1] == pytest.approx(plain.force[-1], rel=1e-5)
    whole = replace(KAPTON, vacuum_share=1.0)
    slips = np.linspace(0, 0.06, 9)
    for law in (friction.sheet_friction, pull.brake_force):
        assert np.array_equal(law(slips, FULL, whole), law(slips, FULL, KAPTON))


@pytest.mark.slow
def test_a_drop_with_a_leak_is_the_drop_under_that_history():
    case = {"mass": 1.0, "speed": 2.5}
    for leak_time, held in ((0.5, 0.1), (300.0, 60.0)):
        made = lj.drop(
            FILE, vacuum=FULL, leak_time=leak_time, held=held, rope_stiffness=16.8e3, **case
        )
        time = np.linspace(0, held + 0.1, 2048)
        history = History(time - held, leaked(time, FULL, leak_time))
        timed, _ = drop_in_time(FILE, vacuum=history, rope_stiffness=16.8e3, **case)
        assert made.slip == pytest.approx(timed.slip, rel=3e-6)
        assert made.peak_force == pytest.approx(timed.peak_force, rel=3e-6)
        assert made.vacuum == pytest.approx(leaked(held, FULL, leak_time)[0], rel=1e-6)


@settings(max_examples=10)
@given(seeds)
def test_the_share_presses_the_sheets_and_not_the_enclosure(seed):
    brakes = random_brakes(seed, 50, exponent=True, spacers=True)
    share = np.random.default_rng(seed).uniform(0.05, 1, 50)
    partly, (slip, vacuum) = change(brakes, vacuum_share=share), points(seed, brakes)
    # the same sheets under the share of the vacuum, the same enclosure under all of it
    sheets = friction.sheet_friction(slip, share * vacuum, brakes)
    np.testing.assert_allclose(friction.sheet_friction(slip, vacuum, partly), sheets, rtol=1e-12)
    np.testing.assert_allclose(
        friction.holding_force(vacuum, partly),
        friction.holding_force(share * vacuum, brakes),
        rtol=1e-12,
    )
    whole = sheets + enclosure_force(slip, vacuum, brakes)
    np.testing.assert_allclose(pull.brake_force(slip, vacuum, partly), whole, rtol=1e-12)


def test_a_wet_brake_is_pressed_by_the_share_too():
    film = next(iter(ILLUSTRATIVE.values())) if isinstance(ILLUSTRATIVE, dict) else ILLUSTRATIVE
    fanned = change(KAPTON, mount__spacers=False)
    for brake in (KAPTON, fanned):
        here = wet_force(0.01, 0.02, FULL, replace(brake, vacuum_share=0.6), film)
        less = wet_force(0.01, 0.02, 0.6 * FULL, brake, film)
        more = enclosure_force(0.01, FULL, brake) - enclosure_force(0.01, 0.6 * FULL, brake)
        assert float(here) == pytest.approx(float(less + more), rel=1e-12)


@pytest.mark.slow
def test_the_commands_take_the_share_and_the_gauge_reads_the_vacuum():
    share, bare = 0.7, change(KAPTON, enclosure__modulus=1e3, stiffness_measured=1e9)
    made = lj.tensile(bare, vacuum=FULL, speed=0.01, travel=0.02, vacuum_share=share)
    cut = 0.875 * 0.24 * 10 * 13e-3 * FULL * share
    assert made.peak_force == pytest.approx(cut * 0.068, rel=1e-4)
    assert np.all(made.record.vacuum == FULL)
    assert made.record.brake.brake.vacuum_share == share
    partly = replace(bare, vacuum_share=share)
    np.testing.assert_allclose(
        make_stack(partly, FULL).friction, share * make_stack(bare, FULL).friction, rtol=1e-12
    )
    # a mass on a stiff brake: m v^2/2 = c (L2 d - d^2/2) + 2/3 e d^(3/2) - m g d
    stop = lj.drop(bare, mass=1.0, speed=2.5, vacuum=FULL, vacuum_share=share)
    faces = 2 * math.sqrt(1e3 * 1e-3 * FULL * 0.8) * 13e-3

    def left(d):
        work = cut * (0.068 * d - d * d / 2) + 2 / 3 * faces * d**1.5
        return 3.125 - work + 9.80665 * d

    assert stop.slip == pytest.approx(brentq(left, 0, 0.05), rel=1e-4)
    assert stop.vacuum == FULL


def test_a_plan_waits_behind_its_leak_and_needs_the_share_more():
    case = Arrival(mass=1.0, speed=2.5, warning=3.0, travel=0.04, gravity=9.80665)
    line = lj.load_line("choi2018")
    leaky = _add_leak(line, 10.0, water=False).line
    partly = replace(FILE, brake=replace(KAPTON, vacuum_share=0.98))
    needed = needed_vacuum(KAPTON, case)
    made = plan_stop(partly, leaky, case)
    pump, volume = line.line.pump, line.line.chamber.volume

    def filling(_, p):
        pumped = pump.flow * pump.count / volume * (p - pump.ultimate)
        return -pumped + (A * A - p * p) / (2 * A * 10.0)

    filled = solve_ivp(filling, (0, 3.0), [A], "DOP853", rtol=1e-11, atol=1e-3)
    assert made.reached == pytest.approx(A - filled.y[0, -1], rel=1e-7)
    # what the sheets lose is made up for, and the enclosure takes over some of it
    assert needed < made.needed < needed / 0.98


@pytest.mark.slow
def test_shut_off_at_the_taut_rope_the_vacuum_leaks_away_during_the_stop():
    case = Arrival(mass=1.0, speed=2.5, warning=3.0, travel=0.04, gravity=9.80665)
    leaky = _add_leak(lj.load_line("choi2018"), 10.0, water=False).line
    made = plan_stop(FILE, leaky, case, leaks=True)
    stopped = made.tuned.coupled
    time = stopped.timed.time
    left = leaked(time, made.tuned.vacuum, 10.0)[0] - made.tuned.vacuum
    assert stopped.vacuum_change == pytest.approx(left, rel=1e-4)
    assert stopped.slip_change > 0


@pytest.mark.parametrize(
    "call",
    [
        lambda: lj.drop(FILE, mass=1, speed=2, vacuum=FULL, held=3),
        lambda: lj.drop(FILE, mass=1, speed=2, vacuum=FULL, leak_time=0),
        lambda: lj.drop(FILE, mass=1, speed=2, vacuum=FULL, vacuum_share=1.2),
        lambda: lj.drop(FILE, mass=1, speed=2, vacuum_history=History([0, 1], [1, 2]), leak_time=3),
        lambda: lj.drop(FILE, mass=1, speed=2, no_brake=True, rope_stiffness=1e4, leak_time=3),
        lambda: lj.tensile(FILE, vacuum=FULL, speed=0.01, travel=0.02, model="stack", leak_time=9),
        lambda: lj.plan(
            "choi2018", FILE, mass=1, speed=2, warning=3, travel=0.04, fluid="water", leak_time=9
        ),
        lambda: lj.plan(
            lj.load_line("choi2018").line.with_(laminar="1e-8 m^3/s"),
            FILE,
            mass=1,
            speed=2,
            warning=3,
            travel=0.04,
            leak_time=9,
        ),
    ],
)
def test_what_contradicts_itself_is_refused(call):
    with pytest.raises(LayerjamError) as said:
        call()
    assert isinstance(said.value, QuantityError)
