"""Bias, R^2, conditions, and how much of an error is scatter between repeats."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays

from laboratory.campaigns.bench import FULL, curve, noisy
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features
from layerjam.laboratory.identify.validation.metrics import (
    compare_pull,
    split_error,
    uncalibrated,
    validate_curves,
    validate_pulls,
)
from layerjam.laboratory.identify.validation.several import (
    _residual_drift,
    check_validation,
    make_error_rows,
    pool,
)
from strategies import KAPTON, PTFE, change

RESIDUALS = arrays(
    np.float64, st.tuples(st.integers(2, 6), st.integers(1, 20)), elements=st.floats(-1e3, 1e3)
)


def moved(pull: PullFeatures, plus: float = 0.0, factor: float = 1.0) -> PullFeatures:
    return replace(pull, force=pull.force * factor + plus)


def measured(
    pull: PullFeatures, vacuum: float = FULL, speed: float | None = 0.013, path: str = "pull"
) -> Curve:
    return Curve(**{**vars(pull), "vacuum": vacuum, "speed": speed, "path": path})


def test_the_split_by_hand() -> None:
    """Two repeats at 1 and 3: mean square 5, variance 2, (mean 2)^2 less half of it 3."""
    assert split_error(np.array([[1.0, 1.0], [3.0, 3.0]])) == pytest.approx((5.0, 3.0, 2.0))
    # alike: nothing scatters; opposite: nothing but scatter, the model's part below zero
    assert split_error(np.full((4, 7), -3.0)) == pytest.approx((9.0, 9.0, 0.0))
    assert split_error(np.array([[2.0], [-2.0]])) == pytest.approx((4.0, -4.0, 8.0))
    with pytest.raises(FitError, match="at least 2"):
        split_error(np.ones((1, 5)))


@given(RESIDUALS)
def test_the_parts_are_the_whole(residuals: np.ndarray) -> None:
    mse, model, scatter = split_error(residuals)
    assert model + scatter == pytest.approx(mse, rel=1e-9, abs=1e-9)
    assert scatter >= 0
    assert mse == pytest.approx(float((residuals**2).mean()))


@given(RESIDUALS, st.floats(-50, 50), st.floats(-5, 5))
def test_units_order_and_a_shift(residuals: np.ndarray, factor: float, shift: float) -> None:
    before = split_error(residuals)
    scaled = split_error(factor * residuals)
    assert scaled == pytest.approx(tuple(factor**2 * v for v in before), rel=1e-6, abs=1e-6)
    assert split_error(residuals[::-1, ::-1]) == pytest.approx(before, rel=1e-9, abs=1e-9)
    # what all repeats share is the model's, whatever it is
    assert split_error(residuals + shift)[2] == pytest.approx(before[2], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("repeats", [2, 3, 5])
def test_both_parts_are_unbiased_also_for_few_repeats(repeats: int) -> None:
    """A model 2 N off, repeats that scatter by 3 N: 4 and 9 N^2 on the mean of many campaigns."""
    random = np.random.default_rng(1)
    draws = [split_error(2.0 + 3.0 * random.standard_normal((repeats, 1))) for _ in range(20000)]
    found = np.array(draws)
    error = found.std(axis=0, ddof=1) / len(found) ** 0.5
    assert np.all(np.abs(found.mean(axis=0) - [13.0, 4.0, 9.0]) < 4 * error)
    # the error against the mean of the repeats, uncorrected, would carry their scatter
    plain = found[:, 1] + found[:, 2] / repeats
    assert plain.mean() == pytest.approx(4 + 9 / repeats, abs=5 * error[1])


def test_two_pulls_either_side_of_the_model() -> None:
    exact = pull_features(curve(KAPTON))
    pulls = [measured(moved(exact, plus=p), path=str(p)) for p in (1.5, -1.5)]
    result = validate_curves(pulls, KAPTON)
    (one,) = result.conditions
    assert one.scatter is not None and result.scatter is not None
    assert (one.scatter.mse, one.scatter.model_mse, one.scatter.scatter_mse) == pytest.approx(
        (2.25, -2.25, 4.5), rel=1e-4
    )
    assert one.scatter.share == pytest.approx(2.0, rel=1e-4) and one.scatter.repeats == 2
    assert result.bias == pytest.approx(0.0, abs=1e-4)
    assert result.rmse == pytest.approx(1.5, rel=1e-4)


def test_a_wrong_model_is_not_scatter() -> None:
    exact = pull_features(curve(KAPTON))
    result = validate_curves([measured(exact, path=p) for p in "abc"], uncalibrated(KAPTON))
    assert result.scatter is not None
    assert result.scatter.scatter_mse == pytest.approx(0.0, abs=1e-12)
    assert result.scatter.model_mse == pytest.approx(result.scatter.mse)
    assert result.scatter.share == pytest.approx(0.0, abs=1e-12)


def test_noise_is_scatter() -> None:
    pulls = [measured(pull_features(noisy(KAPTON, seed)), path=str(seed)) for seed in (1, 2, 3, 4)]
    result = validate_curves(pulls, KAPTON)
    assert result.scatter is not None
    # interpolated between samples, white noise of 0.15 N keeps half to all of its variance
    assert 0.5 * 0.15**2 < result.scatter.scatter_mse < 1.1 * 0.15**2
    assert abs(result.scatter.model_mse) < 0.1 * 0.15**2


def test_r_squared_by_hand() -> None:
    pull = moved(pull_features(curve(KAPTON, rows=40001)), plus=2.0)
    found = compare_pull(pull, FULL, KAPTON)
    spread = found.measured - found.measured.mean()
    assert found.r_squared == pytest.approx(1 - 4.0 * len(spread) / float((spread**2).sum()))
    assert compare_pull(pull_features(curve(KAPTON)), FULL, KAPTON).r_squared == pytest.approx(1.0)
    flat = replace(pull, force=np.full_like(pull.force, pull.peak_force))
    assert compare_pull(flat, FULL, KAPTON).r_squared is None


def test_rmse_is_bias_and_the_rest() -> None:
    found = compare_pull(pull_features(curve(KAPTON)), FULL, change(KAPTON, scale_factor=0.9))
    error = found.model - found.measured
    assert found.rmse**2 == pytest.approx(found.bias**2 + float(error.var()))
    assert found.bias > 0  # a greater scale factor makes the model too strong


def test_conditions_are_vacuum_and_speed() -> None:
    curves = [
        measured(pull_features(curve(KAPTON, p)), p * (1 + 1e-3 * r), v, f"{p}-{v}-{r}")
        for v in (0.019, 0.007) for p in (46.1e3, 80.6e3, 18.6e3) for r in range(3)
    ]  # fmt: skip
    result = validate_curves(curves, KAPTON)
    asked = [(round(c.vacuum / 1e3), c.speed) for c in result.conditions]
    assert asked == [(81, 0.007), (46, 0.007), (19, 0.007), (81, 0.019), (46, 0.019), (19, 0.019)]
    assert [len(c.curves) for c in result.conditions] == [3] * 6
    assert result.mape_conditions == pytest.approx(result.mape)  # as many pulls in each
    alone = validate_pulls([(curves[0], curves[0].vacuum)], KAPTON)
    assert alone.scatter is None and alone.conditions[0].speed is None
    assert alone.mape_conditions_sd is None


def test_pooling_keeps_brakes_apart() -> None:
    """Kapton and PTFE at one vacuum and speed are two conditions, not repeats of one another."""
    results = [
        validate_curves([measured(pull_features(curve(b)), path=f"{b}-{i}") for i in range(2)],
                        uncalibrated(b))
        for b in (KAPTON, PTFE)
    ]  # fmt: skip
    both = pool(results)
    assert len(both.conditions) == 2 and len(both.curves) == 4
    assert both.mape == pytest.approx(np.mean([r.mape for r in results]))
    assert both.mape_conditions_sd == pytest.approx(np.std([r.mape for r in results], ddof=1))
    assert both.scatter is not None
    assert both.scatter.mse == pytest.approx(np.mean([r.scatter.mse for r in results if r.scatter]))
    assert make_error_rows(pool(results[:1])) == make_error_rows(results[0])
    with pytest.raises(FitError, match="no validation"):
        pool([])


def test_without_a_peak_the_window_starts_10_percent_below_the_straight_rise() -> None:
    """A rise of K to 0.2 mm, then K/10: K u1 + K/10 (u - u1) = 0.9 K u at u = 1.125 u1."""
    bend, end = 2e-4, 4e-4
    u = np.linspace(0, end, 4001)
    force = 5e5 * (np.minimum(u, bend) + 0.1 * np.maximum(u - bend, 0))
    pull = replace(
        pull_features(curve(KAPTON)), has_peak=False, straight=True, stiffness=5e5, elongation=u,
        force=force, peak_force=float(force[-1]),
    )  # fmt: skip
    window = compare_pull(pull, FULL, KAPTON).elongation
    assert window[0] == pytest.approx(1.125 * bend, abs=1.5 * end / 4000)
    assert window[-1] == pytest.approx(end)


def test_before_calibration() -> None:
    before = uncalibrated(KAPTON)
    assert before.scale_factor == 1.0 and before.stiffness_measured is None
    assert before.film == KAPTON.film
    stuck = float(force_at_elongation(1e-5, FULL, before)) / 1e-5
    assert stuck == pytest.approx(808.1e3, rel=1e-3)  # eq. 1


def test_checks_say_what_the_residuals_show() -> None:
    def checks(factors: list[float], seen: int = 0) -> dict[str, bool]:
        pulls = [
            measured(moved(pull_features(curve(KAPTON, p)), factor=f), p, 0.013, str(i))
            for i, (f, p) in enumerate(zip(factors, (90e3, 80e3, 60e3, 40e3, 20e3), strict=True))
        ]
        found = check_validation(validate_curves(pulls, KAPTON), seen)
        return {c.name: c.passed for c in found}

    fine = checks([1.0, 1.001, 0.999, 1.002, 0.998])
    assert all(fine.values()) and "trend over speed" not in fine
    assert not checks([1.0] * 5, seen=2)["independent"]
    assert not checks([1.2, 1.21, 1.19, 1.2, 1.2])["bias"]
    assert not checks([1.2, 1.15, 1.05, 0.95, 0.85])["trend over vacuum"]


def test_the_drift_is_the_change_of_the_residual_over_the_mean_force() -> None:
    u = np.linspace(0.01, 0.03, 41)
    force = 80 + 1000 * u  # 100 N on average
    one = SimpleNamespace(elongation=u, measured=force, model=force + 2 + 300 * u)
    assert _residual_drift(one) == pytest.approx(300 * 0.02 / 100, rel=1e-9)
