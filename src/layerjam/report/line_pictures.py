"""Pictures of the paper's line under control: regulators, a fault, forces, a plan, the coupling.

The paper has no regulator; sensor, leak and volume per slip are examples of ours and the captions
say so.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.control.closed_loop import FaultInjection, simulate
from layerjam.control.follow import bode, follow, rehabilitation
from layerjam.control.plan import Arrival, plan
from layerjam.control.plant import plant_of
from layerjam.control.settings import KINDS, Regulator
from layerjam.device.load import load
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Leak, Line, Sensor, Valve
from layerjam.report.plan_figures import planned
from layerjam.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
    canvas,
    label,
    look,
    title,
)
from layerjam.simulate.coupled import coupled_drop

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KPA, MM = 1e3, 1e-3
SENSOR = Sensor(range=103e3, lag=0.005, noise=50.0, resolution=25.0)
HELD = 80e3
"""Target of the regulators [Pa]."""
COLORS = dict(zip(KINDS, (BLUE, ORANGE, INK), strict=True))
PROFILE = {"low": 20.0, "high": 100.0, "period": 16.0}
WIDER = 40e-6
"""Volume per slip [m^2] of the coupled stops: a guess, no source prints one."""
COLLISION = Arrival(mass=1.0, speed=2.5, warning=3.0, travel=40e-3, mass_sd=0.1, speed_sd=0.2)


def example_line() -> Line:
    """The paper's line with a leak that empties it in 500 s and a small valve, both examples."""
    line = load_line("choi2018").line
    leak = Leak(laminar=line.chamber.volume * 0.002)
    return replace(line, leak=leak, valve=Valve(conductance=3.5e-10))


def regulator(kind: str, safe_state: str = "release") -> Regulator:
    """One of the three on the example line."""
    plant = plant_of(example_line(), vacuum=HELD)
    return Regulator(plant=plant, sensor=SENSOR, kind=kind, safe_state=safe_state, tuned_at=HELD)


def regulators() -> Figure:
    """Three regulators near their target, and a pump that dies under one of them."""
    with look():
        figure, (near, fault) = canvas(columns=2, width=9.6, height=3.9)
        rows = []
        for kind in KINDS:
            made = simulate(regulator(kind), [(25.0, HELD)])
            near.plot(made.time, made.vacuum / KPA, color=COLORS[kind], lw=1.3)
            switched = f"{kind}: {made.pump_switches} switchings"
            rows.append((float(made.vacuum[-1]) / KPA, switched, COLORS[kind]))
        near.axhline(HELD / KPA, color=GREEN, lw=1.0, ls=(0, (4, 2)))
        near.set(xlim=(3, 25), ylim=(78.8, 81.2), xlabel="time [s]", ylabel="vacuum [kPa]")
        for level, (_, text, color) in zip((81.05, 80.92, 80.79), rows, strict=True):
            label(near, 11.5, level, text, color)
        label(near, 3.3, 80.09, "target", GREEN)
        title(near, "Three regulators hold 80 kPa", "the true vacuum; the pump's switchings in all")
        for state, color, place in (("release", RED, (2.55, 12.0)), ("hold", BLUE, (2.9, 47.0))):
            made = simulate(
                regulator("pi", state), [(6.0, HELD)], injected=FaultInjection(at=1.5, pump=0.0)
            )
            fault.plot(made.time, made.vacuum / KPA, color=color, lw=1.6)
            label(fault, *place, f"safe state {state}", color)
        fault.axvline(1.5, color=GREY, lw=0.8, ls=(0, (2, 2)))
        late = made.fault_time - 1.5
        label(fault, 1.62, 64, f"the pump dies; {made.outcome}\nis said {late:.2f} s later", INK)
        fault.set(xlim=(0, 6), ylim=(0, 80), xlabel="time [s]", ylabel="vacuum [kPa]")
        title(fault, "A fault ends where you declared", "the pump gives nothing from 1.5 s on")
    return figure


