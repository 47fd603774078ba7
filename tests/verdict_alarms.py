"""How often a check fails on healthy cases, and finds a planted fault; into docs/verdicts.md.

Each case is drawn at random and computed here from a closed form or by the virtual laboratory, so
that its truth is known: logs of leaks and pumps, specimens of silicone, pulses, campaigns of pulls,
vacuum lines, collisions and designs. A failed check on a healthy case is a false alarm.

    python tests/verdict_alarms.py [--cases N] [--seed S] [--only NAME...] [--write]
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import jax
import numpy as np

jax.config.update("jax_enable_x64", True)

from laboratory.campaigns.bench import Machine  # noqa: E402
from laboratory.campaigns.bench import pull as virtual_pull  # noqa: E402
from layerjam.bench.control.checks import regulation_checks, step_check  # noqa: E402
from layerjam.bench.control.closed_loop import simulate_run  # noqa: E402
from layerjam.bench.control.plan import Arrival, checks_of_plan, plan_stop, predict_stop  # noqa: E402
from layerjam.bench.control.plant import linearise_line  # noqa: E402
from layerjam.bench.control.settings import Regulator  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.brake.fluid.line import Leak as LineLeak  # noqa: E402
from layerjam.brake.fluid.line import Line, Sensor  # noqa: E402
from layerjam.brake.fluid.line_file import load_line  # noqa: E402
from layerjam.brake.mechanics.tracing import double_precision  # noqa: E402
from layerjam.core.errors import LayerjamError  # noqa: E402
from layerjam.core.verdict import Check  # noqa: E402
from layerjam.laboratory.commands.pull import pull  # noqa: E402
from layerjam.laboratory.identify.calibration.gross import find_gross_pulls  # noqa: E402
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks  # noqa: E402
from layerjam.laboratory.identify.logs.crash import reduce_crash  # noqa: E402
from layerjam.laboratory.identify.logs.leak import fit_leak  # noqa: E402
from layerjam.laboratory.identify.logs.log_checks import check_crash, check_leak, check_pump_downs  # noqa: E402
from layerjam.laboratory.identify.logs.pump_down import fit_pump_down  # noqa: E402
from layerjam.laboratory.identify.rubber import hyperelastic  # noqa: E402
from layerjam.laboratory.identify.rubber.specimen_checks import check_specimens  # noqa: E402
from layerjam.laboratory.identify.validation.metrics import validate_curves  # noqa: E402
from layerjam.laboratory.identify.validation.several import add_pull_table, check_validation  # noqa: E402
from layerjam.workshop.design.verdict import design_checks  # noqa: E402
from pull_faults import FAULTS, curves, drawn  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "verdicts.md"
MARKS = ("<!-- false alarms of checks: begin -->", "<!-- false alarms of checks: end -->")
CASES, SEED = 200, 2018
PLANTED = 8
"""Times as many healthy cases as cases with a planted fault."""
ATMOSPHERE, G = 101325.0, 9.80665
HEALTHY = "healthy"
Random = np.random.Generator


def leaks(random: Random, fault: str) -> Iterator[Check]:
    """A hold at 60 to 95 kPa of vacuum that loses 10 to 80 % of it; temperature within 0.1 K."""
    lost = random.uniform(0.1, 0.8)
    length, step = random.uniform(60, 1200), random.uniform(0.1, 1)
    time = np.arange(0, length, max(step, length / 600))
    start = random.uniform(60e3, 95e3)
    rate = -np.log(1 - lost) / length
    pressure = ATMOSPHERE - start * np.exp(-rate * time)
    if fault == "tight":
        pressure = np.full(len(time), ATMOSPHERE - start)
    if fault == "valve":  # opened in the middle of the log
        late = time > length / 2
        pressure[late] += (ATMOSPHERE - pressure[late]) * 0.6
    warm = 293.15 + np.cumsum(random.normal(0, 0.1 / len(time) ** 0.5, len(time)))
    pressure = pressure * warm / warm[0] + random.normal(0, random.uniform(10, 100), len(time))
    found = fit_leak(time, pressure, temperature=warm)
    yield from check_leak(found, found.fits[found.best], logged=True)


def pump_downs(random: Random, fault: str) -> Iterator[Check]:
    """A pump-down to 2 to 20 kPa over 3 to 8 time constants."""
    rate, ultimate = np.exp(random.uniform(np.log(0.05), np.log(2))), random.uniform(2e3, 20e3)
    time = np.linspace(0, random.uniform(3, 8) / rate, int(random.integers(100, 600)))
    begin = ATMOSPHERE - ultimate
    pressure = ultimate + begin * np.exp(-rate * time)
    if fault == "opened":  # the valve opens while the pump runs
        pressure = np.where(time > 0.5 * time[-1], pressure + 0.5 * begin, pressure)
    if fault == "short":
        time = time / time[-1] / 8 / rate
        pressure = ultimate + begin * np.exp(-rate * time)
    found = fit_pump_down(
        time, pressure + random.normal(0, random.uniform(10, 100), len(time)), window=(0.0, None)
    )
    ends = {"rate": (found.rate, *found.interval(2))}
    ends["ultimate pressure"] = (found.ultimate, *found.interval(1))
    yield from check_pump_downs([found], ends)


def specimens(random: Random, fault: str) -> Iterator[Check]:
    """Three to six specimens of Ecoflex 00-30, 2 to 8 % of scatter (SD), noise of 0.5 %."""
    count, sheet = int(random.integers(3, 7)), 68.95e3
    factor = random.uniform(0.75, 1.3)
    scatter = random.uniform(0.02, 0.08)
    strain = np.linspace(0.01, 3.0, 300)
    rows, wrong = {}, int(random.integers(count))
    for number in range(count):
        one = factor * np.exp(scatter * random.standard_normal())
        c1, c2 = one * sheet / 69e3 * 14e3, one * sheet / 69e3 * 8e3
        made = hyperelastic.stress("mooney-rivlin", {"C1": c1, "C2": c2}, strain)
        if fault == "newtons" and number == wrong:  # N read as lbf
            made = made * 4.4482216
        if fault == "area":  # the diameter's millimetres squared, 3.3 times the area
            made = made / 3.3
        made = made + 0.005 * made.max() * random.standard_normal(len(made))
        at = float(np.interp(1.0, strain, made))
        slope = float(np.polyfit(strain[4:20], made[4:20], 1)[0])
        row = {"modulus_100": at, "initial_modulus": slope, "material": "ecoflex-00-30"}
        rows[f"{number}.csv"] = {**row, "difference": at / sheet - 1}
    fits = hyperelastic.fit_models(strain, made)
    error = fits[hyperelastic.choose_model(fits)[0]].error_at_100
    yield from check_specimens(rows, {"error_at_100": error}, True)


def pulses(random: Random, fault: str) -> Iterator[Check]:
    """Half sines of 10 to 150 g and 4 to 40 ms, noise of 0.1 to 1 %."""
    rate, length = random.uniform(5e3, 50e3), random.uniform(4e-3, 40e-3)
    time = np.arange(0, 0.05 + length + 0.1, 1 / rate)
    height = random.uniform(10, 150) * G
    inside = (time >= 0.05) & (time <= 0.05 + length)
    signal = np.where(inside, height * np.sin(np.pi * (time - 0.05) / length), 0.0)
    signal = signal + height * random.uniform(1e-3, 1e-2) * random.standard_normal(len(time))
    if fault == "clipped":
        signal = np.minimum(signal, random.uniform(0.4, 0.8) * height)
    if fault == "cut":
        signal, time = signal[time < 0.05 + 0.6 * length], time[time < 0.05 + 0.6 * length]
    yield from check_crash(reduce_crash(time, signal, cfc=180))


def single_pulls(random: Random, fault: str) -> Iterator[Check]:
    """A pull of the virtual laboratory at 20 to 95 kPa; after a free slide with the fault."""
    machine = Machine(
        load_cell_noise=10 ** random.uniform(-2, 0),
        sampling_rate=float(random.choice([100, 500])),
        seed=int(random.integers(1, 10**6)),
    )
    brake = load(str(random.choice(["choi2018-kapton", "choi2018-ptfe"]))).brake
    trace = virtual_pull(
        brake, random.uniform(20e3, 95e3), random.uniform(2e-3, 15e-3), 0.03, machine
    )
    if fault == "slide":  # the rest of the pull starts from the force of the slide
        free = random.uniform(0.1, 0.6) * float(trace.force.max())
        length = random.uniform(0.3, 1.5) * float(trace.travel[np.argmax(trace.force)])
        start = int(np.argmax(trace.force > free))
        count = max(start, int(length * len(trace) / 0.03), 40)
        slide = free + machine.load_cell_noise * random.normal(size=count)
        force = np.concatenate([trace.force[:start], slide, trace.force[start:]])
        step = float(np.median(np.diff(trace.elongation)))
        trace = replace(trace, force=force, elongation=step * np.arange(len(force)), time=None)
    for row in pull(trace).checks:
        yield Check(name=row["name"], level=row["level"], sentence=row["sentence"])


def campaigns(random: Random, fault: str) -> Iterator[Check]:
    """Twelve pulls of the virtual laboratory, calibrated on (default method) and validated on.

    A pull that is left out by `calibrate` counts as a failed check named `excluded`.
    """
    made = drawn(FAULTS[0], [int(random.integers(1 << 31))])
    pulls = list(curves(made))
    if fault == "unit":
        force = float(random.choice([1e-3, 1 / 4.4482216, 4.4482216, 1000 / 9.80665, 9.80665]))
        pulls[5] = scaled(pulls[5], force)
    brake, true = made.subjects[0].known, made.subjects[0].true
    gross = find_gross_pulls([(one, one.vacuum) for one in pulls], brake)
    left_out = Check(name="excluded", level="failed" if gross else "passed", sentence="")
    kept = [one for place, one in enumerate(pulls) if place not in gross]
    yield left_out
    yield from calibrate_peaks(kept, brake).checks
    found = add_pull_table(validate_curves(pulls, true), pulls, true)
    named = ("pulls", "model")
    yield from (
        replace(c, name=f"validate: {c.name}")
        for c in check_validation(found, 0)
        if c.name in named
    )


def scaled(one: Any, force: float) -> Any:
    """A pull whose forces are multiplied by a factor."""
    pull = one
    fields = {
        name: getattr(pull, name) * force
        for name in ("force", "peak_force", "stiffness", "noise", "preload")
        if getattr(pull, name, None) is not None
    }
    return replace(one, force=one.force * force, pull=replace(pull, **fields))


def lines(random: Random, fault: str) -> Iterator[Check]:
    """The paper's line, its volume 0.3 to 10 times, leaks or none, a sensor with 25 Pa of steps."""
    base = load_line("choi2018").line
    volume = base.chamber.volume * np.exp(random.uniform(np.log(0.3), np.log(10)))
    kind = str(random.choice(["pi", "scheduled", "bang-bang"]))
    leak = float(random.choice([0.0, 1e-8, 1e-7]))
    sample, run = 0.01, 0.0
    if fault == "slow":  # a sample moves the vacuum by more than twice the band
        kind, volume, leak = "bang-bang", 0.1 * base.chamber.volume, 1e-7
    if fault == "run":
        kind, leak, run = "bang-bang", 1e-7, 0.5
    line: Line = replace(
        base, chamber=replace(base.chamber, volume=volume), leak=LineLeak(laminar=leak)
    )
    target = float(random.uniform(10e3, 70e3))
    regulator = Regulator(
        plant=linearise_line(line, vacuum=target),
        sensor=Sensor(range=103e3, noise=float(random.uniform(0, 50)), resolution=25.0),
        kind=kind,
        safe_state="release",
        reversible=line.valve is None,
        tuned_at=target,
        sample_time=sample,
        minimum_on=run,
        minimum_off=run,
    )
    length = 12 * regulator.plant.time_constant(target)
    loop = simulate_run(regulator, [(length, target)], seed=int(random.integers(1000)))
    yield from regulation_checks(regulator, target, loop)
    yield replace(step_check(regulator, target), name="bench run: ripple")


