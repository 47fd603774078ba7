"""Figures of a brake's report: vector, a column or a page wide, type as large as in print."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.identify.friction.reduction import FrictionResult
from layerjam.identify.validation.metrics import ConditionError, Validation, uncalibrated
from layerjam.measure.trace import Trace
from layerjam.mechanics.pull import force_at_elongation
from layerjam.report.brake_tables import Calibrated
from layerjam.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    VACUUMS,
    canvas,
    label,
    look,
)
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MM = 1e3
COLUMN, PAGE = 3.4, 7.0
"""Widths [in]: of one of two columns, and of the text on A4."""
APART = (BLUE, RED, GREEN, PURPLE)
DASHED, DOTTED = (0, (5, 2)), (0, (1, 1.6))


def thinned(x: np.ndarray, y: np.ndarray, bins: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """At most 2 * `bins` samples of a long record: the least and the greatest of each bin."""
    if len(y) <= 2 * bins:
        return x, y
    kept = []
    for part in np.array_split(np.arange(len(y)), bins):
        kept += sorted({int(part[np.argmin(y[part])]), int(part[np.argmax(y[part])])})
    return x[kept], y[kept]


def vacuum_colors(vacuums: Iterable[float]) -> dict[str, str]:
    """A colour for every vacuum by its text; a ramp from dark to pale where there are many."""
    names = list(dict.fromkeys(show(v, "Pa") for v in sorted(vacuums, reverse=True)))
    if len(names) <= len(APART):
        return dict(zip(names, APART, strict=False))
    ramp = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in VACUUMS], float)
    place = np.linspace(0, len(VACUUMS) - 1, len(names))
    mixed = [np.interp(place, range(len(VACUUMS)), ramp[:, i]) for i in range(3)]
    return {
        name: "#" + "".join(f"{round(float(channel[k])):02x}" for channel in mixed)
        for k, name in enumerate(names)
    }


def _small(axes: Sequence[Axes]) -> None:
    for one in axes:
        one.tick_params(labelsize=7.5)
        one.set_title(one.get_title(loc="left"), fontsize=8.5, pad=5)
        one.xaxis.label.set_fontsize(8)
        one.yaxis.label.set_fontsize(8)


def friction(traces: Sequence[Trace], result: FrictionResult) -> Figure:
    """Friction coefficient over travel of every repeat, with the reduced values."""
    with look():
        figure, (axes,) = canvas(width=COLUMN, height=2.35)
        start, end = (w * MM for w in result.window)
        axes.axvspan(start, end, color="#f1f4f6", lw=0)
        far = end
        for trace in traces:
            travel = np.abs(trace.elongation - trace.elongation[0]) * MM
            axes.plot(*thinned(travel, trace.force / result.normal_force), color=SKY, lw=0.6)
            far = max(far, float(travel.max()))
        if result.kinetic is not None:
            axes.plot([start, end], [result.kinetic] * 2, color=RED, lw=1.6)
            label(
                axes, (start + end) / 2, result.kinetic - 0.09 * result.static,
                f"kinetic {result.kinetic:.4f}", RED, ha="center", fontsize=7.5,
            )  # fmt: skip
        for repeat in result.repeats:
            axes.plot(repeat.static_at * MM, repeat.static, "o", color=INK, ms=2.6)
        words = f"static {result.static:.4f}, mean of the greatest values"
        axes.axhline(result.static, color=INK, lw=0.8, ls=(0, (4, 3)))
        label(axes, far, result.static * 1.08, words, INK, ha="right", fontsize=7.5)
        top = max(1.2 * result.static, 1.1 * max(r.static for r in result.repeats))
        axes.set(xlabel="travel [mm]", ylabel="force / normal force", xlim=(0, far), ylim=(0, top))
        _small([axes])
    return figure


def calibration(brake: Brake, result: Calibrated, low: float | None, high: float | None) -> Figure:
    """The pulls near their peaks with slope and calibrated law; the factor each pull gives.

    `brake` is the calibrated one; `low` to `high` the scale factor's 95 % interval.
    """
    colors = vacuum_colors(f.vacuum for f in result.fits)
    with look():
        figure, (axes, factors) = canvas(
            columns=2, width=PAGE, height=2.5, gridspec_kw={"width_ratios": [1.35, 1]}
        )
        near = 4 * max(f.pull.peak_elongation for f in result.fits)
        top = max(f.pull.peak_force for f in result.fits)
        seen: dict[str, float] = {}
        for fit in result.fits:
            part = fit.pull.elongation <= near
            name = show(fit.vacuum, "Pa")
            u, force = thinned(fit.pull.elongation[part] * MM, fit.pull.force[part], 250)
            axes.plot(u, force, color=colors[name], lw=0.9, alpha=0.75)
            seen[name] = fit.vacuum
        ends = []
        for name, vacuum in seen.items():
            u = np.linspace(0, near, 600)
            law = np.asarray(force_at_elongation(u, vacuum, brake))
            axes.plot(u * MM, law, color=INK, lw=1.1, ls=DASHED)
            ends.append((float(law[-1]), name, colors[name]))
        for fit in result.fits:
            axes.plot(
                fit.pull.peak_elongation * MM, fit.pull.peak_force, "o", ms=3.6, zorder=4,
                markerfacecolor="white", markeredgecolor=INK, markeredgewidth=0.9,
            )  # fmt: skip
        reach = np.array([0.0, 1.04 * top / result.values["stiffness"]])
        axes.plot(reach * MM, result.values["stiffness"] * reach, color=ORANGE, lw=1.2)
        axes.set(
            xlim=(0, near * MM), ylim=(0, 1.18 * top), xlabel="elongation [mm]", ylabel="force [N]"
        )
        _labels(axes, ends, 2.35)
        axes.set_title("Near the peak")
        _factors(factors, result, colors, low, high)
        _legend(
            figure,
            [
                _line(BLUE, "pulls", lw=0.9),
                _line(INK, "fitted peaks", lw=0, marker="o", markerfacecolor="white", ms=3.6),
                _line(INK, "calibrated law", lw=1.1, ls=DASHED),
                _line(ORANGE, "slope before onset, k", lw=1.2),
            ],
        )
        _small([axes, factors])
    return figure


def _factors(
    axes: Axes, result: Calibrated, colors: dict[str, str], low: float | None, high: float | None
) -> None:
    count = len(result.fits)
    if low is not None and high is not None:
        axes.axhspan(low, high, color="#e7ebee", lw=0)
    axes.axhline(result.values["scale_factor"], color=INK, lw=1.0)
    for place, fit in enumerate(result.fits, 1):
        axes.plot(place, fit.scale_factor, "o", color=colors[show(fit.vacuum, "Pa")], ms=4)
    axes.set_xlim(0.4, count + 0.6)
    axes.set_xticks(range(1, count + 1) if count <= 12 else [1, count // 2, count])
    axes.margins(y=0.25)
    axes.set(xlabel="pull", ylabel="scale factor a")
    axes.set_title("Each pull, mean" + (", 95 % interval" if low is not None else ""))


def _mean_sd(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    sd = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.zeros(rows.shape[1])
    return rows.mean(axis=0), sd


def _grid(one: ConditionError) -> np.ndarray:
    """Elongations all repeats of a condition have [m], dense where the force turns."""
    far = min(float(c.pull.elongation[-1]) for c in one.curves)
    near = min(4 * max(c.pull.peak_elongation for c in one.curves), 0.5 * far)
    return np.concatenate([np.linspace(0, near, 160, endpoint=False), np.linspace(near, far, 160)])


def _measured(one: ConditionError, grid: np.ndarray) -> np.ndarray:
    rows = []
    for curve in one.curves:
        order = np.argsort(curve.pull.elongation, kind="stable")
        rows.append(np.interp(grid, curve.pull.elongation[order], curve.pull.force[order]))
    return np.stack(rows)


Draw = Callable[["Axes", ConditionError, str], float]
"""Draws one condition in its colour; gives the height of its end, where its label stands."""


def _over_speeds(
    result: Validation, height: float, draw: Draw, ylabel: str, low: float | None = None
) -> tuple[Figure, list[Axes]]:
    """A panel for every speed, all on the same axes, each condition labelled at its end."""
    panels: dict[str, list[ConditionError]] = {}
    for one in result.conditions:
        name = "speed not known" if one.speed is None else f"at {show(one.speed, 'm/s', 3)}"
        panels.setdefault(name, []).append(one)
    colors = vacuum_colors(c.vacuum for c in result.conditions)
    columns = len(panels) if len(panels) <= 3 else min(-(-len(panels) // 2), 3)
    rows = -(-len(panels) // columns)
    height *= 1.0 if rows == 1 else 0.8
    figure, axes = canvas(
        columns=columns, rows=rows, width=PAGE, height=height * rows, sharex=True, sharey=True
    )
    ends: list[list[tuple[float, str, str]]] = []
    for place, (speed, conditions) in zip(axes, panels.items(), strict=False):
        ends.append([])
        for one in conditions:
            name = show(one.vacuum, "Pa")
            ends[-1].append((draw(place, one, colors[name]), name, colors[name]))
        place.set_title(speed)
        place.set_xlabel("elongation [mm]")
    axes[0].set_xlim(0, None)
    axes[0].set_ylim(low, None)
    for place, labels in zip(axes, ends, strict=False):
        _labels(place, labels, height)
    for place in axes[len(panels) :]:
        place.set_visible(False)
    for first in axes[::columns]:
        first.set_ylabel(ylabel)
    _small(axes)
    return figure, axes


def overlay(brake: Brake, result: Validation, with_uncalibrated: bool) -> Figure:
    """Mean of the repeats with its SD band and the model's line, a panel for every speed."""
    before = uncalibrated(brake)

    def draw(axes: Axes, one: ConditionError, color: str) -> float:
        grid = _grid(one)
        mean, sd = _mean_sd(_measured(one, grid))
        axes.fill_between(grid * MM, mean - sd, mean + sd, color=color, alpha=0.28, lw=0)
        axes.plot(grid * MM, mean, color=color, lw=1.3)
        if with_uncalibrated:
            line = np.asarray(force_at_elongation(grid, one.vacuum, before))
            axes.plot(grid * MM, line, color=GREY, lw=1.0, ls=DOTTED)
        law = np.asarray(force_at_elongation(grid, one.vacuum, brake))
        axes.plot(grid * MM, law, color=INK, lw=1.0, ls=DASHED)
        return float(mean[-1])

    with look():
        figure, _ = _over_speeds(result, 2.75, draw, "force [N]", low=0.0)
        _key(figure, with_uncalibrated)
    return figure


