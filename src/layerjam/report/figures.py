"""Figures of single answers: what `--figure` of each command draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.validation.metrics import Validation
from layerjam.measure.trace import Trace
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.mechanics.friction import sheet_friction
from layerjam.mechanics.pull import brake_force
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
    from matplotlib.axes import Axes
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
    """Friction coefficient over travel of every repeat, with the reduced values.

    Shown are the kinetic window, where each repeat's static friction was taken, and the envelope
    of repeats that judder, these enlarged beside it.
    """
    found = [r.teeth for r in result.repeats if r.teeth is not None]
    count = len(result.repeats)
    with look():
        figure, places = canvas(columns=1 + bool(found), width=8.8 if found else 6.4)
        axes = places[0]
        start, end = (w * MM for w in result.window)
        for place in places:
            _friction_records(place, traces, result)
        highest = max(r.static for r in result.repeats)
        axes.axvspan(start, end, color="#f1f4f6", lw=0)
        axes.set(ylim=(0, highest * 1.22))
        label(axes, (start + end) / 2, highest * 0.05, "kinetic window", GREY, ha="center")
        ends = [(result.static, f"static {result.static:.4f}{_pm(result.static_sd)}", INK)]
        axes.axhline(result.static, color=INK, lw=1, ls=(0, (4, 3)))
        if result.kinetic is not None:
            word = "middle" if found else "kinetic"
            axes.plot([start, end], [result.kinetic] * 2, color=RED, lw=2)
            ends.append(
                (result.kinetic, f"{word} {result.kinetic:.4f}{_pm(result.kinetic_sd)}", RED)
            )
        if found:
            detail = f"{sum(r.teeth is not None for r in result.repeats)} of {count} stick and slip"
            ends += _envelope(places, result, (start, end))
        else:
            detail = result.standard.title
        which = "first maximum" if result.standard.first_maximum else "maximum"
        title(axes, f"Friction, {count} repeat{'s' * (count > 1)}", f"{_made(traces)}; {detail}")
        labels_right(axes, axes.get_xlim()[1], ends)
        label(axes, 0.03 * axes.get_xlim()[1], highest * 1.15, f"circle: {which} of a repeat", GREY)
    return figure


def _friction_records(axes: Axes, traces: Sequence[Trace], result: FrictionResult) -> None:
    """Every repeat as a coefficient over travel, with its static point."""
    for trace, one in zip(traces, result.repeats, strict=True):
        travel = np.abs(trace.elongation - trace.elongation[0]) * MM
        axes.plot(travel, trace.force / result.normal_force, color=SKY, lw=0.8)
        axes.plot(one.static_at * MM, one.static, "o", color=INK, ms=4, mfc="white", zorder=3)
    axes.set(xlabel="travel [mm]", ylabel="force / normal force [-]", xlim=(0, None))


def _envelope(
    places: Sequence[Axes], result: FrictionResult, span: tuple[float, float]
) -> list[tuple[float, str, str]]:
    """Ends of the stick-slip over the window, eight teeth enlarged; labels for the right side."""
    axes, zoom = places
    found = [r.teeth for r in result.repeats if r.teeth is not None]
    upper, lower = (
        float(np.mean([getattr(t, name) for t in found])) / result.normal_force
        for name in ("upper", "lower")
    )
    spacing = float(np.mean([t.spacing for t in found]))
    for place in places:
        for level in (upper, lower):
            place.plot(span, [level] * 2, color=ORANGE, lw=2)
    first = found[0].start * MM
    zoom.set(xlim=(first, first + 8 * spacing * MM), ylim=axes.get_ylim())
    zoom.set(ylabel="")
    title(zoom, "Eight teeth, enlarged", f"a slip every {show(spacing, 'm', 3)} of travel")
    return [
        (upper, f"upper end {upper:.4f}", "#8a5f00"),
        (lower, f"lower end {lower:.4f}", "#8a5f00"),
    ]


def _pm(sd: float | None) -> str:
    return "" if sd is None else f" ± {sd:.4f} SD"


def _made(traces: Sequence[Trace]) -> str:
    synthetic = any(t.facts.synthetic for t in traces)
    return "synthetic data, made by the virtual test machine" if synthetic else "measured"


def calibration(file: BrakeFile, result: Any, synthetic: bool) -> Figure:
    """The pulls, the fitted law with its bands and what is left between them, at any depth."""
    from layerjam.report import calibration_figure

    return calibration_figure.calibration(file, result, synthetic)


def validation(file: BrakeFile, result: Validation, synthetic: bool) -> Figure:
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
        words += ", synthetic data" if synthetic else ""
        title(axes, f"{file.name}: files (blue) and model (dashed)", words)
    return figure
