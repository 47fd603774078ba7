"""A brake bent between its caps, and pulled over a joint."""

from __future__ import annotations

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.mechanics.bending import (
    buckling_moment,
    slip_moment,
    turning_moment,
    turning_stiffness_free,
)
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.mechanics.joint import joint_friction
from layerjam.report import style
from layerjam.report.style import BLUE, GREY, INK, RED
from layerjam.units import show


@style.styled
def bend(
    file: BrakeFile, vacuum: float, angle: float, slip: float, radius: float | None
) -> style.Figure:
    """Moment over the angle, jammed and free; the sheets' friction over the joint's angle."""
    columns = 1 if radius is None else 2
    figure, (turn, *pull) = style.canvas(columns=columns, width=5.6 * columns, height=3.9)
    _moment(turn, file, vacuum, angle, slip)
    if radius is not None:
        _pull(pull[0], file, vacuum, angle, slip, radius)
    return figure


def _moment(axes: style.Axes, file: BrakeFile, vacuum: float, most: float, slip: float) -> None:
    brake, milli = file.brake, 1e3
    angle = np.linspace(0, 1.25 * most, 400)
    jammed = np.asarray(turning_moment(angle, slip, vacuum, brake)) * milli
    free = float(turning_stiffness_free(slip, brake)) * angle * milli
    friction = float(slip_moment(slip, vacuum, brake)) * milli
    top, degrees = float(max(jammed.max(), free.max())) * 1.3, np.degrees(angle)
    axes.plot(degrees, friction + free, color=GREY, lw=1.1, ls=style.DASHED)
    axes.plot(degrees, jammed, color=BLUE)
    axes.plot(degrees, free, color=INK)
    axes.set(xlabel="angle between the caps [°]", ylabel="moment [mN m]")
    axes.set(xlim=(0, float(degrees[-1])), ylim=(0, top))
    euler = float(buckling_moment(slip, brake)) * milli
    if euler < 0.9 * top:
        style.level(axes, euler, "sheets buckle", at=0.98)
    names = (("jammed", BLUE), ("without vacuum", INK), ("every interface slips", GREY))
    style.key(axes, *names, at="upper left", ncols=2)
    style.title(axes, f"{file.name}, bent", f"computed; {show(vacuum, 'Pa')}")


def _pull(
    axes: style.Axes, file: BrakeFile, vacuum: float, most: float, slip: float, radius: float
) -> None:
    brake = file.brake
    angle = np.linspace(0, 1.25 * most, 400)
    held, off = (
        np.asarray(
            joint_friction(
                slip,
                pressure,
                angle,
                radius,
                float(enclosure_force(slip, pressure, brake)) / 2,
                brake,
            )
        )
        for pressure in (vacuum, 0.0)
    )
    degrees = np.degrees(angle)
    axes.plot(degrees, held, color=BLUE)
    axes.plot(degrees, off, color=INK)
    axes.set(xlabel="angle of the joint [°]", ylabel="friction of the sheets [N]")
    axes.set(xlim=(0, float(degrees[-1])), ylim=(0, float(held.max()) * 1.3 or 1.0))
    here = float(np.interp(most, angle, held))
    style.spot(axes, float(np.degrees(most)), here, show(here, "N"), RED)
    style.key(axes, ("jammed", BLUE), ("without vacuum", INK), at="upper left", ncols=2)
    style.title(axes, "Pulled over a joint", f"radius {show(radius, 'm')}")
