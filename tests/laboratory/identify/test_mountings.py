"""Pulls that share a mounting: intervals against a Monte Carlo, groups against scipy's F test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from laboratory.identify.fitted import campaign
from layerjam.laboratory.identify.calibration.intervals import Population, quantile
from layerjam.laboratory.identify.calibration.mountings import find_mountings
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.curves import Curve
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


@pytest.mark.parametrize("numbers", [[None] * 9, [1] * 9, [1, None] * 4 + [2]])
def test_unstated_mountings_may_be_one(
    curves: tuple[Curve, ...], numbers: list[int | None]
) -> None:
    """The interval includes 5 % between mountings, or the scatter of the pulls if that is more."""
    found = calibrate_peaks(stated(curves, numbers), KAPTON)
    assert len(found.mountings) == 9
    logs = np.log([[f.scale_factor, f.stiffness] for f in found.fits])
    for spread in (1.0, 0.2 / logs[:, 0].std(ddof=1)):
        one = find_mountings(stated(curves, numbers), (logs - logs.mean(axis=0)) * spread)
        due = max(0.05, spread * logs[:, 0].std(ddof=1))
        assert one.unseen["scale_factor"] == pytest.approx(due)
        assert one.check.passed and f"{due:.1%}" in one.check.sentence
    parts = [c.relative for c in found.contributions if c.relative]
    interval = found.intervals["scale_factor"]
    assert interval.standard_error / found.scale_factor == pytest.approx(np.hypot.reduce(parts))
    assert [c.what for c in found.contributions][2] == "mounting"


def test_two_mountings_do_not_show_their_scatter(curves: tuple[Curve, ...]) -> None:
    """Student's t of two is 12.7: the scatter is 5 %, or that of the two means if it is more."""
    numbers = [1] * 5 + [2] * 4
    for gap, due in ((0.01, 0.05), (0.2, 0.2 / 2**0.5)):
        logs = np.array([[gap * (n == 2), 0.0] for n in numbers])
        found = find_mountings(stated(curves, numbers), logs)
        assert found.unseen["scale_factor"] == pytest.approx(due / 2**0.5)
        assert "only 2 mountings" in found.check.sentence
    assert not find_mountings(stated(curves, [1, 2, 3] * 3), logs).unseen
