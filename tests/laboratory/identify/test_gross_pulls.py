"""One pull of twelve with a wrong unit does not move a calibration: it is left out by name."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from counts import FULL, cases
from layerjam.cli.main import main
from layerjam.laboratory.identify.odd import find_gross_outliers
from layerjam.laboratory.measure.trace import Trace
from pull_faults import FAULTS, drawn

WRONG = {
    "kN": (1e-3, 1.0),
    "lbf": (1 / 4.4482216, 1.0),
    "newtons in a column of lbf": (4.4482216, 1.0),
    "gram-force": (1000 / 9.80665, 1.0),
    "inches": (1.0, 1 / 25.4),
    "millimetres in a column of inches": (1.0, 25.4),
}
NAMED = {"newtons in a column of lbf": "in N but read as lbf", "gram-force": "in gram-force"}


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


def foreign(brake: Any, pull: Trace) -> Trace:
    """A pull of another brake at the same vacuum, under the name of this one."""
    other = "choi2018-ptfe" if brake.film.kinetic > 0.1 else "choi2018-kapton"
    made = lj.tensile(other, vacuum=pull.facts.vacuum, speed="13 mm/s", travel="40 mm").to_frame()
    columns = {name: made[name].to_numpy() for name in ("force", "elongation", "time")}
    return replace(pull, **columns)


def test_a_pull_of_another_brake_is_left_out(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, clean = campaign
    trace = foreign(brake, pulls[5])
    found = lj.calibrate(brake, [*pulls[:5], trace, *pulls[6:]])
    assert [row["file"] for row in found.excluded] == [trace.path]
    assert found.scale_factor == pytest.approx(clean.scale_factor, rel=0.02)


METHODS: dict[str, dict[str, Any]] = {
    "curves": {"depth": "curves"},
    "bayesian": {"depth": "bayesian", "draws": cases(300, 150), "chains": 2, "seed": 3},
}
ATTACKED = [
    (method, unit)
    for method in METHODS
    for unit in (*WRONG, "another brake")
    if FULL or method != "bayesian"
]


@pytest.mark.slow
@pytest.mark.parametrize(("method", "unit"), ATTACKED)
def test_no_method_moves_by_one_wrong_pull_of_twelve(
    method: str, unit: str, campaign: tuple[Any, list[Trace], Any]
) -> None:
    """Excluded by name, or exit 4; else the clean interval's width bounds the change."""
    brake, pulls, _ = campaign
    wrong = [*pulls[:5], foreign(brake, pulls[5]), *pulls[6:]]
    if unit in WRONG:
        wrong = scaled(pulls, 5, *WRONG[unit])
    found = lj.calibrate(brake, wrong, **METHODS[method])
    if found.exit_code == 4:
        return
    assert {row["file"] for row in found.excluded} | set(found.refused) == {pulls[5].path}
    clean = lj.calibrate(brake, pulls, **METHODS[method])
    interval = clean.intervals["scale_factor"]
    moved = abs(found.scale_factor - clean.scale_factor)
    assert moved <= interval["high"] - interval["low"]


def test_faultless_pulls_stay(campaign: tuple[Any, list[Trace], Any]) -> None:
    assert campaign[2].excluded == [] and campaign[2].verdict == "passed"


def test_half_of_the_pulls_with_another_unit_fail(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, _ = campaign
    half = [replace(p, force=p.force * 4.4482216) for p in pulls[:6]]
    found = lj.calibrate(brake, [*half, *pulls[6:]])
    assert found.exit_code == 4 and found.excluded == []
    assert {"repeats", "stiffness repeats"} <= {check["name"] for check in found.failed_checks}
    kept = lj.calibrate(
        brake, [*half, *pulls[6:]], accept={c["name"]: "a trial" for c in found.failed_checks}
    )
    assert kept.verdict == "accepted" and kept.exit_code == 0


def test_later_commands_report_what_was_accepted_of_a_mixed_campaign(
    campaign: tuple[Any, list[Trace], Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    brake, pulls, _ = campaign
    mixed = [replace(p, force=p.force * 4.4482216) for p in pulls[:6]] + list(pulls[6:])
    out = tmp_path / "brake.toml"
    first = lj.calibrate(brake, mixed, out=out)
    assert first.exit_code == 4 and first.file is None and not out.exists()
    reasons = {check["name"]: "only to look at it" for check in first.failed_checks}
    assert lj.calibrate(brake, mixed, out=out, accept=reasons).file == str(out)
    for words in (
        ["vacuum", out, "--slip", "20mm", "--force", "60N"],
        ["show", out],
        ["export", "c", out, "--out", tmp_path / "c"],
    ):
        code = main([*map(str, words), "--json"])
        answer = json.loads(capsys.readouterr().out)
        assert answer["accepted"], words
        assert {row["check"] for row in answer["accepted"]} >= set(reasons), (code, words)
        assert "only to look at it" in " ".join(answer["warnings"])
    assert "only to look at it" in (tmp_path / "c" / "brake.h").read_text()


def test_one_pull_alone_with_a_wrong_unit_fails(campaign: tuple[Any, list[Trace], Any]) -> None:
    brake, pulls, _ = campaign
    found = lj.calibrate(brake, [replace(pulls[0], force=pulls[0].force * 1000 / 9.80665)])
    assert {c["name"] for c in found.failed_checks} >= {"plausible"}


def test_scatter_of_a_film_makes_no_gross_outlier() -> None:
    """With a tenth of scatter (SD) a sample of twelve normal values keeps them all."""
    random = np.random.default_rng(11)
    values = np.exp(0.1 * random.standard_normal((2000, 12)))
    alarms = sum(bool(find_gross_outliers(row.tolist())) for row in values)
    assert alarms <= 20
    assert find_gross_outliers([1.0, 1.01]) == {}
    assert set(find_gross_outliers([1.0, 1.01, None, 0.99, 3.0])) == {4}
