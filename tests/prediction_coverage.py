"""How often predictions of a calibrated brake hold; part of `make coverage`.

Devices, pulls and stops are drawn by tests/independent/devices.py, which shares no code with
layerjam. Each campaign calibrates one device and predicts pulls and stops that the calibration
never saw. The table goes to docs/coverage.md.

    python tests/prediction_coverage.py [--campaigns N] [--seed S] [--only WORD] [--write]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import jax
import numpy as np

jax.config.update("jax_enable_x64", True)

from independent.devices import (  # noqa: E402
    GRAVITY,
    SPEED,
    USABLE,
    Device,
    Pull,
    draw_device,
)
from layerjam.brake.device.brake_file import BrakeFile  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.brake.mechanics.pull import peak  # noqa: E402
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, stop  # noqa: E402
from layerjam.brake.mechanics.stop.motion import rope_spring  # noqa: E402
from layerjam.brake.simulate.prediction import Prediction  # noqa: E402
from layerjam.brake.simulate.safe_vacuum import DECISION_SAMPLES, find_safe_vacuum  # noqa: E402
from layerjam.brake.simulate.tuned import Case as Stopping  # noqa: E402
from layerjam.brake.simulate.tuned import tuning_vacuum  # noqa: E402
from layerjam.core.evolve import evolve  # noqa: E402
from layerjam.laboratory.identify.calibration.evidence import (  # noqa: E402
    make_calibration_evidence,
)
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks  # noqa: E402
from layerjam.laboratory.identify.curves import Curve  # noqa: E402
from layerjam.laboratory.identify.pull.features import PullFeatures  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- predictions: begin -->", "<!-- predictions: end -->")
CAMPAIGNS, SEED, FURTHER, LEVELS = 300, 2018, 20, 4
AIM, SAFE_AIM = (0.92, 0.98), (0.93, 0.97)
ONE, THREE, FAR = (60e3,), (40e3, 60e3, 90e3), (10e3, 95e3)
FAR_MARK = ", far"
TRAVEL, PULLED = 0.04, 0.04
READING = 1e-3
"""Relative error of a peak and of a slope that are read from a curve."""
ELONGATION = np.linspace(0.0, PULLED, 120)
Random = np.random.Generator


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row of the table."""

    pulls: int
    vacuums: tuple[float, ...]
    mountings: int
    stated: bool = True
    scatter: float | None = None
    """Relative scatter (SD) between mountings; None for a random one of each device."""
    far: bool = False
    """Whether pulls are predicted at `FAR`, for brakes with an exponent from -0.1 to 0."""

    @property
    def name(self) -> str:
        """Name of the row."""
        vacuums = "one vacuum" if len(self.vacuums) == 1 else "three vacuums"
        mountings = "one mounting" if self.mountings == 1 else "three mountings"
        unstated = "" if self.stated else ", not stated"
        scatter = "" if self.scatter is None else f", scatter of {self.scatter:.0%}"
        far = FAR_MARK if self.far else ""
        return f"{self.pulls} pulls, {vacuums}, {mountings}{unstated}{scatter}{far}"


CASES = tuple(
    Case(pulls=pulls, vacuums=vacuums, mountings=mountings)
    for vacuums in (ONE, THREE)
    for mountings in (1, 3)
    for pulls in (3, 6, 12)
)
UNSTATED = tuple(
    Case(pulls=pulls, vacuums=ONE, mountings=mountings, stated=False)
    for mountings in (1, 3)
    for pulls in (3, 12)
)
OTHERS = tuple(
    Case(pulls=12, vacuums=ONE, mountings=mountings, scatter=scatter)
    for mountings in (1, 3)
    for scatter in (0.03, 0.08)
)
FAR_CASES = tuple(
    Case(pulls=pulls, vacuums=vacuums, mountings=mountings, far=True)
    for vacuums in (ONE, THREE)
    for mountings in (1, 3)
    for pulls in (3, 12)
)


@dataclass
class Tally:
    """Shares of each campaign that lie in their intervals, by what was predicted."""

    shares: dict[str, list[float]] = field(default_factory=dict)
    widths: list[float] = field(default_factory=list)
    unsafe: int = 0
    """Campaigns in which no vacuum is safe."""

    def add(self, name: str, inside: np.ndarray) -> None:
        """Add the predictions of one campaign."""
        self.shares.setdefault(name, []).append(float(np.mean(inside)))

    def share(self, name: str) -> float:
        """Share over all campaigns."""
        return float(np.mean(self.shares[name]))

    def error(self, name: str) -> float:
        """Half of the 95 % interval of that share, from its scatter between campaigns."""
        shares = self.shares[name]
        return 1.96 * float(np.std(shares, ddof=1)) / len(shares) ** 0.5


