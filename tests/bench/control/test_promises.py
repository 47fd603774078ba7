"""What is promised of a fault is kept in every phase, by an integrator of high order and noise.

The law's detectors alone, at a pump that runs full: the vacuum rises from none, the fault begins
where a stated room is left below the pump's vacuum, and the detector began to count somewhere in
the two decision steps before.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench.control.loops import AIR, IDEAL, NOISY, WATER, regulator
from bench.control.test_tube import line, random_lines
from counts import FULL, cases
from layerjam.bench.control import law
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.settings import FAULTS, Regulator
from layerjam.bench.control.tolerances import EXACT, Tolerances
from layerjam.brake.fluid.line_file import load_line

PHASES = 96
RATE = 4
"""Where what is seen holds the rise owed in a sample."""
PUMP = {"NO_VACUUM", "WEAK_PUMP", "SENSOR_STUCK"}
CATALOGUE = load_line("choi2018").line
PLANTS = {
    "air": AIR,
    "water": WATER,
    "paper": linearise_line(CATALOGUE, vacuum=94.5e3),
    "paper-water": linearise_line(CATALOGUE, vacuum=94.5e3, water=True),
    "tube": linearise_line(line(leak=2e-8), vacuum=85e3),
    "wide-tube": linearise_line(line(2.0, 2e-3), vacuum=94.5e3),
}


def risen(
    plant: Plant, lag: float, start: tuple[float, ...], pump: float, left: float, times: Any
) -> Any:
    """Chamber's and side's vacuum and what the sensor shows, shape (3, N), at full command.

    Water rises beyond the pump's vacuum in these equations; the sensor sees it end there.
    """
    tube = plant.passage

    def slope(_t: float, y: Any) -> list[float]:
        v, w, shown = y
        lagging = (min(v, plant.top) - shown) / lag if lag else 0.0
        if tube is None:
            dv = pump * plant.rate * (plant.top - plant.weight * v) - plant.leak * v
            return [dv / left, 0.0, lagging]
        p, s = tube.atmosphere - v, tube.atmosphere - w
        along = tube.passes * (p * p - s * s)
        drawn = pump * plant.rate * (plant.top - w)
        return [(along - plant.leak * v) / left, (drawn - along) / tube.volume, lagging]

    made = solve_ivp(
        slope, (times[0], times[-1]), start, "LSODA", t_eval=times, rtol=1e-8, atol=1e-2
    )  # fmt: skip
    assert made.success
    if not lag:
        made.y[2] = np.minimum(made.y[0], plant.top)
    return made.y


def path(
    loop: Regulator, at: float, pump: float, left: float, after: int, restarts: bool
) -> tuple[Any, int]:
    """What the sensor shows at the samples, and the sample at which the fault begins.

    The pump has run for long, or `restarts` with the fault.
    """
    plant, dt, lag = loop.plant, loop.sample_time, loop.sensor.lag
    if restarts:
        return risen(plant, lag, (at, at, at), pump, left, dt * np.arange(after + 1))[2], 0
    most = at / plant.rise(at)
    fine = np.linspace(0.0, 1.05 * most, 4001)
    rises = risen(plant, lag, (0.0, 0.0, 0.0), 1.0, 1.0, fine)[0]
    begins = float(np.interp(at, rises, fine))
    before = int(begins / dt - 1e-9)
    samples = begins - dt * np.arange(before, -1, -1)
    sound = risen(plant, lag, (0.0, 0.0, 0.0), 1.0, 1.0, np.r_[0.0, samples])[:, 1:]
    broken = risen(plant, lag, tuple(sound[:, -1]), pump, left, dt * np.arange(after + 1))
    return np.r_[sound[2], broken[2, 1:]], before


def said(loop: Regulator, shows: Any, first: int, seed: int) -> tuple[int, str]:
    """Sample and name of the first fault of a detector that begins at one; -1 for none."""
    sensor, watch, seen = loop.sensor, loop.pack()[1], law.fresh()[1]
    if first:  # the pump has run before
        owed = float(loop.owed_rise.rise_at(shows[first])) * loop.sample_time
        seen = (*seen[:RATE], owed, *seen[RATE + 1 :])
    noisy = shows + sensor.noise * np.random.default_rng(seed).standard_normal(len(shows))
    if sensor.resolution:
        noisy = np.rint(noisy / sensor.resolution) * sensor.resolution
    pump = 0.0
    for n in range(first, len(noisy)):
        fault, _, seen = law.detect(
            watch, seen, (0.0, pump, 0.0, 1e9, 1e9, 0.0, 0.0, 0.0), float(noisy[n]), 0.0
        )
        if fault:
            return n, FAULTS[int(fault)]
        pump = 1.0
    return -1, ""


def kept(loop: Regulator, at: float, name: str, pump: float, left: float) -> bool:
    """In every phase the fault is said under its name in its time; False where none is promised."""
    promised = detection_times(loop, at)[name]
    if math.isinf(promised):
        return False
    dt = loop.sample_time
    names = {"LINE_BLOCKED"} if name == "LINE_BLOCKED" else PUMP
    for restarts in (False, True):
        shows, begins = path(loop, at, pump, left, math.ceil(promised / dt), restarts)
        counted = np.cumsum(loop.owed_rise.rise_at(shows[begins::-1]) * dt)
        window = max(int(np.searchsorted(counted, 2 * loop.detection_threshold)), PHASES // 12)
        for phase in range(PHASES):
            first = max(begins - round(window * phase / PHASES), 0)
            n, what = said(loop, shows, first, phase)
            assert what in names, (name, at, phase, what, n - begins)
            assert 0 < (n - begins) * dt <= promised + 1e-9, (name, at, phase)
    return True


def each_fault(loop: Regulator, at: float, smaller: tuple[float, ...] = (1.0,)) -> set[str]:
    """The faults promised there, every promise kept."""
    made = set()
    for name, pump, left in (
        ("NO_VACUUM", 0.0, 1.0),
        ("WEAK_PUMP", loop.weak_ratio / 2, 1.0),
        *(("LINE_BLOCKED", 1.0, part * 0.5 / loop.blocked_ratio) for part in smaller),
    ):
        if kept(loop, at, name, pump, left):
            made.add(name)
    return made


ALL = {"NO_VACUUM", "WEAK_PUMP", "LINE_BLOCKED"}


ROOMS = (1.0, 1.3, 1.6, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 16.0, 25.0, 40.0)[:: cases(1, 2)]
"""Decision steps of room below the pump's vacuum."""


