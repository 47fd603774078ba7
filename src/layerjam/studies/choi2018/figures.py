"""The paper's figures drawn from our model, the paper's printed numbers marked in them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.load import catalogue, load
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.mechanics.pull import brake_force, force_at_elongation, peak
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.report.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    VACUUMS,
    canvas,
    label,
    labels_right,
    look,
    title,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MM = 1e3
FIG4 = (94.5e3, 65.5e3, 31.0e3, 0.0)
FIG7 = (80.6e3, 46.1e3, 18.6e3)
FULL = 94.5e3
TESTED = 0.040
CALIBRATED = ("choi2018-kapton", "choi2018-ptfe")
NAMES = {
    "choi2018-kapton": "Kapton",
    "choi2018-polyester": "Polyester",
    "choi2018-ptfe": "PTFE",
    "choi2018-ptfe-fiberglass": "PTFE-coated fibreglass",
}


def _curve(vacuum: float, brake: Brake, end: float = TESTED) -> tuple[np.ndarray, np.ndarray]:
    """Elongation [mm] and force [N], dense around the onset."""
    k = float(working_stiffness(brake))
    near = 3 * float(peak(vacuum, end, brake).force) / k
    u = np.union1d(np.linspace(0, min(near, end), 300), np.linspace(0, end, 300))
    return u * MM, np.asarray(force_at_elongation(u, vacuum, brake))


def fig4() -> Figure:
    """Pulls of all four films at four vacuums."""
    with look():
        figure, all_axes = canvas(columns=2, rows=2, width=8.6, height=6.2, sharex=True)
        for axes, name in zip(all_axes, [n for n in NAMES if n in catalogue()], strict=True):
            file = load(name)
            ends = []
            for vacuum, color in zip(FIG4, VACUUMS, strict=True):
                u, force = _curve(vacuum, file.brake)
                axes.plot(u, force, color=color)
                ends.append((float(force[-1]), f"{vacuum / 1e3:.1f} kPa", color))
            axes.set(xlim=(0, TESTED * MM), ylim=(0, None))
            labels_right(axes, TESTED * MM, ends)
            guess = any(s.kind == "handbook" for p, s in file.sources.items() if "film.kin" in p)
            detail = "handbook friction, not calibrated" if guess else "calibrated by the paper"
            title(axes, NAMES[name], f"model; {detail}")
        for axes in all_axes[2:]:
            axes.set_xlabel("elongation [mm]")
        for axes in all_axes[::2]:
            axes.set_ylabel("force [N]")
    return figure


def fig7_9() -> Figure:
    """Model before (Fig. 7) and after calibration (Fig. 9) at the three test vacuums."""
    with look():
        figure, all_axes = canvas(columns=2, width=8.6, height=3.9)
        for axes, name in zip(all_axes, CALIBRATED, strict=True):
            brake = load(name).brake
            ends = []
            for vacuum, color in zip(FIG7, VACUUMS, strict=False):
                u, after = _curve(vacuum, brake)
                _, before = _curve(vacuum, replace(brake, scale_factor=1.0))
                before = np.interp(u, _curve(vacuum, replace(brake, scale_factor=1.0))[0], before)
                axes.fill_between(u, before, after, color=color, alpha=0.13, lw=0)
                axes.plot(u, before, color=color, lw=1.2, ls=(0, (4, 2)))
                axes.plot(u, after, color=color)
                ends.append((float(after[-1]), f"{vacuum / 1e3:.1f} kPa", color))
            axes.set(xlim=(0, TESTED * MM), ylim=(0, None), xlabel="elongation [mm]")
            labels_right(axes, TESTED * MM, ends)
            title(axes, NAMES[name], f"model: a = 1 (dashed), a = {brake.scale_factor:g} (solid)")
        all_axes[0].set_ylabel("force [N]")
    return figure


def fig8(exact: dict[str, dict[str, float]]) -> Figure:
    """The calibration pulls near their peaks, with the paper's two stiffnesses as lines.

    `exact` holds for each film what the procedure gave: scale_factor, eq9 [N/m].
    """
    text, caption = (
        {"choi2018-kapton": 131e3, "choi2018-ptfe": 55e3},
        {
            "choi2018-kapton": 107e3,
            "choi2018-ptfe": 42e3,
        },
    )
    with look():
        figure, all_axes = canvas(columns=2, width=8.6, height=3.9)
        for axes, name in zip(all_axes, CALIBRATED, strict=True):
            brake = load(name).brake
            top = peak(FULL, TESTED, brake)
            end = 3.2 * float(top.elongation)
            u, force = _curve(FULL, brake, end)
            high = float(top.force)
            for k, color, words, place in (
                (text[name], ORANGE, f"text: {text[name] / 1e3:.0f} kN/m", 0.80),
                (caption[name], PURPLE, f"caption: {caption[name] / 1e3:.0f} kN/m", 0.55),
                (
                    exact[name]["eq9"],
                    GREEN,
                    f"eq. 9 on our curve: {exact[name]['eq9'] / 1e3:.0f} kN/m",
                    0.3,
                ),
            ):
                axes.plot(
                    [0, high / k * MM], [0, high], color=color, lw=1.5, ls=(0, (4, 2)), zorder=3
                )
                # right of all three lines, so that no word lies on one
                softest = min(text[name], caption[name], exact[name]["eq9"])
                right = high * place / softest * MM + 0.03 * end * MM
                label(axes, right, high * place, words, "#8a5f00" if color == ORANGE else color)
            axes.plot(u, force, color=BLUE)
            axes.plot(float(top.elongation) * MM, high, "o", color=RED, ms=5)
            label(axes, float(top.elongation) * MM * 1.15, high * 1.07, f"peak {high:.2f} N", RED)
            axes.set(xlim=(0, end * MM), ylim=(0, high * 1.18), xlabel="elongation [mm]")
            title(
                axes,
                NAMES[name],
                f"model at 94.5 kPa; a = {exact[name]['scale_factor']:.4g} comes back",
            )
        all_axes[0].set_ylabel("force [N]")
    return figure


def eq5() -> Figure:
    """Eq. 5 as printed against eq. 5 with x inside the root."""
    brake = load("choi2018-kapton").brake
    x = np.linspace(0, TESTED, 300)
    right = np.asarray(enclosure_force(x, FULL, brake))
    root = right[-1] / TESTED**0.5
    with look():
        figure, (axes, low) = canvas(columns=2, width=8.6, height=3.7)
        axes.plot(x * MM, right, color=BLUE)
        axes.plot(x * MM, root * x, color=RED, ls=(0, (4, 2)))
        label(axes, 19, right[75] - 0.3, "x inside the root [N]", BLUE, va="top")
        label(axes, 25, root * 0.025 + 0.9, "as printed [N·√m]", RED, ha="center", va="bottom")
        axes.set(xlabel="slip [mm]", ylabel="sleeve force", xlim=(0, None), ylim=(0, None))
        title(
            axes, "Eq. 5: the sleeve's force at 94.5 kPa", "the printed form has no unit of force"
        )
        ends = []
        for vacuum, color in zip((2000.0, 1000.0, 500.0, 0.0), VACUUMS, strict=True):
            force = np.asarray(brake_force(x, vacuum, brake))
            low.plot(x * MM, force, color=color)
            ends.append((float(force[-1]), f"{vacuum / 1e3:g} kPa", color))
        low.set(xlabel="slip [mm]", ylabel="force [N]", xlim=(0, TESTED * MM), ylim=(0, None))
        labels_right(low, TESTED * MM, ends)
        title(
            low, "When the slope turns positive", "whole brake; the sleeve saturates at low vacuum"
        )
    return figure


def sheets_and_mass() -> Figure:
    """Force and mass as sheets are added, the paper's 17.5 N and 0.4 g beside ours."""
    from layerjam.device.brake import mass

    brake = load("choi2018-kapton").brake
    counts = np.arange(3, 32)
    force, weight = [], []
    for count in counts:
        more = replace(brake, sheets=replace(brake.sheets, count=int(count)))
        force.append(float(peak(FULL, 0.06, more).force))
        weight.append(mass(more) * 1e3)
    at = int(np.flatnonzero(counts == 11)[0])
    with look():
        figure, (axes,) = canvas(width=6.4, height=3.8)
        axes.plot(weight, force, "o-", color=BLUE, ms=3.5, lw=1.2)
        paper = np.array([weight[at] + 0.4 * (n - 11) for n in counts])
        axes.plot(
            paper,
            [force[at] + 17.5 * (n - 11) for n in counts],
            color=ORANGE,
            lw=1.2,
            ls=(0, (4, 2)),
        )
        axes.plot(weight[at], force[at], "o", color=RED, ms=7)
        label(
            axes, weight[at] + 0.4, force[at] * 0.93, "the paper's brake, 11 sheets", RED, va="top"
        )
        label(axes, 25.2, 355, "ours: the sleeve grows too", BLUE)
        label(axes, 24.6, 455, "+17.5 N, +0.4 g a sheet (paper)", "#8a5f00", ha="right")
        axes.set(xlabel="mass of the brake [g]", ylabel="peak force at 94.5 kPa [N]")
        title(axes, "More sheets", "model; Kapton, 3 to 31 sheets")
    return figure


def buckling_and_closing() -> Figure:
    """Vacuum below which the sleeve closes the unloaded brake."""
    from layerjam.mechanics.limits import self_closing_vacuum

    x = np.linspace(0, 0.055, 300)
    with look():
        figure, (axes,) = canvas(width=6.4, height=3.6)
        for name, color in zip(CALIBRATED, (BLUE, ORANGE), strict=True):
            closing = np.asarray(self_closing_vacuum(x, load(name).brake)) / 1e3
            axes.plot(x * MM, closing, color=color)
            y = float(np.interp(0.04, x, closing))
            axes.plot(40, y, "o", color=color, ms=5)
            below = name == CALIBRATED[0]
            place = (41, y - 1.6) if below else (39.2, y + 1.2)
            label(
                axes,
                place[0],
                place[1],
                f"{NAMES[name]}: {y:.2f} kPa",
                color,
                ha="left" if below else "right",
            )
        axes.set(xlabel="slip [mm]", ylabel="vacuum [kPa]", xlim=(0, None), ylim=(0, 40))
        label(axes, 20, 32, "above: friction holds the stretched sleeve", GREY, ha="center")
        title(
            axes, "Below this vacuum the sleeve closes the brake", "model; ours, not in the paper"
        )
    return figure
