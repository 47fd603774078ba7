"""Bands and chances against the laws they come from; "cannot" counts and is told."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import (
    brake_force,
    force_at_elongation,
    force_limits,
    peak,
    vacuum_for_force,
)
from layerjam.brake.mechanics.stop.exact import stop
from layerjam.brake.simulate.drop import series_spring
from layerjam.core.errors import QuantityError
from layerjam.core.units import get_spec
from layerjam.laboratory.identify.bayes.posterior import Population, _summarise_draws
from layerjam.laboratory.identify.bayes.predictive import (
    LEVELS,
    Band,
    drop_band,
    force_band,
    peak_band,
    vacuum_band,
)
from strategies import KAPTON, PTFE, change

ROPE = 16.8e3


def population(spread: float, draws: int = 4000, seed: int = 1, **of: Any) -> Population:
    """Brakes about KAPTON's, with log-normal spread of all three numbers."""
    random = np.random.default_rng(seed)
    z = np.exp(spread * random.standard_normal((3, draws)))
    return Population(
        brake=of.get("brake", KAPTON),
        scale_factor=0.875 * z[0],
        stiffness=131e3 * z[1],
        enclosure_factor=z[2],
        residual=np.full(draws, of.get("residual", 0.0)),
    )


@pytest.mark.slow
def test_without_spread_every_quantile_is_the_law() -> None:
    same = population(0.0)
    u, force = np.linspace(0, 0.04, 30), np.array([20.0, 60.0, 120.0])
    law = np.asarray(force_at_elongation(u, 80e3, KAPTON))
    assert force_band(same, u, 80e3).values == pytest.approx(np.tile(law, (5, 1)), rel=1e-12)
    vacuum = np.asarray(vacuum_for_force(force, 0.02, KAPTON))
    assert vacuum_band(same, force, 0.02).quantile_at(0.5) == pytest.approx(vacuum, rel=1e-12)
    top = peak_band(same, [31e3, 94.5e3])
    expected = np.asarray(peak(np.array([31e3, 94.5e3]), 0.06, KAPTON).force)
    assert top.quantile_at(0.975) == pytest.approx(expected, rel=1e-12)
    made = drop_band(same, mass=1.0, speed=[2.5, 3, 3], vacuum=[94.5e3, 8e4, 8e4],
                     rope_stiffness=ROPE)  # fmt: skip
    # check values of design/mechanics.md, section 6
    assert made.slip.quantile_at(0.5) == pytest.approx(
        [17.0251044e-3, 44.0565365e-3, 44.0565365e-3], rel=1e-7
    )
    assert made.peak_force.quantile_at(0.5) == pytest.approx(
        [175.925038, 149.007238, 149.007238], rel=1e-8
    )


def test_quantiles_are_those_of_the_draws() -> None:
    of = population(0.1)
    found = vacuum_band(of, 60.0, 0.02)
    each = [
        float(vacuum_for_force(60.0, 0.02, change(KAPTON, scale_factor=float(a),
              enclosure__modulus=1e5 * float(f), film__friction_on_silicone=0.8 * float(f))))
        for a, f in zip(of.scale_factor[:200], of.enclosure_factor[:200], strict=True)
    ]  # fmt: skip
    few = vacuum_band(replace_draws(of, 200), 60.0, 0.02)
    exact = np.quantile(each, LEVELS, method="inverted_cdf")
    assert few.values[:, 0] == pytest.approx(exact, rel=1e-9)
    assert (np.diff(found.values, axis=0) > 0).all()


def replace_draws(of: Population, count: int) -> Population:
    return replace(
        of, scale_factor=of.scale_factor[:count], stiffness=of.stiffness[:count],
        enclosure_factor=of.enclosure_factor[:count], residual=of.residual[:count],
    )  # fmt: skip


