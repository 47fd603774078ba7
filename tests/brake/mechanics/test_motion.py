"""A mass on rope and brake marched in time: against the exact stop, SciPy, and the energy."""

from __future__ import annotations

import dataclasses
import inspect

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    SNAPS,
    STOPPED,
    stop,
    time_at_slip,
)
from layerjam.brake.mechanics.stop.motion import (
    CLOSED,
    LONGEST,
    MOVING,
    NOT_A_CASE,
    SNAPPED,
    STANDSTILL,
    TRAVEL_USED,
    make_load,
    stop_in_time,
    stored_energy,
)
from strategies import KAPTON, random_brakes, unchecked

G, ROPE, FULL = 9.80665, 16.8e3, 94.5e3
SPRING = 1 / (1 / 131e3 + 1 / ROPE)
MANY = 400_000


def audit(run, mass, speed, gravity, rope, damping, brake):
    """What is missing in the books [J], as a part of all the energy that came in."""
    load = make_load(mass, gravity, rope, damping, brake)
    came = mass * speed**2 / 2 + mass * gravity * np.asarray(run.place)
    there = mass * np.asarray(run.speed) ** 2 / 2 + np.asarray(run.heat)
    return (there + np.asarray(stored_energy(run, load, brake)) - came) / came


def one_by_one(cases, damping, step):
    """Drops (mass, speed, vacuum) on the rope, one after the other: all compile as one does."""
    runs = [stop_in_time(*c, None, ROPE, damping, G, step, MANY, KAPTON) for c in cases]
    return jax.tree.map(lambda *parts: np.array(parts), *runs)


def in_numpy(*case):
    """The march without a compiled program, which a few hundred steps are not worth."""
    with np.errstate(all="ignore"):
        return inspect.unwrap(stop_in_time)(*jax.tree.map(np.float64, case))


COARSE = pytest.param(in_numpy, 10, id="numpy")
FINE = pytest.param(stop_in_time, 1, id="compiled", marks=pytest.mark.slow)
"""A solver, and how many times longer its steps are."""


