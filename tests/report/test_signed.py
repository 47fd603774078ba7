"""What a report that one can sign states, and that it says what nobody stated."""

from __future__ import annotations

import pytest
from scipy import stats

from layerjam.identify.calibration.budget import Budget, Contribution
from layerjam.measure.sidecar import Facts
from layerjam.report.brake_numbers import Number, numbers_of
from layerjam.report.signed import STATED, budget_table, circumstances


def rows(*facts: Facts) -> dict[str, str]:
    part = circumstances([(f"pull-{k}.csv", one) for k, one in enumerate(facts, 1)])
    return {str(name): str(said) for name, said in part.tables[0].rows}


def test_every_thing_has_a_row_and_says_when_nobody_stated_it() -> None:
    found = rows(Facts(), Facts())
    assert len(found) == len(STATED) and set(found.values()) == {"not stated"}


def test_what_all_state_stands_once_and_what_differs_names_the_files() -> None:
    one = Facts(operator="A. Nurse", film_lot="K17", gauge_limit=500.0, load_cell_limit=0.005)
    two = Facts(operator="A. Nurse", film_lot="K18", gauge_limit=500.0)
    found = rows(one, one, two, Facts(operator="A. Nurse"))
    assert found["operator"] == "A. Nurse"
    assert found["film lot"] == (
        "K17 (pull-1.csv and 1 more); K18 (pull-3.csv); not stated of 1 file"
    )
    assert found["gauge, limit of error"].startswith("0.5 kPa (pull-1.csv and 2 more)")
    assert found["load cell, limit of error"].startswith("0.005 of the reading")


def test_the_budgets_numbers_are_those_of_the_budget() -> None:
    lines = (
        Contribution(
            what="repeats", basis="standard error", standard=0.003, sensitivity=1.0, degrees=2
        ),
        Contribution(what="load cell", basis="limit", standard=0.004, sensitivity=1.0),
        Contribution(
            what="overlap", basis="not stated", standard=None, sensitivity=-1.0, supply="its sd"
        ),
    )
    table = budget_table(Budget(contributions=lines))
    values = {n.quantity.split(": ")[-1].split("factor, ")[-1]: n.value for n in numbers_of(table)}
    degrees = 0.005**4 / (0.003**4 / 2)
    student = stats.t.ppf(0.975, degrees)
    assert values["combined"] == pytest.approx(0.005)
    assert values["degrees of freedom"] == pytest.approx(degrees)
    assert values["coverage factor k"] == pytest.approx(student)
    assert values["expanded"] == pytest.approx(0.005 * student)
    assert isinstance(table.rows[1][4], Number) and table.rows[1][4].text() == "0.400 %"
    assert table.rows[-1][1] == f"k = {student:.2f} for 95 %"
    assert table.rows[2][4] == "not stated" and "lower bound" in table.note
    assert table.note.endswith("State for a whole budget: its sd.")


def test_a_budget_in_which_nothing_is_stated_says_so() -> None:
    lines = (
        Contribution(
            what="repeats", basis="one", standard=None, sensitivity=1.0, supply="a second pull"
        ),
        Contribution(
            what="enclosure", basis="default", standard=0.3, sensitivity=-0.1, supply="its SD"
        ),
    )
    table = budget_table(Budget(contributions=lines))
    assert [row[4] for row in table.rows[-2:]] == ["not stated", "not stated"]
    assert "0.000 %" not in str(table.rows)
    assert table.note.endswith("State for a whole budget: a second pull; its SD.")
