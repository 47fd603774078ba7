"""Accelerometer readings of the paper's stop, and conditions that would explain its peaks."""

import numpy as np

from layerjam.brake.simulate.accelerometer import (
    ADXL193,
    CLASSES,
    IDEAL,
    Reading,
    measure_acceleration,
    specific_force,
)
from layerjam.brake.simulate.record import DropRecord
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, KPA, MS, ORANGE, PURPLE, RED, SKY
from layerjam.core.units import show
from layerjam.studies.choi2018 import impact
from layerjam.studies.choi2018.impact import PAPER_BARE, PAPER_FULL, PAPER_TUNED, G

NAMES = ("ADXL193", *(f"CFC {c}" for c in CLASSES))
COLORS = dict(zip(NAMES, (BLUE, RED, ORANGE, PURPLE, SKY), strict=True))


def apply_filters(record: DropRecord) -> dict[str, Reading]:
    """Return {filter: reading} of one stop: the sensor alone, then each class alone."""
    read = [
        measure_acceleration(record, ADXL193),
        *(measure_acceleration(record, IDEAL, c) for c in CLASSES),
    ]
    return dict(zip(NAMES, read, strict=True))


@style.use_style
def draw_readings() -> style.Figure:
    """Draw the paper's stop at full and tuned vacuum, ideal and filtered, with details below."""
    figure, panels = style.make_axes(2, 2, width=10.4, height=7.2, height_ratios=(1, 1.15))
    for column, name in enumerate(("Full vacuum", "Tuned for 40 mm")):
        record = impact.simulate_stops()[column]
        by_chain = apply_filters(record)
        time, value = specific_force(record)
        high, top = float(time[np.argmax(value)]) * MS, float(value.max()) / G
        overview, close = panels[column], panels[2 + column]
        _draw_lines(overview, record, by_chain, -6, float(time[-1]) * MS + 6)
        overview.set_ylim(0, top * 1.22)
        style.mark_x(overview, float(record.time[-1]) * MS, "stop, then rebound")
        detail = f"simulated; 1 kg, {show(record.speed, 'm/s')}, {show(record.vacuum, 'Pa')}"
        style.add_title(overview, name, detail)
        _draw_lines(close, record, by_chain, high - 3, high + 9)
        close.set_ylim(0.82 * top, 1.07 * top)
        peaks = [(f"ideal  {top:.2f} g", INK)]
        for chain, reading in by_chain.items():
            words = f"{chain}  {reading.peak / G:.2f} g ({-reading.loss:+.1%})"
            peaks.append((words, COLORS[chain]))
        style.add_key(close, *peaks, loc="upper right")
        style.add_title(close, "Close-up of the peak")
    return figure


def _draw_lines(
    axes: style.Axes, record: DropRecord, by_chain: dict[str, Reading], first: float, last: float
) -> None:
    """Draw the signal and its readings between two times [ms]."""
    time, value = specific_force(record)
    axes.plot(time * MS, value / G, color=INK, lw=3.5, alpha=0.35)
    for chain, reading in by_chain.items():
        is_inside = (reading.time * MS > first) & (reading.time * MS < last)
        height = reading.acceleration[is_inside] / G
        axes.plot(reading.time[is_inside] * MS, height, color=COLORS[chain], lw=1.3)
    axes.set(xlim=(first, last), xlabel="time since the rope became taut [ms]")
    axes.set_ylabel("specific force shown [g]")


@style.use_style
def draw_requirements() -> style.Figure:
    """Draw peaks versus filter cutoff and versus rope stiffness, with the paper's peaks."""
    figure, (filters, ropes) = style.make_axes(columns=2, width=11.5, height=4.8)
    _draw_peak_versus_cutoff(filters)
    _draw_peak_versus_rope(ropes)
    for axes in (filters, ropes):
        style.set_log_scale(axes, "xy")
        axes.set(ylabel="peak shown [g]", ylim=(1, 300), yticks=[1, 2, 5, 10, 20, 50, 100])
        axes.minorticks_off()
        style.add_key(axes, loc="upper left")
    return figure


def _draw_peak_versus_cutoff(axes: style.Axes) -> None:
    full_force, tuned_force = (specific_force(run) for run in impact.simulate_stops())
    _, rope = impact.load_brake_and_rope()
    cutoff, (ten, two) = np.geomspace(1, 2000, 90), impact.find_cutoffs()
    axes.set(xscale="log", xlim=(1, 2000), yscale="log", ylim=(1, 300))
    for signal, color, name, shown_at in (
        (impact.simulate_rope(rope), INK, "no brake, 3.7 m/s", None),
        (full_force, BLUE, "full vacuum, 2.5 m/s", (ten, PAPER_FULL)),
        (tuned_force, GREEN, "tuned, 2.5 m/s", (two, PAPER_TUNED)),
    ):
        peaks = [impact.filtered_peak(signal, float(f)) for f in cutoff]
        axes.plot(cutoff, peaks, color=color, label=name)
        if shown_at is not None:
            takes, peak = shown_at
            words = f"paper's {peak:.0f} g: {takes:.1f} Hz"
            style.add_point(
                axes, takes, peak, label=words, shape="o" if peak == PAPER_FULL else "s"
            )
    style.add_point(axes, 2000, PAPER_BARE, "paper: 50 g", shape="^", clip_on=False)
    for text, f in [("ADXL193", 400.0), *((f"CFC {c}", c / 0.6) for c in CLASSES)]:
        axes.axvline(f, color=GREY, lw=0.7, ls=style.DOTTED)
        axes.text(f, 1.06, f" {text}", rotation=90, fontsize=7.5, color=GREY, ha="right")
    detail = "4 poles, zero phase (shape of SAE J211-1), any cutoff"
    headline = "Required filter"
    style.label_axes(axes, headline, detail, xlabel="−3 dB frequency of the filter [Hz]")


def _draw_peak_versus_rope(axes: style.Axes) -> None:
    study = impact.study_ropes()
    _, rope = impact.load_brake_and_rope()
    stiffness, slips = study.rope / 1e3, study.full < study.bare * 0.995
    axes.plot(stiffness, study.bare, color=INK, label="no brake")
    words = f"full vacuum, {impact.FULL * KPA:.1f} kPa"
    axes.plot(stiffness[slips], study.full[slips], color=BLUE, label=words)
    axes.plot(stiffness, study.tuned, color=GREEN, label="tuned for 40 mm")
    axes.set(xscale="log", xlim=(0.01, 1e3))
    style.mark_y(axes, PAPER_TUNED, "paper: under 2 g, tuned", share=0.99)
    style.mark_y(axes, PAPER_FULL, "paper: 10 g, full vacuum", below=True)
    style.mark_x(axes, rope / 1e3, "rope of the paper, inferred", share=0.03)
    softest = float(study.rope[np.isfinite(study.tuned)][0])
    detail = f"1 kg at 2.5 m/s, ideal; below {show(softest, 'N/m', 2)} the rope alone stops it"
    x_label = "stiffness of the rope [kN/m]"
    style.label_axes(axes, "Required rope", detail, xlabel=x_label)
