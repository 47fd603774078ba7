"""Verdicts are computed from the two numbers, never typed in."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.studies.choi2018.claims import Printed, Verdict, claim, judged, paper

numbers = st.floats(-1e6, 1e6, allow_nan=False)


def number(paper: float, tolerance: float) -> Printed:
    return Printed(
        claim="c",
        section="II",
        paper=paper,
        unit="N",
        tolerance=tolerance,
        why="why {x}",
        otherwise="otherwise",
    )


@given(numbers, numbers, st.floats(0, 1e3))
def test_number(paper: float, ours: float, tolerance: float) -> None:
    found = judged(number(paper, tolerance), ours, x="this")
    same = abs(ours - paper) <= tolerance
    assert found.verdict == (Verdict.REPRODUCED if same else Verdict.DIFFERS)
    assert ("otherwise" in found.why) is not same and "why this" in found.why
    row = {"claim": "c", "section": "II", "paper": paper, "ours": ours, "unit": "N"}
    assert found.row() == row | {"verdict": str(found.verdict), "why": found.why}


def test_the_difference_is_said() -> None:
    assert judged(number(10.0, 0.5), 17.94, x="").why.startswith("+79.4% against the paper; ")
    assert judged(number(0.0, 0.5), 1.0, x="").verdict is Verdict.DIFFERS
    assert judged(number(17.5, 0.05 + 1e-12), 17.55, x="").verdict is Verdict.REPRODUCED


@pytest.mark.parametrize(("holds", "verdict"), [(True, "reproduced"), (False, "differs")])
def test_statement(holds: bool, verdict: str) -> None:
    row = Printed(claim="c", section="II", ours="{y:.1f} N", why="why")
    found = judged(row, holds=holds, y=2.0)
    assert str(found.verdict) == verdict and found.paper == "as stated" and found.ours == "2.0 N"


def test_the_other_two() -> None:
    row = Printed(claim="c", section="II", paper=32.0, unit="%", why="why")
    assert str(judged(row).verdict) == str(judged(row, 3.0).verdict) == "not reproducible"
    assert [str(v) for v in Verdict] == ["reproduced", "differs", "not reproducible", "not yet"]


def test_every_claim_of_the_file_is_one() -> None:
    for key, row in paper()["claim"].items():
        assert Printed(**row).section.startswith("I"), key
    with pytest.raises(KeyError):
        claim("no such claim")
