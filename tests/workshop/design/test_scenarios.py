"""Scenario files, verdicts, refusals, the command and its page."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from layerjam.cli.main import main
from layerjam.core.errors import FileError, QuantityError
from layerjam.studies.machines.apply import scenario
from layerjam.studies.machines.registry import MACHINES, load_scenario, scenarios
from layerjam.studies.machines.scenario import Curve, read_scenario
from layerjam.studies.machines.verdict import Limit, find_deciding_limit
from machine_scenarios import text_of

NOTHING = np.zeros(4001)
VACUUM = 94.5e3


# verdicts, files, refusals


def test_the_verdict_names_the_limit_missed_most() -> None:
    low = Limit(name="a", value=2.0, limit=1.0, unit="m")
    high = Limit(name="b", value=1.0, limit=5.0, unit="m", least=True)
    fine = Limit(name="c", value=0.5, limit=1.0, unit="m")
    never = Limit(name="d", value=math.inf, limit=1.0, unit="s")
    assert (low.is_met, high.is_met, fine.is_met, never.is_met) == (False, False, True, False)
    assert (low.factor, high.factor, fine.factor, never.factor) == (2.0, 5.0, 0.5, math.inf)
    assert find_deciding_limit([low, high, fine]) is high and find_deciding_limit([fine]) is fine
    assert "never reached" in never.sentence() and "factor of 5" in high.sentence()
    assert not Limit(name="n", value=math.nan, limit=1.0, unit="1").is_met
    assert Limit(name="at", value=1.0, limit=1.0, unit="1").is_met


def test_every_number_of_a_scenario_says_where_it_is_from() -> None:
    assert scenarios() == ["ankle-clutch", "neck-guard", "rehabilitation", "seat-belt", "slow-stop"]
    for name in scenarios():
        scenario = load_scenario(name)
        for path, value, source in scenario.list_sources():
            assert value and "unstated" not in source and len(source) > 8, path
        assumed = [p for p, s in scenario.sources.items() if s.kind == "assumed"]
        said = " ".join(scenario.warnings())
        assert all(p in said for p in assumed if p != "safe_state")


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        ("seat-belt", "78 kg", "78 m", "not in units of mass"),
        ("seat-belt", '"56 km/h"', "56", "has no unit"),
        ("neck-guard", "half-sine", "half-cosine", "half-sine"),
        ("seat-belt", 'machine = { value = "seat-belt"', 'machine = { value = "sofa"', "seat-belt"),
        ("seat-belt", "choi2018-kapton", "choi2018-captain", "choi2018-kapton"),
        ("rehabilitation", "30 55 80 105 130 deg", "30 55 80 105 deg", "must have the same length"),
        ("rehabilitation", "30 55 80 105 130 deg", "30 55 80 105 120 deg", "must cover"),
        ("rehabilitation", '"30 mm"', '"60 mm"', "smaller pulley"),
        ("ankle-clutch", "0 4 8 12", "1 4 8 12", "from 0 to 100"),
        ("ankle-clutch", "1.9 1.8 1.8 1.7 deg", "1.9 1.8 1.8 1.7 N", "rad"),
    ],
)
def test_a_scenario_that_is_none_is_refused_with_its_line(
    name: str, old: str, new: str, said: str
) -> None:
    text = text_of(name)
    assert old in text
    with pytest.raises(FileError, match=re.escape(said)) as caught:
        read_scenario(text.replace(old, new, 1), name, MACHINES)
    assert caught.value.line is not None or "choi" in said


def test_a_scenario_without_machine_names_the_machines() -> None:
    with pytest.raises(FileError, match=r"machine \(kind of machine: .*seat-belt.*\) is missing"):
        read_scenario('name = "x"\n', "mine.toml", MACHINES)


def test_a_regulator_without_safe_state_is_refused() -> None:
    text = "\n".join(
        line for line in text_of("rehabilitation").splitlines() if "safe_state" not in line
    )
    with pytest.raises(FileError, match="safe_state"):
        read_scenario(text, "mine", MACHINES)
    # and a machine without regulator knows no such key
    with pytest.raises(FileError, match="occupant.mass"):
        read_scenario(text_of("seat-belt").replace("mass = { value", "mast = { value", 1).replace(
            "mast = { value", "# mass = { value", 1), "mine", MACHINES)  # fmt: skip


def test_a_curve_is_numbers_and_a_unit() -> None:
    curve = Curve(unit="rad", text="angle", lo=-7, hi=7)
    np.testing.assert_allclose(curve.read("0 90 -180 deg", "x"), [0, math.pi / 2, -math.pi])
    for bad in ("deg", "1 2 3", "1 deg", "1,2 deg", 5, "1 2 kg", "1 900 deg"):
        with pytest.raises(QuantityError, match="x"):
            curve.read(bad, "x")


def test_the_command_answers_cannot_with_its_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenario", "ankle-clutch", "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    for key in (
        "machine", "feasible", "reason", "conclusion", "brakes_needed", "mass", "limits", "units",
        "warnings", "page", "results",
    ):  # fmt: skip
        assert key in answer
    assert answer["machine"] == "ankle-clutch" and answer["feasible"] is False
    assert set(answer["limits"][0]) >= {"name", "value", "limit", "unit", "met"}
    assert main(["scenario", "--list"]) == 0
    assert capsys.readouterr().out.split() == scenarios()
    assert main(["scenario", "ancle-clutch"]) == 2
    assert "did you mean ankle-clutch" in capsys.readouterr().err
    assert main(["scenario"]) == 2


def test_the_page_stands_whole_with_its_pictures(tmp_path: Path) -> None:
    answer = scenario("ankle-clutch", out=tmp_path / "page")
    page = (tmp_path / "page" / "report.html").read_text(encoding="utf-8")
    assert answer.page == str(tmp_path / "page" / "report.html")
    assert (
        page.count("<svg") == 2
        and "<script" not in page
        and "http"
        not in re.sub(
            r'xmlns[^"]*"[^"]*"', "", page.split("<footer")[0].split("Source of every number")[0]
        )
    )
    assert "Not feasible" in page and "gait.angle" in page
    kept = json.loads((tmp_path / "page" / "results.json").read_text(encoding="utf-8"))
    assert kept["brakes_needed"] == answer.brakes_needed
    assert len(list((tmp_path / "page" / "figures").iterdir())) == 2
    with pytest.raises(FileError, match="--overwrite"):
        scenario("ankle-clutch", out=tmp_path / "page")
