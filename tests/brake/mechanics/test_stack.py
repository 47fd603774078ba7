"""Sheet by sheet: the exact increment, check values, energy, the sleeve's faces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from layerjam.brake.device.load import load
from layerjam.brake.kernel.stack import make_knots, pull_stack
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.memory import enclosure_cycle
from layerjam.brake.mechanics.stack.lasso import fused_lasso
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import Housing, Interfaces, make_stack
from layerjam.core.errors import ProcedureError, QuantityError
from strategies import KAPTON, PTFE, area, padded

FULL = 94.5e3
C = 175.4298 / 10
SLOPE = C / KAPTON.sheets.overlap


def rigid(static: bool = False, count: int = 11, ratio: float | None = None) -> Stack:
    stack = make_stack(KAPTON, FULL, static=static, enclosure=False, mount=np.inf)
    if count == 11:
        return stack if ratio is None else stack._replace(ratio=np.full(10, ratio))
    return stack._replace(
        springs=np.full(count, stack.springs[0]),
        right=np.arange(count) % 2 == 1,
        friction=np.full(count - 1, C),
        ratio=np.ones(count - 1),
        length=np.full(count - 1, 0.068),
        ends=np.array([0, count - 1]),
    )


def mounted(**more: object) -> Stack:
    return make_stack(KAPTON, FULL, **more)  # type: ignore[arg-type]


def through(*turns: float, n: int = 200) -> np.ndarray:
    legs = [np.linspace(a, b, n + 1)[1:] for a, b in itertools.pairwise(turns)]
    return np.concatenate([[turns[0]], *legs])


def solved(d: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    z = np.zeros(len(d))
    fused_lasso(len(d), d, b, c, z, make_knots(len(d)))
    return z


# --- one increment


@pytest.mark.parametrize("n", [2, 3, 11, 200])
def test_the_increment_meets_the_conditions_of_its_minimum(n):
    random = np.random.default_rng(n)
    for _ in range(300):
        d = np.exp(random.normal(0, 1, n))
        b = random.normal(0, 1, n) * random.choice([0.1, 1, 10])
        c = np.exp(random.normal(-1, 1.5, n - 1))
        z = solved(d, b, c)
        carried = np.cumsum(d * (z - b))
        assert abs(carried[-1]) < 1e-9 * np.abs(d * b).max()
        force = carried[:-1]
        assert (np.abs(force) <= c * (1 + 1e-9) + 1e-9).all()
        slides = np.diff(z) != 0
        # friction pulls the left sheet after the right one
        ahead = np.sign(np.diff(z))[slides]
        assert force[slides] == pytest.approx((c * 1.0)[slides] * ahead, rel=1e-8, abs=1e-8)


def test_two_sheets_by_hand():
    z = solved(np.array([2.0, 3.0]), np.array([0.0, 1.0]), np.array([0.5]))
    assert z == pytest.approx([0.25, 1 - 0.5 / 3])
    z = solved(np.array([2.0, 3.0]), np.array([0.0, 1.0]), np.array([5.0]))
    assert z == pytest.approx([0.6, 0.6])


@pytest.mark.slow
def test_balance_bounds_and_direction_hold_at_every_increment():
    """What makes a state right, checked from the outside, with scatter, sleeve, mount and walls."""
    random = np.random.default_rng(5)
    uneven = Interfaces(friction=np.exp(random.normal(0, 0.4, 10)))
    stack = mounted(interfaces=uneven, housing=Housing(friction=4.0, contact=0.079))
    path = through(0, 0.02, 0.0195, 0.03, n=150)
    run = pull_stack(path, stack)
    home = np.where(stack.right, run.cap[:, None], 0.0)
    held = stack.springs * (run.sheets - home)
    push = np.zeros_like(held)
    for e, end in enumerate(stack.ends):
        push[:, end] += run.faces[:, e] * (-1 if stack.right[end] else 1)
    assert np.cumsum(held - push, axis=1)[:, :-1] == pytest.approx(run.interface, abs=1e-9)
    assert (held - push).sum(axis=1) == pytest.approx(0.0, abs=1e-8)
    cap = -held[:, stack.right].sum(axis=1) + run.faces.sum(axis=1)
    assert run.force == pytest.approx(cap, abs=1e-8)
    assert run.force == pytest.approx(stack.mount * (path - run.cap), abs=1e-6)
    bound = stack.friction * (1 - run.slip / stack.length)
    assert (np.abs(run.interface) <= bound * (1 + 1e-9) + 1e-9).all()
    moved = np.diff(run.slip, axis=0)
    along = np.where(stack.right[:-1], -1.0, 1.0) * run.interface[1:]
    slides = np.abs(moved) > 1e-12
    assert along[slides] == pytest.approx((np.sign(moved) * bound[1:])[slides], rel=1e-7)


# --- check values


def test_rigid_mount_identical_interfaces_no_sleeve():
    path = np.linspace(0, 3e-4, 6001)
    result = pull_stack(path, rigid())
    assert result.force[1] / path[1] == pytest.approx(2046694.2, rel=1e-7)
    # the outer sheets carry one interface only, so the outer interfaces slide first, at 6 c
    first = int(result.sliding.any(axis=1).argmax())
    assert result.sliding[first].tolist() == [True] + [False] * 8 + [True]
    assert result.force[first] == pytest.approx(6 * C, rel=2e-3)
    # 2 slope c/spring below 10 c: the outer pair has slipped when the last ones let go
    top = 10 * C - 2 * SLOPE * C / rigid().springs[0]
    assert result.force.max() == pytest.approx(top, abs=5e-4)
    assert result.force.max() == pytest.approx(175.416, abs=3e-3)
    # all slide: each interface has slipped by U less what its sheets stretch
    assert (result.slip[-1] > 0).all()


def test_the_answer_does_not_depend_on_the_increments():
    for stack, end in ((rigid(), 3e-4), (mounted(), 3e-3)):
        fine = pull_stack(np.linspace(0, end, 2001), stack)
        coarse = pull_stack(np.linspace(0, end, 21), stack)
        assert coarse.force == pytest.approx(fine.force[::100], rel=1e-11)
        assert coarse.slip == pytest.approx(fine.slip[::100], abs=1e-15)
        assert coarse.heat == pytest.approx(fine.heat[::100], rel=1e-9, abs=1e-15)
        assert coarse.work == pytest.approx(fine.work[::100], rel=1e-9, abs=1e-15)


def test_the_cap_gives_way_as_a_spring_in_series():
    stack, path = mounted(enclosure=False), np.linspace(0, 6e-4, 7)
    stiff = KAPTON.stiffness_measured
    assert pull_stack(path, stack).force == pytest.approx(stiff * path, rel=1e-9)
    assert stack.mount == pytest.approx(1 / (1 / stiff - 1 / 2046694.2148760335), rel=1e-9)


def test_static_friction_breaks_with_a_drop_at_a_fixed_cap():
    result = pull_stack(np.linspace(0, 1.2e-4, 24001), rigid(static=True))
    drop = int(np.flatnonzero(np.diff(result.force) < -1)[0])
    assert result.force[drop] == pytest.approx(140.34, abs=0.01)
    assert result.force[drop + 1] == pytest.approx(133.85, abs=0.02)


def test_a_break_happens_where_it_does_whatever_the_increment():
    """Two sheets by hand: at F_s the load falls to F_k at fixed cap, d/2 over both springs."""
    stack = rigid(count=2)._replace(ratio=np.array([1.5]), length=np.array([np.inf]))
    d = stack.springs[0]
    at = 1.5 * C / (d / 2)
    for n in (3, 7, 500):
        run = pull_stack(np.linspace(0, 1.7 * at, n), stack)
        assert run.force[-1] == pytest.approx(C, rel=1e-9)
        # the way after the break is done at F_k; before it all is elastic; the jump wins nothing
        assert run.work[-1] == pytest.approx(1.5 * C * at / 2 + C * 0.7 * at, rel=1e-9)
        assert run.stored[-1] == pytest.approx(C**2 / d, rel=1e-9)
        assert run.heat[-1] == pytest.approx(run.work[-1] - C**2 / d, rel=1e-9)


def test_an_interface_that_stopped_is_static_again():
    stack = rigid(count=2)._replace(ratio=np.array([1.5]), length=np.array([np.inf]))
    at = 3 * C / stack.springs[0]
    run = pull_stack(through(0, 2 * at, 1.6 * at, 3 * at, n=4000), stack)
    # unloaded by 0.4 at and loaded again it must climb past F_k to F_s
    later = run.force[8001:]
    assert later.max() == pytest.approx(1.5 * C, rel=1e-3)
    assert run.force[-1] == pytest.approx(C, rel=1e-9)


def test_a_load_held_moves_nothing():
    path = np.concatenate([np.linspace(0, 5e-5, 500), np.full(2000, 5e-5)])
    for stack in (rigid(), rigid(static=True)):
        result = pull_stack(path, stack)
        assert (result.slip[-1] == result.slip[499]).all()
        assert (result.sheets[-1] == result.sheets[499]).all()
        assert result.heat[-1] == result.heat[499]


# --- energy


def test_energy_closes_against_the_force_integrated_on_its_own():
    """Without sleeve the force is straight between two changes of state: trapezoids are exact."""
    for stack, end in ((rigid(), 3e-4), (mounted(enclosure=False), 3e-3)):
        path = np.linspace(0, end, 301)
        for _ in range(45):  # the grid closes in on every change of state
            run = pull_stack(path, stack)
            change = np.flatnonzero((np.diff(run.sliding.astype(int), axis=0) != 0).any(axis=1))
            middle = (path[change] + path[change + 1]) / 2
            path = np.union1d(path, middle)
        run = pull_stack(path, stack)
        assert 3 <= len(change) <= 6
        outside = area(run.force, path)
        assert run.work == pytest.approx(outside, abs=1e-10 * outside[-1])
        assert run.heat + run.stored == pytest.approx(outside, abs=1e-10 * outside[-1])


def test_energy_closes_with_the_sleeve_at_second_order():
    stack, misses = mounted(), []
    for n in (4000, 8000, 16000):
        path = 3e-3 * np.linspace(0, 1, n + 1) ** 2
        run = pull_stack(path, stack)
        misses.append(abs(run.heat[-1] + run.stored[-1] - area(run.force, path)[-1]))
    assert misses[2] < 3e-8 * run.work[-1]
    assert misses[0] / misses[2] == pytest.approx(16, rel=0.5)


@given(
    seed=st.integers(0, 10**6),
    turns=st.lists(st.floats(0.02, 1), min_size=2, max_size=5),
    static=st.booleans(),
    vacuum=st.sampled_from([1e3, 2e4, FULL]),
)
# two interfaces that reach their bounds within rounding of each other
@example(seed=0, turns=[1.0, 1.0], static=True, vacuum=1e3)
# at rest without force between sliding one way and the other: no mount has snapped
@example(seed=616, turns=[0.5, 0.875], static=False, vacuum=2e4)
@example(seed=880836, turns=[0.159056, 0.27586629, 0.27586629, 1.0], static=True, vacuum=2e4)
def test_no_history_wins_energy(seed, turns, static, vacuum):
    random = np.random.default_rng(seed)
    brake = (KAPTON, PTFE)[seed % 2]
    each = Interfaces(friction=np.exp(random.normal(0, 0.3, brake.sheets.count - 1)))
    walls = Housing(friction=float(random.uniform(0, 10))) if seed % 3 == 0 else None
    stack = make_stack(brake, vacuum, interfaces=each, housing=walls, static=static)
    reach = random.choice([3, 20, 300]) * stack.friction.sum() / 131e3
    far = [min(reach, 0.06) * t for t in turns]
    path = through(0, *far, 0, *far, 0, n=300)
    run = pull_stack(path, stack)
    assert (run.force >= 0).all()
    assert (run.stored >= -1e-15).all()
    assert (np.diff(run.heat) >= -1e-13 * run.work.max()).all()
    # work by the crosshead's force alone; a closed cycle never gives any back
    outside = area(run.force, path)
    ends = np.flatnonzero(path == 0)
    assert (np.diff(outside[ends]) >= -2e-3 * outside.max()).all()
    # static friction breaks within increments, where trapezoids see the drop late
    assert run.work == pytest.approx(outside, abs=(3e-2 if static else 2e-3) * outside.max())
    assert (run.work - run.heat - run.stored) == pytest.approx(0, abs=1e-12 * run.work.max())


def test_a_closed_cycle_takes_work():
    path = through(0, 5e-3, 0, 5e-3, 0, n=2000)
    run = pull_stack(path, rigid())
    work = area(run.force, path)
    assert work[4000] > 0
    assert work[-1] >= work[4000] - 1e-12
    assert run.work == pytest.approx(work, abs=1e-5 * work[-1])


# --- unloading


def test_unloaded_it_rests_without_force_and_takes_up_the_load_where_it_left():
    stack = mounted()
    run = pull_stack(through(0, 0.02, 0, 0.02, n=400), stack)
    assert run.slack.any()
    rest = run.slack
    assert (run.force[rest] == 0).all()
    assert np.ptp(run.slip[rest], axis=0).max() == 0
    assert run.force[-1] == pytest.approx(run.force[400], rel=1e-9)
    # while it unloads the brake is as stiff as it was
    part = slice(401, 404)
    path = through(0, 0.02, 0, 0.02, n=400)
    rise = np.polyfit(path[part], run.force[part], 1)[0]
    assert rise == pytest.approx(131e3, rel=1e-2)


def test_the_low_vacuum_sleeve_closes_the_brake_as_in_the_lumped_one():
    path = through(0, 0.04, 0, n=300)
    stack = make_stack(KAPTON, 2e3)
    run = pull_stack(path, stack)
    long, vacuum, count = padded(path, 2e3)
    lumped = brake_cycle(long, vacuum, KAPTON)
    assert np.asarray(lumped.closed)[count - 1]
    assert run.slip[-1].mean() == pytest.approx(float(lumped.slip[count - 1]), rel=2e-4)
    assert run.stored[-1] == pytest.approx(float(lumped.stored[count - 1]), rel=1e-3)
    assert run.heat[-1] == pytest.approx(float(lumped.heat[count - 1]), rel=1e-3)


# --- sleeve


def frictionless(vacuum: float) -> Stack:
    """Two faces on stiff sheets and nothing else: their gap is the cap's way."""
    stack = make_stack(KAPTON, vacuum, mount=np.inf)
    return stack._replace(friction=np.zeros(10), springs=np.full(11, 1e10))


