"""Where numbers come from, as a file says it and as code asks for it."""

from __future__ import annotations

import pytest

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.toml_files.source import Source
from layerjam.workshop.design.robust import predict_design
from layerjam.workshop.design.specification import read_spec

KAPTON = load("choi2018-kapton")


def test_a_scatter_is_a_number_however_the_source_prints_it():
    assert KAPTON.sources["film.static"].sd == pytest.approx(0.0818, rel=1e-15)
    assert Source(spread="SD 0.02").sd is None and Source(spread="0.3 to 0.4").sd is None
    for source in (Source(sd=0.07), Source(spread="SD 8.18 % of 5"), Source(spread="x", sd=0.1)):
        assert Source.read({"value": 1, **source.to_toml()}, "film.static") == (1, source)


def test_an_sd_of_a_file_reaches_the_probabilities_of_a_design():
    text = KAPTON.text.replace('spread = "SD 8.18 %"', 'sd = "5 %"')
    mine = BrakeFile.read(text, "mine.toml")
    asked = read_spec(
        'brake = "mine.toml"\nobjectives = ["minimise mass"]', "x", {"mine.toml": mine}
    )
    unknowns = predict_design(asked, asked.grid.point(0), mine.name).unknowns
    sds = {u.names: u.root[0, 0] for u in unknowns if u.names[0].startswith("film.")}
    assert sds[("film.static",)] == pytest.approx(0.05, rel=1e-3)
    assert sds[("film.kinetic",)] == pytest.approx(0.0277, rel=1e-3)


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
