"""How many more pulls: against Student's t by hand, and against campaigns that are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from layerjam.laboratory.identify.calibration.intervals import (
    SURE,
    Further,
    Population,
    predict_further_pulls,
)


def means(values: np.ndarray, weights: np.ndarray | None = None) -> Population:
    """Pulls that each tell one number, weighted by their standard deviations' inverses."""
    design = np.ones(len(values)) if weights is None else weights
    mean = float((design**2 * values).sum() / (design**2).sum())
    return Population(
        estimate=np.array([mean]),
        design=design[:, None, None],
        residual=(design * (values - mean))[:, None],
    )


def of(values: np.ndarray, groups: dict[str, list[int]], weights=None) -> Further:
    found = predict_further_pulls(means(values, weights), {"a": np.ones(1)}, groups, {"a": 1.0})[
        "a"
    ]
    assert found is not None
    return found


@pytest.mark.parametrize("count", [2, 3, 7])
def test_the_interval_at_hand_is_students(count: int) -> None:
    values = np.random.default_rng(count).normal(1.0, 0.03, count)
    error = values.std(ddof=1) / count**0.5
    found = of(values, {"90 kPa": list(range(count))})
    assert found.half_width() == pytest.approx(stats.t.ppf(0.975, count - 1) * error, rel=1e-10)
    for more in (1, 5):
        total = count + more
        wide = stats.t.ppf(0.975, total - 1) * values.std(ddof=1) / total**0.5
        assert found.half_width("90 kPa", more) == pytest.approx(wide, rel=1e-10)


@pytest.mark.parametrize("more", [0, 6])
def test_an_error_common_to_all_pulls_adds_as_in_the_gum(more: int) -> None:
    """Welch and Satterthwaite: whole^4/degrees = error^4/(pulls - 1), as the common one is known.

    However many further pulls there are, the interval of the common error remains.
    """
    values, common = np.random.default_rng(4).normal(1.0, 0.03, 6), 0.02
    further = predict_further_pulls(
        means(values), {"a": np.ones(1)}, {"c": list(range(6))}, {"a": 1.0}, {"a": common}
    )["a"]
    assert further is not None
    error = values.std(ddof=1) / (6 + more) ** 0.5
    whole = np.hypot(error, common)
    degrees = whole**4 / (error**4 / (5 + more))
    expected = stats.t.ppf(0.975, degrees) * whole
    assert further.half_width("c", more) == pytest.approx(expected, rel=1e-10)
    least = stats.norm.ppf(0.975) * common
    assert further.half_width("c", 10**8) == pytest.approx(least, rel=1e-5)


def test_a_negative_value_gains_as_much_as_its_mirror_image() -> None:
    """A speed slope or a pressure exponent of -0.1; a ratio of deviations has no sign."""
    values = np.array([0.09, 0.1, 0.12])
    one, mirrored = (
        predict_further_pulls(means(v), {"a": np.ones(1)}, {"c": [0, 1, 2]}, {"a": v.mean()})["a"]
        for v in (values, -values)
    )
    assert one is not None and mirrored is not None
    assert mirrored.scatter == pytest.approx(one.scatter) and one.scatter > 0
    assert mirrored.after_one() == pytest.approx(one.after_one())


def test_a_pull_where_pulls_tell_more_gains_more() -> None:
    random = np.random.default_rng(3)
    sd = np.array([0.01] * 3 + [0.04] * 3)
    found = of(1 + sd * random.standard_normal(6), {"95": [0, 1, 2], "20": [3, 4, 5]}, 1 / sd)
    after = found.after_one()
    assert list(after) == ["95", "20"]
    information = np.array([3 / 0.01**2 + 3 / 0.04**2])
    better, worse = (information / (information + 1 / s**2) for s in (0.01, 0.04))
    ratio = (better / worse) ** 0.5
    assert after["95"] / after["20"] == pytest.approx(float(ratio[0]), rel=1e-10)


def test_the_chance_is_what_it_says() -> None:
    """Over campaigns of four pulls and six more, drawn without our code."""
    random, count, more, runs = np.random.default_rng(8), 4, 6, 40_000
    values = random.standard_normal((runs, count + more))
    spread = values[:, :count].std(axis=1, ddof=1)
    reached = stats.t.ppf(0.975, count + more - 1) * values.std(axis=1, ddof=1)
    reached /= (count + more) ** 0.5
    one = of(np.array([-1.5, -0.5, 0.5, 1.5]) / np.sqrt(5 / 3), {"c": [0, 1, 2, 3]})
    promised = float(one.half_width("c", more, SURE)) * spread  # its own spread is one
    share = (reached <= promised).mean()
    assert abs(share - SURE) < 4 * (SURE * (1 - SURE) / runs) ** 0.5


@pytest.mark.slow
def test_as_many_as_are_sure_are_enough_in_four_of_five_campaigns() -> None:
    random, within, enough, asked = np.random.default_rng(9), 0.012, 0, 0
    for _ in range(400):
        values = random.normal(1.0, 0.02, 5)
        sure = of(values, {"c": list(range(5))}).required_pulls(within).sure
        if not sure:
            continue
        asked += 1
        every = np.append(values, random.normal(1.0, 0.02, sure))
        wide = stats.t.ppf(0.975, len(every) - 1) * every.std(ddof=1) / len(every) ** 0.5
        enough += wide <= within
    assert asked > 300 and enough / asked >= SURE


def test_needed_is_the_least_that_does_and_none_where_nothing_does() -> None:
    values = np.array([0.9, 1.0, 1.1])
    found = of(values, {"c": [0, 1, 2]})
    needed = found.required_pulls(0.05)
    assert needed.likely is not None and needed.sure is not None
    assert found.half_width("c", needed.likely) <= 0.05 < found.half_width("c", needed.likely - 1)
    assert needed.sure > needed.likely
    assert found.required_pulls(1.0).likely == 0
    assert found.required_pulls(1e-6).likely is None
    assert predict_further_pulls(means(values[:1]), {"a": np.ones(1)}, {"c": [0]}, {"a": 1.0}) == {
        "a": None
    }
