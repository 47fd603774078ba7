"""Unloading, cycles and softening of a hyperelastic enclosure, against a chain of sliders."""

from __future__ import annotations

import inspect
import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erf

from brake.mechanics.slider_chain import Chain, Rubber
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.load import load
from layerjam.brake.mechanics import rubber_strip
from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_stretch
from layerjam.brake.mechanics.energy import slip_heat, slip_work
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.law import compiled, law
from layerjam.brake.mechanics.memory import enclosure_cycle
from layerjam.brake.mechanics.tracing import double_precision
from layerjam.brake.simulate.procedure import parse_procedure
from layerjam.brake.simulate.record import Outcome
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import ProcedureError, QuantityError
from strategies import KAPTON, LENGTHS, padded, unchecked

TERMS = {"c1": 11e3, "c2": 300.0}
SOFTENING = {"r": 1.7, "m": 4e3, "beta": 0.2}
FIRM = replace(KAPTON, hyperelastic=Hyperelastic(strain=12.0, c10=11e3, c20=300.0))
SOFT = replace(
    FIRM,
    hyperelastic=replace(FIRM.hyperelastic, softening_r=1.7, softening_m=4e3, softening_beta=0.2),
)
SECTION = KAPTON.sheets.width * KAPTON.enclosure.wall
REACH = (KAPTON.sheets.free_left + KAPTON.sheets.overlap + KAPTON.sheets.free_right) / 2
Q = KAPTON.film.friction_on_silicone * KAPTON.sheets.width
HISTORIES = {
    "spreads": (0.03, 4e3, (0, 1, 0.75, 0.95, 0.8, 0.9, 0.72, 1.2)),
    "moves as a whole": (0.04, 300.0, (0, 0.6, 0.4, 0.55, 0.45, 1, 0.65, 0.9)),
}


def path(*turns: float, steps: int = 6) -> np.ndarray:
    """Dense after every turn, where the force goes as a root."""
    grid = np.linspace(0, 1, steps + 1)[1:] ** 2
    legs = [a + (b - a) * grid for a, b in itertools.pairwise(turns)]
    return np.concatenate([[turns[0]], *legs])


def run(brake: Brake, slip: np.ndarray, vacuum: object) -> np.ndarray:
    slips, vacuums, n = padded(slip, vacuum, LENGTHS if brake.hyperelastic is None else (1024,))
    return np.array(enclosure_cycle(slips, vacuums, brake))[:, :n]


def chained(slip: np.ndarray, vacuum: np.ndarray, nodes: int) -> np.ndarray:
    """Force, elastic energy and all that became heat, of the chain of sliders."""
    chain = Chain(Rubber(**TERMS, **SOFTENING), SECTION, REACH, nodes)
    rows = []
    for x, p in zip(slip, np.broadcast_to(vacuum, slip.shape), strict=True):
        force = chain.pull(x, Q * p)
        rows.append((force, chain.given_back(), chain.heat + chain.softened()))
    return np.array(rows).T


@pytest.mark.slow
@pytest.mark.parametrize("name", HISTORIES)
def test_nested_loops_agree_with_a_chain_of_sliders(name: str) -> None:
    """Within the chain's error, which falls as it is refined."""
    size, vacuum, turns = HISTORIES[name]
    slip = size * path(*turns, steps=3)
    ours = run(SOFT, slip, vacuum)
    scale = ours.max(axis=1)
    off = [np.abs(ours - chained(slip, vacuum, n)).max(axis=1) / scale for n in (16, 64)]
    assert (off[1] < 0.01).all() and (off[1] < 0.5 * off[0]).all()


@pytest.mark.slow
def test_a_vacuum_that_rises_agrees_with_the_chain_and_one_that_falls_is_not_known() -> None:
    slip = 0.02 * path(0, 1, 0.9, 1.3, steps=4)
    vacuum = np.where(np.arange(len(slip)) < 7, 1e3, 4e3)
    ours, due = run(SOFT, slip, vacuum), chained(slip, vacuum, 80)
    assert np.abs(ours - due).max() < 0.01 * due.max()
    fallen = run(SOFT, slip, vacuum[::-1])
    assert np.isfinite(fallen[:, :6]).all() and np.isnan(fallen[:, 6:]).all()
    pushed = run(SOFT, 0.02 * path(0, 1, 0, steps=4), 4e3)
    assert np.isfinite(pushed[:, 4]).all() and np.isnan(pushed[:, 8]).all()


