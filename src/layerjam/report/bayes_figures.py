"""Figures of a Bayesian calibration: posterior, bands over curves, vacuum for a force."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.errors import count_of
from layerjam.identify.bayes.model import Prior
from layerjam.identify.bayes.posterior import BayesFit, Population
from layerjam.identify.bayes.predictive import Band, force_band, vacuum_band
from layerjam.identify.curves import Curve, levels
from layerjam.mechanics.pull import force_limits
from layerjam.report import style
from layerjam.report.style import BLUE, GREY, INK, KPA, MM, ORANGE, RED, VACUUMS
from layerjam.units import show

WIDE, INNER = (0.025, 0.975), (0.25, 0.75)
Array = np.ndarray[Any, Any]


@style.styled
def posterior(fit: BayesFit) -> style.Figure:
    """Scale factor and stiffness: posterior of the brake, of the next pull, curves, prior."""
    figure, panels = style.canvas(columns=2, width=9.6, height=4.0)
    parts = ("scale_factor", 1.0, ""), ("stiffness", 1e-3, "kN/m")
    for axes, (name, scale, unit) in zip(panels, parts, strict=True):
        brake = getattr(fit, name).ravel() * scale
        own = np.median(getattr(fit, f"curve_{name}"), axis=(0, 1)) * scale
        after = getattr(fit.next_pull(), name) * scale
        _densities(axes, brake, after, own, fit.priors[name], scale)
        words = name.replace("_", " ")
        low, middle, high = np.quantile(brake, [WIDE[0], 0.5, WIDE[1]])
        of = f"{middle:.4g} {unit}".strip()
        detail = f"{of} (95 %: {low:.4g} to {high:.4g}) from {len(own)} curves"
        below = f"{words} [{unit or '-'}]\nprior: {fit.priors[name].text()}"
        density = f"probability density [{f'1/({unit})' if unit else '-'}]"
        style.panel(axes, words.capitalize(), detail, xlabel=below, ylabel=density, yticks=[])
    return figure


def _densities(
    axes: style.Axes, brake: Array, after: Array, own: Array, prior: Prior, scale: float
) -> None:
    low, high = np.quantile(after, [0.015, 0.985])
    low, high = min(low, float(own.min())), max(high, float(own.max()))
    middle, reach = (low + high) / 2, 0.62 * (high - low)
    x = np.linspace(max(middle - reach, 1e-9), middle + reach, 500)
    width = (np.log(x / scale) - prior.place) / prior.sd
    believed = np.exp(-(width**2) / 2) / (x * prior.sd * np.sqrt(2 * np.pi))
    style.band(axes, x, 0, believed, GREY, 0.25)
    top = 0.0
    for draws, color, strength in ((after, ORANGE, 0.18), (brake, BLUE, 0.22)):
        dense = _density(draws, x)
        style.band(axes, x, 0, dense, color, strength)
        axes.plot(x, dense, color=color)
        top = max(top, float(dense.max()))
    axes.plot(own, np.full(len(own), -0.035 * top), "|", color=INK, ms=9, mew=1.2)
    axes.set(xlim=(x[0], x[-1]), ylim=(-0.075 * top, 1.12 * top))
    names = ("the brake", BLUE), ("the next pull", ORANGE), ("prior", GREY), ("curves", INK)
    style.key(axes, *names)


def _density(draws: Array, x: Array) -> Array:
    """Smoothed histogram, its width from the quartiles, which heavy tails do not widen."""
    quartiles = np.quantile(draws, [0.25, 0.75])
    width = 1.3 * float(np.ptp(quartiles)) / 1.34 * len(draws) ** -0.2
    kept = draws[np.abs(draws - draws.mean()) < 50 * max(width, 1e-300) + np.ptp(x)]
    z = (x[:, None] - kept[None]) / width
    return np.asarray(np.exp(-(z**2) / 2).sum(axis=1) / (len(draws) * width * np.sqrt(2 * np.pi)))


class _Level:
    """The curves at one vacuum, and the band in which the next pull there is expected."""

    def __init__(self, curves: Sequence[Curve], color: str, after: Population) -> None:
        self.curves, self.color = curves, color
        self.vacuum = float(np.mean([c.vacuum for c in curves]))
        self.far = far = max(float(c.elongation[-1]) for c in curves)
        self.u = np.union1d(np.linspace(0, 0.1 * far, 90), np.linspace(0.1 * far, far, 160))
        self.band: Band = force_band(after, self.u, self.vacuum, measured=True)
        self.count = count_of(len(curves), "curve")

    def fill(self, axes: style.Axes, less: Any = 0.0, factor: float = 1.0) -> None:
        """50 and 95 % of the next pull, less some curve."""
        for part, strength in ((WIDE, 0.22), (INNER, 0.30)):
            low, high = ((self.band.at(q) - less) * factor for q in part)
            style.band(axes, self.u * MM, low, high, self.color, strength)


def _levels(fit: BayesFit, curves: Sequence[Curve]) -> list[_Level]:
    """Curves at one vacuum (within 3 %) together, the greatest vacuum first."""
    level = levels([c.vacuum for c in curves])
    order = sorted({*level}, reverse=True)
    groups = [[c for c, n in zip(curves, level, strict=True) if n == one] for one in order]
    after, colors = fit.next_pull(), [*VACUUMS, *VACUUMS[-1:] * len(groups)]
    return [_Level(group, color, after) for group, color in zip(groups, colors, strict=False)]


@style.styled
def bands(fit: BayesFit, curves: Sequence[Curve], samples: int = 900) -> style.Figure:
    """Measured curves on what the next pull is expected to show, one band for each vacuum."""
    figure, (axes,) = style.canvas(width=7.4, height=4.8)
    ends, most = [], 0.0
    for one in _levels(fit, curves):
        one.fill(axes)
        for curve in one.curves:
            step = max(1, len(curve.force) // samples)
            u, force = curve.elongation[::step] * MM, curve.force[::step]
            axes.plot(u, force, color=one.color, lw=0.7, alpha=0.9)
        words = f"{show(one.vacuum, 'Pa', 3)}, {one.count}"
        ends.append((float(one.band.at(0.5)[-1]), words, one.color))
        most = max(most, one.far)
    detail = "lines: measured; bands: 50 and 95 % of the next pull"
    axes.set(xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, most * MM), ylim=(0, None))
    style.title(axes, "Measured pulls and the next one", detail)
    style.labels_right(axes, most * MM, ends)
    return figure


@style.styled
def deviations(fit: BayesFit, curves: Sequence[Curve], samples: int = 400) -> style.Figure:
    """How far measured curves lie from the median of the next pull, a panel for each vacuum.

    In percent of the greatest force; curves are means over some tens of samples.
    """
    found = _levels(fit, curves)[:4]
    figure, panels = style.canvas(
        columns=len(found), width=1 + 3.2 * len(found), height=3.6, sharey=True
    )
    for axes, one in zip(panels, found, strict=True):
        middle = one.band.at(0.5)
        part = 100 / float(middle.max())
        one.fill(axes, middle, part)
        for curve in one.curves:
            size = max(1, len(curve.force) // samples)
            x, y = (
                v[: len(v) // size * size].reshape(-1, size).mean(axis=1)
                for v in (curve.elongation, curve.force)
            )
            left = (y - np.interp(x, one.u, middle)) * part
            axes.plot(x * MM, left, color=one.color, lw=0.9)
        axes.axhline(0, color=GREY, lw=0.8)
        headline = show(one.vacuum, "Pa", 3)
        style.panel(axes, headline, one.count, xlabel="elongation [mm]", xlim=(0, one.far * MM))
    panels[0].set_ylabel("off the next pull's median\n[% of the greatest force]")
    return figure


@style.styled
def vacuum_for_force(
    fit: BayesFit, slip: float | None = None, asked: float | None = None
) -> style.Figure:
    """The vacuum that gives a force, with its band, and how likely none does.

    At a `slip` [m], a third of the usable travel unless given; `asked` [N] is marked with its
    vacuum in words.
    """
    at = fit.brake.sheets.usable_travel / 3 if slip is None else slip
    after, atmosphere = fit.next_pull(), float(fit.brake.site.atmosphere)
    least, most = (np.asarray(x) for x in force_limits(at, after.brakes()))
    span = float(np.quantile(most, 0.995)) * 1.03
    force = np.linspace(float(np.median(least)), span, 240)
    band = vacuum_band(after, force, at)
    figure, (axes, chance) = style.canvas(rows=2, width=6.8, height=5.6, height_ratios=(3.2, 1))
    for part, strength in ((WIDE, 0.22), (INNER, 0.32)):
        below, above = (np.clip(band.at(q), 0, atmosphere) * KPA for q in part)
        style.band(axes, force, below, above, BLUE, strength)
    middle = np.where(np.isfinite(band.at(0.5)), band.at(0.5), np.nan)
    axes.plot(force, middle * KPA, color=BLUE)
    axes.set(xlim=(0, span), ylim=(0, atmosphere * 1.12 * KPA), xlabel="required force [N]")
    style.level(axes, atmosphere * KPA, "all the site gives")
    if asked is not None:
        _mark(axes, fit, asked, at)
    detail = "median, 50 and 95 % of the next pull"
    style.panel(axes, "Vacuum for a force", detail, ylabel="vacuum needed [kPa]")
    style.band(chance, force, 0, 100 * band.chances["too strong"], RED, 0.35)
    chance.set(xlabel=f"required force at {show(at, 'm')} of slip [N]", xlim=(0, span))
    chance.set(ylabel="no vacuum\ndoes it [%]", ylim=(0, 100), yticks=[0, 50, 100])
    return figure


def _mark(axes: style.Axes, fit: BayesFit, asked: float, at: float) -> None:
    band = vacuum_band(fit.next_pull(), asked, at)
    low, middle, high = (float(band.at(q)[0]) for q in (WIDE[0], 0.5, WIDE[1]))
    if not np.isfinite([low, middle]).all():
        return
    top = min(high, float(fit.brake.site.atmosphere))
    axes.plot([asked, asked], [low * KPA, top * KPA], color=INK, lw=1.2)
    most = show(high, "Pa") if np.isfinite(high) else "none"
    words = f"{asked:.4g} N: {show(middle, 'Pa')}\n(95 %: {show(low, 'Pa')} to {most})"
    style.spot(axes, asked, middle * KPA, words, INK, ms=4.5)
