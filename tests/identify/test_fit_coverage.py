"""The 95 % intervals hold in random campaigns; `make coverage` runs a thousand of each kind."""

from __future__ import annotations

import re

import pytest
from scipy import stats

from interval_coverage import BOUNDS, CASES, PAGE, SEED, measure

CAMPAIGNS = 100


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name.replace(" ", "-"))
def test_intervals_contain_the_truth(case) -> None:
    """As often as a share of 95 % allows in a hundred campaigns, but for one in ten thousand."""
    least = stats.binom.ppf(1e-4, CAMPAIGNS, 0.95)
    for name, tally in measure(case, CAMPAIGNS, SEED + 1).items():
        assert tally.inside >= least - tally.missing, (name, tally.inside)
        assert tally.missing <= 5, name
        # neither side of the truth is missed far more often than the other
        assert max(tally.below, tally.above) <= 2 + stats.binom.ppf(1 - 1e-4, CAMPAIGNS, 0.025)


def test_the_page_holds_every_kind_within_the_bounds() -> None:
    text = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| `(\w+)` \| ([\d.]+)% \|", text, re.MULTILINE)
    assert {name for name, _, _ in rows} == {case.name for case in CASES}
    low, high = BOUNDS
    for name, parameter, share in rows:
        assert low <= float(share) / 100 <= high, (name, parameter)
    assert {p for _, p, _ in rows} == {
        "scale_factor", "stiffness", "enclosure_factor", "pressure_exponent", "speed_slope",
    }  # fmt: skip
    assert "synthetic" in text and f"--seed {SEED}" in text
