"""Pulls of two populations fail, whichever is larger; at most two outliers are left out by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from independent.pulls import BRAKE, SCALE_FACTOR, Pull, repeats, write
from laboratory.figures.brake_files import draw_nothing
from layerjam.laboratory.figures import brake_files as writer
from layerjam.laboratory.identify.odd import find_two_groups, outlier_limit


def healthy(count: int = 12, scatter: float = 0.02, seed: int = 3) -> list[Pull]:
    return list(repeats(np.random.default_rng(seed), count=4, scatter=scatter))[:count]


def slowly(*cases: tuple[int, int]) -> list[Any]:
    return [pytest.param(*case, marks=pytest.mark.slow) for case in cases]


def scaled(pulls: Sequence[Pull], which: Sequence[int], multiplier: float) -> list[Pull]:
    return [replace(p, multiplier=multiplier) if i in which else p for i, p in enumerate(pulls)]


MIXED = ((0, 3, 5, 7, 11), (0, 1, 2, 3, 4), (1, 2, 4, 6, 8, 9, 10))


MULTIPLIERS = (0.7, 0.8, 1.25, 1.6, 1 / 4.4482216)
QUICK = {(0, 1.25), (1, 1 / 4.4482216), (2, 0.8)}
"""Groups and multipliers of the quick tests: the two nearest to 1, and another unit."""


@pytest.mark.parametrize(
    ("which", "multiplier"),
    [
        pytest.param(which, by, marks=[] if (place, by) in QUICK else pytest.mark.slow)
        for place, which in enumerate(MIXED)
        for by in MULTIPLIERS
    ],
)
def test_two_groups_fail_and_nothing_is_left_out(
    tmp_path: Path, which: tuple[int, ...], multiplier: float
) -> None:
    """Five or seven of twelve pulls with another lever arm or unit: exit 4, both groups named."""
    files = write(tmp_path, scaled(healthy(), which, multiplier))
    found = lj.calibrate(BRAKE, files)
    assert found.exit_code == 4 and found.excluded == []
    [reason] = [row["reason"] for row in found.failed_checks if row["name"] == "pulls"]
    assert "two groups" in reason and all(path.name in reason for path in files)
    tested = lj.validate(BRAKE, files)
    assert tested.exit_code == 4 and "pulls" in {row["name"] for row in tested.failed_checks}


@pytest.mark.parametrize(
    ("count", "wrong"), [(3, 1), (7, 2), (8, 3), *slowly((3, 2), (5, 3), (12, 3))]
)
def test_more_outliers_than_the_limit_are_kept_and_fail(
    tmp_path: Path, count: int, wrong: int
) -> None:
    files = write(tmp_path, scaled(healthy(count), range(wrong), 0.55))
    found = lj.calibrate(BRAKE, files)
    assert found.exit_code == 4 and found.excluded == []
    assert "pulls" in {row["name"] for row in found.failed_checks}


@pytest.mark.parametrize(("count", "wrong"), [(4, 1), (8, 2), *slowly((7, 1), (12, 2))])
def test_outliers_within_the_limit_are_named_beside_the_number(
    tmp_path: Path, count: int, wrong: int
) -> None:
    files = write(tmp_path / "pulls", scaled(healthy(count), range(wrong), 0.55))
    names = [path.name for path in files[:wrong]]
    found = lj.calibrate(BRAKE, files)
    assert found.exit_code == 0
    assert [Path(row["file"]).name for row in found.excluded] == names
    assert all(row["automatic"] for row in found.excluded)
    assert found.scale_factor == pytest.approx(SCALE_FACTOR, rel=0.04)
    line = next(text for name, text in found.rows() if name == "scale factor")
    assert all(name in line for name in names) and "automatically" in line
    assert all(name in found.standard_errors["rests_on"] for name in names)
    assert "by hand" not in str(found)


def test_the_report_names_pulls_left_out_beside_the_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "draw_all", draw_nothing)
    monkeypatch.setattr(writer, "typeset_pdf", lambda data, pictures: b"%PDF")
    files = write(tmp_path / "pulls", scaled(healthy(12), [4], 0.55))
    reasons = {"pulls": "pull 5 has another lever arm"}
    found = lj.report(BRAKE, pulls=files, accept=reasons, out=tmp_path / "report")
    page = Path(found.report).read_text("utf-8")
    assert "left out automatically: pull-05.csv" in page
    assert "pull-05.csv (calibration, automatically)" in page and "Excluded by hand" not in page
    assert found.excluded[0]["automatic"]


def test_an_acceptance_is_replaced_only_by_as_many_pulls(tmp_path: Path) -> None:
    files = write(tmp_path / "mixed", scaled(healthy(8), MIXED[1], 1.6))
    failures = {row["name"]: "a trial" for row in lj.calibrate(BRAKE, files).failed_checks}
    out, again = tmp_path / "brake.toml", tmp_path / "again.toml"
    lj.calibrate(BRAKE, files, out=out, accept=failures)
    right = write(tmp_path / "right", healthy(8))
    for count in (1, 7):
        found = lj.calibrate(out, right[:count], out=again, overwrite=True)
        assert found.exit_code == 0 and lj.show(again).verdict == "accepted"
        kept = [[entry.to_toml() for entry in lj.load(path).accepted] for path in (out, again)]
        assert kept[0] == kept[1]
    replaced = lj.calibrate(out, right, out=again, overwrite=True)
    assert replaced.exit_code == 0 and not lj.load(again).accepted


def test_a_file_left_out_by_the_user_is_not_called_automatic(tmp_path: Path) -> None:
    files = write(tmp_path, healthy(4))
    found = lj.calibrate(BRAKE, files, exclude={files[0].name: "the grip slipped"})
    assert [row["automatic"] for row in found.excluded] == [False]
    assert "automatically" not in str(found)


@pytest.mark.parametrize("quantity", ["vacuum", "mounting"])
def test_groups_that_a_stated_condition_explains_are_no_second_population(
    tmp_path: Path, quantity: str
) -> None:
    """Two mountings that differ by 12 % widen the interval; the pulls are of one population."""
    pulls = healthy(8, scatter=0.003)
    changed = []
    for place, pull in enumerate(pulls):
        high = pull.vacuum > 40e3 if quantity == "vacuum" else place % 2 == 1
        facts = {"mounting": str(place % 2 + 1)} if quantity == "mounting" else {}
        changed.append(
            replace(pull, scale_factor=pull.scale_factor * (1.12 if high else 1.0), facts=facts)
        )
    found = lj.calibrate(BRAKE, write(tmp_path, changed))
    [row] = [check for check in found.checks if check["name"] == "pulls"]
    assert row["level"] == "passed"


def test_the_limit_of_outliers_is_that_of_a_minority() -> None:
    assert [outlier_limit(n) for n in range(1, 10)] == [0, 0, 0, 1, 1, 1, 1, 2, 2]


@pytest.mark.parametrize("count", [4, 6, 12, 20])
def test_two_groups_are_found_as_often_in_normal_samples_as_stated(count: int) -> None:
    random = np.random.default_rng(count)
    values = random.standard_normal((4000, count))
    found = sum(find_two_groups(row, 0.02, 0.0) is not None for row in values)
    assert 0.012 <= found / 4000 <= 0.028
    apart = values[0] * 0.01 + np.repeat([0.0, 1.0], [count // 2, count - count // 2])
    group = find_two_groups(apart, 0.005, 0.5)
    assert group in (tuple(range(count // 2)), tuple(range(count // 2, count)))
    assert find_two_groups(apart, 0.005, 2.0) is None and find_two_groups(apart[:3], 0.5, 0) is None