@pytest.mark.parametrize("step", [1e-4, 2e-5])
def test_it_is_the_exact_stop_at_constant_vacuum_at_any_step(step):
    mass = np.array([1.0, 1.0, 1.0, 1.0, 12.0, 0.3])
    speed = np.array([2.5, 3.0, 3.7, 0.2, 0.2, 5.0])
    vacuum = np.array([94.5e3, 80e3, 94.5e3, 94.5e3, 94.5e3, 60e3])
    exact = stop(mass, speed, vacuum, SPRING, G, KAPTON)
    run = one_by_one(zip(mass, speed, vacuum, strict=True), None, step)
    assert np.abs(run.slip - exact.slip).max() < 1e-8 * KAPTON.sheets.usable_travel
    np.testing.assert_allclose(run.peak, exact.peak_force, rtol=1e-9)
    np.testing.assert_allclose(run.speed, exact.end_speed, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(run.heat, exact.heat, rtol=1e-9, atol=1e-12)
    codes = {STOPPED: STANDSTILL, NEVER_SLID: STANDSTILL, BOTTOMED_OUT: TRAVEL_USED}
    assert [codes[int(c)] for c in exact.outcome] == np.asarray(run.outcome).tolist()
    assert np.abs(audit(run, mass, speed, G, ROPE, None, KAPTON)).max() < 1e-9


@pytest.mark.parametrize(("march", "longer"), [COARSE, FINE])
def test_random_brakes_stop_where_the_exact_stop_says(march, longer):
    random, brakes, n = np.random.default_rng(3), random_brakes(8, 300), 300
    k = np.asarray(working_stiffness(brakes))
    vacuum, mass = random.uniform(2e4, 1e5, n), random.uniform(0.1, 5.0, n)
    speed = random.uniform(0.1, 3.0, n)
    exact = stop(mass, speed, vacuum, k, G, brakes)
    step = longer * np.sqrt(mass / k) / 100
    run = march(mass, speed, vacuum, None, None, None, G, step, MANY, brakes)
    # a sleeve that closes the brake ends the run; a spring softer than the brake snaps sooner
    there = (np.asarray(exact.outcome) != SNAPS) & ~np.isin(run.outcome, (CLOSED, SNAPPED))
    off = np.abs(np.asarray(run.slip - exact.slip)) / brakes.sheets.usable_travel
    assert there.sum() > 200
    assert off[there].max() < 1e-8
    books = np.abs(audit(run, mass, speed, G, None, None, brakes))
    assert books[there].max() < 1e-9


def _errors(values: list[float]) -> np.ndarray:
    return np.abs(np.diff(np.array(values)))


def test_time_is_of_second_order():
    exact = stop(1.0, 2.5, FULL, SPRING, G, KAPTON)
    time = float(time_at_slip(exact.slip, 1.0, 2.5, FULL, SPRING, G, KAPTON))
    off = [
        float(stop_in_time(1.0, 2.5, FULL, None, ROPE, None, G, h, MANY, KAPTON).time) - time
        for h in (1.6e-4, 8e-5, 4e-5)
    ]
    assert abs(off[0]) < 2e-6 * time * 10
    np.testing.assert_allclose(np.log2(np.divide(off[:-1], off[1:])), 2.0, atol=0.2)


@pytest.mark.parametrize("damping", [10.0, 60.0, 300.0])
def test_a_damped_rope_is_of_second_order_and_keeps_its_books(damping):
    slips = []
    for h in (4e-5, 2e-5, 1e-5, 5e-6):
        run = stop_in_time(1.0, 2.5, FULL, None, ROPE, damping, G, h, MANY, KAPTON)
        assert int(run.outcome) == STANDSTILL
        assert abs(audit(run, 1.0, 2.5, G, ROPE, damping, KAPTON)) < 1e-9
        slips.append(float(run.slip))
    order = np.log2(_errors(slips)[:-1] / _errors(slips)[1:])
    assert order.mean() == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize(("march", "longer"), [COARSE, FINE])
@pytest.mark.parametrize("damping", [None, 60.0])
def test_friction_over_speed_keeps_its_books(damping, march, longer):
    law = SpeedLaw(power=0.2, test_speed=1e-2, rest_speed=1e-4)
    brake = dataclasses.replace(KAPTON, speed_law=law)
    run = march(1.0, 2.5, FULL, None, ROPE, damping, G, 4e-5 * longer, MANY, brake)
    assert int(run.outcome) == STANDSTILL
    assert abs(audit(run, 1.0, 2.5, G, ROPE, damping, brake)) < 1e-9


def _standstill(_: float, y: np.ndarray) -> float:
    return y[1]


_standstill.terminal = True
_standstill.direction = -1


@pytest.mark.parametrize("damping", [20.0, 100.0])
def test_a_damped_rope_agrees_with_scipy(damping):
    """State: place and speed of the mass, elongation of the brake (stuck), then its slip."""
    own = float(working_stiffness(KAPTON))
    onset = float(brake_force(0.0, FULL, KAPTON))

    def stuck(_, y):
        z, v, u = y
        drawn = ((ROPE * (z - u) - own * u) / damping) + v
        return [v, G - own * u, drawn]

    def slides(_, y):
        return own * y[2] - onset

    slides.terminal = True
    first = solve_ivp(stuck, (0, 1), [0, 2.5, 0], events=[slides], rtol=1e-11, atol=1e-13,
                      method="Radau")  # fmt: skip
    c = (onset - float(brake_force(0.02, FULL, _without_enclosure()))) / 0.02
    e = (float(brake_force(0.01, FULL, KAPTON)) - (onset - c * 0.01)) / np.sqrt(0.01)

    def rests(_, y):
        # on a rope that damps much the force falls, and the slip ends, before the mass stands
        return sliding(0.0, y)[2]

    rests.terminal, rests.direction = True, -1

    def sliding(_, y):
        z, v, w = y  # w = sqrt(slip), which takes out the steep start
        w = max(w, 0.0)
        force = onset - c * w * w + e * w
        u = w * w + force / own
        drawn = (ROPE * (z - u) - force) / damping + v
        return [v, G - force / 1.0, drawn / (2 * w * (1 - c / own) + e / own)]

    z, v, _ = first.y[:, -1]
    second = solve_ivp(sliding, (0, 1), [z, v, 0.0], events=[_standstill, rests], rtol=1e-10,
                       atol=1e-12, method="Radau")  # fmt: skip
    slip = float(second.y[2, -1]) ** 2
    run = stop_in_time(1.0, 2.5, FULL, None, ROPE, damping, G, 4e-6, MANY, KAPTON)
    assert float(run.slip) == pytest.approx(slip, rel=1e-6)
    if len(second.t_events[1]) == 0:
        assert float(run.time) == pytest.approx(float(first.t[-1] + second.t[-1]), rel=1e-6)
    else:
        assert float(run.time) > float(first.t[-1] + second.t[-1])


def _without_enclosure():
    return unchecked(KAPTON, enclosure=unchecked(KAPTON.enclosure, modulus=1e-12))


def test_little_damping_is_none():
    free = stop_in_time(1.0, 2.5, FULL, None, ROPE, None, G, 1e-5, MANY, KAPTON)
    case = (1.0, 2.5, FULL)
    less = [float(one_by_one([case], damping, 5e-6).slip[0]) for damping in (1.0, 0.5)]
    off = np.array(less) - float(free.slip)
    assert (off < 0).all()
    assert off[0] == pytest.approx(2 * off[1], rel=0.02)


TIMES = np.array([0.0, 0.01, 0.06])


@pytest.mark.slow
def test_a_history_that_does_not_change_is_the_constant_vacuum():
    samples = np.full(3, FULL)
    one = stop_in_time(1.0, 2.5, samples, TIMES, ROPE, None, G, 1e-4, MANY, KAPTON)
    exact = stop(1.0, 2.5, FULL, SPRING, G, KAPTON)
    assert float(one.slip) == pytest.approx(float(exact.slip), abs=1e-8 * 0.06)


@pytest.mark.slow
def test_a_falling_vacuum_is_of_second_order_and_keeps_its_books():
    samples, slips = np.array([94.5e3, 94.5e3, 40e3]), []
    for h in (4e-5, 2e-5, 1e-5, 5e-6):
        run = stop_in_time(1.0, 2.5, samples, TIMES, ROPE, None, G, h, MANY, KAPTON)
        assert abs(audit(run, 1.0, 2.5, G, ROPE, None, KAPTON)) < 1e-9
        slips.append(float(run.slip))
    np.testing.assert_allclose(np.log2(_errors(slips)[:-1] / _errors(slips)[1:]), 2.0, atol=0.2)
    assert slips[-1] > float(stop(1.0, 2.5, FULL, SPRING, G, KAPTON).slip)


@pytest.mark.slow
def test_a_rising_vacuum_lies_between_its_ends_and_keeps_its_books():
    samples = np.array([60e3, 60e3, 94.5e3])
    ends = stop(1.0, 2.5, np.array([94.5e3, 60e3]), SPRING, G, KAPTON).slip
    slips = []
    for h in (2e-5, 1e-5, 5e-6):
        run = stop_in_time(1.0, 2.5, samples, TIMES, ROPE, None, G, h, MANY, KAPTON)
        assert float(ends[0]) < float(run.slip) < float(ends[1])
        assert abs(audit(run, 1.0, 2.5, G, ROPE, None, KAPTON)) < 1e-9
        slips.append(float(run.slip))
    assert _errors(slips)[-1] < 1e-5 * slips[-1]


@pytest.mark.slow
def test_one_that_falls_in_no_time_is_a_lower_vacuum_from_the_start():
    samples, times = np.array([94.5e3, 60e3, 60e3]), np.array([0.0, 1e-9, 1.0])
    run = stop_in_time(1.0, 2.5, samples, times, ROPE, None, G, 1e-6, MANY, KAPTON)
    exact = stop(1.0, 2.5, 60e3, SPRING, G, KAPTON)
    assert float(run.slip) == pytest.approx(float(exact.slip), rel=1e-9)


def test_heat_is_what_friction_and_damper_took():
    """Against force times slip, summed over a run in small steps by the trapezoid rule."""
    damping, step, place = 60.0, 2e-5, []
    for count in range(0, 800, 10):
        run = stop_in_time(1.0, 2.5, FULL, None, ROPE, damping, G, step, count, KAPTON)
        place.append((float(run.slip), float(run.heat), float(run.stretch), float(run.time)))
    slip, heat, stretch, time = np.array(place).T
    fine = np.linspace(0, slip[-1], 20001)
    held = np.asarray(brake_force(fine, FULL, KAPTON))
    work = np.concatenate([[0], np.cumsum((held[1:] + held[:-1]) / 2 * np.diff(fine))])
    from layerjam.brake.mechanics.enclosure import enclosure_law

    sheets = np.interp(slip, fine, work) - np.asarray(
        enclosure_law(FULL, KAPTON).stored_energy(slip)
    )
    rate = np.gradient(stretch, time)
    rope = np.concatenate(
        [[0], np.cumsum(damping * (rate[1:] ** 2 + rate[:-1] ** 2) / 2 * np.diff(time))]
    )
    assert heat[-1] == pytest.approx(sheets[-1] + rope[-1], rel=0.02)


def test_too_soft_a_rope_snaps_and_too_few_steps_are_named():
    soft = stop_in_time(1.0, 5.0, FULL, None, 2.0e3, None, G, 1e-4, MANY, KAPTON)
    assert int(soft.outcome) == SNAPPED
    short = stop_in_time(1.0, 2.5, FULL, None, ROPE, None, G, 1e-5, 10, KAPTON)
    assert int(short.outcome) == MOVING
    assert float(short.time) == pytest.approx(1e-4)


@pytest.mark.parametrize(("march", "longer"), [COARSE, FINE])
def test_both_solvers_snap_at_the_same_slip_near_the_limit(march, longer):
    """Springs of 0.7 to 1.05 c: what the sleeve adds decides, and where it fades the brake goes."""
    random, n = np.random.default_rng(1), 300
    brakes, vacuum = random_brakes(11, n), random.uniform(2e4, 1e5, n)
    k = np.asarray(friction_per_contact(vacuum, brakes)) * random.uniform(0.7, 1.05, n)
    brakes = dataclasses.replace(brakes, stiffness_measured=k)
    mass, speed = random.uniform(0.1, 30, n), random.uniform(0.1, 3, n)
    exact = stop(mass, speed, vacuum, k, G, brakes)
    step = longer * np.sqrt(mass / k) / 100
    run = march(mass, speed, vacuum, None, None, None, G, step, MANY, brakes)
    code, there = np.asarray(exact.outcome), np.asarray(run.outcome)
    snaps = code == SNAPS
    assert 50 < snaps.sum() < 200
    held = there != CLOSED
    np.testing.assert_array_equal((there == SNAPPED)[held], snaps[held])
    off = np.abs(np.asarray(run.slip - exact.slip)) / brakes.sheets.usable_travel
    assert off[held].max() < 1e-6
    # the force falls there as fast as the spring gives, and the sleeve keeps a softer one
    slope = jax.vmap(jax.grad(brake_force))(exact.slip, vacuum, brakes)
    np.testing.assert_allclose(np.asarray(slope)[snaps], -k[snaps], rtol=1e-6)


def test_a_step_that_could_pass_over_the_standstill_is_no_case():
    runs = [one_by_one([(1.0, 2.5, FULL)], None, step) for step in (0.1, 1e-4)]
    assert [int(run.outcome[0]) for run in runs] == [NOT_A_CASE, STANDSTILL]
    assert np.isnan(runs[0].slip[0])
    longest = LONGEST * np.sqrt(1.0 / SPRING)
    run = stop_in_time(1.0, 2.5, FULL, None, ROPE, None, G, longest, MANY, KAPTON)
    assert float(run.slip) == pytest.approx(17.0251044e-3, abs=1e-10)


def test_a_weight_at_rest_stays_where_it_is_for_an_hour():
    """99.9 % of what the brake holds, hung on at rest: nothing creeps, at any step."""
    from layerjam.brake.mechanics.stop.motion import Load, Motion, Vacuum, advance_step, new_motion

    onset = float(brake_force(0.0, FULL, KAPTON))
    mass = 0.999 * onset / G
    force = mass * G

    @jax.jit
    def march(state: Motion, step: float, count: int, load: Load) -> Motion:
        def one(_, now):
            return advance_step(now, step, Vacuum(FULL), load, KAPTON)

        return jax.lax.fori_loop(0, count, one, state)

    for step, count in ((1.0, 3600), (1e-2, 20000)):
        start = new_motion(np.float64(0.0), np.float64(FULL), True)
        start = start._replace(
            place=np.float64(force / SPRING), drawn=np.float64(force / SPRING),
            force=np.float64(force),
        )  # fmt: skip
        load = Load(np.float64(mass), np.float64(G), np.float64(SPRING), None, None)

        last = march(jax.tree.map(np.asarray, start), step, count, load)
        assert float(last.slip) == 0.0
        assert float(last.heat) == 0.0
        assert float(last.place) == pytest.approx(force / SPRING, rel=1e-12)
        assert int(last.outcome) in (MOVING, STANDSTILL)


@jax.jit
def march_slack(state, step, load):
    """Whether the rope is slack, energy, heat and speed after each of 2500 steps."""
    from layerjam.brake.mechanics.stop.motion import Vacuum, try_step

    def one(state, _):
        new = try_step(state, step, Vacuum(FULL), load, KAPTON)[0]
        energy = load.mass * (new.speed**2 / 2 - load.gravity * new.place) + new.heat
        return new, (new.slack, energy + stored_energy(new, load, KAPTON), new.heat, new.speed)

    return jax.lax.scan(one, state, None, length=2500)[1]


@pytest.mark.parametrize("damping", [None, 10.0, 60.0])
def test_a_mass_that_flies_back_from_a_slack_rope_keeps_its_books(damping):
    """Thrown up from 50 N: what the damper takes is all that is lost."""
    from layerjam.brake.mechanics.stop.motion import new_motion

    mass, speed, force = 1.0, -0.8, 50.0
    load = make_load(mass, G, ROPE, damping, KAPTON)
    load = jax.tree.map(np.float64, load)
    stretch = 0.0 if damping is None else force / ROPE
    drawn = force / float(load.spring)
    start = new_motion(np.float64(speed), np.float64(FULL), True)._replace(
        place=np.float64(drawn + stretch), drawn=np.float64(drawn),
        stretch=np.float64(stretch), force=np.float64(force),
    )  # fmt: skip

    slack, energy, heat, velocity = march_slack(jax.tree.map(np.asarray, start), 1e-4, load)
    slack, heat, velocity = map(np.asarray, (slack, heat, velocity))
    begun = mass * speed**2 / 2 - mass * G * (drawn + stretch) + force**2 / 2 / SPRING
    np.testing.assert_allclose(energy, begun, atol=1e-9)
    assert (np.diff(heat) >= -1e-15).all()
    leaves, lands = np.flatnonzero(np.diff(slack.astype(int)))[:2]
    if damping is None:
        assert heat[lands + 1] == 0.0
        # without a damper it leaves and meets the rope at the same place, so equally fast
        assert (lands - leaves) * 1e-4 == pytest.approx(-2 * velocity[leaves + 1] / G, abs=2e-4)


@pytest.mark.campaign
def test_it_batches_by_broadcasting_and_by_vmap():
    speed, vacuum = np.array([2.0, 2.5, 3.0]), np.array([[70e3], [94.5e3]])
    whole = stop_in_time(1.0, speed, vacuum, None, ROPE, None, G, 5e-5, MANY, KAPTON)
    assert whole.slip.shape == (2, 3)

    def one(v, p):
        return stop_in_time(1.0, v, p, None, ROPE, None, G, 5e-5, MANY, KAPTON).slip

    each = jax.vmap(jax.vmap(one, (0, None)), (None, 0))(speed, vacuum[:, 0])
    np.testing.assert_allclose(each, whole.slip, rtol=1e-12)
    histories = np.array([[94.5e3, 94.5e3, 40e3], [60e3, 60e3, 60e3]])
    slips = jax.vmap(
        lambda h: stop_in_time(1.0, 2.5, h, TIMES, ROPE, None, G, 5e-5, MANY, KAPTON).slip
    )(histories)
    exact = stop(1.0, 2.5, 60e3, SPRING, G, KAPTON).slip
    assert float(slips[1]) == pytest.approx(float(exact), abs=1e-9)


def test_outside_its_domain_it_is_nan():
    bad = [(0.0, 1.0, FULL), (1.0, -1.0, FULL), (1.0, 1.0, -5.0)]
    for mass, speed, vacuum in bad:
        run = stop_in_time(mass, speed, vacuum, None, ROPE, None, G, 1e-4, 10, KAPTON)
        assert np.isnan(float(run.slip))
        assert int(run.outcome) == NOT_A_CASE
