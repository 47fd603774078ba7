"""What a report that one can sign states, and that it says what nobody stated."""

from __future__ import annotations

import pytest
from scipy import stats

from layerjam.core.drawing.page import Part
from layerjam.core.errors import count_text
from layerjam.laboratory.figures.brake_numbers import Number, table_numbers
from layerjam.laboratory.figures.signed import (
    NOT_STATED,
    STATED,
    budget_table,
    list_certificate_problems,
    make_apparatus,
    make_identity,
    make_signature_part,
)
from layerjam.laboratory.identify.calibration.budget import Budget, Contribution
from layerjam.laboratory.measure.certificate import Certificate
from layerjam.laboratory.measure.sidecar import Facts


def rows(*facts: Facts) -> dict[str, str]:
    part = make_apparatus([(f"pull-{k}.csv", one) for k, one in enumerate(facts, 1)])
    return {str(name): said.text for name, said in part.tables[0].rows}


def test_every_thing_has_a_row_and_says_when_nobody_stated_it() -> None:
    found = rows(Facts(), Facts())
    assert len(found) == len(STATED) and set(found.values()) == {"not stated"}


def test_what_all_state_stands_once_and_what_differs_names_the_files() -> None:
    one = Facts(operator="A. Nurse", film_lot="K17", gauge_limit=500.0, load_cell_limit=0.005)
    two = Facts(operator="A. Nurse", film_lot="K18", gauge_limit=500.0)
    found = rows(one, one, two, Facts(operator="A. Nurse"))
    assert found["operator"] == "A. Nurse"
    assert found["film lot"] == (
        "K17 (pull-1.csv and 1 more); K18 (pull-3.csv); not stated for 1 file"
    )
    assert found["gauge, error limit"].startswith("0.5 kPa (pull-1.csv and 2 more)")
    assert found["load cell, error limit"].startswith("0.5 % (pull-1.csv and 1 more)")


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
    values = {
        n.quantity.split(": ")[-1].split("factor, ")[-1]: n.value for n in table_numbers(table)
    }
    degrees = 0.005**4 / (0.003**4 / 2)
    # three pulls alone need more than Student's quantile for all
    student = max(stats.t.ppf(0.975, degrees), stats.t.ppf(0.975, 2) * 0.003 / 0.005)
    assert values["combined"] == pytest.approx(0.005)
    assert values["degrees of freedom"] == pytest.approx(degrees)
    assert values["coverage factor k"] == pytest.approx(student)
    assert values["expanded"] == pytest.approx(0.005 * student)
    assert isinstance(table.rows[1][4], Number) and table.rows[1][4].text() == "0.400 %"
    assert table.rows[-1][1] == f"k = {student:.2f}, ν = {degrees:.1f}"
    assert table.rows[2][4] == "not stated" and "lower bound" in table.note
    assert table.note.endswith("For a complete budget, state: its sd.")


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
    assert table.note.endswith("For a complete budget, state: a second pull; its SD.")


def test_the_signature_names_what_nobody_stated() -> None:
    """ISO/IEC 17025, 7.8.2.1: number, customer, laboratory, and the day of the tests."""
    bare = make_identity([("a.csv", Facts())], "", "", "2026-11-25")
    assert [k for k, text in bare.items() if text == NOT_STATED] == [
        "report number", "customer", "laboratory", "tests done on"
    ]  # fmt: skip
    said = " ".join(make_signature_part(bare).text)
    assert "Tests done on: not stated" in said and "date in conditions.toml" in said
    assert said.count("ISO/IEC 17025, section 7.8.2.1") == 4 and "--report-number" in said
    facts = Facts(date="2026-11-20", laboratory="Lab, Road 1", number="T-1", customer="C")
    full = make_identity([("a.csv", facts), ("b.csv", facts)], "L-7", "", "2026-11-25")
    assert full == {
        "report number": "L-7",
        "customer": "C",
        "laboratory": "Lab, Road 1",
        "tests done on": "2026-11-20",
        "issued on": "2026-11-25",
    }
    assert "not stated" not in " ".join(make_signature_part(full).text)
    one_day = make_identity([("a.csv", facts), ("b.csv", Facts())], "L-7", "C", "2026-11-25")
    assert "Tests done on: not stated" in " ".join(make_signature_part(one_day).text)


def test_certificates_are_judged_on_the_days_of_the_tests() -> None:
    cell = Certificate(number="K", date="2026-03-01", due="2027-03-01", laboratory="L")
    gauge = Certificate(number="P", date="2025-03-01", due="2026-03-01", laboratory="L")
    facts = Facts(
        date="2026-11-20 to 2026-11-22", load_cell_certificate=cell, gauge_certificate=gauge
    )
    stated = [("a.csv", facts), ("b.csv", facts)]
    table = make_apparatus(stated).tables[1]
    assert [row[:6] for row in table.rows] == [
        ["load cell", "K", "2026-03-01", "2027-03-01", "L", "valid"],
        ["vacuum gauge", "P", "2025-03-01", "2026-03-01", "L", "overdue since 2026-03-01"],
        ["normal force", *[NOT_STATED] * 4, ""],
    ]
    assert list_certificate_problems(stated) == [
        "Calibration certificate P of the vacuum gauge: "
        "overdue since 2026-03-01 (a.csv and 1 more)."
    ]
    early = [("a.csv", Facts(date="2026-02-28", load_cell_certificate=cell))]
    assert "calibrated after the tests" in list_certificate_problems(early)[0]
    assert list_certificate_problems([("a.csv", Facts(load_cell_certificate=cell))]) == []


def test_numbers_stand_right_although_the_first_is_not_stated() -> None:
    """Two lines of a budget, and facts that look like numbers and are words."""
    lines = (
        Contribution(what="repeats", basis="one", standard=None, sensitivity=1.0, supply="more"),
        Contribution(what="load cell", basis="limit", standard=0.004, sensitivity=1.0),
    )
    assert budget_table(Budget(contributions=lines)).template_data()["right"] == [
        False, False, True, True, True
    ]  # fmt: skip
    part = make_apparatus([("a.csv", Facts(number="17", load_cell_limit=0.005))])
    assert part.tables[0].template_data()["right"] == [False, False]


def test_a_page_prints_minus_signs_and_a_space_before_percent() -> None:
    """Sentences of commands have the hyphen of a keyboard; file names and options keep theirs."""
    said = "pull-3.csv: the law is -0.2% off (95 % interval -3.3% to -0.9%); --area -3 mm, ±1.5%"
    part = Part(id="p", title="P", text=[said]).template_data()
    assert part["text"] == [
        "pull-3.csv: the law is −0.2 % off (95 % interval −3.3 % to −0.9 %); --area −3 mm, ±1.5 %"
    ]


def test_one_is_counted_as_one() -> None:
    found = [count_text(n, "calibration pull") for n in (0, 1, 2)]
    assert found == ["0 calibration pulls", "1 calibration pull", "2 calibration pulls"]
