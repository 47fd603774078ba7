"""Figure of measured pulls with what was found in them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from layerjam.identify.pull.summary import PullSummary
from layerjam.measure.trace import Trace
from layerjam.report.style import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    canvas,
    label,
    look,
    save,
    title,
)
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["pulls", "save"]
MM = 1e3
MOST = 12
"""Pulls drawn; more lie over one another."""


def pulls(found: Sequence[tuple[Trace, PullSummary]]) -> Figure:
    """Force over elongation of each pull from its onset on, whole and around the peak.

    Marked are the onset, the line the stiffness is taken from, the peak, the steady part, the
    envelope of stick-slip and the slope of the way back.
    """
    drawn = list(found)[:MOST]
    with look():
        figure, (axes, zoom) = canvas(columns=2, width=8.8)
        for trace, one in drawn:
            for place in (axes, zoom):
                _record(place, trace, one)
        for _, one in drawn:
            _marks(axes, zoom, one)
        highest = max(float(one.features.force.max()) for _, one in drawn)
        near = 4 * max(one.features.peak_elongation for _, one in drawn) * MM
        back = max(max(one.start.slack for _, one in drawn) * MM, 0.05 * near)
        axes.set(xlabel="elongation from the onset [mm]", ylabel="force [N]")
        axes.set(ylim=(min(0, axes.get_ylim()[0]), highest * 1.15))
        zoom.set(xlabel="elongation from the onset [mm]", xlim=(-1.1 * back, near))
        zoom.set(ylim=axes.get_ylim())
        count = len(found)
        words = Path(drawn[0][0].path).name if count == 1 else f"{count} files"
        if count > MOST:
            words += f", the first {MOST} drawn"
        made = "synthetic data" if any(t.facts.synthetic for t, _ in drawn) else "measured"
        title(axes, "Pull" if count == 1 else "Pulls", f"{words}; {made}")
        title(zoom, "Around the peak", _what(drawn))
        if count == 1:
            _words(axes, zoom, drawn[0][1])
    return figure


def _record(axes: Axes, trace: Trace, one: PullSummary) -> None:
    shift = one.start.onset
    force = trace.force - (one.tared or 0.0)
    axes.plot((trace.elongation - shift) * MM, force, color=SKY, lw=1.2)


def _marks(axes: Axes, zoom: Axes, one: PullSummary) -> None:
    """Onset, rise, peak, steady part, envelope and way back of one pull."""
    features, start = one.features, one.start
    shift = start.onset - features.origin
    if features.straight:
        line = np.array([start.onset - features.origin, features.peak_force / features.stiffness])
        zoom.plot((line - shift) * MM, features.stiffness * line, color=ORANGE, lw=1.4)
    zoom.plot(0.0, start.baseline, "o", color=INK, mfc="white", ms=5, zorder=3)
    if features.has_peak:
        for place in (axes, zoom):
            place.plot(
                (features.peak_elongation - shift) * MM, features.peak_force, "o", color=RED, ms=5
            )
    if one.steady is not None:
        ends = np.array([one.steady.start, one.steady.end])
        height = one.steady.force + one.steady.slope * (ends - ends.mean())
        axes.plot((ends - shift) * MM, height, color=INK, lw=1.4, ls=(0, (5, 2)))
    if one.teeth is not None:
        _envelope(axes, one, shift)
    back = one.unloading
    if back is not None and back.stiffness is not None and back.residual_elongation is not None:
        foot, top = back.residual_elongation, start.baseline
        ends = np.array([foot, foot + (back.force_at_reversal - top) / back.stiffness])
        axes.plot(ends * MM, [top, back.force_at_reversal], color=PURPLE, lw=1.8)


def _envelope(axes: Axes, one: PullSummary, shift: float) -> None:
    """Lines through the upper and lower ends of the teeth."""
    features, teeth = one.features, one.teeth
    if teeth is None:
        return
    for places in (teeth.peaks, teeth.troughs):
        x, y = features.elongation[places], features.force[places]
        axes.plot((x - shift) * MM, y, color=ORANGE, lw=1.0)


def _what(drawn: Sequence[tuple[Trace, PullSummary]]) -> str:
    text = "onset (ring), stiffness (orange), peak (red)"
    return text if len(drawn) > 1 else "onset (ring), slope of the rise (orange)"


def _words(axes: Axes, zoom: Axes, one: PullSummary) -> None:
    """Numbers beside their marks, for a single pull."""
    features, start = one.features, one.start
    high = axes.get_ylim()[1]
    wide = zoom.get_xlim()[1]
    zoom_text = [f"slack {show(start.slack, 'm', 3)}", f"preload {show(start.baseline, 'N', 3)}"]
    if features.straight:
        zoom_text.append(f"k = {show(features.stiffness, 'N/m')}")
    label(zoom, wide * 0.45, high * 0.25, "\n".join(zoom_text), GREY)
    if features.has_peak:
        at = (features.peak_elongation + features.origin - start.onset) * MM
        label(zoom, at, features.peak_force + 0.05 * high, show(features.peak_force, "N"), RED,
              ha="left")  # fmt: skip
    far = axes.get_xlim()[1]
    notes = []
    if one.steady is not None:
        notes.append((f"dashed: {show(one.steady.slope, 'N/m', 3)} after the peak", INK))
    if one.teeth is not None:
        notes.append((f"stick-slip ± {show(one.teeth.amplitude, 'N', 3)} every "
                      f"{show(one.teeth.spacing, 'm', 3)}", "#8a5f00"))  # fmt: skip
    if one.unloading is not None and one.unloading.stiffness is not None:
        notes.append((f"way back {show(one.unloading.stiffness, 'N/m', 3)}, kept "
                      f"{show(one.unloading.loop, 'J', 3)}", "#8e4a79"))  # fmt: skip
    for row, (text, color) in enumerate(notes):
        label(axes, far * 0.97, high * (0.95 - 0.07 * row), text, color or BLUE, ha="right")
