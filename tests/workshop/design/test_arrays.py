"""Arrays of brakes: closed forms, order of slipping, energy, the antagonistic pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.strategies import KAPTON, PTFE

from layerjam.brake.device.brake import mass
from layerjam.brake.mechanics.energy import slip_work
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, peak
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.record import Outcome
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import QuantityError
from layerjam.workshop.design import arrays
from layerjam.workshop.design.antagonist import neutral_stiffness, pair
from layerjam.workshop.design.arrays import (
    Array,
    Member,
    grid,
    in_parallel,
    in_series,
    pull,
    single,
    totals,
)

P = 94.5e3
TRAVEL = 0.060
K = 131e3
PEAK = float(peak(P, TRAVEL, KAPTON).force)
END = float(brake_force(TRAVEL, P, KAPTON))
"""Force as the travel is used up."""


def at(made: arrays.ArrayLoading, u: float | np.ndarray) -> np.ndarray:
    return np.interp(u, made.elongation, made.force)


def outside_work(made: arrays.ArrayLoading) -> float:
    return float(np.trapezoid(made.force, made.elongation))


def test_one_brake_is_the_brake() -> None:
    made = pull(single(KAPTON, P))
    u = np.linspace(0, made.elongation[-1], 997)
    np.testing.assert_allclose(at(made, u), force_at_elongation(u, P, KAPTON), atol=2e-3)
    assert made.force.max() == pytest.approx(PEAK, rel=1e-12)
    assert made.elongation[-1] == pytest.approx(TRAVEL + END / K, rel=1e-12)
    assert made.outcome is Outcome.BOTTOMED_OUT
    assert [what for _, _, what in made.order] == ["runs", "ends"]


def test_one_brake_agrees_with_the_test_machine() -> None:
    from layerjam.brake.device.load import load

    record = tensile(load("choi2018-kapton"), simple_pull(P, 1e-3, 0.040))
    made = pull(single(KAPTON, P), until=0.040)
    assert made.outcome is Outcome.FINISHED and made.elongation[-1] == 0.040
    np.testing.assert_allclose(at(made, record.elongation), record.force, atol=2e-3)
    assert made.work[-1] == pytest.approx(record.work[-1], rel=1e-6)


@pytest.mark.parametrize("count", [2, 7])
def test_in_parallel_forces_and_stiffness_add(count: int) -> None:
    one, many = pull(single(KAPTON, P)), pull(grid(Member(brake=KAPTON, vacuum=P), series=1,
                                                   parallel=count))  # fmt: skip
    u = np.linspace(0, one.elongation[-1], 400)
    np.testing.assert_allclose(at(many, u), count * at(one, u), rtol=1e-12, atol=1e-9)
    assert many.elongation[-1] == pytest.approx(one.elongation[-1], rel=1e-12)
    assert many.work[-1] == pytest.approx(count * one.work[-1], rel=1e-12)
    small = 1e-4
    assert at(many, small) / small == pytest.approx(count * K, rel=1e-9)
    # side by side in one stage or as chains of their own is the same thing
    stage = pull(Array(chains=(((Member(brake=KAPTON, vacuum=P),) * count,),)))
    np.testing.assert_allclose(at(stage, u), at(many, u), rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("count", [2, 5])
def test_in_series_force_stays_travel_multiplies(count: int) -> None:
    made = pull(grid(Member(brake=KAPTON, vacuum=P), series=count, parallel=1))
    assert made.force.max() == pytest.approx(PEAK, rel=1e-12)
    assert made.slips[-1] == pytest.approx(np.full(count, TRAVEL), abs=1e-12)
    assert made.elongation[-1] == pytest.approx(count * (TRAVEL + END / K), rel=1e-9)
    small = 1e-4
    assert at(made, small) / small == pytest.approx(K / count, rel=1e-9)


def test_equal_brakes_in_series_run_in_the_order_named() -> None:
    made = pull(grid(Member(brake=KAPTON, vacuum=P), series=3, parallel=1))
    assert [(i, what) for _, i, what in made.order] == [
        (0, "runs"), (0, "ends"), (1, "runs"), (1, "ends"), (2, "runs"), (2, "ends"),
    ]  # fmt: skip
    # all reach the peak's slip together; behind it one runs and the others keep theirs
    peak_slip = float(peak(P, TRAVEL, KAPTON).slip)
    halfway = int(np.argmin(np.abs(made.slips[:, 0] - 0.03)))
    assert made.slips[halfway, 1:] == pytest.approx([peak_slip, peak_slip], rel=1e-3)
    # the force climbs to the peak once a brake
    high = made.force >= PEAK * (1 - 1e-9)
    assert int(np.sum(np.diff(high.astype(int)) == 1)) == 3


def test_in_series_the_weaker_goes_first_and_limits_the_force() -> None:
    made = pull(in_series(single(KAPTON, P), single(PTFE, P)))
    assert [(i, what) for _, i, what in made.order] == [
        (1, "runs"), (1, "ends"), (0, "runs"), (0, "ends"),
    ]  # fmt: skip
    weak = float(peak(P, TRAVEL, PTFE).force)
    end_of_weak = next(u for u, i, what in made.order if i == 1 and what == "ends")
    before = made.elongation <= end_of_weak
    assert made.force[before].max() == pytest.approx(weak, rel=1e-12)
    assert made.slips[before, 0].max() == 0.0  # Kapton holds while PTFE runs
    # while it runs the force is the weaker brake's own law at its slip
    running = before & (made.slips[:, 1] > 1e-3)
    own = brake_force(made.slips[running, 1], P, PTFE)
    np.testing.assert_allclose(made.force[running], own, atol=2e-3)
    # on its stop it is an elastic strap, and the stronger one has its whole pull
    assert made.force.max() == pytest.approx(PEAK, rel=1e-12)
    assert made.slips[-1] == pytest.approx([TRAVEL, TRAVEL])


def test_without_a_stop_the_chain_comes_apart_with_its_first_brake() -> None:
    made = pull(grid(Member(brake=KAPTON, vacuum=P, stop=False), series=2, parallel=1))
    assert made.outcome is Outcome.SEPARATED and "the sheets separated" in made.warnings[0]
    assert made.slips[-1, 0] == pytest.approx(KAPTON.sheets.overlap)
    assert made.slips[-1, 1] < 1e-3


def test_no_vacuum_has_no_peak_and_equal_brakes_share() -> None:
    made = pull(grid(Member(brake=KAPTON, vacuum=0.0), series=2, parallel=1))
    assert np.all(np.diff(made.force) >= 0)
    np.testing.assert_allclose(made.slips[:, 0], made.slips[:, 1], rtol=1e-12)


@pytest.mark.slow
def test_a_long_chain_snaps_where_the_rest_is_softer_than_the_fall() -> None:
    """U = sum of slips + F N/k rises while N |F'| < k; the fall is steepest at its end."""
    fall = float(brake_force(TRAVEL - 1e-6, P, KAPTON) - brake_force(TRAVEL, P, KAPTON)) / 1e-6
    longest = int(K / fall)
    assert longest == 53
    member = Member(brake=KAPTON, vacuum=P)
    assert pull(grid(member, series=longest, parallel=1)).outcome is Outcome.BOTTOMED_OUT
    long = pull(grid(member, series=longest + 1, parallel=1))
    assert long.outcome is Outcome.SNAPS and "snaps" in long.warnings[0]
    assert 0.05 < long.slips[-1, 0] < TRAVEL and np.all(long.slips[-1, 1:] < 1e-3)


