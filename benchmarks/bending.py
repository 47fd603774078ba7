"""Our law of a bent stack next to those of two papers, at the papers' own stacks.

    python -m benchmarks.bending [--figure docs/images/bending.svg]

The equations of both papers are second hand: they were read in a public review of the papers, not
in the papers themselves.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np

from layerjam.brake.device.load import load
from layerjam.brake.mechanics.bending import cantilever_force, enclosure_bending_stiffness


def ours(
    deflection: Any, length: float, vacuum: float, count: int, thickness: float, width: float,
    modulus: float, friction: float,
) -> Any:  # fmt: skip
    """Transverse force [N] of bare sheets held at one end, without an enclosure."""
    brake = load("choi2018-kapton").brake
    sheets = replace(brake.sheets, count=count, thickness=thickness, width=width)
    film = replace(brake.film, modulus=modulus, kinetic=friction, static=friction)
    stack = replace(brake, sheets=sheets, film=film, scale_factor=1.0, amplification_held=None)
    tube = 3 * deflection / length**3 * enclosure_bending_stiffness(stack)
    return np.asarray(cantilever_force(deflection, length, vacuum, stack) - tube)


CARUSO = {"count": 20, "thickness": 0.1e-3, "width": 60e-3, "modulus": 1.7e9, "friction": 0.55}
SPAN, CARUSO_VACUUM = 0.1, 68e3


def caruso(deflection: Any) -> Any:
    """Force [N] in the middle of a beam on two supports, Caruso and others 2023, eqs. 8 to 15.

    After the first slip the ends of the span count as clamped.
    """
    n, h, b, e, mu = CARUSO.values()
    force = mu * CARUSO_VACUUM * b * h
    forces = [2 * n / 3, n / (3 * (n - 2)), 2 * (n**2 - 6 * n + 12) / (3 * (n**2 - 6 * n + 8))]
    way = mu * CARUSO_VACUUM * SPAN**3 / (3 * e * h**2)
    ways = [1 / n**2, 1 / (2 * n**2 * (n - 2)), 1 / (2 * n * (n**2 - 6 * n + 8))]
    for i in range(3, n // 2):
        d = n**3 - 6 * (i - 1) * n**2 + 12 * (i - 1) ** 2 * n - 8 * (i**3 - 3 * i**2 + 2 * i)
        forces.append(2 * d / (3 * (d - 4 * n)))
        ways.append(1 / (d - 4 * n))
    steps = [np.concatenate([[0.0], np.cumsum(each)]) for each in (ways, forces)]
    return np.interp(deflection, way * steps[0], 2 * force * steps[1])


ZHANG = {"count": 20, "thickness": 0.25e-3, "width": 20e-3, "modulus": 755e6, "friction": 0.55}
LENGTH, ZHANG_VACUUM = 0.1, 60e3


def zhang(deflection: Any) -> Any:
    """Force [N] at the end of a cantilever, Zhang and others 2025, eqs. 5, 6, 9, 19 and 20.

    The width is added to the second branch of eq. 20, which has the unit m^3 as printed.
    """
    n, t, b, e, mu = ZHANG.values()
    h, flow = n * t, mu * ZHANG_VACUUM * b
    first = 2 / 3 * flow * h
    last = flow * (3 * h**2 - 6 * t * h + 4 * t**2) / (3 * (h - t))
    force = np.linspace(0, 20, 20_001)
    load = np.clip(force, first, last)
    root = np.sqrt(3 * (3 * load - 2 * flow * h) * (load + 2 * flow * h))
    sliding = np.where(force >= last, h / 2 - t, (3 * load - 2 * flow * h + root) / (8 * flow))
    softness = LENGTH**3 / (3 * e * 2 * b / 3 * ((h / 2) ** 3 - sliding**3))
    way = np.concatenate([[0.0], np.cumsum((softness[1:] + softness[:-1]) / 2 * np.diff(force))])
    return np.interp(deflection, way, force)


def bent_far(deflection: float) -> float:
    """Most that friction can hold [N] on Zhang's stack, at any angle: all interfaces slip.

    A section at the angle a carries F cos a = q t (n - 1) - B a'', where it slips; B a'^2/2 follows
    from that in closed form. The stack is straight at the held end.
    """
    n, t, b, e, mu = ZHANG.values()
    bare, slip = n * e * b * t**3 / 12, mu * ZHANG_VACUUM * b * t * (n - 1)
    u = (np.arange(4000) + 0.5) / 4000

    def shape(force: float, end: float) -> tuple[float, float]:
        angle = end * (1 - u**2)
        square = force * (np.sin(end) - np.sin(angle)) - slip * (end - angle)
        piece = 2 * end * u / np.sqrt(2 / bare * square) / len(u)
        return float(piece.sum()), float((np.sin(angle) * piece).sum())

    def reaches(force: float) -> float:
        low, high = 1e-3, float(np.arccos(slip / force)) * (1 - 1e-4)
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if shape(force, middle)[0] < LENGTH else (low, middle)
        return shape(force, low)[1]

    low, high = slip * 1.01, slip * 1.3
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if reaches(middle) < deflection else (low, middle)
    return low


def ours_as_caruso(deflection: Any) -> Any:
    """Force [N] in the middle of Caruso's span by our law: two halves."""
    return 2 * ours(deflection, SPAN / 2, CARUSO_VACUUM, **CARUSO)


