"""Verdicts are computed from the two numbers, never typed in."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.studies.choi2018.claims import (
    VERDICTS,
    Basis,
    Claim,
    PrintedClaim,
    Verdict,
    claim,
    count_verdicts,
    judge_claim,
    load_paper,
)

numbers = st.floats(-1e6, 1e6, allow_nan=False)


def number(paper: float, tolerance: float) -> PrintedClaim:
    return PrintedClaim(
        claim="c",
        section="II",
        against="other numbers",
        because="because",
        paper=paper,
        unit="N",
        tolerance=tolerance,
        why="why {x}",
        otherwise="otherwise",
    )


@given(numbers, numbers, st.floats(0, 1e3))
def test_number(paper: float, ours: float, tolerance: float) -> None:
    found = judge_claim(number(paper, tolerance), ours, x="this")
    same = abs(ours - paper) <= tolerance
    assert found.verdict == (Verdict.REPRODUCED if same else Verdict.DIFFERS)
    assert ("otherwise" in found.why) is not same and "why this" in found.why
    row = {"claim": "c", "section": "II", "paper": paper, "ours": ours, "unit": "N"}
    words = {"verdict": str(found.verdict), "because": "because", "why": found.why, "again": ""}
    assert found.row() == row | words


def test_the_difference_is_said() -> None:
    assert judge_claim(number(10.0, 0.5), 17.94, x="").why.startswith(
        "+79.4% relative to the paper; "
    )
    assert judge_claim(number(0.0, 0.5), 1.0, x="").verdict is Verdict.DIFFERS
    assert judge_claim(number(17.5, 0.05 + 1e-12), 17.55, x="").verdict is Verdict.REPRODUCED


def statement(against: str, **more: str) -> PrintedClaim:
    return PrintedClaim(
        claim="c", section="II", against=against, because="b", ours="{y:.1f} N", why="why", **more
    )


@pytest.mark.parametrize(
    ("against", "holds", "verdict"),
    [
        ("other numbers", True, "reproduced"),
        ("other numbers", False, "differs"),
        ("own words", True, "consistent"),
        ("own words", False, "differs"),
        ("itself", True, "by construction"),
        ("itself", False, "ours to explain"),
        ("our assumptions", True, "consistent"),
        ("our assumptions", False, "ours to explain"),
    ],
)
def test_statement(against: str, holds: bool, verdict: str) -> None:
    found = judge_claim(statement(against), holds=holds, y=2.0)
    assert str(found.verdict) == verdict and found.paper == "as stated" and found.ours == "2.0 N"


def test_nothing_to_compare_is_said_and_nothing_else_is() -> None:
    row = PrintedClaim(
        claim="c", section="II", against="nothing", because="b", paper=32.0, unit="%", why="why"
    )
    assert str(judge_claim(row).verdict) == str(judge_claim(row, 3.0).verdict) == "not reproducible"
    with pytest.raises(ValueError, match="c: cannot be judged against nothing"):
        judge_claim(row, holds=True)
    with pytest.raises(ValueError, match="c: cannot be judged against itself"):
        judge_claim(statement("itself"), y=2.0)
    with pytest.raises(ValueError, match="hearsay"):
        judge_claim(statement("hearsay"), holds=True, y=2.0)


def test_only_other_numbers_reproduce() -> None:
    agrees = {against: pair[0] for against, pair in VERDICTS.items()}
    assert set(agrees) == set(Basis)
    assert [a for a, v in agrees.items() if v is Verdict.REPRODUCED] == [Basis.OTHER_NUMBERS]
    assert {v for pair in VERDICTS.values() for v in pair} == set(Verdict)


def test_a_claim_looked_at_again_is_not_counted() -> None:
    rows: list[Claim] = [judge_claim(statement("own words"), holds=False, y=1.0)] * 2
    rows.append(judge_claim(statement("own words", again="full"), holds=False, y=1.0))
    assert rows[2].again == "Fig. 11: full vacuum gives about 20 % of 50 g"
    counts = count_verdicts(rows)
    assert list(counts) == list(Verdict) and counts.pop(Verdict.DIFFERS) == 2
    assert not any(counts.values())


def test_every_claim_of_the_file_is_one() -> None:
    for key, row in load_paper()["claim"].items():
        printed = PrintedClaim(**row)
        assert printed.section.startswith("I") and len(printed.because) > 10, key
        assert Basis(printed.against) and (
            not printed.again or printed.again in load_paper()["claim"]
        )
    with pytest.raises(KeyError):
        claim("no such claim")
