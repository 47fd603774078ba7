"""The figure of a calibration: pulls, the fitted law with its bands, and what is left of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import count_of
from layerjam.identify.calibration.forward import FINE, ReducedCurves, law_with_error, reduce
from layerjam.identify.calibration.law_spread import LawSpread
from layerjam.identify.calibration.least_squares import JointFit
from layerjam.identify.calibration.record import Calibration
from layerjam.identify.curves import Curve, levels
from layerjam.report import style
from layerjam.report.style import FAINT, GREY, MM, ORANGE, RED
from layerjam.units import show

POINTS = 200
TOGETHER = 4
NEAR = 4.0
"""The right half shows this times the elongation at the peak."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawn:
    """What the figure needs of a fit: by curve, its law and how sure that is.

    `shapes` (curves, 3) are (a, k, the enclosure's factor); `sure` and `scatter` (curves, 3, 3) the
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


@style.styled
def calibration(file: BrakeFile, result: Calibration, synthetic: bool) -> style.Figure:
    """Pulls and law over elongation, whole and near the peak; residuals below, part of the peak."""
    drawn = _drawn(result)
    figure, panels = style.canvas(
        2, 2, 9.6, 5.6, sharex="col", sharey="row", height_ratios=(2.1, 1), width_ratios=(1.25, 1)
    )
    whole, near, rest, close = panels
    level = np.array(levels([c.vacuum for c in drawn.curves]))
    names = {n: show(c.vacuum, "Pa") for n, c in zip(level[::-1], drawn.curves[::-1], strict=True)}
    order = sorted(names, reverse=True)
    colors = dict(zip(order, style.scheme([str(n) for n in order]).values(), strict=True))
    _curves(panels, drawn, [colors[n] for n in level], file.brake)
    ends = []
    for one in order:
        members = np.flatnonzero(level == one)
        far = max(float(drawn.curves[i].elongation[-1]) for i in members)
        below = (rest, close) if one == order[0] else ()
        end = _law((whole, near), below, drawn, int(members[0]), far, colors[one], file.brake)
        ends.append((end, names[one], colors[one]))
    highest = max(float(c.pull.peak_force) for c in drawn.curves)
    peak = max(float(c.pull.peak_elongation) for c in drawn.curves)
    count = len(drawn.curves)
    words = f"{file.name}, {count_of(count, 'pull')}" + ", synthetic data" * synthetic
    style.panel(whole, ylabel="force [N]", ylim=(0, highest * 1.15), xlim=(0, None))
    style.title(whole, "Pulls and calibrated law", f"{words}; law dashed")
    style.labels_right(whole, whole.get_xlim()[1], ends)
    near.set_xlim(0, NEAR * peak * MM)
    factor = result.values.get("enclosure_factor")
    numbers = f"k = {show(result.stiffness, 'N/m')}, a = {result.scale_factor:.4g}"
    numbers += "" if factor is None else f", enclosure × {factor:.3g}"
    style.title(near, "Near the peak", numbers)
    if result.fit is None:
        _peaks(near, result)
    sure = "bands, 95 %: the law (dark), a further pull (pale)"
    words = "one pull: no repeats tell how sure the law is" if drawn.sure is None else sure
    rest.set_title(words, fontsize=8.5, fontweight="normal", color=GREY)
    most = min(max(abs(edge) for edge in rest.get_ylim()), 30.0)
    style.panel(rest, ylabel="pull − law [% of peak]", ylim=(-most, most))
    for axes in (rest, close):
        axes.axhline(0, color=FAINT, lw=1)
        axes.set(xlabel="elongation [mm]")
    return figure


def _curves(
    panels: Sequence[style.Axes], drawn: Drawn, colors: Sequence[str], brake: Brake
) -> None:
    """The pulls over elongation, and what the law leaves of them, in percent of the peak."""
    whole, near, rest, close = panels
    reduced = reduce(drawn.curves)
    for index, curve in enumerate(drawn.curves):
        u, force = _points(reduced, index)
        u, force = u - drawn.origins[index], force - drawn.offsets[index]
        law, _ = law_with_error(
            np.maximum(u, 0.0), curve.vacuum, drawn.shapes[index], np.zeros((3, 3)), brake
        )
        left = (force - law) / float(curve.pull.peak_force) * 100
        for axes in (whole, near):
            axes.plot(*style.thinned(u * MM, force, 200), color=colors[index], lw=1.0, alpha=0.55)
        for axes in (rest, close):
            axes.plot(*style.thinned(u * MM, left, 200), color=colors[index], lw=0.8, alpha=0.7)


def _points(reduced: ReducedCurves, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Elongation and force of a curve, the fine stretches in fours, so that noise looks alike."""
    weight = reduced.weight[index]
    group = np.arange(len(weight))
    group[:FINE] = group[:FINE] // TOGETHER * TOGETHER
    total = np.bincount(group, weight)
    some = total > 0
    u, force = (
        np.bincount(group, weight * values[index])[some] / total[some]
        for values in (reduced.elongation, reduced.force)
    )
    return u, force


def _law(
    panels: Sequence[style.Axes],
    below: Sequence[style.Axes],
    drawn: Drawn,
    index: int,
    far: float,
    color: str,
    brake: Brake,
) -> float:
    """The law at one vacuum with its bands, these about zero too `below`; its force at the end."""
    curve, shape = drawn.curves[index], drawn.shapes[index]
    close = NEAR * float(curve.pull.peak_elongation)
    u = np.union1d(np.linspace(0, close, POINTS), np.linspace(0, far, POINTS))
    u = u[u <= far]
    law, _ = law_with_error(u, curve.vacuum, shape, np.zeros((3, 3)), brake)
    for axes in panels:
        axes.plot(u * MM, law, color=color, lw=1.3, ls=style.DASHED)
    if drawn.sure is not None and drawn.scatter is not None:
        sure = drawn.sure[index]
        for covariance, strength in ((sure + drawn.scatter[index], 0.13), (sure, 0.30)):
            wide = drawn.t * law_with_error(u, curve.vacuum, shape, covariance, brake)[1]
            part = wide / float(curve.pull.peak_force) * 100
            for axes in panels:
                style.band(axes, u * MM, law - wide, law + wide, color, strength)
            for axes in below:
                style.band(axes, u * MM, -part, part, color, strength / 2)
    return float(law[-1])


def _peaks(near: style.Axes, result: Calibration) -> None:
    """By the exact method: the fitted peaks and the slope that gave k."""
    for one in result.fits:
        style.spot(near, one.pull.peak_elongation * MM, one.pull.peak_force, ms=4)
    top = max(one.pull.peak_force for one in result.fits)
    near.plot([0, top / result.stiffness * MM], [0, top], color=ORANGE, lw=1.5)
    style.key(near, ("slope k", ORANGE), ("fitted peaks", RED, "o"), at="lower right")


def _drawn(result: Calibration) -> Drawn:
    count, fit = len(result.curves), result.fit
    spread = LawSpread.from_calibration(result)
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
    return Drawn(
        curves=result.curves,
        shapes=shapes,
        origins=origins,
        offsets=offsets,
        sure=None
        if spread is None
        else np.array([spread.sure(c.vacuum, c.speed) for c in result.curves]),
        scatter=None if spread is None else np.tile(spread.scatter, (count, 1, 1)),
        t=spread.t if spread else float("nan"),
    )
