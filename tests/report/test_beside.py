"""Figures from a second process: the same bytes, whatever happens to it, and nothing left of it."""

from __future__ import annotations

import io
import pickle
import subprocess
import sys
from typing import Any

import pytest

from layerjam.report import beside, style
from layerjam.report.beside import FEW, DrawingProcess


@style.in_style
def figure(slope: float, names: Any = None) -> style.Figure:
    made, (axes,) = style.canvas()
    axes.plot([0, 1], [0, slope])
    style.panel(axes, "A line", "and its slope", xlabel="x [m]", ylabel="y [N]")
    if names is not None:
        axes.xaxis.set_major_formatter(names)
    return made


def by_matplotlib(made: style.Figure) -> str:
    """As `savefig` writes it, which lays out first and draws then."""
    buffer = io.StringIO()
    with style.look():
        made.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "cores", lambda: 2)


def process_of(drawing: DrawingProcess) -> subprocess.Popen[bytes]:
    assert drawing._process is not None
    return drawing._process


def test_a_parent_that_takes_an_old_address_hides_no_other() -> None:
    """Each transform of a figure that was sent knows its parents by their own addresses."""
    made = figure(1.0)
    line = made.axes[0].lines[0]
    sent = pickle.loads(beside._pickle_figure(made))
    for node in (sent.axes[0].bbox, sent.axes[0].transData, sent.axes[0].lines[0].get_clip_box()):
        assert all(key == id(parent()) for key, parent in node._parents.items())
    assert len(sent.axes[0].bbox._parents) == len(made.axes[0].bbox._parents) > 0
    sent.axes[0].set_position((0.5, 0.5, 0.25, 0.25))
    assert sent.axes[0].lines[0].get_clip_box().width < 0.5 * line.get_clip_box().width


@pytest.mark.usefixtures("two_cores")
def test_the_same_bytes_in_order() -> None:
    slopes = [1.0, -2.0, 3.0, 4.0]
    with DrawingProcess(FEW) as drawing:
        for slope in slopes:
            drawing.post(figure(slope))
        drawing.post(figure(5.0, lambda value, _: f"{value:.3f}"))  # no pickle takes it
        there = [asked.result() for _, asked in drawing._posted]
        texts = drawing.collect()
    assert there == texts, "drawn here what the other process should have drawn"
    expected = [by_matplotlib(figure(slope)) for slope in slopes]
    assert texts[:4] == expected and len(set(texts)) == 5
    assert texts[4] == by_matplotlib(figure(5.0, lambda value, _: f"{value:.3f}"))
    assert process_of(drawing).returncode is not None


@pytest.mark.usefixtures("two_cores")
def test_a_process_that_dies_costs_no_figure() -> None:
    with DrawingProcess(FEW) as drawing:
        process_of(drawing).kill()
        for slope in (1.0, 2.0):
            drawing.post(figure(slope))
        texts = drawing.collect()
    assert texts == [by_matplotlib(figure(slope)) for slope in (1.0, 2.0)]


@pytest.mark.usefixtures("two_cores")
def test_an_interrupt_leaves_no_process() -> None:
    with pytest.raises(KeyboardInterrupt), DrawingProcess(FEW) as drawing:
        drawing.post(figure(1.0))
        raise KeyboardInterrupt
    assert process_of(drawing).returncode is not None


def test_few_figures_or_one_core_are_drawn_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "_start", lambda: pytest.fail("a process was started"))
    with DrawingProcess(FEW - 1) as drawing:
        drawing.post(figure(1.0))
        assert drawing.collect() == [by_matplotlib(figure(1.0))]
    monkeypatch.setattr(beside, "cores", lambda: 1)
    with DrawingProcess(50):
        pass


@pytest.mark.usefixtures("two_cores")
def test_what_warns_is_drawn_again_where_it_is_heard() -> None:
    with DrawingProcess(FEW) as drawing:
        drawing.post(figure(1.0, lambda value, _: ""))
        made = figure(1.0)
        made.axes[0].set_title("\u9802")  # no glyph of the typeface
        drawing.post(made)
        with pytest.warns(UserWarning, match="missing from font"):
            drawing.collect()


def test_the_other_process_loads_no_computation() -> None:
    code = (
        "import sys, layerjam.report.beside; "
        "print([m for m in ('jax', 'pandas', 'scipy', 'xarray') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