def test_a_force_beyond_all_vacuum_is_an_answer() -> None:
    of = population(0.05)
    _, most = (float(x) for x in force_limits(0.02, KAPTON))
    found = vacuum_band(of, [0.5 * most, most, 2 * most], 0.02)
    assert found.chances["too strong"] == pytest.approx([0.0, 0.5, 1.0], abs=0.03)
    assert np.isfinite(found.values[:, 0]).all()
    assert np.isfinite(found.quantile_at(0.25)[1]) and np.isinf(found.quantile_at(0.75)[1])
    assert np.isinf(found.values[:, 2]).all()
    assert "too strong 100.0%" in found.sentence(2) and "vacuum none" in found.sentence(2)


def test_a_force_below_the_sleeves_own_is_an_answer() -> None:
    of = population(0.05)
    least, _ = (float(x) for x in force_limits(0.04, KAPTON))
    found = vacuum_band(of, [least / 2, least], 0.04)
    assert found.chances["enclosure alone"] == pytest.approx([1.0, 0.5], abs=0.03)
    assert (found.quantile_at(0.5)[0], found.quantile_at(0.25)[1]) == (-np.inf, -np.inf)
    assert "below" in found.sentence(0)


def test_bottoming_out_counts_as_infinite() -> None:
    of = population(0.08)
    found = drop_band(of, mass=1.0, speed=[1.0, 3.2, 4.5], vacuum=80e3, rope_stiffness=ROPE)
    whole = sum(found.chances.values())
    assert whole == pytest.approx([1.0, 1.0, 1.0])
    out = found.chances["bottomed out"]
    assert out[0] == 0 and 0.05 < out[1] < 0.95 and out[2] == 1
    # a quantile is infinite exactly where the chance of no answer exceeds what lies above it
    for level in LEVELS:
        assert np.isinf(found.slip.quantile_at(level)[1]) == (1 - level < out[1])
    assert np.nanmax(found.slip.values[np.isfinite(found.slip.values)]) <= 0.06


def test_the_chance_of_bottoming_out_is_that_of_single_drops() -> None:
    few = population(0.08, 40)
    of = Population(
        brake=KAPTON,
        **{
            n: np.tile(getattr(few, n), 100)
            for n in ("scale_factor", "stiffness", "enclosure_factor")
        },
        residual=np.zeros(4000),
    )
    found = drop_band(of, mass=1.0, speed=[3.2] * 3, vacuum=80e3, rope_stiffness=ROPE)
    lost = 0
    for a, k, f in zip(few.scale_factor, few.stiffness, few.enclosure_factor, strict=True):
        brake = change(
            KAPTON, scale_factor=float(a), stiffness_measured=float(k),
            enclosure__modulus=1e5 * float(f), film__friction_on_silicone=0.8 * float(f),
        )  # fmt: skip
        end = stop(1.0, 3.2, 80e3, series_spring(brake, ROPE), 9.80665, brake)
        lost += float(end.end_speed) > 0
    assert found.chances["bottomed out"][0] == pytest.approx(lost / 40)


def test_a_soft_rope_snaps() -> None:
    found = drop_band(
        population(0.05), mass=1.0, speed=[5.0] * 3, vacuum=94.5e3, rope_stiffness=2.6e3
    )
    assert 0.1 < found.chances["snaps"][0] < 0.9
    soft = replace(population(0.05), stiffness=np.full(4000, 2.6e3))
    band = force_band(soft, [0.01], 94.5e3)
    assert 0.1 < band.chances["snaps"][0] < 0.9 and np.isfinite(band.values).all()


