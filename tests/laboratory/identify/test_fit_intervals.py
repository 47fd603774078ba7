"""Intervals over repeats: Student's t where it is exact, and nothing where nothing tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from laboratory.campaigns.bench import FULL, curve
from layerjam.laboratory.identify.calibration.influence import bootstrap_errors, compute_shifts
from layerjam.laboratory.identify.calibration.intervals import Population, quantile
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.statistics import summarise_repeats
from strategies import KAPTON


def means(values: np.ndarray) -> Population:
    """The population behind plain means of (n, q) values."""
    return Population(
        estimate=values.mean(axis=0),
        design=np.tile(np.eye(values.shape[1]), (len(values), 1, 1)),
        residual=values - values.mean(axis=0),
    )


def line(x: np.ndarray, y: np.ndarray) -> Population:
    """Ordinary least squares of a line, every point its own cluster."""
    design = np.column_stack([np.ones_like(x), x])
    beta = np.linalg.lstsq(design, y, rcond=None)[0]
    rest = y - design @ beta
    return Population(
        estimate=beta,
        design=design[:, None, :],
        residual=rest[:, None],
    )


@pytest.mark.parametrize("count", [2, 3, 5, 30])
def test_for_equal_weights_it_is_students_t_of_a_mean(count: int) -> None:
    values = np.random.default_rng(count).normal(3, 0.4, (count, 2))
    for j, unit in enumerate(np.eye(2)):
        found = means(values).standard_error(unit)
        assert found == pytest.approx((values[:, j].std(ddof=1) / np.sqrt(count), count - 1))
        plain = summarise_repeats(values[:, j].tolist(), positive=False)
        low, high = stats.t.interval(
            0.95, count - 1, values[:, j].mean(), values[:, j].std(ddof=1) / np.sqrt(count)
        )
        assert (plain.low, plain.high) == pytest.approx((low, high), rel=1e-12)
    assert quantile(2) == pytest.approx(4.302653, rel=1e-6)


def test_one_repeat_has_none() -> None:
    assert means(np.array([[1.0, 2.0]])).standard_error(np.array([1.0, 0.0])) is None


def test_one_pull_has_an_error_only_if_both_its_rise_and_its_peak_scatter() -> None:
    """A model's curve has none; 0.1 N of noise are some parts in ten thousand of its peak."""
    exact = curve(KAPTON)
    elongation, share = exact.elongation, exact.force / exact.force.max()
    rise = (share > 0.3) & (share < 0.7) & (elongation < elongation[share.argmax()])
    peak = elongation > elongation[share > 0.9][0]
    noise = 0.1 * np.random.default_rng(1).standard_normal(len(share))
    # no trend, so that the slope, and with it the slip after it, stay as they are
    noise[rise] -= np.polyval(np.polyfit(elongation[rise], noise[rise], 1), elongation[rise])
    for part in (rise, peak, rise | peak):
        trace = replace(exact, force=exact.force + np.where(part, noise, 0.0))
        pull = pull_features(trace)
        result = calibrate([(pull, FULL)], KAPTON)
        errors = [result.standard_errors[name] for name in ("scale_factor", "stiffness")]
        if part is rise or part is peak:
            assert errors == [None, None]
            assert result.errors_rest_on == "nothing: its rise or its peak has no noise"
        else:
            assert errors == [result.fits[0].scale_factor_se, pull.stiffness_se]
            assert min(errors[0] / result.scale_factor, errors[1] / result.stiffness) > 1e-5
            assert result.errors_rest_on.startswith("the noise within one pull")


def test_the_slope_of_a_line_is_covered() -> None:
    """One point far out: few degrees of freedom, and rather too wide than too narrow."""
    random = np.random.default_rng(3)
    x = np.array([0.0, 0.1, 0.2, 0.3, 0.5, 0.9, 1.6])
    inside, degrees = 0, 0.0
    for _ in range(2000):
        fit = line(x, 2 + 3 * x + 0.3 * random.standard_normal(len(x)))
        error, degrees = fit.standard_error(np.array([0.0, 1.0]))
        inside += abs(fit.estimate[1] - 3) < quantile(degrees) * error
    assert 1 < degrees < 5
    assert 0.94 < inside / 2000 < 0.99


