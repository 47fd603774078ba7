"""How sure a calibrated law is: against chance itself, and against what the calibration states."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from laboratory.campaigns.bench import FULL
from laboratory.identify.fitted import campaign
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.laboratory.figures.calibration_figure import _find_band
from layerjam.laboratory.identify.calibration.budget import fitted_enclosure_line
from layerjam.laboratory.identify.calibration.evidence import apply_calibration
from layerjam.laboratory.identify.calibration.law_spread import LawSpread
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.provenance import format_brake
from layerjam.laboratory.identify.shape import SHAPE
from strategies import KAPTON


def test_of_peaks_it_covers_the_truth_as_often_as_it_says():
    random, inside = np.random.default_rng(2), []
    for _ in range(600):
        a, k = np.exp(random.multivariate_normal([0, 11], [[1e-4, 1e-4], [1e-4, 9e-4]], 4).T)
        fits = [SimpleNamespace(scale_factor=x, stiffness=y) for x, y in zip(a, k, strict=True)]
        found = SimpleNamespace(
            fit=None,
            fits=fits,
            scale_factor=a.mean(),
            stiffness=k.mean(),
            covariance={},
            intervals={"scale_factor": None},
            contributions=(None, fitted_enclosure_line()),
        )
        told = LawSpread.from_calibration(found)
        width = stats.t.ppf(0.975, 3) * np.sqrt(np.diag(told.covariance))[:2]
        inside.append(np.abs(told.estimate[:2] - (0, 11)) <= width)
    # a share of 0.95 of 600 scatters by 0.009
    assert np.mean(inside, axis=0) == pytest.approx(0.95, abs=0.025)


def test_it_is_the_covariance_that_a_calibration_states():
    pulls = campaign(repeats=5, spread=(0.02, 0.03, 0.0), noise=0.1)
    known = replace(KAPTON, enclosure=replace(KAPTON.enclosure, force_uncertainty=0.0))
    peaks = calibrate_peaks(pulls, known)
    told, stated = LawSpread.from_calibration(peaks), peaks.covariance
    own = np.array([peaks.scale_factor, peaks.stiffness])
    names = ("scale_factor", "stiffness")
    due = np.array([[stated[x][y] for y in names] for x in names]) / np.outer(own, own)
    sizes = np.sqrt(np.outer(np.diag(due), np.diag(due)))
    # of logarithms, so that they differ to second order
    assert told.covariance[:2, :2] / sizes == pytest.approx(due / sizes, abs=0.02)
    assert not told.covariance[2].any()
    assert LawSpread.from_calibration(calibrate_peaks(pulls, KAPTON)).covariance[
        2, 2
    ] == pytest.approx(0.3**2)
    assert LawSpread.from_calibration(calibrate_peaks(pulls[:1], KAPTON)) is None


@pytest.mark.slow
def test_over_whole_curves_it_is_the_covariance_of_the_fit():
    pulls = campaign((30e3, 60e3, FULL), 3, spread=(0.02, 0.03, 0.05), noise=0.1, exponent=-0.1)
    found = calibrate_curves(pulls, KAPTON, ["pressure_exponent"])
    told, stated = LawSpread.from_calibration(found), found.covariance
    scale = np.array(
        [found.values[n] if n in ("scale_factor", "stiffness") else 1 for n in told.names]
    )
    due = np.array([[stated[x][y] for y in told.names] for x in told.names])
    assert told.covariance == pytest.approx(due / np.outer(scale, scale), rel=1e-6)


def test_errors_common_to_all_pulls_add_their_variance():
    """Of ln a, of ln k, and of the enclosure factor itself; independent of each other."""
    pulls = campaign((30e3, FULL), 2, spread=(0.02, 0.03, 0.05), noise=0.1)
    found = calibrate_curves(pulls, KAPTON)
    errors = dict(zip(SHAPE, (0.02, 0.03, 0.1), strict=True))
    without, with_errors = (
        LawSpread.from_calibration(replace(found, common_errors=common)).covariance
        for common in ({}, errors)
    )
    due = [0.02**2, 0.03**2, (0.1 * found.values[SHAPE[2]]) ** 2]
    assert with_errors - without == pytest.approx(np.diag([*due, *[0.0] * (len(without) - 3)]))


@pytest.mark.parametrize("repeats", [1, 4])
def test_the_band_of_the_figure_is_the_prediction_of_the_file_that_is_written(repeats):
    pulls = campaign(repeats=repeats, spread=(0.02, 0.03, 0.0), noise=0.1)
    file = load("choi2018-kapton")
    found = calibrate_peaks(pulls, file.brake)
    written = BrakeFile.read(format_brake(file, found, "exact", "mine"), "mine.toml")
    curve = pulls[0]
    pull = tensile(written, vacuum=curve.vacuum, speed=curve.speed or 0.01, elongation=0.03)
    low, high = _find_band(apply_calibration(file, found), curve, np.array([0.03]), False)
    due = np.subtract(pull.interval("force_at_end"), pull.force_at_end)
    assert (low[0], high[0]) == pytest.approx(tuple(due), rel=0.08)
