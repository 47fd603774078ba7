"""Figures of the stack: which sheet slides when, what each carries, how far peaks scatter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layerjam.device.load import load
from layerjam.mechanics.stack.pull import pull_stack
from layerjam.mechanics.stiffness import stiffness_sliding
from layerjam.report.style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    canvas,
    label,
    look,
    save,
    title,
)
from layerjam.simulate.stack_layout import stack_of
from layerjam.simulate.stack_spread import Spread, peak_spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["onset", "save", "spread", "warm_up"]
VACUUM = 94.5e3
UM = 1e6
_PAIRS = (RED, ORANGE, GREEN, PURPLE, BLUE)


def warm_up() -> None:
    """Compile the loops of the stack, ten seconds on a first run, while another core does more."""
    file = load("choi2018-kapton")
    pull_stack(np.zeros(2), stack_of(file.brake, VACUUM, mount=np.inf))
    peak_spread(file, VACUUM, 0.0, samples=1)


def onset() -> Figure:
    """The Kapton brake held rigidly: interfaces let go in pairs; what each sheet carries then."""
    brake = load("choi2018-kapton").brake
    stack = stack_of(brake, VACUUM, mount=np.inf)
    u = np.linspace(0, 0.16e-3, 1601)
    run = pull_stack(u, stack)
    starts = run.sliding.argmax(axis=0)
    sign = np.where(stack.right[:-1], -1.0, 1.0)
    stuck = float(stiffness_sliding(0.0, brake))
    with look():
        figure, (force, each, carried) = canvas(columns=3, width=11.4, height=4.0)
        together = np.minimum(stuck * u, stack.friction.sum())
        force.plot(u * UM, together, color=GREY, lw=1.2, ls=(0, (4, 2)))
        force.plot(u * UM, run.force, color=INK)
        for pair, color in enumerate(_PAIRS):
            start = int(starts[pair])
            if pair in (0, len(_PAIRS) - 1):
                force.plot(u[start] * UM, run.force[start], "o", color=color, ms=6)
            each.plot(u * UM, sign[pair] * run.interface[:, pair], color=color, lw=1.6)
        label(force, 70, 184, "if all slid at once", GREY, ha="center")
        label(force, 60, 96, "the outermost two slide", RED)
        last = float(u[starts[-1 - len(_PAIRS)]]) * UM
        label(force, last + 4, 157, "all slide", BLUE)
        force.set(xlabel="way of the cap [µm]", ylabel="force [N]", xlim=(0, 160), ylim=(0, 205))
        bound = float(stack.friction[0])
        each.axhline(bound, color=FAINT, lw=1)
        label(each, 3, bound * 1.05, f"friction at rest, {bound:.2f} N", GREY)
        heights = (15.4, 1.2, 12.6, 4.2, 9.8)
        for number, (color, y) in enumerate(zip(_PAIRS, heights, strict=True), 1):
            label(each, 158, y, f"{number} and {11 - number}", color, ha="right")
        each.set(xlabel="way of the cap [µm]", ylabel="force of an interface [N]", xlim=(0, 160))
        each.set_ylim(0, bound * 1.18)
        home = np.where(stack.right, run.cap[:, None], 0.0)
        load_of = np.abs(stack.springs * (run.sheets - home))
        moments = ((int(starts[0]), SKY, "as the first slide"), (-1, BLUE, "all slide"))
        place = np.arange(1, len(stack.springs) + 1)
        for shift, (at, color, words) in zip((-0.2, 0.2), moments, strict=True):
            carried.bar(place + shift, load_of[at], 0.38, color=color)
            label(carried, 6, (44.3, 40.5)[int(shift > 0)], words, color, ha="center")
        carried.set(xlabel="sheet, even ones on the moving cap", ylabel="load of a sheet [N]")
        carried.set(xticks=place, ylim=(0, 47))
        carried.grid(False, axis="x")
        title(force, "The peak is rounded", "Kapton, 94.5 kPa, held rigidly; computed")
        title(each, "The outermost interfaces let go first", "counted from one side")
        title(carried, "What each sheet carries", "an outer sheet rubs on one side only")
    return figure


def spread(found: Spread | None = None) -> Figure:
    """How peak, onset and stiffness scatter where the friction of each interface does."""
    name = "choi2018-kapton"
    found = found or peak_spread(load(name), VACUUM, 0.10, samples=5_000)
    even = peak_spread(load(name), VACUUM, 0.0, samples=1)
    with look():
        figure, (force, stiffness) = canvas(
            columns=2, width=9.4, height=3.9, gridspec_kw={"width_ratios": [1.7, 1]}
        )
        bins = np.linspace(found.onset.min(), found.peak.max(), 90)
        for values, same, color, word in (
            (found.onset, float(even.onset[0]), ORANGE, "first interface slides"),
            (found.peak, float(even.peak[0]), BLUE, "peak"),
        ):
            count, _ = np.histogram(values, bins)
            force.stairs(count, bins, fill=True, color=color, alpha=0.75)
            force.plot([same, same], [0, count.max()], color=INK, lw=1, ls=(0, (4, 2)))
            text = f"{word}\n{values.mean():.1f} ± {values.std(ddof=1):.1f} N"
            label(force, float(np.median(values)), float(count.max()) * 1.1, text, color,
                  ha="center", weight="bold")  # fmt: skip
        top = force.get_ylim()[1] * 1.16
        middle = float(even.peak[0] + even.onset[0]) / 2
        label(force, middle, top * 0.3, "dashed: all\ninterfaces alike", GREY, ha="center")
        force.set(xlabel="force [N]", ylabel="stacks", ylim=(0, top))
        count, bins = np.histogram(found.stiffness / 1e3, 60)
        stiffness.stairs(count, bins, fill=True, color=GREEN, alpha=0.75)
        stiffness.axvline(float(even.stiffness[0]) / 1e3, color=INK, lw=1, ls=(0, (4, 2)))
        stiffness.set(xlabel="stiffness, 20 to 80 % of the peak [kN/m]", ylabel="stacks")
        words = f"{found.done:,} stacks drawn; friction scatters by {found.scatter:.0%}"
        title(force, "Scatter of the interfaces lets the first slide early", words)
        mean, sd = found.stiffness.mean() / 1e3, found.stiffness.std(ddof=1) / 1e3
        title(stiffness, "The rig sets the stiffness", f"{mean:.2f} ± {sd:.2f} kN/m")
    return figure
