"""What an accelerometer shows of the paper's stop, and what would make its numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.report.style import (
    BLUE,
    GREEN,
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
from layerjam.simulate.accelerometer import ADXL193, CLASSES, IDEAL, Reading, seen, specific_force
from layerjam.simulate.record import DropRecord
from layerjam.studies.choi2018.impact import (
    FULL,
    PAPER_BARE,
    PAPER_FULL,
    PAPER_TUNED,
    G,
    bare,
    brake_and_rope,
    cutoff_for,
    filtered_peak,
    rope_study,
    stops,
)
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["readings", "save", "what_it_takes"]
COLORS = dict(zip(("ADXL193", "CFC 60", "CFC 180", "CFC 600", "CFC 1000"),
                  (BLUE, RED, ORANGE, PURPLE, SKY), strict=True))  # fmt: skip


def chains(record: DropRecord) -> dict[str, Reading]:
    """Readings of one stop by name of the filter: the sensor alone, then each class alone."""
    out = {"ADXL193": seen(record, ADXL193)}
    return out | {f"CFC {c}": seen(record, IDEAL, c) for c in CLASSES}


def readings() -> Figure:
    """The paper's stop at full vacuum and tuned, ideal and filtered; below, the peaks close up."""
    names = ("Full vacuum", "Tuned for 40 mm")
    with look():
        figure, axes = canvas(columns=2, rows=2, width=10.4, height=7.2, height_ratios=(1, 1.15))
        for column, (name, record) in enumerate(zip(names, stops(), strict=True)):
            shown = chains(record)
            _stop(axes[column], name, record, shown)
            _close_up(axes[2 + column], record, shown)
    return figure


def _stop(axes: Axes, name: str, record: DropRecord, shown: dict[str, Reading]) -> None:
    time, value = specific_force(record)
    _lines(axes, record, shown, -0.006, float(time[-1]) + 0.006)
    end = float(record.time[-1]) * 1e3
    top = float(value.max()) / G * 1.22
    axes.axvline(end, color=GREY, lw=0.8, ls=(0, (3, 3)))
    label(axes, end - 0.8, 0.94 * top, "stop", GREY, ha="right")
    label(axes, end + 0.8, 0.94 * top, "rebound", GREY)
    axes.set(xlim=(-6, float(time[-1]) * 1e3 + 6), ylim=(0, top))
    axes.set(xlabel="time from the taut rope [ms]", ylabel="specific force shown [g]")
    detail = f"simulated; 1 kg, {show(record.speed, 'm/s')}, {show(record.vacuum, 'Pa')}"
    title(axes, name, detail)


def _close_up(axes: Axes, record: DropRecord, shown: dict[str, Reading]) -> None:
    time, value = specific_force(record)
    highest, top = float(time[np.argmax(value)]), float(value.max()) / G
    _lines(axes, record, shown, highest - 0.003, highest + 0.009)
    axes.set(xlim=((highest - 0.003) * 1e3, (highest + 0.009) * 1e3))
    axes.set(ylim=(0.82 * top, 1.07 * top))
    axes.set(xlabel="time from the taut rope [ms]", ylabel="specific force shown [g]")
    _tell(axes, f"ideal  {top:.2f} g", INK, 0, lw=3.5, alpha=0.35)
    for i, (chain, reading) in enumerate(shown.items()):
        words = f"{chain}  {reading.peak / G:.2f} g ({-reading.loss:+.1%})"
        _tell(axes, words, COLORS[chain], i + 1, lw=2)
    title(axes, "The peak, close up")


def _lines(
    axes: Axes, record: DropRecord, shown: dict[str, Reading], first: float, last: float
) -> None:
    """The signal and its readings between two times [s]."""
    time, value = specific_force(record)
    axes.plot(time * 1e3, value / G, color=INK, lw=3.5, alpha=0.35)
    for chain, made in shown.items():
        inside = (made.time > first) & (made.time < last)
        at, height = made.time[inside] * 1e3, made.acceleration[inside] / G
        axes.plot(at, height, color=COLORS[chain], lw=1.3)


def _tell(axes: Axes, text: str, color: str, line: int, **how: Any) -> None:
    """One line of a list in the upper right, which the falling force leaves free."""
    height = 0.95 - 0.062 * line
    axes.plot([0.53, 0.58], [height] * 2, color=color, transform=axes.transAxes, **how)
    axes.text(0.6, height, text, transform=axes.transAxes, color=INK, va="center", fontsize=8.5)


