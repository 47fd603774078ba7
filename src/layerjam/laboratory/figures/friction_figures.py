"""Figures of friction tests."""

from collections.abc import Sequence

import numpy as np

from layerjam.core.drawing import style
from layerjam.core.drawing.style import FAINT, INK, MM, ORANGE, RED, SKY
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.friction.envelope import StickSlip
from layerjam.laboratory.identify.friction.reduction import FrictionResult
from layerjam.laboratory.measure.trace import Trace


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
