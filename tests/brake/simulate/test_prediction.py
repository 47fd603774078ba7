"""Predictions of uncertain brakes against closed forms, and their basis."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import Evidence, Part, state_fitted
from layerjam.brake.device.load import load
from layerjam.brake.device.spread import EXPONENT_SD, SPEED_SD
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.pull import brake_force, peak
from layerjam.brake.simulate.prediction import Prediction
from layerjam.laboratory.identify.calibration.intervals import combine_uncertainties

FILE = load("choi2018-kapton")
VACUUM, SLIP = 60e3, 0.02
TESTED = {"vacuum": (55e3, 65e3), "slip": (0.0, 0.04), "speed": (0.013, 0.013)}
SHAPE = ("scale_factor", "stiffness_measured", "enclosure_force")


def with_tests(*parts: Part, names: tuple[str, ...] = SHAPE, **changes: object) -> BrakeFile:
    """The brake with evidence of these parts."""
    evidence = Evidence(
        command="calibrate",
        date="2026-11-28",
        tests=6,
        names=names,
        ranges=TESTED,
        fitted=state_fitted("calibrate", FILE.known_values),
        parts=parts,
    )
    return replace(FILE, evidence=(replace(evidence, **changes),))


def part(of: str, *sds: float, degrees: float = math.inf) -> Part:
    """A part with independent deviations."""
    matrix = np.diag(np.square([*sds, *[0.0] * (3 - len(sds))]))
    return Part(of, tuple(map(tuple, matrix.tolist())), degrees)


def friction(file: BrakeFile, vacuum: float = VACUUM, **given: float) -> tuple[float, float, float]:
    """Friction of the sheets and its interval."""
    prediction = Prediction(file, vacuum, SLIP, **given)
    interval = prediction.interval(sheet_friction(SLIP, vacuum, prediction.brakes))
    return float(sheet_friction(SLIP, vacuum, file.brake)), interval["low"], interval["high"]


@pytest.mark.parametrize("sd", [0.01, 0.05, 0.3])
def test_with_only_the_scale_factor_uncertain_the_interval_is_that_of_a_normal_logarithm(sd):
    # at a vacuum other than the reference the exponent would matter too
    reference = math.sqrt(55e3 * 65e3)
    value, low, high = friction(with_tests(part("mean", sd)), reference)
    assert low == pytest.approx(value * math.exp(-1.96 * sd), rel=0.01)
    assert high == pytest.approx(value * math.exp(1.96 * sd), rel=0.01)


def test_a_scatter_of_two_degrees_of_freedom_has_students_t():
    reference = math.sqrt(55e3 * 65e3)
    value, low, high = friction(with_tests(part("test", 0.03, degrees=2.0)), reference)
    t = stats.t.ppf(0.975, 2)
    assert math.log(high / value) == pytest.approx(0.03 * t, rel=0.03)
    assert math.log(low / value) == pytest.approx(-0.03 * t, rel=0.03)


def test_independent_parts_add_as_squares():
    reference = math.sqrt(55e3 * 65e3)
    file = with_tests(part("mean", 0.03), part("test", 0.02), part("mounting", 0.06))
    _, low, high = friction(file, reference)
    assert math.log(high / low) == pytest.approx(2 * 1.96 * 0.07, rel=0.04)


def test_the_mean_and_the_next_test_of_one_scatter_have_students_prediction_interval():
    """Of three tests with the scatter s: t of two degrees times s times the root of 1 + 1/3."""
    reference = math.sqrt(55e3 * 65e3)
    sd = 0.02
    file = with_tests(part("mean", sd / 3**0.5, degrees=2.0), part("test", sd, degrees=2.0))
    _, low, high = friction(file, reference)
    due = stats.t.ppf(0.975, 2) * sd * (4 / 3) ** 0.5
    assert math.log(high / low) / 2 == pytest.approx(due, rel=0.01)


@pytest.mark.parametrize(("sds", "degrees"), [((0.03, 0.05), (2.0, 9.0)), ((0.02, 0.02), (3, 4))])
def test_variances_of_different_degrees_add_as_in_the_gum(sds, degrees):
    parts = [part("test", sd, degrees=nu) for sd, nu in zip(sds, degrees, strict=True)]
    _, low, high = friction(with_tests(*parts), math.sqrt(55e3 * 65e3))
    error, freedom = combine_uncertainties(zip(sds, degrees, strict=True))
    due = stats.t.ppf(0.975, freedom) * error
    assert math.log(high / low) / 2 == pytest.approx(due, rel=0.01)


def test_a_further_error_never_narrows_an_interval():
    """With one degree of freedom, the degrees of the sum would do so."""
    alone, both = (
        friction(with_tests(part("test", 0.02, degrees=1.0), *more), math.sqrt(55e3 * 65e3))
        for more in ([], [part("mounting", 0.015)])
    )
    due = stats.t.ppf(0.975, 1) * 0.02
    for _, low, high in (alone, both):
        assert math.log(high / low) / 2 == pytest.approx(due, rel=0.01)


def test_without_any_uncertainty_the_interval_has_no_width():
    reference = math.sqrt(55e3 * 65e3)
    value, low, high = friction(with_tests(part("mean", 0.0)), reference, speed=0.013)
    assert low == pytest.approx(value, rel=1e-12)
    assert high == pytest.approx(value, rel=1e-12)


def test_the_widest_scatter_that_a_file_may_state_gives_numbers_without_a_warning():
    file = with_tests(part("mean", 1.99, 1.99, 1.99, degrees=1.0))
    forces = brake_force(0.01, VACUUM, Prediction(file, VACUUM, 0.01).brakes)
    squares = forces**2
    assert np.isfinite(squares).all()
    # quantiles of Student's t with one degree of freedom are those of the Cauchy distribution
    low, high = np.exp(1.99 * stats.cauchy.ppf([0.025, 0.975]))
    value, *ends = friction(file, speed=0.013)
    assert ends == pytest.approx([value * low, value * high], rel=0.3)


def test_the_mean_of_many_tests_has_no_scatter():
    file = with_tests(part("mean", 0.02), part("test", 0.1), part("mounting", 0.1))
    wide = Prediction(file, VACUUM, SLIP)
    narrow = Prediction(file, VACUUM, SLIP, of_mean=True)
    widths = []
    for prediction in (wide, narrow):
        interval = prediction.interval(sheet_friction(SLIP, VACUUM, prediction.brakes))
        widths.append(math.log(interval["high"] / interval["low"]))
    assert widths[1] < 0.3 * widths[0]
    assert (wide.subject, narrow.subject) == ("next test", "mean")


def test_correlated_numbers_compensate_each_other():
    """A peak that was read well, of an enclosure that is not known: the peak is still known."""
    known = peak(VACUUM, 0.04, FILE.brake).force
    stronger = FILE.brake
    stronger = replace(
        stronger,
        enclosure=replace(stronger.enclosure, modulus=stronger.enclosure.modulus * 1.01),
        film=replace(stronger.film, friction_on_silicone=stronger.film.friction_on_silicone * 1.01),
    )
    weaker = replace(FILE.brake, scale_factor=FILE.brake.scale_factor * 1.01)
    by_enclosure = math.log(float(peak(VACUUM, 0.04, stronger).force / known))
    by_friction = math.log(float(peak(VACUUM, 0.04, weaker).force / known))
    root = np.array([-by_enclosure / by_friction, 0.0, 1.0]) * 0.2
    for matrix, share in ((np.outer(root, root), 0.3), (np.diag(root**2), 1.2)):
        file = with_tests(Part("mean", tuple(map(tuple, matrix.tolist()))))
        prediction = Prediction(file, math.sqrt(55e3 * 65e3))
        forces = peak(VACUUM, 0.04, prediction.brakes).force
        interval = prediction.interval(forces)
        width = math.log(interval["high"] / interval["low"])
        by_one = 2 * 1.96 * 0.2 * by_enclosure / math.log(1.01)
        assert (width < 0.3 * by_one) == (share < 1), (width, by_one)


def test_away_from_the_tests_the_exponent_widens_the_interval():
    reference = math.sqrt(55e3 * 65e3)
    value, low, high = friction(with_tests(part("mean", 0.0)), reference / 6)
    assert math.log(high / value) == pytest.approx(1.96 * EXPONENT_SD * math.log(6), rel=0.01)
    assert math.log(low / value) == pytest.approx(-1.96 * EXPONENT_SD * math.log(6), rel=0.01)


def test_beyond_the_tested_speeds_the_slope_widens_the_interval():
    reference = math.sqrt(55e3 * 65e3)
    _, low, high = friction(with_tests(part("mean", 0.0)), reference, speed=1.3)
    assert math.log(high / low) == pytest.approx(2 * 1.96 * SPEED_SD * 2, rel=0.01)


def test_a_fitted_exponent_is_as_uncertain_as_its_covariance_with_the_scale_factor_says():
    """Their sum at ln(P/P_test) = 1 has the variance 0.02^2 + 0.05^2 + 2 cov."""
    names = (*SHAPE, "pressure_exponent")
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[3, 3] = 0.02**2, 0.05**2
    matrix[0, 3] = matrix[3, 0] = -0.8 * 0.02 * 0.05
    file = with_tests(
        Part("mean", tuple(map(tuple, matrix.tolist()))), names=names, reference_pressure=VACUUM
    )
    for logarithm in (0.0, 1.0, -1.0):
        _, low, high = friction(file, VACUUM * math.exp(logarithm))
        unit = np.array([1.0, 0, 0, logarithm])
        sd = math.sqrt(unit @ matrix @ unit)
        assert math.log(high / low) == pytest.approx(2 * 1.96 * sd, rel=0.03), logarithm


def test_an_end_beyond_every_bound_is_open():
    values = np.where(np.arange(1000) < 100, np.inf, np.linspace(1, 2, 1000))
    prediction = Prediction(with_tests(part("mean", 0.1)), VACUUM)
    interval = prediction.interval(values)
    assert interval["high"] is None
    assert interval["low"] == pytest.approx(1.125, abs=0.01)


def test_samples_never_change_and_broadcast():
    file = with_tests(part("mean", 0.1), part("test", 0.02))
    vacuums = np.array([40e3, 60e3, 90e3])
    many = Prediction(file, vacuums, SLIP)
    forces = brake_force(SLIP, vacuums, many.brakes)
    assert forces.shape == (many.samples, 3)
    for place, vacuum in enumerate(vacuums):
        one = Prediction(file, float(vacuum), SLIP)
        alone = brake_force(SLIP, float(vacuum), one.brakes)
        assert np.allclose(alone, forces[:, place], rtol=1e-12)


def test_tested_within_a_tenth_of_the_range():
    file = with_tests(part("mean", 0.01))
    assert Prediction(file, 0.91 * 55e3, 0.043, 0.0142).basis.word == "tested"
    assert Prediction(file, 1.09 * 65e3).basis.word == "tested"
    for vacuum in (0.89 * 55e3, 1.11 * 65e3):
        prediction = Prediction(file, vacuum, SLIP, 2.0)
        basis = prediction.basis
        assert basis.word == "extrapolated"
        stated = prediction.state(force=np.ones(1000))["extrapolated"]
        assert stated == [
            {"quantity": "vacuum", "value": vacuum, "low": 55e3, "high": 65e3},
            {"quantity": "speed", "value": 2.0, "low": 0.013, "high": 0.013},
        ]
        assert "speed 2 m/s; tested at 13 mm/s" in basis.reason


def test_a_changed_dimension_makes_the_tests_void():
    file = with_tests(part("mean", 0.01))
    wider = replace(file, brake=replace(file.brake, sheets=replace(file.brake.sheets, width=0.015)))
    assert Prediction(file, VACUUM).notices() == []
    prediction = Prediction(wider, VACUUM)
    assert prediction.basis.word == "handbook"
    [notice] = prediction.notices()
    assert "sheets.width was 13 mm, is 15 mm" in notice
    _, low, high = friction(wider)
    assert high / low > 3


def test_a_brake_without_tests_rests_on_handbook_values():
    prediction = Prediction(FILE, VACUUM)
    assert prediction.basis.word == "handbook"
    assert prediction.notices() == []


def with_specimens(*covariances: Part, strain: float = 4.0, others: tuple = ()) -> BrakeFile:
    """The brake with evidence of tensile tests of its enclosure."""
    tests = Evidence(
        command="enclosure",
        date="2026-11-28",
        tests=5,
        names=("enclosure_force",),
        ranges={"strain": (0.0, strain)},
        fitted=state_fitted("enclosure", FILE.known_values),
        parts=covariances,
    )
    return replace(FILE, evidence=(*others, tests))


def test_a_tested_enclosure_has_the_interval_of_a_monte_carlo_simulation():
    """Its force is the root of modulus times friction: five bars, and friction within 1.5."""
    random = np.random.default_rng(7)
    modulus, drag = 0.08, math.log(1.5)
    parts = (
        Part("mean", ((modulus**2 / 5 / 4,),), 4.0),
        Part("mean", ((drag**2 / 4,),)),
    )
    prediction = Prediction(with_specimens(*parts), VACUUM, SLIP)
    found = prediction.interval(enclosure_force(SLIP, VACUUM, prediction.brakes))
    logs = modulus / 5**0.5 * random.standard_t(4, 400_000) + drag * random.standard_normal(400_000)
    value = float(enclosure_force(SLIP, VACUUM, FILE.brake))
    due = value * np.quantile(np.exp(logs / 2), [0.025, 0.975])
    assert (found["low"], found["high"]) == pytest.approx(tuple(due), rel=0.01)


def test_a_stated_uncertainty_of_the_enclosure_is_that_of_its_owner():
    file = with_specimens(Part("mean", ((0.04,),))).with_(force_uncertainty=0.1)
    prediction = Prediction(file, VACUUM, SLIP)
    found = prediction.interval(enclosure_force(SLIP, VACUUM, prediction.brakes))
    assert math.log(found["high"] / found["low"]) == pytest.approx(2 * 1.96 * 0.1, rel=0.01)


def test_a_strain_beyond_the_specimens_is_named_unless_a_pull_reached_its_slip():
    # of paper, eq. 5: at the end of a face, half of the force over its stiffness EA
    sheets, enclosure = FILE.brake.sheets, FILE.brake.enclosure
    strain = 140 / 2 / (enclosure.modulus * sheets.width * enclosure.wall)
    part_of = Part("mean", ((0.04,),))
    basis = Prediction(with_specimens(part_of, strain=1.0), VACUUM, 0.04).basis
    assert basis.word == "handbook"
    (beyond,) = basis.extrapolations
    force = float(enclosure_force(0.04, VACUUM, FILE.brake))
    assert (beyond.quantity, beyond.high) == ("strain", 1.0)
    assert beyond.value == pytest.approx(strain * force / 140, rel=1e-6)
    assert "strain" in basis.reason and "no test of this brake" in basis.reason
    pulls = with_tests(part("mean", 0.02)).evidence
    both = with_specimens(part_of, strain=1.0, others=pulls)
    assert Prediction(both, VACUUM, 0.04).basis.word == "tested"
    names = [e.quantity for e in Prediction(both, VACUUM, 0.05).basis.extrapolations]
    assert names == ["slip", "strain"]
