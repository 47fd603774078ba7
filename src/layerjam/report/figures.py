"""Figures of single results, drawn by the `--figure` option of each command."""

from collections.abc import Sequence

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.errors import count_text
from layerjam.identify.friction.envelope import StickSlip
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.validation.metrics import Validation
from layerjam.measure.trace import Trace
from layerjam.mechanics.friction import sheet_friction
from layerjam.mechanics.pull import brake_force
from layerjam.report import calibration_figure, style
from layerjam.report.style import BLUE, FAINT, INK, KPA, MM, ORANGE, RED, SKY
from layerjam.units import show

calibration = calibration_figure.draw_calibration


@style.use_style
def plot_force_slip(file: BrakeFile, vacuum: float, slip: float) -> style.Figure:
    """Draw the sliding brake's force versus slip at one vacuum, divided into its components."""
    brake = file.brake
    x = np.linspace(0, brake.sheets.overlap, 400)
    sheets, total = (np.asarray(law(x, vacuum, brake)) for law in (sheet_friction, brake_force))
    figure, (axes,) = style.make_axes()
    style.add_band(axes, x * MM, 0, sheets, BLUE, 0.16)
    style.add_band(axes, x * MM, sheets, total, ORANGE, 0.35)
    axes.plot(x * MM, total, color=INK)
    top = 1.3 * float(total.max()) or 1.0
    axes.set(xlabel="sheet slip [mm]", ylabel="force [N]", xlim=(0, None), ylim=(0, top))
    style.mark_x(axes, brake.sheets.usable_travel * MM, "usable travel")
    force = float(brake_force(slip, vacuum, brake))
    style.add_point(axes, slip * MM, force, show(force, "N"))
    style.add_key(axes, ("sheets", BLUE), ("enclosure", ORANGE), loc="upper left", ncols=2)
    style.add_title(axes, f"{file.name} sliding at {show(vacuum, 'Pa')}", "computed")
    return figure


@style.use_style
def plot_force_vacuum(file: BrakeFile, slip: float, target: float, vacuum: float) -> style.Figure:
    """Draw the force at one slip versus vacuum, with the target force."""
    brake = file.brake
    pressure = np.linspace(0, brake.site.atmosphere, 400)
    figure, (axes,) = style.make_axes()
    force = np.asarray(brake_force(slip, pressure, brake))
    axes.plot(pressure * KPA, force, color=BLUE)
    axes.set(xlabel="vacuum [kPa]", ylabel="force [N]", xlim=(0, None))
    axes.set_ylim(0, 1.12 * max(float(force.max()), target))
    style.mark_y(axes, target, f"required {show(target, 'N')}")
    if np.isfinite(vacuum):
        style.mark_x(axes, vacuum * KPA, show(vacuum, "Pa"), RED, share=0.03)
        style.add_point(axes, vacuum * KPA, target)
    style.add_title(axes, f"{file.name} at a slip of {show(slip, 'm')}", "computed")
    return figure


@style.use_style
def draw_friction(traces: Sequence[Trace], result: FrictionResult) -> style.Figure:
    """Draw the friction coefficient of every repeat versus slip, with the evaluated values.

    The figure also shows the kinetic window, the point of each repeat's static friction, and the
    envelope of repeats with stick–slip, enlarged in a second panel.
    """
    events = result.stick_slip
    count, (start, end) = len(result.repeats), (w * MM for w in result.window)
    figure, panels = style.make_axes(1 + bool(events), width=10.4 if events else 6.4, height=3.2)
    axes = panels[0]
    for place in panels:
        for trace, repeat in zip(traces, result.repeats, strict=True):
            slip = np.abs(trace.elongation - trace.elongation[0]) * MM
            place.plot(*style.thin_out(slip, trace.force / result.normal_force), color=SKY, lw=0.8)
            style.add_point(
                place, repeat.static_at * MM, repeat.static, color=INK, ms=4, mfc="white"
            )
        style.label_axes(
            place, xlabel="slip [mm]", ylabel="force / normal force [-]", xlim=(0, None)
        )
    axes.set_ylim(0, max(r.static for r in result.repeats) * 1.3)
    axes.axvspan(start, end, color=style.SHADE, lw=0)
    axes.axhline(result.static, color=INK, lw=1, ls=style.DASHED)
    ends = [(result.static, f"static {result.static:.4f}{_sd(result.static_sd)}", INK)]
    if result.kinetic is not None:
        word = "midpoint" if events else "kinetic"
        axes.plot([start, end], [result.kinetic] * 2, color=RED, lw=2)
        ends.append((result.kinetic, f"{word} {result.kinetic:.4f}{_sd(result.kinetic_sd)}", RED))
    detail = result.standard.title
    if events:
        detail = f"{len(events.files)} of {count} stick and slip"
        ends += _draw_envelope(panels, result, events, (start, end))
    synthetic = any(t.facts.synthetic for t in traces)
    origin = "synthetic data from the virtual test machine" if synthetic else "measured"
    style.add_title(axes, f"Friction, {count_text(count, 'repeat')}", f"{origin}; {detail}")
    style.add_end_labels(axes, axes.get_xlim()[1], ends)
    maximum = "first maximum" if result.standard.first_maximum else "maximum"
    words = (f"circle: {maximum} of a repeat", INK), ("grey background: kinetic window", FAINT)
    style.add_key(axes, *words, loc="upper left", ncols=2, handlelength=0)
    return figure


def _draw_envelope(
    panels: Sequence[style.Axes],
    result: FrictionResult,
    stick_slip: StickSlip,
    span: tuple[float, float],
) -> list[tuple[float, str, str]]:
    """Draw the stick–slip bounds and enlarge eight cycles; return labels for the right side."""
    axes, zoom = panels
    ends = []
    for name, height in (("upper", stick_slip.upper), ("lower", stick_slip.lower)):
        for place in panels:
            place.plot(span, [height] * 2, color=ORANGE, lw=2)
        ends.append((height, f"{name} end {height:.4f}", ORANGE))
    first = next(r.teeth.start for r in result.repeats if r.teeth is not None) * MM
    zoom.set(xlim=(first, first + 8 * stick_slip.spacing * MM), ylim=axes.get_ylim())
    style.add_title(
        zoom,
        "Eight stick–slip cycles, enlarged",
        f"one slip every {show(stick_slip.spacing, 'm', 3)}",
    )
    return ends


def _sd(sd: float | None) -> str:
    return "" if sd is None else f" ± {sd:.4f} SD"


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
