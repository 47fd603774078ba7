"""commands.md, line by line: keys, units, warnings, exit codes, nothing else on stdout."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from layerjam.brake.device.load import load

from .conftest import Files, Run

FORCE = ("force", "choi2018-kapton", "--slip", "20mm", "--vacuum", "94.5kPa")
PULL = ("--vacuum", "94.5kPa", "--speed", "13mm/s", "--elongation", "40mm")
SHOW = {
    "mass": "kg", "drawn_mass": "kg", "stiffness_before_slip": "N/m",
    "stiffness_sliding": "N/m", "stiffness_measured": "N/m", "usable_travel": "m", "max_force": "N",
    "holding_force": "N", "energy_capacity": "J", "force_density": "N/kg", "buckling_force": "N",
}  # fmt: skip


def checked(found: dict[str, Any], keys: dict[str, str | None]) -> None:
    """Every key is there, has the unit stated, and every number is finite and has a unit."""
    for key, unit in keys.items():
        assert key in found, key
        if unit is not None:
            assert found["units"][key] == unit, key
            assert found[key] is None or math.isfinite(found[key])
    assert isinstance(found["units"], dict) and isinstance(found["warnings"], list)
    assert all(isinstance(w, str) and w for w in found["warnings"])
    assert len(found["warnings"]) == len(set(found["warnings"]))
    for key, value in found.items():
        if isinstance(value, float):
            assert key in found["units"], f"{key} has no unit"
    assert set(found["units"]) <= set(found)


@pytest.mark.parametrize(
    "brake", ["choi2018-kapton", "choi2018-ptfe", "choi2018-polyester", "choi2018-ptfe-fiberglass"]
)
def test_show(run: Run, brake: str) -> None:
    ran = run("show", brake, "--json")
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, {**SHOW, "sources": None})
    measured = brake in ("choi2018-kapton", "choi2018-ptfe")
    assert (ran.json["stiffness_measured"] is not None) is measured
    assert set(ran.json["sources"]) == set(load(brake).sources)
    other = [w for w in ran.json["warnings"] if "is not sold" not in w]
    assert bool(other) is not measured
    assert (len(other) < len(ran.json["warnings"])) is (brake == "choi2018-kapton")
    assert ran.json["force_density"] == pytest.approx(
        ran.json["max_force"] / ran.json["mass"], rel=1e-12
    )


def test_force(run: Run) -> None:
    ran = run(*FORCE, "--json")
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, {"sheet_friction": "N", "enclosure_force": "N", "force": "N"})
    assert ran.json["warnings"] == []
    forces = {"sheet_friction", "enclosure_force", "force"}
    certainty = {"intervals", "basis", "basis_reason", "extrapolated"}
    assert set(ran.json) == forces | certainty | {"units", "warnings"}
    for name in forces:
        ends = ran.json["intervals"][name]
        assert ends["low"] < ran.json[name] < ends["high"] and ends["level"] == 0.95
    assert ran.json["basis"] == "handbook" and ran.json["extrapolated"] == []


def test_force_between_usable_travel_and_overlap_warns(run: Run) -> None:
    words = ("force", "choi2018-kapton", "--vacuum", "94.5kPa", "--json", "--slip")
    for slip, warned in (("60mm", False), ("60.1mm", True), ("68mm", True)):
        ran = run(*words, slip)
        assert ran.code == 0
        assert bool(ran.json["warnings"]) is warned
        if warned:
            assert "usable travel of 60 mm" in ran.json["warnings"][0]
    assert ran.json["sheet_friction"] == 0.0


def test_vacuum(run: Run) -> None:
    words = ("vacuum", "choi2018-kapton", "--slip", "20mm", "--force", "100N", "--json")
    ran = run(*words)
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, {"vacuum": "Pa", "feasible": None})
    assert ran.json["feasible"] is True and ran.json["reason"] is None


@pytest.mark.parametrize(
    ("force", "reason"), [("0.5N", "the enclosure alone resists with"), ("200N", "at most 143.2 N")]
)
def test_an_infeasible_force_is_an_answer(run: Run, force: str, reason: str) -> None:
    ran = run("vacuum", "choi2018-kapton", "--slip", "20mm", "--force", force, "--json")
    assert (ran.code, ran.err) == (1, "")
    checked(ran.json, {"vacuum": "Pa", "feasible": None, "reason": None})
    assert ran.json["feasible"] is False and ran.json["vacuum"] is None
    assert reason in ran.json["reason"]
    shown = run("vacuum", "choi2018-kapton", "--slip", "20mm", "--force", force)
    assert shown.code == 1 and reason in " ".join(shown.out.split()) and shown.err == ""


def test_tensile(run: Run) -> None:
    ran = run("tensile", "choi2018-kapton", *PULL, "--json")
    assert (ran.code, ran.err) == (0, "")
    keys = {
        "peak_force": "N", "peak_elongation": "m", "force_at_end": "N", "work": "J",
        "dissipated_energy": "J", "outcome": None,
    }  # fmt: skip
    checked(ran.json, keys)
    assert ran.json["outcome"] == "FINISHED"
    text = "evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm"
    same = run("tensile", "choi2018-kapton", "--procedure", text, "--json")
    assert same.json == ran.json
    lumped = run("tensile", "choi2018-kapton", *PULL, "--model", "lumped", "--json")
    assert lumped.json == ran.json


@pytest.mark.parametrize(
    ("procedure", "outcome"),
    [
        ("evacuate to 94.5 kPa; pull at 1 mm/s until 70 mm", "SEPARATED"),
        ("evacuate to 3 kPa; pull at 1 mm/s until 40 mm; return at 1 mm/s to 1 mm",
         "CLOSED_BY_SLEEVE"),
        ("pull at 1 mm/s until 40 mm", "FINISHED"),
    ],
)  # fmt: skip
def test_outcomes_are_answers(run: Run, procedure: str, outcome: str) -> None:
    ran = run("tensile", "choi2018-kapton", "--procedure", procedure, "--json")
    assert (ran.code, ran.json["outcome"]) == (0, outcome)


def test_snaps_on_a_soft_rig(run: Run, tmp_path: Path) -> None:
    text = load("choi2018-kapton").text.replace('"131 kN/m"', '"2 kN/m"')
    (tmp_path / "soft.toml").write_text(text)
    ran = run("tensile", tmp_path / "soft.toml", *PULL, "--elongation", "100mm", "--json")
    assert ran.json["outcome"] == "SNAPS" and ran.code == 0
    assert "2.58 kN/m" in ran.json["warnings"][-1]


def test_friction(run: Run, files: Files) -> None:
    keys = {
        "static": "1", "kinetic": "1", "static_sd": "1", "kinetic_sd": "1", "repeats": "1",
    }  # fmt: skip
    ran = run("friction", *files.friction, "--normal-force", "2.45N", "--json")
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, keys)
    assert ran.json["repeats"] == 3 and ran.json["static_sd"] > 0 < ran.json["kinetic_sd"]
    assert ran.json["static"] == pytest.approx(0.32, abs=0.03)
    assert ran.json["kinetic"] == pytest.approx(0.24, abs=0.015)
    one = run("friction", files.friction[0], "--normal-force", "2.45N", "--json")
    checked(one.json, keys)
    assert one.json["static_sd"] is None and one.json["kinetic_sd"] is None
    assert one.json["repeats"] == 1


def test_friction_window_and_normal_force(run: Run, files: Files) -> None:
    words = ("friction", *files.friction, "--json", "--normal-force")
    base = run(*words, "2.45N").json
    same = run(*words, "2.45N", "--from", "40 mm", "--to", "10cm").json
    assert same["kinetic"] == base["kinetic"]
    other = run(*words, "2.45N", "--from", "50mm", "--to", "90mm").json
    assert other["kinetic"] != base["kinetic"] and other["static"] == base["static"]
    double = run(*words, "4.9N").json
    assert double["kinetic"] == pytest.approx(base["kinetic"] / 2, rel=1e-12)
    stated = run("friction", *files.friction, "--json").json
    assert stated["kinetic"] == base["kinetic"]


def test_calibrate(run: Run, files: Files) -> None:
    keys = {
        "scale_factor": "1", "stiffness": "N/m", "scale_factor_eq8": "1", "stiffness_eq9": "N/m",
        "peak_force": "N", "peak_elongation": "m", "standard_errors": None, "checks": None,
    }  # fmt: skip
    ran = run("calibrate", "choi2018-kapton", *files.pulls, "--json")
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, keys)
    errors = ran.json["standard_errors"]
    assert {"scale_factor", "stiffness"} <= set(errors)
    unseen = 0.05 / 2**0.5  # scatter between mountings, which two pulls do not show
    assert errors["scale_factor"] == pytest.approx(0.875 * unseen, rel=0.03)
    assert errors["stiffness"] == pytest.approx(131e3 * unseen, rel=0.03)
    assert any("2 pulls" in str(v) for v in errors.values())  # says what it rests on
    for check in ran.json["checks"]:
        assert {"name", "passed", "level", "sentence"} <= set(check)
        assert check["passed"] is (check["level"] == "passed")
    assert ran.json["scale_factor"] == pytest.approx(0.875, rel=0.005)
    assert ran.json["stiffness"] == pytest.approx(131e3, rel=0.02)


def test_standard_errors_are_null_without_noise(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "quiet.csv"
    assert run("tensile", "choi2018-kapton", *PULL, "--out", out).code == 0
    ran = run("calibrate", "choi2018-kapton", out, "--vacuum", "94.5kPa", "--json")
    errors = ran.json["standard_errors"]
    assert ran.code == 0
    assert errors["scale_factor"] is None and errors["stiffness"] is None
    assert any("nothing" in str(v) for v in errors.values())
    assert ran.json["scale_factor"] == pytest.approx(0.875, rel=1e-6)


def test_validate(run: Run, files: Files) -> None:
    ran = run("validate", "choi2018-kapton", *files.validation, "--json")
    assert (ran.code, ran.err) == (0, "")
    checked(ran.json, {"mape": "1", "rmse": "N", "files": None})
    assert ran.json["mape"] < 0.02 and ran.json["rmse"] < 0.2
    assert [Path(row["path"]) for row in ran.json["files"]] == list(files.validation)
    assert [row["vacuum"] for row in ran.json["files"]] == [80.6e3, 46.1e3, 18.6e3]
    mean = sum(row["mape"] for row in ran.json["files"]) / 3
    assert ran.json["mape"] == pytest.approx(mean, rel=1e-12)
    assert any("synthetic" in w for w in ran.json["warnings"])


def test_a_vacuum_serves_files_without_a_sidecar_only(run: Run, files: Files) -> None:
    bare = run("validate", "choi2018-kapton", files.bare, "--vacuum", "94.5 kPa", "--json").json
    beside = run("validate", "choi2018-kapton", files.pulls[1], "--vacuum", "20kPa", "--json").json
    assert bare["files"][0]["vacuum"] == beside["files"][0]["vacuum"] == 94.5e3
    assert bare["mape"] == beside["mape"]


def test_calibrate_write_validate(run: Run, files: Files, tmp_path: Path) -> None:
    """The main job: friction, calibrate, validate, vacuum; the calibration's files are known."""
    mine, fitted = tmp_path / "mine.toml", tmp_path / "fitted.toml"
    ran = run("friction", *files.friction, "--normal-force", "2.45N", "--brake", "choi2018-kapton",
              "--out", mine, "--json")  # fmt: skip
    assert ran.code == 0 and ran.json["file"] == str(mine)
    assert load(mine).brake.film.kinetic == ran.json["kinetic"]
    assert load(mine).brake.scale_factor == 1.0
    assert any("0.875 was fitted with the old friction" in w for w in ran.json["warnings"])
    ran = run("calibrate", mine, *files.pulls, "--out", fitted, "--json")
    assert ran.code == 0
    made = load(fitted)
    assert made.brake.scale_factor == ran.json["scale_factor"]
    assert made.brake.stiffness_measured == ran.json["stiffness"]
    assert made.brake.scale_factor * made.brake.film.kinetic == pytest.approx(0.21, rel=0.005)
    honest = run("validate", fitted, *files.validation, "--json")
    assert honest.json["mape"] < 0.02
    assert not any("also used to calibrate this brake" in w for w in honest.json["warnings"])
    circular = run("validate", fitted, *files.pulls, *files.validation, "--json")
    said = [w for w in circular.json["warnings"] if "also used to calibrate this brake" in w]
    assert len(said) == 1 and all(str(p) in said[0] for p in files.pulls)
    assert str(files.validation[0]) not in said[0]
    answer = run("vacuum", fitted, "--slip", "20mm", "--force", "100N", "--json").json
    back = run("force", fitted, "--slip", "20mm", "--vacuum", f"{answer['vacuum']!r} Pa", "--json")
    assert back.json["force"] == pytest.approx(100.0, rel=1e-9)