def at_room(loop: Regulator, steps: float) -> float:
    """The vacuum with so many decision steps of room below the pump's, where that is tuned for."""
    tube, at = loop.plant.passage, loop.plant.top - steps * loop.detection_threshold
    return at if tube is None else min(at, tube.vacuum)


@pytest.mark.parametrize(
    "steps", [2.0, 3.4, *(pytest.param(n, marks=pytest.mark.slow) for n in (8.0, 30.0))]
)
@pytest.mark.parametrize("plant", ["air", "paper"])
def test_two_steps_of_room_do_in_air(plant: str, steps: float) -> None:
    """The paper's 94.5 kPa leaves 3.4 steps."""
    loop = regulator(plant=PLANTS[plant], kind="bang-bang", tolerances=EXACT)
    assert each_fault(loop, at_room(loop, steps)) == ALL


@pytest.mark.parametrize("steps", [4.0, 10.0])
@pytest.mark.parametrize("plant", ["water", "paper-water"])
def test_water_takes_the_room_of_a_sample_more(plant: str, steps: float) -> None:
    """A blocked water line rises by two decision steps within a sample of 10 ms."""
    loop = regulator(plant=PLANTS[plant], kind="bang-bang", tolerances=EXACT)
    assert each_fault(loop, at_room(loop, steps)) == ALL


@pytest.mark.parametrize("steps", [8.0, pytest.param(20.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("plant", ["tube", "wide-tube"])
def test_a_block_behind_a_tube_is_named(plant: str, steps: float) -> None:
    """Tubes that hold a third and nearly all of the chamber's gas besides."""
    loop = regulator(plant=PLANTS[plant], kind="bang-bang", tolerances=EXACT)
    assert "LINE_BLOCKED" in each_fault(loop, at_room(loop, steps))


LOOPS = [
    loop
    for number, loop in enumerate(
        itertools.product(PLANTS, ("bang-bang", "pi"), (NOISY, IDEAL), (EXACT, Tolerances()))
    )
    if FULL or min(number % 8, 7 - number % 8) == number // 8 % 4
]
"""Plant, kind, sensor and tolerances; `make slow` takes a quarter, two opposite ones a plant."""


@pytest.mark.slow
@pytest.mark.parametrize(("plant", "kind", "sensor", "tolerances"), LOOPS)
def test_every_room_stated(plant: str, kind: str, sensor: Any, tolerances: Tolerances) -> None:
    loop = regulator(plant=PLANTS[plant], kind=kind, sensor=sensor, tolerances=tolerances)
    for steps in ROOMS:
        at = at_room(loop, steps)
        if at > 0:  # wide steps leave no room for forty of them
            each_fault(loop, at, (1.0, 0.3, 0.01))


@pytest.mark.slow
def test_every_promise_behind_random_tubes() -> None:
    """Many are promised, and what is promised is kept."""
    count = dict.fromkeys(ALL, 0)
    for of, target in random_lines(cases(40, 10), 6):
        loop = regulator(
            plant=linearise_line(of, vacuum=target), kind="bang-bang",
            sample_time=min(0.01, 0.09 / linearise_line(of, vacuum=target).rate),
        )  # fmt: skip
        for share in (1.0, 0.3):
            for name in each_fault(loop, share * target):
                count[name] += 1
    assert min(count.values()) >= cases(30, 7), count
