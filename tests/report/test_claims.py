"""Verdicts are computed from the two numbers, never typed in."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.studies.choi2018.claims import Verdict, beyond, number, statement

numbers = st.floats(-1e6, 1e6, allow_nan=False)


@given(numbers, numbers, st.floats(0, 1e3))
def test_number(paper: float, ours: float, tolerance: float) -> None:
    claim = number("c", "II", paper, ours, "N", tolerance, "why", "otherwise")
    same = abs(ours - paper) <= tolerance
    assert claim.verdict == (Verdict.REPRODUCED if same else Verdict.DIFFERS)
    assert ("otherwise" in claim.why) is not same and "why" in claim.why
    assert claim.row() == {
        "claim": "c", "section": "II", "paper": paper, "ours": ours, "unit": "N",
        "verdict": str(claim.verdict), "why": claim.why,
    }  # fmt: skip


def test_the_difference_is_said() -> None:
    assert number("c", "II", 10.0, 17.94, "g", 0.5).why == "+79.4% against the paper"
    assert number("c", "II", 0.0, 1.0, "g", 0.5).verdict is Verdict.DIFFERS
    assert number("c", "II", 17.5, 17.55, "N", 0.05 + 1e-12).verdict is Verdict.REPRODUCED


@pytest.mark.parametrize(("holds", "verdict"), [(True, "reproduced"), (False, "differs")])
def test_statement(holds: bool, verdict: str) -> None:
    claim = statement("c", "II", holds, "ours", "why")
    assert str(claim.verdict) == verdict and claim.paper == "as stated" and claim.ours == "ours"


def test_the_other_two() -> None:
    assert str(beyond("c", "II", 32.0, "%", "why").verdict) == "not reproducible"
    assert [str(v) for v in Verdict] == ["reproduced", "differs", "not reproducible", "not yet"]
