"""The 95 % intervals hold in random campaigns; `make coverage` runs a thousand of each kind."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy import stats

from counts import cases
from interval_coverage import CASES, SEED, campaign, is_outside, measure
from interval_page import MARKS, PAGE
from interval_values import Pulls, of_curves, of_peaks
from layerjam.laboratory.identify.calibration.budget import Peak
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves

CAMPAIGNS = cases(100, 30)


@pytest.mark.parametrize("name", ["exact", "exact, 3 mountings of 6 pulls, per mixed"])
def test_values_have_the_intervals_of_whole_records(name: str) -> None:
    """The fast rows: with what the pulls of a record tell, their intervals are the product's."""
    case = next(c for c in CASES if c.name == name)
    found = campaign(case, np.random.Generator(np.random.PCG64(3)))
    fit = calibrate_peaks(found.curves, found.brake)
    told = np.array([(f.scale_factor, f.stiffness) for f in fit.fits])
    peaks = tuple(Peak(f.pull.peak_force, f.vacuum) for f in fit.fits)
    fast = Pulls(
        brake=found.brake, truth=found.truth, curves=found.curves, own=told, told=told, peaks=peaks
    )
    for quantity, interval in of_peaks(fast).items():
        due = fit.intervals[quantity]
        assert (interval.low, interval.high) == pytest.approx((due.low, due.high), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("between", [0.0, 0.5])
def test_values_have_the_intervals_of_whole_curves(between: float) -> None:
    """Own parameters as the fit finds them give its intervals, but for the weights."""
    case = next(c for c in CASES if c.depth == "curves" and c.between == between)
    found = campaign(case, np.random.Generator(np.random.PCG64(5)))
    fit = calibrate_curves(found.curves, found.brake)
    own = fit.fit.own.own[:, :3].copy()
    own[:, :2] = np.exp(own[:, :2])
    fast = Pulls(
        brake=found.brake, truth=found.truth, curves=found.curves, own=own, told=own, peaks=()
    )
    for quantity, interval in of_curves(fast).items():
        due = fit.intervals[quantity]
        assert interval.half_width == pytest.approx(due.half_width, rel=0.1), quantity


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name.replace(" ", "-"))
def test_intervals_contain_the_truth(case) -> None:
    """As often as a share of 95 % allows of the campaigns, but for one in ten thousand."""
    least = stats.binom.ppf(1e-4, CAMPAIGNS, 0.95)
    for name, tally in measure(case, CAMPAIGNS, SEED + 1).items():
        assert tally.inside >= least - tally.missing, (name, tally.inside)
        assert tally.missing <= 5, name
        # neither side of the truth is missed far more often than the other
        assert max(tally.below, tally.above) <= 2 + stats.binom.ppf(
            1 - 1e-4, CAMPAIGNS, 0.025 if case.stated else 0.1
        )


def test_the_page_holds_every_kind_within_the_bounds() -> None:
    text = PAGE.read_text(encoding="utf-8")
    part = text.split(MARKS[0])[1].split(MARKS[1])[0]
    rows = re.findall(r"^\| ([^|]*) \| `(\w+)` \| ([\d.]+)% \|", part, re.MULTILINE)
    names = [name for name, *_ in rows if name]
    assert names == [case.name for case in CASES]
    by_name = {case.name: case for case in CASES}
    assert "could not be computed: 0." in part
    [asked] = map(int, re.findall(r"--campaigns (\d+) --seed", part))
    case = CASES[0]
    for name, parameter, share in rows:
        case = by_name.get(name, case)  # a further parameter of the same fit has no name
        inside = round(float(share) / 100 * asked)
        assert not is_outside(case, inside, asked), (case.name, parameter)
    assert {p for _, p, *_ in rows} == {
        "scale_factor", "stiffness", "enclosure_factor", "pressure_exponent", "speed_slope",
    }  # fmt: skip
    assert "synthetic" in text and f"--seed {SEED}" in text


def test_the_rows_that_the_issue_names_are_there() -> None:
    """Mountings with all methods, enclosures that are off, 2 to 12 pulls, one to three vacuums."""
    names = {case.name for case in CASES}
    for depth in ("exact", "curves", "bayesian"):
        kinds = {n.rpartition(" ")[2] for n in names if n.startswith(f"{depth}, 3 mountings")}
        assert kinds == {"pull", "mixed", "repeat"}
    for words in ("2 pulls", "three repeats", "6 pulls", "12 pulls"):
        assert f"exact, {words} in all" in names
    for words in ("two vacuums", "three vacuums"):
        assert f"exact, {words}, 3 repeats" in names
    assert sum("25 % off" in name for name in names) == 2
