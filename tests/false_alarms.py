"""False alarms in healthy hours and the time to each fault, into docs/coverage.md.

Noise is drawn again for each hour (`bench.control.noise`), the line is the paper's with a leak, a
vent and a sensor of ours; a third of the hours has the line as told, a third a pump 20 % weaker
with a fifth of the leak, a third one 20 % stronger without leak. Faults of a full pump begin at
96 moments of a rise for each room below the pump's vacuum, so that they meet every phase of what
the detector counts.

    python tests/false_alarms.py [--hours N] [--seed S] [--write]
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import time
from pathlib import Path

import numpy as np

from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.faults import FaultInjection as Fault
from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.settings import FAULTS, KINDS, Regulator
from layerjam.brake.fluid.line import Chamber, Line, Pump, Sensor, Tube, Valve

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- false alarms: begin -->", "<!-- false alarms: end -->")
AIR = Plant(rate=3.33 / 7.503, top=101325.0, leak=0.002, vent=5.0)
SENSOR = Sensor(range=103e3, lag=0.005, noise=50.0, resolution=25.0)
HOUR = [(60.0, 80e3), (30.0, 40e3), (30.0, 0.0), (60.0, 92e3), (20.0, 10e3), (10.0, 0.0)]
TRUE = ((1.0, 1.0), (0.8, 0.2), (1.2, 0.0))
EXACT = Sensor(range=103e3)
TARGET = 80e3
RISE = [(20.0, TARGET)]
DOWN = [(10.0, TARGET), (5.0, 0.0)]
BREAKS: dict[str, tuple[str, Fault, list[tuple[float, float]], float, float]] = {
    "sensor gives NaN": ("NOT_A_NUMBER", Fault(sensor="nan"), RISE, 0.0, 19.0),
    "sensor at its rail": (
        "SENSOR_OUT_OF_RANGE", Fault(sensor="rail", value=-2e4), RISE, 0.0, 19.0),
    "sensor stuck": ("SENSOR_STUCK", Fault(sensor="stuck"), RISE, 5.0, 18.0),
    "sensor 3 kPa off": ("SENSOR_OFFSET", Fault(sensor="offset", value=3e3), DOWN, 11.2, 14.0),
    "pump dead while holding": ("VACUUM_LOST", Fault(pump=0.0), [(80.0, TARGET)], 8.0, 30.0),
    "leak beyond the pump": ("VACUUM_LOST", Fault(leak=20.0), RISE, 8.0, 15.0),
}  # fmt: skip


TUBE = Line(
    chamber=Chamber(volume=7.503e-6), pump=Pump(flow=3.33e-6), tube=Tube(length=5.0, bore=0.8e-3),
    valve=Valve(conductance=4e-10),
)  # fmt: skip
LINES = {
    "air": AIR,
    "water": linearise_line(
        dataclasses.replace(TUBE, chamber=Chamber(volume=7.503e-6, compliance=6.607e-11)),
        vacuum=94.5e3,
        water=True,
    ),
    "air, 5 m tube of 0.8 mm": linearise_line(TUBE, vacuum=94.5e3),
}
FULL = {
    "pump dead": ("NO_VACUUM", Fault(pump=0.0)),
    "pump at a quarter": ("WEAK_PUMP", Fault(pump=0.25)),
    "an eighth of the volume left": ("LINE_BLOCKED", Fault(volume=1 / 8)),
}
ROOMS = (40.0, 10.0, 4.0, 3.0, 2.0)
"""Decision steps below the pump's vacuum."""
PHASES, NOISES = 96, 20
TO_GO = 4.0
"""Decision steps left to the target behind a tube, so that the pump runs on: what the emptied tube
still draws brings the vacuum to a target that is near, and a pump that rests is not judged."""


def regulator(kind: str, plant: Plant = AIR) -> Regulator:
    """A loop the page is about."""
    return Regulator(plant=plant, sensor=SENSOR, kind=kind, safe_state="release")


def healthy(kind: str, hours: int, seed: int) -> tuple[str, float]:
    """A row of the first table, and how long it took [s]."""
    begun, alarms, names, switches = time.perf_counter(), 0, set(), 0.0
    for part, (flow, leak) in enumerate(TRUE):
        count = hours // 3 + (part < hours % 3)
        true = dataclasses.replace(AIR, rate=AIR.rate * flow, leak=AIR.leak * leak)
        made = simulate_runs(
            regulator(kind), HOUR, runs=count, duration=3600.0, plant=true, seed=seed + part
        )
        alarms += int((made.fault != 0).sum())
        names |= {FAULTS[int(f)] for f in np.unique(made.fault) if f}
        switches += float(made.pump_switches.sum())
    took = time.perf_counter() - begun
    # Poisson: 3.0 is the 95 % bound on the mean of a count of none
    bound = f"{3.0 / hours:.0e}" if not alarms else f"{(alarms + 2 * alarms**0.5 + 3) / hours:.0e}"
    found = f"{alarms}" + (f" ({', '.join(sorted(names))})" if names else "")
    return f"| {kind} | {hours:,} | {found} | {bound} | {switches / hours:,.0f} |", took


