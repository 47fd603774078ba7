"""Figures of stick–slip and speed: a map of stick–slip, an explanation of Fig. 4, and Fig. 6."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stick_slip.laws import critical_speed
from layerjam.brake.mechanics.stick_slip.wet import (
    ILLUSTRATIVE,
    ILLUSTRATIVE_VISCOUS,
    WetFilm,
    wet_force,
    wet_stress,
)
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.stick_slip import (
    amplitude_map,
    force_bounds,
    make_slide,
    moving_mass,
    series_stiffness,
)
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREY, INK, KPA, MM, ORANGE, RED, VACUUMS
from layerjam.studies.choi2018.figures import FIG4, FULL
from layerjam.studies.choi2018.speed import DAMPING, FAST, FILMS, SLOW, STRIBECK, study_fig4

RATIO = 0.05
"""Assumed damping ratio of the map."""


@style.use_style
def draw_amplitudes() -> style.Figure:
    """Draw stick–slip versus speed and vacuum for both films, and the mount that prevents it."""
    speeds, vacuums = np.geomspace(1e-3, 20, 44), np.linspace(2e3, 100e3, 22)
    figure, (*maps, design) = style.make_axes(columns=3, width=12.4, height=4.0)
    for axes, (film, name) in zip(maps, FILMS.items(), strict=True):
        brake = load(name).brake
        mass, spring = moving_mass(brake), series_stiffness(brake)
        drag = 2 * RATIO * (spring * mass) ** 0.5
        moving: dict[str, Any] = {"mass": mass, "stiffness": spring}
        axes_values = speeds[:, None], vacuums[None, :]
        saw_map = amplitude_map(brake, *axes_values, damping=drag, swings=60, **moving)
        force = np.where(saw_map.judders, saw_map.amplitude, np.nan)
        # filled contours instead of an image, because the page embeds no images
        scale: dict[str, Any] = {"levels": np.arange(0, 81, 8), "cmap": "viridis"}
        contours = axes.contourf(speeds, vacuums * KPA, force.T, **scale)
        slide = make_slide(brake, vacuum=vacuums, speed=1.0, frozen=True, **moving)
        edge = np.asarray(critical_speed(*force_bounds(slide), spring, mass, drag))
        axes.plot(edge, vacuums * KPA, color=RED, lw=1.6, label="critical\nspeed (taut)")
        axes.set(xscale="log", xlabel="pulling speed [m/s]", xlim=(1e-3, 20))
        axes.set_ylabel("vacuum [kPa]")
        style.add_label(axes, 12, 12, "slides\nsteadily", GREY, ha="right")
        style.add_key(axes, loc="upper right")
        style.add_title(axes, film, f"model; jump law, damping ratio {RATIO:g} (assumed)")
    figure.colorbar(contours, ax=maps[1], label="half the peak-to-peak force [N]", pad=0.02)
    _draw_mount(design)
    return figure


def _draw_mount(axes: style.Axes) -> None:
    stiffness = np.geomspace(5e3, 2e6, 200)
    for name, color in zip(FILMS.values(), (BLUE, ORANGE), strict=True):
        brake = load(name).brake
        mass, working = moving_mass(brake), float(working_stiffness(brake))
        slide = make_slide(brake, vacuum=FULL, speed=1.0, mass=mass, stiffness=1.0, frozen=True)
        for ratio, dash in ((RATIO, "-"), (0.5, style.DASHED)):
            drag = 2 * ratio * np.sqrt(stiffness * mass)
            speed = np.asarray(critical_speed(*force_bounds(slide), stiffness, mass, drag))
            axes.plot(stiffness / 1e3, speed, color=color, ls=dash)
            style.add_point(
                axes, working / 1e3, float(np.interp(working, stiffness, speed)), color=color
            )
    axes.set(xscale="log", yscale="log", xlabel="stiffness of brake and mount [kN/m]")
    axes.set(ylabel="critical speed [m/s]", xlim=(5, 2e3), ylim=(0.02, 40))
    style.add_key(axes, *zip(FILMS, (BLUE, ORANGE), strict=True))
    detail = f"94.5 kPa; damping ratio {RATIO:g} (solid), 0.5 (dashed); dots: as measured"
    style.add_title(axes, "Critical speed versus stiffness", detail)


@style.use_style
def draw_fig4_stick_slip() -> style.Figure:
    """Draw stick–slip by Table I, with staggered sliding, and where only Kapton shows it."""
    from matplotlib.colors import ListedColormap

    study = study_fig4()
    kapton, ptfe = study["Kapton"], study["PTFE"]
    figure, (bars, grid) = style.make_axes(
        columns=2, width=10.4, height=4.1, width_ratios=(1, 1.35)
    )
    for place, (film, color) in enumerate(zip((kapton, ptfe), (BLUE, ORANGE), strict=True)):
        for shift, value, alpha in ((-0.18, film.together, 1.0), (0.18, film.apart, 0.45)):
            bars.bar(place + shift, value * 100, 0.32, color=color, alpha=alpha)
            style.add_label(bars, place + shift, value * 100 + 4, f"{value:.0%}", ha="center")
    bars.set_xticks([0, 1], ["Kapton", "PTFE"])
    bars.tick_params(axis="x", length=0)
    bars.set(ylabel="half peak-to-peak / kinetic force [%]", ylim=(0, 150))
    bars.grid(axis="x", visible=False)
    words = "left: table I, all sheets slip together", "right: sheets start to slip one by one"
    style.add_key(bars, *((text, INK) for text in words), loc="upper left", handlelength=0)
    style.add_title(bars, "Slow pull, 94.5 kPa", "model; Fig. 4 shows the opposite order")
    code = kapton.judders.astype(int) + 2 * ptfe.judders.astype(int)
    names = "neither", "Kapton alone, as in Fig. 4", "PTFE alone", "both stick and slip"
    shades = "#eef1f3", BLUE, ORANGE, "#b9c2ca"
    scale: dict[str, Any] = {"cmap": ListedColormap(shades), "vmin": -0.5, "vmax": 3.5}
    grid.pcolormesh(STRIBECK, DAMPING, code, shading="nearest", **scale)
    grid.set(xscale="log", yscale="log", xlabel="Stribeck speed $v_s$ [m/s]")
    grid.set_ylabel("damping [N s/m]")
    style.mark_y(grid, ptfe.settles, "PTFE's limit", INK, share=0.99, below=True)
    style.mark_y(grid, kapton.settles, "Kapton's limit, small $v_s$", INK, share=0.99)
    colors = dict(zip(names, (GREY, BLUE, ORANGE, GREY), strict=True))
    present = [names[value] for value in (1, 2) if (code == value).any()]
    style.add_key(grid, *((name, colors[name]) for name in present), loc="lower right")
    style.add_label(grid, 2e-2, 3, names[3], INK, ha="center")
    style.add_label(grid, 9, 210, names[0], INK, ha="center")
    style.add_title(grid, "At 1 mm/s, same law for both films", "model; nothing here is measured")
    return figure


FilmStyles = Sequence[tuple[WetFilm | None, Any]]


def _draw_pulls(axes: style.Axes, speed: float, films: FilmStyles) -> None:
    """Draw pulls of Kapton at one speed, dry (None) and wet, with a line style for each film."""
    brake = load("choi2018-kapton").brake
    slip = np.union1d(np.linspace(0, 1e-3, 60), np.linspace(1e-3, 0.04, 120))
    spring = float(working_stiffness(brake))
    for vacuum, color in zip(FIG4, VACUUMS, strict=True):
        for film, dash in films:
            dry = brake_force(slip, vacuum, brake)
            force = np.asarray(dry if film is None else wet_force(slip, speed, vacuum, brake, film))
            u = np.append(0.0, slip + force / spring) * MM
            width = 1.8 if film is None else 1.3
            axes.plot(u, np.append(0.0, force), color=color, ls=dash, lw=width)
    axes.set(xlim=(0, 40), ylim=(0, 245), xlabel="elongation [mm]", ylabel="force [N]")


@style.use_style
def draw_fig6() -> style.Figure:
    """Draw dry and wet Kapton at two speeds; the wet parameters are illustrative."""
    brake = load("choi2018-kapton").brake
    speed = np.geomspace(1e-4, 0.1, 200)
    lower, higher = (ILLUSTRATIVE, style.LONG), (ILLUSTRATIVE_VISCOUS, style.DOTTED)
    figure, (law, slow, fast) = style.make_axes(columns=3, width=12.4, height=4.1)
    dry = brake.scale_factor * brake.film.kinetic * FULL * KPA
    law.plot(speed * MM, np.full_like(speed, dry), color=INK, label="dry")
    names = "wet, lower at speed", "wet, higher at speed"
    for (film, dash), color, name in zip((lower, higher), (BLUE, RED), names, strict=True):
        stress = np.asarray(wet_stress(speed, FULL, film, brake.scale_factor)) * KPA
        law.plot(speed * MM, stress, color=color, ls=dash, label=name)
    law.set(xscale="log", xlabel="sliding speed [mm/s]", ylabel="shear stress [kPa]")
    law.set(xlim=(0.1, 100), ylim=(0, 45))
    for speed_ in (SLOW, FAST):
        style.mark_x(law, speed_ * MM, f"{speed_ * MM:g} mm/s", share=0.03)
    style.add_key(law, loc="upper left")
    style.add_title(law, "Stress of an interface, 94.5 kPa", "wet: ILLUSTRATIVE, not measured")
    _draw_pulls(slow, SLOW, ((None, "-"), lower))
    _draw_pulls(fast, FAST, ((None, "-"), lower, higher))
    end = [float(brake_force(0.04, p, brake)) for p in FIG4]
    ends = [(f, f"{p * KPA:.1f} kPa", c) for f, p, c in zip(end, FIG4, VACUUMS, strict=True)]
    style.add_end_labels(fast, 40, ends)
    style.add_title(slow, "Fig. 6: Kapton at 1 mm/s", "solid: dry; dashed: wet, ILLUSTRATIVE")
    detail = "solid: dry; dashed and dotted: the two readings"
    style.add_title(fast, "Kapton at 25 mm/s", detail)
    return figure
