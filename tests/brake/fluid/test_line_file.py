"""A line's file: the catalogue, and what is refused with the line it stands on."""

from __future__ import annotations

import pytest

from layerjam.brake.fluid.line_file import LineFile, lines, load_line
from layerjam.core.errors import FileError, UnknownNameError

LEAST = 'name = "mine"\n[chamber]\nvolume = "8 mL"\n[pump]\nflow = "2 mL/s"\n'


def test_the_catalogue_loads_and_says_what_is_inferred():
    for name in lines():
        file = load_line(name)
        assert file.name == name
    assert "inferred" in load_line("choi2018").warnings()[0]


def test_the_least_file():
    line = LineFile.read(LEAST, "mine.toml").line
    assert (line.chamber.volume, line.pump.flow, line.pump.count) == (8e-6, 2e-6, 1)
    assert line.valve is None and line.leak.laminar == 0.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('name = "mine"\n[chamber]\nvolume = "8 mL"\n', "pump.flow .* is missing"),
        (LEAST + 'flows = "2 mL/s"\n', "line 6: unknown key 'pump.flows'"),
        (LEAST + 'ultimate = "5 mL"\n', "line 6: .*'5 mL'"),
        (LEAST + 'ultimate = "102 kPa"\n', "line 6: pump.ultimate: 102 kPa is not below"),
        (LEAST + "count = 1.5\n", "an integer"),
        (LEAST + '[valve]\ndelay = "1 s"\n', "valve.conductance .* is missing"),
        (LEAST.replace("8 mL", "-8 mL"), "line 3: chamber.volume: -8 mL"),
        (LEAST.replace('flow = "2 mL/s"', "flow = 2"), "line 5: .* has no unit"),
        (
            LEAST.replace('"8 mL"', '"8 mL"\nshrink = "0.1 mL/kPa"'),
            "chamber.shrink: .* would be lost",
        ),
        ("name = 3\n" + LEAST[14:], "name"),
    ],
)
def test_what_is_refused(text, words):
    with pytest.raises(FileError, match=words):
        LineFile.read(text, "mine.toml")


def test_unknown_lines_and_files(tmp_path):
    with pytest.raises(UnknownNameError, match="choi2018"):
        load_line("choi2019")
    with pytest.raises(FileError, match="cannot be read"):
        load_line(tmp_path / "no.toml")
