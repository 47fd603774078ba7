"""Stribeck laws out of synthetic points: truth comes back, errors are honest, verdicts say no."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from layerjam.brake.mechanics.stick_slip.laws import film_curve, sliding_force
from layerjam.brake.mechanics.stick_slip.wet import ILLUSTRATIVE, wet_force
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.friction.stribeck import (
    SpeedPoints,
    fit_dry,
    fit_wet,
    speed_points,
)
from strategies import KAPTON

TRUTH = film_curve(KAPTON, 3e-3)
SPEED = np.geomspace(1e-4, 0.1, 16)


def dry_points(noise: float = 0.0, seed: int = 0, **change: Any) -> SpeedPoints:
    curve = film_curve(KAPTON, **{"speed": 3e-3, **change})
    force = np.asarray(sliding_force(0.01, SPEED, 80e3, KAPTON, curve))
    force = force + noise * np.random.default_rng(seed).standard_normal(len(SPEED))
    return speed_points(SPEED, force, slip=0.01, vacuum=80e3, brake=KAPTON)


def wet_points(noise: float = 0.0, seed: int = 0) -> SpeedPoints:
    speed, vacuum = (a.ravel() for a in np.meshgrid(SPEED[::2], [0.0, 31e3, 65.5e3, 94.5e3]))
    force = np.asarray(wet_force(0.005, speed, vacuum, KAPTON, ILLUSTRATIVE))
    force = force + noise * np.random.default_rng(seed).standard_normal(len(speed))
    return speed_points(speed, force, slip=0.005, vacuum=vacuum, brake=KAPTON)


@pytest.mark.parametrize(("exponent", "viscous"), [(1.0, 0.0), (2.0, 0.0), (1.0, 0.5)])
def test_dry_truth_comes_back(exponent: float, viscous: float) -> None:
    points = dry_points(exponent=exponent, viscous=viscous)
    fit = fit_dry(points, KAPTON, exponent=exponent, viscous=viscous > 0)
    assert fit.law.static == pytest.approx(0.32, rel=1e-7)
    assert fit.law.kinetic == pytest.approx(0.24, rel=1e-7)
    assert fit.law.speed == pytest.approx(3e-3, rel=1e-6)
    if viscous:
        assert fit.law.viscous == pytest.approx(viscous, rel=1e-6)  # type: ignore[union-attr]
    assert fit.trusted, [c.sentence for c in fit.checks if not c.passed]
    assert set(fit.standard_errors.values()) == {None}, "nothing estimates the noise"


def test_wet_truth_comes_back() -> None:
    fit = fit_wet(wet_points(), KAPTON)
    for name in ("static", "kinetic", "speed", "adhesion", "viscosity"):
        assert getattr(fit.law, name) == pytest.approx(getattr(ILLUSTRATIVE, name), rel=1e-5)
    assert fit.trusted


def scores(wet: bool, count: int) -> np.ndarray:
    """(estimate - truth)/standard error over noisy data sets, one row a set."""
    names = ["kinetic", "static", *(["adhesion", "viscosity"] if wet else [])]
    truth: Any = ILLUSTRATIVE if wet else TRUTH
    rows = []
    for seed in range(count):
        fit = (
            fit_wet(wet_points(1.0, seed), KAPTON)
            if wet
            else fit_dry(dry_points(1.0, seed), KAPTON)
        )
        errors = fit.standard_errors
        row = [(getattr(fit.law, n) - getattr(truth, n)) / errors[n] for n in names]  # type: ignore[operator]
        rows.append([*row, np.log(fit.law.speed / truth.speed) / errors["speed"]])  # type: ignore[operator]
    return np.array(rows)


def test_standard_errors_agree_with_the_scatter() -> None:
    found = scores(False, 60)
    assert (np.abs(found.mean(axis=0)) < 0.5).all()
    assert ((found.std(axis=0) > 0.7) & (found.std(axis=0) < 1.4)).all()


@pytest.mark.slow
def test_standard_errors_agree_with_the_scatter_in_water() -> None:
    found = scores(True, 100)
    assert (np.abs(found.mean(axis=0)) < 0.4).all()
    assert ((found.std(axis=0) > 0.8) & (found.std(axis=0) < 1.25)).all()


def failed(fit: Any) -> set[str]:
    return {check.name for check in fit.checks if not check.passed}


def test_flat_points_say_nothing_of_the_speed() -> None:
    force = 40 + 0.5 * np.random.default_rng(1).standard_normal(len(SPEED))
    fit = fit_dry(speed_points(SPEED, force, vacuum=80e3, brake=KAPTON), KAPTON)
    assert "identifiable" in failed(fit) and not fit.trusted
    # the wide prior holds it finite
    assert 1e-6 < fit.law.speed < 10


def test_speeds_too_fast_to_see_the_fall() -> None:
    fast = np.geomspace(0.1, 1.0, 12)
    force = np.asarray(sliding_force(0.0, fast, 80e3, KAPTON, TRUTH))
    force = force + 0.3 * np.random.default_rng(2).standard_normal(12)
    fit = fit_dry(speed_points(fast, force, vacuum=80e3, brake=KAPTON), KAPTON)
    assert failed(fit) & {"identifiable", "bounds", "span"}


def test_a_law_that_does_not_fit_shows_in_the_residuals() -> None:
    fit = fit_dry(dry_points(0.02, exponent=0.4), KAPTON)
    assert "trend over speed" in failed(fit)


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"force": [1.0, 2.0]}, "3 speeds do not match 2 forces"),
        ({"slip": [0.0, 0.1]}, "lists of the same length"),
        ({"speed": [1e-3, -1e-3, 1e-2]}, "zero or more"),
        ({"force": [1.0, np.nan, 3.0]}, "point 2"),
        ({"slip": 0.07}, "beyond the overlap"),
    ],
)
def test_bad_points(given: dict[str, Any], word: str) -> None:
    values = {"speed": [1e-3, 2e-3, 1e-2], "force": [1.0, 2.0, 3.0], "vacuum": 5e4, **given}
    with pytest.raises(FitError, match=word):
        speed_points(values.pop("speed"), values.pop("force"), brake=KAPTON, **values)


def test_one_point_more_than_parameters_is_enough() -> None:
    """Kinetic, drop and v_s are three; the points are exactly on their law."""
    speed = np.array([1e-4, 1e-3, 5e-3, 5e-2])
    force = np.asarray(sliding_force(0.01, speed, 80e3, KAPTON, TRUTH))
    fit = fit_dry(speed_points(speed, force, slip=0.01, vacuum=80e3, brake=KAPTON), KAPTON)
    assert fit.law.static == pytest.approx(0.32, rel=1e-7)
    assert fit.law.kinetic == pytest.approx(0.24, rel=1e-7)
    assert fit.law.speed == pytest.approx(3e-3, rel=1e-6)
    three = speed_points(speed[1:], force[1:], slip=0.01, vacuum=80e3, brake=KAPTON)
    with pytest.raises(FitError, match="3 are too few to fit 3 parameters"):
        fit_dry(three, KAPTON)


def test_points_that_cannot_tell() -> None:
    few = speed_points([1e-3, 1e-2, 0.1], [1.0, 2.0, 3.0], vacuum=5e4, brake=KAPTON)
    with pytest.raises(FitError, match="too few"):
        fit_dry(few, KAPTON)
    with pytest.raises(FitError, match="one vacuum"):
        fit_wet(dry_points(), KAPTON)
    loose = speed_points(SPEED, np.ones(16), vacuum=0.0, brake=KAPTON)
    with pytest.raises(FitError, match="without vacuum"):
        fit_dry(loose, KAPTON)
    two = speed_points(np.tile([1e-3, 1e-2], 4), np.ones(8), vacuum=5e4, brake=KAPTON)
    with pytest.raises(FitError, match="three speeds"):
        fit_dry(two, KAPTON)
