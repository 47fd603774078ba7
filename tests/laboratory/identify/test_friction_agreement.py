"""Friction tests are compared with each other: the issue's faults, the film's range, the study."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

import layerjam as lj
from counts import cases
from friction_faults import ALARMS, FAULTS, MARKS, MUST, NONE, NONE_OF_RIG, PAGE, measure
from laboratory.campaigns import bench as virtual
from layerjam.brake.device.load import load
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.laboratory.identify.friction.agreement import film_friction_range
from layerjam.laboratory.measure.trace import Trace

NORMAL = 2.45
KAPTON = (0.32, 0.24)


def campaign_of(static: float, kinetic: float, count: int = 5) -> list[Trace]:
    """Friction tests that scatter by 3 % (SD)."""
    machine = virtual.Machine(sampling_rate=100.0, load_cell_noise=0.002, load_cell_range=10.0)
    made = [
        virtual.friction(
            static, kinetic, NORMAL, machine=machine, repeat=repeat, kinetic_sd=0.03 * kinetic,
            static_sd=0.03 * static, string_stiffness=300.0, travel=0.11,
        )
        for repeat in range(1, count + 1)
    ]  # fmt: skip
    return [replace(trace, path=f"test-{place}.csv") for place, trace in enumerate(made)]


def with_factor(traces: list[Trace], factor: float) -> list[Trace]:
    """The tests with the forces of the third one multiplied."""
    return [replace(t, force=t.force * factor) if i == 2 else t for i, t in enumerate(traces)]


@pytest.mark.parametrize("count", [3, 5])
def test_repeats_without_a_fault_pass(count: int) -> None:
    answer = lj.friction(campaign_of(*KAPTON, count), normal_force=NORMAL)
    assert answer.verdict == "passed" and answer.exit_code == 0
    assert {c["name"] for c in answer.checks} >= {"repeats", "film", "static over kinetic"}


@pytest.mark.parametrize("count", [3, 4, 5])
@pytest.mark.parametrize("factor", [1e-3, 0.5, 0.3, 2.0, 4.448, 1e3])
def test_one_file_of_another_unit_fails(count: int, factor: float) -> None:
    traces = with_factor(campaign_of(*KAPTON, count), factor)
    answer = lj.friction(traces, normal_force=NORMAL)
    assert answer.verdict == "failed" and answer.exit_code == 4
    (repeats,) = [c for c in answer.failed_checks if c["name"] == "repeats"]
    assert Path(traces[2].path).name in repeats["reason"]
    assert not any(Path(t.path).name in repeats["reason"] for i, t in enumerate(traces) if i != 2)


def test_two_repeats_that_differ_name_both() -> None:
    first, second = campaign_of(*KAPTON, 2)
    answer = lj.friction([first, replace(second, force=second.force / 2)], normal_force=NORMAL)
    (reason,) = [c["reason"] for c in answer.failed_checks if c["name"] == "repeats"]
    assert Path(first.path).name in reason and Path(second.path).name in reason


@pytest.mark.parametrize("factor", [1e-3, 1 / 4.448, 5.0])
def test_a_fault_of_all_files_shows_against_the_film(factor: float) -> None:
    traces = [replace(t, force=t.force * factor) for t in campaign_of(*KAPTON)]
    stated = [replace(t, facts=replace(t.facts, brake="choi2018-kapton")) for t in traces]
    answer = lj.friction(stated, normal_force=NORMAL)
    assert "film" in {c["name"] for c in answer.failed_checks}


def test_the_range_of_a_film_is_that_of_its_printed_values() -> None:
    """Kapton HN: 0.24 (Choi 2018, table I) and 0.48 (DuPont); half and twice."""
    assert film_friction_range(load("choi2018-kapton")) == pytest.approx((0.12, 0.96))
    assert film_friction_range(load("choi2018-ptfe")) == pytest.approx((0.025, 0.15))


def test_static_far_above_kinetic_fails() -> None:
    answer = lj.friction(campaign_of(1.4, 0.24), normal_force=NORMAL)
    assert "static over kinetic" in {c["name"] for c in answer.failed_checks}


def test_a_failed_check_writes_no_brake_until_it_is_accepted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = [
        str(virtual.write_own(trace, tmp_path / f"test-{place}.csv"))
        for place, trace in enumerate(with_factor(campaign_of(*KAPTON), 0.5))
    ]
    out = tmp_path / "brake.toml"
    words = ["friction", *paths, "--normal-force", "2.45N", "--brake", "choi2018-kapton"]
    words += ["--out", str(out)]
    assert main([*words, "--json"]) == 4
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "failed" and not out.exists()
    failed = [row["name"] for row in answer["failed_checks"]]
    accept = [word for name in failed for word in ("--accept", f"{name}=new lot of film")]
    assert main([*words, *accept]) == 0
    stored = lj.load(out).accepted
    assert {one.check for one in stored} == set(failed)
    assert set(stored[0].numbers) == {"film.static", "film.kinetic"}
    with pytest.raises(QuantityError, match="has not failed"):
        lj.friction(campaign_of(*KAPTON), normal_force=NORMAL, accept={"repeats": "why"})


def rows() -> dict[str, list[str]]:
    """{fault: cells} of the page's table."""
    part = PAGE.read_text(encoding="utf-8").split(MARKS[0])[1].split(MARKS[1])[0]
    found = re.findall(r"^\| (?:\*\*)?([^|*]+?)(?:\*\*)? \| ([\d,]+ \|.*) \|$", part, re.MULTILINE)
    return {name: cells.split(" | ") for name, cells in found}


def test_the_page_has_every_fault_and_the_gross_ones_are_found() -> None:
    found = rows()
    assert set(found) == {fault.name for fault in FAULTS}
    assert sum(fault.gross for fault in FAULTS) >= 8
    for fault in FAULTS:
        campaigns, failed, _ = found[fault.name]
        part = float(failed.rstrip("%")) / 100
        assert int(campaigns.replace(",", "")) >= (300 if fault.healthy else 100)
        assert part >= MUST or not fault.gross, fault.name
        assert part <= ALARMS or not fault.healthy


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        NONE,
        NONE_OF_RIG,
        "forces of one test halved",
        "another film in all tests",
        "a zero error of 15 %",
    ],
)
def test_the_study_in_small(name: str) -> None:
    fault = next(f for f in FAULTS if f.name == name)
    tally = measure(fault, cases(100, 40), 77)
    share = tally.found / tally.campaigns
    assert share <= 0.08 if fault.healthy else share >= 0.92
