"""Figures of stick–slip and speed: the map, Fig. 4 explained, Fig. 6."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.device.load import load
from layerjam.mechanics.pull import brake_force
from layerjam.mechanics.stick_slip.laws import critical_speed
from layerjam.mechanics.stick_slip.wet import (
    ILLUSTRATIVE,
    ILLUSTRATIVE_VISCOUS,
    WetFilm,
    wet_force,
    wet_stress,
)
from layerjam.mechanics.stiffness import working_stiffness
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
from layerjam.simulate.stick_slip import (
    amplitude_map,
    bounds_at,
    moving_mass,
    series_stiffness,
    slide_of,
)
from layerjam.studies.choi2018.speed import DAMPING, FILMS, STRIBECK, fig4_study

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["amplitude", "fig4_judder", "fig6", "save"]
MM, KPA = 1e3, 1e3
FULL, SLOW, FAST = 94.5e3, 1e-3, 25e-3
FIG6 = (94.5e3, 65.5e3, 31.0e3, 0.0)
RATIO = 0.05
"""Damping ratio of the map: assumed."""
DARK_ORANGE = "#8a5f00"


def amplitude() -> Figure:
    """Judder over pulling speed and vacuum for both films, and the mount that stops it."""
    speeds = np.geomspace(1e-3, 20, 44)
    vacuums = np.linspace(2e3, 100e3, 22)
    with look():
        figure, (*maps, design) = canvas(columns=3, width=11.4, height=4.0)
        shown: Any = None
        for axes, (film, name) in zip(maps, FILMS.items(), strict=True):
            brake = load(name).brake
            mass, spring = moving_mass(brake), series_stiffness(brake)
            drag = 2 * RATIO * (spring * mass) ** 0.5
            found = amplitude_map(
                brake, speeds[:, None], vacuums[None, :], mass=mass, stiffness=spring,
                damping=drag, swings=60,
            )  # fmt: skip
            force = np.where(found.judders, found.amplitude, np.nan)
            # filled contours, not an image: the page embeds none
            shown = axes.contourf(
                speeds, vacuums / KPA, force.T, levels=np.arange(0, 81, 8), cmap="viridis"
            )
            at = slide_of(
                brake, vacuum=vacuums, speed=1.0, mass=mass, stiffness=spring, frozen=True
            )
            edge = np.asarray(critical_speed(*bounds_at(at), spring, mass, drag))
            axes.plot(edge, vacuums / KPA, color=RED, lw=1.6)
            axes.set(xscale="log", xlabel="pulling speed [m/s]", xlim=(1e-3, 20))
            label(axes, 12, 12, "slides\nsteadily", GREY, ha="center")
            label(axes, float(edge[-1]) * 1.3, 98, "critical\nspeed\n(taut)", RED, va="top")
            title(axes, film, f"model; jump law, damping ratio {RATIO:g} (assumed)")
        maps[0].set_ylabel("vacuum [kPa]")
        figure.colorbar(shown, ax=maps[1], label="half of the force's swing [N]", pad=0.02)
        _mount(design)
    return figure


def _mount(axes: Axes) -> None:
    """Critical speed over the stiffness of brake and mount."""
    stiffness = np.geomspace(5e3, 2e6, 200)
    for (film, name), color in zip(FILMS.items(), (BLUE, ORANGE), strict=True):
        brake = load(name).brake
        mass = moving_mass(brake)
        static, kinetic = bounds_at(
            slide_of(brake, vacuum=FULL, speed=1.0, mass=mass, stiffness=1.0, frozen=True)
        )
        for ratio, dash in ((RATIO, "-"), (0.5, (0, (4, 2)))):
            drag = 2 * ratio * np.sqrt(stiffness * mass)
            speed = np.asarray(critical_speed(static, kinetic, stiffness, mass, drag))
            axes.plot(stiffness / 1e3, speed, color=color, ls=dash)
            own = float(working_stiffness(brake))
            here = float(np.interp(own, stiffness, speed))
            axes.plot(own / 1e3, here, "o", color=color, ms=5)
            if ratio == RATIO:
                word, share = (DARK_ORANGE, 1.5) if color == ORANGE else (color, 0.62)
                label(axes, own / 1e3, here * share, film, word, ha="center")
    axes.set(xscale="log", yscale="log", xlabel="stiffness of brake and mount [kN/m]")
    axes.set(ylabel="critical speed [m/s]", xlim=(5, 2e3), ylim=(0.02, 40))
    label(axes, 1800, 11, "solid: damping ratio 0.05\ndashed: 0.5; dots: as measured", GREY,
          ha="right", va="bottom")  # fmt: skip
    title(axes, "How fast, how stiff", "94.5 kPa; judder dies above the line")


def fig4_judder() -> Figure:
    """What table I gives, what staggered sliding leaves, and where Kapton alone would judder."""
    from matplotlib.colors import ListedColormap

    study = fig4_study()
    kapton, ptfe = study["Kapton"], study["PTFE"]
    with look():
        figure, (bars, grid) = canvas(columns=2, width=9.6, height=4.1, width_ratios=(1, 1.35))
        for place, color in zip((0, 1), (BLUE, ORANGE), strict=True):
            film = (kapton, ptfe)[place]
            values = (film.together * 100, film.apart * 100)
            for side, value in enumerate(values):
                x = place + (side - 0.5) * 0.36
                bars.bar(x, value, 0.32, color=color, alpha=1.0 if side == 0 else 0.45)
                bars.text(x, value + 2, f"{value:.0f} %", ha="center", fontsize=8.8)
        bars.set_xticks([0, 1], ["Kapton", "PTFE"])
        bars.tick_params(axis="x", length=0)
        bars.set(ylabel="half of the swing over kinetic force [%]", ylim=(0, 150))
        bars.grid(axis="x", visible=False)
        bars.text(-0.4, 142, "left: table I, all sheets at once", fontsize=8.6, color=INK)
        bars.text(-0.4, 133, "right: sheets let go one by one", fontsize=8.6, color=INK)
        title(bars, "Slow pull, 94.5 kPa", "model; Fig. 4 shows the opposite order")
        code = kapton.judders.astype(int) + 2 * ptfe.judders.astype(int)
        colors = ListedColormap(["#eef1f3", BLUE, ORANGE, "#b9c2ca"])
        grid.pcolormesh(
            STRIBECK, DAMPING, code, cmap=colors, vmin=-0.5, vmax=3.5, shading="nearest"
        )  # fmt: skip
        for film, dash in ((ptfe, (0, (4, 2))), (kapton, "-")):
            grid.axhline(film.settles, color=INK, lw=1.0, ls=dash)
        label(grid, 70, kapton.settles * 1.3, "Kapton's limit, small $v_s$", INK, ha="right")
        label(grid, 70, ptfe.settles * 0.76, "PTFE's", INK, ha="right")
        grid.set(xscale="log", yscale="log", xlabel="Stribeck speed $v_s$ [m/s]")
        grid.set(ylabel="damping [N s/m]")
        label(grid, 0.02, 3, "both judder", INK, ha="center")
        label(grid, 9, 210, "neither", INK, ha="center")
        if (code == 1).any():
            grid.annotate(
                "Kapton alone, as in Fig. 4", (3e-5, (ptfe.settles * kapton.settles) ** 0.5),
                xytext=(2.2e-5, 190), fontsize=8.8, color=BLUE,
                arrowprops={"arrowstyle": "-", "color": BLUE, "lw": 0.8},
            )  # fmt: skip
        if (code == 2).any():
            label(grid, 30, 0.42, "PTFE alone", DARK_ORANGE, ha="right")
        title(grid, "At 1 mm/s, same law for both films", "model; nothing here is measured")
    return figure


def _pull(axes: Axes, speed: float, films: tuple[tuple[WetFilm | None, Any], ...]) -> None:
    brake = load("choi2018-kapton").brake
    slip = np.concatenate([np.linspace(0, 1e-3, 60), np.linspace(1e-3, 0.04, 120)[1:]])
    spring = float(working_stiffness(brake))
    for vacuum, color in zip(FIG6, VACUUMS, strict=True):
        for film, dash in films:
            force = np.asarray(
                brake_force(slip, vacuum, brake)
                if film is None
                else wet_force(slip, speed, vacuum, brake, film)
            )
            u = np.append(0.0, slip + force / spring)
            axes.plot(
                u * MM, np.append(0.0, force), color=color, ls=dash, lw=1.8 if dash == "-" else 1.3
            )
    axes.set(xlim=(0, 40), ylim=(0, 245), xlabel="elongation [mm]")


def fig6() -> Figure:
    """Dry and wet Kapton at two speeds; the wet sets are illustrative."""
    brake = load("choi2018-kapton").brake
    speed = np.geomspace(1e-4, 0.1, 200)
    dash, dots = (0, (5, 2)), (0, (1, 1.6))
    with look():
        figure, (law, slow, fast) = canvas(columns=3, width=11.4, height=4.1)
        dry = brake.scale_factor * brake.film.kinetic * FULL / KPA
        law.plot(speed * MM, np.full_like(speed, dry), color=INK)
        sets = ((ILLUSTRATIVE, dash, BLUE), (ILLUSTRATIVE_VISCOUS, dots, RED))
        for film, style, color in sets:
            stress = np.asarray(wet_stress(speed, FULL, film, brake.scale_factor)) / KPA
            law.plot(speed * MM, stress, color=color, ls=style)
        for place in (SLOW, FAST):
            law.axvline(place * MM, color=GREY, lw=0.8)
            law.text(place * MM * 1.1, 1.0, f"{place * MM:g} mm/s", fontsize=8.4, color=GREY)
        law.set(xscale="log", xlabel="sliding speed [mm/s]", ylabel="shear stress [kPa]")
        law.set(xlim=(0.1, 100), ylim=(0, 36))
        label(law, 0.13, dry - 1.6, "dry", INK)
        label(law, 0.13, 12.5, "wet, lower at speed", BLUE)
        label(law, 0.13, 31.0, "wet, higher at speed", RED)
        title(law, "Stress of an interface, 94.5 kPa", "wet: ILLUSTRATIVE, not measured")
        _pull(slow, SLOW, ((None, "-"), (ILLUSTRATIVE, dash)))
        _pull(fast, FAST, ((None, "-"), (ILLUSTRATIVE, dash), (ILLUSTRATIVE_VISCOUS, dots)))
        slow.set_ylabel("force [N]")
        ends = [
            (float(brake_force(0.04, p, brake)), f"{p / KPA:.1f} kPa", c)
            for p, c in zip(FIG6, VACUUMS, strict=True)
        ]
        labels_right(fast, 40, ends)
        title(slow, "Fig. 6: Kapton at 1 mm/s", "solid: dry; dashed: wet, ILLUSTRATIVE")
        title(fast, "Kapton at 25 mm/s", "solid: dry; dashed and dotted: the two readings")
    return figure
