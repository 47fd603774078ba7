"""The paper's figures, drawn from our model, with the numbers that the paper prints."""

from collections.abc import Mapping

import numpy as np

from layerjam.brake.device.brake import Brake, mass
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.limits import self_closing_vacuum
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, peak
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREEN, GREY, KPA, MM, ORANGE, PURPLE, RED, VACUUMS
from layerjam.core.evolve import evolve
from layerjam.laboratory.identify.calibration.result import Calibration

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
STIFFNESSES = {"choi2018-kapton": (131e3, 107e3), "choi2018-ptfe": (55e3, 42e3)}
"""Stiffnesses in the paper's text and in the caption of its Fig. 8 [N/m]."""


def _run_pull(vacuum: float, brake: Brake, end: float = TESTED) -> tuple[np.ndarray, np.ndarray]:
    """Return elongation [m] and force [N] of a pull, densely sampled around the onset."""
    k = float(working_stiffness(brake))
    rise = 3 * float(peak(vacuum, end, brake).force) / k
    u = np.union1d(np.linspace(0, min(rise, end), 300), np.linspace(0, end, 300))
    return u, np.asarray(force_at_elongation(u, vacuum, brake))


def _format_axes(
    axes: style.Axes, ends: list[tuple[float, str, str]], detail: str, name: str
) -> None:
    """Draw the axes of a pull to 40 mm, as in the paper, with a label at each curve's end."""
    axes.set(xlim=(0, TESTED * MM), ylim=(0, None), xlabel="elongation [mm]", ylabel="force [N]")
    style.add_end_labels(axes, TESTED * MM, ends)
    style.add_title(axes, name, detail)


@style.use_style
def draw_fig4() -> style.Figure:
    """Draw pulls of all four films at four vacuums."""
    figure, panels = style.make_axes(columns=2, rows=2, width=8.6, height=6.4)
    for axes, (name, film) in zip(panels, NAMES.items(), strict=True):
        file, ends = load(name), []
        for vacuum, color in zip(FIG4, VACUUMS, strict=True):
            u, force = _run_pull(vacuum, file.brake)
            axes.plot(u * MM, force, color=color)
            ends.append((float(force[-1]), f"{vacuum * KPA:.1f} kPa", color))
        guess = any(s.kind == "handbook" for p, s in file.sources.items() if "film.kin" in p)
        detail = "handbook friction, not calibrated" if guess else "calibrated by the paper"
        _format_axes(axes, ends, f"model; {detail}", film)
    return figure


@style.use_style
def draw_fig7_9() -> style.Figure:
    """Draw the model before (Fig. 7) and after calibration (Fig. 9) at the three test vacuums."""
    figure, panels = style.make_axes(columns=2, width=8.6, height=3.9)
    for axes, name in zip(panels, CALIBRATED, strict=True):
        brake, ends = load(name).brake, []
        for vacuum, color in zip(FIG7, VACUUMS, strict=False):
            u, after = _run_pull(vacuum, brake)
            before = np.interp(u, *_run_pull(vacuum, evolve(brake, scale_factor=1.0)))
            style.add_band(axes, u * MM, before, after, color, 0.13)
            axes.plot(u * MM, before, color=color, lw=1.2, ls=style.DASHED)
            axes.plot(u * MM, after, color=color)
            ends.append((float(after[-1]), f"{vacuum * KPA:.1f} kPa", color))
        detail = f"model: a = 1 (dashed), a = {brake.scale_factor:g} (solid)"
        _format_axes(axes, ends, detail, NAMES[name])
    return figure


@style.use_style
def draw_fig8(fits: Mapping[str, Calibration]) -> style.Figure:
    """Draw the calibration `fits` near their peaks, and lines with the paper's two stiffnesses."""
    figure, panels = style.make_axes(columns=2, width=8.6, height=3.9)
    for axes, name in zip(panels, CALIBRATED, strict=True):
        brake, (text, caption), our_stiffness = (
            load(name).brake,
            STIFFNESSES[name],
            fits[name].stiffness_eq9 or 0.0,
        )
        top = peak(FULL, TESTED, brake)
        end, high = 3.2 * float(top.elongation), float(top.force)
        u, force = _run_pull(FULL, brake, end)
        axes.plot(u * MM, force, color=BLUE)
        for k, color, words in (
            (text, ORANGE, f"text: {text / 1e3:.0f} kN/m"),
            (caption, PURPLE, f"caption: {caption / 1e3:.0f} kN/m"),
            (our_stiffness, GREEN, f"eq. 9 on our curve: {our_stiffness / 1e3:.0f} kN/m"),
        ):
            line = [0, high / k * MM], [0, high]
            axes.plot(*line, color=color, lw=1.5, ls=style.DASHED, zorder=3, label=words)
        axes.set(xlabel="elongation [mm]", ylabel="force [N]")
        axes.set(xlim=(0, end * MM), ylim=(0, high * 1.22))
        style.add_point(axes, float(top.elongation) * MM, high, f"peak {high:.2f} N")
        style.add_key(axes, loc="lower right")
        detail = f"model at 94.5 kPa; a = {fits[name].scale_factor:.4g} is recovered"
        style.add_title(axes, NAMES[name], detail)
    return figure