def test_chances_are_calibrated() -> None:
    """Truths drawn as the population was: what was given 30 % happens in 30 % of the cases."""
    of, truths = population(0.06, seed=2), population(0.06, 3000, seed=3)
    brakes = truths.brakes()
    top = np.asarray(peak(80e3, 0.06, brakes).force)[:, 0]
    band = peak_band(of, 80e3, levels=(0.1, 0.3, 0.5, 0.7, 0.9))
    below = [(top < value).mean() for value in band.values[:, 0]]
    assert below == pytest.approx([0.1, 0.3, 0.5, 0.7, 0.9], abs=0.03)
    _, most = (np.asarray(x)[:, 0] for x in force_limits(0.02, brakes))
    asked = np.array([120.0, 135.0, 140.0, 150.0, 165.0])
    chance = vacuum_band(of, asked, 0.02).chances["too strong"]
    assert chance == pytest.approx([(most < f).mean() for f in asked], abs=0.03)


def test_a_measured_curve_scatters_more_than_the_law() -> None:
    u = np.array([0.005, 0.02])
    law = force_band(population(0.0, 4000, residual=0.01), u, 80e3)
    seen = force_band(population(0.0, 4000, residual=0.01), u, 80e3, measured=True)
    height = float(peak(80e3, 0.06, KAPTON).force)
    assert np.ptp(law.values, axis=0) == pytest.approx([0, 0], abs=1e-9)
    width = (seen.quantile_at(0.975) - seen.quantile_at(0.025)) / 2
    assert width == pytest.approx([1.96 * 0.01 * height] * 2, rel=0.06)
    again = force_band(population(0.0, 4000, residual=0.01), u, 80e3, measured=True)
    assert (again.values == seen.values).all()


def test_forces_of_the_median_vacuum_are_the_asked_one() -> None:
    of = population(0.05)
    pressure = float(vacuum_band(of, 60.0, 0.02).quantile_at(0.5)[0])
    forces = np.asarray(brake_force(0.02, pressure, of.brakes()))
    assert np.median(forces) == pytest.approx(60.0, rel=2e-3)


def test_another_film_and_a_pressure_exponent() -> None:
    brake = change(PTFE, pressure_exponent=0.1, test_pressure=3900.0)
    of = replace(population(0.0, 5, brake=brake), scale_factor=np.full(5, 1.24))
    own = replace(brake, scale_factor=1.24, stiffness_measured=131e3)
    expected = float(vacuum_for_force(30.0, 0.02, own))
    assert vacuum_band(of, 30.0, 0.02).quantile_at(0.5)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda p: force_band(p, [-0.01], 80e3), "elongation: -10 mm"),
        (lambda p: force_band(p, [0.01], np.nan), "vacuum: nan"),
        (lambda p: vacuum_band(p, [10.0], 0.08), "at most the overlap, 68 mm"),
        (lambda p: vacuum_band(p, [-1.0], 0.01), "force: -1 N"),
        (lambda p: drop_band(p, mass=0.0, speed=1.0, vacuum=8e4), "mass: 0 g .* more than zero"),
        (lambda p: peak_band(p, 8e4, levels=(0.5, 1.0)), "levels: 1 is not allowed"),
    ],
)
def test_bad_questions(call: Any, word: str) -> None:
    with pytest.raises(QuantityError, match=word):
        call(population(0.0, 3))


def test_a_level_not_asked_for() -> None:
    band = Band(quantity="force", unit="N", levels=(0.5,), values=np.ones((1, 1)))
    with pytest.raises(KeyError):
        band.quantile_at(0.9)


def test_a_summary_is_that_of_the_draws() -> None:
    """2.5 % of the draws lie on each side of the interval: counted, not interpolated."""
    draws = np.random.default_rng(3).gamma(2.0, 5.0, 4000)
    row = _summarise_draws(draws, get_spec(Brake, "scale_factor"), 1.0, 900.0, "")
    below, above = np.mean(draws < row.low), np.mean(draws > row.high)
    assert below == pytest.approx(0.025, abs=3e-4) and above == pytest.approx(0.025, abs=3e-4)
    assert np.mean(draws < row.median) == pytest.approx(0.5, abs=3e-4)
    assert row.mean == pytest.approx(draws.sum() / 4000)
    assert row.sd**2 == pytest.approx(((draws - row.mean) ** 2).sum() / 3999)
