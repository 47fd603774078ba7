"""Campaigns of an independent generator: the shares that docs/coverage.md states, on a few each."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
from calibration_attacks import CASES, PAGE, measure, worn
from counts import cases
from independent.pulls import BRAKE, SCALE_FACTOR, VACUUMS, repeats, write


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "-"))
def test_every_case_has_the_share_that_is_required(case) -> None:
    assert measure(case, cases(40, 8), seed=7).is_right(case)


def test_the_page_has_every_case_with_the_share_that_is_required() -> None:
    text = PAGE.read_text("utf-8")
    for case in CASES:
        [row] = re.findall(rf"^\| {re.escape(case.name)} \| (.*) \|$", text, re.MULTILINE)
        count, covered, _, failed, _ = row.split(" | ")
        slack = 3 / int(count) ** 0.5
        share = float(failed.rstrip("%")) / 100
        if case.found is not None:
            assert share >= case.found - slack * (case.found * (1 - case.found)) ** 0.5, row
        else:
            assert share <= 0.025 + slack * (0.025 * 0.975) ** 0.5, row
            assert float(covered.rstrip("%")) / 100 >= 0.9 - slack * 0.3, row


def with_facts(pulls, **facts: str):
    return [replace(p, facts={**p.facts, **facts}) for p in pulls]


def own_mountings(pulls):
    return [replace(p, facts={"mounting": str(n)} | dict(p.facts)) for n, p in enumerate(pulls, 1)]


def test_stated_limits_enter_the_interval_and_others_are_listed(tmp_path: Path) -> None:
    """A rectangular error of the gauge, 4 kPa at 80 kPa, is a relative SD of 2.9 % (GUM 4.3.7)."""
    pulls = own_mountings(repeats(np.random.default_rng(1), (80e3,), 6, 0.005))
    plain = lj.calibrate(BRAKE, write(tmp_path / "a", pulls))
    assert plain.not_included == ["load cell", "vacuum gauge"]
    assert "not included: load cell, vacuum gauge (common to all pulls)" in str(plain)
    stated = with_facts(pulls, gauge_limit='"4 kPa"', load_cell_limit='"1 %"')
    found = lj.calibrate(BRAKE, write(tmp_path / "b", stated))
    assert found.not_included == [] and "not included" not in str(found)
    before, after = (f.intervals["scale_factor"]["standard_error"] for f in (plain, found))
    sleeve = 1.0  # the peak of this brake is nearly all friction of the sheets
    shared = SCALE_FACTOR * np.hypot(4 / 80, 0.01) / 3**0.5 * sleeve
    assert after == pytest.approx(np.hypot(before, shared), rel=0.03)
    stiff = found.stiffness * 0.01 / 3**0.5
    before, after = (f.intervals["stiffness"]["standard_error"] for f in (plain, found))
    assert after == pytest.approx(np.hypot(before, stiff), rel=0.02)
    band = found.covariance["scale_factor"]["scale_factor"] ** 0.5
    assert band == pytest.approx(found.intervals["scale_factor"]["standard_error"], rel=1e-6)


@pytest.mark.parametrize(("tare", "level"), [(0.0, "passed"), (5.0, "warning"), (20.0, "failed")])
def test_a_force_before_the_rise_enters_the_interval_unless_it_is_subtracted(
    tmp_path: Path, tare: float, level: str
) -> None:
    pulls = own_mountings(
        replace(p, tare=tare) for p in repeats(np.random.default_rng(2), VACUUMS, 3, 0.005)
    )
    files = write(tmp_path, pulls)
    found = lj.calibrate(BRAKE, files)
    [row] = [check for check in found.checks if check["name"] == "zero"]
    assert row["level"] == level and (found.exit_code == 4) == (level == "failed")
    interval = found.intervals["scale_factor"]
    assert level == "failed" or interval["low"] < SCALE_FACTOR < interval["high"]
    tared = lj.calibrate(BRAKE, files, tare=True)
    assert tared.exit_code == 0 and tared.scale_factor == pytest.approx(SCALE_FACTOR, rel=0.01)
    narrow = tared.intervals["scale_factor"]
    assert narrow["high"] - narrow["low"] <= 1.01 * (interval["high"] - interval["low"])
    assert lj.validate(BRAKE, files, tare=True).mape < 0.02


def test_wear_fails_and_is_named(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    for folder, vacuums, count in (("one", (80e3,), 12), ("three", VACUUMS, 4)):
        files = write(tmp_path / folder, own_mountings(worn(random, vacuums, count, 0.03)))
        found = lj.calibrate(BRAKE, [files[4], *files[:4], *files[5:]])  # names show the order
        assert "wear" in {row["name"] for row in found.failed_checks}
        assert "wear" in {row["name"] for row in found.checks if not row["passed"]}


@pytest.mark.parametrize("depth", ["exact", pytest.param("curves", marks=pytest.mark.slow)])
def test_curves_that_need_an_impossible_enclosure_fail(tmp_path: Path, depth: str) -> None:
    random = np.random.default_rng(4)
    pulls = own_mountings(repeats(random, VACUUMS, 4, 0.01))
    healthy = lj.calibrate(BRAKE, write(tmp_path / "healthy", pulls), depth=depth)
    assert healthy.exit_code == 0
    for name, numbers in (("static", {"static": 0.2}), ("short", {"overlap": 63e-3})):
        files = write(tmp_path / name, [replace(p, **numbers) for p in pulls])
        found = lj.calibrate(BRAKE, files, depth=depth)
        names = {row["name"] for row in found.failed_checks}
        assert found.exit_code == 4 and names & {"enclosure", "enclosure's factor over vacuum"}
