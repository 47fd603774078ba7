"""What a report that one can sign states, and that it says what nobody stated."""

from __future__ import annotations

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
        Contribution(what="repeats", basis="standard error", standard=0.003, sensitivity=1.0),
        Contribution(what="load cell", basis="limit", standard=0.004, sensitivity=1.0),
        Contribution(what="overlap", basis="not stated", standard=None, sensitivity=-1.0),
    )
    table = budget_table(Budget(contributions=lines))
    values = {n.quantity.split(": ")[-1].split("factor, ")[-1]: n.value for n in numbers_of(table)}
    assert values["combined"] == 0.005 and values["expanded (k = 2)"] == 0.01
    assert isinstance(table.rows[1][4], Number) and table.rows[1][4].text() == "0.400 %"
    assert table.rows[2][4] == "not stated" and "lower bound" in table.note