def test_a_brake_that_snaps_alone_is_refused() -> None:
    soft = replace(KAPTON, stiffness_measured=2e3)
    with pytest.raises(QuantityError, match="member 2: stiffness 2 kN/m does not exceed"):
        pull(in_series(single(KAPTON, P), single(soft, P)))


def test_parallel_brakes_share_by_stiffness_then_each_by_its_own_law() -> None:
    slack = 0.01
    stage = (Member(brake=KAPTON, vacuum=P), Member(brake=PTFE, vacuum=5e4, slack=slack))
    made = pull(Array(chains=((stage,),)))
    u = np.linspace(0, 0.055, 500)
    want = np.asarray(force_at_elongation(u, P, KAPTON))
    late = np.maximum(u - slack, 0.0)
    want = want + np.where(u > slack, force_at_elongation(late, 5e4, PTFE), 0.0)
    np.testing.assert_allclose(at(made, u), want, atol=3e-3)
    # the first on its stop ends the stage, and with it the pull
    assert made.elongation[-1] == pytest.approx(TRAVEL + END / K) and made.slips[-1, 1] < TRAVEL
    assert made.outcome is Outcome.BOTTOMED_OUT
    stuck = pull(Array(chains=(((replace(stage[0]), replace(stage[1], slack=0.0)),),)))
    i = int(np.searchsorted(stuck.elongation, 1e-4))
    share = stuck.forces[i] / stuck.force[i]
    k = np.array([K, float(working_stiffness(PTFE))])
    np.testing.assert_allclose(share, k / k.sum(), rtol=1e-9)


