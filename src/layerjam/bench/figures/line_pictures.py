"""Pictures of the paper's line under control: controllers, a fault, forces, a plan, coupling.

The paper has no controller. Sensor, leak and volume per unit slip are example values of our own, as
the captions state.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from layerjam.bench.control.closed_loop import simulate_run
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.follow import bode_response, follow, rehabilitation
from layerjam.bench.control.plan import Arrival, plan_stop
from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.settings import KINDS, Regulator
from layerjam.bench.figures.control_figures import (
    describe_outcome,
    draw_frequency_response,
    draw_plan,
    draw_profile,
)
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line import Leak, Line, Sensor, Valve
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.simulate.coupled import coupled_drop
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, KPA, MM, ORANGE, RED

SENSOR = Sensor(range=103e3, lag=0.005, noise=50.0, resolution=25.0)
PLANT = Plant(rate=0.4438, top=101325.0, leak=0.002, vent=5.0)
"""Line of the examples in docs/control.md."""
HELD = 80e3
"""Target of the controllers [Pa]."""
LOW, HIGH, PERIOD = 20.0, 100.0, 16.0
"""Lowest and highest force, and period, of the force profile [N, N, s]."""
STARTS = (30e3, 40e3, 50e3, 65e3, 80e3, 94.5e3)
"""Vacuums at first contact of the coupled stops [Pa]."""
WIDER = 40e-6
"""Volume per unit slip [m^2] of the coupled stops, assumed because no source gives one."""
COLLISION = Arrival(mass=1.0, speed=2.5, warning=3.0, travel=40e-3, mass_sd=0.1, speed_sd=0.2)


def make_example_line() -> Line:
    """Return the paper's line with a leak (time constant 500 s) and a small valve, both assumed."""
    line = load_line("choi2018").line
    leak = Leak(laminar=line.chamber.volume * 0.002)
    return replace(line, leak=leak, valve=Valve(conductance=3.5e-10))


def make_regulator(kind: str, safe_state: str = "release") -> Regulator:
    """Return one of the three controllers on the example line."""
    plant = linearise_line(make_example_line(), vacuum=HELD)
    return Regulator(plant=plant, sensor=SENSOR, kind=kind, safe_state=safe_state, tuned_at=HELD)


@style.use_style
def draw_regulators() -> style.Figure:
    """Draw the runs of docs/control.md: three controllers, and a pump that fails at 1 s."""
    figure, (zoom, fault) = style.make_axes(columns=2, width=9.6, height=3.9)
    loop = Regulator(plant=PLANT, sensor=SENSOR, kind="scheduled", safe_state="release")
    for kind, color in zip(KINDS, (BLUE, ORANGE, INK), strict=True):
        run = simulate_run(replace(loop, kind=kind), [(20.0, HELD)])
        words = f"{kind}: the pump switches {run.pump_switches} times"
        zoom.plot(run.time, run.vacuum * KPA, color=color, lw=1.3, label=words)
    zoom.axhline(HELD * KPA, color=GREEN, lw=1.0, ls=style.DASHED, label="target")
    zoom.set(xlim=(2, 20), ylim=(78.8, 81.6), xlabel="time [s]", ylabel="vacuum [kPa]")
    style.add_key(zoom, loc="upper right")
    style.add_title(zoom, "Three controllers hold 80 kPa", "simulated; true vacuum over 20 s")
    ends = []
    fault.set(xlim=(0, 4), ylim=(0, 80), xlabel="time [s]", ylabel="vacuum [kPa]")
    for state, color in (("release", RED), ("hold", BLUE)):
        dead = FaultInjection(at=1.0, pump=0.0)
        run = simulate_run(replace(loop, safe_state=state), [(20.0, HELD)], injected=dead)
        fault.plot(run.time, run.vacuum * KPA, color=color, lw=1.6)
        visible_vacuum = run.vacuum[run.time <= 4.0]
        ends.append((float(visible_vacuum[-1]) * KPA, state, color))
    words = f"the pump fails; the controller\n{describe_outcome(run.outcome)}"
    style.mark_x(fault, 1.0, f"{words} at {run.fault_time:.2f} s", INK)
    style.add_end_labels(fault, 4.0, ends)
    detail = "simulated; the pump delivers nothing from 1 s on"
    style.add_title(fault, "Your safe state follows a fault", detail)
    return figure


