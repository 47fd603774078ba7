"""Which values are unlike the others: against Grubbs' printed table, brute force, and chance."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from layerjam.laboratory.identify.odd import (
    FIRST,
    _find_likeliest_outliers,
    find_outliers,
    find_shifted_group,
)

GRUBBS = {3: 1.155, 5: 1.715, 8: 2.126, 10: 2.290, 12: 2.412, 20: 2.709}
"""Critical values, two-sided at 5 % (one-sided at 2.5 %), of Grubbs and Beck 1972, table 1."""


def on_the_edge(count: int, ratio: float) -> np.ndarray:
    """Values of mean 0 whose last lies `ratio` standard deviations off it, the others even."""
    rest = np.linspace(-1.0, 1.0, count - 1)
    low, high = 0.0, 1e6
    for _ in range(200):
        middle = (low + high) / 2
        values = np.append(rest, middle)
        far = (middle - values.mean()) / values.std(ddof=1)
        low, high = (middle, high) if far < ratio else (low, middle)
    return np.append(rest, low)


@pytest.mark.parametrize(("count", "critical"), GRUBBS.items())
def test_one_value_is_judged_as_in_grubbs_table(count: int, critical: float) -> None:
    share = FIRST if count >= 8 else 1.0  # the rest of the false alarms goes to sets of several
    if count == 3:  # no three values lie further than 2/sqrt(3) off: the table's own limit
        assert critical == pytest.approx(2 / math.sqrt(3), abs=1e-3)
        return
    for ratio, odd in ((critical - 0.006, ()), (critical + 0.006, (count - 1,))):
        assert find_outliers(on_the_edge(count, ratio), 0.05 / share, 0.0) == odd


@given(st.lists(st.floats(-5, 5), min_size=8, max_size=11, unique=True), st.integers(1, 2))
def test_the_likeliest_set_is_that_of_all_sets(values: list[float], size: int) -> None:
    """By trying every set of that size; the ratio of an ordinary analysis of variance."""
    x = np.array(values)
    tried = {}
    for out in itertools.combinations(range(len(x)), size):
        rest = np.delete(x, out)
        left = ((rest - rest.mean()) ** 2).sum()
        freedom = len(x) - 1 - size
        ratio = (((x - x.mean()) ** 2).sum() - left) / size / (left / freedom) if left else np.inf
        tried[out] = math.comb(len(x), size) * stats.f.sf(ratio, size, freedom)
    chance, which = _find_likeliest_outliers(x, size)
    assert chance == pytest.approx(min(tried.values()), rel=1e-6, abs=1e-12)
    assert tried[tuple(sorted(which))] == pytest.approx(chance, rel=1e-6, abs=1e-12)


@given(
    st.lists(st.floats(-1, 1), min_size=3, max_size=20),
    st.floats(-3, 3),
    st.floats(0.1, 10),
)
def test_the_verdict_knows_no_unit_and_no_zero(
    values: list[float], moved: float, scaled: float
) -> None:
    x = np.round(np.array(values), 6)
    assert find_outliers(x * scaled + moved, 0.05, 1e-3 * scaled) == find_outliers(x, 0.05, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("count", [4, 6, 12, 24])
def test_false_alarms_among_like_values(count: int) -> None:
    """The stated share at most, and not far below: three standard errors of 1,500 draws."""
    random = np.random.default_rng(count)
    found = sum(bool(find_outliers(random.standard_normal(count), 0.05, 0.0)) for _ in range(1500))
    assert 0.4 * 0.05 < found / 1500 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 1500)


def test_two_odd_values_do_not_hide_each_other() -> None:
    random = np.random.default_rng(4)
    both = single = 0
    for _ in range(200):
        x = random.standard_normal(12)
        x[:2] += 10.0
        both += find_outliers(x, 0.02, 0.0) == (0, 1)
        far = np.abs(x - x.mean()).max() / x.std(ddof=1)
        single += far > GRUBBS[12]
    assert both > 160 and single < 40


def test_too_few_or_too_near_or_too_far() -> None:
    assert find_outliers(np.array([0.0, 9.0]), 0.05, 0.0, 0.1) == ()
    near = np.array([0.0, 1e-9, -1e-9, 0.019])
    assert find_outliers(near, 0.05, 0.02) == () and find_outliers(near, 0.05, 0.018) == (3,)
    wide = np.array([-0.1, 0.1, 0.0, -0.05, 0.05, 0.13])
    assert find_outliers(wide, 0.05, 0.0) == () and find_outliers(wide, 0.05, 0.0, 0.1) == (0, 5)
    assert find_outliers(np.full(5, 3.0), 0.05, 0.0) == ()


def test_a_group_is_judged_as_by_a_t_test() -> None:
    random = np.random.default_rng(7)
    groups = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]
    alarms = 0
    for _ in range(400):
        x = random.standard_normal(12)
        found = find_shifted_group(x, groups, 0.1, 0.0)
        alarms += found is not None
        tests = [stats.ttest_ind(x[g], np.delete(x, g)).pvalue for g in groups]
        assert (found is not None) == (3 * min(tests) <= 0.1)
        if found is not None:
            assert list(found[0]) == groups[int(np.argmin(tests))]
            assert found[1] == pytest.approx(
                x[list(found[0])].mean() - np.delete(x, list(found[0])).mean()
            )
    assert alarms / 400 < 0.1 + 3 * math.sqrt(0.1 * 0.9 / 400)
    # of a group of one nothing says how it scatters, and a small shift does not matter
    assert find_shifted_group(np.array([0.0, 0.1, 5.0]), [[0, 1], [2]], 0.5, 0.0) is None
    even = np.array([0.0, 0.0, 0.01, 0.01])
    assert find_shifted_group(even, [[0, 1], [2, 3]], 0.05, 0.02) is None
    assert find_shifted_group(even, [[0, 1], [2, 3]], 0.05, 0.005) is not None
