"""The figure of a calibration: pulls, the fitted law with its bands, and what is left of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.identify.calibration.forward import FINE, Reduced, law_with_error, reduce
from layerjam.identify.calibration.intervals import quantile
from layerjam.identify.calibration.peaks import Calibration
from layerjam.identify.calibration.whole_curves import CurvesCalibration
from layerjam.identify.curves import Curve, levels
from layerjam.report.style import (
    FAINT,
    GREY,
    ORANGE,
    RED,
    VACUUMS,
    canvas,
    label,
    labels_right,
    look,
    title,
)  # fmt: skip
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MM = 1e3
POINTS = 600
TOGETHER = 4
NEAR = 4.0
"""The right half shows this times the elongation at the peak."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawn:
    """What the figure needs of a fit: by curve, its law and how sure that is.

    `shapes` (curves, 3) are (a, k, sleeve's factor); `sure` and `scatter` (curves, 3, 3) the
    covariances of (ln a, ln k, factor): of the law itself, and of a further pull about it (None
    where no repeats tell); `origins` (curves,) [m] where each curve's rise begins, `offsets` [N] of
    its force; `t` Student's quantile for the bands.
    """

    curves: tuple[Curve, ...]
    shapes: np.ndarray
    origins: np.ndarray
    offsets: np.ndarray
    sure: np.ndarray | None
    scatter: np.ndarray | None
    t: float