def detected(what: str, seed: int) -> str:
    """A row of the second table: 40 moments, 25 runs each, every kind of controller."""
    name, injected, targets, first, last = BREAKS[what]
    worst, missed, said = 0.0, 0, set()
    for kind in KINDS:
        loop = regulator(kind)
        for n, at in enumerate(np.linspace(first, last, 40)):
            broken = dataclasses.replace(injected, at=float(at))
            made = simulate_runs(loop, targets, runs=25, injected=broken, seed=seed + n)
            late = made.fault_time - at
            worst = max(worst, float(np.nanmax(late)))
            missed += int((made.fault == 0).sum())
            said |= {FAULTS[int(f)] for f in np.unique(made.fault) if f}
    stated = detection_times(regulator("pi"), TARGET)[name]
    if name == "VACUUM_LOST":  # counted from leaving the band: add the time until then
        band = regulator("pi").loss_margin
        stated += band / ((AIR.leak + injected.leak) * (TARGET - band))
    return f"| {what} | {', '.join(sorted(said))} | {stated:.2f} | {worst:.2f} | {missed} |"


def in_every_phase(what: str, name: str, room: float, seed: int) -> str:
    """A row of the third table: 96 moments within a decision step before a room is left."""
    plant, (fault, injected) = LINES[name], FULL[what]
    loop = regulator("bang-bang", plant)
    tube = plant.passage
    deepest = plant.top - room * loop.detection_threshold
    if deepest < loop.detection_threshold:
        return ""
    if tube is not None and deepest > tube.vacuum - TO_GO * loop.detection_threshold:
        return ""
    stated = detection_times(loop, deepest)[fault]
    where = f"| {what} | {name} | {room:g}, {deepest / 1e3:.1f} "
    if np.isinf(stated):
        return f"{where}| not promised | | |"
    # the deepest target that it takes: the pump runs full until the fault is said, or is not
    highest = plant.reach - loop.half_band - 10.0
    if tube is not None:
        highest = min(highest, tube.vacuum)
    course = [(60.0, highest)]
    sound = simulate_run(dataclasses.replace(loop, sensor=EXACT), course)
    rises = slice(0, int(sound.vacuum.argmax()))
    worst, missed = 0.0, 0
    for phase in range(PHASES):
        begins = deepest - phase / PHASES * loop.detection_threshold
        at = float(np.interp(begins, sound.vacuum[rises], sound.time[rises])) - loop.sample_time
        made = simulate_runs(
            loop, course, runs=NOISES, duration=at + stated + 1.0,
            injected=dataclasses.replace(injected, at=at), seed=seed + phase,
        )  # fmt: skip
        worst = max(worst, float(np.nanmax(made.fault_time - at, initial=0.0)))
        missed += int((made.fault == 0).sum())
    return f"{where}| {stated:.2f} | {worst:.2f} | {missed} |"


def main() -> None:
    """Print the tables; with --write put them into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--hours", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=2018)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    lines = [
        f"Healthy hours at 100 Hz, seed {given.seed} (`python tests/false_alarms.py --hours "
        f"{given.hours} --write`):",
        "",
        "| controller | hours | false alarms | rate at most, 95 % [1/h] | pump switches an hour |",
        "|---|---|---|---|---|",
    ]
    for kind in KINDS:
        row, took = healthy(kind, given.hours, given.seed)
        print(f"{row}  {took:.1f} s, {took / given.hours / 3.6e5 * 1e9:.1f} ns a step", flush=True)
        lines.append(row)
    lines += [
        "",
        "Faults of a thousand runs for each kind of controller:",
        "",
        "| what breaks | what it is called | stated [s] | worst seen [s] | missed |",
        "|---|---|---|---|---|",
    ]
    for what in BREAKS:
        lines.append(detected(what, given.seed))
        print(lines[-1], flush=True)
    lines += [
        "",
        f"Faults of a pump that runs full (bang-bang), {PHASES} moments within a decision step "
        f"before that room below the pump's vacuum is left, {NOISES} runs each:",
        "",
        "| what breaks | line | room [steps], from [kPa] | stated [s] | worst seen [s] | missed |",
        "|---|---|---|---|---|---|",
    ]
    for what, name, room in itertools.product(FULL, LINES, ROOMS):
        row = in_every_phase(what, name, room, given.seed)
        if row:
            lines.append(row)
            print(row, flush=True)
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        page = "\n".join([MARKS[0], "", *lines, "", MARKS[1]])
        PAGE.write_text(before + page + after, encoding="utf-8")


if __name__ == "__main__":
    main()