@pytest.mark.parametrize("vacuum", [0.0, 300.0, FULL])
def test_faces_load_along_the_backbone(vacuum):
    path = np.linspace(0, 0.06, 61)
    run = pull_stack(path, frictionless(vacuum))
    law = np.asarray(enclosure_law(vacuum, KAPTON).force(path))
    assert run.force == pytest.approx(law, rel=1e-5, abs=1e-9)
    assert run.faces.sum(axis=1) == pytest.approx(law, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("vacuum", [300.0, 5e3, FULL])
def test_nested_loops_of_the_faces_are_those_of_the_lumped_sleeve(vacuum):
    path = through(0, 0.04, 0.03, 0.035, 0.032, 0.034, 0.031, 0.045, 0.042, n=40)
    run = pull_stack(path, frictionless(vacuum))
    long, level, count = padded(path, vacuum)
    force, stored, heat = (np.asarray(a)[:count] for a in enclosure_cycle(long, level, KAPTON))
    assert (force >= 0).all(), "the stack's crosshead could not follow"
    assert run.force == pytest.approx(force, rel=1e-5)
    assert run.heat == pytest.approx(heat, rel=1e-4, abs=1e-9)
    assert run.stored == pytest.approx(stored, rel=1e-4, abs=1e-9)


def test_more_nested_turns_than_are_remembered_are_refused():
    turns = [0.0]
    for i in range(140):
        turns.append(0.04 + (-1) ** i * (0.002 - 1.4e-5 * i))
    with pytest.raises(ProcedureError, match="nested"):
        pull_stack(through(*turns, n=2), frictionless(5e3))


# --- layouts


def test_a_missing_vacuum_in_the_middle_weakens_those_interfaces_only():
    share = Interfaces.missing_vacuum(11, 0.4).vacuum
    assert share[[0, -1]] == pytest.approx(1)
    assert share.min() == pytest.approx(0.4, abs=0.02)
    stack = mounted(interfaces=Interfaces.missing_vacuum(11, 0.4), enclosure=False)
    result = pull_stack(np.linspace(0, 0.01, 2001), stack)
    assert np.abs(result.interface[-1]) == pytest.approx(
        stack.friction * (1 - result.slip[-1] / stack.length), rel=1e-9
    )
    assert result.force.max() == pytest.approx(10 * C * share.mean(), rel=2e-3)


def test_misaligned_sheets_overlap_by_what_both_are_shifted():
    shifts = np.zeros(11)
    shifts[4] = -5e-3
    stack = mounted(interfaces=Interfaces.misaligned(shifts), enclosure=False)
    assert stack.length[[2, 5]] == pytest.approx([0.068, 0.068])
    assert stack.length[[3, 4]] == pytest.approx([0.063, 0.063])
    assert stack.friction[3] == pytest.approx(C * 63 / 68)
    run = pull_stack(np.linspace(0, 0.01, 500), stack)
    assert run.force.max() == pytest.approx(C * (8 + 2 * 63 / 68), rel=2e-3)


def test_a_housing_adds_its_friction_and_lets_go_first():
    plain, housed = (
        mounted(enclosure=False),
        mounted(enclosure=False, housing=Housing(friction=5.0)),
    )
    path = np.linspace(0, 0.01, 2001)
    a, b = pull_stack(path, plain), pull_stack(path, housed)
    assert len(housed.springs) == 13
    assert housed.right.tolist() == [i % 2 == 0 for i in range(13)]
    # it slides past the wall: ten newtons more once all slide, at the same slip
    at = np.interp(b.slip[-1, 1:-1].mean(), a.slip.mean(axis=1), a.force)
    assert b.force[-1] - at == pytest.approx(10.0, rel=1e-3)
    assert b.slip[-1, 0] == pytest.approx(b.cap[-1] - b.sheets[-1, 1], abs=1e-6)
    assert (b.slip[-1, [0, -1]] > 0).all()
    shrinking = mounted(enclosure=False, housing=Housing(friction=5.0, contact=0.02))
    c = pull_stack(path, shrinking)
    left = 10 * (1 - c.slip[-1, 0] / 0.02)
    at = np.interp(c.slip[-1, 1:-1].mean(), a.slip.mean(axis=1), a.force)
    assert c.force[-1] - at == pytest.approx(left, rel=1e-3)
    one = pull_stack(path, mounted(enclosure=False, housing=Housing(friction=(5.0, 0.0))))
    at = np.interp(one.slip[-1, 1:-1].mean(), a.slip.mean(axis=1), a.force)
    assert one.force[-1] - at == pytest.approx(5.0, rel=1e-3)


def test_even_stacks_and_thousands_of_sheets():
    even = rigid(count=10)
    run = pull_stack(np.linspace(0, 4e-4, 101), even)
    assert run.force.max() == pytest.approx(9 * C, rel=2e-3)
    many = rigid(count=2000)
    run = pull_stack(np.linspace(0, 4e-4, 41), many)
    assert run.force.max() == pytest.approx(1999 * C, rel=5e-3)
    assert run.force[1] / 1e-5 == pytest.approx(1000 / 2 * many.springs[0], rel=1e-9)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"length": np.ones(3)}, "interfaces"),
        ({"right": np.zeros(3, bool)}, "interfaces"),
        ({"friction": np.full(10, -1.0)}, "negative"),
        ({"ratio": np.full(10, 0.5)}, "static friction is below kinetic"),
        ({"friction": np.full(10, np.nan)}, "must be known"),
        ({"springs": np.full(11, np.inf)}, "only lengths may be infinite"),
        ({"springs": np.zeros(11)}, "above 0 N/m"),
        ({"mount": 0.0}, "above 0 N/m"),
        ({"ends": np.array([0, 11])}, "not two of 11 sheets"),
        ({"ends": np.array([10, 0])}, "not two of 11 sheets"),
        ({"ends": np.array([0, 5, 10])}, "ends two"),
        ({"face": np.zeros(2)}, "three numbers"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, match):
    with pytest.raises(QuantityError, match=match):
        pull_stack(np.zeros(3), rigid()._replace(**change))
    with pytest.raises(QuantityError, match="path"):
        pull_stack(np.array([0.0, np.nan]), rigid())


