"""The lengths of section 2 of the specification, and the [build] table that they follow from."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from scipy.special import ellipe

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.device.workshop import Build
from layerjam.core.errors import FileError, QuantityError
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.lengths import CannotBuildError, compute_lengths, ellipse_girth

KAPTON = load("choi2018-kapton")


def test_the_papers_brake_has_the_lengths_of_the_specification() -> None:
    found = compute_lengths(KAPTON.brake, resolve_choices(KAPTON).build)
    assert (found.thread.name, found.screw_length) == ("M3", 8)
    printed = {
        "floor": 1.403, "plate_height": 4.603, "shelf_height": 4.003, "cap_height": 11.4,
        "tray_width": 16.8, "slot": 13.6, "sleeve": 126, "pin_to_pin": 154.4, "overall": 166.4,
        "strap": 214.4,
    }  # fmt: skip
    for name, value in printed.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12), name
    assert found.left.tray == 7 and found.left.reach == found.right.reach == 18
    assert 2 * found.neck_a == pytest.approx(12.56847, abs=5e-6) and found.neck_a == found.neck_b
    assert (found.mould.casting, found.mould.length) == (136, 166)
    assert (found.left.sheets, found.left.spacers) == (6, 5)
    assert (found.right.sheets, found.right.spacers) == (5, 6)


@pytest.mark.parametrize("aspect", [1.0, 1.3, 2.0, 3.0])
def test_the_girth_of_an_ellipse(aspect: float) -> None:
    exact = 4 * ellipe(1 - 1 / aspect**2)
    assert ellipse_girth(1.0, 1 / aspect) == pytest.approx(exact, rel=1e-14)


def test_unequal_free_lengths_give_unequal_caps() -> None:
    brake = KAPTON.brake.with_(free_left="9 mm")
    found = compute_lengths(brake, Build())
    assert found.left.clamped == pytest.approx(8) and found.right.clamped == pytest.approx(6)
    assert not found.has_same_caps
    assert found.sleeve == pytest.approx(found.free + found.left.reach + found.right.reach)


def test_a_stack_beyond_every_screw_cannot_be_built() -> None:
    brake = KAPTON.brake.with_(count=250)
    with pytest.raises(CannotBuildError) as caught:
        compute_lengths(brake, Build())
    assert caught.value.reason == "screw-length" and caught.value.limit == 0.06
    assert math.isclose(caught.value.value or 0, 0.0635 + 2 * 0.0012 + 0.0024)


def test_a_hole_below_two_millimetres_is_refused() -> None:
    with pytest.raises(QuantityError, match="at least 2 mm is needed for M2"):
        compute_lengths(KAPTON.brake.with_(screw_hole="1.9 mm"), Build())


def built(rows: str) -> BrakeFile:
    return BrakeFile.read(f"{KAPTON.text}\n[build]\n{rows}\n", "brake.toml")


def test_the_table_is_read_with_its_sources_and_written_again() -> None:
    file = built('kerf = { value = "0.2 mm", kind = "measured", source = "comb" }\nport = "4 mm"')
    assert file.making.build == replace(Build(), kerf=0.2e-3, port=4e-3)
    assert file.sources["build.kerf"].text == "comb"
    again = BrakeFile.read(file.render("again"), "again.toml")
    assert again.making == file.making and again.brake == file.brake
    assert file.with_(width="14 mm").making == file.making


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ('kerf = "1.5 mm"', "at most 1 mm"),
        ('kerf = "0.2 mm"\ncutter = "knife"', "plotter applies its own offset"),
        ('kerf = "0.5 mm"\ngap = "0.4 mm"', "not less than build.gap"),
        ('krf = "1 mm"', "did you mean build.kerf"),
        ("kerf = 0.2", "has no unit"),
        ('kerf = "nan mm"', "not a number"),
        ('port = "M6"', "use M5 or a tube's diameter"),
        ('cutter = "axe"', "unknown cutter"),
        ('tip_radius = "6.5 mm"', "half the sheets' width"),
        ('edge = "1.6 mm"', "not less than build.cheek"),
        ('laser_bed = "600 mm"', "2 lengths"),
        ('print_bed = "0.5mm x 1m x 1m"', "at least 1 mm"),
        ('stock_width = "50 mm"', "give both or neither"),
        ("screws = 26", "at most 25"),
        ("screws = 5", "5 side by side, leaves no material in sheets 13 mm wide"),
    ],
)
def test_what_contradicts_itself_is_refused_with_its_line(rows: str, said: str) -> None:
    with pytest.raises(FileError, match=said) as caught:
        built(rows)
    assert caught.value.line is not None


def test_command_over_brake_over_workshop(tmp_path) -> None:
    place = tmp_path / "workshop.toml"
    place.write_text('[build]\nkerf = "0.3 mm"\ngap = "4 mm"\nmargin = "8 mm"\n')
    file = built('kerf = "0.2 mm"\ngap = "5 mm"')
    made = resolve_choices(file, place, {"gap": 6e-3, "cutter": None})
    assert (made.build.kerf, made.build.gap, made.build.margin) == (0.2e-3, 6e-3, 8e-3)
    assert (
        "kerf" not in made.default_keys
        and "margin" not in made.default_keys
        and "tip_radius" in made.default_keys
    )
    place.write_text('name = "empty"\n')
    with pytest.raises(FileError, match=r"no \[build\] table"):
        resolve_choices(file, place)