def test_unequal_weights_are_covered_also_with_three() -> None:
    random = np.random.default_rng(8)
    weight = np.array([1.0, 2.0, 4.0])
    inside = 0
    for _ in range(3000):
        y = 1 + random.standard_normal(3) / np.sqrt(weight)
        at = float((weight * y).sum() / weight.sum())
        root = np.sqrt(weight)
        fit = Population(
            estimate=np.array([at]),
            design=root[:, None, None],
            residual=(root * (y - at))[:, None],
        )
        error, degrees = fit.standard_error(np.ones(1))
        inside += abs(at - 1) < quantile(degrees) * error
    assert 0.93 < inside / 3000 < 0.975


def test_a_parameter_that_hangs_on_one_curve_has_none() -> None:
    x = np.array([0.0, 0.0, 0.0, 1.0])
    fit = line(x, np.array([1.0, 1.1, 0.9, 2.0]))
    assert fit.standard_error(np.array([0.0, 1.0])) is None
    assert fit.shift([3]) is None
    assert np.isnan(fit.covariance()).all()


def test_leaving_out_is_refitting() -> None:
    random = np.random.default_rng(1)
    x, y = random.uniform(0, 1, 8), random.standard_normal(8)
    whole = line(x, y)
    for out in ([2], [1, 5], [0, 3, 6]):
        keep = np.setdiff1d(np.arange(8), out)
        again = line(x[keep], y[keep])
        np.testing.assert_allclose(whole.estimate + whole.shift(out), again.estimate, rtol=1e-10)
    found = compute_shifts(whole, {"slope": np.array([0.0, 1.0])}, list("abcdefgh"), {})
    by = [abs(moved) for moved in found["slope"].files.values()]
    assert by == sorted(by, reverse=True) and len(by) == 8


def test_the_bootstrap_of_three_repeats_is_no_narrower_than_t() -> None:
    """Plain resampling of three gives 2/3 of the variance; drawing two of them gives all of it."""
    values = np.random.default_rng(5).normal(10, 1, (3, 1))
    found = bootstrap_errors(means(values), [(0, 1, 2)], {"mean": np.ones(1)})["mean"]
    assert found is not None and found[1] == 2
    assert found[0] == pytest.approx(values.std(ddof=1) / 3**0.5, rel=0.05)


def test_the_bootstrap_keeps_conditions_apart() -> None:
    """A difference between conditions is no scatter between repeats."""
    random = np.random.default_rng(2)
    values = np.concatenate([random.normal(m, 0.1, (4, 1)) for m in (1.0, 5.0)])
    groups = [(0, 1, 2, 3), (4, 5, 6, 7)]
    within = bootstrap_errors(means(values), groups, {"mean": np.ones(1)})["mean"]
    pooled = bootstrap_errors(means(values), [range(8)], {"mean": np.ones(1)})["mean"]
    assert within is not None and pooled is not None
    assert within[0] < 0.1 < 0.5 < pooled[0]
    single = bootstrap_errors(means(values[:2]), [(0,), (1,)], {"mean": np.ones(1)})["mean"]
    assert single is not None and single[1] == 1


def test_resampling_has_as_many_degrees_of_freedom_as_repeats_beyond_their_groups() -> None:
    eight = means(np.random.default_rng(6).normal(1, 0.1, (8, 1)))
    assert eight.bootstrap([(0, 1, 2, 3), (4, 5, 6, 7)], 1, 10)[1] == 6
    assert eight.bootstrap([(0,), range(1, 8)], 1, 10)[1] == 7
    assert means(np.array([[1.0]])).bootstrap([(0,)], 1, 10)[1] == 0


def test_covariance_agrees_with_the_single_errors() -> None:
    random = np.random.default_rng(4)
    fit = line(random.uniform(0, 1, 12), random.standard_normal(12))
    covariance = fit.covariance()
    for j, unit in enumerate(np.eye(2)):
        assert covariance[j, j] == pytest.approx(fit.standard_error(unit)[0] ** 2)
    assert np.linalg.eigvalsh(covariance).min() >= -1e-12