def ours_as_zhang(deflection: Any) -> Any:
    """Force [N] at the end of Zhang's stack by our law."""
    return ours(deflection, LENGTH, ZHANG_VACUUM, **ZHANG)


def figure(path: Path) -> None:
    """Both laws over the deflection, for both stacks."""
    from layerjam.core.drawing import style

    with style.apply_style():
        picture, (left, right) = style.make_axes(columns=2, width=9.6, height=3.9)
        for axes, theirs, mine, far, name, detail in (
            (left, caruso, ours_as_caruso, 8.5e-3, "Caruso 2023", "ends of the span clamped"),
            (right, zhang, ours_as_zhang, 50e-3, "Zhang 2025", "outer sheets stay one section"),
        ):
            way = np.linspace(0, far, 500)
            axes.plot(way * 1e3, theirs(way), color=style.ORANGE)
            axes.plot(way * 1e3, mine(way), color=style.BLUE)
            axes.set(xlabel="deflection [mm]", ylabel="force [N]", xlim=(0, far * 1e3))
            axes.set_ylim(0)
            laws = (theirs, name, style.ORANGE), (mine, "layerjam", style.BLUE)
            ends = [(float(law(far)), words, color) for law, words, color in laws]
            style.add_end_labels(axes, far * 1e3, ends)
            style.add_title(axes, f"The stack of {name}", f"computed; published law: {detail}")
        bent = np.array([20e-3, 30e-3, 40e-3, 50e-3])
        right.plot(bent * 1e3, [bent_far(w) for w in bent], "o", ms=4, color=style.BLUE)
        limit = ("layerjam: upper limit at large angles", style.BLUE, "o")
        style.add_key(right, limit, loc="lower right")
        style.save(picture, path, overwrite=True)


def main() -> None:
    """Print the ratios, and draw the figure if asked."""
    jax.config.update("jax_enable_x64", True)
    for name, theirs, mine, ways in (
        ("Caruso", caruso, ours_as_caruso, (4e-3, 8e-3)),
        ("Zhang", zhang, ours_as_zhang, (10e-3, 50e-3)),
    ):
        for way in ways:
            a, b = float(mine(way)), float(theirs(way))
            print(f"{name} {1e3 * way:.0f} mm: ours {a:.3f} N, theirs {b:.3f} N, ratio {a / b:.2f}")
    print(f"Zhang 50 mm, most at large angles: {bent_far(50e-3):.3f} N")
    if sys.argv[1:2] == ["--figure"]:
        figure(Path(sys.argv[2]))


if __name__ == "__main__":
    main()
