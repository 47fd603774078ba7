"""One word for each quantity: travel is slip, an elongation is that of a crosshead."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
from layerjam.cli.main import main
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands

KAPTON = "choi2018-kapton"
PULL = ("--vacuum", "60kPa", "--speed", "1mm/s")


@pytest.mark.parametrize("name", ["tensile", "stick-slip"])
def test_the_elongation_of_a_pull_was_called_travel(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = []
    for option in ("--elongation", "--travel"):
        assert main([name, KAPTON, *PULL, option, "3mm", "--json"]) == 0
        out, err = capsys.readouterr()
        printed.append(json.loads(out))
        assert ("is now called --elongation" in err) is (option == "--travel")
    assert printed[0] == printed[1]


def test_the_former_name_works_in_python() -> None:
    new = lj.tensile(KAPTON, vacuum=6e4, speed=1e-3, elongation=0.01)
    assert lj.tensile(KAPTON, vacuum=6e4, speed=1e-3, travel=0.01) == new


def test_travel_is_a_slip_wherever_it_is_an_option() -> None:
    found = {}
    for name in commands():
        for p in load_command(name).parameters:
            if p.name == "travel" and p.spec is not None:
                found[name] = p.sentence.lower()
    assert {*found} == {"drop", "tune", "plan"}
    assert all("slip" in sentence for sentence in found.values())


def test_the_mass_has_a_displacement(tmp_path: Path) -> None:
    stop = lj.drop(KAPTON, mass=1, speed=2.5, vacuum=6e4, rope_stiffness=16.8e3)
    record = stop.record
    assert isinstance(record, lj.DropRecord)
    assert record.displacement[-1] > record.slip[-1]
    np.testing.assert_array_equal(record.travel, record.displacement)
    assert "displacement" in stop.to_frame() and "travel" not in stop.to_frame()
    assert "displacement [m]" in stop.save(tmp_path / "stop.csv").read_text("utf-8")


def test_only_static_friction_holds(tmp_path: Path) -> None:
    exported = lj.export_c(KAPTON, out=tmp_path / "c")
    sheets, film = lj.load(KAPTON).brake.sheets, lj.load(KAPTON).brake.film
    area = sheets.width * sheets.overlap * (sheets.count - 1) * 101325 * 0.875
    assert exported.sheet_friction == pytest.approx(film.kinetic * area, rel=1e-9)
    assert exported.holds == exported.sheet_friction and "holds" not in str(exported)
    assert lj.show(KAPTON).holding_force == pytest.approx(film.static * area, rel=1e-9)


@pytest.mark.parametrize("horizontal", [False, True])
def test_the_floor_is_a_stop_at_constant_force_over_slip_and_stretch(horizontal: bool) -> None:
    case = {"mass": 1.0, "speed": 2.5, "rope_stiffness": 16.8e3, "horizontal": horizontal}
    tuned = lj.tune(KAPTON, travel=0.04, **case)
    top = lj.laws.peak(tuned.vacuum, 0.06, lj.load(KAPTON).brake).force
    distance = 0.04 + top * (1 / 16.8e3 + 1 / 131e3)
    floor = 2.5**2 / (2 * 9.80665 * distance) + (not horizontal)
    assert tuned.floor_g == pytest.approx(floor, rel=1e-6)
    assert lj.drop(KAPTON, vacuum=tuned.vacuum, **case).peak_g > tuned.floor_g


def test_every_printed_term_of_the_first_hour_is_explained() -> None:
    docs = Path(__file__).parents[3] / "docs"
    for page, terms in {
        "five-minutes.md": (
            "peak vacuum",
            "scale factor",
            "amplification held",
        ),
        "first-calibration.md": ("scale factor eq8", "stiffness eq9"),
        "which-vacuum.md": (
            "safe vacuum",
            "basis",
            "vacuum",
            "vacuum eq10",
            "floor g",
            "least speed",
        ),
    }.items():
        text = (docs / page).read_text("utf-8")
        assert all(f"`{term}` " in text for term in terms), page
    assert "(PET)" in lj.load("choi2018-polyester").title
