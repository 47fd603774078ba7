"""The budget against a Monte Carlo of the same errors, and against its closed limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import peak, scale_factor_of_peak
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.identify.calibration.budget import (
    Budget,
    Contribution,
    Peak,
    enclosure_line,
    make_budget,
    make_friction_lines,
    make_limit_lines,
    round_to_uncertainty,
    scatter_line,
)
from layerjam.laboratory.identify.calibration.intervals import (
    combine_uncertainties,
    coverage_factor,
)
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.identify.statistics import summarise_repeats
from strategies import unchecked

BRAKE = load("choi2018-kapton").brake


def peaks(*vacuums: float) -> list[Peak]:
    return [Peak(float(peak(p, 0.04, BRAKE).force), p) for p in vacuums]


def test_without_an_enclosure_every_sensitivity_is_one() -> None:
    """a = F/(mu (n-1) W P L2): plus one in the force, minus one in all else."""
    bare = unchecked(BRAKE, enclosure=unchecked(BRAKE.enclosure, modulus=1e-9))
    at = [Peak(170.0, 94.5e3)]
    known = scatter_line((0.01, 4), 1.0, ""), enclosure_line(at, bare)
    found = make_budget(at, bare, (*known, *make_limit_lines(at, bare, {})), {})
    assert [c.sensitivity for c in found.contributions] == pytest.approx(
        [1.0, 0.0, 1.0, -1.0, -1.0, -1.0], abs=2e-4
    )


def test_the_combined_uncertainty_is_that_of_a_monte_carlo() -> None:
    """Errors that all pulls share, drawn as the budget takes them: rectangular and normal."""
    random, count = np.random.default_rng(12), 40_000
    here = peaks(94.5e3, 60e3, 60e3, 20e3)
    cell, gauge, width, overlap = 0.01, 400.0, 0.01, 0.006
    limits = {"load_cell": cell, "gauge": gauge}
    sds = {"sheets.width": width, "sheets.overlap": overlap}
    sources = {path: Source(kind="measured", sd=sd) for path, sd in sds.items()}
    brake = replace(BRAKE, enclosure=replace(BRAKE.enclosure, force_uncertainty=0.25))
    known = scatter_line((0.004, np.inf), 1.0, ""), enclosure_line(here, brake)
    found = make_budget(here, brake, (*known, *make_limit_lines(here, brake, limits)), sources)
    read = 1 + random.uniform(-cell, cell, count)
    off = random.uniform(-gauge, gauge, count)
    wide, long = (1 + sd * random.standard_normal(count) for sd in (width, overlap))
    sheets = replace(
        BRAKE.sheets, width=BRAKE.sheets.width * wide, overlap=BRAKE.sheets.overlap * long
    )
    sleeve = change_shape(BRAKE, 1.0, None, np.exp(0.25 * random.standard_normal(count)))
    other = replace(sleeve, sheets=sheets)
    factors = [scale_factor_of_peak(p.force * read, p.vacuum + off, other) for p in here]
    drawn = np.mean(np.asarray(factors), axis=0)
    drawn = drawn * (1 + 0.004 * random.standard_normal(count))
    assert found.is_complete
    assert found.standard_uncertainty == pytest.approx(drawn.std() / drawn.mean(), rel=0.02)
    assert found.standard_uncertainty is not None and found.expanded_uncertainty is not None
    assert found.expanded_uncertainty == pytest.approx(
        stats.norm.ppf(0.975) * found.standard_uncertainty
    )


def test_the_enclosures_line_is_that_of_a_monte_carlo() -> None:
    """A light film, where it matters; the same enclosure in every pull."""
    light = load("choi2018-ptfe").brake
    at = [Peak(float(peak(p, 0.04, light).force), p) for p in (22e3, 40e3)]
    line = enclosure_line(at, light)
    drawn = np.random.default_rng(3).normal(1, 0.05, 20_000)
    other = change_shape(light, 1.0, None, drawn)
    factors = np.mean([scale_factor_of_peak(p.force, p.vacuum, other) for p in at], axis=0)
    assert line.standard == 0.3 and line.supply
    assert abs(line.sensitivity) * 0.05 == pytest.approx(factors.std() / factors.mean(), rel=0.03)
    stated = replace(light, enclosure=replace(light.enclosure, force_uncertainty=0.1))
    known = enclosure_line(at, stated)
    assert known.standard == 0.1 and not known.supply


def test_effective_degrees_of_freedom_are_those_of_the_gums_end_gauge() -> None:
    """GUM, H.1.6: 25, 9.7, 2.9 and 16.6 nm with 18, 25.6, 50 and 2 degrees of freedom."""
    parts = [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)]
    whole, degrees = combine_uncertainties(parts)
    assert whole == pytest.approx(32, abs=0.5)
    assert degrees == pytest.approx(16.7, abs=0.2)
    assert stats.t.ppf(0.995, int(degrees)) * whole == pytest.approx(93, abs=1)


def test_few_pulls_widen_the_expanded_uncertainty() -> None:
    """Three pulls: k is Student's 4.30, not 2; a known contribution brings it towards 1.96."""
    pulls = scatter_line((0.01, 2), 1.25, "")
    alone = Budget(contributions=(pulls,), value=1.25)
    assert alone.coverage_factor == pytest.approx(stats.t.ppf(0.975, 2))
    assert alone.expanded_uncertainty == pytest.approx(stats.t.ppf(0.975, 2) * 0.008)
    cell = Contribution(what="load cell", basis="", standard=0.01, sensitivity=1.0)
    both = Budget(contributions=(pulls, cell), value=1.25)
    degrees = (0.008**2 + 0.01**2) ** 2 / (0.008**4 / 2)
    assert both.degrees_of_freedom == pytest.approx(degrees)
    # Student's 2.59 for these; three pulls alone already need 4.30 * 0.008
    alone_needs = stats.t.ppf(0.975, 2) * 0.008 / np.hypot(0.008, 0.01)
    assert both.coverage_factor == pytest.approx(max(stats.t.ppf(0.975, degrees), alone_needs))
    many = scatter_line((0.01, 40), 1.25, "")
    more = Budget(contributions=(many, cell), value=1.25)
    degrees = (0.008**2 + 0.01**2) ** 2 / (0.008**4 / 40)
    assert more.coverage_factor == pytest.approx(stats.t.ppf(0.975, degrees))


