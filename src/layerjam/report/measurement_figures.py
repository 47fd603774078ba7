"""Figures of `sleeve`, `leak`, `pump-down` and `crash`: what was measured and what was fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from layerjam.identify.logs.crash import Crash
from layerjam.identify.logs.leak import Leak
from layerjam.identify.logs.pump_down import PumpDown
from layerjam.identify.rubber import hyperelastic
from layerjam.identify.rubber.tensile import Moduli, Specimen
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
    labels_right,
    look,
    save,
    title,
)
from layerjam.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["crash", "leak", "pump_down", "save", "sleeve"]
_COLOURS = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)
_MODELS = dict(zip(hyperelastic.PARAMETERS, (GREY, SKY, GREEN, ORANGE, RED), strict=True))
_LAWS = {"linear": BLUE, "laminar": GREEN, "orifice": RED}
_MOST = 2000


def _thin(count: int) -> slice:
    """No more points than a figure can show."""
    return slice(None, None, max(count // _MOST, 1))


def sleeve(
    specimens: Mapping[str, tuple[Specimen, Moduli, Mapping[str, hyperelastic.Fit], str]],
    sheets: Mapping[str, float | None],
) -> Figure:
    """Stress over strain of every specimen with its model, and the first 150 % close up.

    `sheets` is the data sheet's 100 % modulus [Pa] by file, None where it is not known.
    """
    with look():
        figure, (whole, near) = canvas(columns=2, width=10.4, height=4.3)
        many = len(specimens) > 1
        ends = []
        for (path, made), colour in zip(specimens.items(), _cycle(len(specimens)), strict=True):
            specimen, found, fits, model = made
            _curve(whole, specimen, fits[model], colour)
            _curve(near, specimen, fits[model], colour)
            ends.append((found.modulus_100 or 0.0, specimen.name.rsplit(".", 1)[0], colour))
            _at_100(near, found, sheets.get(path), colour)
            if not many:
                _others(whole, near, specimen, fits, model)
        _frame(
            whole,
            near,
            [made[0] for made in specimens.values()],
            [s for s in sheets.values() if s is not None],
        )
        if many:
            _names(near, ends)
            title(whole, "Whole curves", "points: measured; lines: the model chosen for each")
        else:
            (made,) = specimens.values()
            title(whole, made[0].name, f"points: measured; {made[3]} chosen, others pale")
        title(near, "Up to 150 %", "dot: 100 % modulus; diamond: data sheet")
    return figure


def _cycle(count: int) -> list[str]:
    return [_COLOURS[i % len(_COLOURS)] for i in range(count)]


def _curve(axes: Axes, specimen: Specimen, fit: hyperelastic.Fit, colour: str) -> None:
    kept = _thin(4 * len(specimen.strain))
    axes.plot(
        specimen.strain[kept] * 100,
        specimen.stress[kept] / 1e6,
        ".",
        color=colour,
        ms=3,
        alpha=0.45,
    )
    x = np.linspace(0, fit.strain_range[1], 300)
    axes.plot(
        x * 100, hyperelastic.stress(fit.model, fit.parameters, x) / 1e6, color=colour, lw=1.4
    )


def _others(
    whole: Axes, near: Axes, specimen: Specimen, fits: Mapping[str, hyperelastic.Fit], chosen: str
) -> None:
    """The models not chosen, named at the right end."""
    top = float(specimen.stress.max()) / 1e6
    end = float(specimen.strain[-1])
    names = []
    for model, fit in fits.items():
        x = np.linspace(0, fit.strain_range[1], 300)
        y = hyperelastic.stress(model, fit.parameters, x) / 1e6
        if model != chosen:
            for axes in (whole, near):
                axes.plot(x * 100, y, color=_MODELS[model], lw=0.9, alpha=0.75, zorder=1)
        names.append(
            (min(float(y[-1]), 1.12 * top), model, BLUE if model == chosen else _MODELS[model])
        )
    whole.set_ylim(-0.04 * top, 1.15 * top)
    labels_right(whole, end * 100, names)


def _at_100(axes: Axes, found: Moduli, sheet: float | None, colour: str) -> None:
    if found.modulus_100 is not None:
        axes.plot(100, found.modulus_100 / 1e6, "o", color=colour, ms=6)
    if sheet is not None:
        axes.plot(100, sheet / 1e6, "D", mfc="white", mec=colour, mew=1.6, ms=6.5)
    if sheet is not None and found.modulus_100 is not None:
        axes.plot([100, 100], [found.modulus_100 / 1e6, sheet / 1e6], color=colour, lw=0.8, ls=":")


def _frame(whole: Axes, near: Axes, specimens: Sequence[Specimen], sheets: Sequence[float]) -> None:
    far = max(sheets, default=0.0) / 1e6
    for specimen in specimens:
        inside = specimen.strain <= 1.5
        far = max(far, float(specimen.stress[inside].max(initial=0.0)) / 1e6)
    for axes in (whole, near):
        axes.set(xlabel="engineering strain [%]", ylabel="engineering stress [MPa]")
    near.set(xlim=(0, 150), ylim=(-0.04 * far, 1.12 * far))
    whole.set_xlim(left=0)


def _names(axes: Axes, ends: Sequence[tuple[float, str, str]]) -> None:
    """Names of many specimens as a list, the stiffest first."""
    for line, (_, name, colour) in enumerate(sorted(ends, reverse=True)):
        axes.text(
            0.03, 0.95 - 0.062 * line, name, transform=axes.transAxes, color=colour, fontsize=8.8,
            va="center", fontweight="bold",
        )  # fmt: skip


def leak(found: Leak) -> Figure:
    """The log with the three laws, and what each leaves over."""
    with look():
        figure, (above, below) = canvas(
            rows=2, width=6.8, height=5.2, height_ratios=(2.2, 1), sharex=True
        )
        kept = _thin(len(found.time))
        t, p = found.time[kept] + found.window[0], found.pressure[kept]
        above.plot(t, p / 1e3, ".", color=GREY, ms=2, alpha=0.5)
        for name, fit in found.fits.items():
            y = fit.curve(found.time, found.atmosphere)
            first = name == found.best
            above.plot(
                t, y[kept] / 1e3, color=_LAWS[name], lw=2.0 if first else 1.1,
                zorder=3 if first else 2,
            )  # fmt: skip
            below.plot(t, (p - y[kept]) / 1e3, color=_LAWS[name], lw=0.9, alpha=0.9)
        above.set(ylabel="pressure, absolute [kPa]")
        below.set(xlabel="time [s]", ylabel="log − law [kPa]")
        below.axhline(0, color=INK, lw=0.7)
        _laws(above, found)
        detail = "nearest law" if found.distinct else "nearest law, but they are not told apart"
        title(above, f"Pressure hold: {found.best}", f"points: log; thick line: {detail}")
    return figure


def _laws(axes: Axes, found: Leak) -> None:
    """Names of the laws with their time constants, in the corner the curve leaves free."""
    falls = found.pressure[0] > found.pressure[-1]
    for line, (name, fit) in enumerate(found.fits.items()):
        constant = show(1 / fit.rate, "s") if fit.rate > 0 else "no leak"
        axes.text(
            0.97, (0.94 - 0.075 * line) if falls else (0.06 + 0.075 * line),
            f"{name}: {constant}", transform=axes.transAxes, ha="right", va="center",
            color=_LAWS[name], fontsize=9, fontweight="bold" if name == found.best else "normal",
        )  # fmt: skip


def pump_down(alone: PumpDown, second: PumpDown | None, constant: PumpDown | None) -> Figure:
    """The log and its fit, on a logarithmic scale over the ultimate pressure beside it."""
    with look():
        figure, (plain, logged) = canvas(columns=2, width=10.0, height=4.0)
        shown = [(alone, BLUE, "alone" if second else "fit")]
        if second is not None:
            shown.append((second, RED, "with the volume added"))
        if constant is not None:
            shown.append((constant, GREY, "constant volume"))
        for fit, colour, name in shown:
            kept = _thin(len(fit.time))
            t, p, made = fit.time[kept], fit.pressure[kept], fit.curve(fit.time)[kept]
            if fit is not constant:
                plain.plot(t, p / 1e3, ".", color=colour, ms=2.5, alpha=0.3)
                over = p > fit.ultimate
                logged.plot(
                    t[over], (p - fit.ultimate)[over] / 1e3, ".", color=colour, ms=2.5, alpha=0.3
                )
            plain.plot(t, made / 1e3, color=colour, lw=1.6)
            clear = made > fit.ultimate
            logged.plot(t[clear], (made - fit.ultimate)[clear] / 1e3, color=colour, lw=1.6)
            line = [f for f, *_ in shown].index(fit)
            text = f"{name}: flow/volume {fit.rate:.4g} 1/s"
            plain.text(
                0.97, 0.93 - 0.075 * line, text, transform=plain.transAxes, ha="right",
                color=colour, fontsize=9,
            )  # fmt: skip
        plain.axhline(alone.ultimate / 1e3, color=FAINT, lw=1.0, ls=(0, (4, 3)))
        end = float(alone.time[-1])
        label(
            plain,
            0.02 * end,
            alone.ultimate / 1e3,
            f"ultimate {alone.ultimate / 1e3:.3g} kPa",
            GREY,
        )
        plain.set(xlabel="time [s]", ylabel="pressure, absolute [kPa]", ylim=(0, None))
        logged.set(xlabel="time [s]", ylabel="pressure over ultimate [kPa]", yscale="log")
        floor = max(alone.series.noise / 2, 1e-4 * alone.start)
        logged.set_ylim(bottom=floor / 1e3)
        title(plain, "Pump-down", "points: log; line: fit")
        title(logged, "Over the ultimate pressure", "straight where volume and flow are constant")
    return figure


def crash(found: Crash) -> Figure:
    """The pulse as logged and filtered, and the change of velocity."""
    with look():
        figure, (pulse, speed) = canvas(
            rows=2, width=6.8, height=5.4, height_ratios=(2, 1), sharex=True
        )
        length = found.pulse[1] - found.pulse[0]
        first, last = found.pulse[0] - 0.8 * length, found.pulse[1] + 0.8 * length
        near = (found.time >= first) & (found.time <= last)
        t = (found.time[near] - found.pulse[0]) * 1e3
        g = STANDARD_GRAVITY
        pulse.plot(t, found.acceleration[near] / g, color=GREY, lw=0.9)
        pulse.plot(t, found.filtered[near] / g, color=BLUE, lw=2)
        at = (found.filtered_peak_time - found.pulse[0]) * 1e3
        pulse.plot(at, found.filtered_peak / g, "o", color=BLUE, ms=6)
        name = "not filtered" if found.cfc is None else f"CFC {found.cfc}"
        for line, (text, colour) in enumerate(
            (
                (f"log: {found.peak / g:.4g} g", GREY),
                (f"{name}: {found.filtered_peak / g:.4g} g", BLUE),
            )
        ):
            high = found.filtered_peak > 0
            pulse.text(
                0.98, (0.93 - 0.08 * line) if high else (0.15 - 0.08 * line), text, ha="right",
                transform=pulse.transAxes, color=colour, fontsize=9.5,
            )  # fmt: skip
        for axes in (pulse, speed):
            axes.axvspan(0, length * 1e3, color=FAINT, alpha=0.35, lw=0)
        if found.saturated and found.saturation is not None:
            pulse.axhline(np.sign(found.peak) * found.saturation / g, color=RED, lw=1, ls="--")
        moved = found.velocity()[near]
        speed.plot(t, moved - moved[0], color=GREEN)
        pulse.set(ylabel="acceleration [g]")
        speed.set(xlabel="time from the start of the pulse [ms]", ylabel="velocity change [m/s]")
        title(
            pulse, "Pulse" + (", saturated" if found.saturated else ""),
            f"grey ground: over 5 % of the filtered peak, {show(length, 's')}; offset taken off",
        )  # fmt: skip
    return figure