def forces() -> Figure:
    """A force that follows a profile and steps, with what cannot be followed; sines of two sizes.

    The true brake rubs 3 % more than the controller knows, the slip's noise is 0.1 mm.
    """
    loop, brake = regulator("scheduled"), load("choi2018-kapton").brake
    true = replace(brake, scale_factor=brake.scale_factor * 1.03)
    time = np.asarray(np.arange(3200) * loop.sample_time, np.float64)
    slip = 10 * MM + 0.5 * MM * time
    with look():
        figure, (smooth, steps, sine) = canvas(columns=3, width=12.4, height=3.9)
        waves = rehabilitation(time, **PROFILE)
        square = np.where((time / PROFILE["period"]) % 1 < 0.5, PROFILE["high"], PROFILE["low"])
        for axes, wanted in ((smooth, waves), (steps, square)):
            run = follow(loop, brake, wanted, slip, brake=true, slip_noise=0.1 * MM)
            lost = ~run.possible
            axes.fill_between(time, 0, 1, where=lost, color=RED, alpha=0.25, lw=0,
                              transform=axes.get_xaxis_transform())  # fmt: skip
            axes.plot(time, wanted, color=GREEN, lw=2.2, alpha=0.7)
            axes.plot(time, run.force, color=INK, lw=1.0)
            axes.set(xlim=(0, 32), ylim=(0, 140), xlabel="time [s]", ylabel="force [N]")
            label(axes, 0.6, 131, "wanted", GREEN)
            label(axes, 8.0, 131, "given", INK)
            if axes is smooth:
                title(axes, "A profile", f"error {run.rms:.1f} N RMS, of it 3 % the wrong model")
                continue
            swing, low = PROFILE["high"] - PROFILE["low"], PROFILE["low"]
            second = time >= PROFILE["period"]
            up = time[second & (run.force > low + 0.9 * swing)][0] - PROFILE["period"]
            down = time[(time > 8) & (run.force < low + 0.1 * swing)][0] - PROFILE["period"] / 2
            title(axes, "Steps", f"90 % of the way up takes {up:.1f} s, down {down:.1f} s")
        fast = np.geomspace(0.02, 4.0, 12).tolist()
        turn = sine.twinx()
        ends = []
        for swing, color in ((5.0, BLUE), (30.0, ORANGE)):
            made = bode(loop, brake, slip=20 * MM, mean=60.0, amplitude=swing, frequencies=fast)
            sine.plot(made.frequency, made.magnitude, "o-", color=color, ms=3.5, lw=1.3)
            turn.plot(made.frequency, made.phase, color=color, lw=1.0, ls=(0, (3, 2)))
            ends.append((float(made.magnitude[-1]), f"±{swing:g} N", color))
        sine.axhline(2**-0.5, color=GREY, lw=0.8, ls=(0, (2, 2)))
        sine.set(xscale="log", ylim=(0, 1.25), xlim=(0.018, 4.2), xlabel="frequency [Hz]")
        sine.set_ylabel("force over wanted force")
        for level, (_, text, color) in zip((0.2, 0.1), ends, strict=True):
            label(sine, 0.02, level, text, color)
        label(sine, 0.02, 0.645, "71 %", GREY)
        turn.set(ylim=(-270, 45), ylabel="phase, dashed [degrees]")
        turn.grid(visible=False)
        title(sine, "Sines about 60 N", "larger swings are limited by pump and valve")
    return figure


def warned() -> Figure:
    """The plan for one collision: what comes in time, full against tuned."""
    brake = load("choi2018-kapton")
    case = replace(COLLISION, gravity=brake.brake.site.gravity)
    return planned(plan(brake, load_line("choi2018").line, case))


def coupling() -> Figure:
    """When the sleeve's stretching matters: vacuum gained and slip saved over the vacuum at first.

    Line shut off, 1 kg at 2 m/s.
    """
    line, brake = load_line("choi2018").line, load("choi2018-kapton")
    starts = np.array([30e3, 40e3, 50e3, 65e3, 80e3, 94.5e3])
    with look():
        figure, (gain, way) = canvas(columns=2, width=9.6, height=3.7)
        rows = []
        for area, color in ((10e-6, BLUE), (WIDER, RED)):
            chamber = replace(line.chamber, volume_per_slip=area)
            made = [
                coupled_drop(brake, replace(line, chamber=chamber), mass=1.0, speed=2.0, start=p)
                for p in starts.tolist()
            ]
            dots: dict[str, Any] = {"color": color, "ms": 3.5}
            gain.plot(starts / KPA, [m.vacuum_change / KPA for m in made], "o-", **dots)
            way.plot(starts / KPA, [m.timed.slip / MM for m in made], "o-", **dots)
            name = f"{area * 1e6:g} mm²"
            rows.append((made[0].vacuum_change / KPA, name, color))
            label(way, 29, float(made[0].timed.slip) / MM, name, color, ha="right")
        still = [float(m.constant.slip) / MM for m in made]
        way.plot(starts / KPA, still, color=GREY, lw=1.2, ls=(0, (4, 2)))
        label(way, 36, 52, "vacuum held", GREY)
        for level, name, color in rows:
            label(gain, 29, level, name, color, ha="right")
        for axes in (gain, way):
            axes.set(xlim=(18, 100), xlabel="vacuum at first contact [kPa]")
        gain.set(ylabel="vacuum gained in the stop [kPa]")
        way.set(ylabel="slip until the stop [mm]")
        gain.set_ylim(bottom=0)
        way.set_ylim(bottom=0)
        title(gain, "A sleeve that widens thins its gas", "volume gained per slip: two guesses")
        title(way, "It matters at part vacuum", "1 kg at 2 m/s, the line shut off")
    return figure


__all__ = ["coupling", "example_line", "forces", "regulators", "warned"]
