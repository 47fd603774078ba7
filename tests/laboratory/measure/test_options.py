"""The [read] table of a sidecar: how to read its file, in the words of the commands' options."""

from __future__ import annotations

import pytest

from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.commands.pull import pull
from layerjam.laboratory.measure.options import ReadingOptions, load_reading_options
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import read_facts

FORCE = [min(7.0 * i, 175 - i) for i in range(60)]


@pytest.fixture
def file(tmp_path):
    """Columns without names, the force in kN and counted negative."""
    path = tmp_path / "pull.csv"
    lines = [f"{i};{-f / 1e3:.6f};{i / 10:.2f}\n" for i, f in enumerate(FORCE)]
    path.write_text("".join(lines), encoding="utf-8")
    return path


def beside(file, text):
    file.with_name(file.name + ".toml").write_text(text, encoding="utf-8")


READ = '[read]\ncolumns = "skip,force:kN,elongation:mm"\nnegative = ["force"]\n'


def test_a_file_is_read_as_its_sidecar_says(file):
    with pytest.raises(FileError, match="--columns"):
        read_trace(file)
    beside(file, 'vacuum = "40 kPa"\n' + READ)
    trace = read_trace(file)
    assert trace.force.max() == pytest.approx(max(FORCE))
    assert trace.facts.vacuum == 40e3
    assert "[read] of its sidecar" in trace.understood[-1]
    assert pull([file]).understood == {str(file): list(trace.understood)}


def test_it_gives_the_same_as_the_options(file):
    said = ReadingOptions(negative=["force"], columns="skip,force:kN,elongation:mm")
    by_options = read_trace(file, said)
    beside(file, READ)
    by_sidecar = read_trace(file)
    assert (by_options.force == by_sidecar.force).all()
    assert (by_options.elongation == by_sidecar.elongation).all()


def test_what_is_given_with_the_command_counts(file):
    beside(file, READ)
    given = ReadingOptions(columns="skip,force:N,elongation:mm")
    assert read_trace(file, given).force.max() == pytest.approx(max(FORCE) / 1e3)
    assert given.over(ReadingOptions(decimal=",")).decimal == ","
    assert ReadingOptions(decimal=".").over(ReadingOptions(decimal=",")).decimal == "."
    assert ReadingOptions().over(given) == given


@pytest.mark.parametrize("text", [
    "read = 3", "[read]\nunit = 'N'", "[read]\nnegative = 3", "[read]\ndecimal = ';'",
    "[read]\nspecimen = true", "[read]\nspecimen = 0", "[read]\ncolumn = ['force']",
    "[read]\nnegative = 'torque'", "[read]\ncolumns = 'force:mm,elongation:mm'",
])  # fmt: skip
def test_an_answer_that_is_none_is_refused_with_the_sidecars_name(file, text):
    beside(file, text)
    with pytest.raises(LayerjamError, match=r"pull\.csv\.toml"):
        read_trace(file)


def test_facts_do_not_hold_the_answers_and_stay_strict(file):
    beside(file, READ)
    assert read_facts(file).vacuum is None
    assert load_reading_options(file).negative == ("force",)
    beside(file, "reed = 3\n")
    with pytest.raises(FileError, match="reed"):
        read_facts(file)