def test_small_strains_without_softening_follow_masing_s_rule() -> None:
    """To a ten-thousandth: the strain itself, and the cells."""
    slip, vacuum = 2e-7 * path(0, 1, 0.7, 0.9, 0.75, 1.1, 0.8, steps=8), 0.02
    modulus = 6 * FIRM.hyperelastic.c10
    linear = replace(KAPTON, enclosure=replace(KAPTON.enclosure, modulus=modulus))
    for pressure in (vacuum, 5 * vacuum):
        ours, due = run(FIRM, slip, pressure), run(linear, slip, pressure)
        np.testing.assert_allclose(ours, due, atol=2e-4 * due.max(axis=1).max(), rtol=1e-3)


@pytest.mark.slow
def test_first_loading_is_the_closed_one_and_the_cells_converge_with_their_square() -> None:
    slip = 0.04 * path(0, 1, steps=20)[1:]
    due = np.asarray(enclosure_force(slip, 2e3, SOFT))
    heat = np.asarray(slip_heat(slip, 2e3, unchecked(SOFT, scale_factor=1e-12)))

    @law
    @compiled
    def cells(slip: object, vacuum: object, brake: Brake) -> tuple[object, ...]:
        made = []
        for count in (30, 60, 120):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(rubber_strip.make_cells, "__defaults__", (count,))
                # the function itself, because its program is compiled once
                made.append(inspect.unwrap(enclosure_cycle)(slip, vacuum, brake))
        return tuple(made)

    with double_precision():
        made = cells(slip, np.full(len(slip), 2e3), SOFT)
    for index, exact in ((0, due), (2, heat)):
        off = [np.abs(np.asarray(one[index]) - exact).max() / exact.max() for one in made]
        orders = np.log2(np.array(off[:-1]) / off[1:])
        assert (orders > 1.7).all() and off[-1] < 1e-3, (index, off)


def test_a_closed_loop_is_wiped_out_and_no_energy_comes_from_nowhere() -> None:
    turns = (0, 0.8, 0.7, 0.75, 0.72, 0.8, 1.0, 0.8, 1.0, 0.8, 1.0)
    slip = 0.04 * path(*turns, steps=100)
    force, stored, heat = run(SOFT, slip, 2e3)
    work = np.append(0, np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(slip)))
    np.testing.assert_allclose(work, stored + heat, atol=2e-4 * work[-1])
    assert (np.diff(heat) >= -1e-15).all() and (stored >= 0).all()
    # back at its greatest slip the enclosure is as in a first pull, whatever lay in between
    for end in (500, 600, 800, 1000):
        due = float(enclosure_force(slip[end], 2e3, SOFT))
        assert force[end] == pytest.approx(due, rel=1e-4)
    # a cycle up to the greatest slip so far softens no more: it repeats, and costs friction alone
    np.testing.assert_allclose(force[601:801], force[801:1001], rtol=1e-9)
    firm = run(FIRM, slip, 2e3)
    assert (force[601:700] < 0.999 * firm[0][601:700]).all()


def test_without_vacuum_a_second_stretch_is_softer_by_ogden_and_roxburgh_s_factor() -> None:
    slip = 0.04 * path(0, 1, 0, 1, 1.2, steps=8)
    force, stored, heat = run(SOFT, slip, 0.0)
    rubber, strain = Rubber(**TERMS, **SOFTENING), slip / (2 * REACH)
    held = np.maximum.accumulate(rubber.first(strain)[1])
    np.testing.assert_allclose(
        force, 2 * SECTION * rubber.stress(strain, held), rtol=1e-9, atol=1e-15
    )
    assert np.asarray(enclosure_stretch(slip[4], 0.0, SOFT)) == pytest.approx(strain[4])
    # what a stretch took is the area between the two curves
    grid = np.linspace(0, strain[8], 20_001)
    top = rubber.first(strain[8])[1]
    lost = np.trapezoid(rubber.stress(grid, 0 * grid) - rubber.stress(grid, top), grid)
    np.testing.assert_allclose(heat[8:25], 4 * SECTION * REACH * lost, rtol=1e-6)
    assert stored[16] == pytest.approx(0, abs=1e-12) and heat[-1] > heat[24]
    # and the stress falls by at most 1/r
    first = 2 * SECTION * rubber.first(strain)[0]
    assert (force >= first * (1 - 1 / 1.7) * (1 - 1e-9)).all()
    assert 1 - erf(top / (4e3 + 0.2 * top)) / 1.7 == pytest.approx(force[17] / first[17], rel=0.05)


