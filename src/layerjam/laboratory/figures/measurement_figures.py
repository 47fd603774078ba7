"""Figures of `ageing`, `enclosure`, `leak`, `pump-down` and `crash`: measurement and fit."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from layerjam.brake.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, FAINT, GREEN, GREY, INK, KPA, MS, ORANGE, RED, SKY
from layerjam.core.units import show
from layerjam.laboratory.identify.friction.ageing import AgeingFit
from layerjam.laboratory.identify.logs.crash import Crash
from layerjam.laboratory.identify.logs.leak import Leak
from layerjam.laboratory.identify.logs.pump_down import PumpDown
from layerjam.laboratory.identify.rubber import hyperelastic
from layerjam.laboratory.identify.rubber.tensile import Moduli, Specimen

_MODELS = dict(zip(hyperelastic.PARAMETERS, (GREY, SKY, GREEN, ORANGE, RED), strict=True))
_LAWS = {"linear": BLUE, "laminar": GREEN, "orifice": RED}
MPA = 1e-6
SpecimenResult = tuple[Specimen, Moduli, Mapping[str, hyperelastic.Fit], str]


@style.use_style
def draw_sleeve(
    specimens: Mapping[str, SpecimenResult], sheets: Mapping[str, float | None]
) -> style.Figure:
    """Draw stress versus strain of every specimen with its model, and the first 150 % enlarged.

    `sheets` is the data sheet's 100 % modulus [Pa] for each file, None if unknown.
    """
    figure, (full, zoom) = style.make_axes(columns=2, width=10.4, height=4.3)
    top, names = max((s or 0.0 for s in sheets.values()), default=0.0), []
    for index, (path, (specimen, moduli, fits, model)) in enumerate(specimens.items()):
        color = style.CYCLE[index % len(style.CYCLE)]
        for axes in (full, zoom):
            x, y = style.thin_out(specimen.strain * 100, specimen.stress * MPA)
            axes.plot(x, y, ".", color=color, ms=3, alpha=0.45)
            _draw_model(axes, fits[model], color)
        _draw_moduli_at_100(zoom, moduli, sheets.get(path), color)
        names.append((moduli.modulus_100 or 0.0, Path(specimen.name).stem, color))
        top = max(top, float(specimen.stress[specimen.strain <= 1.5].max(initial=0.0)))
    for axes in (full, zoom):
        axes.set(xlabel="engineering strain [%]", ylabel="engineering stress [MPa]")
    zoom.set(xlim=(0, 150), ylim=(-0.04 * top * MPA, 1.12 * top * MPA))
    full.set_xlim(left=0)
    if len(specimens) > 1:
        style.add_key(zoom, *(name[1:] for name in sorted(names, reverse=True)), loc="upper left")
        style.add_title(full, "Whole curves", "points: measured; lines: the model chosen for each")
    else:
        _draw_other_models(full, zoom, specimen, fits, model)
        style.add_title(full, specimen.name, f"points: measured; {model} chosen, others pale")
    style.add_title(zoom, "Up to 150 %", "dot: 100 % modulus; diamond: data sheet")
    return figure


def _draw_model(axes: style.Axes, fit: hyperelastic.Fit, color: str, lw: float = 1.4) -> float:
    """Draw a model's curve over the fitted strains; return its stress at the end [MPa]."""
    x = np.linspace(0, fit.strain_range[1], 300)
    y = hyperelastic.stress(fit.model, fit.parameters, x) * MPA
    axes.plot(x * 100, y, color=color, lw=lw)
    return float(y[-1])


def _draw_other_models(
    full: style.Axes,
    zoom: style.Axes,
    specimen: Specimen,
    fits: Mapping[str, hyperelastic.Fit],
    best: str,
) -> None:
    top = float(specimen.stress.max()) * MPA
    names = []
    for model, fit in fits.items():
        color, width = (BLUE, 1.4) if model == best else (_MODELS[model], 0.9)
        _draw_model(zoom, fit, color, width)
        names.append((min(_draw_model(full, fit, color, width), 1.12 * top), model, color))
    full.set_ylim(-0.04 * top, 1.15 * top)
    style.add_end_labels(full, float(specimen.strain[-1]) * 100, names)


def _draw_moduli_at_100(axes: style.Axes, moduli: Moduli, sheet: float | None, color: str) -> None:
    modulus = moduli.modulus_100
    if modulus is not None:
        style.add_point(axes, 100, modulus * MPA, color=color)
    if sheet is not None:
        style.add_point(axes, 100, sheet * MPA, color=color, shape="D", mfc="white", mew=1.6)
    if sheet is not None and modulus is not None:
        axes.plot([100, 100], [modulus * MPA, sheet * MPA], color=color, lw=0.8, ls=":")


@style.use_style
def draw_leak(log: Leak) -> style.Figure:
    """Draw the leak log with the three laws, and the residuals of each."""
    figure, (above, below) = style.make_axes(
        rows=2, width=6.8, height=5.2, height_ratios=(2.2, 1), sharex=True
    )
    t = log.time + log.window[0]
    above.plot(*style.thin_out(t, log.pressure * KPA), ".", color=GREY, ms=2, alpha=0.5)
    for name, fit in log.fits.items():
        y = fit.curve(log.time, log.atmosphere)
        best = name == log.best
        words = f"{name}: {show(1 / fit.rate, 's') if fit.rate > 0 else 'no leak'}"
        x, law = style.thin_out(t, y * KPA)
        above.plot(x, law, color=_LAWS[name], lw=2.4 if best else 1.1, zorder=2 + best, label=words)
        residuals = style.thin_out(t, (log.pressure - y) * KPA)
        below.plot(*residuals, color=_LAWS[name], lw=0.9, alpha=0.9)
    below.axhline(0, color=INK, lw=0.7)
    style.add_key(above, loc="upper right" if log.pressure[0] > log.pressure[-1] else "lower right")
    detail = "best-fitting law" if log.distinct else "best-fitting law; others fit equally well"
    detail = f"points: log; thick line: {detail}; time constants"
    style.label_axes(above, f"Pressure hold: {log.best}", detail, ylabel="pressure, absolute [kPa]")
    style.label_axes(below, xlabel="time [s]", ylabel="measured − law [kPa]")
    return figure


