"""Brakes and lines with other numbers by name: checked like a file, the text in step."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from layerjam.brake.commands.arguments import convert_brake
from layerjam.brake.device.brake import Brake, mass
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.load import load, materials
from layerjam.brake.fluid.closed_forms import rise_time
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.brake.fluid.parts import parts
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.core.toml_files.changes import quantity_names
from layerjam.core.toml_files.shipped import shipped_files
from layerjam.core.units import quantities, quantity, record
from strategies import unchecked

KAPTON = load("choi2018-kapton")
PAPER = load_line("choi2018")


def friction(brake: Brake) -> float:
    return float(sheet_friction(0.02, 90e3, brake))


def test_a_wider_brake_holds_more_in_proportion_and_weighs_more():
    wide = KAPTON.brake.with_(width="14 mm", weighed_mass=None)
    same = KAPTON.brake.with_(weighed_mass=None)
    assert friction(wide) == pytest.approx(friction(KAPTON.brake) * 14 / 13, rel=1e-12)
    assert mass(wide) > mass(same)
    # text with a unit and an SI number say the same; what is not named is not touched
    assert KAPTON.brake.with_(width=0.014) == KAPTON.brake.with_(width="1.4 cm")
    assert wide.film == KAPTON.brake.film and KAPTON.brake.sheets.width == 0.013


def test_a_modulus_is_that_of_the_film_or_of_the_enclosure():
    brake = KAPTON.brake.with_(stiffness_measured=None)
    stiff = brake.with_(film_modulus=2 * brake.film.modulus)
    assert float(stiffness_before_slip(stiff)) == pytest.approx(
        2 * float(stiffness_before_slip(brake)), rel=1e-9
    )
    assert stiff.enclosure == brake.enclosure
    with pytest.raises(UnknownNameError, match=r"did you mean .*modulus"):
        brake.with_(modulus="2.5 GPa")


def test_a_name_without_its_record_is_never_that_of_an_optional_record():
    """`stiffness` alone would be the rope's, where a user means the brake's."""
    with pytest.raises(UnknownNameError, match="stiffness_measured"):
        KAPTON.brake.with_(stiffness="200 kN/m")
    assert KAPTON.brake.with_(rope_stiffness="200 kN/m").rope.stiffness == 200e3
    bare = replace(KAPTON.brake, rope=None)
    assert bare.with_(rope_stiffness="3 kN/m").rope.damping == 0
    for cls in (Brake, Line):
        assert set(quantity_names(cls).values()) == {path for path, _, _ in quantities(cls)}
        assert len(set(quantity_names(cls))) == len(quantity_names(cls))


@pytest.mark.parametrize(
    ("change", "quantity", "words"),
    [
        ({"width": 13.0}, "sheets.width", "13 m is not allowed"),
        ({"width": -1.0}, "sheets.width", "not allowed"),
        ({"width": "13"}, "sheets.width", "no unit"),
        ({"width": None}, "sheets.width", "cannot be omitted"),
        ({"count": 11.5}, "sheets.count", "an integer"),
        ({"usable_travel": "69 mm"}, "sheets.usable_travel", "exceeds the overlap"),
        ({"kinetic": 0.9}, "film.kinetic", "cannot exceed static friction"),
        ({"screw_hole": "13 mm"}, "mount.screw_hole", "leaves no"),
        ({"screws": 5}, "mount.screw_hole", "3 mm, 5 side by side, leaves no"),
        ({"screws": 1.5}, "mount.screws", "an integer"),
        ({"pressure_exponent": 0.1}, "pressure_exponent", "together with test_pressure"),
    ],
)
def test_what_no_file_could_say_is_refused(change, quantity, words):
    with pytest.raises(QuantityError, match=words) as caught:
        KAPTON.brake.with_(**change)
    assert (caught.value.key, caught.value.quantity) == ("quantity", quantity)
    with pytest.raises(LayerjamError, match=words):
        KAPTON.with_(**change)


def test_a_record_changed_behind_the_back_is_refused_where_it_is_wrapped():
    """13 m instead of 13 mm once gave 149,483 N without a word."""
    with pytest.raises(QuantityError, match=r"^width: 13 m is not allowed"):
        replace(KAPTON.brake.sheets, width=13.0)
    # what no constructor sees, such as a step of an optimiser over JAX's leaves
    wrong = unchecked(KAPTON.brake, sheets=unchecked(KAPTON.brake.sheets, width=13.0))
    for wrap in (convert_brake, BrakeFile.of, lambda b: convert_brake(replace(KAPTON, brake=b))):
        with pytest.raises(LayerjamError, match=r"sheets\.width: 13 m is not allowed"):
            wrap(wrong)


def test_a_brake_has_many_doors_and_is_the_same():
    file = BrakeFile.from_record(KAPTON.brake, "mine")
    for door in ("choi2018-kapton", KAPTON, KAPTON.brake, file):
        assert convert_brake(door).brake == KAPTON.brake
    assert BrakeFile.read(file.text, "x") == file and file.name == "mine"
    assert BrakeFile.from_record(KAPTON.brake).name == "unnamed"
    assert LineFile.from_record(PAPER.line).line == PAPER.line


def test_a_changed_file_keeps_sources_and_comments_and_its_text_in_step():
    file = replace(KAPTON, text="# weighed twice\n" + KAPTON.text)
    made = file.with_(width="14 mm", film_modulus="2.6 GPa", weighed_mass=None)
    assert made.brake == file.brake.with_(width=0.014, film_modulus=2.6e9, weighed_mass=None)
    assert made.text.startswith("# weighed twice") and 'value = "14 mm"' in made.text
    assert BrakeFile.read(made.text, "x").brake == made.brake
    assert made.sources["sheets.width"].text == "set with with_()"
    kept = set(file.sources) - {"sheets.width", "film.modulus", "weighed_mass"}
    assert all(made.sources[path] == file.sources[path] for path in kept)
    assert any("film.modulus" in warning for warning in made.warnings())


def test_a_record_that_left_its_text_behind_is_written_anew():
    site = replace(KAPTON.brake.site, atmosphere=80e3)
    high = replace(KAPTON, brake=replace(KAPTON.brake, site=site))
    made = high.with_(width="12 mm")
    assert (made.brake.site.atmosphere, made.brake.sheets.width) == (80e3, 0.012)
    assert made.sources["film.static"] == KAPTON.sources["film.static"]


def test_a_material_speaks_where_nothing_is_known():
    assert KAPTON.with_(strength="80 MPa").brake.film.strength == 80e6
    with pytest.raises(QuantityError, match=r"film\.strength: .* part, material or default"):
        KAPTON.with_(strength=None)


def test_a_line_with_twice_the_pump_rises_in_half_the_time():
    line = PAPER.line.with_(polytropic=1.0)
    twice = PAPER.with_(flow=2 * line.pump.flow)
    assert LineFile.read(twice.text, "x").line == twice.line
    leakless, half = (made.with_(laminar=0, orifice=0) for made in (line, twice.line))
    assert rise_time(60e3, half) == pytest.approx(rise_time(60e3, leakless) / 2, rel=1e-9)
    with pytest.raises(QuantityError, match=r"chamber\.shrink: .* would be lost"):
        PAPER.line.with_(shrink="1 mL/kPa")
    with pytest.raises(FileError, match="is not below atmospheric pressure"):
        PAPER.with_(ultimate="102 kPa")


def test_what_ships_is_handed_out_as_a_copy_or_read_only():
    texts = shipped_files("layerjam.brake.device", "catalogue", "brakes")
    texts.clear()
    materials()["films"].clear()
    assert load("choi2018-kapton") == KAPTON and materials()["films"]
    with pytest.raises(TypeError):
        parts("pump")["mine"] = None


def test_errors_keep_their_fields_between_processes():
    error = pickle.loads(pickle.dumps(QuantityError.of("sheets.width", "too wide")))
    assert (str(error), error.quantity) == ("sheets.width: too wide", "sheets.width")
    kinds = {e.key for e in (QuantityError, FileError, UnknownNameError)}
    assert kinds == {"quantity", "file", "unknown-name"}


def test_spacers_are_true_false_or_unstated_however_they_are_said():
    assert KAPTON.brake.mount.spacers is None
    for said in (False, "false"):
        without = KAPTON.with_(spacers=said)
        assert without.brake.mount.spacers is False
        assert KAPTON.brake.with_(spacers=said) == without.brake
        assert BrakeFile.read(without.render("x"), "x").brake == without.brake
    assert "spacers = {" not in KAPTON.text and "spacers = {value = true" in (
        KAPTON.with_(spacers=True).text
    )
    assert without.with_(spacers=None).brake == KAPTON.brake
    for wrong in (1.0, "yes", 0):
        with pytest.raises(QuantityError, match="mount.spacers: must be true or false"):
            KAPTON.brake.with_(spacers=wrong)
    with pytest.raises(FileError, match="mount.spacers: must be true or false"):
        BrakeFile.read(KAPTON.text.replace("[mount]", '[mount]\nspacers = "true"'), "x")
    with pytest.raises(QuantityError, match="2.0 is not allowed; write true or false"):
        replace(KAPTON.brake.mount, spacers=2.0)


@record
class Halved:
    share: float = quantity("1", "share of the friction that is left", hi=1)

    def friction_factor(self, vacuum, brake):
        return self.share


def test_effects_stay_with_the_brake_and_never_get_lost_in_silence():
    half = replace(KAPTON, brake=replace(KAPTON.brake, effects=(Halved(share=0.5),)))
    wide = half.brake.with_(width="26 mm")
    assert friction(wide) == pytest.approx(friction(KAPTON.brake), rel=1e-12)
    for write in (
        lambda: half.with_(width="26 mm"),
        lambda: half.render("half"),
        lambda: updated_text(half, "half", {}),
        lambda: parameters(half),
    ):
        with pytest.raises(QuantityError, match="effects"):
            write()
    with pytest.raises(QuantityError, match="share of the friction"):
        replace(half.brake, effects=(Halved(share=2.0),)).with_()
