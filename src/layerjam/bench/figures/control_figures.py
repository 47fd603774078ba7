"""Figures of a controller on its line, of a force that follows a profile, and of a plan."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.bench.control.closed_loop import ClosedLoop
from layerjam.bench.control.settings import Regulator
from layerjam.core.drawing import style
from layerjam.core.drawing.chart import Curve, Pane, draw_panes
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, KPA, ORANGE, RED, SKY
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.bench.control.follow import Bode, Following, ForceSpread
    from layerjam.bench.control.plan import Arrival, Plan


def loop_panes(regulator: Regulator, run: ClosedLoop, fault_at: float | None = None) -> list[Pane]:
    """Return panes of vacuum, reading and target, and of the commands, shaded after a fault."""
    time, end = run.time, float(run.time[-1])
    vacuum = [
        Curve(time, run.vacuum * KPA, name="vacuum"),
        Curve(time, run.measured * KPA, SKY, "sensor", width=1.0),
        Curve(time, run.target * KPA, GREEN, "target", "dashed", 1.5),
    ]
    commands = [
        Curve(time, run.pump, name="pump", width=1.2),
        Curve(time, run.vent, RED, "vent", width=1.5),
    ]
    fault_time = float(run.fault_time) if np.isfinite(run.fault_time) else end
    begin_time = fault_time if fault_at is None else min(fault_at, fault_time)
    grounds = (begin_time, fault_time, ORANGE), (fault_time, end, RED)
    common: dict[str, Any] = {"x": "time [s]", "x_range": (0, end)}
    common["spans"] = [ground for ground in grounds if ground[0] < ground[1]]
    high = 1.15 * float(max(run.target.max(), run.vacuum.max())) * KPA
    rise = show(run.rise_time, "s", 3) if np.isfinite(run.rise_time) else "never reached"
    words = (
        f"rise time (10 to 90 %): {rise}; overshoot {show(run.overshoot, 'Pa', 3)}; pump switched "
    )
    words += f"{run.pump_switches} times"
    titles: dict[str, Any] = {
        "headline": f"Controller “{regulator.kind}” {describe_outcome(run.outcome)}",
        "detail": words,
    }
    low = min(1.15 * float(run.pump.min()), 0.0)
    return [
        Pane(vacuum, y="vacuum [kPa]", y_range=(0, high), share=1.7, **titles, **common),
        Pane(commands, y="command [-]", y_range=(low, 1.15), **common),
    ]


def describe_outcome(outcome: str) -> str:
    """Return what a controller does about the state that its detectors report, in words."""
    if outcome == "HEALTHY":
        return "detects no fault"
    return f"detects the fault “{outcome.replace('_', ' ').lower()}”"


def bench_panes(time: Any, vacuum: Any, target: Any, **pane: Any) -> list[Pane]:
    """Return panes of a bench's vacuum [Pa] (NaN if not read) and target [Pa] versus time [s]."""
    target_kpa, vacuum_kpa = np.asarray(target, float) * KPA, np.asarray(vacuum, float) * KPA
    aim = Curve(time, target_kpa, GREEN, "target", "dashed", 1.5)
    highest = max(50.0, 1.15 * float(np.nanmax((*target_kpa, *vacuum_kpa))))
    options = {"x": "time [s]", "x_range": (0, max(float(time[-1]), 1e-3)), **pane}
    curves, top = [Curve(time, vacuum_kpa, name="vacuum"), aim], math.ceil(highest / 10) * 10
    return [Pane(curves, y="vacuum [kPa]", y_range=(0, top), **options)]


def draw_run(
    time: Sequence[float], vacuum: Sequence[float], target: Sequence[float], simulated: bool = False
) -> style.Figure:
    """Return the figure of `bench_panes`."""
    detail = f"over {show(max(float(time[-1]), 1e-3), 's', 3)}"
    detail = "a virtual board: computed, not measured" if simulated else detail
    return draw_panes(bench_panes(time, vacuum, target, headline="Bench vacuum", detail=detail))


