"""From a wish to a file that `build` accepts: `design new`, `design --out`, `save`, a dict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import Evidence, Part, state_fitted
from layerjam.brake.device.load import load
from layerjam.cli.main import main
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.workshop.design.specification import read_spec

KAPTON = "choi2018-kapton"
WISH: dict[str, Any] = {
    "name": "small",
    "brake": KAPTON,
    "constraints": ["holding_force >= 150 N", "length <= 170 mm"],
    "objectives": ["minimise mass"],
    "film": [{"use": KAPTON, "thickness": ["127 µm"]}],
    "vary": {
        "count": {"from": 11, "to": 21, "step": 2},
        "width": ["12 mm", "14 mm"],
        "overlap": ("60 mm", "68 mm"),
        "vacuum": "80 kPa",
    },
}


def write_wish(path: Path) -> Path:
    path.write_text(
        f"""
brake = "{KAPTON}"
constraints = ["holding_force >= 150 N", "length <= 170 mm"]
objectives = ["minimise mass"]
[[film]]
use = "{KAPTON}"
thickness = ["127 µm"]
[vary]
count = {{ from = 11, to = 21, step = 2 }}
width = ["12 mm", "14 mm"]
overlap = ["60 mm", "68 mm"]
vacuum = "80 kPa"
""",
        "utf-8",
    )
    return path


def test_a_dict_is_a_specification(tmp_path: Path) -> None:
    of_dict, of_file = lj.design(WISH), lj.design(write_wish(tmp_path / "small.toml"))
    assert of_dict.chosen == of_file.chosen and of_dict.front == of_file.front
    with pytest.raises(LayerjamError, match="did you mean constraints"):
        lj.design({**WISH, "constraint": ["mass <= 3 g"]})
    with pytest.raises(LayerjamError, match="no unit"):
        lj.design({**WISH, "vary": {"width": [0.012]}})


def test_the_design_is_written_as_a_brake_that_build_draws(tmp_path: Path) -> None:
    wish, file = write_wish(tmp_path / "small.toml"), tmp_path / "brake.toml"
    assert main(["design", str(wish), "--out", str(file)]) == 0
    result = lj.design(wish)
    drawn = lj.build(file, out=tmp_path / "built", no_step=True)
    assert drawn.feasible and drawn.overall_length <= 0.170
    assert drawn.overall_length == pytest.approx(result.chosen["length"], rel=1e-9)
    assert lj.show(file).usable_travel == pytest.approx(result.chosen["usable_travel"])
    saved = result.save(tmp_path / "saved.toml")
    assert saved.read_text("utf-8") == file.read_text("utf-8")


def test_the_usable_travel_is_printed() -> None:
    assert "usable_travel: " in str(lj.design(WISH))


def test_another_design_is_written_by_its_number(tmp_path: Path) -> None:
    file = tmp_path / "other.toml"
    result = lj.design(WISH)
    other = next(row for row in result.record.search.designs(np.arange(4)) if row["overlap"] > 0.06)
    lj.design(WISH, out=file, number=other["number"])
    assert lj.load(file).brake.sheets.overlap == pytest.approx(other["overlap"])
    with pytest.raises(QuantityError, match="number: only with out"):
        lj.design(WISH, number=3)


def test_no_file_without_a_design(tmp_path: Path) -> None:
    wish = {**WISH, "constraints": ["holding_force >= 5 kN"]}
    result = lj.design(wish, out=tmp_path / "brake.toml")
    assert result.exit_code == 1 and result.file is None and not [*tmp_path.iterdir()]
    with pytest.raises(QuantityError, match="no brake"):
        result.save(tmp_path / "brake.toml")


def test_edited_brakes_are_saved(tmp_path: Path) -> None:
    edited = lj.edit(KAPTON, {"sheets.width": "14 mm"}, name="mine")
    path = edited.save(tmp_path / "mine.toml")
    assert path.read_text("utf-8") == edited.text
    assert lj.load(path).brake.sheets.width == 0.014
    lj.load(KAPTON).with_(width="15 mm").save(tmp_path / "wide.toml")
    assert lj.load(tmp_path / "wide.toml").brake.sheets.width == 0.015
    with pytest.raises(FileError, match="already exists"):
        edited.save(path)
    with pytest.raises(FileError, match="use .toml"):
        edited.save(tmp_path / "mine.csv")


@pytest.mark.parametrize("start", ["wrist", "stop"])
def test_a_new_specification_is_that_of_the_example(
    start: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["design", "new", "grip", "--from", start]) == 0
    mine, example = lj.load_spec("grip.toml"), lj.load_spec(start)
    assert mine.name == "grip"
    assert (mine.constraints, mine.objectives) == (example.constraints, example.objectives)
    assert mine.grid.size == example.grid.size
    assert "# " + " " * 2 + "clamped_length" in Path("grip.toml").read_text("utf-8")
    assert main(["design", "new", "grip"]) == 2
    assert main(["design", "new", "no/name"]) == 2


def test_a_design_that_is_the_tested_brake_keeps_its_tests() -> None:
    """Pulls hold for other vacuums, but not for other dimensions."""
    kapton = load("choi2018-kapton")
    spread = ((1e-4, 0.0), (0.0, 1e-4))
    entry = Evidence(
        command="calibrate",
        date="2026-11-01",
        tests=5,
        names=("scale_factor", "stiffness_measured"),
        ranges={"vacuum": (50e3, 90e3), "slip": (0.0, 0.03)},
        fitted=state_fitted("calibrate", kapton.known_values),
        parts=(Part("mean", spread, 4.0), Part("test", spread)),
    )
    mine = BrakeFile.read(replace(kapton, evidence=(entry,)).render("mine"), "mine.toml")
    assert mine.evidence == (entry,)
    text = 'brake = "mine.toml"\nconstraints = ["holding_force >= 150 N"]\n'
    text += 'objectives = ["minimise mass"]\n[vary]\nvacuum = ["60 kPa", "70 kPa"]\n'
    same, other = (
        lj.design(read_spec(t, "s", {"mine.toml": mine}))
        for t in (text, text + 'width = ["14 mm"]\n')
    )
    assert same.basis == "tested" and same.robustness["all"]["probability"] >= 0.95
    assert other.basis == "handbook" and other.robustness["all"]["probability"] < 0.95
    written = same.content()
    assert written.evidence == (entry,)
    assert lj.force(written, slip=0.0, vacuum=70e3).basis == "tested"
