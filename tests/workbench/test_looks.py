"""Numbers as they are printed, ends of axes, and colours of figures on a light and a dark page."""

from __future__ import annotations

import re
from importlib.resources import files

import pytest

from layerjam.core.drawing.chart import Curve, Pane
from layerjam.workbench.charts import MOST_ROOM, chart_options
from layerjam.workbench.tables import html_table, typeset_symbols
from layerjam.workbench.widgets import read_asset


@pytest.mark.parametrize(
    ("plain", "printed"),
    [
        ("0.01285 m^2", "0.01285 m²"),
        ("9.81 m/s^2", "9.81 m/s²"),
        ("10 W/(m^2 K)", "10 W/(m² K)"),
        ("3 (N s)^-1", "3 (N s)⁻¹"),
        ("1.2e+07 N/m", "1.2 × 10⁷ N/m"),
        ("4e-12", "4 × 10⁻¹²"),
        ("12.3 kN", "12.3 kN"),
        ("choi2018-kapton", "choi2018-kapton"),
        ("run 3e2b.csv", "run 3e2b.csv"),
    ],
)
def test_numbers_are_printed_with_raised_figures(plain, printed):
    assert typeset_symbols(plain) == printed


def test_only_columns_of_numbers_are_printed_so():
    made = html_table(("", "Value"), [("film^2", "2 m^2")], (1,))
    assert "film^2" in made and "2 m²" in made
    assert '<th scope="col"></th>' not in made  # a head without words is none


def test_an_axis_ends_with_a_number_only_where_that_is_round():
    made = chart_options([Pane([Curve([0, 38.6153674], [0, 47.2])], "x", "y", (0, 38.6153674))])
    assert made["xAxis"][0]["axisLabel"]["showMaxLabel"] is False
    assert made["xAxis"][0]["axisLabel"]["showMinLabel"] is True
    assert made["yAxis"][0]["axisLabel"]["showMaxLabel"] is None  # the browser chooses its own


def test_names_have_their_room_and_no_more():
    def room(*names):
        curves = [Curve([0, 1], [0, 1], name=name) for name in names]
        return chart_options([Pane(curves, "x", "y")])["grid"][0]["right"]

    assert room("") < room("mass") < room("mass", "a longer name") < room("x" * 80) == MOST_ROOM


def names_of(block):
    return set(re.findall(r"--(\w+):", block))


def test_every_colour_of_a_figure_has_a_light_and_a_dark_shade():
    page = files("layerjam.core.drawing").joinpath("page.css").read_text("utf-8")
    drawn = set(re.findall(r"--(\w+):#[0-9a-f]{6}", page.split("}")[0]))
    css = read_asset("workbench.css")
    light, dark = (
        re.search(rf"^{head} {{(.*?)}}", css, re.M | re.S)[1]
        for head in (r"\.figure", r"\.body--dark \.figure")
    )
    assert drawn <= names_of(light)
    assert drawn - {"ground"} <= names_of(dark)