@style.use_style
def draw_tracking(
    run: "Following", sweep: "Bode | None", spread: "ForceSpread | None" = None
) -> style.Figure:
    """Draw force and target with the force's interval, and the response to a sinusoidal target."""
    figure, (force, *size) = style.make_axes(
        columns=1 + (sweep is not None), width=10.4, height=4.2
    )
    detail = f"error {show(run.rms, 'N', 3)} RMS; the brake slips from "
    detail += f"{show(float(run.slip[0]), 'm', 3)} to {show(float(run.slip[-1]), 'm', 3)}"
    top = max(run.wanted.max(), run.force.max(), 0.0 if spread is None else spread.high.max())
    draw_profile(force, run, 1.3 * float(top), spread)
    style.add_title(force, "A force that follows a profile", detail)
    if sweep is not None:
        wide = (
            "above the tested range" if sweep.bandwidth is None else show(sweep.bandwidth, "Hz", 3)
        )
        phase = size[0].twinx()
        draw_frequency_response(size[0], phase, [(sweep, INK, "")], turn=(-180, 45))
        phase.grid(visible=False)
        style.add_title(size[0], "Frequency response", f"amplitude 71 % at {wide}; phase dashed")
    return figure


def draw_profile(
    axes: style.Axes, run: "Following", top: float, spread: "ForceSpread | None" = None
) -> None:
    """Draw force and target, and mark the times at which the force cannot follow.

    With a `spread`, the force of the next brake has a band, and is dashed where tests do not cover
    it.
    """
    gaps = ~run.possible
    transform = axes.get_xaxis_transform()
    axes.fill_between(run.time, 0, 1, where=gaps, color=RED, alpha=0.15, lw=0, transform=transform)
    axes.plot(run.time, run.wanted, color=GREEN, lw=2.2, alpha=0.7)
    is_tested = np.ones(len(run.time), bool)
    if spread is not None:
        style.add_band(axes, spread.time, spread.low, spread.high, GREY, 0.35)
        is_tested = np.interp(run.time, spread.time, spread.is_tested) > 0.5
    for part, dash in ((is_tested, "-"), (~is_tested, style.DASHED)):
        if part.any():
            axes.plot(run.time, np.where(part, run.force, np.nan), color=INK, lw=1.1, ls=dash)
    names: list[tuple[Any, ...]] = [("target", GREEN), ("actual", INK)]
    names += [] if is_tested.all() else [("not tested", INK, style.DASHED)]
    names += [] if spread is None else [("95 %", GREY)]
    names += [("cannot be followed", RED)] if gaps.mean() > 0.005 else []
    axes.set(xlim=(0, float(run.time[-1])), ylim=(0, top), xlabel="time [s]", ylabel="force [N]")
    style.add_key(axes, *names, loc="upper left", ncols=3)


def draw_frequency_response(
    axes: style.Axes,
    phase: style.Axes,
    sweeps: list[tuple["Bode", str, str]],
    turn: tuple[float, float],
) -> None:
    """Draw magnitude and phase of each (response, colour, name); `turn` limits the phase axis."""
    for sweep, color, _ in sweeps:
        axes.plot(sweep.frequency, sweep.magnitude, "o-", color=color, ms=3.5, lw=1.3)
        phase.plot(sweep.frequency, sweep.phase, color=color, lw=1.0, ls=style.DASHED)
    style.set_log_scale(axes)
    axes.set(ylim=(0, 1.25), xlabel="frequency [Hz]", ylabel="force / required force [-]")
    style.mark_y(axes, 2**-0.5, "71 %", GREY)
    phase.set(ylabel="phase, dashed [degrees]", ylim=turn)
    if any(name for *_, name in sweeps):
        style.add_key(axes, *((name, color) for _, color, name in sweeps), loc="lower left")


STEPS = 25
"""Number of plotted uncertainties, from zero to `WIDEST` times the given one."""
WIDEST = 2.0
GUESS = 0.1
"""Ratio of the speed's standard deviation to its mean, if none is given."""


def energy_sd(case: "Arrival") -> float:
    """Return the relative standard deviation of the energy for log-normal mass and speed."""
    mass = np.log1p((case.mass_sd / case.mass) ** 2)
    speed = np.log1p((case.speed_sd / case.speed) ** 2)
    return float(np.sqrt(np.expm1(mass + 4 * speed)))


