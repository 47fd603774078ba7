"""The enclosure with a hyperelastic law, against a strip of cells and its closed forms."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.optimize import brentq

from layerjam.brake.device.brake import Brake, validate
from layerjam.brake.device.hyperelastic import NAMES, Hyperelastic
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_law, enclosure_stretch
from layerjam.brake.mechanics.energy import pull_work, slip_work
from layerjam.brake.mechanics.hyperelastic import FirstLoading, largest_slip, make_strip
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.law import law
from layerjam.brake.mechanics.pull import (
    brake_force,
    force_at_elongation,
    slip_at_elongation,
    vacuum_for_force,
)
from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from layerjam.brake.mechanics.tracing import double_precision
from layerjam.brake.simulate.procedure import simple_pull
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import QuantityError
from layerjam.laboratory.identify.rubber import hyperelastic as fitted
from strategies import KAPTON

FULL, TOP = 94.5e3, 12.0
MODELS = {
    "neo-hookean": {"C1": 15e3},
    "mooney-rivlin": {"C1": 11e3, "C2": 9e3},
    "yeoh": {"C1": 11e3, "C2": 150.0, "C3": 0.5},
    "ogden-1": {"mu1": 20e3, "alpha1": 2.6},
    "ogden-2": {"mu1": 40e3, "alpha1": 1.4, "mu2": 300.0, "alpha2": 4.0},
}
SLIPS = np.array([1e-4, 2e-3, 1e-2, 2e-2])
VACUUMS = (2e3, 2e4, FULL)


@law
def strip(slip: object, vacuum: object, brake: Brake) -> tuple[object, FirstLoading]:
    """Strain at the ends of the faces, and the enclosure there."""
    faces = make_strip(vacuum, brake)
    return faces.stretch(slip), faces.load_to(slip)


def brake_of(model: str, top: float = TOP, whole: bool = False) -> Brake:
    """The Kapton brake with a law of the rubber; `whole`: what is not in it as zeros."""
    none = dict.fromkeys(("c10", "c01", "c20", "c30", "mu1", "mu2"), 0.0)
    rubber = {**none, "alpha1": 1.0, "alpha2": 1.0} if whole else {}
    rubber |= {NAMES[model][name]: value for name, value in MODELS[model].items()}
    return replace(KAPTON, hyperelastic=Hyperelastic(strain=top, **rubber))


def energy(model: str, strain: np.ndarray) -> np.ndarray:
    """Area under the stress that `sleeve` fits, by trapezia."""
    grid = np.linspace(0, TOP, 200_001)
    stress = fitted.stress(model, MODELS[model], grid)
    area = np.concatenate([[0], np.cumsum((stress[1:] + stress[:-1]) / 2 * np.diff(grid))])
    return np.interp(strain, grid, area)


def cells(model: str, slip: float, vacuum: float, count: int = 4000) -> np.ndarray:
    """Force, stretch, stored energy and heat of a strip of cells, each in balance with the next."""
    sheets = KAPTON.sheets
    section = sheets.width * KAPTON.enclosure.wall
    friction = KAPTON.film.friction_on_silicone * sheets.width * vacuum
    reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    grid = np.linspace(0, TOP, 200_001)
    table = fitted.stress(model, MODELS[model], grid)

    def strains(pull: float, reach: float) -> np.ndarray:
        place = (np.arange(count) + 0.5) / count * reach
        return np.interp(np.maximum(pull - friction * place, 0) / section, table, grid)

    def drawn(pull: float) -> tuple[np.ndarray, float]:
        moves = min(reach, pull / friction)  # the cells lie where there is tension
        return strains(pull, moves), moves / count

    def over(pull: float) -> float:
        strain, size = drawn(pull)
        return strain.sum() * size - slip / 2

    pull = brentq(over, 1e-9, section * table[-1], xtol=1e-13)
    strain, size = drawn(pull)
    moved = np.cumsum(strain[::-1])[::-1] * size - strain * size / 2
    held = section * energy(model, strain).sum() * size
    end = np.interp(pull / section, table, grid)
    return np.array([2 * pull, end, 4 * held, 4 * friction * moved.sum() * size])


@pytest.mark.parametrize("model", MODELS)
def test_force_stretch_and_energies_are_those_of_a_strip_of_cells(model: str) -> None:
    slip, vacuum = np.meshgrid(SLIPS, VACUUMS, indexing="ij")
    strain, made = strip(slip, vacuum, brake_of(model, whole=True))
    ours = np.array([made.force, strain, made.stored, made.heat])
    due = np.array([[cells(model, x, p) for p in VACUUMS] for x in SLIPS])
    np.testing.assert_allclose(ours, np.moveaxis(due, 2, 0), rtol=2e-4)


@pytest.mark.parametrize("model", ["yeoh", "ogden-2"])
def test_while_a_part_rests_the_slip_is_the_complementary_energy(model: str) -> None:
    slip = np.geomspace(1e-3, 2e-2, 12).reshape(4, 3)
    strain, _ = strip(slip, np.full((4, 3), FULL), brake_of(model, whole=True))
    stress = fitted.stress(model, MODELS[model], strain)
    one = enclosure_law(FULL, KAPTON)
    section = KAPTON.sheets.width * KAPTON.enclosure.wall
    assert (section * stress < one.friction * one.reach).all()
    due = 2 * section / float(one.friction) * (strain * stress - energy(model, strain))
    np.testing.assert_allclose(slip, due, rtol=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_small_strains_obey_the_one_modulus_and_no_vacuum_stretches_evenly(model: str) -> None:
    modulus = fitted.initial_modulus(model, MODELS[model])
    linear = replace(KAPTON, enclosure=replace(KAPTON.enclosure, modulus=modulus))
    # spreading, saturated, and evenly; the last two stretch it much, and relax it
    reach = float(enclosure_law(0.0, linear).reach)
    slip, vacuum = np.full((4, 3), 1e-13), np.full((4, 3), FULL)
    slip[1], vacuum[1], slip[2], vacuum[2], slip[3] = 1e-7, 1e-2, 0.04, 0.0, 0.0
    strain, made = strip(slip, vacuum, brake_of(model, whole=True))
    assert (strain[:2] < 2e-5).all()
    one = enclosure_law(vacuum[:2], linear)
    np.testing.assert_allclose(made.force[:2], one.force(slip[:2]), rtol=1e-4)
    even = 0.04 / (2 * reach)
    due = 2 * KAPTON.sheets.width * KAPTON.enclosure.wall
    due *= float(fitted.stress(model, MODELS[model], even))
    np.testing.assert_allclose(strain[2], even, rtol=1e-12)
    np.testing.assert_allclose(made.force[2], due, rtol=1e-12)
    assert (made.force[3] == 0).all() and (made.heat[3] == 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("vacuum", [500.0, FULL])
def test_work_is_the_area_under_the_force_and_a_pull_s_too(vacuum: float) -> None:
    brake = brake_of("yeoh")
    slip = 0.03 * np.linspace(0, 1, 3001) ** 2
    work = np.trapezoid(np.asarray(brake_force(slip, vacuum, brake)), slip)
    assert float(slip_work(0.03, vacuum, brake)) == pytest.approx(work, rel=1e-6)
    onset = float(brake_force(0.0, vacuum, brake)) / brake.stiffness_measured
    way = np.append(0.0, onset + (0.03 - onset) * np.linspace(0, 1, 3001) ** 2)
    pulled = np.asarray(force_at_elongation(way, vacuum, brake))
    due = np.trapezoid(pulled, way)
    assert float(pull_work(0.03, vacuum, brake)) == pytest.approx(due, rel=1e-5)
    # and the force at an elongation is that at its slip
    at = np.asarray(slip_at_elongation(way, vacuum, brake))
    sliding = at > 0
    force = np.asarray(brake_force(at[sliding], vacuum, brake))
    np.testing.assert_allclose(pulled[sliding], force, rtol=1e-9)


@pytest.mark.slow
def test_gradients_are_those_of_differences() -> None:
    brake = brake_of("yeoh")
    names = ("c10", "c20", "c30")

    def force(x: object, p: object, values: object, u: object) -> object:
        made = replace(brake.hyperelastic, **dict(zip(names, values, strict=True)))
        changed = replace(brake, hyperelastic=made)
        return brake_force(x, p, changed) + force_at_elongation(u, p, changed)

    at = (0.01, 3e4, (11e3, 150.0, 0.5), 0.012)
    with double_precision():
        slopes = jax.jit(jax.jacfwd(force, argnums=(0, 1, 2, 3)))(*at)
        for index, slope in enumerate(jax.tree.leaves(slopes)):
            leaves, tree = jax.tree.flatten(at)
            step = 1e-5 * leaves[index]
            up, down = (
                [v + sign * step * (i == index) for i, v in enumerate(leaves)] for sign in (1, -1)
            )
            rise = force(*tree.unflatten(up)) - force(*tree.unflatten(down))
            assert float(slope) == pytest.approx(float(rise) / (2 * step), rel=1e-5)


@pytest.mark.slow
def test_beyond_the_strain_that_was_fitted_there_is_no_force() -> None:
    brake = brake_of("yeoh", top=2.0)
    most = float(largest_slip(FULL, brake))
    slip = most * np.array([0.1, 0.5, 1 - 1e-6, 1 + 1e-6, 2.0])
    strain = np.asarray(enclosure_stretch(slip, FULL, brake))
    assert strain[2] == pytest.approx(2.0, rel=1e-5) and strain[0] < strain[1] < strain[2]
    assert np.isnan(strain).tolist() == [False] * 3 + [True] * 2
    np.testing.assert_array_equal(np.isnan(enclosure_force(slip, FULL, brake)), np.isnan(strain))
    with pytest.raises(QuantityError, match="beyond the measured"):
        tensile(replace(load("choi2018-kapton"), brake=brake), simple_pull(FULL, 0.01, 0.04))


def test_a_brake_with_one_modulus_has_no_fitted_strain() -> None:
    with pytest.raises(
        QuantityError, match=r"hyperelastic: this result needs a hyperelastic enclosure"
    ):
        largest_slip(FULL, replace(brake_of("yeoh"), hyperelastic=None))


@pytest.mark.slow
def test_a_pull_peaks_where_the_strain_is_q_over_c() -> None:
    brake = brake_of("yeoh")
    record = tensile(replace(load("choi2018-kapton"), brake=brake), simple_pull(FULL, 0.01, 0.03))
    top = int(np.argmax(record.force))
    sheets, film = brake.sheets, brake.film
    c = brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width
    ratio = film.friction_on_silicone * sheets.width / c
    strain = float(enclosure_stretch(record.slip[top], FULL, brake))
    assert strain == pytest.approx(ratio, rel=1e-6)
    fine = np.asarray(brake_force(np.linspace(0, 2e-3, 20_001), FULL, brake))
    assert record.force[top] == pytest.approx(fine.max(), rel=1e-9)
    # books: what was put in is heat or held
    book = record.dissipated_energy + record.stored_energy
    np.testing.assert_allclose(record.work, book, rtol=1e-9, atol=1e-12)
    assert (np.diff(record.dissipated_energy) >= -1e-12).all()


@pytest.mark.slow
def test_sheets_that_fan_out_peak_where_they_must() -> None:
    brake = brake_of("yeoh")
    brake = replace(brake, mount=replace(brake.mount, spacers=False))
    record = tensile(replace(load("choi2018-kapton"), brake=brake), simple_pull(FULL, 0.01, 0.03))
    fine = np.asarray(brake_force(np.linspace(0, 2e-3, 20_001), FULL, brake))
    assert record.force.max() == pytest.approx(fine.max(), rel=1e-9)
    sliding = record.slip > 0
    due = np.asarray(brake_force(record.slip[sliding], FULL, brake))
    np.testing.assert_allclose(record.force[sliding], due, rtol=1e-9)


def test_what_has_no_hyperelastic_law_refuses() -> None:
    brake = brake_of("yeoh")
    with pytest.raises(QuantityError, match="single modulus"):
        brake_cycle(np.linspace(0, 0.01, 9), FULL, brake, 0.01)
    with pytest.raises(QuantityError, match="single modulus"):
        vacuum_for_force(50.0, 0.01, brake)
    with pytest.raises(QuantityError, match="single modulus"):
        tuned_vacuum(1.0, 2.0, 0.02, 1e4, 9.81, brake)


@pytest.mark.parametrize(
    ("terms", "said"),
    [
        ({"c10": 1e4, "c20": -2e3}, "does not rise at a strain of"),
        ({"mu1": 1e4}, "together with alpha1"),
        ({"mu1": 1e4, "alpha1": 0.0}, "must not be zero"),
        ({}, "does not rise at a strain of 0"),
    ],
)
def test_a_law_that_cannot_be_is_refused(terms: dict[str, float], said: str) -> None:
    with pytest.raises(QuantityError, match=said):
        validate(replace(KAPTON, hyperelastic=Hyperelastic(strain=3.0, **terms)))


@pytest.mark.parametrize("left_out", ["r", "m", "beta", "r m", "r beta", "m beta"])
def test_a_part_of_the_softening_is_refused(left_out: str) -> None:
    given = {"softening_r": 1.5, "softening_m": 1e3, "softening_beta": 0.1}
    for name in left_out.split():
        del given[f"softening_{name}"]
    with pytest.raises(
        QuantityError, match=f"softening_{left_out.split(maxsplit=1)[0]}.*give all of"
    ):
        validate(replace(KAPTON, hyperelastic=Hyperelastic(strain=3.0, c10=1e4, **given)))