def collisions(random: Random, fault: str) -> Iterator[Check]:
    """Collisions with the paper's line and brake; healthy: no jump of the slip near the vacuum."""
    file, line = load("choi2018-kapton"), load_line("choi2018").line
    while True:
        case = Arrival(
            mass=float(random.uniform(0.2, 8)),
            speed=float(random.uniform(0.2, 3)),
            warning=float(random.uniform(0.02, 3)),
            travel=float(random.uniform(0.01, 0.06)),
            gravity=G * float(random.integers(2)),
        )
        made = plan_stop(file, line, case)
        if made.needed is None:
            continue
        # 0.01 % less vacuum and the mass runs more than half of the rest of the way: a jump
        below = predict_stop(file, case, 0.9999 * made.needed)
        jumps = not below.stops_within(
            case.travel + 0.5 * (file.brake.sheets.usable_travel - case.travel)
        )
        if jumps == (fault == "edge"):
            break
    yield from checks_of_plan(made, 0.0)


def designs(random: Random, fault: str) -> Iterator[Check]:
    """Brakes whose sheets bear at most 0.7 of the film's strength, or 1.1 times of it and more.

    The stress is that of the friction alone, a (n - 1) mu P W L2 over n/2 sections (paper, eq. 4).
    """
    file = load("choi2018-kapton")
    base = file.brake
    while True:
        count = 2 * int(random.integers(2, 26))
        sheets = replace(
            base.sheets,
            count=count,
            width=float(random.uniform(0.02, 0.06)),
            thickness=float(np.exp(random.uniform(np.log(12e-6), np.log(125e-6)))),
        )
        vacuum, strength = random.uniform(20e3, 95e3), random.uniform(20e6, 200e6)
        friction = base.scale_factor * base.film.kinetic * (count - 1) * vacuum
        friction *= sheets.width * sheets.overlap
        load_share = friction / (count / 2 * sheets.width * sheets.thickness) / strength
        if load_share >= 1.1 if fault == "torn" else load_share <= 0.7:
            break
    brake = replace(base, sheets=sheets, film=replace(base.film, strength=float(strength)))
    yield from design_checks(replace(file, brake=brake), float(vacuum))


