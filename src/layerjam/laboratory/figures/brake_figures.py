"""Figures of a brake's report only: validation by speed, and scale factor of each pull."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.core.drawing import style
from layerjam.core.drawing.style import GREY, INK, MM
from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.validation.metrics import (
    ConditionError,
    Validation,
    sample_force,
    uncalibrated,
)

PAGE = 7.0
"""Width of the text on A4 [in]."""


def vacuum_colors(vacuums: Sequence[float]) -> dict[str, str]:
    """Return {text of a vacuum: its colour}, the highest vacuum first."""
    descending = sorted(vacuums, reverse=True)
    return style.choose_colours(list(dict.fromkeys(show(v, "Pa") for v in descending)))


@style.use_style
def draw_factors(result: Calibration) -> style.Figure:
    """Draw the scale factor of each pull, and the mean with its 95 % interval."""
    colors = vacuum_colors([f.vacuum for f in result.fits])
    figure, (axes,) = style.make_axes(width=PAGE, height=2.6)
    count = len(result.fits)
    interval = result.intervals["scale_factor"]
    if interval is not None:
        axes.axhspan(interval.low, interval.high, color="#e7ebee", lw=0)
    axes.axhline(result.scale_factor, color=INK, lw=1.0)
    for number, fit in enumerate(result.fits, 1):
        style.add_point(axes, number, fit.scale_factor, color=colors[show(fit.vacuum, "Pa")])
    axes.set(xlabel="pull number", ylabel="scale factor a [-]", xlim=(0.4, count + 0.6))
    axes.set_xticks(range(1, count + 1) if count <= 12 else [1, count // 2, count])
    axes.margins(y=0.25)
    style.add_key(axes, *colors.items(), handlelength=0)
    style.add_title(axes, "Each pull and the mean" + ", 95 % interval" * bool(interval))
    return figure


Draw = Callable[["style.Axes", ConditionError, str], float]
"""Function that draws a condition in its colour and returns the height at which its curve ends."""


def _draw_speed_panels(
    result: Validation, height: float, draw: Draw, ylabel: str, low: float | None = None
) -> style.Figure:
    """Draw a panel for every speed, all on the same axes, each condition labelled at its end."""
    panels: dict[str, list[ConditionError]] = {}
    for case in result.conditions:
        name = "speed unknown" if case.speed is None else f"at {show(case.speed, 'm/s', 3)}"
        panels.setdefault(name, []).append(case)
    colors = vacuum_colors([c.vacuum for c in result.conditions])
    columns = len(panels) if len(panels) <= 3 else min(-(-len(panels) // 2), 3)
    rows = -(-len(panels) // columns)
    figure, axes = style.make_axes(columns, rows, PAGE + 1, height * rows, sharex=True, sharey=True)
    ends = []
    for place, conditions in zip(axes, panels.values(), strict=False):
        names = [show(case.vacuum, "Pa") for case in conditions]
        heights = [draw(place, case, colors[n]) for case, n in zip(conditions, names, strict=True)]
        ends.append([(y, n, colors[n]) for y, n in zip(heights, names, strict=True)])
    axes[0].set(xlim=(0, None), ylim=(low, None))
    for place, speed, words in zip(axes, panels, ends, strict=False):
        style.label_axes(place, speed, xlabel="elongation [mm]")
        style.add_end_labels(place, place.get_xlim()[1], words)
    for place in axes[len(panels) :]:
        place.set_visible(False)
    for first in axes[::columns]:
        first.set_ylabel(ylabel)
    return figure


@style.use_style
def draw_overlay(brake: Brake, result: Validation, with_uncalibrated: bool) -> style.Figure:
    """Draw the mean of the repeats with its SD band and the model's line, one panel per speed."""
    models = [(brake, INK, style.DASHED)]
    if with_uncalibrated:
        models.append((uncalibrated(brake), GREY, style.DOTTED))

    def draw(axes: style.Axes, case: ConditionError, color: str) -> float:
        grid = _common_elongations(case)
        mean, sd = _mean_sd(np.stack([sample_force(c.pull, grid) for c in case.curves]))
        style.add_band(axes, grid * MM, mean - sd, mean + sd, color, 0.28)
        axes.plot(grid * MM, mean, color=color, lw=1.3)
        for law, shade, dash in models:
            force = np.asarray(force_at_elongation(grid, case.vacuum, law))
            axes.plot(grid * MM, force, color=shade, lw=1.0, ls=dash)
        return float(mean[-1])

    figure = _draw_speed_panels(result, 3.2, draw, "force [N]", low=0.0)
    names: list[tuple[Any, ...]] = [
        (f"{vacuum}, mean of the repeats ± 1 SD", color)
        for vacuum, color in vacuum_colors([c.vacuum for c in result.conditions]).items()
    ]
    names += [("model", INK, style.DASHED)]
    names += [("model before calibration", GREY, style.DOTTED)] * with_uncalibrated
    style.add_key(figure, *names, loc="outside upper center", ncols=2, handlelength=2.2)
    return figure


@style.use_style
def draw_residuals(result: Validation) -> style.Figure:
    """Draw model minus measured force: mean of the repeats with its SD band, and the zero line."""

    def draw(axes: style.Axes, case: ConditionError, color: str) -> float:
        axes.axhline(0, color=INK, lw=0.9, zorder=3)
        start = max(float(c.elongation[0]) for c in case.curves)
        end = min(float(c.elongation[-1]) for c in case.curves)
        if not end > start:
            return math.nan
        grid = np.linspace(start, end, 160)
        errors = [np.interp(grid, c.elongation, c.model - c.measured) for c in case.curves]
        mean, sd = _mean_sd(np.stack(errors))
        style.add_band(axes, grid * MM, mean - sd, mean + sd, color, 0.22)
        axes.plot(grid * MM, mean, color=color, lw=1.2)
        return float(mean[-1])

    return _draw_speed_panels(result, 2.6, draw, "model − measured [N]")


def _mean_sd(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    sd = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.zeros(rows.shape[1])
    return rows.mean(axis=0), sd


def _common_elongations(case: ConditionError) -> np.ndarray:
    """Return elongations [m] that all repeats of a condition reach, dense where the curve bends."""
    end = min(float(c.pull.elongation[-1]) for c in case.curves)
    bend = min(4 * max(c.pull.peak_elongation for c in case.curves), 0.5 * end)
    return np.concatenate([np.linspace(0, bend, 160, endpoint=False), np.linspace(bend, end, 160)])