def test_a_first_stretch_turns_into_heat_what_softening_takes() -> None:
    """Without vacuum: the area between the first curve and the softened one; no work is lost."""
    slip = 0.04 * np.array([0.3, 0.6, 1.0])
    rubber = Rubber(**TERMS, **SOFTENING)
    grid = slip / (2 * REACH) * np.linspace(0, 1, 20_001)[:, None]
    first, energy = rubber.first(grid)
    lost = np.trapezoid(first - rubber.stress(grid, energy[-1]), grid, axis=0)
    volume = 4 * SECTION * REACH
    np.testing.assert_allclose(slip_heat(slip, 0.0, SOFT), volume * lost, rtol=1e-6)
    np.testing.assert_allclose(slip_work(slip, 0.0, SOFT), volume * energy[-1], rtol=1e-9)


def test_the_brake_s_cycle_is_that_of_one_modulus_at_small_strains() -> None:
    """Pulled, closed by its enclosure, slack, and pulled again."""
    linear = replace(KAPTON, enclosure=replace(KAPTON.enclosure, modulus=6 * 11e3))
    elongation, vacuum = 2e-6 * path(0, 1, 0, 1.5, 0.4, steps=12), 0.005
    longer, _, n = padded(elongation, vacuum)
    ours, due = (brake_cycle(longer, vacuum, brake) for brake in (FIRM, linear))
    assert due.closed[n - 1] and due.slack[:n].any()
    for name in ("force", "slip", "sleeve_force", "work", "heat", "stored"):
        a, b = (np.asarray(getattr(one, name))[:n] for one in (ours, due))
        np.testing.assert_allclose(a, b, atol=5e-4 * b.max(), err_msg=name)
    np.testing.assert_array_equal(ours.slack, due.slack)
    np.testing.assert_array_equal(ours.closed, due.closed)


@pytest.mark.slow
def test_a_procedure_returns_and_pulls_again_softer() -> None:
    file = replace(load("choi2018-kapton"), brake=SOFT)
    steps = "evacuate to 300 Pa; pull at 1 mm/s until 40 mm; return at 1 mm/s to 0 mm; "
    steps += "pull at 1 mm/s until 45 mm"
    record = tensile(file, parse_procedure(steps))
    assert record.outcome is Outcome.CLOSED_BY_SLEEVE
    np.testing.assert_allclose(
        record.work, record.dissipated_energy + record.stored_energy, rtol=1e-9, atol=1e-12
    )
    area = np.append(
        0, np.cumsum(np.diff(record.elongation) * (record.force[1:] + record.force[:-1]) / 2)
    )
    assert record.work[-1] == pytest.approx(area[-1], rel=1e-3)
    turn = int(np.argmax(record.elongation >= 0.04))
    again = turn + int(np.argmin(record.elongation[turn:]))
    middle = [
        np.interp(0.03, *(np.asarray(c)[part] for c in (record.elongation, record.sleeve_force)))
        for part in (slice(0, turn), slice(again, None))
    ]
    assert middle[1] < 0.9 * middle[0]
    assert (np.diff(record.dissipated_energy) >= -1e-12).all()
    # beyond the first pull both are first loading
    alone = tensile(file, parse_procedure("evacuate to 300 Pa; pull at 1 mm/s until 45 mm"))
    assert record.force[-1] == pytest.approx(alone.force[-1], rel=1e-4)


def test_what_is_not_known_is_refused() -> None:
    file = replace(load("choi2018-kapton"), brake=SOFT)
    vented = "evacuate to 50 kPa; pull at 1 mm/s until 9 mm; vent; pull at 1 mm/s until 20 mm"
    with pytest.raises(ProcedureError, match="the vacuum falls"):
        tensile(file, parse_procedure(vented))
    short = replace(SOFT, hyperelastic=replace(SOFT.hyperelastic, strain=2.0))
    back = "evacuate to 50 kPa; pull at 1 mm/s until 40 mm; return at 1 mm/s to 0 mm"
    with pytest.raises(QuantityError, match="beyond the measured"):
        tensile(replace(file, brake=short), parse_procedure(back))
    with pytest.raises(QuantityError, match="or none"):
        replace(FIRM, hyperelastic=replace(FIRM.hyperelastic, softening_m=4e3))
