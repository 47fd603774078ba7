"""Scale factor and stiffness from the model's own pull, exact and as the paper does it."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.mechanics.pull import (
    brake_force,
    force_at_elongation,
    peak,
    scale_factor_eq8,
    scale_factor_of_peak,
    slip_at_elongation,
)
from strategies import KAPTON, PTFE, change, points, random_brakes

FULL = 94.5e3
CASES = [(KAPTON, 0.875, "0.883", "115"), (PTFE, 1.24, "1.244", "33")]


@pytest.mark.parametrize(("brake", "factor", "eq8", "eq9"), CASES)
def test_the_peak_gives_the_scale_factor_back(brake, factor, eq8, eq9):
    """Exact from the peak; with the crosshead's displacement as in the paper it is off."""
    top = peak(FULL, 0.06, brake)
    for start in (1.0, 0.3, 2.0):
        other = change(brake, scale_factor=start)
        assert float(scale_factor_of_peak(top.force, FULL, other)) == pytest.approx(factor)
        paper = float(scale_factor_eq8(top.force, top.elongation, FULL, other))
        assert f"{paper:.3f}" == eq8
    assert f"{float(top.force / top.elongation) / 1e3:.0f}" == eq9


def test_scale_factor_eq8_is_exact_with_the_slip():
    slip = 0.017
    force = float(brake_force(slip, FULL, KAPTON))
    assert float(scale_factor_eq8(force, slip, FULL, KAPTON)) == pytest.approx(0.875, rel=1e-13)


def test_no_pull_peaks_below_the_sleeve():
    assert np.isnan(float(scale_factor_of_peak(1.0, FULL, KAPTON)))


def test_scale_factor_over_random_brakes():
    brakes = random_brakes(21, 2000)
    vacuum = points(21, brakes)[1]
    top = peak(vacuum, np.full(2000, 1e9), brakes)
    found = np.asarray(scale_factor_of_peak(top.force, vacuum, brakes))
    overlap = brakes.sheets.overlap
    good = np.asarray(top.inside) & (np.asarray(top.slip) < 0.99 * overlap)
    assert good.sum() > 500
    assert found[good] == pytest.approx(brakes.scale_factor[good], rel=1e-7)


def test_force_at_elongation_is_spring_times_stretch():
    u = np.array([0.0, 1e-4, 0.01, 0.04])
    slip = np.asarray(slip_at_elongation(u, FULL, KAPTON))
    force = np.asarray(force_at_elongation(u, FULL, KAPTON))
    assert force == pytest.approx(131e3 * (u - slip), rel=1e-13)
    assert f"{force[3]:.7f}" == "88.1486228"