@dataclass(frozen=True)
class Study:
    """Cases of one command: how a case is drawn, and what may be wrong in it."""

    name: str
    draw: Callable[[Random, str], Iterator[Check]]
    faults: dict[str, str] = field(default_factory=dict)


STUDIES = (
    Study("leak", leaks, {"tight": "no leak", "valve": "a valve opens in the log"}),
    Study(
        "pump-down",
        pump_downs,
        {"opened": "a valve opens in the log", "short": "an eighth of a time constant"},
    ),
    Study(
        "enclosure",
        specimens,
        {"newtons": "N read as lbf in one", "area": "area 3.3 times too large in all"},
    ),
    Study(
        "crash",
        pulses,
        {"clipped": "the sensor saturates", "cut": "the log ends in the pulse"},
    ),
    Study("pull", single_pulls, {"slide": "a free slide before the pull"}),
    Study("calibrate, validate", campaigns, {"unit": "one pull in another unit of force"}),
    Study(
        "regulate, bench run",
        lines,
        {"slow": "one sample moves more than the band", "run": "a least run of 0.5 s"},
    ),
    Study("plan", collisions, {"edge": "the slip jumps below the vacuum needed"}),
    Study("design, sweep", designs, {"torn": "sheets loaded beyond the film's strength"}),
)


