"""The covariance that a calibration states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from layerjam.laboratory.identify.calibration.influence import estimate_covariance
from layerjam.laboratory.identify.calibration.intervals import Population
from layerjam.laboratory.identify.calibration.peaks import _estimate_means, join_means
from strategies import BARE_CURVE


def test_it_is_what_the_errors_of_sums_and_differences_say() -> None:
    """cov(x, y) = (var(x + y) - var(x - y))/4, each variance asked for by itself."""
    draw = np.random.default_rng(1)
    design, scatter = draw.normal(size=(9, 2, 3)), draw.normal(size=(9, 2))
    estimate = np.linalg.lstsq(design.reshape(-1, 3), scatter.ravel(), rcond=None)[0]
    shared = Population(estimate=estimate, design=design, residual=scatter - design @ estimate)
    named = {"a": np.array([1.0, 0, 0]), "b": np.array([0, 2.0, -1.0])}
    found = estimate_covariance(shared, named)

    def variance(contrast: np.ndarray) -> float:
        told = shared.standard_error(contrast)
        assert told is not None
        return told[0] ** 2

    a, b = named.values()
    assert found["a"]["a"] == pytest.approx(variance(a))
    assert found["b"]["b"] == pytest.approx(variance(b))
    due = (variance(a + b) - variance(a - b)) / 4
    assert found["a"]["b"] == pytest.approx(due) and found["b"]["a"] == pytest.approx(due)


def test_means_over_pulls_of_which_some_tell_one_value_only() -> None:
    """Against the scatter of the means themselves over many laboratories."""
    draw = np.random.default_rng(2)
    spread = np.array([[0.04, -0.9], [-0.9, 100.0]])
    told = np.arange(7) >= 2  # the first two tell no stiffness
    means, stated = [], []
    for pulls in draw.multivariate_normal([1.0, 120.0], spread, (4000, 7)):
        a, k = pulls.T
        means.append((a.mean(), k[told].mean()))
        each = {"a": list(a), "k": [v if t else None for v, t in zip(k, told, strict=True)]}
        made = estimate_covariance(
            join_means(each), {"a": np.array([1.0, 0]), "k": np.array([0, 1.0])}
        )
        stated.append([[made[x][y] for y in "ak"] for x in "ak"])
    true = np.cov(np.array(means).T)
    assert np.mean(stated, axis=0) == pytest.approx(true, rel=0.07)
    assert true[0, 1] == pytest.approx(spread[0, 1] / 7, rel=0.07)


def test_the_means_of_pulls_have_it() -> None:
    draw = np.random.default_rng(3)
    values = {"scale_factor": list(draw.normal(1, 0.1, 5)), "stiffness": list(draw.normal(9, 1, 5))}
    curves = [replace(BARE_CURVE, vacuum=6e4, repeat=n, path=f"pull-{n}.csv") for n in range(5)]
    alone = [(n,) for n in range(5)]
    found = _estimate_means(values, curves, alone, {})
    due = np.cov(np.array(list(values.values()))) / 5
    made = [[found["covariance"][x][y] for y in values] for x in values]
    assert np.array(made) == pytest.approx(due)
    for name in values:
        own = found["covariance"][name][name]
        assert found["standard_errors"][name] ** 2 == pytest.approx(own)
    # an error common to all pulls adds to the variance of its own value alone
    both = _estimate_means(values, curves, alone, {"stiffness": 0.05})
    added = np.array([[both["covariance"][x][y] for y in values] for x in values]) - due
    common = (0.05 * np.mean(values["stiffness"])) ** 2
    assert added == pytest.approx(np.diag([0.0, common]), abs=1e-12)
    total = both["covariance"]["stiffness"]["stiffness"]
    assert both["standard_errors"]["stiffness"] ** 2 == pytest.approx(total)
    single = _estimate_means(
        {name: some[:1] for name, some in values.items()}, curves[:1], [(0,)], {}
    )
    assert single["covariance"] == {}
