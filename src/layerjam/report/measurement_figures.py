"""Figures of `ageing`, `enclosure`, `leak`, `pump-down` and `crash`: measurement and fit."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from layerjam.identify.friction.ageing import AgeingFit
from layerjam.identify.logs.crash import Crash
from layerjam.identify.logs.leak import Leak
from layerjam.identify.logs.pump_down import PumpDown
from layerjam.identify.rubber import hyperelastic
from layerjam.identify.rubber.tensile import Moduli, Specimen
from layerjam.report import style
from layerjam.report.style import BLUE, FAINT, GREEN, GREY, INK, KPA, MS, ORANGE, RED, SKY
from layerjam.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.units import show

_MODELS = dict(zip(hyperelastic.PARAMETERS, (GREY, SKY, GREEN, ORANGE, RED), strict=True))
_LAWS = {"linear": BLUE, "laminar": GREEN, "orifice": RED}
MPA = 1e-6
Made = tuple[Specimen, Moduli, Mapping[str, hyperelastic.Fit], str]


@style.styled
def sleeve(specimens: Mapping[str, Made], sheets: Mapping[str, float | None]) -> style.Figure:
    """Stress over strain of every specimen with its model, and the first 150 % close up.

    `sheets` is the data sheet's 100 % modulus [Pa] by file, None where it is not known.
    """
    figure, (whole, near) = style.canvas(columns=2, width=10.4, height=4.3)
    far, names = max((s or 0.0 for s in sheets.values()), default=0.0), []
    for index, (path, (specimen, found, fits, model)) in enumerate(specimens.items()):
        color = style.CYCLE[index % len(style.CYCLE)]
        for axes in (whole, near):
            x, y = style.thinned(specimen.strain * 100, specimen.stress * MPA)
            axes.plot(x, y, ".", color=color, ms=3, alpha=0.45)
            _model(axes, fits[model], color)
        _at_100(near, found, sheets.get(path), color)
        names.append((found.modulus_100 or 0.0, Path(specimen.name).stem, color))
        far = max(far, float(specimen.stress[specimen.strain <= 1.5].max(initial=0.0)))
    for axes in (whole, near):
        axes.set(xlabel="engineering strain [%]", ylabel="engineering stress [MPa]")
    near.set(xlim=(0, 150), ylim=(-0.04 * far * MPA, 1.12 * far * MPA))
    whole.set_xlim(left=0)
    if len(specimens) > 1:
        style.key(near, *(name[1:] for name in sorted(names, reverse=True)), at="upper left")
        style.title(whole, "Whole curves", "points: measured; lines: the model chosen for each")
    else:
        _others(whole, near, specimen, fits, model)
        style.title(whole, specimen.name, f"points: measured; {model} chosen, others pale")
    style.title(near, "Up to 150 %", "dot: 100 % modulus; diamond: data sheet")
    return figure


def _model(axes: style.Axes, fit: hyperelastic.Fit, color: str, lw: float = 1.4) -> float:
    """A model's curve over the strains it was fitted to; its stress at the end [MPa]."""
    x = np.linspace(0, fit.strain_range[1], 300)
    y = hyperelastic.stress(fit.model, fit.parameters, x) * MPA
    axes.plot(x * 100, y, color=color, lw=lw)
    return float(y[-1])


def _others(
    whole: style.Axes,
    near: style.Axes,
    specimen: Specimen,
    fits: Mapping[str, hyperelastic.Fit],
    chosen: str,
) -> None:
    """The models not chosen, named at the right end."""
    top = float(specimen.stress.max()) * MPA
    names = []
    for model, fit in fits.items():
        color, width = (BLUE, 1.4) if model == chosen else (_MODELS[model], 0.9)
        _model(near, fit, color, width)
        names.append((min(_model(whole, fit, color, width), 1.12 * top), model, color))
    whole.set_ylim(-0.04 * top, 1.15 * top)
    style.labels_right(whole, float(specimen.strain[-1]) * 100, names)


def _at_100(axes: style.Axes, found: Moduli, sheet: float | None, color: str) -> None:
    own = found.modulus_100
    if own is not None:
        style.spot(axes, 100, own * MPA, color=color)
    if sheet is not None:
        style.spot(axes, 100, sheet * MPA, color=color, shape="D", mfc="white", mew=1.6)
    if sheet is not None and own is not None:
        axes.plot([100, 100], [own * MPA, sheet * MPA], color=color, lw=0.8, ls=":")


@style.styled
def leak(found: Leak) -> style.Figure:
    """The log with the three laws, and what each leaves over."""
    figure, (above, below) = style.canvas(
        rows=2, width=6.8, height=5.2, height_ratios=(2.2, 1), sharex=True
    )
    t = found.time + found.window[0]
    above.plot(*style.thinned(t, found.pressure * KPA), ".", color=GREY, ms=2, alpha=0.5)
    for name, fit in found.fits.items():
        y = fit.curve(found.time, found.atmosphere)
        best = name == found.best
        words = f"{name}: {show(1 / fit.rate, 's') if fit.rate > 0 else 'no leak'}"
        x, law = style.thinned(t, y * KPA)
        above.plot(x, law, color=_LAWS[name], lw=2.4 if best else 1.1, zorder=2 + best, label=words)
        left = style.thinned(t, (found.pressure - y) * KPA)
        below.plot(*left, color=_LAWS[name], lw=0.9, alpha=0.9)
    below.axhline(0, color=INK, lw=0.7)
    style.key(above, at="upper right" if found.pressure[0] > found.pressure[-1] else "lower right")
    detail = "nearest law" if found.distinct else "nearest law, but they are not told apart"
    detail = f"points: log; thick line: {detail}; time constants"
    style.panel(above, f"Pressure hold: {found.best}", detail, ylabel="pressure, absolute [kPa]")
    style.panel(below, xlabel="time [s]", ylabel="log − law [kPa]")
    return figure