def what_it_takes() -> Figure:
    """Peaks over the filter's cutoff and over the rope's stiffness, against the paper's."""
    with look():
        figure, (filters, ropes) = canvas(columns=2, width=11.5, height=4.6)
        for axes in (filters, ropes):
            axes.set(xscale="log", yscale="log", ylabel="peak shown [g]", ylim=(1, 120))
            axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
        _over_cutoff(filters)
        _over_rope(ropes)
        for axes in (filters, ropes):
            axes.minorticks_off()
    return figure


def _over_cutoff(axes: Axes) -> None:
    full, tuned = (specific_force(run) for run in stops())
    _, rope = brake_and_rope()
    cutoff = np.geomspace(1, 2000, 90)
    for signal, color in ((bare(rope), INK), (full, BLUE), (tuned, GREEN)):
        axes.plot(cutoff, [filtered_peak(signal, float(f)) for f in cutoff], color=color)
    for signal, peak, name, place in (
        (full, PAPER_FULL, "full vacuum", (14, 5.0)), (tuned, PAPER_TUNED, "tuned", (4.2, 1.35)),
    ):  # fmt: skip
        takes = cutoff_for(signal, peak)
        axes.plot(takes, peak, "o", color=RED, ms=6)
        axes.annotate(
            f"paper's {peak:.0f} g, {name}: {takes:.1f} Hz", (takes, peak), place,
            arrowprops={"arrowstyle": "-", "color": RED, "lw": 0.8}, color=RED, fontsize=8.8,
            va="center",
        )  # fmt: skip
    axes.plot(2000, PAPER_BARE, "^", color=RED, ms=7, clip_on=False)
    label(axes, 1800, 66, "paper: 50 g", RED, ha="right")
    for text, f in [("ADXL193", 400.0), *((f"CFC {c}", c / 0.6) for c in CLASSES)]:
        axes.axvline(f, color=GREY, lw=0.7, ls=(0, (2, 3)))
        axes.text(f, 1.06, f" {text}", rotation=90, fontsize=7.5, color=GREY, ha="right")
    label(axes, 24, 52, "no brake, 3.7 m/s", INK, ha="right")
    label(axes, 110, 22, "full vacuum, 2.5 m/s", BLUE)
    label(axes, 110, 8.3, "tuned, 2.5 m/s", GREEN)
    axes.set(xlabel="−3 dB frequency of the filter [Hz]", xlim=(1, 2000))
    axes.set_xticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])
    title(axes, "Which filter it would take", "4 poles, no phase (shape of SAE J211-1), any cutoff")


def _over_rope(axes: Axes) -> None:
    study = rope_study()
    _, rope = brake_and_rope()
    slips = study.full < study.bare * 0.995
    axes.plot(study.rope, study.bare, color=INK)
    axes.plot(study.rope[slips], study.full[slips], color=BLUE)
    axes.plot(study.rope, study.tuned, color=GREEN)
    axes.axvline(rope, color=GREY, lw=0.7, ls=(0, (2, 3)))
    label(axes, rope * 1.12, 4.5, "rope of the paper, inferred", GREY)
    for peak, text in ((PAPER_TUNED, "paper: under 2 g, tuned"),
                       (PAPER_FULL, "paper: 10 g, full vacuum")):  # fmt: skip
        axes.axhline(peak, color=RED, lw=1.4, ls=(0, (5, 3)))
        label(axes, 9e5, peak * 0.84, text, RED, ha="right", va="center")
    label(axes, 4e4, 70, "no brake", INK, ha="right")
    label(axes, 3e4, 21.5, f"full vacuum, {FULL / 1e3:.1f} kPa", BLUE)
    label(axes, 3e4, 13.6, "tuned for 40 mm", GREEN)
    softest = float(study.rope[np.isfinite(study.tuned)][0])
    words = (
        f"below {show(softest, 'N/m', 2)} the brake does not slip\n40 mm: the rope stops the mass"
    )
    label(axes, 13, 27, words, GREY)
    axes.set(xlabel="stiffness of the rope [kN/m]", xlim=(10, 1e6))
    axes.set_xticks([10, 100, 1e3, 1e4, 1e5, 1e6], ["0.01", "0.1", "1", "10", "100", "1000"])
    title(axes, "Which rope it would take", "1 kg at 2.5 m/s, ideal accelerometer")
