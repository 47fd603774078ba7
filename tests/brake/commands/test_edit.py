"""A brake changed in its own text: what was not touched stays, to the last character."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.brake.commands.edit import BRAKE_FIELDS, edit, find_stale_numbers
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.core.units import get

KAPTON = "choi2018-kapton"


def test_one_number_changes_and_the_rest_of_the_text_stays():
    text = load(KAPTON).text.replace("[film]", "# our own remark\n[film]")
    file = BrakeFile.read(text, "it")
    made = edit(file, {"sheets.width": "15 mm"})
    changed = [
        (a, b) for a, b in zip(text.splitlines(), made.text.splitlines(), strict=True) if a != b
    ]
    assert [a.split(" ")[0] for a, _ in changed] == ["width"]
    assert made.record.brake.sheets.width == 0.015
    for path, source in file.sources.items():
        if path != "sheets.width":
            assert made.record.sources[path] == source
    said = made.record.sources["sheets.width"]
    assert said.kind == "assumed"
    assert "was 13 mm, paper: Choi 2018, section II-A" in said.sentence()


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(BRAKE_FIELDS)), st.floats(0.9, 1.1))
def test_any_number_reads_back_as_it_was_set(path, factor):
    old = get(load(KAPTON).brake, path)
    spec = BRAKE_FIELDS[path][0]
    value = (old if old is not None else max(spec.lo, 1.0)) * factor
    value = int(value) if spec.whole else value
    try:
        made = edit(KAPTON, {path: value}, kind="measured", source="a test")
    except LayerjamError as err:
        named = path.split(".")[-1], path.split(".")[0], "sheets", "film"
        assert any(name in str(err) for name in named)
        return
    assert get(made.record.brake, path) == value
    assert made.record.sources[path].kind == "measured"
    assert made.record.sources[path].text == "a test"
    # the text alone says it all
    assert BrakeFile.read(made.text, "again").brake == made.record.brake


def test_what_is_taken_back_is_not_known_or_what_the_material_says():
    heavy = edit(KAPTON, {"weighed_mass": "21 g", "film.strength": "80 MPa"}).record
    light = edit(heavy, {"weighed_mass": None, "film.strength": None}).record
    assert light.brake == load(KAPTON).brake
    with pytest.raises(
        QuantityError, match=r"film\.strength: is set by a part, material or default"
    ):
        edit(light, {"film.strength": None})
    with pytest.raises(FileError, match=r"sheets\.width \(sheet width\) is missing"):
        edit(light, {"sheets.width": None})


def test_the_first_source_outlives_several_edits():
    twice = edit(edit(KAPTON, {"sheets.count": 13}).record, {"sheets.count": 15}).record
    assert twice.sources["sheets.count"].was == "11, paper: Choi 2018, section II-A"
    again = BrakeFile.read(twice.text, "again")
    assert again.sources == twice.sources


def test_factors_of_the_brake_before_are_named():
    assert find_stale_numbers(load(KAPTON)) == []
    made = edit(KAPTON, {"sheets.count": 13})
    assert any("stiffness_measured" in w and "sheets.count" in w for w in made.warnings)
    own = edit(made.record, {
        "scale_factor": 1.0, "stiffness_measured": "200 kN/m", "fittings_mass": "12 g",
    })  # fmt: skip
    assert find_stale_numbers(own.record) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sheets.width": "15"}, "15 mm"),
        ({"sheets.width": "15 kg"}, "units of length"),
        ({"sheets.overlap": "500 mm"}, "sheets.length: 85 mm is shorter"),
        ({"film.kinetic": 0.5}, "kinetic friction cannot exceed static friction"),
        ({"sheets.with": "1 mm"}, "did you mean"),
    ],
)
def test_what_makes_no_brake_is_refused_in_words(changes, words):
    with pytest.raises(LayerjamError, match=words):
        edit(KAPTON, changes)
