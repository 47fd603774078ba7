"""Pulls that share a mounting: intervals against a Monte Carlo, groups against scipy's F test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from identify.fitted import campaign
from layerjam.identify.calibration.intervals import Population, quantile
from layerjam.identify.calibration.mountings import find_mountings
from layerjam.identify.calibration.peaks import calibrate_peaks
from layerjam.identify.curves import Curve
from strategies import KAPTON

VACUUMS = (30e3, 60e3, 90e3)


@pytest.fixture(scope="module")
def curves() -> tuple[Curve, ...]:
    """Three vacuums, three pulls of each, numbered within their vacuum."""
    return campaign(VACUUMS, 3, spread=(0.02, 0.02, 0.0), noise=0.05)


def stated(curves: tuple[Curve, ...], numbers: list[int | None]) -> tuple[Curve, ...]:
    return tuple(replace(c, mounting=n) for c, n in zip(curves, numbers, strict=True))


def test_means_over_joined_pulls_are_students_means_of_mountings() -> None:
    """Three mountings of four pulls: mean, error and degrees of the three means (scipy)."""
    values = np.random.default_rng(1).normal(10, 1, 12)
    plain = Population(
        estimate=np.array([values.mean()]),
        design=np.ones((12, 1, 1)),
        residual=(values - values.mean())[:, None],
    )
    joined = plain.join_groups([(0, 1, 2, 3), (4, 5, 6, 7), (8, 9, 10, 11)])
    error, degrees = joined.standard_error(np.ones(1))
    means = values.reshape(3, 4).mean(axis=1)
    assert joined.estimate == plain.estimate
    assert error == pytest.approx(stats.sem(means)) and degrees == pytest.approx(2)
    same = plain.join_groups([(n,) for n in range(12)]).standard_error(np.ones(1))
    assert same == pytest.approx(plain.standard_error(np.ones(1)))


@pytest.mark.parametrize("between", [0.0, 1.0, 5.0])
@pytest.mark.parametrize("sizes", [(6, 6, 6), (2, 5, 6, 3)])
def test_joined_pulls_cover_the_truth_whatever_they_share(
    between: float, sizes: tuple[int, ...]
) -> None:
    """Drawn means, equal and unequal mountings; pulls taken one by one cover 45 % (last case)."""
    random, inside, alone = np.random.default_rng(2), 0, 0
    places = np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])
    for _ in range(1500):
        values = random.standard_normal(sum(sizes))
        for group in places:
            values[group] += between * random.standard_normal()
        plain = Population(
            estimate=np.array([values.mean()]),
            design=np.ones((len(values), 1, 1)),
            residual=(values - values.mean())[:, None],
        )
        for units, kind in ((plain.join_groups(places), 0), (plain, 1)):
            error, degrees = units.standard_error(np.ones(1))
            hit = abs(values.mean()) <= quantile(degrees) * error
            inside, alone = inside + (hit and kind == 0), alone + (hit and kind == 1)
    assert 0.93 <= inside / 1500 <= 0.98
    if between == 5.0 and len(sizes) == 3:
        assert alone / 1500 < 0.6


def test_stated_mountings_are_used(curves: tuple[Curve, ...]) -> None:
    found = calibrate_peaks(stated(curves, [1, 2, 3] * 3), KAPTON)
    assert found.mountings == ((0, 3, 6), (1, 4, 7), (2, 5, 8))
    means = [np.mean([found.fits[n].scale_factor for n in group]) for group in found.mountings]
    scatter = found.contributions[0]
    assert scatter.standard == pytest.approx(stats.sem(means) / np.mean(means))
    assert scatter.degrees == pytest.approx(2)
    [check] = [c for c in found.checks if c.name == "mountings"]
    assert check.passed and "3 mountings" in check.sentence
    assert "3 mountings of 9 pulls" in found.errors_rest_on


def test_unstated_mountings_are_taken_from_the_scatter(curves: tuple[Curve, ...]) -> None:
    """F of a two-way table without interaction, as scipy gives it, decides."""
    random = np.random.default_rng(5)
    table = random.normal(0, 0.01, (3, 3)) + random.normal(0, 0.1, (3, 1))  # vacuum by pull
    shared = random.normal(0, 0.05, 3)
    for effect in (shared, 0 * shared):
        logs = (table + effect).ravel()[:, None]
        rest = table + effect - (table + effect).mean(axis=1, keepdims=True)
        means = rest.mean(axis=0)
        ratio = 3 * (means**2).sum() / 2 / (((rest - means) ** 2).sum() / 4)
        chance = stats.f.sf(ratio, 2, 4)
        found = find_mountings(curves, logs)
        assert f"p = {chance:.2g}" in found.check.sentence
        assert (len(found.groups) == 3) == (chance <= 0.25)
        assert found.check.passed == (chance > 0.005)
    assert len(find_mountings(curves, table.ravel()[:, None]).groups) in (3, 9)


def test_one_vacuum_tells_no_mountings(curves: tuple[Curve, ...]) -> None:
    found = find_mountings(stated(curves[:3], [None] * 3), np.zeros((3, 1)))
    assert found.groups == ((0,), (1,), (2,)) and found.check.passed
    assert "no mounting is stated" in found.check.sentence
    one = find_mountings(stated(curves[:3], [1, 1, 1]), np.zeros((3, 1)))
    assert "all pulls state one mounting" in one.check.sentence and len(one.groups) == 3
