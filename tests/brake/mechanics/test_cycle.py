"""The brake under a moving crosshead: monotonic pulls, tension only, slack, energy of games."""

from __future__ import annotations

import itertools
from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.optimize import brentq

from counts import cases
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.energy import pull_work
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.limits import self_closing_vacuum
from layerjam.brake.mechanics.memory import DEPTH
from layerjam.brake.mechanics.pull import slip_at_elongation
from strategies import KAPTON, PTFE, area, change, fine, padded, random_brakes

FULL = 94.5e3
K = KAPTON.stiffness_measured


def run(elongation, vacuum, brake=KAPTON):
    elongation, vacuum, n = padded(elongation, vacuum)
    return jax.tree.map(lambda v: np.asarray(v)[:n], brake_cycle(elongation, vacuum, brake))


@pytest.mark.parametrize("vacuum", [0.0, 700.0, FULL])
@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_monotonic_pull_is_the_closed_form(vacuum, brake):
    u = np.linspace(0, 0.05, 51)
    made = run(u, vacuum, brake)
    slip = np.asarray(slip_at_elongation(u, vacuum, brake))
    assert made.slip == pytest.approx(slip, rel=1e-11, abs=1e-15)
    assert made.force == pytest.approx(brake.stiffness_measured * (u - slip), rel=1e-9, abs=1e-9)
    assert made.work == pytest.approx(np.asarray(pull_work(u, vacuum, brake)), rel=1e-9)
    assert not made.slack.any() and not made.overflow.any() and not made.snapped.any()
    sleeve = np.asarray(enclosure_force(made.slip, vacuum, brake))
    assert made.sleeve_force == pytest.approx(sleeve, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize(
    "vacuum",
    [0.0, 1.0, 700.0, FULL],
)
def test_a_pull_that_only_goes_out_never_closes(vacuum):
    assert not run(np.linspace(0, 0.05, 51), vacuum).closed.any()


def test_stuck_below_the_friction_and_elastic():
    onset = float(sheet_friction(0.0, FULL, KAPTON)) / K
    made = run(np.array([0.5, 0.9, 0.999, 0.2, 0.0]) * onset, FULL)
    assert (made.slip == 0).all()
    assert made.heat == pytest.approx(np.zeros(5), abs=1e-16)
    assert made.force == pytest.approx(np.array([0.5, 0.9, 0.999, 0.2, 0.0]) * onset * K)
    assert made.work == pytest.approx(made.force**2 / 2 / K, abs=1e-16)
    assert made.stored == pytest.approx(made.work, abs=1e-16)


def test_sticks_on_reversal_then_goes_slack_with_slip_frozen():
    """Tension only: at full vacuum friction holds the sleeve, the slip stays bit for bit."""
    made = run([0.04, 0.0397, 0.0385, 0.0, 0.039, 0.04], FULL)
    slip = made.slip[0]
    assert (made.slip[1:5] == slip).all()
    assert made.force[1] == pytest.approx(K * (0.0397 - slip), rel=1e-12)
    assert made.force[2] == 0 and made.force[3] == 0
    assert list(made.slack) == [False, False, True, True, True, False]
    assert not made.closed.any()
    assert made.force[5] == pytest.approx(made.force[0], rel=1e-12)
    assert made.heat[5] == pytest.approx(made.heat[0], rel=1e-12)


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_unloaded_brake_closes_below_the_self_closing_vacuum_only(brake):
    """Loaded to slip 40 mm, then slack: closes on its own where F_e > F_f."""
    limit = float(self_closing_vacuum(0.04, brake))
    for vacuum, closes in ((limit * 0.97, True), (limit * 1.03, False)):
        k = brake.stiffness_measured
        friction = float(sheet_friction(0.04, vacuum, brake))
        u = 0.04 + (friction + float(enclosure_force(0.04, vacuum, brake))) / k
        made = run([u, 0.0], vacuum, brake)
        assert made.slip[0] == pytest.approx(0.04, rel=1e-9)
        assert bool(made.closed[1]) is closes
        assert bool(made.slip[1] < 0.04 * (1 - 1e-9)) is closes
        assert made.force[1] == 0 and bool(made.slack[1])
        if closes:
            held = float(sheet_friction(made.slip[1], vacuum, brake))
            assert made.sleeve_force[1] == pytest.approx(held, rel=1e-9)


def test_slides_back_under_tension_where_spring_balances_sleeve_less_friction():
    vacuum, u0, u1 = 200.0, 0.05, 0.03
    made = run([u0, u1], vacuum)
    top = made.slip[0]
    first = float(enclosure_force(top, vacuum, KAPTON))

    def residual(x):
        sleeve = first - 2 * float(enclosure_force((top - x) / 2, vacuum, KAPTON))
        return K * (u1 - x) - sleeve + float(sheet_friction(x, vacuum, KAPTON))

    assert residual(u1) < 0 < residual(0.0)
    x = brentq(residual, 0, top, xtol=1e-16)
    assert made.slip[1] == pytest.approx(x, rel=1e-8)
    assert bool(made.closed[1]) and made.force[1] == pytest.approx(K * (u1 - x), rel=1e-5)


def test_no_vacuum_is_a_spring_that_keeps_nothing():
    made = run(fine(0, 0.05, 0.0), 0.0)
    assert made.heat == pytest.approx(np.zeros(len(made.heat)), abs=1e-12)
    assert made.slip[-1] == pytest.approx(0, abs=1e-12)
    assert made.stored[-1] == pytest.approx(0, abs=1e-12)


def test_separates_once_the_overlap_is_used_up():
    made = run([0.06, 0.3], FULL)
    assert list(made.separated) == [False, True]


def test_brake_softer_than_its_friction_snaps_and_is_not_answered():
    soft = change(KAPTON, stiffness_measured=2000.0)
    made = run([0.0, 0.08, 0.09, 0.02], FULL, soft)
    assert list(np.isnan(made.force)) == list(made.snapped) == [False, False, True, True]
    assert made.force[1] == pytest.approx(160.0, rel=1e-12)
    assert np.isfinite(run([0.0, 0.08, 0.09, 0.02], 7e4, soft).force).all()


@pytest.mark.parametrize(("u", "vacuum"), [([0.01, -0.01], 1e4), ([0.01, 0.02], [1e4, -1.0])])
def test_outside_the_domain_is_nan(u, vacuum):
    force = run(u, np.broadcast_to(vacuum, 2)).force
    assert np.isfinite(force[0]) and np.isnan(force[1])


def test_too_many_nested_turns_are_reported():
    n = 2 * DEPTH + 6
    ends = 0.03 + 0.0025 * 0.95 ** np.arange(n) * (-1.0) ** np.arange(n)
    made = run(ends, 200.0)  # no loop in which the whole strip slides: that would forget the others
    assert made.overflow[-1] and np.isnan(made.force[-1]) and not made.overflow[n // 2]


def test_lowered_vacuum_lets_a_stretched_brake_slip_at_a_fixed_crosshead():
    """No work is done; what rig and sleeve give up is heat; force ends on the new law."""
    made = run([0.04, 0.04, 0.04], np.array([FULL, 3e4, 0.0]))
    assert made.work == pytest.approx(np.full(3, made.work[0]), rel=1e-13)
    assert (np.diff(made.heat) > 0).all() and (np.diff(made.slip) > 0).all()
    assert made.stored + made.heat == pytest.approx(made.work, rel=1e-12)
    for i, vacuum in ((1, 3e4), (2, 0.0)):
        friction = float(sheet_friction(made.slip[i], vacuum, KAPTON))
        assert made.force[i] == pytest.approx(friction + made.sleeve_force[i], rel=1e-9)


def test_raised_vacuum_holds():
    made = run([0.03, 0.03, 0.0305], np.array([1e4, 9e4, 9e4]))
    assert made.slip[1] == made.slip[0] and made.force[1] == made.force[0]
    assert made.slip[2] == made.slip[0]
    assert made.force[2] == pytest.approx(made.force[1] + K * 0.0005, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_work_is_the_integral_of_force_on_random_paths(seed):
    rng = np.random.default_rng(seed)
    brake = [KAPTON, PTFE][seed % 2]
    vacuum = [1e3, 4e3, 1e4, 9e4, 300.0][seed]
    turns = np.concatenate([[0.0], rng.uniform(0, 0.06, 8)])
    dense = np.linspace(0, 1, 500) ** 2
    legs = [a + (b - a) * dense[1:] for a, b in itertools.pairwise(turns)]
    u = np.concatenate([[0.0], *legs])
    made = run(u, vacuum, brake)
    work = area(made.force, u)
    assert made.work == pytest.approx(work, abs=2e-4 * work.max())
    assert made.stored + made.heat == pytest.approx(made.work, rel=1e-9, abs=1e-13)
    coarse = run(turns, vacuum, brake)
    assert made.work[:: len(dense) - 1] == pytest.approx(coarse.work, rel=1e-8, abs=1e-12)
    assert made.slip[:: len(dense) - 1] == pytest.approx(coarse.slip, rel=1e-8, abs=1e-13)
    assert (np.diff(made.heat) >= -1e-14).all()


played = jax.jit(jax.vmap(brake_cycle))


def games(seed: int, n: int, steps: int):
    """Random crosshead and vacuum histories for n random brakes, all let go at the end."""
    rng = np.random.default_rng(seed)
    brakes = random_brakes(seed, n)
    u = rng.uniform(0, 1, (n, steps)) ** 2 * brakes.sheets.overlap[:, None]
    vacuum = brakes.site.atmosphere[:, None] * rng.uniform(0, 1, (n, steps)) ** 5
    vacuum = vacuum * (rng.uniform(size=(n, steps)) > 0.15)
    for i in range(1, steps):
        still = rng.uniform(size=n) < 0.4
        u[:, i] = np.where(still, u[:, i - 1], u[:, i])
        vacuum[:, i] = np.where(still, vacuum[:, i], vacuum[:, i - 1])
    u[:, -2:], vacuum[:, -1] = 0, 0
    return brakes, u, vacuum


def check_games(seed: int, n: int, steps: int) -> None:
    brakes, u, vacuum = games(seed, n, steps)
    made = jax.tree.map(np.asarray, played(u, vacuum, brakes))
    good = ~made.separated.any(axis=1) & ~made.overflow.any(axis=1)
    size = made.work.max(axis=1)[good][:, None] + 1e-15
    work, heat, stored = (v[good] / size for v in (made.work, made.heat, made.stored))
    assert good.mean() > 0.5
    assert np.isfinite(made.force[good]).all() and (made.force[good] >= 0).all()
    assert (made.slip[good] >= 0).all()
    assert (np.diff(heat, axis=1) >= -1e-10).all() and (stored >= -1e-10).all()
    assert work == pytest.approx(heat + stored, abs=1e-9)
    assert (work[:, -1] >= -1e-10).all() and (work >= stored - 1e-10).all()
    assert made.stored[good][:, -1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("vacuum", [300.0, 1e3])
def test_without_vacuum_nothing_holds_an_unloaded_brake_open(vacuum):
    """Pulled, let go (it closes a little), pumped down to nothing: silicone springs back."""
    made = run([0.04, 0.0, 0.0], np.array([vacuum, vacuum, 0.0]))
    assert made.slip[2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("vacuum", [9e4, 2e4])
def test_held_open_by_full_vacuum_then_vented_it_closes(vacuum):
    made = run([0.04, 0.0, 0.0], np.array([vacuum, vacuum, 0.0]))
    assert made.slip[1] == made.slip[0] and made.slip[2] == pytest.approx(0, abs=1e-12)
    assert bool(made.closed[2]) and not bool(made.closed[1])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(cases(2, 1)))
def test_games_with_crosshead_and_pump_win_nothing(seed):
    check_games(seed, 400, 24)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(10, 10 + cases(10, 1)))
def test_long_games_win_nothing(seed):
    check_games(seed, cases(3000, 500), 60)


@pytest.mark.parametrize("seed", range(3))
def test_area_under_the_force_agrees_with_the_books_in_pump_games(seed):
    """Work recomputed from force and crosshead alone, vacuum changed at standstill."""
    rng = np.random.default_rng(100 + seed)
    turns = np.concatenate([[0.0], rng.uniform(0, 0.06, 7), [0.0]])
    dense = np.sort(np.concatenate([np.linspace(0, 1, 250), np.linspace(0, 1, 250) ** 3]))
    pressures = 1e5 * rng.uniform(0, 1, len(turns) - 1) ** 4
    u, vacuum = [np.zeros(1)], [pressures[:1]]
    for a, b, p in zip(turns, turns[1:], pressures, strict=False):
        u.append(a + (b - a) * dense)
        vacuum.append(np.full(len(dense), p))
    u, vacuum = np.concatenate(u), np.concatenate(vacuum)
    made = run(u, vacuum)
    work = area(made.force, u)
    assert made.work == pytest.approx(work, abs=3e-4 * work.max())
    assert work[-1] >= 0


@pytest.mark.parametrize("vacuum", [500.0, 3335.0, 94.5e3])
def test_the_sheets_are_apart_once_the_slip_is_the_overlap_to_rounding(vacuum):
    overlap = KAPTON.sheets.overlap
    apart = overlap + float(enclosure_force(overlap, vacuum, KAPTON)) / K
    made = run([apart * (1 - 1e-9), apart], vacuum)
    assert made.separated.tolist() == [False, True]
    assert made.force[1] == pytest.approx(made.sleeve_force[1], rel=1e-9)


def test_vented_under_tension_it_slides_back_to_where_spring_and_friction_hold_the_sleeve():
    """A sleeve that slid back as a whole and goes on doing so, by many small steps."""
    vacuum = np.concatenate([[9e4, 9e4], np.full(20, 60.0), np.linspace(60.0, 5.0, 20)])
    u = np.concatenate([[0.05, 0.04], np.linspace(0.04, 0.02, 20), np.full(20, 0.02)])
    made = run(u, vacuum)
    back = np.flatnonzero(np.diff(made.slip) < -1e-9) + 1
    assert len(back) > 10
    friction = np.asarray(sheet_friction(made.slip, vacuum, KAPTON))
    rest = made.sleeve_force - made.force - friction
    np.testing.assert_allclose(rest[back], 0.0, atol=1e-8)
    assert (made.slip[back] > 0).all()


BY_SPEED = replace(KAPTON, speed_law=SpeedLaw(power=0.05, test_speed=1e-3, rest_speed=1e-5))
RUBBER = replace(KAPTON, hyperelastic=Hyperelastic(strain=12.0, c10=11e3, c20=300.0))


@pytest.mark.parametrize(
    ("brake", "speed"),
    [
        (KAPTON, None),
        pytest.param(RUBBER, None, marks=pytest.mark.slow),
        pytest.param(BY_SPEED, 2e-3, marks=pytest.mark.slow),
    ],
    ids=["plain", "rubber", "speed law"],
)
def test_one_vacuum_is_a_history_of_that_vacuum(brake, speed):
    """A number has a program of its own, without changes of vacuum."""
    u = np.concatenate([np.linspace(0, 0.02, 31), np.linspace(0.02, 0, 31), [-1e-3, 0.01]])
    one = brake_cycle(u, 60e3, brake, speed)
    many = brake_cycle(u, np.full_like(u, 60e3), brake, speed)
    assert np.isfinite(one.force).sum() == len(u) - 1  # a negative elongation has no force
    for a, b in zip(one, many, strict=True):
        np.testing.assert_allclose(np.asarray(a), np.asarray(b), rtol=1e-12, atol=1e-15)


def test_swinging_while_it_sticks_is_not_remembered():
    """Fifty times up and down below the friction: no turn of the sleeve, nothing overflows."""
    u = np.concatenate([[0.02], np.tile([0.0196, 0.0199], 50), [0.021]])
    made = run(u, FULL)
    assert not made.overflow.any()
    assert np.ptp(made.slip[:-1]) == 0.0
    assert made.slip[-1] == pytest.approx(float(slip_at_elongation(0.021, FULL, KAPTON)), rel=1e-9)


@pytest.mark.campaign
def test_one_history_at_a_time_and_many_at_once_agree_to_a_millionth():
    """Random walks in steps of a tenth of the travel, the vacuum anew at every step.

    Half of them on a grid: loops close and vacuums return exactly. No law may hang on a tie.
    """
    travel, steps, count = 0.06, 96, cases(1500, 300)
    rng = np.random.default_rng(7)
    walks = np.cumsum(rng.uniform(-travel / 10, travel / 10, (count, steps)), axis=1)
    path, vacuum = np.abs(walks) % travel, FULL * rng.uniform(size=(count, steps))
    path[::2], vacuum[::2] = np.round(path[::2], 3), np.round(vacuum[::2], -4)
    one = jax.jit(lambda u, p: brake_cycle(u, p, KAPTON).force)
    many = np.asarray(jax.jit(jax.vmap(lambda u, p: brake_cycle(u, p, KAPTON).force))(path, vacuum))
    alone = np.array([np.asarray(one(u, p)) for u, p in zip(path, vacuum, strict=True)])
    assert np.isfinite(many).all()
    assert np.abs(many - alone).max() <= 1e-6