@style.use_style
def draw_ageing(fit: AgeingFit) -> style.Figure:
    """Draw the static friction of every pull versus its hold time, and the fitted line."""
    figure, (axes,) = style.make_axes()
    ends = fit.holds.min() / 1.5, fit.holds.max() * 1.5
    hold = np.geomspace(*ends, 50)
    axes.plot(fit.holds, fit.values, "o", color=GREY, ms=4, alpha=0.7)
    axes.plot(hold, fit.static_at(hold), color=BLUE)
    low, high = float(fit.values.min()), float(fit.values.max())
    margin = 0.3 * (high - low) or 0.1 * high
    style.label_axes(axes, xlabel="hold time [s]", ylabel="static friction [-]")
    axes.set(xlim=ends, ylim=(low - margin, high + margin))
    style.set_log_scale(axes)
    style.add_title(axes, f"{fit.ageing:+.4f} per tenfold hold time", "points: pulls; line: fit")
    return figure


@style.use_style
def draw_pump_down(
    first: PumpDown, second: PumpDown | None, constant: PumpDown | None
) -> style.Figure:
    """Draw the pump-down log, its fit, and the log of the excess over the ultimate pressure."""
    figure, (linear_axes, log_axes) = style.make_axes(columns=2, width=10.0, height=4.0)
    names = ("alone" if second else "fit", BLUE), ("with the volume added", RED)
    fits = zip((first, second, constant), (*names, ("constant volume", GREY)), strict=True)
    for fit, (name, color) in fits:
        if fit is None:
            continue
        t, p = style.thin_out(fit.time, fit.pressure)
        model, words = fit.curve(fit.time), f"{name}: flow/volume {fit.rate:.4g} 1/s"
        for axes, floor in ((linear_axes, -np.inf), (log_axes, fit.ultimate)):
            base = fit.ultimate if axes is log_axes else 0.0
            shows, clear = p > floor, model > floor
            if fit is not constant:
                excess = (p - base)[shows] * KPA
                axes.plot(t[shows], excess, ".", color=color, ms=2.5, alpha=0.3)
            axes.plot(
                fit.time[clear], (model - base)[clear] * KPA, color=color, lw=1.6, label=words
            )
    ultimate = f"ultimate {first.ultimate * KPA:.3g} kPa"
    linear_axes.set(xlabel="time [s]", ylabel="pressure, absolute [kPa]", ylim=(0, None))
    style.mark_y(linear_axes, first.ultimate * KPA, ultimate, GREY)
    style.add_key(linear_axes, loc="upper right")
    floor = max(first.series.noise / 2, 1e-4 * first.start)
    log_axes.set(xlabel="time [s]", ylabel="pressure above ultimate [kPa]", yscale="log")
    log_axes.set_ylim(bottom=floor * KPA)
    style.add_title(linear_axes, "Pump-down", "points: log; line: fit")
    detail = "straight if volume and flow are constant"
    style.add_title(log_axes, "Above the ultimate pressure", detail)
    return figure


@style.use_style
def draw_crash(log: Crash) -> style.Figure:
    """Draw the pulse as logged and filtered, and the change in velocity."""
    figure, (pulse, speed) = style.make_axes(
        rows=2, width=6.8, height=5.4, height_ratios=(2, 1), sharex=True
    )
    (start, stop), g = log.pulse, STANDARD_GRAVITY
    margin = 0.8 * (stop - start)
    is_near = (log.time >= start - margin) & (log.time <= stop + margin)
    t = (log.time[is_near] - start) * MS
    name = "not filtered" if log.cfc is None else f"CFC {log.cfc}"
    signals: Sequence[tuple[str, np.ndarray, float, str, float]] = (
        ("log", log.acceleration, log.peak, GREY, 0.9),
        (name, log.filtered, log.filtered_peak, BLUE, 2.0),
    )
    for words, values, peak, color, width in signals:
        pulse.plot(
            t, values[is_near] / g, color=color, lw=width, label=f"{words}: {peak / g:.4g} g"
        )
    style.add_point(pulse, (log.filtered_peak_time - start) * MS, log.filtered_peak / g, color=BLUE)
    for axes in (pulse, speed):
        axes.axvspan(0, (stop - start) * MS, color=FAINT, alpha=0.35, lw=0)
    if log.saturated and log.saturation is not None:
        style.mark_y(pulse, float(np.sign(log.peak)) * log.saturation / g)
    style.add_key(pulse, loc="upper right" if log.filtered_peak > 0 else "lower right")
    velocity = log.velocity()[is_near]
    speed.plot(t, velocity - velocity[0], color=GREEN)
    detail = f"grey: above 5 % of the filtered peak, {show(stop - start, 's')}; offset removed"
    headline = "Pulse" + (", saturated" if log.saturated else "")
    style.label_axes(pulse, headline, detail, ylabel="acceleration [g]")
    x_label = "time from the start of the pulse [ms]"
    style.label_axes(speed, xlabel=x_label, ylabel="velocity change [m/s]")
    return figure