def test_slack_is_taken_up_at_no_force() -> None:
    made = pull(single(KAPTON, P, slack=0.02))
    assert at(made, np.array([0.0, 0.01, 0.02])) == pytest.approx([0, 0, 0], abs=1e-12)
    assert at(made, 0.0201) == pytest.approx(1e-4 * K, rel=1e-9)
    assert made.elongation[-1] == pytest.approx(0.02 + TRAVEL + END / K)


vacuums = st.one_of(st.just(0.0), st.floats(500.0, 1.0e5))
slacks = st.sampled_from([0.0, 0.0, 1e-3, 0.02])
members = st.builds(
    Member,
    brake=st.sampled_from([KAPTON, PTFE]),
    vacuum=vacuums,
    slack=slacks,
    stop=st.sampled_from([True, True, False]),
)
stages = st.lists(members, min_size=1, max_size=3).map(tuple)
chains = st.lists(stages, min_size=1, max_size=3).map(tuple)


@settings(max_examples=25)
@given(st.lists(chains, min_size=1, max_size=2))
def test_any_array_balances_its_energy_and_its_forces(made_of: list[arrays.Chain]) -> None:
    array = Array(chains=tuple(made_of))
    made = pull(array)
    scale = made.force.max() * made.elongation[-1]
    # work at the crosshead is what the members took up, summed from their own laws
    assert outside_work(made) == pytest.approx(made.work[-1], abs=2e-4 * scale)
    assert np.all(np.diff(made.elongation) > 0) and np.all(made.force >= 0)
    assert np.all(np.diff(made.slips, axis=0) >= -1e-12)
    # every stage of a chain carries the chain's force; the chains' forces add
    first, whole = 0, np.zeros(len(made.force))
    for chain in array.chains:
        carried = []
        for stage in chain:
            carried.append(made.forces[:, first : first + len(stage)].sum(axis=1))
            first += len(stage)
        for other in carried[1:]:
            np.testing.assert_allclose(other, carried[0], atol=2e-3 * made.force.max())
        whole += carried[0]
    np.testing.assert_allclose(whole, made.force, atol=2e-3 * made.force.max())
    # no brake beyond its own law: a stop may, at the end of the travel
    for i, m in enumerate(array.members):
        grown = m.travel * np.linspace(0, 1, 500) ** 2
        most = np.interp(made.slips[:, i], grown, np.asarray(brake_force(grown, m.vacuum, m.brake)))
        free = made.slips[:, i] < m.travel * (1 - 1e-6)
        assert np.all((made.forces[:, i] - most)[free] <= 5e-3 * made.force.max())


@settings(max_examples=20)
@given(st.lists(st.integers(5, 1000), min_size=2, max_size=4, unique=True))
def test_the_order_in_series_is_that_of_the_peaks(hundreds: list[int]) -> None:
    found = [100.0 * n for n in hundreds]
    made = pull(in_series(*(single(KAPTON, p) for p in found)))
    ran = [i for _, i, what in made.order if what == "ends"]
    peaks = [float(peak(p, TRAVEL, KAPTON).force) for p in found]
    falling = [i for i in ran if bool(peak(found[i], TRAVEL, KAPTON).inside)]
    assert falling == sorted(falling, key=lambda i: peaks[i])


def test_totals() -> None:
    member = Member(brake=KAPTON, vacuum=P)
    made = totals(grid(member, series=3, parallel=2), chamber=7.5e-6)
    one = float(slip_work(TRAVEL, P, KAPTON))
    assert made.brakes == 6
    assert made.mass == pytest.approx(6 * mass(KAPTON))
    assert made.travel == pytest.approx(3 * TRAVEL)
    assert made.energy == pytest.approx(6 * one)
    assert made.stiffness == pytest.approx(2 * K / 3)
    assert made.volume == pytest.approx(45e-6)
    mixed = totals(in_parallel(single(KAPTON, P), single(PTFE, P, slack=0.01)))
    assert mixed.travel == pytest.approx(TRAVEL) and mixed.volume is None
    assert mixed.stiffness == pytest.approx(K + float(working_stiffness(PTFE)))


