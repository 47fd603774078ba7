"""Where numbers come from, as a file says it and as code asks for it."""

from __future__ import annotations

import pytest

from layerjam.design.specification import read_spec
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.errors import FileError, QuantityError
from layerjam.toml_files.source import Source

KAPTON = load("choi2018-kapton")


def test_a_scatter_is_a_number_however_the_source_prints_it():
    assert KAPTON.sources["film.static"].sd == pytest.approx(0.0818, rel=1e-15)
    assert Source(spread="SD 0.02").sd is None and Source(spread="0.3 to 0.4").sd is None
    for source in (Source(sd=0.07), Source(spread="SD 8.18 % of 5"), Source(spread="x", sd=0.1)):
        assert Source.read({"value": 1, **source.to_toml()}, "film.static") == (1, source)


def test_an_sd_of_a_file_reaches_the_robustness_of_a_design():
    text = KAPTON.text.replace('spread = "SD 8.18 %"', 'sd = "5 %"')
    mine = BrakeFile.read(text, "mine.toml")
    asked = read_spec(
        'brake = "mine.toml"\nobjectives = ["minimise mass"]', "x", {"mine.toml": mine}
    )
    assert asked.scatter.static == 0.05 and asked.scatter.kinetic == pytest.approx(0.0277)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('{ value = 0.3, sd = "5 mm" }', "a pure number"),
        ("{ value = 0.3, sd = -0.1 }", "not allowed"),
        ("{ value = 0.3, source = 3 }", "must be text"),
        ("{ sd = 0.1 }", "has no value"),
    ],
)
def test_what_is_no_source_is_refused_with_its_line(table, words):
    lines = KAPTON.text.splitlines()
    number = next(i for i, line in enumerate(lines) if line.startswith("static ="))
    lines[number] = f"static = {table}"
    with pytest.raises(FileError, match=words) as caught:
        BrakeFile.read("\n".join(lines), "mine.toml")
    assert caught.value.line == number + 1


def test_an_entry_holds_nothing_else():
    with pytest.raises(QuantityError, match="has the unknown key units"):
        Source.read({"value": 1, "units": "m"}, "x")