def test_new(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "mine.toml"
    ran = run("new", "my-brake", "--from", "choi2018-ptfe", "--out", out, "--json")
    assert (ran.code, ran.err) == (0, "")
    assert {"units", "warnings"} <= set(ran.json)
    made = load(out)
    assert made.name == "my-brake" and made.brake == load("choi2018-ptfe").brake
    assert out.read_text().count("\n#") > 20
    again = run("show", out, "--json").json
    paper = run("show", "choi2018-ptfe", "--json").json
    assert {k: again[k] for k in SHOW} == {k: paper[k] for k in SHOW}


@pytest.mark.parametrize(
    "words",
    [
        ("show", "choi2018-kapton"),
        ("force", "choi2018-kapton", "--slip", "20mm", "--vacuum", "70kPa"),
        ("vacuum", "choi2018-kapton", "--slip", "20mm", "--force", "100N"),
        ("tensile", "choi2018-kapton", *PULL[2:], "--vacuum", "70kPa"),
    ],
    ids=lambda w: w[0],
)
def test_atmosphere(run: Run, words: tuple[str, ...]) -> None:
    high = run(*words, "--atmosphere", "80kPa", "--json")
    sea = run(*words, "--json")
    default = run(*words, "--atmosphere", "101325 Pa", "--json")
    assert high.code == sea.code == 0
    shown, given = sea.json, default.json
    if words[0] == "show":
        assert "given with the command" in given.pop("sources")["site.atmosphere"]
        shown.pop("sources")
    assert given == shown
    if words[0] == "show":
        assert high.json["max_force"] < 0.8 * sea.json["max_force"]
        assert high.json["energy_capacity"] < 0.81 * sea.json["energy_capacity"]
    elif words[0] == "vacuum":
        assert high.json["greatest_force"] < sea.json["greatest_force"]
        assert high.json["vacuum"] == pytest.approx(sea.json["vacuum"], rel=1e-12)
    else:
        assert high.json == sea.json


def test_atmosphere_for_calibrate_and_validate(run: Run, files: Files) -> None:
    for command in ("calibrate", "validate"):
        fine = run(command, "choi2018-kapton", *files.pulls, "--atmosphere", "98kPa", "--json")
        assert fine.code == 0
        low = run(command, "choi2018-kapton", *files.pulls, "--atmosphere", "90kPa", "--json")
        assert low.code == 2 and "94.5 kPa exceeds atmospheric pressure, 90 kPa" in low.err


def test_of_several_files_the_good_are_used(run: Run, files: Files, tmp_path: Path) -> None:
    bad, out = tmp_path / "bad.csv", tmp_path / "out.toml"
    bad.write_text("hello\n")
    for command in ("calibrate", "validate"):
        ran = run(command, "choi2018-kapton", files.pulls[0], bad, "--json")
        alone = run(command, "choi2018-kapton", files.pulls[0], "--json")
        assert ran.code == 3 and alone.code == 0 and ran.err == ""
        assert list(ran.json["refused"]) == [str(bad)] and alone.json["refused"] == {}
        key = "scale_factor" if command == "calibrate" else "mape"
        assert ran.json[key] == alone.json[key]
        shown = run(command, "choi2018-kapton", files.pulls[0], bad)
        assert shown.code == 3 and "refused:" in shown.out and "bad.csv" in shown.out
    words = ("calibrate", "choi2018-kapton", *files.pulls, bad, "--out", out, "--json")
    ran = run(*words)
    assert ran.code == 3 and not out.exists() and ran.json["file"] is None
    assert any("use --partial to write it" in w for w in ran.json["warnings"])
    ran = run(*words, "--partial")
    assert ran.code == 3 and load(out).brake.scale_factor == ran.json["scale_factor"]


def test_friction_with_one_bad_file(run: Run, files: Files, tmp_path: Path) -> None:
    bad, out = tmp_path / "bad.csv", tmp_path / "out.toml"
    bad.write_bytes(files.friction[0].read_bytes()[:3000])
    words = ("friction", *files.friction, bad, "--normal-force", "2.45N", "--brake",
             "choi2018-kapton", "--out", out, "--json")  # fmt: skip
    ran = run(*words)
    assert ran.code == 3 and list(ran.json["refused"]) == [str(bad)] and ran.json["repeats"] == 3
    assert not out.exists()
    assert run(*words, "--partial").code == 3 and out.exists()