def test_a_lever_turns_force_into_torque() -> None:
    made = pull(single(KAPTON, P))
    angle, torque = made.torque(0.05)
    np.testing.assert_allclose(angle * 0.05, made.elongation)
    np.testing.assert_allclose(torque, made.force * 0.05)
    # work is the same either way
    assert np.trapezoid(torque, angle) == pytest.approx(outside_work(made), rel=1e-12)
    with pytest.raises(QuantityError, match="lever"):
        made.torque(0.0)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: Array(chains=()), "empty"),
        (lambda: Array(chains=(((),),)), "empty"),
        (lambda: single(KAPTON, 2e5), "member 1.vacuum"),
        (lambda: single(KAPTON, float("nan")), "member 1.vacuum"),
        (lambda: single(KAPTON, P, slack=-1e-3), "member 1.slack"),
        (lambda: grid(Member(brake=KAPTON, vacuum=P), series=0, parallel=1), "series"),
        (lambda: grid(Member(brake=KAPTON, vacuum=P), series=200, parallel=200), "10000"),
        (lambda: totals(single(KAPTON, P), chamber=0.0), "chamber"),
        (
            lambda: in_series(single(KAPTON, P), in_parallel(single(KAPTON, P), single(PTFE, P))),
            "parallel chains cannot be in series",
        ),
    ],
)
def test_what_cannot_be_is_refused(wrong: object, said: str) -> None:
    with pytest.raises(QuantityError, match=said):
        wrong()  # type: ignore[operator]


def test_antagonistic_pair_about_neutral() -> None:
    """Paper II-A: torque (F1 - F2) r, and (k1 + k2) r^2 while both are taut and stuck."""
    radius, stretch = 0.02, 5e-4
    k = K + float(working_stiffness(PTFE))
    angle = np.linspace(-0.01, 0.01, 21)
    made = pair((KAPTON, PTFE), (P, P), angle, radius, stretch)
    assert neutral_stiffness((KAPTON, PTFE), radius) == pytest.approx(k * radius**2)
    slope = np.diff(made.torque) / np.diff(angle)
    np.testing.assert_allclose(slope, k * radius**2, rtol=1e-9)
    np.testing.assert_allclose(made.torque, (made.forces[:, 0] - made.forces[:, 1]) * radius)


def test_equal_brakes_turn_alike_both_ways() -> None:
    out = np.linspace(0, 1, 60)
    one = pair((KAPTON, KAPTON), (P, P), out, 0.02)
    other = pair((KAPTON, KAPTON), (P, P), -out, 0.02)
    np.testing.assert_allclose(one.torque, -other.torque, atol=1e-12)
    assert one.torque.max() <= PEAK * 0.02 * (1 + 1e-9)
    # the one that turns slack carries nothing; the other is a brake being pulled
    np.testing.assert_allclose(one.forces[1:, 1], 0.0)
    want = np.asarray(force_at_elongation(out * 0.02, P, KAPTON))
    np.testing.assert_allclose(one.forces[:, 0], want, atol=1e-6)


def test_a_closed_turn_dissipates_and_balances() -> None:
    turn = np.concatenate(
        [np.linspace(0, 1, 125), np.linspace(1, -1, 250), np.linspace(-1, 0, 125)]
    )
    made = pair((KAPTON, KAPTON), (P, P), turn, 0.02, 2e-4)
    np.testing.assert_allclose(made.work, made.heat + made.stored, atol=1e-9)
    assert np.all(np.diff(made.heat) >= -1e-12) and made.heat[-1] > 0
    done = np.trapezoid(made.torque, made.angle)
    pretension = float(K * 2e-4**2)
    assert done + pretension == pytest.approx(made.work[-1], rel=2e-3)


@pytest.mark.slow
def test_a_pair_that_comes_apart_is_refused() -> None:
    with pytest.raises(QuantityError, match="brake 1 separates"):
        pair((KAPTON, KAPTON), (P, P), [0.0, 4.0], 0.02)


def test_a_pair_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(QuantityError, match="finite angles"):
        pair((KAPTON, KAPTON), (P, P), [0.0, np.nan], 0.02)
    with pytest.raises(QuantityError, match="vacuum 2"):
        pair((KAPTON, KAPTON), (P, 2e5), [0.0, 0.1], 0.02)
    with pytest.raises(QuantityError, match="radius"):
        pair((KAPTON, KAPTON), (P, P), [0.0, 0.1], 0.0)
