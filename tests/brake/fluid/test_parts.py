"""The catalogue of parts: every entry, its sources, in a line, and what is refused."""

from __future__ import annotations

import math

import pytest

from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.fluid.closed_forms import reachable_vacuum
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.fluid.parts import FAMILIES, NEEDED, PRINTED, family_fields, parts, read_parts
from layerjam.brake.fluid.pump_curve import STANDARD
from layerjam.core.errors import FileError, UnknownNameError

EVERY = [p for family in FAMILIES for p in parts(family).values()]
LINE = 'name = "mine"\n[chamber]\nvolume = "10 mL"\n'


def line_with(*tables):
    return LineFile.read(LINE + "\n".join(tables) + "\n", "mine.toml")


@pytest.mark.parametrize("part", EVERY, ids=lambda p: p.name)
def test_every_number_has_a_source_and_lies_in_its_bounds(part):
    own = family_fields(part.family)
    assert set(part.values) <= set(own) and set(part.printed) <= set(PRINTED)
    for key in (*part.values, *part.printed):
        source = part.sources[key]
        assert source.kind != "unstated" and source.text
        assert not source.text.startswith("as ")
    for key, value in part.values.items():
        if key != "curve":
            own[key].check(value, key)


def test_there_are_as_many_as_the_catalogue_says():
    counts = {f: sum(p.missing is None for p in parts(f).values()) for f in FAMILIES}
    assert counts["pump"] >= 4 and counts["valve"] >= 2 and counts["sensor"] >= 3


def test_units_convert():
    assert parts("pump")["dfr0523"].values["flow"] == pytest.approx(45e-6 / 60)
    assert parts("valve")["smc-vt307v"].values["conductance"] == pytest.approx(0.71e-8)
    assert parts("sensor")["honeywell-hsc-015pd"].values["range"] == pytest.approx(103421.0)
    assert parts("sensor")["freescale-mpx4115a"].printed["sensitivity"] == pytest.approx(45.9e-6)
    assert parts("sensor")["freescale-mpx4115a"].values["lag"] == pytest.approx(
        parts("sensor")["freescale-mpx4115a"].printed["response"] / math.log(9), abs=1e-6
    )


@pytest.mark.parametrize("part", [p for p in EVERY if p.missing is None], ids=lambda p: p.name)
def test_every_whole_part_stands_in_a_line(part):
    table = f'[{part.family}]\npart = "{part.name}"'
    tables = [table] if part.family == "pump" else ['[pump]\nflow = "20 mL/s"', table]
    file = line_with(*tables)
    made = getattr(file.line, part.family)
    for key, value in part.values.items():
        assert getattr(made, key) == value
    assert file.parts == {part.family: part.name}
    for key in part.values:
        assert file.sources[f"{part.family}.{key}"] == part.sources[key]
    answer = rise(file, target=0.5 * reachable_vacuum(file.line))
    assert answer.feasible
    if any(part.sources[k].kind == "assumed" for k in part.values):
        assert any("assumed" in w and part.family in w for w in answer.warnings)


def test_free_air_and_greatest_vacuum_of_a_data_sheet():
    """Without vacuum the pump takes in its free air; it ends at its greatest vacuum."""
    file = line_with('[pump]\npart = "jsg-bd-04"')
    assert reachable_vacuum(file.line) == pytest.approx(75e3)
    answer = rise(file, target="50 kPa")
    # V dp / q over the line, q straight: q(P) = a Q (1 - P/75 kPa)
    q = STANDARD * 7e-3 / 60
    by_hand = 10e-6 * 75e3 / q * math.log((75 - 5) / (75 - 45))
    assert answer.rise_time == pytest.approx(by_hand, rel=1e-6)


def test_what_stands_beside_a_part_comes_first():
    line = line_with(
        '[pump]\npart = "jsg-bd-04"\nflow = "20 mL/s"\ncount = 3',
        '[valve]\npart = "smc-vt307v"\ncritical_ratio = 0.3',
    ).line
    assert (line.pump.flow, line.pump.curve, line.pump.count) == (20e-6, None, 3)
    assert (line.valve.conductance, line.valve.critical_ratio) == (0.71e-8, 0.3)
    file = line_with(
        '[pump]\npart = "dfr0523"\ncurve = [["0 kPa", "1 L/min"], ["50 kPa", "0 L/min"]]'
    )
    assert file.line.pump.flow is None and file.line.pump.power == 5.0
    assert "pump.ultimate" not in file.sources


def test_a_missing_critical_ratio_is_shown_as_assumed():
    file = line_with('[pump]\nflow = "20 mL/s"', '[valve]\npart = "smc-vt307v"')
    assert file.sources["valve.critical_ratio"].kind == "assumed"
    assert "valve.critical_ratio" in " ".join(file.warnings())


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ('[pump]\npart = "dfr0524"', "line 5: unknown pump 'dfr0524'; did you mean dfr0523"),
        ("[pump]\npart = 3", "unknown pump '3'"),
        (
            '[pump]\nflow = "1 mL/s"\n[valve]\npart = "festo-mh1-3-2"',
            r"line 7: valve.part: festo-mh1-3-2 has no conductance \(.*; also give valve.conduct",
        ),
        (
            '[pump]\nflow = "1 mL/s"\n[sensor]\npart = "honeywell-24pccfb6g"',
            "sensor.part: honeywell-24pccfb6g has no range",
        ),
        ('[pump]\npart = "jsg-bd-04"\nultimate = "20 kPa"', "line 6: pump.ultimate: a flow curve"),
        ('[pump]\npart = "dfr0523"\nflow = "1 kPa"', "line 6: .*'1 kPa' is not in"),
        ('[tube]\npart = "dfr0523"', "unknown key 'tube.part'"),
    ],
)
def test_what_is_refused(tables, words):
    with pytest.raises(FileError, match=words):
        line_with(tables)


def test_a_number_beside_a_part_fills_its_gap():
    line = line_with(
        '[pump]\nflow = "1 mL/s"',
        '[valve]\npart = "festo-mh1-3-2"\nconductance = "0.05 L/(s bar)"',
    ).line
    assert (line.valve.conductance, line.valve.delay) == (0.05e-8, 0.004)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[a]\nname = "A"\nkind = "b"\nrange = "1 kPa"\n', "line 4: a.range names no source"),
        ('[a]\nname = "A"\nkind = "b"\nrangs = "1 kPa"\n', "line 4: unknown key 'a.rangs'"),
        ('[a]\nkind = "b"\n', "a.name: must be text in quotes"),
        ("a = 3\n", "a must be a table"),
    ],
)
def test_a_catalogue_that_is_none(text, words):
    with pytest.raises(FileError, match=words):
        read_parts(text, "sensors.toml", "sensor")


def test_families():
    assert set(NEEDED) == set(FAMILIES)
    with pytest.raises(UnknownNameError, match="family of parts 'hose'"):
        parts("hose")