@style.use_style
def draw_forces() -> style.Figure:
    """Draw forces that follow a profile, steps and sines, and mark where they cannot follow.

    The sines have two amplitudes. The true brake has 3 % more friction than the controller assumes,
    and the noise of the slip is 0.1 mm.
    """
    loop, brake = make_regulator("scheduled"), load("choi2018-kapton").brake
    true = replace(brake, scale_factor=brake.scale_factor * 1.03)
    time = np.asarray(np.arange(3200) * loop.sample_time, np.float64)
    slip = 10 / MM + 0.5 / MM * time
    waves = rehabilitation(time, low=LOW, high=HIGH, period=PERIOD)
    square = np.where((time / PERIOD) % 1 < 0.5, HIGH, LOW)
    figure, (smooth, steps, gain, phase) = style.make_axes(columns=2, rows=2, width=9.6, height=7.2)
    runs = [follow(loop, brake, f, slip, brake=true, slip_noise=0.1 / MM) for f in (waves, square)]
    for axes, run in zip((smooth, steps), runs, strict=True):
        draw_profile(axes, run, 150)
    error = f"RMS error {runs[0].rms:.1f} N, including 3 % model error"
    style.add_title(smooth, "The force follows a profile", error)
    force, swing = runs[1].force, HIGH - LOW
    up = time[(time >= PERIOD) & (force > LOW + 0.9 * swing)][0] - PERIOD
    down = time[(time > 8) & (force < LOW + 0.1 * swing)][0] - PERIOD / 2
    detail = f"90 % rise takes {up:.1f} s, 90 % fall {down:.1f} s"
    style.add_title(steps, "Steps upwards wait for the pump", detail)
    fast = np.geomspace(0.02, 4.0, 12).tolist()
    sweeps = []
    for size, color in ((5.0, BLUE), (30.0, ORANGE)):
        sweep = bode_response(
            loop, brake, slip=20 / MM, mean=60.0, amplitude=size, frequencies=fast
        )
        sweeps.append((sweep, color, f"±{size:g} N"))
    draw_frequency_response(gain, phase, sweeps, turn=(-135, 45))
    style.set_log_scale(phase)
    phase.set_xlabel("frequency [Hz]")
    style.add_title(gain, "Small sine waves pass, large ones do not", "amplitude; mean 60 N")
    style.add_title(phase, "Large sine waves also lag", "phase; mean 60 N")
    return figure


def draw_warned_plan() -> style.Figure:
    """Draw the plan for one collision: vacuum versus time, and full compared with tuned vacuum."""
    brake = load("choi2018-kapton")
    case = replace(COLLISION, gravity=brake.brake.site.gravity)
    return draw_plan(plan_stop(brake, load_line("choi2018").line, case))


@style.use_style
def draw_coupling(starts: Sequence[float] = STARTS) -> style.Figure:
    """Draw the effect of the stretching enclosure: vacuum gained and slip saved.

    Both are drawn versus the initial vacuum, for 1 kg at 2 m/s and a line that is shut off.
    """
    line, brake = load_line("choi2018").line, load("choi2018-kapton")
    start_kpa = np.array(starts) * KPA
    figure, (gain, slip) = style.make_axes(columns=2, width=9.6, height=3.7)
    for area, color in ((10e-6, BLUE), (WIDER, RED)):
        shut = replace(line, chamber=replace(line.chamber, volume_per_slip=area))
        runs = [coupled_drop(brake, shut, mass=1.0, speed=2.0, start=p) for p in starts]
        name = f"{area * 1e6:g} mm² volume per unit slip"
        gains, slips = ([m.vacuum_change for m in runs], [m.timed.slip for m in runs])
        gain.plot(start_kpa, np.array(gains) * KPA, "o-", color=color, ms=3.5, label=name)
        slip.plot(start_kpa, np.array(slips) * MM, "o-", color=color, ms=3.5, label=name)
    still = np.array([float(m.constant.slip) for m in runs]) * MM
    slip.plot(start_kpa, still, color=GREY, lw=1.2, ls=style.DASHED, label="constant vacuum")
    for axes, label in (
        (gain, "vacuum gained during the stop [kPa]"),
        (slip, "slip until the stop [mm]"),
    ):
        axes.set(xlim=(18, 100), xlabel="vacuum at first contact [kPa]", ylabel=label)
        axes.set_ylim(bottom=0)
        style.add_key(axes)
    detail = "volume gained per unit slip: two assumed values"
    style.add_title(gain, "A widening enclosure expands its gas", detail)
    style.add_title(
        slip, "The effect matters at partial vacuum", "1 kg at 2 m/s, the line shut off"
    )
    return figure
