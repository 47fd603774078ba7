"""The figure of a calibration: pulls, the fitted law with its bands, and the residuals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.spread import TEST_SPEED
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.simulate.prediction import Prediction
from layerjam.brake.simulate.pull_spread import BAND_SAMPLES
from layerjam.core.drawing import style
from layerjam.core.drawing.style import FAINT, GREY, MM, ORANGE, RED
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.evidence import apply_calibration
from layerjam.laboratory.identify.calibration.forward import (
    FINE,
    ReducedCurves,
    reduce_curves,
)
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.calibration.result import Calibration
from layerjam.laboratory.identify.curves import Curve, number_levels
from layerjam.laboratory.identify.shape import change_shape, drop_exponent

POINTS = 200
TOGETHER = 4
ZOOM = 4.0
"""Range of the right-hand panels, relative to the elongation at the peak."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FigureData:
    """Law of each curve of a fit, and the calibrated `file` for its bands.

    `shapes` (curves, 3) are (a, k, the enclosure's factor). `origins` (curves,) [m] are the starts
    of the rises, `offsets` [N] the zeros of the forces.
    """

    curves: tuple[Curve, ...]
    shapes: np.ndarray
    origins: np.ndarray
    offsets: np.ndarray
    file: BrakeFile


@style.use_style
def draw_calibration(file: BrakeFile, result: Calibration, synthetic: bool) -> style.Figure:
    """Draw pulls and law versus elongation, complete and near the peak, and relative residuals."""
    data = _make_figure_data(file, result)
    figure, panels = style.make_axes(
        2, 2, 9.6, 5.6, sharex="col", sharey="row", height_ratios=(2.1, 1), width_ratios=(1.25, 1)
    )
    full, zoom, residuals, close = panels
    level = np.array(number_levels([c.vacuum for c in data.curves]))
    names = {n: show(c.vacuum, "Pa") for n, c in zip(level[::-1], data.curves[::-1], strict=True)}
    order = sorted(names, reverse=True)
    colors = dict(zip(order, style.choose_colours([str(n) for n in order]).values(), strict=True))
    _draw_curves(panels, data, [colors[n] for n in level], file.brake)
    ends = []
    for number in order:
        members = np.flatnonzero(level == number)
        reach = max(float(data.curves[i].elongation[-1]) for i in members)
        below = (residuals, close) if number == order[0] else ()
        end = _draw_law(
            (full, zoom), below, data, int(members[0]), reach, colors[number], file.brake
        )
        ends.append((end, names[number], colors[number]))
    highest = max(float(c.peak_force) for c in data.curves)
    peak = max(float(c.peak_elongation) for c in data.curves)
    count = len(data.curves)
    words = f"{file.name}, {count_text(count, 'pull')}" + ", synthetic data" * synthetic
    style.label_axes(full, ylabel="force [N]", ylim=(0, highest * 1.15), xlim=(0, None))
    style.add_title(full, "Pulls and calibrated law", f"{words}; law dashed")
    style.add_end_labels(full, full.get_xlim()[1], ends)
    zoom.set_xlim(0, ZOOM * peak * MM)
    factor = result.values.get("enclosure_factor")
    numbers = f"k = {show(result.stiffness, 'N/m')}, a = {result.scale_factor:.4g}"
    numbers += "" if factor is None else f", enclosure × {factor:.3g}"
    style.add_title(zoom, "Near the peak", numbers)
    if result.fit is None:
        _draw_peaks(zoom, result)
    words = "95 % bands: mean of many pulls (dark), next pull (pale)"
    residuals.set_title(words, fontsize=8.5, fontweight="normal", color=GREY)
    limit = min(max(abs(edge) for edge in residuals.get_ylim()), 30.0)
    style.label_axes(residuals, ylabel="pull − law [% of peak]", ylim=(-limit, limit))
    for axes in (residuals, close):
        axes.axhline(0, color=FAINT, lw=1)
        axes.set(xlabel="elongation [mm]")
    return figure


def _draw_curves(
    panels: Sequence[style.Axes], data: FigureData, colors: Sequence[str], brake: Brake
) -> None:
    """Draw the pulls versus elongation, and the residuals of the law in percent of the peak."""
    full, zoom, residuals, close = panels
    samples = reduce_curves(data.curves)
    for index, curve in enumerate(data.curves):
        u, force = _average_points(samples, index)
        u, force = u - data.origins[index], force - data.offsets[index]
        law = _compute_law(np.maximum(u, 0.0), curve.vacuum, data.shapes[index], brake)
        left = (force - law) / float(curve.peak_force) * 100
        for axes in (full, zoom):
            axes.plot(*style.thin_out(u * MM, force, 200), color=colors[index], lw=1.0, alpha=0.55)
        for axes in (residuals, close):
            axes.plot(*style.thin_out(u * MM, left, 200), color=colors[index], lw=0.8, alpha=0.7)