@style.use_style
def draw_eq5() -> style.Figure:
    """Draw eq. 5 as printed, and eq. 5 with x under the root."""
    brake = load("choi2018-kapton").brake
    x = np.linspace(0, TESTED, 300)
    right = np.asarray(enclosure_force(x, FULL, brake))
    printed_force = right[-1] / TESTED**0.5 * x
    figure, (axes, low) = style.make_axes(columns=2, width=9.6, height=3.7)
    axes.plot(x * MM, right, color=BLUE, label="x inside the root [N]")
    axes.plot(x * MM, printed_force, color=RED, ls=style.DASHED, label="as printed [N·√m]")
    axes.set(xlabel="slip [mm]", ylabel="enclosure force [N or N·√m]", xlim=(0, None))
    axes.set_ylim(0, None)
    style.add_key(axes)
    detail = "the printed form has no unit of force"
    style.add_title(axes, "Eq. 5: the enclosure's force at 94.5 kPa", detail)
    ends = []
    for vacuum, color in zip((2000.0, 1000.0, 500.0, 0.0), VACUUMS, strict=True):
        force = np.asarray(brake_force(x, vacuum, brake))
        low.plot(x * MM, force, color=color)
        ends.append((float(force[-1]), f"{vacuum * KPA:g} kPa", color))
    detail = "whole brake; the enclosure saturates at low vacuum"
    _format_axes(low, ends, detail, "When the slope turns positive")
    low.set_xlabel("slip [mm]")
    return figure


@style.use_style
def draw_sheets_and_mass() -> style.Figure:
    """Draw force and mass versus the number of sheets, with the paper's 17.5 N and 0.4 g."""
    brake = load("choi2018-kapton").brake
    counts = np.arange(3, 32)
    variants = [evolve(brake, sheets=evolve(brake.sheets, count=int(n))) for n in counts]
    force = [float(peak(FULL, 0.06, variant).force) for variant in variants]
    weight = [mass(variant) * 1e3 for variant in variants]
    place = int(np.flatnonzero(counts == 11)[0])
    paper = weight[place] + 0.4 * (counts - 11), force[place] + 17.5 * (counts - 11)
    figure, (axes,) = style.make_axes(width=6.4, height=3.8)
    our_label = "ours: the enclosure grows too"
    axes.plot(weight, force, "o-", color=BLUE, ms=3.5, lw=1.2, label=our_label)
    label = "+17.5 N, +0.4 g per sheet (paper)"
    axes.plot(*paper, color=ORANGE, lw=1.2, ls=style.DASHED, label=label)
    axes.set(xlabel="mass of the brake [g]", ylabel="peak force at 94.5 kPa [N]")
    style.add_point(axes, weight[place], force[place], label="the paper's brake, 11 sheets", ms=7)
    style.add_key(axes, loc="upper left")
    style.add_title(axes, "More sheets", "model; Kapton, 3 to 31 sheets")
    return figure


@style.use_style
def draw_closing_vacuum() -> style.Figure:
    """Draw the vacuum below which the enclosure closes the unloaded brake."""
    x = np.linspace(0, 0.055, 300)
    figure, (axes,) = style.make_axes(width=6.4, height=3.6)
    axes.set(xlabel="slip [mm]", ylabel="vacuum [kPa]", xlim=(0, 60), ylim=(0, 40))
    for name, color in zip(CALIBRATED, (BLUE, ORANGE), strict=True):
        vacuum = np.asarray(self_closing_vacuum(x, load(name).brake)) * KPA
        axes.plot(x * MM, vacuum, color=color)
        y = float(np.interp(TESTED, x, vacuum))
        style.add_point(axes, TESTED * MM, y, f"{NAMES[name]}: {y:.2f} kPa", color)
    style.add_label(axes, 3, 37, "above: friction holds the stretched enclosure", GREY)
    detail = "model; ours, not in the paper"
    style.add_title(axes, "Below this vacuum the enclosure closes the brake", detail)
    return figure
