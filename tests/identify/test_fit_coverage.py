"""The 95 % intervals hold in random campaigns; `make coverage` runs a thousand of each kind."""

from __future__ import annotations

import re

import pytest
from scipy import stats

from interval_coverage import CASES, LEAST, PAGE, SEED, is_outside, measure

CAMPAIGNS = 100


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name.replace(" ", "-"))
def test_intervals_contain_the_truth(case) -> None:
    """As often as a share of 95 % allows in a hundred campaigns, but for one in ten thousand."""
    count = CAMPAIGNS // case.part
    least = stats.binom.ppf(1e-4, count, 0.95 if case.least else 0.8)
    for name, tally in measure(case, count, SEED + 1).items():
        assert tally.inside >= least - tally.missing, (name, tally.inside)
        assert tally.missing <= 5, name
        # neither side of the truth is missed far more often than the other
        assert max(tally.below, tally.above) <= 2 + stats.binom.ppf(
            1 - 1e-4, count, 0.025 if case.least else 0.1
        )


def test_the_page_holds_every_kind_within_the_bounds() -> None:
    text = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| `(\w+)` \| ([\d.]+)% \|.*\| (\d+) \|$", text, re.MULTILINE)
    assert {name for name, *_ in rows} == {case.name for case in CASES}
    cases = {case.name: case for case in CASES}
    for name, parameter, share, count in rows:
        inside = round(float(share) / 100 * int(count))
        assert not is_outside(cases[name], inside, int(count)), (name, parameter)
    assert {p for _, p, *_ in rows} == {
        "scale_factor", "stiffness", "enclosure_factor", "pressure_exponent", "speed_slope",
    }  # fmt: skip
    assert "synthetic" in text and f"--seed {SEED}" in text


def test_the_rows_that_the_issue_names_are_there() -> None:
    """Mountings with all methods, enclosures that are off, 2 to 12 pulls, one to three vacuums."""
    names = {case.name for case in CASES if case.least == LEAST}
    for depth in ("exact", "curves", "bayesian"):
        kinds = {n.rpartition(" ")[2] for n in names if n.startswith(f"{depth}, 3 mountings")}
        assert kinds == {"pull", "mixed", "repeat"}
    for words in ("2 pulls", "three repeats", "6 pulls", "12 pulls"):
        assert f"exact, {words} in all" in names
    for words in ("two vacuums", "three vacuums"):
        assert f"exact, {words}, 3 repeats" in names
    assert sum("25 % off" in name for name in names) == 2
