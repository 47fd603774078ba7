"""One pull of twelve with a wrong unit does not move a calibration: it is left out by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from layerjam.identify.odd import gross_outliers
from layerjam.measure.trace import Trace
from pull_faults import FAULTS, drawn

WRONG = {
    "kN": (1e-3, 1.0),
    "lbf": (1 / 4.4482216, 1.0),
    "newtons in a column of lbf": (4.4482216, 1.0),
    "gram-force": (1000 / 9.80665, 1.0),
    "inches": (1.0, 1 / 25.4),
    "millimetres in a column of inches": (1.0, 25.4),
}
NAMED = {"newtons in a column of lbf": "in N, read as lbf", "gram-force": "in gram-force"}


def scaled(pulls: list[Trace], index: int, force: float, elongation: float) -> list[Trace]:
    one = pulls[index]
    wrong = replace(one, force=one.force * force, elongation=one.elongation * elongation)
    return [*pulls[:index], wrong, *pulls[index + 1 :]]


@pytest.fixture(scope="module")
def campaign() -> tuple[Any, list[Trace], Any]:
    made = drawn(FAULTS[0], (29, 1))
    brake, pulls = made.subjects[0].known, made.traces()
    return brake, pulls, lj.calibrate(brake, pulls)


@pytest.mark.parametrize("unit", WRONG)
def test_a_wrong_unit_in_one_pull_of_twelve_moves_nothing(
    unit: str, campaign: tuple[Any, list[Trace], Any]
) -> None:
    brake, pulls, clean = campaign
    found = lj.calibrate(brake, scaled(pulls, 5, *WRONG[unit]))
    path = pulls[5].path
    out = {row["file"]: row["because"] for row in found.excluded} | dict(found.refused)
    assert list(out) == [path] and found.verdict == "passed"
    for name in ("scale_factor", "stiffness"):
        interval = clean.intervals[name]
        width = interval["high"] - interval["low"]
        assert abs(getattr(found, name) - getattr(clean, name)) <= width
    assert NAMED.get(unit, "") in out[path]
    assert Path(path).name in str(found)


def test_a_pull_of_another_brake_is_left_out(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, clean = campaign
    other = "choi2018-ptfe" if brake.film.kinetic > 0.1 else "choi2018-kapton"
    vacuum = pulls[5].facts.vacuum
    foreign = lj.tensile(other, vacuum=vacuum, speed="13 mm/s", travel="40 mm").to_frame()
    trace = replace(
        pulls[5],
        force=foreign["force"].to_numpy(),
        elongation=foreign["elongation"].to_numpy(),
        time=foreign["time"].to_numpy(),
    )
    found = lj.calibrate(brake, [*pulls[:5], trace, *pulls[6:]])
    assert [row["file"] for row in found.excluded] == [trace.path]
    assert found.scale_factor == pytest.approx(clean.scale_factor, rel=0.02)


def test_faultless_pulls_stay(campaign: tuple[Any, list[Trace], Any]) -> None:
    assert campaign[2].excluded == [] and campaign[2].verdict == "passed"


def test_half_of_the_pulls_with_another_unit_fail(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, _ = campaign
    half = [replace(p, force=p.force * 4.4482216) for p in pulls[:6]]
    found = lj.calibrate(brake, [*half, *pulls[6:]])
    assert found.exit_code == 4 and found.excluded == []
    assert "scale factor interval" in {check["name"] for check in found.failed_checks}
    kept = lj.calibrate(
        brake, [*half, *pulls[6:]], accept={c["name"]: "a trial" for c in found.failed_checks}
    )
    assert kept.verdict == "accepted" and kept.exit_code == 0


def test_one_pull_alone_with_a_wrong_unit_fails(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, _ = campaign
    found = lj.calibrate(brake, [replace(pulls[0], force=pulls[0].force * 1000 / 9.80665)])
    assert {c["name"] for c in found.failed_checks} >= {"plausible"}


def test_scatter_of_a_film_makes_no_gross_outlier() -> None:
    """With a tenth of scatter (SD) a sample of twelve normal values keeps them all."""
    random = np.random.default_rng(11)
    values = np.exp(0.1 * random.standard_normal((2000, 12)))
    alarms = sum(bool(gross_outliers(row.tolist())) for row in values)
    assert alarms <= 20
    assert gross_outliers([1.0, 1.01]) == {}
    assert set(gross_outliers([1.0, 1.01, None, 0.99, 3.0])) == {4}
