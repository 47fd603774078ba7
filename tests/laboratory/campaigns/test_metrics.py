"""MAPE and RMSE over the written window: 200 points from the peak to the end, 5 % and more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from laboratory.campaigns.bench import FULL, curve, noisy
from layerjam.brake.mechanics.pull import force_at_elongation, peak
from layerjam.core.errors import FileError, FitError
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features
from layerjam.laboratory.identify.validation.metrics import (
    FLOOR,
    POINTS,
    compare_pull,
    validate_pulls,
)
from strategies import KAPTON, PTFE, change


def lifted(pull: PullFeatures, factor: float = 1.0, plus: float = 0.0) -> PullFeatures:
    return replace(pull, force=pull.force * factor + plus)


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_the_window(brake) -> None:
    pull = pull_features(curve(brake))
    found = compare_pull(pull, FULL, brake)
    assert POINTS == 200 and FLOOR == 0.05
    assert len(found.elongation) == len(found.measured) == len(found.model) == 200
    assert found.elongation[0] == pytest.approx(float(peak(FULL, 0.06, brake).elongation), rel=1e-5)
    assert found.elongation[-1] == pytest.approx(0.04, rel=1e-12)
    np.testing.assert_allclose(np.diff(found.elongation), np.diff(found.elongation)[0], rtol=1e-9)
    assert found.mape < 1e-6 and found.rmse < 1e-3 and found.note == ""


def test_mape_rmse_and_bias_by_hand() -> None:
    pull = pull_features(curve(KAPTON, rows=40001))
    low = compare_pull(lifted(pull, factor=1.25), FULL, KAPTON)
    assert low.mape == pytest.approx(0.2, rel=1e-6)  # |m - 1.25 m| / 1.25 m
    shift = compare_pull(lifted(pull, plus=2.0), FULL, KAPTON)
    assert shift.rmse == pytest.approx(2.0, rel=1e-5)
    assert shift.bias == pytest.approx(-2.0, rel=1e-5)
    by_hand = np.mean(np.abs(shift.model - shift.measured) / shift.measured)
    assert shift.mape == pytest.approx(by_hand, rel=1e-12)
    law = np.asarray(force_at_elongation(shift.elongation, FULL, KAPTON))
    np.testing.assert_array_equal(shift.model, law)


def test_the_friction_factor_alone_makes_fourteen_percent() -> None:
    """a = 1 against 0.875: 14.3 % of the sheets' part; the sleeve's share takes some away."""
    blank = change(KAPTON, scale_factor=1.0)
    found = compare_pull(pull_features(curve(KAPTON)), FULL, blank)
    assert 0.12 < found.mape < 1 / 0.875 - 1


def test_points_below_five_percent_of_the_peak_do_not_count() -> None:
    thin = change(KAPTON, enclosure__modulus=300.0)
    pull = pull_features(curve(thin, travel=0.0685))
    found = compare_pull(pull, FULL, thin)
    assert 100 < len(found.elongation) < 200
    assert found.measured.min() >= 0.05 * pull.peak_force
    cut = pull.elongation[np.flatnonzero(pull.force >= 0.05 * pull.peak_force)[-1]]
    assert found.elongation[-1] == pytest.approx(cut, abs=0.07 / 199)


def test_a_pull_without_a_peak_starts_where_it_bends_and_says_so() -> None:
    """With 0.2 mm of travel after onset there is no peak yet, but a straight rise."""
    top = peak(FULL, 0.06, KAPTON)
    pull = pull_features(curve(KAPTON, travel=float(top.elongation), rows=20001))
    assert pull.straight and not pull.has_peak
    soft = replace(pull, elongation=np.append(pull.elongation, 0.01),
                   force=np.append(pull.force, 0.85 * 131e3 * 0.01))  # fmt: skip
    found = compare_pull(soft, FULL, KAPTON)
    assert found.note.startswith("no peak: the window starts where")
    assert found.elongation[0] > 0.9 * float(top.elongation)
    assert found.elongation[-1] == pytest.approx(0.01, rel=1e-9)


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
@pytest.mark.parametrize("vacuum", [0.0, 500.0, 1000.0])
def test_without_a_straight_rise_the_whole_record_counts(brake, vacuum) -> None:
    """At low vacuum 20 to 80 % of the greatest force is the sleeve's stretching, not the stuck
    sheets' spring; its line once put the origin at -313 mm and the MAPE at 336 %."""
    found = compare_pull(pull_features(curve(brake, vacuum)), vacuum, brake)
    assert found.note == "no peak and no linear rise: the window is the whole record"
    assert found.mape < 1e-6 and found.elongation[-1] == pytest.approx(0.04, rel=1e-9)
    rough = pull_features(noisy(brake, 1, vacuum=vacuum))
    assert not rough.has_peak
    assert abs(rough.origin) < 1e-3 and compare_pull(rough, vacuum, brake).rmse < 0.16


def test_a_low_peak_starts_the_window_and_the_record_the_origin() -> None:
    pull = pull_features(noisy(PTFE, 4, vacuum=5e3))
    assert pull.has_peak and not pull.straight and pull.origin == 0.0
    found = compare_pull(pull, 5e3, PTFE)
    top = peak(5e3, 0.06, PTFE)
    assert found.elongation[0] == pytest.approx(float(top.elongation), abs=5e-3)
    assert found.rmse < 0.16 and found.note == ""


def test_a_record_that_ends_at_its_peak_is_refused() -> None:
    straight = pull_features(curve(KAPTON, travel=0.0013))
    with pytest.raises(FileError, match="no sliding part to compare"):
        compare_pull(straight, FULL, KAPTON)


def test_a_model_that_snaps_is_refused() -> None:
    soft = change(KAPTON, stiffness_measured=2e3)
    with pytest.raises(FitError, match="snap"):
        compare_pull(pull_features(curve(KAPTON)), FULL, soft)


def test_several_files_count_the_same() -> None:
    pulls = [
        (lifted(pull_features(curve(KAPTON, p, rows=16001 if p > 3e4 else 4001)), factor=f), p)
        for p, f in ((80e3, 1.25), (50e3, 1.0), (20e3, 1.25))
    ]
    result = validate_pulls(pulls, KAPTON)
    mapes = [c.mape for c in result.curves]
    assert mapes == pytest.approx([0.2, 0.0, 0.2], abs=1e-3)
    assert result.mape == pytest.approx(np.mean(mapes), rel=1e-12)
    assert result.mape_sd == pytest.approx(np.std(mapes, ddof=1), rel=1e-12)
    squares = np.concatenate([(c.model - c.measured) ** 2 for c in result.curves])
    assert result.rmse == pytest.approx(np.sqrt(squares.mean()), rel=1e-12)
    assert validate_pulls(pulls[:1], KAPTON).mape_sd is None
    with pytest.raises(FitError, match="no pull was given"):
        validate_pulls([], KAPTON)


def test_noise_alone_gives_its_own_rmse() -> None:
    """200 points interpolated between noisy samples scatter by the noise or a little less."""
    found = compare_pull(pull_features(noisy(KAPTON, 5)), FULL, KAPTON)
    assert 0.1 < found.rmse < 0.17
