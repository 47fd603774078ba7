"""The page on faulty pulls holds what it must; the study itself, in small, when asked for."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from counts import cases
from layerjam.laboratory.campaigns.spec import Odd
from layerjam.laboratory.identify.pull.features import pull_features
from pull_faults import ALARMS, FAULTS, MARKS, MUST, NONE, PAGE, best_test, drawn, measure, seat


def rows() -> dict[str, list[str]]:
    """{what is wrong: cells} of the page's table."""
    text = PAGE.read_text(encoding="utf-8")
    part = text.split(MARKS[0])[1].split(MARKS[1])[0]
    found = re.findall(r"^\| (?:\*\*)?([^|*]+?)(?:\*\*)? \| ([\d,]+ \|.*) \|$", part, re.MULTILINE)
    return {name: cells.split(" | ") for name, cells in found}


def test_the_page_has_every_fault_and_what_must_be_found_is() -> None:
    found = rows()
    assert set(found) == {fault.name for fault in FAULTS}
    strong = [fault.name for fault in FAULTS if fault.strong]
    assert len(strong) >= 14
    for name in strong:
        campaigns, calibrated, _, *others, _ = found[name]
        assert int(campaigns) >= 100 and len(others) == 3
        for share in (calibrated, *others):
            assert float(share.rstrip("%")) / 100 >= MUST, (name, share)
    alarms = found[NONE]
    assert int(alarms[0].replace(",", "")) >= 1000
    for place in (1, 3, 4, 5):
        assert float(alarms[place].rstrip("%")) / 100 <= ALARMS


def test_the_seat_lowers_the_slope_by_what_it_says() -> None:
    fault = next(f for f in FAULTS if f.softer == 0.3 and f.of_all)
    made = drawn(fault, (5, 0, 0))
    stiffness = float(made.subjects[0].true.stiffness_measured or 0)
    middle = [t for t in made.tests if t.vacuum == 55e3]
    slopes = [
        pull_features(trace).stiffness / test.stiffness
        for test, trace in zip(made.tests, made.traces(), strict=True)
        if test in middle
    ]
    assert np.mean(slopes) == pytest.approx(0.7 * stiffness, rel=0.03)
    assert seat(0.3, 100.0, 1e5) > seat(0.1, 100.0, 1e5) > 0


def test_the_best_test_has_the_false_alarms_it_says() -> None:
    """Told of a shift that is not there."""
    fault = next(f for f in FAULTS if f.odd.friction_change == 0.1)
    found = []
    for number in range(60):
        made = drawn(replace(fault, odd=Odd()), (9, 0, number))
        odd = replace(made, spec=replace(made.spec, odd=fault.odd))
        found.append(best_test(fault, odd))
    assert 0 < sum(map(bool, found)) < 60 * ALARMS + 3 * np.sqrt(60 * ALARMS * (1 - ALARMS))


@pytest.mark.slow
def test_the_best_test_of_a_shape_is_told_of_one_that_is_not_there() -> None:
    fault = next(f for f in FAULTS if f.overshoot == 0.05 and f.of_all)
    found = []
    for number in range(cases(12, 6)):
        made = drawn(replace(fault, overshoot=0.0), (9, 1, number))
        machine = replace(made.spec.machine, overshoot=1e-4)
        found.append(best_test(fault, replace(made, spec=replace(made.spec, machine=machine))))
        assert best_test(fault, drawn(fault, (9, 1, number)))
    assert sum(map(bool, found)) <= cases(4, 2)  # more of 12, or 6, at 5 %: in one of 400


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [NONE, "friction of one pull +15 %", "static overshoot of all 5 %"]
)
def test_the_study_in_small(name: str) -> None:
    fault = next(f for f in FAULTS if f.name == name)
    tally = measure(fault, cases(60, 12), 77)
    if name == NONE:
        assert tally.found <= cases(8, 3)  # more of 60, or 12, at 5 %: in one of 400
    else:
        assert tally.found > 0.7 * tally.campaigns
