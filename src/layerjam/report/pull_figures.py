"""Figure of measured pulls with what was found in them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from layerjam.identify.pull.summary import PullSummary
from layerjam.measure.trace import Trace
from layerjam.report import style
from layerjam.report.style import INK, MM, ORANGE, PURPLE, RED, SKY
from layerjam.units import show

save = style.save
MOST = 12
"""Pulls drawn; more lie over one another."""


@style.styled
def pulls(found: Sequence[tuple[Trace, PullSummary]]) -> style.Figure:
    """Force over elongation of each pull from its onset on, whole and around the peak.

    Marked are the onset, the line the stiffness is taken from, the peak, the steady part, the
    envelope of stick–slip and the slope of the way back.
    """
    drawn = list(found)[:MOST]
    figure, (axes, zoom) = style.canvas(columns=2, width=10.4)
    for trace, one in drawn:
        force = trace.force - (one.tared or 0.0)
        for place in (axes, zoom):
            place.plot((trace.elongation - one.start.onset) * MM, force, color=SKY, lw=1.2)
    for _, one in drawn:
        _marks(axes, zoom, one)
    highest = max(float(one.features.force.max()) for _, one in drawn)
    near = 4 * max(one.features.peak_elongation for _, one in drawn) * MM
    back = max(max(one.start.slack for _, one in drawn) * MM, 0.05 * near)
    axes.set(ylim=(min(0, axes.get_ylim()[0]), highest * 1.35))
    zoom.set(xlim=(-1.1 * back, near), ylim=axes.get_ylim())
    for place in (axes, zoom):
        place.set(xlabel="elongation from the onset [mm]", ylabel="force [N]")
    count = len(found)
    words = Path(drawn[0][0].path).name if count == 1 else f"{count} files"
    words += f", the first {MOST} drawn" if count > MOST else ""
    made = "synthetic data" if any(t.facts.synthetic for t, _ in drawn) else "measured"
    style.title(axes, "Pull" if count == 1 else "Pulls", f"{words}; {made}")
    what = "onset (ring), stiffness (orange), peak (red)"
    if count == 1:
        what = "onset (ring), slope of the rise (orange)"
        _words(axes, zoom, drawn[0][1])
    style.title(zoom, "Around the peak", what)
    return figure


def _marks(axes: style.Axes, zoom: style.Axes, one: PullSummary) -> None:
    """Onset, rise, peak, steady part, envelope and way back of one pull."""
    features, start = one.features, one.start
    shift = start.onset - features.origin
    if features.straight:
        line = np.array([shift, features.peak_force / features.stiffness])
        zoom.plot((line - shift) * MM, features.stiffness * line, color=ORANGE, lw=1.4)
    style.spot(zoom, 0.0, start.baseline, color=INK, mfc="white")
    if features.has_peak:
        for place in (axes, zoom):
            style.spot(place, (features.peak_elongation - shift) * MM, features.peak_force)
    if one.steady is not None:
        ends = np.array([one.steady.start, one.steady.end])
        height = one.steady.force + one.steady.slope * (ends - ends.mean())
        axes.plot((ends - shift) * MM, height, color=INK, lw=1.4, ls=style.LONG)
    if one.teeth is not None:
        for tips in (one.teeth.peaks, one.teeth.troughs):
            x, y = features.elongation[tips], features.force[tips]
            axes.plot((x - shift) * MM, y, color=ORANGE, lw=1.0)
    back = one.unloading
    if back is not None and back.stiffness is not None and back.residual_elongation is not None:
        foot, top = back.residual_elongation, start.baseline
        ends = np.array([foot, foot + (back.force_at_reversal - top) / back.stiffness])
        axes.plot(ends * MM, [top, back.force_at_reversal], color=PURPLE, lw=1.8)


def _words(axes: style.Axes, zoom: style.Axes, one: PullSummary) -> None:
    """Numbers of a single pull, in the colours of their marks."""
    features, start = one.features, one.start
    near = [(f"slack {show(start.slack, 'm', 3)}", INK)]
    near.append((f"preload {show(start.baseline, 'N', 3)}", INK))
    if features.straight:
        near.append((f"k = {show(features.stiffness, 'N/m')}", ORANGE))
    if features.has_peak:
        near.append((f"peak {show(features.peak_force, 'N')}", RED))
    style.key(zoom, *near, at="lower right", handlelength=0)
    notes = []
    if one.steady is not None:
        notes.append((f"dashed: {show(one.steady.slope, 'N/m', 3)} after the peak", INK))
    if one.teeth is not None:
        spacing = show(one.teeth.spacing, "m", 3)
        words = f"stick–slip ± {show(one.teeth.amplitude, 'N', 3)} every {spacing}"
        notes.append((words, ORANGE))
    if one.unloading is not None and one.unloading.stiffness is not None:
        words = f"way back {show(one.unloading.stiffness, 'N/m', 3)}, kept "
        notes.append((words + show(one.unloading.loop, "J", 3), PURPLE))
    if notes:
        style.key(axes, *notes, at="upper right")
