"""Figures of measured pulls: with their features, and with the model."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, FAINT, INK, MM, ORANGE, PURPLE, RED, SKY
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.pull.summary import PullSummary
from layerjam.laboratory.identify.validation.metrics import Validation
from layerjam.laboratory.measure.trace import Trace

save = style.save
MAX_PULLS = 12
"""Largest number of pulls drawn; more would overlap."""


@style.use_style
def draw_pulls(summaries: Sequence[tuple[Trace, PullSummary]]) -> style.Figure:
    """Draw force versus elongation of each pull from its onset, complete and around the peak.

    It marks the onset, the line of the stiffness, the peak, the plateau, the envelope of stick–slip
    and the slope of the unloading.
    """
    pairs = list(summaries)[:MAX_PULLS]
    figure, (axes, zoom) = style.make_axes(columns=2, width=10.4)
    for trace, summary in pairs:
        force = trace.force - (summary.tared or 0.0)
        for place in (axes, zoom):
            place.plot((trace.elongation - summary.start.onset) * MM, force, color=SKY, lw=1.2)
    for _, summary in pairs:
        _draw_marks(axes, zoom, summary)
    highest = max(float(summary.features.force.max()) for _, summary in pairs)
    zoom_end = 4 * max(summary.features.peak_elongation for _, summary in pairs) * MM
    zoom_start = max(max(summary.start.slack for _, summary in pairs) * MM, 0.05 * zoom_end)
    axes.set(ylim=(min(0, axes.get_ylim()[0]), highest * 1.35))
    zoom.set(xlim=(-1.1 * zoom_start, zoom_end), ylim=axes.get_ylim())
    for place in (axes, zoom):
        place.set(xlabel="elongation from the onset [mm]", ylabel="force [N]")
    count = len(summaries)
    words = Path(pairs[0][0].path).name if count == 1 else f"{count} files"
    words += f", the first {MAX_PULLS} drawn" if count > MAX_PULLS else ""
    origin = "synthetic data" if any(t.facts.synthetic for t, _ in pairs) else "measured"
    style.add_title(axes, "Pull" if count == 1 else "Pulls", f"{words}; {origin}")
    detail = "onset (ring), stiffness (orange), peak (red)"
    if count == 1:
        detail = "onset (ring), slope of the rise (orange)"
        _write_values(axes, zoom, pairs[0][1])
    style.add_title(zoom, "Around the peak", detail)
    return figure


def _draw_marks(axes: style.Axes, zoom: style.Axes, summary: PullSummary) -> None:
    features, start = summary.features, summary.start
    shift = start.onset - features.origin
    if features.straight:
        line = np.array([shift, features.peak_force / features.stiffness])
        zoom.plot((line - shift) * MM, features.stiffness * line, color=ORANGE, lw=1.4)
    style.add_point(zoom, 0.0, start.baseline, color=INK, mfc="white")
    if features.has_peak:
        for place in (axes, zoom):
            style.add_point(place, (features.peak_elongation - shift) * MM, features.peak_force)
    if summary.steady is not None:
        ends = np.array([summary.steady.start, summary.steady.end])
        height = summary.steady.force + summary.steady.slope * (ends - ends.mean())
        axes.plot((ends - shift) * MM, height, color=INK, lw=1.4, ls=style.LONG)
    if summary.teeth is not None:
        for tips in (summary.teeth.peaks, summary.teeth.troughs):
            x, y = features.elongation[tips], features.force[tips]
            axes.plot((x - shift) * MM, y, color=ORANGE, lw=1.0)
    end = summary.unloading
    if end is not None and end.stiffness is not None and end.residual_elongation is not None:
        foot, top = end.residual_elongation, start.baseline
        ends = np.array([foot, foot + (end.force_at_reversal - top) / end.stiffness])
        axes.plot(ends * MM, [top, end.force_at_reversal], color=PURPLE, lw=1.8)


def _write_values(axes: style.Axes, zoom: style.Axes, summary: PullSummary) -> None:
    features, start = summary.features, summary.start
    items = [(f"slack {show(start.slack, 'm', 3)}", INK)]
    items.append((f"preload {show(start.baseline, 'N', 3)}", INK))
    if features.straight:
        items.append((f"k = {show(features.stiffness, 'N/m')}", ORANGE))
    if features.has_peak:
        items.append((f"peak {show(features.peak_force, 'N')}", RED))
    style.add_key(zoom, *items, loc="lower right", handlelength=0)
    notes = []
    if summary.steady is not None:
        notes.append((f"dashed: {show(summary.steady.slope, 'N/m', 3)} after the peak", INK))
    if summary.teeth is not None:
        spacing = show(summary.teeth.spacing, "m", 3)
        words = f"stick–slip ± {show(summary.teeth.amplitude, 'N', 3)} every {spacing}"
        notes.append((words, ORANGE))
    if summary.ripple is not None:
        spacing = show(summary.ripple.spacing, "m", 3)
        notes.append((f"machine ripple, every {spacing}", INK))
    if summary.unloading is not None and summary.unloading.stiffness is not None:
        words = f"unloading {show(summary.unloading.stiffness, 'N/m', 3)}, loss "
        notes.append((words + show(summary.unloading.loop, "J", 3), PURPLE))
    if notes:
        style.add_key(axes, *notes, loc="upper right")


@style.use_style
def draw_validation(file: BrakeFile, result: Validation, synthetic: bool) -> style.Figure:
    """Draw measured and predicted curves over the comparison window, and their differences."""
    figure, (axes, residuals) = style.make_axes(
        rows=2, width=6.8, height=5.2, sharex=True, height_ratios=(2, 1)
    )
    ends = {}
    for curve in result.curves:
        x = curve.elongation * MM
        axes.plot(x, curve.measured, color=SKY, lw=3.2)
        axes.plot(x, curve.model, color=INK, lw=1.2, ls=style.DASHED)
        residuals.plot(x, curve.model - curve.measured, color=BLUE, lw=0.9)
        ends[show(curve.vacuum, "Pa")] = float(curve.model[-1])
    residuals.axhline(0, color=FAINT, lw=1)
    words = f"MAPE {result.mape:.2%}, RMSE {show(result.rmse, 'N', 3)}"
    words += f" over {count_text(len(result.curves), 'file')}" + ", synthetic data" * synthetic
    headline = f"{file.name}: files (light blue) and model (dashed)"
    style.label_axes(axes, headline, words, ylabel="force [N]", ylim=(0, None), xlim=(0, None))
    style.add_end_labels(axes, axes.get_xlim()[1], [(y, text, INK) for text, y in ends.items()])
    style.label_axes(residuals, xlabel="elongation [mm]", ylabel="model − file [N]")
    return figure
