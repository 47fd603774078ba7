"""The catalogue: complete, sourced, consistent, and what the paper weighs."""

from __future__ import annotations

import dataclasses
import tomllib

import pytest

from layerjam.brake.device.brake import enclosure_mass, mass, sheet_mass, validate
from layerjam.brake.device.load import catalogue, devices, load, materials
from layerjam.brake.fluid.line_file import load_line
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.toml_files.source import KINDS, Source
from layerjam.core.units import get, quantities
from strategies import KAPTON, change, one, random_brakes

NAMES = catalogue()


def test_what_is_there():
    assert {"choi2018-kapton", "choi2018-ptfe", "choi2018-polyester"} <= set(NAMES)
    assert "kapton-hn" in materials()["films"] and "ecoflex-5" in materials()["silicones"]


@pytest.mark.parametrize("name", NAMES)
def test_every_number_has_a_source(name):
    file = load(name)
    given = [p for p, _, _ in quantities(type(file.brake)) if get(file.brake, p) is not None]
    for path in given:
        if path.startswith("site."):
            continue  # the standard atmosphere and gravity are the record's defaults
        if path == "rope.damping" and path not in file.sources:
            continue  # default: a rope without damping
        source = file.sources[path]
        assert source.kind in KINDS and source.kind != "unstated", path
        assert len(source.text) > 5, path


@pytest.mark.parametrize("folder", ["films", "silicones"])
def test_every_material_number_has_a_source(folder):
    for name, text in materials()[folder].items():
        for key, entry in tomllib.loads(text).items():
            if key not in ("name", "title", "note"):
                assert entry["kind"] in KINDS and len(entry["source"]) > 5, (name, key)


@pytest.mark.parametrize("name", NAMES)
def test_brakes_are_valid_and_weigh_what_the_paper_says(name):
    file = load(name)
    validate(file.brake)
    if "choi2018" in name:
        assert mass(file.brake) * 1e3 == pytest.approx(20.0, abs=0.01)
        assert file.brake.sheets.count == 11 and file.brake.sheets.overlap == 0.068


def test_masses():
    assert f"{sheet_mass(KAPTON) * 1e3:.3f}" == "0.399"
    assert enclosure_mass(KAPTON) * 1e3 == pytest.approx(3.43, abs=0.005)
    section = 2 * 1e-3 * (0.013 + 11 * 0.254e-3) + 4e-6
    assert enclosure_mass(KAPTON) == pytest.approx(section * 0.09 * KAPTON.enclosure.density)
    assert mass(change(KAPTON, weighed_mass=0.5)) == 0.5
    total = 11 * sheet_mass(KAPTON) + enclosure_mass(KAPTON) + KAPTON.fittings_mass
    assert mass(KAPTON) == pytest.approx(total, rel=1e-15)


def test_paper_values_of_kapton_and_ptfe():
    ptfe = load("choi2018-ptfe").brake
    assert (KAPTON.scale_factor, ptfe.scale_factor) == (0.875, 1.24)
    assert (KAPTON.stiffness_measured, ptfe.stiffness_measured) == (131e3, 55e3)
    assert (KAPTON.film.static, KAPTON.film.kinetic) == (0.32, 0.24)
    assert (ptfe.film.static, ptfe.film.kinetic) == (0.12, 0.05)
    assert (KAPTON.film.friction_on_silicone, ptfe.film.friction_on_silicone) == (0.80, 0.23)
    assert KAPTON.enclosure.modulus == 1e5 and KAPTON.rope.stiffness == 16.8e3
    assert "107 N/mm" in load("choi2018-kapton").sources["stiffness_measured"].conflict


def test_warnings_name_what_was_not_measured():
    plain = load("choi2018-polyester")
    said = " ".join(plain.warnings())
    assert "no stiffness was measured" in said and "handbook values" in said
    assert "scale_factor" in said and "assumed values" in said
    assert not any("no stiffness" in w for w in load("choi2018-kapton").warnings())


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"sheets__usable_travel": 0.07}, "usable_travel.*exceeds the overlap"),
        ({"sheets__length": 0.08}, "sheets.length.*shorter than"),
        ({"sheets__free_right": 0.012}, "sheets.length.*shorter than"),
        ({"mount__screw_hole": 0.013}, "screw_hole.*leaves no"),
        ({"film__kinetic": 0.33}, "film.kinetic.*exceeds film.static"),
        ({"pressure_exponent": 0.1}, "together with test_pressure"),
        ({"test_pressure": 3900.0}, "together with test_pressure"),
        ({"sheets__count": 1}, "sheets.count"),
        ({"sheets__count": 2.5}, "an integer"),
        ({"scale_factor": float("nan")}, "scale_factor"),
        ({"site__atmosphere": 2e5}, "site.atmosphere"),
    ],
)
def test_contradictions_are_refused(values, says):
    with pytest.raises(QuantityError, match=says):
        validate(change(KAPTON, **values))


def test_random_brakes_of_the_other_tests_are_valid():
    for exponent in (False, True):
        brakes = random_brakes(1, 60, exponent=exponent)
        for index in range(60):
            validate(one(brakes, index))


def test_unknown_names_offer_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean choi2018-kapton"):
        load("choi2018-kaptn")
    with pytest.raises(UnknownNameError) as caught:
        load("x" * 5000)
    assert len(str(caught.value)) < 300


def test_source_sentence():
    source = Source(kind="paper", text="table I", spread="SD 3 %", conflict="0.48")
    assert source.sentence() == "paper: table I; spread SD 3 %; conflict: 0.48"
    assert dataclasses.replace(source, text="", spread="", conflict="").sentence() == "paper"


def test_a_second_reading_of_a_device_is_no_second_device():
    readings = {name for name in NAMES if name.endswith("-eq9")}
    assert readings == {"choi2018-kapton-eq9", "choi2018-ptfe-eq9"}
    assert set(devices()) == set(NAMES) - readings
    for name in readings:
        plain = load(name.removesuffix("-eq9"))
        for field in ("scale_factor", "stiffness_measured"):
            assert name in plain.sources[field].conflict
            assert plain.name in load(name).sources[field].conflict


@pytest.mark.parametrize(("load", "name"), [(load, "choi2018-kapton"), (load_line, "choi2018")])
def test_a_changed_copy_of_a_shipped_file_changes_no_other(load, name) -> None:
    first = load(name)
    for mapping in (first.sources, first.notes, getattr(first, "parts", {})):
        mapping.clear()
    second = load(name)
    assert second.sources and second.record == first.record
    assert getattr(second, "parts", None) != {}