def calibration(file: BrakeFile, result: Any, synthetic: bool) -> Figure:
    """Pulls and law over elongation, whole and near the peak; residuals below, part of the peak."""
    drawn = _drawn(result)
    level = np.array(levels([c.vacuum for c in drawn.curves]))
    order = sorted(set(level.tolist()), reverse=True)
    colours = {n: VACUUMS[min(i * len(VACUUMS) // max(len(order), 2), len(VACUUMS) - 1)]
               for i, n in enumerate(order)}  # fmt: skip
    with look():
        figure, places = canvas(
            rows=2, columns=2, width=9.0, height=5.6, sharex="col", sharey="row",
            gridspec_kw={"height_ratios": [2.1, 1], "width_ratios": [1.25, 1]},
        )  # fmt: skip
        whole, near, rest, close = places
        highest = max(float(c.pull.peak_force) for c in drawn.curves)
        reduced = reduce(drawn.curves)
        for place, curve in enumerate(drawn.curves):
            colour = colours[int(level[place])]
            u, force = _points(reduced, place)
            u, force = u - drawn.origins[place], force - drawn.offsets[place]
            law, _ = law_with_error(
                np.maximum(u, 0.0), curve.vacuum, drawn.shapes[place], np.zeros((3, 3)), file.brake
            )
            for axes in (whole, near):
                axes.plot(u * MM, force, color=colour, lw=1.0, alpha=0.55)
            for axes in (rest, close):
                left = (force - law) / float(curve.pull.peak_force)
                axes.plot(u * MM, left * 100, color=colour, lw=0.8, alpha=0.7)
        ends = []
        for one in order:
            place = int(np.flatnonzero(level == one)[0])
            members = [drawn.curves[i] for i in np.flatnonzero(level == one)]
            far = max(float(c.elongation[-1]) for c in members)
            end = _law(places, drawn, place, far, colours[one], file, one == order[0])
            ends.append((end, show(members[0].vacuum, "Pa"), colours[one]))
        _finish(places, ends, highest, max(float(c.pull.peak_elongation) for c in drawn.curves))
        _peaks(near, result)
        count = len(drawn.curves)
        words = f"{file.name}, {count} pull{'s' * (count > 1)}"
        words += ", synthetic data" if synthetic else ""
        title(whole, "Pulls and calibrated law", f"{words}; law dashed")
        numbers = f"k = {show(result.stiffness, 'N/m')}, a = {result.scale_factor:.4g}"
        title(near, "Near the peak", numbers + _sleeve(result))
        rest.set_title(_bands(drawn), fontsize=8.5, fontweight="normal", color=GREY)
    return figure


def _points(reduced: Reduced, place: int) -> tuple[np.ndarray, np.ndarray]:
    """Elongation and force of a curve, the fine stretches in fours, so that noise looks alike."""
    weight = reduced.weight[place]
    group = np.arange(len(weight))
    group[:FINE] = group[:FINE] // TOGETHER * TOGETHER
    total = np.bincount(group, weight)
    some = total > 0
    means = (
        np.bincount(group, weight * values[place])[some] / total[some]
        for values in (reduced.elongation, reduced.force)
    )
    u, force = means
    return u, force


def _law(
    places: Sequence[Axes],
    drawn: Drawn,
    place: int,
    far: float,
    colour: str,
    file: BrakeFile,
    below: bool,
) -> float:
    """The law at one vacuum with its bands, around zero too if `below`; its force at the end."""
    vacuum, shape = drawn.curves[place].vacuum, drawn.shapes[place]
    near_end = NEAR * float(drawn.curves[place].pull.peak_elongation)
    u = np.concatenate([np.linspace(0, near_end, POINTS), np.linspace(0, far, POINTS)])
    u = np.unique(u)
    u = u[u <= far]
    whole, near, rest, close = places
    peak = float(drawn.curves[place].pull.peak_force)
    if drawn.sure is not None and drawn.scatter is not None:
        for covariance, depth in (
            (drawn.sure[place] + drawn.scatter[place], 0.13), (drawn.sure[place], 0.30),
        ):  # fmt: skip
            law, error = law_with_error(u, vacuum, shape, covariance, file.brake)
            wide = drawn.t * error
            for axes in (whole, near):
                axes.fill_between(u * MM, law - wide, law + wide, color=colour, alpha=depth, lw=0)
            for axes in (rest, close) if below else ():
                axes.fill_between(
                    u * MM, -wide / peak * 100, wide / peak * 100, color=colour,
                    alpha=depth / 2, lw=0,
                )  # fmt: skip
    law, _ = law_with_error(u, vacuum, shape, np.zeros((3, 3)), file.brake)
    for axes in (whole, near):
        axes.plot(u * MM, law, color=colour, lw=1.3, ls=(0, (5, 2)))
    return float(law[-1])


def _finish(
    places: Sequence[Axes], ends: Sequence[tuple[float, str, str]], highest: float, peak: float
) -> None:
    whole, near, rest, close = places
    whole.set(ylabel="force [N]", ylim=(0, highest * 1.15), xlim=(0, None))
    near.set(xlim=(0, NEAR * peak * MM))
    rest.set(xlabel="elongation [mm]", ylabel="pull − law [% of peak]")
    close.set(xlabel="elongation [mm]")
    low, high = rest.get_ylim()
    most = min(max(abs(low), abs(high)), 30.0)
    rest.set_ylim(-most, most)
    for axes in (rest, close):
        axes.axhline(0, color=FAINT, lw=1)
    labels_right(whole, whole.get_xlim()[1], ends)


def _peaks(near: Axes, result: Any) -> None:
    """At depth exact: the fitted peaks and the slope that gave k."""
    if not isinstance(result, Calibration):
        return
    for one in result.fits:
        near.plot(one.pull.peak_elongation * MM, one.pull.peak_force, "o", color=RED, ms=4)
    top = max(result.fits, key=lambda one: one.pull.peak_force).pull
    line = np.array([0, top.peak_force / result.stiffness])
    near.plot(line * MM, result.stiffness * line, color=ORANGE, lw=1.5)
    x, y = near.get_xlim()[1] * 0.97, near.get_ylim()[1] * 0.12
    label(near, x, y, "slope k (orange)\nfitted peaks (red)", GREY, ha="right")


def _sleeve(result: Any) -> str:
    factor = getattr(result, "values", {}).get("enclosure_factor")
    return "" if factor is None else f", sleeve × {factor:.3g}"


def _bands(drawn: Drawn) -> str:
    if drawn.sure is None:
        return "one pull: no repeats tell how sure the law is"
    return "bands, 95 %: the law (dark), a further pull (pale)"


def _drawn(result: Any) -> Drawn:
    if isinstance(result, Calibration):
        return _of_exact(result)
    if isinstance(result, CurvesCalibration):
        return _of_curves(result)
    return _of_draws(result)


def _of_exact(result: Calibration) -> Drawn:
    curves = tuple(
        Curve(
            elongation=f.pull.elongation, force=f.pull.force, vacuum=f.vacuum, speed=None,
            repeat=None, path=f.pull.path, pull=f.pull,
        )
        for f in result.fits
    )  # fmt: skip
    count = len(curves)
    shape = np.array([result.scale_factor, result.stiffness, 1.0])
    spread = np.array([
        [np.log(f.scale_factor), np.log(f.stiffness), 0.0] for f in result.fits
    ])  # fmt: skip
    scatter = np.atleast_2d(np.cov(spread.T)) if count > 1 else None
    every = (count, 1, 1)
    return Drawn(
        curves=curves,
        shapes=np.tile(shape, (count, 1)),
        origins=np.zeros(count),
        offsets=np.zeros(count),
        sure=None if scatter is None else np.tile(scatter / count, every),
        scatter=None if scatter is None else np.tile(scatter, every),
        t=quantile(count - 1) if count > 1 else float("nan"),
    )


def _of_curves(result: CurvesCalibration) -> Drawn:
    fit, count = result.fit, len(result.curves)
    expected = fit.design @ fit.population.estimate + fit.held
    covariance = fit.population.covariance()
    sure = fit.design @ covariance @ np.swapaxes(fit.design, 1, 2)
    degrees = count - (len(fit.names) - 2)
    away = fit.own.own[:, :3] - expected
    known = degrees > 0 and bool(np.isfinite(covariance).all())
    return Drawn(
        curves=result.curves,
        shapes=np.array([fit.shape(i) for i in range(count)]),
        origins=fit.own.own[:, 3] * fit.reduced.onset,
        offsets=fit.own.own[:, 4] * fit.reduced.height,
        sure=sure if known else None,
        scatter=np.tile(away.T @ away / degrees, (count, 1, 1)) if known else None,
        t=quantile(degrees) if known else float("nan"),
    )


def _of_draws(result: Any) -> Drawn:
    """A posterior, taken as normal in (ln a, ln k, factor), which it nearly is."""
    fit, count = result.fit, len(result.curves)
    draws = np.column_stack([
        np.log(fit.scale_factor.ravel()), np.log(fit.stiffness.ravel()),
        fit.enclosure_factor.ravel(),
    ])  # fmt: skip
    shape = np.array([result.scale_factor, result.stiffness, result.values["enclosure_factor"]])
    repeats = np.median(fit.scale_factor_sd) ** 2, np.median(fit.stiffness_sd) ** 2, 0.0
    every = (count, 1, 1)
    return Drawn(
        curves=result.curves,
        shapes=np.tile(shape, (count, 1)),
        origins=np.median(fit.slack, axis=(0, 1)),
        offsets=np.zeros(count),
        sure=np.tile(np.cov(draws.T), every),
        scatter=np.tile(np.diag(repeats), every),
        t=quantile(1e6),
    )
