"""The figure of a result and its chart on the page are drawn from one description."""

from __future__ import annotations

import json

import numpy as np
import pytest

from layerjam.bench.commands.regulate import regulate
from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.commands.vacuum_line import rise
from layerjam.core.drawing.chart import Curve, Pane, add_comparisons, draw_panes
from layerjam.core.drawing.style import GREY
from layerjam.workbench.charts import chart_options

KAPTON = "choi2018-kapton"
RESULTS = {
    "pull": lambda: tensile(KAPTON, vacuum="60 kPa", speed="1 mm/s", travel="30 mm"),
    "rise": lambda: rise("choi2018", target="80 kPa"),
    "regulator": lambda: regulate(
        "choi2018", target="60 kPa", safe_state="release", sensor_range="103 kPa", duration="6 s"
    ),
}


@pytest.mark.parametrize("name", RESULTS)
def test_figure_and_page_show_the_same_curves_axes_and_ends(name):
    result = RESULTS[name]()
    figure, chart = result.draw(), chart_options(result.panes())
    json.dumps(chart, allow_nan=False)
    for place, axes in enumerate(figure.axes[: len(chart["grid"])]):
        series = [one for one in chart["series"] if one["yAxisIndex"] == place]
        series = [one for one in series if one["lineStyle"]["width"]]  # a band has no line
        lines = axes.get_lines()[: len(series)]
        assert axes.get_ylabel() == chart["yAxis"][place]["name"]
        assert axes.get_ylim()[1] == pytest.approx(chart["yAxis"][place]["max"])
        for line, one in zip(lines, series, strict=True):
            x, y = np.array(one["data"], float).T
            # every point that the browser gets is one of the figure's, to six digits
            known = np.column_stack(line.get_data()) / np.ptp(
                line.get_data(), axis=1, keepdims=True
            ).T.clip(1e-9)
            sent = np.column_stack((x, y)) / np.ptp(line.get_data(), axis=1, keepdims=True).T.clip(
                1e-9
            )
            assert max(np.abs(known - point).max(1).min() for point in sent[::25]) < 1e-4
    below = figure.axes[len(chart["grid"]) - 1]
    assert below.get_xlabel() == chart["xAxis"][-1]["name"]


def test_a_crash_lies_within_the_axes_of_its_figure():
    """The axes once ended where the travel did, and the crash was outside."""
    fall = drop(KAPTON, mass="1 kg", speed="2.5 m/s", vacuum="5 kPa", rope_stiffness="16.8 kN/m")
    for axes in fall.draw().axes:
        for line in axes.get_lines():
            x, y = line.get_data()
            assert np.max(x) <= axes.get_xlim()[1] and np.max(y) <= axes.get_ylim()[1]


def test_curves_beside_are_quiet_named_once_and_widen_the_axes():
    own = [Pane([Curve([0, 1], [0, 2])], "x [s]", y, (0, 1), (0, 2)) for y in ("a [N]", "b [m]")]
    first, second = add_comparisons(own, {"other": [Curve([0, 3], [0, 5]), Curve([0, 3], [0, 1])]})
    quiet = first.curves[1]
    assert (quiet.color, quiet.name, quiet.labelled) == (GREY, "other", True)
    assert not second.curves[1].labelled
    assert first.x_range == (0, 3) and first.y_range[1] > 5 and second.y_range == (0, 2)
    words = [text.get_text() for axes in draw_panes([first, second]).axes for text in axes.texts]
    assert words == ["other"]


def test_names_at_ends_on_each_other_are_set_apart_in_every_pane():
    curves = [Curve([0, 1], [0, 60], name=name) for name in ("vacuum", "sensor", "target")]
    panes = [Pane(curves, "time [s]", y, (0, 1), (0, 69)) for y in ("a [kPa]", "b [kPa]")]
    series = chart_options(panes)["series"]
    for pane in (series[:3], series[3:]):
        shifts = sorted(one["endLabel"]["offset"][1] for one in pane)
        assert np.diff(shifts).min() >= 12  # the size of the words [pixels]
