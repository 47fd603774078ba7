"""The table pull by pull: each fault is found in its own column, in the pull that has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from layerjam.brake.device.load import load
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.faults import Faults
from layerjam.laboratory.campaigns.spec import Odd, Pulls, Scatter, Spec, Truth
from layerjam.laboratory.identify.bayes.fit import calibrate_bayesian
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.curves import Curve, make_curves
from layerjam.laboratory.identify.fit_checks import SHARPEST
from layerjam.laboratory.identify.fit_checks import check_shape as same_shape
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.single_pulls import TESTS, SinglePull, find_common_conditions
from layerjam.laboratory.identify.validation.metrics import validate_curves
from layerjam.laboratory.identify.validation.several import add_pull_table, check_validation
from layerjam.laboratory.measure.trace import Trace

KAPTON = load("choi2018-kapton").brake
SPEC = Spec(
    brakes=(Truth(brake="choi2018-kapton"),),
    seed=3,
    pulls=Pulls(vacuums=(30e3, 55e3, 80e3), speeds=(7e-3, 13e-3), repeats=2, travel=0.04),
    scatter=Scatter(friction=0.01, stiffness=0.01, enclosure=0.03),
    machine=Faults(sampling_rate=1000.0, force_noise=0.1, slack=5e-4, seating_force=50.0),
)


def pulled(spec: Spec = SPEC) -> tuple[tuple[Curve, ...], set[int]]:
    """The pulls of a campaign, and which of them are odd."""
    made = campaign(spec)
    found = [(t, pull_features(t), float(t.facts.vacuum)) for t in made.traces()]
    return make_curves(found), {i for i, test in enumerate(made.tests) if test.odd}


def table(spec: Spec = SPEC) -> tuple[tuple[SinglePull, ...], set[int], set[str]]:
    """Rows, odd pulls, and the checks that failed."""
    curves, odd = pulled(spec)
    found = calibrate_peaks(curves, KAPTON)
    return found.pulls, odd, {c.name for c in found.checks if not c.passed}


def verdicts(rows: tuple[SinglePull, ...]) -> dict[int, set[str]]:
    """{row: what of it is odd} of those that are."""
    return {
        i: {test for test, word in row.verdicts.items() if word == "odd"}
        for i, row in enumerate(rows)
        if row.is_outlier
    }


def test_faultless_pulls_are_all_ok() -> None:
    rows, odd, failed = table()
    assert not odd and not failed and not verdicts(rows)
    for row in rows:
        assert tuple(row.verdicts) == TESTS and set(row.verdicts.values()) == {"ok"}
        assert row.sentence == "" and abs(row.vacuum_of_peak / row.vacuum - 1) < 0.05
        assert row.recorded_speed == pytest.approx(row.speed, rel=1e-3)
        assert abs(row.shape) < 0.01 and abs(row.seating) < 0.03


@pytest.mark.parametrize(
    ("odd", "tests"),
    [
        (Odd(how_many=1, friction_change=0.15), {"factor"}),
        (Odd(how_many=1, vacuum_change=-0.15), {"factor"}),
        (Odd(how_many=2, friction_change=0.15), {"factor"}),
        (Odd(how_many=1, per="vacuum", vacuum_change=0.15), {"vacuum"}),
        (Odd(how_many=1, stiffness_change=-0.3), {"slope"}),
        (Odd(how_many=1, overshoot=0.15), {"factor", "shape"}),
        (Odd(how_many=1, seating=2e-4), {"slope", "seating"}),
        (Odd(how_many=1, speed_change=0.15), {"speed"}),
    ],
)
def test_each_fault_is_named_in_its_column_and_its_pull(odd: Odd, tests: set[str]) -> None:
    rows, true, failed = table(replace(SPEC, odd=odd))
    found = verdicts(rows)
    assert set(found) == true and all(found[i] == tests for i in true)
    assert "pull by pull" in failed
    if odd.vacuum_change and odd.per == "pull":
        [place] = true
        # the vacuum that was in the brake, to the pull's own scatter
        assert rows[place].vacuum_of_peak == pytest.approx(0.85 * rows[place].vacuum, rel=0.03)
        assert "as if at " in rows[place].sentence


@pytest.mark.parametrize(
    ("fault", "checks"),
    [({"overshoot": 0.15}, {"shape"}), ({"seating": 2e-4}, {"seating"})],
)
def test_a_fault_of_all_pulls_is_seen_too(fault: dict[str, float], checks: set[str]) -> None:
    machine = replace(SPEC.machine, **fault)
    rows, _, failed = table(replace(SPEC, machine=machine))
    assert checks | {"pull by pull"} <= failed
    [test] = checks
    assert all(row.verdicts[test] == "odd" for row in rows)


def checked(method: str, spec: Spec) -> dict[str, bool]:
    """{check: passed} by each method that looks at pulls."""
    curves, _ = pulled(spec)
    if method == "validate":
        found = add_pull_table(validate_curves(curves, KAPTON), curves, KAPTON)
        return {c.name: c.passed for c in check_validation(found, 0)}
    if method == "bayesian":
        # three stated mountings, because fewer widen the interval beyond the overshoot
        curves = [replace(curve, mounting=place) for place, curve in enumerate(curves)]
        made = calibrate_bayesian(curves, KAPTON, (100, 1, 1), lambda _what, _share: None)
        return {c.name: c.passed for c in made.checks}
    fit = calibrate_peaks if method == "exact" else calibrate_curves
    return {c.name: c.passed for c in fit(curves, KAPTON).checks}


@pytest.mark.parametrize(
    "method", ["exact", "curves", "validate", pytest.param("bayesian", marks=pytest.mark.campaign)]
)
def test_a_small_overshoot_of_all_pulls_is_seen_by_every_method(method: str) -> None:
    """No pull is unlike the others; only their mean tells."""
    spec = SPEC
    if method == "bayesian":
        spec = replace(SPEC, pulls=replace(SPEC.pulls, speeds=(13e-3,), repeats=1))
    over = checked(method, replace(spec, machine=replace(SPEC.machine, overshoot=0.05)))
    assert not over["shape"] and over["pull by pull"]
    if method != "bayesian":
        fine = checked(method, spec)
        assert fine["shape"] and fine["pull by pull"]


@pytest.mark.parametrize(("count", "noise"), [(3, 0.02), (6, 0.02), (12, 0.04)])
def test_the_mean_shape_has_the_false_alarms_it_is_given(count: int, noise: float) -> None:
    """However narrow its interval, and beside a plain t test of the same numbers."""
    random = np.random.default_rng(count)
    drawn = noise * random.standard_normal((4000, count))
    for half, most in ((np.inf, 0.01), (None, 0.01), (0.0, 0.05)):
        found = [same_shape(row, half, alarms=0.01, least=SHARPEST) for row in drawn]
        failed = np.array([not c.passed for c in found])
        assert failed.mean() < most + 3 * (most / 4000) ** 0.5
    chance = stats.ttest_1samp(drawn, 0.0, axis=1).pvalue
    assert np.array_equal(failed, (chance < 0.05) & (abs(drawn.mean(axis=1)) > SHARPEST))
    [one] = {same_shape([off], None, alarms=0.01, least=SHARPEST).passed for off in (-0.04, 0.04)}
    assert one and same_shape([], None, alarms=0.01, least=SHARPEST) is None


def test_the_mean_shape_of_two_pulls_is_judged_by_students_t() -> None:
    """Two deviations d and 3d: their mean 2d has the standard error d, and t is 12.7."""
    for d in (0.03, 0.1):
        two = same_shape([d, 3 * d], None, alarms=0.01, least=SHARPEST)
        assert two is not None and two.passed
        assert f"±{stats.t.ppf(0.975, 1) * d:.1%} is allowed" in two.sentence
    # without scatter nothing excuses a mean of 8 %
    alike = same_shape([0.08, 0.08], None, alarms=0.01, least=SHARPEST)
    assert alike is not None and not alike.passed


def test_little_is_told_of_few_pulls_and_said_to_be() -> None:
    curves, _ = pulled(replace(SPEC, pulls=replace(SPEC.pulls, vacuums=(55e3,), repeats=1)))
    found = calibrate_peaks(curves, KAPTON)
    for row in found.pulls:
        told = {test for test, word in row.verdicts.items() if word != "untold"}
        assert told == {"shape", "speed", "seating"}
    # a rise that bends is seen in one pull by itself
    assert calibrate_peaks(curves[:1], KAPTON).pulls[0].verdicts["seating"] == "ok"
    [said] = [c for c in found.checks if c.name == "pull by pull"]
    assert said.passed and "too few" in said.sentence
    assert find_common_conditions(found.pulls) == {"vacuum": 55e3}
    assert find_common_conditions(found.pulls[:1]) == {"vacuum": 55e3, "speed": 7e-3}


def test_seating_is_the_ratio_of_the_slopes_of_its_halves() -> None:
    """A rise of two straight parts, bent in the middle; noise moves it by its own error."""
    u = np.linspace(0.0, 2e-3, 4001)
    force = np.where(u < 5e-4, 1e5 * u, 50.0 + 1.2e5 * (u - 5e-4))
    top = 5e-4 + 50.0 / 1.2e5
    force = np.where(u > top, 100.0 - 5e3 * (u - top), force)
    trace = Trace(force=force, elongation=u, time=None, path="bent", format="")
    assert pull_features(trace).seating == pytest.approx(np.log(1.2), abs=0.02)
    random = np.random.default_rng(2)
    found = [
        pull_features(replace(trace, force=force + 0.3 * random.standard_normal(len(u))))
        for _ in range(200)
    ]
    values = np.array([f.seating for f in found])
    assert values.std() == pytest.approx(np.mean([f.seating_se for f in found]), rel=0.2)