@style.styled
def ageing(found: AgeingFit) -> style.Figure:
    """Static friction of every pull over its hold, and the line."""
    figure, (axes,) = style.canvas()
    ends = found.holds.min() / 1.5, found.holds.max() * 1.5
    hold = np.geomspace(*ends, 50)
    axes.plot(found.holds, found.values, "o", color=GREY, ms=4, alpha=0.7)
    axes.plot(hold, found.at(hold), color=BLUE)
    low, high = float(found.values.min()), float(found.values.max())
    room = 0.3 * (high - low) or 0.1 * high
    style.panel(axes, xlabel="hold [s]", ylabel="static friction [-]")
    axes.set(xlim=ends, ylim=(low - room, high + room))
    style.plain(axes)
    style.title(axes, f"{found.ageing:+.4f} for ten times the hold", "points: pulls; line: fit")
    return figure


@style.styled
def pump_down(alone: PumpDown, second: PumpDown | None, constant: PumpDown | None) -> style.Figure:
    """The log and its fit, on a logarithmic scale over the ultimate pressure beside it."""
    figure, (plain, logged) = style.canvas(columns=2, width=10.0, height=4.0)
    names = ("alone" if second else "fit", BLUE), ("with the volume added", RED)
    fits = zip((alone, second, constant), (*names, ("constant volume", GREY)), strict=True)
    for fit, (name, color) in fits:
        if fit is None:
            continue
        t, p = style.thinned(fit.time, fit.pressure)
        made, words = fit.curve(fit.time), f"{name}: flow/volume {fit.rate:.4g} 1/s"
        for axes, floor in ((plain, -np.inf), (logged, fit.ultimate)):
            base = fit.ultimate if axes is logged else 0.0
            seen, clear = p > floor, made > floor
            if fit is not constant:
                over = (p - base)[seen] * KPA
                axes.plot(t[seen], over, ".", color=color, ms=2.5, alpha=0.3)
            axes.plot(fit.time[clear], (made - base)[clear] * KPA, color=color, lw=1.6, label=words)
    ultimate = f"ultimate {alone.ultimate * KPA:.3g} kPa"
    plain.set(xlabel="time [s]", ylabel="pressure, absolute [kPa]", ylim=(0, None))
    style.level(plain, alone.ultimate * KPA, ultimate, GREY)
    style.key(plain, at="upper right")
    floor = max(alone.series.noise / 2, 1e-4 * alone.start)
    logged.set(xlabel="time [s]", ylabel="pressure over ultimate [kPa]", yscale="log")
    logged.set_ylim(bottom=floor * KPA)
    style.title(plain, "Pump-down", "points: log; line: fit")
    detail = "straight where volume and flow are constant"
    style.title(logged, "Over the ultimate pressure", detail)
    return figure


@style.styled
def crash(found: Crash) -> style.Figure:
    """The pulse as logged and filtered, and the change of velocity."""
    figure, (pulse, speed) = style.canvas(
        rows=2, width=6.8, height=5.4, height_ratios=(2, 1), sharex=True
    )
    (start, stop), g = found.pulse, STANDARD_GRAVITY
    room = 0.8 * (stop - start)
    near = (found.time >= start - room) & (found.time <= stop + room)
    t = (found.time[near] - start) * MS
    name = "not filtered" if found.cfc is None else f"CFC {found.cfc}"
    signals: Sequence[tuple[str, np.ndarray, float, str, float]] = (
        ("log", found.acceleration, found.peak, GREY, 0.9),
        (name, found.filtered, found.filtered_peak, BLUE, 2.0),
    )
    for words, values, peak, color, width in signals:
        pulse.plot(t, values[near] / g, color=color, lw=width, label=f"{words}: {peak / g:.4g} g")
    style.spot(pulse, (found.filtered_peak_time - start) * MS, found.filtered_peak / g, color=BLUE)
    for axes in (pulse, speed):
        axes.axvspan(0, (stop - start) * MS, color=FAINT, alpha=0.35, lw=0)
    if found.saturated and found.saturation is not None:
        style.level(pulse, float(np.sign(found.peak)) * found.saturation / g)
    style.key(pulse, at="upper right" if found.filtered_peak > 0 else "lower right")
    moved = found.velocity()[near]
    speed.plot(t, moved - moved[0], color=GREEN)
    detail = f"grey ground: over 5 % of the filtered peak, {show(stop - start, 's')}; offset off"
    headline = "Pulse" + (", saturated" if found.saturated else "")
    style.panel(pulse, headline, detail, ylabel="acceleration [g]")
    below = "time from the start of the pulse [ms]"
    style.panel(speed, xlabel=below, ylabel="velocity change [m/s]")
    return figure