def make_curves(case: Case, device: Device, random: Random) -> tuple[Curve, ...]:
    """The pulls of a calibration as `calibrate` reads them."""
    place = np.arange(case.pulls)
    # each vacuum meets each mounting, as far as there are enough pulls
    number = (place + place // 3 * (len(case.vacuums) > 1)) % case.mountings
    mounted = device.mount(random, case.mountings)[number]
    pulls = device.pull(random, mounted, np.resize(case.vacuums, case.pulls))
    read = 1 + READING * random.standard_normal((2, case.pulls))
    heights, slopes = pulls.peak() * read[0], pulls.stiffness * read[1]
    forces = pulls.curve(ELONGATION) * read[0][:, None]
    return tuple(
        Curve(
            **vars(_read_features(float(heights[i]), float(slopes[i]), force, f"pull-{i + 1}.csv")),
            vacuum=float(pulls.vacuum[i]),
            speed=SPEED,
            repeat=i + 1,
            mounting=int(number[i]) + 1 if case.stated else None,
        )
        for i, force in enumerate(forces)
    )


def _read_features(height: float, slope: float, force: np.ndarray, path: str) -> PullFeatures:
    top = int(np.argmax(force))
    return PullFeatures(
        stiffness=slope,
        stiffness_se=READING * slope,
        peak_force=height,
        peak_force_se=READING * height,
        peak_elongation=float(ELONGATION[top]),
        peak_sample=height,
        peak_misfit=0.0,
        has_peak=True,
        peak_samples=100,
        straight=True,
        rise_samples=50,
        noise=READING * height,
        origin=0.0,
        seating=None,
        seating_se=0.0,
        elongation=ELONGATION,
        force=force,
        path=path,
        baseline=0.0,
    )


def calibrate(curves: tuple[Curve, ...], file: BrakeFile) -> BrakeFile:
    """The file as `calibrate` writes it, without its text."""
    found = calibrate_peaks(curves, file.brake)
    evidence = make_calibration_evidence(file, found, found.sources, "2026-11-28")
    values = {path: value for path, (value, _) in found.sources.items()}
    sources = {**file.sources, **{path: source for path, (_, source) in found.sources.items()}}
    brake = evolve(file.brake, **values)
    return evolve(file, brake=brake, sources=sources, evidence=(evidence,))


def predict_peaks(file: BrakeFile, vacuum: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Interval of the peak force [N] of a further pull at each vacuum."""
    prediction = Prediction(file, vacuum, None, SPEED)
    interval = prediction.interval(peak(vacuum, USABLE, prediction.brakes).force)
    return interval["low"], interval["high"]


def predict_stops(
    file: BrakeFile, vacuum: np.ndarray, mass: float, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Interval of the slip [m] of a further stop at each vacuum."""
    prediction = Prediction(file, vacuum, None, speed)
    brakes = prediction.brakes
    ones = np.ones((prediction.samples, len(vacuum)))
    spring = rope_spring(None, brakes) * ones
    end = stop(mass * ones, speed * ones, vacuum * ones, spring, GRAVITY, brakes)
    slip = np.where(end.outcome == BOTTOMED_OUT, np.inf, end.slip)
    interval = prediction.interval(slip)
    return interval["low"], interval["high"]


def tune(file: BrakeFile, mass: float, speed: float) -> float | None:
    """The safe vacuum [Pa] as `tune` finds it."""
    case = Stopping(brake=file.brake, mass=mass, speed=speed, travel=TRAVEL, gravity=GRAVITY)
    vacuum = tuning_vacuum(case)
    if vacuum is None:
        return None
    prediction = Prediction(file, vacuum, TRAVEL, speed, samples=DECISION_SAMPLES)
    return find_safe_vacuum(case, prediction, 0.95).vacuum


def is_inside(values: np.ndarray, ends: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Whether values lie in their intervals."""
    return (values >= ends[0]) & (values <= ends[1])


def add_campaign(case: Case, random: Random, tally: Tally) -> None:
    """Calibrate one device and predict what it does next."""
    device = draw_device(random, random.uniform(-0.1, 0.0) if case.far else None, case.scatter)
    file = calibrate(make_curves(case, device, random), load(device.film.name))

    def repeat(vacuum: float | np.ndarray) -> Pull:
        return device.pull(random, device.mount(random, FURTHER), vacuum)

    if case.far:
        for vacuum in FAR:
            ends = predict_peaks(file, np.full(1, vacuum))
            tally.add(f"{vacuum:g}", is_inside(repeat(vacuum).peak(), ends))
        return
    low, high = min(case.vacuums), max(case.vacuums)
    pulls = repeat(np.repeat(random.uniform(low, high, LEVELS), FURTHER // LEVELS))
    places, back = np.unique(pulls.vacuum, return_inverse=True)
    ends = predict_peaks(file, places)
    tally.add("peak", is_inside(pulls.peak(), (ends[0][back], ends[1][back])))
    tally.widths.append(float(np.median((ends[1] - ends[0]) / (ends[1] + ends[0]))))
    mass = device.film.mass * random.uniform(0.8, 1.2)
    speed = random.uniform(1.4, 2.0)
    ends = predict_stops(file, places, mass, speed)
    stops = evolve(repeat(0.0), vacuum=pulls.vacuum).stop(mass, speed)
    tally.add("slip", is_inside(stops, (ends[0][back], ends[1][back])))
    safe = tune(file, mass, speed)
    if safe is None:
        tally.unsafe += 1
        return
    tally.add("safe", repeat(safe).stop(mass, speed) <= TRAVEL)


def measure(
    case: Case, campaigns: int, seed: int, tell: Callable[[str], None] = lambda _: None
) -> Tally:
    """Predictions of one row over random campaigns."""
    tally = Tally()
    for number in range(campaigns):
        random = np.random.Generator(np.random.PCG64([seed, number, *case.name.encode()]))
        add_campaign(case, random, tally)
    tell(case.name)
    return tally


def _aim(name: str) -> tuple[float, float]:
    """Least and greatest share of what is predicted; far from the tests, intervals may be wide."""
    if name == "safe":
        return SAFE_AIM
    return AIM if name in ("peak", "slip") else (AIM[0], 1.0)


def is_outside(tally: Tally, name: str) -> bool:
    """Whether a share misses its aim by more than its own uncertainty."""
    low, high = _aim(name)
    share, error = tally.share(name), tally.error(name)
    return not low - error <= share <= high + error


def _cell(tally: Tally, name: str) -> str:
    (low, high), share = _aim(name), tally.share(name)
    mark = " **below**" if share < low else " **above**" if share > high else ""
    return f"{share:.1%} ± {tally.error(name):.1%}{mark}"


def table(found: dict[Case, Tally]) -> str:
    """The tables of predictions in Markdown."""
    near = [
        "| calibrated on | peak of a pull | slip of a stop | within the travel | half width |",
        "|---|---|---|---|---|",
    ]
    far = ["| calibrated on | peak at 10 kPa | peak at 95 kPa |", "|---|---|---|"]
    for case, tally in found.items():
        names = [f"{vacuum:g}" for vacuum in FAR] if case.far else ["peak", "slip", "safe"]
        cells = [case.name.removesuffix(FAR_MARK), *(_cell(tally, name) for name in names)]
        if not case.far:
            cells.append(f"{np.median(tally.widths):.1%}")
        (far if case.far else near).append(f"| {' | '.join(cells)} |")
    return "\n".join([*near, "", "For brakes whose friction depends on the vacuum:", "", *far])


def write(found: dict[Case, Tally], campaigns: int, seed: int) -> None:
    """Write the tables into docs/coverage.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(MARKS[0])
    unsafe = sum(tally.unsafe for tally in found.values())
    made = f"""{MARKS[0]}

`python tests/prediction_coverage.py --campaigns {campaigns} --seed {seed} --write` writes these
tables:

{table(found)}

In {unsafe:,} campaigns no vacuum was safe; they are not in the column *within the travel*.

{MARKS[1]}"""
    PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")


def main() -> int:
    """Measure, print, write; 1 where a share misses its aim."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", help="word in the name of a case")
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    found = {
        case: measure(
            case, given.campaigns, given.seed, lambda s: print(s, file=sys.stderr, flush=True)
        )
        for case in (*CASES, *UNSTATED, *OTHERS, *FAR_CASES)
        if given.only in case.name
    }
    print(table(found))
    if given.write:
        write(found, given.campaigns, given.seed)
    wrong = [
        f"{case.name}: {name} {tally.share(name):.1%}"
        for case, tally in found.items()
        for name in tally.shares
        if case not in UNSTATED + OTHERS and is_outside(tally, name)
    ]
    for line in wrong:
        print(f"outside its aim: {line}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
