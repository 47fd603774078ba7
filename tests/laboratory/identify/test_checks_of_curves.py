"""The verdict on whole curves: every check fails when it should, and only then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtrc

from laboratory.campaigns import bench as virtual
from laboratory.campaigns.bench import FULL
from laboratory.identify.fitted import campaign
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.calibration.influence import Influence
from layerjam.laboratory.identify.calibration.intervals import quantile
from layerjam.laboratory.identify.calibration.least_squares import fit_jointly
from layerjam.laboratory.identify.calibration.verdict import (
    check_bounds,
    check_catalogue_range,
    check_drift,
    check_repeats,
    check_single_file,
)
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.curves import make_curves
from layerjam.laboratory.identify.fit_checks import Check, check_enclosure
from layerjam.laboratory.identify.pull.features import pull_features
from strategies import KAPTON

THREE = (40e3, 60e3, 90e3)
SPREAD = (0.01, 0.01, 0.03)


def failed(checks: tuple[Check, ...]) -> set[str]:
    return {c.name for c in checks if not c.passed}


def verdict(curves, brake=KAPTON, free=()) -> set[str]:
    return failed(calibrate_curves(curves, brake, free).checks)


def test_a_good_campaign_passes_everything() -> None:
    curves = campaign(THREE, 2, spread=SPREAD, noise=0.1, speeds=(0.005, 0.02), slack=1e-4)
    found = calibrate_curves(curves, KAPTON)
    assert failed(found.checks) == set()
    assert {c.name for c in found.checks} == {
        "identifiable", "told apart", "settled", "bounds", "plausible", "catalogue", "stiffness",
        "enclosure", "repeats", "single curves", "residuals over slip", "scale factor over vacuum",
        "enclosure's factor over vacuum", "scale factor over speed", "leave one out",
        "shape", "pull by pull", "seating", "stiffness repeats", "stiffness's trend over vacuum",
        "scale factor interval", "stiffness interval", "mountings", "pulls", "wear", "neighbours",
        "zero",
    }  # fmt: skip


def test_short_pulls_do_not_tell_friction_from_sleeve() -> None:
    """Over half a millimetre of slip at one vacuum the root and the friction look alike."""
    short = campaign((FULL,), 3, spread=SPREAD, noise=0.8, travel=0.0018)
    found = calibrate_curves(short, KAPTON)
    assert "told apart" in failed(found.checks)
    told = found.identifiability
    assert told.least_apart is not None and set(told.least_apart) == {
        "scale_factor",
        "enclosure_factor",
    }
    assert told.correlation < -0.9
    long = calibrate_curves(campaign((FULL,), 3, spread=SPREAD, noise=0.8), KAPTON)
    assert "told apart" not in failed(long.checks)
    assert long.identifiability.condition_number < told.condition_number


def test_friction_that_depends_on_pressure_shows_as_a_drift_until_it_is_fitted() -> None:
    curves = campaign(THREE, 3, spread=SPREAD, noise=0.1, exponent=-0.2)
    assert verdict(curves) == {"scale factor over vacuum"}
    assert verdict(curves, free=("pressure_exponent",)) == set()


def test_friction_that_depends_on_speed_shows_until_it_is_fitted() -> None:
    curves = campaign((FULL,), 4, spread=SPREAD, noise=0.1, slope=0.2, speeds=(0.003, 0.02))
    assert verdict(curves) == {"scale factor over speed", "pull by pull"}
    assert verdict(curves, free=("speed",)) == set()


def test_a_law_that_does_not_fit_leaves_a_trend_over_slip() -> None:
    """A hump of 6 % of the peak at 12 of 40 mm in every curve: in the second sixth of the slip."""
    curves = campaign(THREE, 2, spread=SPREAD, noise=0.1)
    for c in curves:
        c.force[:] += 0.06 * c.peak_force * np.exp(-(((c.elongation - 0.012) / 0.003) ** 2))
    checks = calibrate_curves(curves, KAPTON).checks
    [trend] = [c for c in checks if c.name == "residuals over slip"]
    assert not trend.passed and "from 17% to 33% of the slip" in trend.sentence


def test_repeats_that_disagree_and_a_single_file_that_carries_the_result() -> None:
    assert "repeats" in verdict(campaign((FULL,), 4, spread=(0.15, 0.01, 0.03)))
    assert "repeats" in verdict(campaign((FULL,), 1))


def test_repeats_count_only_where_all_pulls_scatter_as_much() -> None:
    """Six pairs of films that scatter by 4 % often show more than 5 % within pairs, seldom all."""
    curves = campaign(THREE, 2, speeds=(0.005, 0.02), noise=0.1)
    fit = fit_jointly(curves, KAPTON)
    away, random = np.array(fit.own.own), np.random.default_rng(4)
    fit = replace(fit, own=replace(fit.own, own=away))
    falsely, truly, pairs = 0, 0, 0
    for _ in range(500):
        normal = random.standard_normal(len(curves))
        for scatter in (0.04, 0.1):
            away[:, 0] = fit.population.estimate[0] + scatter * normal
            fails = not check_repeats(fit).passed
            falsely += fails and scatter == 0.04
            truly += fails and scatter == 0.1
        apart = [np.ptp(0.04 * normal[list(g)]) for g in fit.groups]
        pairs += np.sqrt(np.mean(np.square(apart)) / 2) > 0.05
    assert len(fit.groups) == 6 and pairs / 500 == pytest.approx(chdtrc(6, 6 / 0.64), abs=0.03)
    # no more than Bonferroni's least of both, and little is lost where they do scatter
    assert falsely / 500 < chdtrc(11, 11 / 0.64) + 0.02 < 0.9 * pairs / 500
    assert truly / 500 == pytest.approx(chdtrc(6, 6 / 4), abs=0.03)


UNITS = {
    "force in kgf": (1 / 9.80665, 1.0),
    "force in lbf": (1 / 4.4482216152605, 1.0),
    "a header of mN over newtons": (1e-3, 1.0),
    "a header of kN over newtons": (1e3, 1.0),
    "elongation in inches": (1.0, 1 / 25.4),
    "elongation in cm": (1.0, 0.1),
    "elongation in m": (1.0, 10.0),
}


FEW_AND_MANY = {("force in kgf", 2), ("elongation in cm", 12)}
"""Cases of the quick tests besides those of four pulls."""


@pytest.mark.parametrize(
    ("unit", "number"),
    [
        pytest.param(
            unit,
            number,
            marks=[] if number == 4 or (unit, number) in FEW_AND_MANY else pytest.mark.slow,
        )
        for unit in UNITS
        for number in (2, 4, 12)
    ],
)
def test_a_pull_in_another_unit_is_named_or_refused(unit: str, number: int) -> None:
    """It was once taken for noise, given no weight, and counted among the pulls."""
    force, length = UNITS[unit]
    pulls = []
    for seed in range(number):
        trace = virtual.noisy(KAPTON, seed + 1)
        if seed == number // 2:
            trace = replace(trace, force=trace.force * force, elongation=trace.elongation * length)
        trace = replace(trace, path=f"pull-{seed}.csv")
        pulls.append((trace, pull_features(trace), FULL))
    try:
        found = calibrate_curves(make_curves(pulls), KAPTON)
    except FitError as error:
        assert str(error).startswith(f"pull-{number // 2}.csv: ") and "leave the file out" in str(
            error
        )
        return
    [said] = [c for c in found.checks if c.name == "single curves"]
    assert not said.passed and ".csv" in said.sentence
    if number > 2:  # of two, nothing says which is the odd one
        assert f"pull-{number // 2}.csv" in said.sentence
    # and it weighs as much as the others: a mean of logarithms, each curve alike
    own = found.fit.own.own
    np.testing.assert_allclose(np.log(found.scale_factor), own[:, 0].mean(), atol=0.02)


def test_a_curve_that_bends_off_the_law_is_named() -> None:
    """A wave of 8 % of the peak, which no friction, stiffness or enclosure makes."""
    curves = campaign((FULL,), 4, spread=SPREAD, noise=0.1)
    curves = [replace(c, path=f"{i}.csv") for i, c in enumerate(curves)]
    odd = curves[2]
    odd.force[:] += 0.08 * odd.peak_force * np.sin(odd.elongation / 0.0015)
    [said] = [c for c in calibrate_curves(curves, KAPTON).checks if c.name == "single curves"]
    assert not said.passed and said.sentence.startswith("2.csv deviates from the law by ")
    odd.force[:] += 0.2 * odd.peak_force * np.sin(odd.elongation / 0.0015)
    with pytest.raises(FitError, match=r"2\.csv: its curve deviates from the law by"):
        calibrate_curves(curves, KAPTON)


def test_implausible_numbers() -> None:
    assert "plausible" in verdict(campaign((FULL,), 3, truth=(2.4, 3e5, 1.0), spread=SPREAD))
    assert "enclosure" in verdict(campaign((FULL,), 3, truth=(0.9, 1.2e5, 3.5), spread=SPREAD))
    assert "stiffness" in verdict(campaign((FULL,), 3, truth=(0.9, 9e5, 1.0), spread=SPREAD))
    assert [check_catalogue_range(p).passed for p in (0.005, 0.0621, 0.21, 5.0)] == [
        False, True, True, False,
    ]  # fmt: skip
    # 2.33 standard deviations of 30 %, of the logarithm: 0.497 to 2.01
    levels = [check_enclosure(f, 0.0, 0.3).level for f in (0.49, 0.5, 2.0, 2.02)]
    assert levels == ["failed", "passed", "passed", "failed"]
    assert check_enclosure(0.49, 0.1, 0.3).passed and not check_enclosure(0.9, 0.0, 0.04).passed


@pytest.mark.parametrize("sign", [1, -1])
def test_a_single_file_counts_whether_it_lifts_or_lowers_a_value(sign: int) -> None:
    """By half of the half-width of the interval, 0.2, and by twice that."""
    scatter = 0.2 / quantile(4), 4.0
    for shift, share, passed in ((0.1, "0.5", True), (0.4, "2", False)):
        influence = Influence(
            most_influential="a.csv", files={"a.csv": sign * shift}, conditions={}
        )
        one = check_single_file({"scale_factor": influence}, {"scale_factor": scatter})
        assert one is not None and one.passed is passed
        assert f"by {share} of the half-width" in one.sentence


def test_bounds() -> None:
    fine = {"scale_factor": 1.0, "stiffness": 1e5, "enclosure_factor": 1.0}
    assert check_bounds(fine).passed
    for name, value in (("scale_factor", 1e-3), ("stiffness", 100.0), ("enclosure_factor", 2e-3)):
        one = check_bounds(fine | {name: value})
        assert not one.passed and "ended at a bound" in one.sentence
    assert not check_bounds({**fine, "pressure_exponent": 2.0}).passed


def test_a_drift_must_be_sure_and_matter() -> None:
    over = np.repeat([20e3, 40e3, 90e3], 3)
    z = np.random.default_rng(2).standard_normal(9)
    small, steep = 0.01 * np.log(over / 40e3), 0.1 * np.log(over / 40e3)
    cases = ((0.05 * z, True), (small + 1e-4 * z, True), (steep + 0.01 * z, False))
    for values, passed in cases:
        found = check_drift(values, over, "scale factor", "vacuum", "Pa")
        assert found is not None and found.passed is passed
    assert check_drift(z, np.full(9, 5e4), "scale factor", "vacuum", "Pa") is None
    assert check_drift(z[:2], over[:2] * [1, 2], "scale factor", "vacuum", "Pa") is None
    bent = check_drift(
        0.2 * np.log(over / 40e3) ** 2 + 0.005 * z, over, "x", "vacuum", "Pa", free=1
    )
    assert bent is not None and not bent.passed and "bends" in bent.sentence
    straight = check_drift(steep + 0.005 * z, over, "x", "vacuum", "Pa", free=1)
    assert straight is not None and straight.passed
    # a slope needs two levels, a bend three
    two = np.repeat([30e3, 80e3], [4, 5])
    assert check_drift(z, two, "x", "vacuum", "Pa") is not None
    assert check_drift(z, two, "x", "vacuum", "Pa", free=1) is None
