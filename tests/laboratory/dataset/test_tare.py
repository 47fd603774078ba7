"""`--tare` means the same in every command that reads forces: against an independent rig."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from independent import pulls as brakes
from independent import sled_rig
from layerjam.core.errors import MissingExtraError
from layerjam.laboratory.commands.measurements import Measurements
from layerjam.laboratory.figures import brake_files

pytestmark = pytest.mark.slow
ZERO, TARE, NORMAL = 0.03, 5.0, 2.0
TEST = {"tare": True}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three friction tests with a zero error of 5 %, and nine pulls with one of 3 to 8 %."""
    place = tmp_path_factory.mktemp("tared")
    for number in range(3):
        rig = sled_rig.Rig(static=0.52, kinetic=brakes.FRICTION * NORMAL, zero=ZERO)
        path = sled_rig.write(place / f"friction-{number}.csv", rig, number)
        path.with_name(path.name + ".toml").write_text(
            f'normal_force = "{NORMAL:g} N"\nbrake = "{brakes.BRAKE}"\n'
        )
    pulls = brakes.repeats(np.random.default_rng(2), brakes.VACUUMS, 3, 0.005)
    facts = [{"mounting": str(n), "brake": f'"{brakes.BRAKE}"'} for n in range(1, 10)]
    tared = [replace(p, tare=TARE, facts=f) for p, f in zip(pulls, facts, strict=True)]
    brakes.write(place, tared)
    return place


@pytest.fixture(autouse=True)
def no_pdf(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any) -> bytes:
        raise MissingExtraError("a page as PDF (typst)", "pdf")

    monkeypatch.setattr(brake_files, "typeset_pdf", missing)


def measurements(folder: Path) -> Measurements:
    return Measurements(
        friction=sorted(folder.glob("friction-?.csv")),
        pulls=sorted(folder.glob("pull-0[1-6].csv")),
        validate=sorted(folder.glob("pull-0[7-9].csv")),
    )


@pytest.mark.parametrize("command", ["report", "publish"])
def test_stages_subtract_what_single_commands_subtract(
    folder: Path, tmp_path: Path, command: str
) -> None:
    files = measurements(folder)
    friction = lj.friction(
        files.friction, test=TEST, brake=brakes.BRAKE, out=tmp_path / "friction.toml"
    )
    fitted = lj.calibrate(
        tmp_path / "friction.toml", files.pulls, tare=True, out=tmp_path / "brake.toml"
    )
    validation = lj.validate(tmp_path / "brake.toml", files.validate, tare=True)
    assert fitted.scale_factor == pytest.approx(brakes.SCALE_FACTOR, rel=0.02)
    out = tmp_path / "out"
    if command == "report":
        lj.report(brakes.BRAKE, measurements=files, test=TEST, out=out)
        results = json.loads((out / "results.json").read_text())
    else:
        lj.publish(folder, brake=brakes.BRAKE, measurements=files, test=TEST, out=out)
        results = json.loads((out / "report" / "results.json").read_text())
        again = lj.recompute(out)
        assert again.equal is True, str(again)
        assert json.loads((out / "recipe.json").read_text())["options"]["tare"] is True
    assert results["friction"]["kinetic"] == friction.kinetic
    for name in ("scale_factor", "stiffness"):
        assert results["calibration"][name] == getattr(fitted, name)
    assert results["validation"]["mape"] == validation.mape


def test_without_it_the_results_include_the_zero(folder: Path, tmp_path: Path) -> None:
    found = lj.report(brakes.BRAKE, measurements=measurements(folder), out=tmp_path / "out")
    levels = {check.name: check.level for check in found.record.verdict.checks}
    assert levels["friction.zero"] == levels["calibration.zero"] == "warning"
    assert found.calibration is not None and found.friction is not None
    product = found.calibration["scale_factor"] * found.friction["kinetic"]
    assert product > 1.04 * brakes.SCALE_FACTOR * brakes.FRICTION
