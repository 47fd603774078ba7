"""Masing's rule with memory of turning points, and the energy of every sleeve history."""

from __future__ import annotations

import itertools

import jax
import numpy as np
import pytest

from counts import cases
from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_law, saturation_slip
from layerjam.brake.mechanics.energy import slip_heat, slip_work
from layerjam.brake.mechanics.memory import DEPTH, enclosure_cycle
from strategies import KAPTON, PTFE, area, change, fine, one, padded, random_brakes, with_fields_of

ALONE = change(KAPTON, film__kinetic=1e-12)


def cycle(slips, vacuum, brake=KAPTON):
    slips, vacuum, n = padded(slips, vacuum)
    return tuple(np.asarray(v)[:n] for v in enclosure_cycle(slips, vacuum, brake))


@pytest.mark.parametrize("vacuum", [0.0, 700.0, 94.5e3])
def test_first_loading_is_the_closed_form(vacuum):
    x = np.linspace(0, 0.06, 61)
    force, stored, heat = cycle(x, vacuum)
    assert force == pytest.approx(np.asarray(enclosure_force(x, vacuum, KAPTON)), rel=1e-12)
    total = np.asarray(slip_work(x, vacuum, ALONE))
    assert stored + heat == pytest.approx(total, rel=1e-9, abs=1e-15)
    assert heat == pytest.approx(np.asarray(slip_heat(x, vacuum, ALONE)), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("vacuum", [700.0, 94.5e3])
def test_unloading_is_twice_the_backbone_at_half_the_way(vacuum):
    top = 0.04
    x = np.linspace(top, 0.0, 41)
    force, _, _ = cycle(np.concatenate([[0.0], x]), vacuum)
    first = float(enclosure_force(top, vacuum, KAPTON))
    back = first - 2 * np.asarray(enclosure_force((top - x) / 2, vacuum, KAPTON))
    assert force[1:] == pytest.approx(back, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("vacuum", [700.0, 94.5e3])
def test_loops_close_and_return_to_the_outer_branch(vacuum):
    """After any inner loop the force is what it would be without the loop, also the heat's rate."""
    plain = [0.0, 0.05, 0.02, 0.03, 0.045, 0.05, 0.055]
    looped = [0.0, 0.05, 0.02, 0.03, 0.025, 0.028, 0.026, 0.03, 0.045, 0.04, 0.045, 0.05, 0.055]
    force, stored, _ = cycle(plain, vacuum)
    again, kept, _ = cycle(looped, vacuum)
    same = [0, 1, 2, 3, 8, 11, 12]
    assert again[same] == pytest.approx(force, rel=1e-12)
    assert kept[same] == pytest.approx(stored, rel=1e-12)
    assert force[-1] == pytest.approx(float(enclosure_force(0.055, vacuum, KAPTON)), rel=1e-12)
    assert again[7] == pytest.approx(again[3], rel=1e-12)


def test_inner_unloading_loop_returns_to_the_outer_unloading_branch():
    deep = [0.0, 0.05, 0.03, 0.035, 0.02, 0.01]
    straight = [0.0, 0.05, 0.03, 0.03, 0.02, 0.01]
    looped, plain = cycle(deep, 3e4), cycle(straight, 3e4)
    for a, b in zip(looped[:2], plain[:2], strict=True):
        assert a[[2, 4, 5]] == pytest.approx(b[[2, 4, 5]], rel=1e-12)
    assert looped[2][-1] > plain[2][-1]


def random_path(rng, n: int, top: float) -> np.ndarray:
    return np.concatenate([[0.0], rng.uniform(0, top, n)])


@pytest.mark.parametrize("seed", range(6))
def test_work_is_the_integral_of_force_on_random_paths(seed):
    """Fine steps and coarse steps give one answer; booked energy is the area under the force."""
    rng = np.random.default_rng(seed)
    vacuum = [94.5e3, 2e3, 400.0][seed % 3]
    turns = random_path(rng, 10, 0.06)
    dense = fine(*turns, n=400)
    force, stored, heat = cycle(dense, vacuum)
    coarse = cycle(turns, vacuum)
    for a, b in zip((force, stored, heat), coarse, strict=True):
        assert a[::400] == pytest.approx(b, rel=1e-9, abs=1e-12)
    work = area(force, dense)
    assert stored + heat == pytest.approx(work, abs=3e-5 * work.max())
    assert (np.diff(heat) >= -1e-15).all()
    assert (stored >= -1e-15).all()


def test_closed_cycle_dissipates_its_area():
    turns = [0.0, 0.05, 0.01, 0.05, 0.01]
    dense = fine(*turns)
    force, stored, heat = cycle(dense, 3e4)
    a, b = 800, 1600
    work = area(force, dense)
    assert stored[b] == pytest.approx(stored[a], rel=1e-12)
    assert heat[b] - heat[a] == pytest.approx(work[b] - work[a], rel=1e-5)
    assert heat[b] - heat[a] > 0.01


def test_standing_still_changes_nothing():
    force, stored, heat = cycle([0.0, 0.03, 0.03, 0.02, 0.02, 0.03], 3e4)
    for values in (force, stored, heat):
        assert values[1] == values[2] and values[3] == values[4]
    assert heat[5] > heat[4]


def test_vacuum_raised_leaves_force_and_energy():
    force, stored, heat = cycle([0, 0.02, 0.02, 0.02], np.array([1e3, 1e3, 3e4, 9e4]))
    for values in (force, stored, heat):
        assert values[1:] == pytest.approx(np.full(3, values[1]), rel=1e-13)


def test_vacuum_lowered_caps_the_force_and_heats():
    vacuum = np.array([9e4, 9e4, 3e4, 1e3, 0.0])
    force, stored, heat = cycle([0, 0.02, 0.02, 0.02, 0.02], vacuum)
    cap = np.asarray(enclosure_force(0.02, vacuum[1:], KAPTON))
    assert force[1:] == pytest.approx(cap, rel=1e-12)
    assert (np.diff(heat[1:]) > 0).all()
    assert stored[1:] + heat[1:] == pytest.approx(np.full(4, stored[1] + heat[1]), rel=1e-12)


def test_vacuum_raised_and_pulled_on_first_spends_the_friction_gained_then_joins_the_backbone():
    """Where the strip slid it has q' - q to spare; past the old sliding zone it is as if new."""
    x, low, high = 0.02, 2e3, 5e4
    held = float(enclosure_force(x, low, KAPTON))
    joined = held * high / low  # the zone held / q, now at q'
    unit = float(enclosure_force(1e-6, 1.0, KAPTON)) ** 2 / 1e-6  # 4 EA mu W per pascal
    ends = joined**2 / (unit * high)
    near, far = x + 0.1 * (ends - x), ends * 1.01
    force, _, _ = cycle([0, x, near, ends, far], np.array([low, low, high, high, high]))
    spent = held + (unit * (high - low) * (near - x)) ** 0.5
    assert force[2] == pytest.approx(spent, rel=1e-9)
    assert force[3] == pytest.approx(joined, rel=1e-9)
    assert force[4] == pytest.approx(float(enclosure_force(far, high, KAPTON)), rel=1e-9)


def test_saturated_and_unsaturated_paths_are_both_walked():
    assert float(saturation_slip(400.0, KAPTON)) < 0.06 < float(saturation_slip(94.5e3, KAPTON))


def spiral(turns: int) -> list[float]:
    ends = 0.03 + 0.02 * 0.9 ** np.arange(turns) * (-1.0) ** np.arange(turns)
    return [0.0, *ends]


def test_more_nested_turns_than_remembered_are_reported_not_guessed():
    force, _, _ = cycle(spiral(2 * DEPTH + 1), 3e4)
    assert np.isfinite(force).all()
    force, stored, heat = cycle(spiral(2 * DEPTH + 4), 3e4)
    assert np.isfinite(force[: 2 * DEPTH + 1]).all()
    assert np.isnan([force[-1], stored[-1], heat[-1]]).all()


def test_outside_the_domain_is_nan():
    force, stored, heat = cycle([0.0, 0.01, -0.01], 3e4)
    assert np.isfinite(force[:2]).all()
    assert np.isnan([force[2], stored[2], heat[2]]).all()
    assert np.isnan(cycle([0.0, 0.01], np.array([3e4, -1.0]))[0][1])


def games(seed: int, n: int, steps: int):
    """Random slips and vacuums: histories (n, steps) for n random brakes."""
    rng = np.random.default_rng(seed)
    brakes = random_brakes(seed, n)
    slips = rng.uniform(0, 1, (n, steps)) ** 2 * brakes.sheets.overlap[:, None]
    slips[:, 0] = 0
    stay = rng.uniform(size=(n, steps)) < 0.4
    stay[:, 0] = False
    for i in range(1, steps):
        slips[:, i] = np.where(stay[:, i], slips[:, i - 1], slips[:, i])
    levels = brakes.site.atmosphere[:, None] * rng.uniform(0, 1, (n, steps)) ** 4
    vacuum = levels * (rng.uniform(size=(n, steps)) > 0.15)
    for i in range(1, steps):
        hold = rng.uniform(size=n) < 0.5
        vacuum[:, i] = np.where(hold, vacuum[:, i - 1], vacuum[:, i])
    return brakes, slips, vacuum


def check_games(slips, made) -> None:
    """Finite, heat never falls, stored energy never below zero."""
    force, stored, heat = map(np.asarray, made)
    size = np.nanmax(np.abs(stored + heat), axis=1, keepdims=True) + 1e-12
    assert force.shape == slips.shape
    assert np.isfinite(force).all() and np.isfinite(stored).all()
    assert (np.diff(heat, axis=1) >= -1e-10 * size).all()
    assert (stored >= -1e-10 * size).all()


def test_pumping_wins_nothing_from_a_sleeve():
    """Any slips, any vacuums, one brake after the other."""
    brakes, slips, vacuum = games(0, 200, 24)
    brakes = with_fields_of(KAPTON, brakes)
    rows = [cycle(s, p, one(brakes, i)) for i, (s, p) in enumerate(zip(slips, vacuum, strict=True))]
    check_games(slips, zip(*rows, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(cases(2, 1)))
def test_pumping_wins_nothing_from_many_sleeves_at_once(seed):
    brakes, slips, vacuum = games(seed, 1500, 24)
    check_games(slips, jax.jit(jax.vmap(enclosure_cycle))(slips, vacuum, brakes))


def test_booked_energy_is_work_when_unloaded_below_the_new_origin():
    slips = np.concatenate([fine(0, 0.02), fine(0.02, 0.0205, 0.0005, 0.0205)])
    vacuum = np.where(np.arange(len(slips)) <= 400, 100.0, 9e4)
    force, stored, heat = cycle(slips, vacuum)
    work = area(force, slips)
    assert stored + heat == pytest.approx(work, abs=1e-4 * work.max())


@pytest.mark.parametrize("seed", range(3))
def test_pumping_wins_nothing_while_the_sleeve_only_pulls(seed):
    """The same game, ended where the sleeve would push: work = stored + heat - released, exact."""
    rng = np.random.default_rng(seed)
    gained = []
    for _ in range(6):
        low, high = np.sort(rng.uniform(0, 0.06, 2))
        levels = rng.uniform(0, 1, 4) ** 3 * 1e5
        turns = [0.0, high, (low + high) / 2, high * 1.02, high]
        legs = [fine(a, b, n=300) for a, b in itertools.pairwise(turns)]
        slips = np.concatenate(legs)
        vacuum = np.repeat(levels, [len(leg) for leg in legs])
        force, stored, heat = cycle(slips, vacuum)
        taut = np.minimum.accumulate(force >= 0)
        work = area(force, slips)
        assert stored[taut] + heat[taut] == pytest.approx(work[taut], abs=2e-4 * work.max())
        assert (np.diff(heat[taut]) >= -1e-14).all() and (stored[taut] >= 0).all()
        gained.append(work[taut].min())
    assert min(gained) >= 0


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_pump_down_and_let_go_returns_less_than_was_put_in(brake):
    """Pull at full vacuum, pump down, let the sleeve pull back: what returns is less."""
    legs = [fine(0, 0.05), fine(0.05, 0.0)]
    slips = np.concatenate(legs)
    for low in (0.0, 100.0, 3e3, 2e4):
        vacuum = np.repeat([94.5e3, low], [len(leg) for leg in legs])
        force, stored, heat = cycle(slips, vacuum, brake)
        work = area(np.maximum(force, 0), slips)
        assert 0 < work[-1] < work[400]
        assert (np.diff(heat) >= -1e-14).all() and stored.min() >= -1e-14


@pytest.mark.parametrize("x", [1e-4, 0.02])
def test_raised_from_nothing_the_whole_strip_has_friction_to_spare(x):
    """At zero vacuum all of it slides: q l of each half must come before the backbone is joined."""
    strip = enclosure_law(5e3, KAPTON)
    held = float(enclosure_force(x, 0.0, KAPTON))
    joined = held + 2 * strip.friction * strip.reach
    ends = float(strip.find_slip(joined, 0.0))
    near = x + 0.5 * (ends - x)
    force, _, _ = cycle([x, x, near, ends], np.array([0.0, 5e3, 5e3, 5e3]))
    assert force[2] == pytest.approx(held + float(strip.force(near - x)), rel=1e-9)
    assert force[3] == pytest.approx(joined, rel=1e-9)


def test_let_back_and_vented_a_little_it_slides_and_rejoins_first_loading():
    """Near EA x/l - q l, where all of it is turned: pulled again it joins the first loading."""
    x, low = 0.02, 100.0
    strip = enclosure_law(low, KAPTON)
    slope = float(strip.stiffness / strip.reach)
    edge = slope * x - float(strip.friction * strip.reach)
    turn = 2 * float(strip.friction) * float(strip.reach) ** 2 / float(strip.stiffness)
    path = [0.04, x, x, x + turn, 0.05]
    force, stored, heat = cycle(path, np.array([2e3, 2e3, low, low, low]))
    assert edge < force[2] < 1.01 * edge
    first = np.asarray(enclosure_force(np.array([x + turn, 0.05]), low, KAPTON))
    assert force[3:] == pytest.approx(first, rel=1e-9)
    assert (np.diff(heat) >= -1e-15).all() and (stored > 0).all()


def test_a_strip_that_slides_back_as_a_whole_heats_by_its_friction_and_falls_by_its_spring():
    low, x, back = 60.0, 0.02, 0.015
    strip = enclosure_law(low, KAPTON)
    force, stored, heat = cycle([0.04, x, x, back], np.array([2e3, 2e3, low, low]))
    way = x - back
    assert force[3] == pytest.approx(
        force[2] - float(strip.stiffness / strip.reach) * way, rel=1e-12
    )
    rubbed = float(strip.friction * strip.reach) * way
    assert heat[3] - heat[2] == pytest.approx(rubbed, rel=1e-9)
    work = -(force[2] + force[3]) / 2 * way
    assert stored[3] - stored[2] == pytest.approx(work - rubbed, rel=1e-9)


def test_a_sleeve_that_pushes_goes_on_pushing_as_far_as_friction_holds_it():
    slips = [0.04, 1e-4, 1e-4]
    force, stored, heat = cycle(slips, np.array([2e3, 2e3, 4e3]))
    assert force[1] < 0 < stored[1]
    assert (force[2], stored[2], heat[2]) == (force[1], stored[1], heat[1])
    force, stored, heat = cycle(slips, np.array([2e3, 2e3, 1e3]))
    assert force[1] < force[2] < 0 and 0 < stored[2] < stored[1]
    assert stored[2] + heat[2] == pytest.approx(stored[1] + heat[1], rel=1e-12)
    assert cycle(slips, np.array([2e3, 2e3, 0.0]))[0][2] == pytest.approx(
        float(enclosure_force(1e-4, 0.0, KAPTON)), abs=1e-12
    )
