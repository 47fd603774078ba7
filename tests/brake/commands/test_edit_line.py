"""Numbers and parts of a line changed in its text."""

from __future__ import annotations

import pytest

from layerjam.brake.commands.edit import LINE_FIELDS, edit_line
from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.core.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.core.units import get


def test_numbers_change_and_say_where_they_come_from():
    made = edit_line("choi2018", {"chamber.volume": "15.006 mL", "polytropic": 1.2}, name="mine")
    file = made.record
    assert file.name == "mine"
    assert file.line.chamber.volume == pytest.approx(15.006e-6)
    assert file.line.polytropic == 1.2
    source = file.sources["chamber.volume"]
    assert source.kind == "assumed" and "was 7.503 mL" in source.sentence()
    # what was not touched keeps its source
    old = load_line("choi2018")
    assert file.sources["chamber.compliance"] == old.sources["chamber.compliance"]
    assert LineFile.read(made.text, "x").line == file.line
    back = edit_line(file, {"chamber.volume": old.line.chamber.volume, "polytropic": None})
    assert back.record.line == old.line


def test_twice_the_volume_takes_twice_the_time():
    one = rise("choi2018", target="60 kPa").rise_time
    two = rise(edit_line("choi2018", {"chamber.volume": "15.006 mL"}).record, target="60 kPa")
    assert two.rise_time == pytest.approx(2 * one)


def test_parts_take_the_place_of_a_table_and_leave_it():
    valve = edit_line("choi2018", takes={"valve": "smc-vt307v"}).record
    assert valve.parts["valve"] == "smc-vt307v" and valve.line.valve is not None
    assert edit_line(valve, takes={"valve": None}).record.line.valve is None
    tube = edit_line(valve, {"tube.length": "1 m", "tube.bore": "3 mm"}).record
    assert tube.line.tube is not None and tube.line.valve == valve.line.valve
    assert edit_line(tube, takes={"tube": None}).record.line.tube is None


def test_comments_stay():
    text = "# mine\n" + load_line("choi2018").text.replace("[pump]", "[pump] # two")
    file = LineFile.read(text, "x")
    made = edit_line(file, {"chamber.volume": "5 mL", "polytropic": 1.1}).text
    assert "# mine" in made and "# two" in made


@pytest.mark.parametrize(
    ("change", "takes", "error", "words"),
    [
        ({"tube.length": "1 m"}, {}, FileError, "tube.bore .* missing"),
        ({"chamber.volume": "5 kPa"}, {}, QuantityError, "units of m"),
        ({"chamber.volume": "0 mL"}, {}, QuantityError, "not allowed"),
        ({"chamber.width": "1 m"}, {}, UnknownNameError, "key"),
        ({"leak.laminar": None}, {}, QuantityError, "change the value"),
        ({}, {"pump": "smc-vt307v"}, UnknownNameError, "part"),
        ({}, {"tube": "smc-vt307v"}, QuantityError, "unknown part family"),
        ({}, {"wheel": None}, UnknownNameError, "table"),
        ({}, {"pump": None}, FileError, "missing"),
        ({}, {"sensor": "honeywell-24pccfb6g"}, LayerjamError, "range"),
    ],
)
def test_what_is_refused(change, takes, error, words):
    with pytest.raises(error, match=words):
        edit_line("choi2018", change, takes=takes)


def test_every_number_of_a_line_can_be_set_to_what_it_is():
    whole = edit_line(
        "choi2018",
        {"tube.length": "1 m", "tube.bore": "3 mm", "reservoir.volume": "1 L",
         "reservoir.conductance": "0.2 L/(s bar)", "pump.power": "3 W"},
        takes={"valve": "smc-vt307v", "sensor": "nxp-mpx5100dp"},
    ).record  # fmt: skip
    same = edit_line(whole, {path: get(whole.line, path) for path in LINE_FIELDS}).record
    assert same.line == whole.line
    assert all(same.sources[path].kind == "assumed" for path in LINE_FIELDS)
