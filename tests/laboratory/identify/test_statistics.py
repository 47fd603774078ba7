"""Means, intervals, lines and bins against SciPy, in other units and from another origin."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from layerjam.laboratory.identify.logs.correlated import average_bins, fit_series
from layerjam.laboratory.identify.statistics import (
    OverRepeats,
    fit_line,
    interval_ends,
    summarise_repeats,
)

RNG = np.random.default_rng(31)
SAMPLES = [RNG.normal(20, 3, count) for count in (2, 3, 7, 40)]


@pytest.mark.parametrize("values", SAMPLES, ids=len)
def test_a_mean_has_the_t_interval_of_scipy(values: np.ndarray) -> None:
    made = summarise_repeats(values.tolist(), positive=False)
    expected = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
    assert (made.low, made.high) == pytest.approx((expected.low, expected.high), rel=1e-12)
    assert made.mean == pytest.approx(values.mean()) and made.repeats == len(values)
    assert made.standard_error == pytest.approx(stats.sem(values))
    assert made.sd == pytest.approx(stats.tstd(values))


@pytest.mark.parametrize("values", SAMPLES, ids=len)
@pytest.mark.parametrize("positive", [False, True])
def test_the_unit_of_a_quantity_does_not_change_its_interval(
    values: np.ndarray, positive: bool
) -> None:
    one = summarise_repeats(values.tolist(), positive, 0.3)
    other = summarise_repeats((1e3 * values).tolist(), positive, 300.0)
    for name in ("mean", "sd", "standard_error", "low", "high"):
        assert getattr(other, name) == pytest.approx(1e3 * getattr(one, name), rel=1e-12), name


def test_an_error_that_all_repeats_share_adds_in_quadrature() -> None:
    values = SAMPLES[2].tolist()
    plain, wide = (summarise_repeats(values, False, limit) for limit in (0.0, 2.0))
    for one in (plain, wide):
        assert one.low is not None and one.high is not None
        assert one.high - one.mean == pytest.approx(one.mean - one.low)
    added = (wide.high - wide.mean) ** 2 - (plain.high - plain.mean) ** 2
    assert added == pytest.approx((1.96 * 2.0 / math.sqrt(3)) ** 2, rel=1e-9)
    assert wide.standard_error == plain.standard_error


def test_one_repeat_has_no_interval() -> None:
    made = summarise_repeats([4.0])
    assert made == OverRepeats(
        mean=4.0, sd=None, standard_error=None, low=None, high=None, repeats=1
    )
    assert made.describe_interval() == "one repeat" and made.as_dict()["level"] == 0.95


@pytest.mark.parametrize("value", [3.0, -3.0, 1e-9])
def test_an_interval_of_a_positive_quantity_is_symmetric_in_its_logarithm(value: float) -> None:
    for share in (1e-4, 0.1, 0.9, 5.0):
        low, high = interval_ends(value, share * abs(value))
        assert low < value < high and low * high == pytest.approx(value**2, rel=1e-12)
        assert math.log(high / value) == pytest.approx(math.copysign(share, value), rel=1e-9)
    near = interval_ends(value, 1e-6 * abs(value))
    assert near == pytest.approx(interval_ends(value, 1e-6 * abs(value), False), rel=1e-11)
    assert interval_ends(0.0, 2.0) == (-2.0, 2.0)
    assert all(map(math.isfinite, interval_ends(value, 1e9)))


@pytest.mark.parametrize("count", [3, 8, 200])
def test_a_line_is_that_of_scipy_from_any_origin_and_in_any_unit(count: int) -> None:
    x = RNG.uniform(-2, 5, count)
    y = 3 - 0.7 * x + RNG.normal(0, 0.2, count)
    line, known = fit_line(x, y), stats.linregress(x, y)
    assert line is not None and line.freedom == count - 2
    assert (line.slope, line.slope_se) == pytest.approx((known.slope, known.stderr), rel=1e-9)
    assert line.value_at(0.0) == pytest.approx(known.intercept, rel=1e-9)
    assert line.value_at(line.meets(11.0)) == pytest.approx(11.0, rel=1e-9)
    moved = fit_line(1e3 * (x - 4), 5 * (y + 7))
    assert moved is not None
    assert (moved.slope, moved.slope_se) == pytest.approx(
        (5e-3 * line.slope, 5e-3 * line.slope_se), rel=1e-9
    )
    assert moved.value_at(-4e3) == pytest.approx(5 * (line.value_at(0.0) + 7), rel=1e-9)


def test_a_line_needs_two_places() -> None:
    assert fit_line(np.array([1.0]), np.array([2.0])) is None
    assert fit_line(np.array([1.0, 1.0]), np.array([2.0, 3.0])) is None
    two = fit_line(np.array([1.0, 3.0]), np.array([2.0, 8.0]))
    assert two is not None and two[:2] == (3.0, 0.0) and two.freedom == 0


@pytest.mark.parametrize("count", [5, 150, 151, 1000])
def test_bins_keep_the_sum_and_the_order(count: int) -> None:
    values = np.sort(RNG.normal(0, 1, count))
    bins = average_bins(values)
    assert len(bins) == min(count, 150) and np.all(np.diff(bins) > 0)
    sizes = np.diff(np.linspace(0, count, len(bins) + 1).astype(int))
    assert sizes.sum() == count and sizes.max() - sizes.min() <= 1
    assert float(bins @ sizes) == pytest.approx(values.sum(), abs=1e-9)


def test_a_fitted_log_has_the_errors_of_independent_noise_and_of_other_units() -> None:
    time = np.linspace(0, 1, 3000)
    log = 4 + 2 * time + RNG.normal(0, 0.05, 3000)

    def fit(size: float, noise: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
        series = fit_series(
            lambda p: size * (p[0] + p[1] * time),
            size * (4 + 2 * time + noise * (log - 4 - 2 * time)),
            (3.0, 1.0),
            (1.0, 1.0),
        )
        assert series.noise == pytest.approx(0.05 * size * noise, rel=0.05)
        assert series.error(lambda p: float(p[0])) == pytest.approx(series.standard_errors[0])
        return series.values, series.standard_errors

    values, errors = fit(1.0)
    known = stats.linregress(time, log)
    assert values == pytest.approx([known.intercept, known.slope], rel=1e-4)
    # a drift that cannot be excluded widens them
    ratio = errors / [known.intercept_stderr, known.stderr]
    assert np.all((ratio > 0.8) & (ratio < 2.5))
    other = fit(1e3)
    assert other[0] == pytest.approx(values, rel=1e-6)
    assert other[1] == pytest.approx(errors, rel=1e-4)
    assert fit(1.0, 3.0)[1] == pytest.approx(3 * errors, rel=1e-3)