def measure(study: Study, fault: str, cases: int, seed: int) -> tuple[int, Counter[str], set[str]]:
    """(cases in which a check failed or the file was refused, by check, all checks seen)."""
    number, by_check, names = 0, Counter[str](), set[str]()
    for case in range(cases):
        random = np.random.Generator(np.random.PCG64([seed, case, len(fault)]))
        try:
            checks: Iterable[Check] = list(study.draw(random, "" if fault == HEALTHY else fault))
        except LayerjamError:
            number += 1
            by_check["refused"] += 1
            continue
        names |= {check.name for check in checks}
        failed = {check.name for check in checks if check.level == "failed"}
        by_check.update(failed)
        number += bool(failed)
    return number, by_check, names


def rows(study: Study, cases: int, seed: int) -> Iterator[str]:
    """The table's rows of one command."""
    for fault in (HEALTHY, *study.faults):
        some = cases if fault == HEALTHY else -(-cases // PLANTED)
        number, by_check, names = measure(study, fault, some, seed)
        told = ", ".join(f"{name} {count / some:.1%}" for name, count in by_check.most_common())
        if fault == HEALTHY:
            quiet = sorted(names - set(by_check))
            told += "; " * bool(told and quiet) + (f"never: {', '.join(quiet)}" if quiet else "")
        words = "**healthy**" if fault == HEALTHY else study.faults[fault]
        name = f"`{study.name.replace(', ', '`, `')}`"
        yield f"| {name} | {words} | {some} | {number / some:.1%} | {told} |"


def write(table: Iterable[str], cases: int, seed: int) -> None:
    """Write the section into docs/verdicts.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(MARKS[0])
    made = f"""{MARKS[0]}

`python tests/verdict_alarms.py --cases {cases} --seed {seed} --write` writes this table:

| command | cases | number | a check failed | which |
|---|---|---|---|---|
{chr(10).join(table)}

In rows marked **healthy**, a failed check is a false alarm. *refused* means that the command
rejected the file with an error.

{MARKS[1]}"""
    PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=CASES, help="of each row")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", nargs="*", default=[], help="names of commands")
    parser.add_argument("--write", action="store_true", help="write docs/verdicts.md")
    given = parser.parse_args()
    table: list[str] = []
    with double_precision():
        for study in STUDIES:
            if given.only and not any(name in study.name for name in given.only):
                continue
            for row in rows(study, given.cases, given.seed):
                table.append(row)
                print(row, flush=True)
    if given.write:
        write(table, given.cases, given.seed)


if __name__ == "__main__":
    main()
