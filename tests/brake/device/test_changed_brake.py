"""A brake that changed since its pulls says so in every command that uses its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import layerjam
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.evidence import Evidence, Part, state_fitted
from layerjam.core.errors import FileError

KEY = "changed-since-tests"


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """File of a brake that was calibrated with 11 sheets, and now has 13."""
    file = layerjam.load("choi2018-kapton")
    entry = Evidence(
        command="calibrate",
        date="2026-01-02",
        tests=5,
        names=("scale_factor",),
        ranges={"vacuum": (40e3, 60e3), "slip": (0.0, 0.06)},
        fitted=state_fitted("calibrate", file.known_values),
        parts=(Part("mean", ((0.01,),)),),
    )
    path = tmp_path_factory.mktemp("changed") / "mine.toml"
    text = updated_text(file, "mine", {}, evidence=entry)
    assert BrakeFile.read(text, "mine.toml").is_calibrated
    path.write_text(text.replace("count = { value = 11", "count = { value = 13"), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "value", ["sheets.count", "sheets.overlap", "film.kinetic", "enclosure.modulus", "scale_factor"]
)
def test_a_table_without_one_of_its_values_is_rejected(value: str, changed: Path) -> None:
    """Otherwise a change of that value would go unnoticed."""
    head, fitted = changed.read_text(encoding="utf-8").split("[tested.fitted]")
    kept = [line for line in fitted.splitlines() if line.split(" = ")[0].strip('"') != value]
    assert len(kept) == len(fitted.splitlines()) - 1
    with pytest.raises(FileError, match="fitted is missing or not as `calibrate` writes it"):
        BrakeFile.read(f"{head}[tested.fitted]" + "\n".join(kept), "mine.toml")


CALLS: dict[str, Callable[[Path, Path], Any]] = {
    "force": lambda brake, _: layerjam.force(brake, slip="1 mm", vacuum="50 kPa"),
    "tune": lambda brake, _: layerjam.tune(brake, mass="1 kg", speed=2.0, travel="40 mm"),
    "show": lambda brake, _: layerjam.show(brake),
    "compare": lambda brake, _: layerjam.compare(brake),
    "bend": lambda brake, _: layerjam.bend(brake, vacuum="50 kPa", angle="30 deg"),
    "export c": lambda brake, folder: layerjam.export_c(brake, out=folder / "c"),
    "export html": lambda brake, folder: layerjam.export_html(brake, out=folder / "brake.html"),
}


@pytest.mark.parametrize("name", CALLS)
def test_the_change_is_named_once(name: str, changed: Path, tmp_path: Path) -> None:
    result = CALLS[name](changed, tmp_path)
    [notice] = [w for w in result.warnings if w.key == KEY]
    assert "2026-01-02" in notice and "sheets.count was 11, is 13" in notice


def test_a_changed_brake_is_not_compared_as_a_calibrated_one(changed: Path) -> None:
    row = layerjam.compare(changed).devices[0]
    assert (row["basis"], row["basis_reason"]) == ("handbook", "changed since its tests")
    assert row["calibrated"] is False


def test_every_notice_is_printed_and_listed_once(changed: Path) -> None:
    result = layerjam.drop(changed, mass="1 kg", speed=2.0, vacuum="50 kPa")
    assert len(set(result.warnings)) == len(result.warnings)
    assert str(result).count("was calibrated on") == 1


@pytest.mark.parametrize("name", ["force", "tune", "show", "compare"])
def test_an_edited_copy_names_the_brake_to_which_its_factor_was_fitted(
    name: str, tmp_path: Path
) -> None:
    path = tmp_path / "wide.toml"
    layerjam.edit("choi2018-kapton", {"sheets.width": "20 mm"}).save(path)
    [notice] = [w for w in CALLS[name](path, tmp_path).warnings if w.key == "borrowed-fit"]
    assert "fitted to choi2018-kapton" in notice and "sheets.width was 13 mm, is 20 mm" in notice
    for brake in (Path(layerjam.new("same", "choi2018-kapton", out=tmp_path / "same.toml").file),
                  "choi2018-kapton-eq9", "choi2018-ptfe"):  # fmt: skip
        assert "borrowed-fit" not in [w.key for w in CALLS[name](brake, tmp_path).warnings]


def test_a_film_by_name_beside_the_values_of_another_is_rejected(tmp_path: Path) -> None:
    text = layerjam.load("choi2018-kapton").render("mine")
    with pytest.raises(FileError, match=r'film.use: "polyester" .* those of Kapton HN'):
        BrakeFile.read(text.replace("[film]", '[film]\nuse = "polyester"'), "mine.toml")
    assert BrakeFile.read(text.replace("[film]", '[film]\nuse = "kapton-hn"'), "mine.toml")


def test_an_edited_copy_is_as_uncertain_as_a_brake_that_nobody_fitted() -> None:
    """The bounds of docs/verdicts.md: 0.5 to 2 for the factor, 3 % between pulls, friction's SD."""
    edited = layerjam.edit("choi2018-kapton", {"sheets.width": "20 mm"}).record
    widths = []
    for brake in ("choi2018-kapton", edited):
        low, high = layerjam.force(brake, slip=0.02, vacuum=101325.0).interval("sheet_friction")
        widths.append(math.log(high / low))
    others = 0.03**2 + 0.0277**2
    assert widths[0] == pytest.approx(2 * 1.96 * math.sqrt(0.05**2 + others), rel=0.05)
    assert widths[1] == pytest.approx(2 * math.sqrt(math.log(2) ** 2 + 1.96**2 * others), rel=0.05)
