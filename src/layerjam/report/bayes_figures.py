"""Figures of a Bayesian calibration: posterior, bands over curves, vacuum for a force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.identify.bayes.model import Prior
from layerjam.identify.bayes.posterior import BayesFit
from layerjam.identify.bayes.predictive import force_band, vacuum_band
from layerjam.identify.curves import Curve
from layerjam.mechanics.pull import force_limits
from layerjam.report.style import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    RED,
    VACUUMS,
    canvas,
    label,
    labels_right,
    look,
    save,
    title,
)
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["bands", "deviations", "posterior", "save", "vacuum_for_force"]
WIDE, INNER = (0.025, 0.975), (0.25, 0.75)
Array = np.ndarray[Any, Any]


def posterior(fit: BayesFit) -> Figure:
    """Scale factor and stiffness: posterior of the brake, of the next pull, curves, prior."""
    parts = (
        ("scale_factor", "scale factor", 1.0, ""), ("stiffness", "stiffness", 1e-3, "kN/m"),
    )  # fmt: skip
    with look():
        figure, axes = canvas(columns=2, width=9.6, height=4.0)
        for place, (name, words, scale, unit) in zip(axes, parts, strict=True):
            brake = getattr(fit, name).ravel() * scale
            own = np.median(getattr(fit, f"curve_{name}"), axis=(0, 1)) * scale
            after = getattr(fit.next_pull(), name) * scale
            _densities(place, brake, after, own, fit.priors[name], scale)
            axis = f"{words} [{unit}]" if unit else words
            place.set(xlabel=f"{axis}\nprior: {fit.priors[name].text()}")
            place.set(yticks=[], ylabel="probability density")
            low, middle, high = np.quantile(brake, [WIDE[0], 0.5, WIDE[1]])
            of = f"{middle:.4g} {unit}".strip()
            detail = f"{of} (95 %: {low:.4g} to {high:.4g}) from {len(own)} curves"
            title(place, words.capitalize(), detail)
    return figure


def _densities(
    axes: Axes, brake: Array, after: Array, own: Array, prior: Prior, scale: float
) -> None:
    low, high = np.quantile(after, [0.015, 0.985])
    low, high = min(low, float(own.min())), max(high, float(own.max()))
    middle, reach = (low + high) / 2, 0.62 * (high - low)
    x = np.linspace(max(middle - reach, 1e-9), middle + reach, 500)
    width = (np.log(x / scale) - prior.place) / prior.sd
    believed = np.exp(-(width**2) / 2) / (x * prior.sd * np.sqrt(2 * np.pi))
    axes.fill_between(x, believed, color=GREY, alpha=0.25, lw=0)
    top = 0.0
    for draws, color, strength in ((after, ORANGE, 0.18), (brake, BLUE, 0.22)):
        dense = _density(draws, x)
        axes.fill_between(x, dense, color=color, alpha=strength, lw=0)
        axes.plot(x, dense, color=color)
        top = max(top, float(dense.max()))
    axes.plot(own, np.full(len(own), -0.035 * top), "|", color=INK, ms=9, mew=1.2)
    axes.set(xlim=(x[0], x[-1]), ylim=(-0.075 * top, 1.12 * top))
    for row, (text, color) in enumerate((
        ("the brake", BLUE), ("the next pull", ORANGE), ("prior", GREY),
        ("curves (medians)", INK),
    )):  # fmt: skip
        label(axes, 0.03, 0.94 - 0.075 * row, text, color, transform=axes.transAxes)


def _density(draws: Array, x: Array) -> Array:
    """Smoothed histogram its width from the quartiles, which heavy tails do not widen."""
    quartiles = np.quantile(draws, [0.25, 0.75])
    width = 1.3 * float(np.ptp(quartiles)) / 1.34 * len(draws) ** -0.2
    kept = draws[np.abs(draws - draws.mean()) < 50 * max(width, 1e-300) + np.ptp(x)]
    z = (x[:, None] - kept[None]) / width
    return np.asarray(np.exp(-(z**2) / 2).sum(axis=1) / (len(draws) * width * np.sqrt(2 * np.pi)))


def bands(fit: BayesFit, curves: Sequence[Curve], samples: int = 900) -> Figure:
    """Measured curves on what the next pull is expected to show, one band for each vacuum."""
    after = fit.next_pull()
    levels = _levels([c.vacuum for c in curves])
    with look():
        figure, (axes,) = canvas(width=7.4, height=4.8)
        ends, most = [], 0.0
        for row, members in enumerate(levels):
            color = VACUUMS[min(row, len(VACUUMS) - 1)]
            group = [curves[i] for i in members]
            vacuum = float(np.mean([c.vacuum for c in group]))
            far = max(float(c.elongation[-1]) for c in group)
            u = np.unique(np.concatenate([
                np.linspace(0, 0.1 * far, 90), np.linspace(0.1 * far, far, 160)
            ]))  # fmt: skip
            band = force_band(after, u, vacuum, measured=True)
            for (low, high), strength in ((WIDE, 0.22), (INNER, 0.30)):
                axes.fill_between(
                    u * 1e3, band.at(low), band.at(high), color=color, alpha=strength, lw=0
                )
            for curve in group:
                step = max(1, len(curve.force) // samples)
                axes.plot(
                    curve.elongation[::step] * 1e3, curve.force[::step], color=color, lw=0.7,
                    alpha=0.9,
                )  # fmt: skip
            repeats = f"{len(group)} curve{'s' * (len(group) > 1)}"
            ends.append((float(band.at(0.5)[-1]), f"{show(vacuum, 'Pa', 3)}, {repeats}", color))
            most = max(most, far)
        axes.set(xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, most * 1e3), ylim=(0, None))
        labels_right(axes, most * 1e3, ends)
        title(
            axes, "Measured pulls and the next one",
            "lines: measured; bands: 50 and 95 % of the next pull",
        )  # fmt: skip
    return figure


def deviations(fit: BayesFit, curves: Sequence[Curve], samples: int = 400) -> Figure:
    """How far measured curves lie from the median of the next pull, a panel for each vacuum.

    In percent of the greatest force; curves are means over some tens of samples.
    """
    after, levels = fit.next_pull(), _levels([c.vacuum for c in curves])[:4]
    with look():
        figure, axes = canvas(columns=len(levels), width=3.4 * len(levels), height=3.6, sharey=True)
        for row, (place, members) in enumerate(zip(axes, levels, strict=True)):
            group, color = [curves[i] for i in members], VACUUMS[min(row, len(VACUUMS) - 1)]
            vacuum = float(np.mean([c.vacuum for c in group]))
            far = max(float(c.elongation[-1]) for c in group)
            u = np.concatenate([np.linspace(0, 0.1 * far, 90), np.linspace(0.101 * far, far, 160)])
            band = force_band(after, u, vacuum, measured=True)
            middle = band.at(0.5)
            part = 100 / float(middle.max())
            for (low, high), strength in ((WIDE, 0.22), (INNER, 0.30)):
                below, above = ((band.at(q) - middle) * part for q in (low, high))
                place.fill_between(u * 1e3, below, above, color=color, alpha=strength, lw=0)
            for curve in group:
                size = max(1, len(curve.force) // samples)
                x, y = (
                    v[: len(v) // size * size].reshape(-1, size).mean(axis=1)
                    for v in (curve.elongation, curve.force)
                )
                place.plot(x * 1e3, (y - np.interp(x, u, middle)) * part, color=color, lw=0.9)
            place.axhline(0, color=GREY, lw=0.8)
            place.set(xlabel="elongation [mm]", xlim=(0, far * 1e3))
            title(place, show(vacuum, "Pa", 3), f"{len(group)} curve{'s' * (len(group) > 1)}")
        axes[0].set(ylabel="off the next pull's median\n[% of the greatest force]")
    return figure


def _levels(vacuums: Sequence[float]) -> list[list[int]]:
    """Places of curves at one vacuum (within 3 %), greatest vacuum first."""
    order = sorted(range(len(vacuums)), key=lambda i: -vacuums[i])
    out: list[list[int]] = []
    for i in order:
        if out and vacuums[i] > 0.97 * vacuums[out[-1][0]]:
            out[-1].append(i)
        else:
            out.append([i])
    return out


def vacuum_for_force(
    fit: BayesFit, slip: float | None = None, asked: float | None = None
) -> Figure:
    """The vacuum that gives a force, with its band, and how likely none does.

    At a `slip` [m], a third of the usable travel unless given; `asked` [N] is marked with its
    answer in words.
    """
    place = fit.brake.sheets.usable_travel / 3 if slip is None else slip
    after, atmosphere = fit.next_pull(), float(fit.brake.site.atmosphere)
    least, most = (np.asarray(x) for x in force_limits(place, after.brakes()))
    span = float(np.quantile(most, 0.995)) * 1.03
    force = np.linspace(float(np.median(least)), span, 240)
    band = vacuum_band(after, force, place)
    with look():
        figure, (axes, chance) = canvas(rows=2, width=6.8, height=5.6, height_ratios=(3.2, 1))
        for (low, high), strength in ((WIDE, 0.22), (INNER, 0.32)):
            below, above = (np.clip(band.at(q), 0, atmosphere) * 1e-3 for q in (low, high))
            axes.fill_between(force, below, above, color=BLUE, alpha=strength, lw=0)
        middle = np.where(np.isfinite(band.at(0.5)), band.at(0.5), np.nan)
        axes.plot(force, middle * 1e-3, color=BLUE)
        axes.axhline(atmosphere * 1e-3, color=RED, lw=1, ls=(0, (4, 3)))
        label(axes, force[0], atmosphere * 1e-3 * 1.045, "all the site gives", RED)
        axes.set(ylabel="vacuum needed [kPa]", xlim=(0, span), ylim=(0, atmosphere * 1.1e-3))
        chance.fill_between(force, 100 * band.chances["too strong"], color=RED, alpha=0.35, lw=0)
        chance.set(xlabel=f"force wanted at {show(place, 'm')} of slip [N]", ylim=(0, 100))
        chance.set(ylabel="no vacuum\ndoes it [%]", xlim=(0, span), yticks=[0, 50, 100])
        if asked is not None:
            _mark(axes, fit, asked, place)
        title(axes, "Vacuum for a force", "median, 50 and 95 % of the next pull")
    return figure


def _mark(axes: Axes, fit: BayesFit, asked: float, place: float) -> None:
    band = vacuum_band(fit.next_pull(), asked, place)
    low, middle, high = (float(band.at(q)[0]) for q in (WIDE[0], 0.5, WIDE[1]))
    if not np.isfinite([low, middle]).all():
        return
    top = min(high, float(fit.brake.site.atmosphere))
    axes.plot([asked, asked], [low * 1e-3, top * 1e-3], color=INK, lw=1.2)
    axes.plot(asked, middle * 1e-3, "o", color=INK, ms=4.5)
    axes.annotate(
        f"{asked:.4g} N: {show(middle, 'Pa')}\n(95 %: {show(low, 'Pa')} to "
        f"{show(high, 'Pa') if np.isfinite(high) else 'none'})",
        (asked, middle * 1e-3), xytext=(14, -34), textcoords="offset points", fontsize=8.8,
        color=INK, va="top",
    )  # fmt: skip
