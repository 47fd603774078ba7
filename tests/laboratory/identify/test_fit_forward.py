"""The law as a fit sees it: right derivatives everywhere, at the onset too."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from layerjam.brake.mechanics.enclosure import enclosure_force, saturation_slip
from layerjam.brake.mechanics.pull import peak
from layerjam.laboratory.identify.calibration.forward import pull_force
from layerjam.laboratory.identify.shape import change_shape, drop_exponent
from strategies import KAPTON, PTFE

BOTH = pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
OWN = np.array([np.log(0.9), np.log(1.2e5), 1.2, 0.01, 0.003])


@BOTH
@pytest.mark.parametrize("vacuum", [3e3, 30e3, 94.5e3])
def test_derivatives_are_those_of_central_differences(brake, vacuum) -> None:
    """At random places, and around the onset, where the slope of the force jumps within 0.1 um."""
    height, onset = 100.0, 1e-3
    shaped = change_shape(brake, *np.exp(OWN[:2]), OWN[2])
    begin = shaped.scale_factor * brake.film.kinetic * (brake.sheets.count - 1)
    begin *= brake.sheets.width * vacuum * brake.sheets.overlap / shaped.stiffness_measured
    random = np.random.default_rng(5)
    near = begin + OWN[3] * onset + np.array([-1e-4, -1e-5, 1e-5, 1e-4, 1e-3])
    places = np.concatenate([random.uniform(1e-5, 0.05, 40), near])

    def force(own):
        return pull_force(own, places, vacuum, height, onset, drop_exponent(brake))

    slope = np.asarray(jax.jacfwd(force)(OWN))
    assert np.isfinite(slope).all()
    for j in range(5):
        step = 1e-7 * np.eye(5)[j]
        by_hand = (np.asarray(force(OWN + step)) - np.asarray(force(OWN - step))) / 2e-7
        np.testing.assert_allclose(slope[:, j], by_hand, rtol=2e-5, atol=2e-5 * height)


@BOTH
def test_derivatives_are_finite_at_the_onset_itself_and_in_slack(brake) -> None:
    shaped = change_shape(brake, *np.exp(OWN[:2]), OWN[2])
    top = peak(60e3, 0.06, shaped)
    exact = np.exp(-OWN[1]) * (
        float(top.force) - 0.25 * 0
    )  # any place will do, zero is the sharp one
    # as many as in the other tests, so that nothing else is compiled
    places = np.resize([0.0, OWN[3] * 1e-3, exact], 45)
    slope = jax.jacfwd(lambda p: pull_force(p, places, 60e3, 1.0, 1e-3, drop_exponent(brake)))(OWN)
    assert np.isfinite(np.asarray(slope)).all()


@BOTH
def test_the_sleeves_factor_multiplies_its_force_and_keeps_its_saturation(brake) -> None:
    x = np.linspace(0, 0.06, 50)
    for vacuum in (2e3, 60e3):
        twice = change_shape(brake, 1.0, 1e5, 2.0)
        np.testing.assert_allclose(
            np.asarray(enclosure_force(x, vacuum, twice)),
            2 * np.asarray(enclosure_force(x, vacuum, brake)), rtol=1e-12,
        )  # fmt: skip
        assert float(saturation_slip(vacuum, twice)) == pytest.approx(
            float(saturation_slip(vacuum, brake)), rel=1e-12
        )
