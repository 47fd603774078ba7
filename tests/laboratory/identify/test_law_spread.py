"""How sure a calibrated law is: against chance itself, and against what the calibration states."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from laboratory.campaigns.bench import FULL
from laboratory.identify.fitted import campaign
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.laboratory.identify.calibration.budget import fitted_enclosure_line
from layerjam.laboratory.identify.calibration.law_spread import LawError, LawSpread
from layerjam.laboratory.identify.calibration.least_squares import fit_jointly
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.shape import change_shape
from strategies import KAPTON

BRAKE = change_shape(KAPTON, 0.9, 120e3, 1.3)
ROOT = np.array([[0.02, 0, 0], [0.01, 0.03, 0], [-0.02, 0.01, 0.05]])
ERROR = LawError(covariance=ROOT @ ROOT.T, t=2.5, pulls=6)
ELONGATION = np.array([0.0004, 0.0009, 0.004, 0.02, 0.035])


def test_the_band_is_as_wide_as_forces_of_drawn_brakes_scatter():
    """Each draw is a brake of its own, whose force the law gives; no derivative is taken."""
    a, k, factor = (ROOT @ np.random.default_rng(1).normal(size=(3, 20_000)))[:, :, None]
    drawn = change_shape(BRAKE, 0.9 * np.exp(a), 120e3 * np.exp(k), 1 + factor)
    for vacuum in (20e3, 80e3):
        force = np.asarray(force_at_elongation(ELONGATION, vacuum, drawn))
        half = ERROR.half_width(BRAKE, ELONGATION, vacuum, None)
        assert half == pytest.approx(2.5 * force.std(axis=0), rel=0.03)


def test_a_brake_whose_friction_depends_on_vacuum_has_the_band_of_its_friction_there():
    bent = replace(BRAKE, pressure_exponent=-0.1, test_pressure=50e3)
    same = replace(BRAKE, scale_factor=BRAKE.scale_factor * (80e3 / 50e3) ** -0.1)
    args = ELONGATION, 80e3, None
    assert ERROR.half_width(bent, *args) == pytest.approx(ERROR.half_width(same, *args), rel=1e-9)
    far = ERROR.half_width(BRAKE, *args)
    assert np.abs(ERROR.half_width(bent, *args) / far - 1).max() > 0.01


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
        error = told.error_at(60e3, 0.01)
        assert error.pulls == 4
        width = error.t * np.sqrt(np.diag(error.covariance))[:2]
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
    assert told.covariance_at(FULL, 0.013)[:2, :2] / sizes == pytest.approx(due / sizes, abs=0.02)
    assert not told.covariance[2].any()
    assert told.t == pytest.approx(stats.t.ppf(0.975, 4))
    assert LawSpread.from_calibration(calibrate_peaks(pulls, KAPTON)).covariance[
        2, 2
    ] == pytest.approx(0.3**2)
    assert LawSpread.from_calibration(calibrate_peaks(pulls[:1], KAPTON)) is None


@pytest.mark.slow
def test_over_whole_curves_it_is_that_of_the_friction_at_the_vacuum():
    pulls = campaign((30e3, 60e3, FULL), 3, spread=(0.02, 0.03, 0.05), noise=0.1, exponent=-0.1)
    found = calibrate_curves(pulls, KAPTON, ["pressure_exponent"])
    told, stated = LawSpread.from_calibration(found), found.covariance
    scale = np.array(
        [found.values[n] if n in ("scale_factor", "stiffness") else 1 for n in told.names]
    )
    due = np.array([[stated[x][y] for y in told.names] for x in told.names])
    if KAPTON.test_pressure is None:
        assert told.covariance == pytest.approx(due / np.outer(scale, scale), rel=1e-6)
    draws = np.random.default_rng(3).multivariate_normal(told.estimate, told.covariance, 100_000).T
    for vacuum in (5e3, told.reference_pressure, 101e3):
        friction = draws[0] + draws[3] * np.log(vacuum / told.reference_pressure)
        assert told.covariance_at(vacuum, 0.013)[0, 0] == pytest.approx(friction.var(), rel=0.03)
    fit = fit_jointly(pulls, KAPTON, ["pressure_exponent"])
    rows = [told.design_at(c.vacuum, c.speed) for c in pulls]
    assert np.array(rows) == pytest.approx(fit.design, abs=1e-12)
    # the file that is written holds the enclosure's factor: about 1 there
    factor = found.values["enclosure_factor"]
    assert told.error_at(FULL, 0.013).covariance[2, 2] == pytest.approx(
        told.covariance_at(FULL, 0.013)[2, 2] / factor**2
    )
