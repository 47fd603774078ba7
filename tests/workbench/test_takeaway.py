"""What charts give away: figures, curves, and Python that draws the same figure."""

from __future__ import annotations

import csv
import io
import json
import sys
import types

import pytest

from layerjam.brake.commands.tensile import tensile
from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.drawing.chart import Curve, Pane
from layerjam.core.errors import LayerjamError
from layerjam.workbench.answer import Answer, Pinned, build_notebook
from layerjam.workbench.call import Call, Subject, python_code
from layerjam.workbench.charts import chart_options
from layerjam.workbench.takeaway import curves_csv

KAPTON = "choi2018-kapton"


def pull(vacuum: str) -> Call:
    said = {"vacuum": vacuum, "speed": "1 mm/s", "elongation": "20 mm"}
    return Call("tensile", (Subject(KAPTON),), said)


def taken() -> Answer:
    high, low = pull("90 kPa"), pull("60 kPa")
    return Answer(high, high.run(), pins=(Pinned("60 kPa", Answer(low, low.run())),))


def test_the_copied_python_draws_the_figure_that_the_button_gives(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = taken()
    for _ in range(2):  # a second run writes the same figure again
        exec(shown.python_code(), {})
    assert (tmp_path / "tensile.svg").read_bytes() == shown.figure("svg")
    # the pinned curve is in it: without it the figure is another
    assert shown.figure("svg") != Answer(shown.call, shown.result).figure("svg")
    assert b"60 kPa" in shown.figure("svg")


def test_only_results_of_one_command_are_drawn_over_one_another():
    made = pull("60 kPa").run()
    with pytest.raises(LayerjamError, match="no curve to compare"):
        made.plot(beside={"a rise": rise("choi2018", target="60 kPa")})


def test_two_calls_of_a_command_write_two_figures_and_what_may_lack_a_curve_is_asked():
    text = python_code([pull("60 kPa"), pull("90 kPa")])
    assert '"tensile-1.svg"' in text and '"tensile-2.svg"' in text
    fall = Call("drop", (Subject(KAPTON),), {"mass": "1 kg", "speed": "1 m/s"})
    assert "if result.has_curve:\n    result.plot(" in python_code([fall])
    assert "plot" not in python_code([Call("tune", (Subject(KAPTON),))])


def test_the_curves_of_a_chart_read_back_and_hold_no_formula():
    low, high = tensile(KAPTON, **pull("60 kPa").options), tensile(KAPTON, **pull("90 kPa").options)
    curves = [
        Curve(r.record.elongation * 1e3, r.record.force, name=name)
        for r, name in ((low, "=cmd|' /C calc'!A0"), (high, "90 kPa"))
    ]
    below = Pane(curves[1:], "elongation [mm]", "residual [N]")
    chart = chart_options([Pane(curves, "elongation [mm]", "force [N]"), below])
    head, *rest = curves_csv(chart).splitlines()
    assert head.startswith("# layerjam")
    rows = list(csv.DictReader(io.StringIO("\n".join(rest))))
    assert {r["curve"] for r in rows} == {"'=cmd|' /C calc'!A0", "90 kPa"}
    assert {r["x axis"] for r in rows} == {"elongation [mm]"}
    top = max(float(r["y"]) for r in rows if r["curve"] == "90 kPa" and r["y axis"] == "force [N]")
    assert top == pytest.approx(high.peak_force, rel=1e-5)
    assert {r["y axis"] for r in rows} == {"force [N]", "residual [N]"}
    assert curves_csv({}) == ""


def run_cells(text: str, folder, monkeypatch) -> list[str]:
    """Run a notebook's cells in a folder, one after the other; the figures that it displays."""
    displayed: list[str] = []
    display = types.ModuleType("IPython.display")
    display.SVG, display.display = str, displayed.append
    monkeypatch.setitem(sys.modules, "IPython", types.ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.chdir(folder)
    space: dict[str, object] = {}
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), space)
    return displayed


def test_a_notebook_computes_and_draws_what_the_chart_shows(tmp_path, monkeypatch):
    shown = taken()
    book = json.loads(shown.notebook())
    assert (book["nbformat"], book["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in book["cells"]}) == len(book["cells"])
    for cell in book["cells"]:
        more = {"outputs", "execution_count"} if cell["cell_type"] == "code" else set()
        assert cell.keys() == {"cell_type", "id", "metadata", "source"} | more
        assert all(line.endswith("\n") for line in cell["source"][:-1])
    assert run_cells(shown.notebook(), tmp_path, monkeypatch) == ["tensile.svg"]
    assert (tmp_path / "tensile.svg").read_bytes() == shown.figure("svg")


def test_a_notebook_holds_the_brakes_that_are_in_no_catalogue(tmp_path, monkeypatch):
    # two of one name: the one on the desk, and a pinned one of before it was edited
    own = load(KAPTON).text + "\n# C:\\new 'one' \"two\" µ \U0001f9f2\n"
    files = [BrakeFile.read(text, "a brake") for text in (own, f"{own}# edited\n")]
    said = pull("60 kPa").options
    calls = [Call("tensile", (Subject("mine.toml", file),), said) for file in files]
    book = build_notebook("mine", calls)
    run_cells(book, tmp_path, monkeypatch)
    assert (tmp_path / "mine.toml").read_text("utf-8") == files[0].text
    assert (tmp_path / "mine-2.toml").read_text("utf-8") == files[1].text
    assert 'lj.tensile("mine-2.toml",' in "".join(json.loads(book)["cells"][-1]["source"])
