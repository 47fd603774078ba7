"""Every check of a calibration fails when it should, and only then."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from laboratory.campaigns.bench import FULL, curve
from layerjam.laboratory.identify.calibration.peaks import calibrate, calibrate_peaks
from layerjam.laboratory.identify.curves import make_curve
from layerjam.laboratory.identify.fit_checks import (
    Check,
    check_agreement,
    check_curve_end,
    check_no_trend,
    check_plausibility,
    check_stiffness,
    note_identifiability,
)
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON, change


def verdicts(checks: tuple[Check, ...]) -> dict[str, bool]:
    return {c.name: c.passed for c in checks}


def fitted(*pulls: tuple[float, float], brake=KAPTON, **values) -> dict[str, bool]:
    """Verdicts of a calibration of `brake` on (scale factor, vacuum) pulls of a changed one."""
    data = [
        (pull_features(curve(change(KAPTON, scale_factor=a, **values), p, rows=16001)), p)
        for a, p in pulls
    ]
    return verdicts(calibrate(data, brake).checks)


THREE = ((0.875, 40e3), (0.875, 60e3), (0.875, 90e3))


def test_a_good_calibration_passes_everything() -> None:
    assert fitted(*THREE) == {
        "identifiable": True, "plausible": True, "stiffness": True, "repeats": True,
        "trend over vacuum": True, "shape": True, "pull by pull": True, "seating": True,
        "stiffness repeats": True, "stiffness's trend over vacuum": True,
        "scale factor interval": True, "stiffness interval": True, "mountings": True,
        "pulls": True, "zero": True, "enclosure": True, "enclosure's factor over vacuum": True,
    }  # fmt: skip


def test_one_pull_says_nothing_about_repeats_and_has_no_trend() -> None:
    assert fitted((0.875, FULL)) == {
        "identifiable": True, "plausible": True, "stiffness": True, "repeats": False,
        "shape": True, "pull by pull": True, "seating": True, "mountings": True,
        "pulls": True, "zero": True, "enclosure": True,
    }  # fmt: skip


def failed(found: dict[str, bool]) -> set[str]:
    return {name for name, passed in found.items() if not passed}


@pytest.mark.parametrize("factor", [0.45, 2.1])
def test_an_implausible_factor(factor: float) -> None:
    pulls = [(factor, p) for _, p in THREE]
    assert failed(fitted(*pulls, stiffness_measured=7e5)) == {"plausible"}


def test_too_stiff_for_the_sheets() -> None:
    assert failed(fitted(*THREE, stiffness_measured=900e3)) == {"stiffness"}
    assert failed(fitted(*THREE, stiffness_measured=800e3)) == set()


def test_pulls_that_disagree() -> None:
    same = [(0.80, 60e3), (0.95, 60e3)]
    assert failed(fitted(*same)) == {"repeats", "scale factor interval"}
    assert failed(fitted((0.86, 60e3), (0.89, 60e3))) == set()


def test_a_trend_over_vacuum() -> None:
    drift = [(0.84, 40e3), (0.875, 60e3), (0.91, 90e3)]
    # three pulls with one degree of freedom tell nothing: at 2.5 errors chance alone made a trend
    # of every fourth
    assert failed(fitted(*drift)) == set()
    assert "trend over vacuum" in failed(fitted(*drift, *drift))


def test_a_wrong_sleeve_shows_at_the_end_of_the_curve() -> None:
    assert failed(fitted(*THREE, film__friction_on_silicone=0.05)) == {"shape", "enclosure"}
    short = change(KAPTON, sheets__overlap=0.055)
    assert "shape" in failed(fitted(*THREE, brake=short))


def started(share: float, fades: float, seed: int, factor: float = 0.85) -> PullFeatures:
    """A pull whose friction is greater by a `share` at first and fades over slip [m], by bisection.

    Written from section 2 of mechanics.md, without our law: sheets' friction, sleeve, spring.
    """
    film, sheets, rubber = KAPTON.film, KAPTON.sheets, KAPTON.enclosure
    width, contacts = sheets.width, sheets.count - 1
    root = 2 * math.sqrt(
        rubber.modulus * width * rubber.wall * FULL * film.friction_on_silicone * width
    )
    noise = np.random.default_rng(seed)
    factor *= 1 + 0.01 * noise.standard_normal()

    def force(slip):
        sheet = factor * film.kinetic * contacts * width * (sheets.overlap - slip) * FULL
        return sheet * (1 + share * np.exp(-slip / fades)) + root * np.sqrt(slip)

    u = np.arange(0.0, 0.04, 1.3e-5)
    low, high = np.zeros_like(u), u.copy()
    for _ in range(60):
        middle = (low + high) / 2
        sticks = 131e3 * (u - middle) < force(middle)
        low, high = np.where(sticks, low, middle), np.where(sticks, middle, high)
    shown = 131e3 * (u - low) + 0.15 * noise.standard_normal(len(u))
    return pull_features(Trace(force=shown, elongation=u, time=None, path=f"{seed}", format=""))


@pytest.mark.parametrize(("share", "fades"), [(0.15, 5e-4), (0.15, 2e-3), (0.05, 1e-3)])
def test_static_friction_at_the_peak_is_seen(share: float, fades: float) -> None:
    """With 15 % more at the start, 0.97 and more was stated for 0.85, to 1 %, with six ok."""
    for campaign in range(10):
        pulls = [make_curve(started(share, fades, 10 * campaign + i), FULL) for i in range(6)]
        # stated mountings, because the intervals would otherwise reach the true value
        found = calibrate_peaks([replace(p, mounting=i) for i, p in enumerate(pulls)], KAPTON)
        interval = found.intervals["scale_factor"]
        assert interval is not None and interval.low > 0.85  # excludes the true value
        odd = failed(verdicts(found.checks))
        # 15 % show in every single pull too
        assert odd == ({"shape", "pull by pull"} if share == 0.15 else {"shape"})


def test_pulls_without_it_pass() -> None:
    """True pulls and a sleeve 20 % off what the file says: at most one of twenty campaigns."""
    alarms = 0
    for campaign in range(20):
        pulls = [(started(0.0, 1.0, 10 * campaign + i), FULL) for i in range(4)]
        brake = KAPTON if campaign % 2 else change(KAPTON, film__friction_on_silicone=0.29)
        alarms += "shape" in failed(verdicts(calibrate(pulls, brake).checks))
    assert alarms <= 1


def test_bounds_of_the_single_checks() -> None:
    assert [check_plausibility(x).passed for x in (0.499, 0.5, 2.0, 2.001)] == [
        False,
        True,
        True,
        False,
    ]
    assert "the friction, the vacuum" in check_plausibility(3.0).sentence
    assert [check_stiffness(k, 808e3).passed for k in (808e3, 808.1e3)] == [True, False]
    assert [check_curve_end(p, 100.0).passed for p in (84.9, 85.1, 114.9, 115.1)] == [
        False, True, True, False,
    ]  # fmt: skip
    assert not check_curve_end(10.0, 0.0).passed
    assert (
        "0.24" in note_identifiability(KAPTON).sentence
        and "product" in note_identifiability(KAPTON).sentence
    )


def test_agreement_allows_three_of_their_own_errors() -> None:
    wide, narrow = [0.8, 1.0], [0.875, 0.880]
    assert not check_agreement(wide, [0.001, 0.001]).passed
    assert check_agreement(wide, [0.1, 0.1]).passed
    assert check_agreement(narrow, [0.0, 0.0]).passed
    assert not check_agreement([0.9], [0.1]).passed


def test_trend_needs_three_vacuums_and_more_than_scatter() -> None:
    assert check_no_trend([1.0, 2.0], [1.0, 2.0], "vacuum", "Pa") is None
    assert check_no_trend([1.0, 2.0, 1.5], [1.0, 2.0, 2.0], "vacuum", "Pa") is None
    x = np.linspace(20e3, 90e3, 8)
    rng = np.random.default_rng(4)
    noise = 0.1 * rng.standard_normal(8)
    scattered = check_no_trend(list(1 + noise), list(x), "vacuum", "Pa")
    drifting = check_no_trend(list(1 + 2e-6 * x), list(x), "vacuum", "Pa")
    assert scattered is not None and scattered.passed
    assert drifting is not None and not drifting.passed and "20 kPa to 90 kPa" in drifting.sentence