def _compute_law(u: np.ndarray, vacuum: float, shape: np.ndarray, brake: Brake) -> np.ndarray:
    """Return the force [N] at elongations [m] for a shape (a, k, enclosure factor)."""
    brake = change_shape(drop_exponent(brake), *map(float, shape))
    return np.asarray(force_at_elongation(u, vacuum, brake))


def _average_points(samples: ReducedCurves, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Return elongation and force of a curve, averaged where samples are dense to reduce noise."""
    weight = samples.weight[index]
    group = np.arange(len(weight))
    group[:FINE] = group[:FINE] // TOGETHER * TOGETHER
    total = np.bincount(group, weight)
    is_filled = total > 0
    u, force = (
        np.bincount(group, weight * values[index])[is_filled] / total[is_filled]
        for values in (samples.elongation, samples.force)
    )
    return u, force


def _draw_law(
    panels: Sequence[style.Axes],
    below: Sequence[style.Axes],
    data: FigureData,
    index: int,
    end: float,
    color: str,
    brake: Brake,
) -> float:
    """Draw the law at one vacuum with its bands, and the bands about zero in `below`.

    Returns the force of the law at its last elongation.
    """
    curve, shape = data.curves[index], data.shapes[index]
    close = ZOOM * float(curve.peak_elongation)
    u = np.union1d(np.linspace(0, close, POINTS), np.linspace(0, end, POINTS))
    u = u[u <= end]
    law = _compute_law(u, curve.vacuum, shape, brake)
    for axes in panels:
        axes.plot(u * MM, law, color=color, lw=1.3, ls=style.DASHED)
    for of_mean, strength in ((False, 0.13), (True, 0.30)):
        low, high = _find_band(data.file, curve, u, of_mean)
        for axes in panels:
            style.add_band(axes, u * MM, law + low, law + high, color, strength)
        part = 100 / float(curve.peak_force)
        for axes in below:
            style.add_band(axes, u * MM, part * low, part * high, color, strength / 2)
    return float(law[-1])


def _find_band(
    file: BrakeFile, curve: Curve, elongation: np.ndarray, of_mean: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the 95 % interval of the force, from that of the calibrated file [N]."""
    speed = TEST_SPEED if curve.speed is None else curve.speed
    device = fix_speed(speed, file.brake)
    vacuum = np.full_like(elongation, curve.vacuum)
    prediction = Prediction(file, vacuum, None, curve.speed, device, of_mean, BAND_SAMPLES)
    forces = force_at_elongation(elongation, vacuum, prediction.brakes)
    ends = prediction.interval(forces)
    average = np.asarray(force_at_elongation(elongation, vacuum, device))
    return ends["low"] - average, ends["high"] - average


def _draw_peaks(axes: style.Axes, result: Calibration) -> None:
    """Draw the fitted peaks of the exact method, and a line whose slope is the stiffness k."""
    for fit in result.fits:
        style.add_point(axes, fit.pull.peak_elongation * MM, fit.pull.peak_force, ms=4)
    top = max(fit.pull.peak_force for fit in result.fits)
    axes.plot([0, top / result.stiffness * MM], [0, top], color=ORANGE, lw=1.5)
    style.add_key(axes, ("slope k", ORANGE), ("fitted peaks", RED, "o"), loc="lower right")


def _make_figure_data(file: BrakeFile, result: Calibration) -> FigureData:
    count, fit = len(result.curves), result.fit
    origins, offsets = np.zeros(count), np.zeros(count)
    if fit is None:
        a, k = result.scale_factor, result.stiffness
        shapes = np.array([[a * f.growth, k, 1.0] for f in result.fits])
    elif isinstance(fit, JointFit):
        shapes = np.array([fit.shape(i) for i in range(count)])
        origins = fit.own.own[:, 3] * fit.reduced.onset
        offsets = fit.own.own[:, 4] * fit.reduced.height
    else:
        shape = result.scale_factor, result.stiffness, result.values["enclosure_factor"]
        shapes = np.tile(np.array(shape), (count, 1))
        origins = np.median(fit.slack, axis=(0, 1))
    return FigureData(
        curves=result.curves,
        shapes=shapes,
        origins=origins,
        offsets=offsets,
        file=apply_calibration(file, result),
    )
