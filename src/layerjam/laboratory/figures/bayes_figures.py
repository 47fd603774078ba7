"""Figures of a Bayesian calibration: posterior, bands over curves, vacuum for a force."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.brake.mechanics.pull import force_limits
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREY, INK, KPA, MM, ORANGE, RED, VACUUMS
from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.bayes.model import Prior
from layerjam.laboratory.identify.bayes.posterior import BayesFit, Population
from layerjam.laboratory.identify.bayes.predictive import Band, force_band, vacuum_band
from layerjam.laboratory.identify.curves import Curve, number_levels

WIDE, INNER = (0.025, 0.975), (0.25, 0.75)
Array = np.ndarray[Any, Any]


@style.use_style
def posterior(fit: BayesFit) -> style.Figure:
    """Draw the prior and posterior of scale factor and stiffness, and the median of each curve."""
    figure, panels = style.make_axes(columns=2, width=9.6, height=4.0)
    parts = ("scale_factor", 1.0, ""), ("stiffness", 1e-3, "kN/m")
    for axes, (name, scale, unit) in zip(panels, parts, strict=True):
        brake = getattr(fit, name).ravel() * scale
        medians = np.median(getattr(fit, f"curve_{name}"), axis=(0, 1)) * scale
        next_pull = getattr(fit.next_pull(), name) * scale
        _draw_densities(axes, brake, next_pull, medians, fit.priors[name], scale)
        words = name.replace("_", " ")
        low, middle, high = np.quantile(brake, [WIDE[0], 0.5, WIDE[1]])
        estimate = f"{middle:.4g} {unit}".strip()
        detail = f"{estimate} (95 %: {low:.4g} to {high:.4g}) from {len(medians)} curves"
        x_label = f"{words} [{unit or '-'}]\nprior: {fit.priors[name].text()}"
        density = f"probability density [{f'1/({unit})' if unit else '-'}]"
        style.label_axes(
            axes, words.capitalize(), detail, xlabel=x_label, ylabel=density, yticks=[]
        )
    return figure


def _draw_densities(
    axes: style.Axes, brake: Array, after: Array, curves: Array, prior: Prior, scale: float
) -> None:
    low, high = np.quantile(after, [0.015, 0.985])
    low, high = min(low, float(curves.min())), max(high, float(curves.max()))
    middle, reach = (low + high) / 2, 0.62 * (high - low)
    x = np.linspace(max(middle - reach, 1e-9), middle + reach, 500)
    width = (np.log(x / scale) - prior.place) / prior.sd
    belief = np.exp(-(width**2) / 2) / (x * prior.sd * np.sqrt(2 * np.pi))
    style.add_band(axes, x, 0, belief, GREY, 0.25)
    top = 0.0
    for draws, color, strength in ((after, ORANGE, 0.18), (brake, BLUE, 0.22)):
        dense = _estimate_density(draws, x)
        style.add_band(axes, x, 0, dense, color, strength)
        axes.plot(x, dense, color=color)
        top = max(top, float(dense.max()))
    axes.plot(curves, np.full(len(curves), -0.035 * top), "|", color=INK, ms=9, mew=1.2)
    axes.set(xlim=(x[0], x[-1]), ylim=(-0.075 * top, 1.12 * top))
    names = ("the brake", BLUE), ("the next pull", ORANGE), ("prior", GREY), ("curves", INK)
    style.add_key(axes, *names)


def _estimate_density(draws: Array, x: Array) -> Array:
    """Return a smoothed histogram whose bandwidth follows from quartiles, not from heavy tails."""
    quartiles = np.quantile(draws, [0.25, 0.75])
    width = 1.3 * float(np.ptp(quartiles)) / 1.34 * len(draws) ** -0.2
    inner = draws[np.abs(draws - draws.mean()) < 50 * max(width, 1e-300) + np.ptp(x)]
    z = (x[:, None] - inner[None]) / width
    return np.asarray(np.exp(-(z**2) / 2).sum(axis=1) / (len(draws) * width * np.sqrt(2 * np.pi)))


class _Level:
    """The curves at one vacuum, and the band in which the next pull at that vacuum is expected."""

    def __init__(self, curves: Sequence[Curve], color: str, after: Population) -> None:
        self.curves, self.color = curves, color
        self.vacuum = float(np.mean([c.vacuum for c in curves]))
        self.end = end = max(float(c.elongation[-1]) for c in curves)
        self.u = np.union1d(np.linspace(0, 0.1 * end, 90), np.linspace(0.1 * end, end, 160))
        self.band: Band = force_band(after, self.u, self.vacuum, measured=True)
        self.count = count_text(len(curves), "curve")

    def fill_bands(self, axes: style.Axes, offset: Any = 0.0, factor: float = 1.0) -> None:
        """Draw the 50 and 95 % bands of the next pull, after subtracting `offset`."""
        for part, strength in ((WIDE, 0.22), (INNER, 0.30)):
            low, high = ((self.band.quantile_at(q) - offset) * factor for q in part)
            style.add_band(axes, self.u * MM, low, high, self.color, strength)


def _group_by_vacuum(fit: BayesFit, curves: Sequence[Curve]) -> list[_Level]:
    """Group the curves by vacuum (within 3 %), the highest vacuum first."""
    level = number_levels([c.vacuum for c in curves])
    order = sorted({*level}, reverse=True)
    groups = [[c for c, n in zip(curves, level, strict=True) if n == number] for number in order]
    next_pull, colors = fit.next_pull(), [*VACUUMS, *VACUUMS[-1:] * len(groups)]
    return [_Level(group, color, next_pull) for group, color in zip(groups, colors, strict=False)]


@style.use_style
def bands(fit: BayesFit, curves: Sequence[Curve], samples: int = 900) -> style.Figure:
    """Draw measured curves over the predicted band of the next pull at each vacuum."""
    figure, (axes,) = style.make_axes(width=7.4, height=4.8)
    ends, end = [], 0.0
    for level in _group_by_vacuum(fit, curves):
        level.fill_bands(axes)
        for curve in level.curves:
            step = max(1, len(curve.force) // samples)
            u, force = curve.elongation[::step] * MM, curve.force[::step]
            axes.plot(u, force, color=level.color, lw=0.7, alpha=0.9)
        words = f"{show(level.vacuum, 'Pa', 3)}, {level.count}"
        ends.append((float(level.band.quantile_at(0.5)[-1]), words, level.color))
        end = max(end, level.end)
    detail = "lines: measured; bands: 50 and 95 % of the next pull"
    axes.set(xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, end * MM), ylim=(0, None))
    style.add_title(axes, "Measured pulls and the next pull", detail)
    style.add_end_labels(axes, end * MM, ends)
    return figure


@style.use_style
def deviations(fit: BayesFit, curves: Sequence[Curve], samples: int = 400) -> style.Figure:
    """Draw the deviation of measured curves from the next pull's median, with one panel per vacuum.

    Deviations are in percent of the highest force; curves are means over a few tens of samples.
    """
    shown_levels = _group_by_vacuum(fit, curves)[:4]
    figure, panels = style.make_axes(
        columns=len(shown_levels), width=1 + 3.2 * len(shown_levels), height=3.6, sharey=True
    )
    for axes, level in zip(panels, shown_levels, strict=True):
        middle = level.band.quantile_at(0.5)
        part = 100 / float(middle.max())
        level.fill_bands(axes, middle, part)
        for curve in level.curves:
            size = max(1, len(curve.force) // samples)
            x, y = (
                v[: len(v) // size * size].reshape(-1, size).mean(axis=1)
                for v in (curve.elongation, curve.force)
            )
            residuals = (y - np.interp(x, level.u, middle)) * part
            axes.plot(x * MM, residuals, color=level.color, lw=0.9)
        axes.axhline(0, color=GREY, lw=0.8)
        headline = show(level.vacuum, "Pa", 3)
        style.label_axes(
            axes, headline, level.count, xlabel="elongation [mm]", xlim=(0, level.end * MM)
        )
    panels[0].set_ylabel("deviation from the next pull's median\n[% of the maximum force]")
    return figure


@style.use_style
def vacuum_for_force(
    fit: BayesFit, slip: float | None = None, target: float | None = None
) -> style.Figure:
    """Draw the vacuum required for a force, with its band, and the probability that none suffices.

    `slip` [m] is a third of the usable travel by default; `target` [N] is marked and labelled with
    its vacuum.
    """
    place = fit.brake.sheets.usable_travel / 3 if slip is None else slip
    next_pull, atmosphere = fit.next_pull(), float(fit.brake.site.atmosphere)
    lowest_force, highest_force = (np.asarray(x) for x in force_limits(place, next_pull.brakes()))
    span = float(np.quantile(highest_force, 0.995)) * 1.03
    force = np.linspace(float(np.median(lowest_force)), span, 240)
    band = vacuum_band(next_pull, force, place)
    figure, (axes, chance) = style.make_axes(rows=2, width=6.8, height=5.6, height_ratios=(3.2, 1))
    for part, strength in ((WIDE, 0.22), (INNER, 0.32)):
        below, above = (np.clip(band.quantile_at(q), 0, atmosphere) * KPA for q in part)
        style.add_band(axes, force, below, above, BLUE, strength)
    middle = np.where(np.isfinite(band.quantile_at(0.5)), band.quantile_at(0.5), np.nan)
    axes.plot(force, middle * KPA, color=BLUE)
    axes.set(xlim=(0, span), ylim=(0, atmosphere * 1.12 * KPA), xlabel="required force [N]")
    style.mark_y(axes, atmosphere * KPA, "full vacuum at the site")
    if target is not None:
        _mark_quantile(axes, fit, target, place)
    detail = "next pull: median, 50 and 95 % bands"
    style.label_axes(axes, "Vacuum required for a force", detail, ylabel="required vacuum [kPa]")
    style.add_band(chance, force, 0, 100 * band.chances["too strong"], RED, 0.35)
    chance.set(xlabel=f"required force at a slip of {show(place, 'm')} [N]", xlim=(0, span))
    chance.set(ylabel="no vacuum\nsuffices [%]", ylim=(0, 100), yticks=[0, 50, 100])
    return figure


def _mark_quantile(axes: style.Axes, fit: BayesFit, force: float, place: float) -> None:
    band = vacuum_band(fit.next_pull(), force, place)
    low, middle, high = (float(band.quantile_at(q)[0]) for q in (WIDE[0], 0.5, WIDE[1]))
    if not np.isfinite([low, middle]).all():
        return
    top = min(high, float(fit.brake.site.atmosphere))
    axes.plot([force, force], [low * KPA, top * KPA], color=INK, lw=1.2)
    upper = show(high, "Pa") if np.isfinite(high) else "none"
    words = f"{force:.4g} N: {show(middle, 'Pa')}\n(95 %: {show(low, 'Pa')} to {upper})"
    style.add_point(axes, force, middle * KPA, words, INK, ms=4.5)
