"""Figures of the stack: order of sliding, load of each sheet, and scatter of the peak."""

import numpy as np

from layerjam.brake.device.load import load
from layerjam.brake.kernel.stack import pull_stack
from layerjam.brake.mechanics.stiffness import stiffness_sliding
from layerjam.brake.simulate.stack_layout import make_stack
from layerjam.brake.simulate.stack_spread import Spread, peak_spread
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, KN, ORANGE, PURPLE, RED, SKY

save = style.save
VACUUM = 94.5e3
UM = 1e6
_PAIRS = (RED, ORANGE, GREEN, PURPLE, BLUE)


@style.use_style
def draw_onset() -> style.Figure:
    """Draw a pull of the Kapton brake on a rigid mount; its interfaces slip in pairs.

    It also shows the load of each sheet at the moment of slip.
    """
    brake = load("choi2018-kapton").brake
    stack = make_stack(brake, VACUUM, mount=np.inf)
    u = np.linspace(0, 0.16e-3, 1601)
    run = pull_stack(u, stack)
    onset_indices = run.sliding.argmax(axis=0)
    sign = np.where(stack.right[:-1], -1.0, 1.0)
    bound = float(stack.friction[0])
    figure, (force, shares, bars) = style.make_axes(columns=3, width=11.4, height=4.0)
    together = np.minimum(float(stiffness_sliding(0.0, brake)) * u, stack.friction.sum())
    force.plot(u * UM, together, color=GREY, lw=1.2, ls=style.DASHED, label="if all slid at once")
    force.plot(u * UM, run.force, color=INK)
    for pair, color in enumerate(_PAIRS):
        start = int(onset_indices[pair])
        name = {0: "the outermost two slide", len(_PAIRS) - 1: "all slide"}.get(pair)
        if name:
            style.add_point(force, u[start] * UM, run.force[start], color=color, label=name)
        words = f"{pair + 1} and {10 - pair}"
        shares.plot(u * UM, sign[pair] * run.interface[:, pair], color=color, lw=1.6, label=words)
    axis = {"xlabel": "cap displacement [µm]", "xlim": (0, 160)}
    style.label_axes(
        force, "The peak is rounded", "Kapton, 94.5 kPa, held rigidly; computed", **axis
    )
    force.set(ylabel="force [N]", ylim=(0, 205))
    style.add_key(force, loc="lower right")
    style.label_axes(shares, "The outermost interfaces slip first", "counted from one side", **axis)
    shares.set(ylabel="interface force [N]", ylim=(0, bound * 1.18))
    style.mark_y(shares, bound, f"static friction, {bound:.2f} N", GREY)
    style.add_key(shares, loc="lower right")
    home = np.where(stack.right, run.cap[:, None], 0.0)
    loads = np.abs(stack.springs * (run.sheets - home))
    numbers = np.arange(1, len(stack.springs) + 1)
    moments = ((-0.2, int(onset_indices[0]), SKY), (0.2, -1, BLUE))
    for shift, row, color in moments:
        bars.bar(numbers + shift, loads[row], 0.38, color=color)
    bars.set(xlabel="sheet number (even sheets move)", xticks=numbers)
    bars.set(ylabel="sheet load [N]", ylim=(0, 52))
    bars.grid(False, axis="x")
    style.add_key(bars, ("at the first slip", SKY), ("all slide", BLUE), loc="upper left", ncols=2)
    style.add_title(bars, "Tension in each sheet", "an outer sheet rubs on one side only")
    return figure


@style.use_style
def draw_spread(result: Spread | None = None) -> style.Figure:
    """Draw the scatter of peak, onset and stiffness from the scatter of interface friction."""
    file = load("choi2018-kapton")
    result = result or peak_spread(file, VACUUM, 0.10, samples=5_000)
    even_spread = peak_spread(file, VACUUM, 0.0, samples=1)
    figure, (force, stiffness) = style.make_axes(
        columns=2, width=9.8, height=3.9, width_ratios=(1.7, 1)
    )
    bins = np.linspace(result.onset.min(), result.peak.max(), 90)
    for values, even_value, color, name in (
        (result.onset, float(even_spread.onset[0]), ORANGE, "first interface slides"),
        (result.peak, float(even_spread.peak[0]), BLUE, "peak"),
    ):
        words = f"{name}: {values.mean():.1f} ± {values.std(ddof=1):.1f} N"
        count, _ = np.histogram(values, bins)
        force.stairs(count, bins, fill=True, color=color, alpha=0.75, label=words)
        force.plot([even_value, even_value], [0, count.max()], color=INK, lw=1, ls=style.DASHED)
    force.set(xlabel="force [N]", ylabel="number of stacks", ylim=(0, force.get_ylim()[1] * 1.2))
    style.add_key(force, loc="upper left")
    words = f"{result.count:,} stacks, friction scatter {result.scatter:.0%}; dashed: no scatter"
    style.add_title(force, "With scatter, the first interface slides earlier", words)
    count, bins = np.histogram(result.stiffness * KN, 60)
    stiffness.stairs(count, bins, fill=True, color=GREEN, alpha=0.75)
    stiffness.axvline(float(even_spread.stiffness[0]) * KN, color=INK, lw=1, ls=style.DASHED)
    x_label = "stiffness, 20 to 80 % of the peak [kN/m]"
    mean, sd = result.stiffness.mean() * KN, result.stiffness.std(ddof=1) * KN
    style.label_axes(
        stiffness, "The rig sets the stiffness", f"{mean:.2f} ± {sd:.2f} kN/m", xlabel=x_label
    )
    stiffness.set_ylabel("number of stacks")
    return figure