@style.use_style
def draw_plan(plan: "Plan") -> style.Figure:
    """Draw the vacuum reached in the warning time, the peak, and the probability of failure.

    The peak is the expected one; a stop fails if the travel is used up.
    """
    figure, (rises, peaks, chances) = style.make_axes(columns=3, width=10.3, height=3.9)
    _draw_rise(rises, plan)
    _draw_failure_probability(peaks, chances, plan)
    return figure


def _draw_rise(axes: style.Axes, plan: "Plan") -> None:
    time, vacuum = plan.rising.time, plan.rising.vacuum * KPA
    end, limit = max(float(time[-1]), 1e-3), plan.needed
    axes.plot(time, vacuum, color=BLUE)
    top = max(float(vacuum.max()), 0.0 if limit is None else limit * KPA, 1.0)
    axes.set(xlim=(0, end * 1.02), ylim=(0, top * 1.22))
    axes.set(xlabel="time since the warning [s]", ylabel="vacuum [kPa]")
    style.add_point(axes, time[-1], vacuum[-1], color=BLUE, clip_on=False)
    words = [(f"{show(plan.reached, 'Pa', 3)} reached in time", BLUE)]
    headline = "Vacuum available in time"
    detail = "no vacuum at the site stops it within the travel"
    if limit is not None:
        enough, case = limit <= plan.reached, plan.case
        color = GREEN if enough else RED
        axes.axhline(limit * KPA, color=color, lw=1.2, ls=style.DASHED)
        words.append((f"{show(limit, 'Pa', 3)} needed", color))
        headline = f"{'Enough' if enough else 'Too little'} vacuum in time"
        detail = f"{show(case.mass, 'kg')} at {show(case.speed, 'm/s')}, to stop within "
        detail += f"a slip of {show(case.travel, 'm')}"
    style.add_key(axes, *words, loc="lower right")
    style.add_title(axes, headline, detail)


def _draw_failure_probability(peaks: style.Axes, chances: style.Axes, plan: "Plan") -> None:
    from layerjam.bench.control.plan_spread import (
        predict_spread,
    )  # import late, because it loads JAX

    case, brake = plan.case, plan.brake.brake
    given = energy_sd(case) > 0
    if not given:
        case = replace(case, speed_sd=GUESS * case.speed)
    cases = [
        replace(case, mass_sd=case.mass_sd * part, speed_sd=case.speed_sd * part)
        for part in np.linspace(0, WIDEST, STEPS).tolist()
    ]
    x = np.array([energy_sd(c) for c in cases]) * 100
    modes = [("full", INK, plan.reached), ("tuned", ORANGE, plan.tuned.vacuum)]
    if plan.capped:
        modes = [("full (upper limit of tuned)", INK, plan.reached)]
    highest = 0.0
    for name, color, vacuum in modes:
        runs = [predict_spread(vacuum, plan.brake, c) for c in cases]
        g = np.array([r.peak_g for r in runs])
        words = f"{name}: {show(vacuum, 'Pa', 3)}" + (
            "" if np.isfinite(g).any() else ", no stop succeeds"
        )
        peaks.plot(x, g, color=color, label=words)
        chances.plot(x, np.array([r.out for r in runs]) * 100, color=color, label=words)
        highest = max(highest, float(np.nanmax(np.append(g, 0.0))))
    usable = show(brake.sheets.usable_travel, "m")
    from_speed = "" if given else ", from the speed alone"
    peaks.set(ylim=(0, max(highest * 1.3, 1.0)), ylabel="expected peak [g]")
    chances.set_ylim(0, min(max(chances.get_ylim()[1] * 1.3, 5.0), 130))
    chances.set_ylabel("probability of running out of travel [%]")
    for axes in (peaks, chances):
        axes.set(xlim=(0, x[-1]), xlabel=f"SD of the energy{from_speed} [%]")
        if given:
            style.mark_x(axes, energy_sd(plan.case) * 100, "as specified", share=0.03)
        style.add_key(axes, loc="upper left")
    style.add_title(peaks, "Deceleration of the mass", "expected peak of the stops that succeed")
    style.add_title(
        chances, "Risk of insufficient travel", f"slip beyond the brake's travel, {usable}"
    )