def _line(color: str, words: str, **how: Any) -> Artist:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, label=words, **how)


def _legend(figure: Figure, handles: list[Artist]) -> None:
    figure.legend(
        handles=handles, fontsize=7.5, loc="outside upper center", ncols=len(handles),
        handlelength=2.2, borderpad=0.1,
    )  # fmt: skip


def _key(figure: Figure, with_uncalibrated: bool) -> None:
    from matplotlib.patches import Patch

    handles = [
        _line(BLUE, "mean of the repeats", lw=1.3),
        Patch(facecolor=BLUE, alpha=0.28, label="± 1 SD between repeats"),
        _line(INK, "model", lw=1.0, ls=DASHED),
    ]
    if with_uncalibrated:
        handles.append(_line(GREY, "model before calibration", lw=1.0, ls=DOTTED))
    _legend(figure, handles)


def residuals(result: Validation) -> Figure:
    """Model less measured over the windows: mean of the repeats with SD band, and the zero line."""

    def draw(axes: Axes, one: ConditionError, color: str) -> float:
        axes.axhline(0, color=INK, lw=0.9, zorder=3)
        start = max(float(c.elongation[0]) for c in one.curves)
        end = min(float(c.elongation[-1]) for c in one.curves)
        if not end > start:
            return math.nan
        grid = np.linspace(start, end, 160)
        found = [np.interp(grid, c.elongation, c.model - c.measured) for c in one.curves]
        mean, sd = _mean_sd(np.stack(found))
        axes.fill_between(grid * MM, mean - sd, mean + sd, color=color, alpha=0.22, lw=0)
        axes.plot(grid * MM, mean, color=color, lw=1.2)
        return float(mean[-1])

    with look():
        figure, _ = _over_speeds(result, 2.1, draw, "model − measured [N]")
    return figure


def _labels(axes: Axes, ends: list[tuple[float, str, str]], height: float) -> None:
    """Labels at the right end of curves in axes of `height` [in], a line apart where they touch."""
    low, high = axes.get_ylim()
    far = axes.get_xlim()[1]
    gap = (high - low) * 9.5 / (72 * 0.68 * height)
    known = sorted(end for end in ends if math.isfinite(end[0]))
    places: list[float] = []
    for y, _, _ in known:
        places.append(max(y, places[-1] + gap) if places else y)
    over = max(places[-1] - high, 0.0) if places else 0.0
    for (_, text, color), y in zip(known, places, strict=True):
        axes.annotate(
            text, (far, y - over), xytext=(4, 0), textcoords="offset points", va="center",
            fontsize=7.5, color=color, annotation_clip=False,
        )  # fmt: skip
    axes.set_ylim(low, high)