def test_layouts_that_make_no_sense_are_refused():
    for each in (
        Interfaces(friction=np.ones(4)),
        Interfaces(extra_overlap=-1.0),
        Interfaces(vacuum=-0.1),
        Interfaces(friction=np.nan),
    ):
        with pytest.raises(QuantityError, match="interfaces"):
            mounted(interfaces=each)
    for walls in (Housing(friction=-1.0), Housing(friction=1.0, contact=0.0)):
        with pytest.raises(QuantityError, match="housing"):
            mounted(housing=walls)
    with pytest.raises(QuantityError, match="middle"):
        Interfaces.missing_vacuum(11, 1.5)


def test_a_mount_that_is_too_soft_snaps_and_the_arrays_end_before_it():
    run = pull_stack(np.linspace(0, 0.2, 500), mounted(mount=2000.0))
    assert run.snapped
    assert 0 < len(run.force) < 500
    assert run.force[-1] <= 10 * C
    firm = pull_stack(np.linspace(0, 0.06, 500), mounted(mount=2700.0))
    assert not firm.snapped


def test_progress_is_told():
    told: list[float] = []
    pull_stack(np.linspace(0, 1e-3, 500), rigid(count=2000), told.append)
    assert told[-1] == 1.0
    assert len(told) >= 5
    assert told == sorted(told)


def test_catalogue_brakes_run_with_static_friction_to_the_end():
    for name in ("choi2018-kapton", "choi2018-ptfe"):
        stack = make_stack(load(name).brake, FULL, static=True)
        run = pull_stack(np.linspace(0, 0.04, 400), stack)
        assert len(run.force) == 400
