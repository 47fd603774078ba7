"""Figures of single answers: what `--figure` of each command draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.identify.fit import Calibration
from layerjam.identify.friction_test import FrictionResult
from layerjam.identify.metrics import Validation
from layerjam.identify.trace import Trace
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.mechanics.friction import sheet_friction
from layerjam.mechanics.pull import brake_force, force_at_elongation
from layerjam.report.style import (
    BLUE,
    FAINT,
    GREY,
    INK,
    ORANGE,
    RED,
    SKY,
    canvas,
    label,
    labels_right,
    look,
    save,
    title,
)
from layerjam.simulate.record import TensileRecord
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "calibration", "force_over_slip", "force_over_vacuum", "friction", "save", "tensile",
    "validation",
]  # fmt: skip
MM = 1e3


def force_over_slip(file: BrakeFile, vacuum: float, slip: float) -> Figure:
    """Force of the sliding brake over its travel at one vacuum, parts stacked."""
    brake = file.brake
    x = np.linspace(0, brake.sheets.overlap, 400)
    sheets = np.asarray(sheet_friction(x, vacuum, brake))
    total = np.asarray(brake_force(x, vacuum, brake))
    with look():
        figure, (axes,) = canvas()
        axes.fill_between(x * MM, 0, sheets, color=BLUE, alpha=0.16, lw=0)
        axes.fill_between(x * MM, sheets, total, color=ORANGE, alpha=0.35, lw=0)
        axes.plot(x * MM, total, color=INK)
        here = float(brake_force(slip, vacuum, brake))
        axes.plot(slip * MM, here, "o", color=RED, ms=6)
        label(axes, slip * MM + 1.2, here * 1.05, show(here, "N"), RED, weight="bold")
        axes.axvline(brake.sheets.usable_travel * MM, color=GREY, lw=0.9, ls=(0, (4, 3)))
        top = axes.get_ylim()[1]
        label(axes, brake.sheets.usable_travel * MM, top * 0.95, "usable travel ", GREY, ha="right")
        label(axes, 3, sheets[0] * 0.35, "sheets", BLUE)
        last = float(enclosure_force(x[300], vacuum, brake))
        label(axes, x[300] * MM, sheets[300] + last / 2, "sleeve", "#8a5f00", ha="center")
        axes.set(
            xlabel="slip of the sheets [mm]", ylabel="force [N]", xlim=(0, None), ylim=(0, top)
        )
        title(axes, f"{file.name} sliding at {show(vacuum, 'Pa')}", "computed")
    return figure


def force_over_vacuum(file: BrakeFile, slip: float, wanted: float, vacuum: float) -> Figure:
    """Force at one slip over the vacuum, with the force wanted."""
    brake = file.brake
    pressure = np.linspace(0, brake.site.atmosphere, 400)
    force = np.asarray(brake_force(slip, pressure, brake))
    with look():
        figure, (axes,) = canvas()
        axes.plot(pressure / 1e3, force, color=BLUE)
        axes.axhline(wanted, color=GREY, lw=1, ls=(0, (4, 3)))
        label(axes, 1.5, wanted, f"wanted {show(wanted, 'N')}", GREY, va="bottom")
        if np.isfinite(vacuum):
            axes.plot(vacuum / 1e3, wanted, "o", color=RED, ms=6)
            label(
                axes, vacuum / 1e3 - 1.5, wanted * 1.06, show(vacuum, "Pa"), RED, ha="right",
                weight="bold",
            )  # fmt: skip
        axes.set(xlabel="vacuum [kPa]", ylabel="force [N]", xlim=(0, None), ylim=(0, None))
        title(axes, f"{file.name} at {show(slip, 'm')} of slip", "computed")
    return figure


def tensile(record: TensileRecord) -> Figure:
    """Force over elongation of a simulated pull."""
    top = int(np.argmax(record.force))
    with look():
        figure, (axes,) = canvas()
        axes.plot(record.elongation * MM, record.force, color=BLUE)
        axes.plot(record.elongation[top] * MM, record.force[top], "o", color=RED, ms=5)
        peak = (
            f"{show(float(record.force[top]), 'N')} at {show(float(record.elongation[top]), 'm')}"
        )
        wide = float(record.elongation.max()) * MM
        label(
            axes, record.elongation[top] * MM + 0.02 * wide, record.force[top] * 1.01, peak, RED,
            va="bottom",
        )  # fmt: skip
        axes.set(
            xlabel="elongation at the crosshead [mm]", ylabel="force [N]", xlim=(0, None),
            ylim=(0, float(record.force.max()) * 1.12 + 1e-9),
        )  # fmt: skip
        first = record.procedure if len(record.procedure) < 66 else record.procedure[:63] + "..."
        title(axes, f"{record.brake.name}: {record.outcome}", f"simulated, {record.model}; {first}")
    return figure


def friction(traces: Sequence[Trace], result: FrictionResult) -> Figure:
    """Friction coefficient over travel of every repeat, with the reduced values."""
    with look():
        figure, (axes,) = canvas()
        start, end = (w * MM for w in result.window)
        axes.axvspan(start, end, color="#f1f4f6", lw=0)
        for trace in traces:
            travel = np.abs(trace.elongation - trace.elongation[0]) * MM
            axes.plot(travel, trace.force / result.normal_force, color=SKY, lw=0.8)
        far = axes.get_xlim()[1]
        axes.plot([start, end], [result.kinetic] * 2, color=RED, lw=2)
        label(
            axes, (start + end) / 2, result.kinetic * 1.12,
            f"kinetic {result.kinetic:.4f}{_pm(result.kinetic_sd)}", RED, ha="center",
        )  # fmt: skip
        axes.axhline(result.static, color=INK, lw=1, ls=(0, (4, 3)))
        words = f"static {result.static:.4f}{_pm(result.static_sd)} (maximum of each repeat)"
        label(axes, end, result.static, words, INK, ha="right", va="bottom")
        axes.set(
            xlabel="travel [mm]", ylabel="force / normal force [-]", xlim=(0, far),
            ylim=(0, result.static * 1.25),
        )  # fmt: skip
        title(axes, f"Friction, {len(result.repeats)} repeats", _made(traces))
    return figure


def _pm(sd: float | None) -> str:
    return "" if sd is None else f" ± {sd:.4f} SD"


def _made(traces: Sequence[Trace]) -> str:
    synthetic = any(t.facts.synthetic for t in traces)
    return "synthetic data, made by the virtual test machine" if synthetic else "measured"


def calibration(file: BrakeFile, result: Calibration) -> Figure:
    """The pulls, the straight line that gave k, the peaks, and the calibrated law."""
    from dataclasses import replace

    fitted = replace(
        file.brake, scale_factor=result.scale_factor, stiffness_measured=result.stiffness
    )
    with look():
        figure, (axes, zoom) = canvas(columns=2, width=8.6)
        for one in result.fits:
            for place in (axes, zoom):
                place.plot(one.pull.elongation * MM, one.pull.force, color=SKY, lw=3.0)
        ends = []
        for vacuum in sorted({one.vacuum for one in result.fits}, reverse=True):
            far = max(one.pull.elongation[-1] for one in result.fits if one.vacuum == vacuum)
            u = np.linspace(0, far, 2000)
            law = np.asarray(force_at_elongation(u, vacuum, fitted))
            for place in (axes, zoom):
                place.plot(u * MM, law, color=INK, lw=1.2, ls=(0, (5, 2)))
            ends.append((float(law[-1]), show(vacuum, "Pa"), INK))
        for one in result.fits:
            zoom.plot(one.pull.peak_elongation * MM, one.pull.peak_force, "o", color=RED, ms=5)
        peak = max(one.pull.peak_elongation for one in result.fits)
        near = 4 * peak * MM
        line = np.array([0, peak])
        zoom.plot(line * MM, result.stiffness * line, color=ORANGE, lw=1.5)
        highest = max(one.pull.peak_force for one in result.fits)
        zoom.set(xlim=(0, near), ylim=(0, highest * 1.15), xlabel="elongation [mm]")
        axes.set(
            xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, None), ylim=(0, highest * 1.15)
        )
        labels_right(axes, axes.get_xlim()[1], ends)
        title(
            axes,
            "Pulls (blue) and calibrated law (dashed)",
            f"{file.name}, {len(result.fits)} pull{'s' * (len(result.fits) > 1)}",
        )
        words = f"k = {show(result.stiffness, 'N/m')}, a = {result.scale_factor:.4g}"
        title(zoom, "Near the peak", words)
        label(zoom, near * 0.42, highest * 0.35, "slope k (orange)\nfitted peak (red)", GREY)
    return figure


def validation(file: BrakeFile, result: Validation) -> Figure:
    """Measured and predicted curves over the comparison window, and what is left between them."""
    with look():
        figure, (axes, rest) = canvas(
            rows=2, width=6.8, height=5.2, sharex=True, gridspec_kw={"height_ratios": [2, 1]}
        )
        for curve in result.curves:
            x = curve.elongation * MM
            axes.plot(x, curve.measured, color=SKY, lw=3.2)
            axes.plot(x, curve.model, color=INK, lw=1.2, ls=(0, (5, 2)))
            rest.plot(x, curve.model - curve.measured, color=BLUE, lw=0.9)
        ends = {
            show(c.vacuum, "Pa"): (float(c.model[-1]), float(c.elongation[-1]))
            for c in result.curves
        }
        axes.set(ylabel="force [N]", ylim=(0, None), xlim=(0, None))
        labels_right(axes, axes.get_xlim()[1], [(y, text, INK) for text, (y, _) in ends.items()])
        rest.axhline(0, color=FAINT, lw=1)
        rest.set(xlabel="elongation [mm]", ylabel="model − file [N]")
        words = f"MAPE {result.mape:.2%}, RMSE {show(result.rmse, 'N', 3)}"
        words += f" over {len(result.curves)} files"
        title(axes, f"{file.name}: files (blue) and model (dashed)", words)
    return figure