@pytest.mark.parametrize("count", [2, 3, 6])
@pytest.mark.parametrize("drawn", [0.0, 0.01])
def test_the_expanded_uncertainty_holds_over_campaigns(count: int, drawn: float) -> None:
    """A shared error, drawn or absent, and the pulls' scatter: the mean lies within it."""
    random, campaigns = np.random.default_rng(7), 4000
    pulls = random.normal(1, 0.01 * count**0.5, (campaigns, count))
    pulls = pulls + drawn * random.standard_normal((campaigns, 1))
    errors = pulls.std(axis=1, ddof=1) / count**0.5
    parts = [[(e, count - 1.0), (0.01, np.inf)] for e in errors.tolist()]
    reach = np.array([coverage_factor(one) * combine_uncertainties(one)[0] for one in parts])
    share = float((np.abs(pulls.mean(axis=1) - 1) <= reach).mean())
    assert share >= 0.93
    if drawn == 0.0:
        assert share >= 0.945


@pytest.mark.parametrize(
    ("value", "uncertainty", "texts"),
    [
        (1.24321, 0.02249, ("1.243", "0.022")),
        (0.87499, 0.0996, ("0.87", "0.10")),
        (1.9, 0.000447, ("1.90000", "0.00045")),
        (123456.0, 1234.0, ("123500", "1200")),
        (12.0, 9.96, ("12", "10")),
    ],
)
def test_the_headline_has_two_significant_digits(
    value: float, uncertainty: float, texts: tuple[str, str]
) -> None:
    """GUM, 7.2.6, rounded by hand."""
    assert round_to_uncertainty(value, uncertainty) == texts


def test_nothing_stated_is_not_zero() -> None:
    at = peaks(94.5e3)
    found = make_budget(
        at,
        BRAKE,
        (
            scatter_line(None, 1.0, "one"),
            enclosure_line(at, BRAKE),
            *make_limit_lines(at, BRAKE, {}),
        ),
        {},
    )
    assert (
        found.standard_uncertainty is None
        and found.expanded_uncertainty is None
        and found.headline is None
    )
    assert found.coverage_factor is None and found.degrees_of_freedom is None
    words = " ".join(found.missing)
    for needed in ("load_cell_limit", "gauge_limit", "sheets.width", "sheets.overlap", "repeat"):
        assert needed in words
    assert "enclosure.force_uncertainty" in words


def test_what_nobody_stated_is_said_and_adds_nothing() -> None:
    one = scatter_line(None, 1.0, "one pull")
    at = peaks(94.5e3)
    found = make_budget(at, BRAKE, [one, *make_limit_lines(at, BRAKE, {"load_cell": 0.01})], {})
    stated = {c.what: c.standard is not None for c in found.contributions}
    assert stated == {
        "repeats": False,
        "load cell": True,
        "vacuum gauge": False,
        "width of the sheets": False,
        "overlap at rest": False,
    }
    assert not found.is_complete
    force = found.contributions[1]
    assert found.standard_uncertainty == pytest.approx(force.sensitivity * 0.01 / 3**0.5, rel=1e-12)
    assert [c.basis for c in found.contributions if c.standard is None][1:] == ["not stated"] * 3


@pytest.mark.parametrize("exponent", [0.0, -0.2])
def test_the_friction_rig_enters_as_its_errors_do(exponent: float) -> None:
    """Errors drawn as the lines take them: a = c/mu, mu = (F/N) (P A/N)^m at the pressure P."""
    random, count = np.random.default_rng(4), 100_000
    limits = {"load_cell": 0.01, "normal_force": 0.02, "area": 0.03}
    tests = summarise_repeats([0.238, 0.241, 0.243])
    force, normal, area = (1 + random.uniform(-x, x, count) for x in limits.values())
    drawn = tests.mean + (tests.standard_error or 0.0) * random.standard_normal(count)
    friction = drawn * force / normal * (area / normal) ** exponent
    factor = 1 / friction
    lines = make_friction_lines(tests, limits, exponent)
    found = Budget(contributions=lines)
    assert found.is_complete
    assert found.standard_uncertainty == pytest.approx(factor.std() / factor.mean(), rel=0.01)
    assert [c.degrees for c in lines] == [2, math.inf, math.inf, math.inf]


def test_what_the_friction_rig_does_not_state_is_listed() -> None:
    """One test has no scatter; the area counts only if friction depends on pressure."""
    one = summarise_repeats([0.24])
    missing = Budget(contributions=make_friction_lines(one, {}, 0.0)).missing
    assert len(missing) == 3 and "second friction test" in missing[0]
    assert "load_cell_limit" in missing[1] and "normal_force_limit" in missing[2]
    assert Budget(contributions=make_friction_lines(one, {}, 0.0)).standard_uncertainty is None
    assert "area_limit" in Budget(contributions=make_friction_lines(one, {}, 0.1)).missing[3]
