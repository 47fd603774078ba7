"""Random closed loops with and without a tube, and a digest of all their numbers.

`python -m control.random_loops` in `tests/` writes `random_loops.json` from the current code.
"""

from __future__ import annotations

import hashlib
import json
import math
import random
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.bench.control.closed_loop import COLUMNS, ClosedLoop, simulate_run
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.faults import PROVOKED, FaultInjection, make_injection
from layerjam.bench.control.passage import Passage
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS, Regulator, validate
from layerjam.brake.fluid.line import Sensor
from layerjam.core.errors import QuantityError

FILE = Path(__file__).with_suffix(".json")
COUNT, SAMPLES = 96, 1500
NUMBERS = [name for name in COLUMNS if name != "fault"]
FIELDS = ("vacuum", "measured", "target", "pump", "vent", "fault")


def draw_loop(number: int) -> tuple[Regulator, dict[str, Any]]:
    """Return a controller and the arguments of its run; a third of the loops have a tube."""
    draw = random.Random(number)
    while True:
        rate, top = 10 ** draw.uniform(-1.5, 0.9), draw.uniform(9e4, 1.01e5)
        target = top * draw.uniform(0.2, 0.85)
        tube = None
        if number % 3 == 0:
            passes = rate * 10 ** draw.uniform(-0.3, 2.0) / (2 * 101325.0)
            tube = Passage(
                volume=10 ** draw.uniform(-2, 0), passes=passes, atmosphere=101325.0, vacuum=target
            )
        plant = Plant(
            rate=rate, top=top, leak=draw.choice([0.0, 1e-3, 5e-3]) * rate,
            vent=10 ** draw.uniform(0, 1.5), backwards=draw.choice([0.0, 4e4]),
            water=number % 3 == 1, passage=tube,
        )  # fmt: skip
        lag, noise = draw.choice([0.0, 0.005, 0.05]), draw.choice([0.0, 20.0, 50.0])
        sensor = Sensor(range=1.3e5, lag=lag, noise=noise, resolution=draw.choice([0.0, 25.0]))
        loop = Regulator(
            plant=plant, sensor=sensor, kind=list(KINDS)[number // 3 % 3],
            safe_state=draw.choice(["release", "hold"]), sample_time=draw.choice([0.002, 0.01]),
            reversible=plant.backwards > 0 and tube is None,
        )  # fmt: skip
        try:
            validate(loop, target)
        except QuantityError:
            continue
        length = SAMPLES * loop.sample_time
        name = draw.choice(["", "", *PROVOKED])
        onset = draw.uniform(0.1, 0.9) * length
        fault = make_injection(name, onset, loop, target)[0] if name else FaultInjection()
        targets = [(0.6 * length, target), (0.2 * length, 0.4 * target), (0.2 * length, 0.0)]
        return loop, {"targets": targets, "injected": fault, "seed": draw.randrange(2**40)}


def run_loop(number: int) -> ClosedLoop:
    """Run the loop of this number."""
    loop, options = draw_loop(number)
    return simulate_run(loop, options.pop("targets"), **options)


def digest(run: ClosedLoop) -> str:
    """Return a digest of every number of a run, except the sign of NaN and of zero."""
    numbers = [np.array([float(getattr(run, name)) for name in NUMBERS])]
    numbers += [np.asarray(getattr(run, name), float) for name in FIELDS]
    values = np.concatenate(numbers) + 0.0
    values[np.isnan(values)] = math.nan
    return hashlib.sha256(values.tobytes()).hexdigest()[:16]


def libm_digest() -> str:
    """Return a digest of the mathematical functions of this machine that the loops use."""
    draw = random.Random(7)
    numbers = (draw.uniform(1e-9, 5.0) for _ in range(2000))
    made = [f for x in numbers for f in (math.exp(-x), math.expm1(-x), math.log(x), x ** (-1 / 3))]
    return hashlib.sha256(struct.pack(f"{len(made)}d", *made)).hexdigest()[:16]


def outcomes() -> Iterator[tuple[str, list[float]]]:
    """Yield the digest and the numbers of each run."""
    for number in range(COUNT):
        run = run_loop(number)
        yield digest(run), [float(getattr(run, name)) for name in NUMBERS]


def worst_times() -> list[dict[str, float]]:
    """Return the detection times of every eighth loop."""
    loops = (draw_loop(number) for number in range(0, COUNT, 8))
    return [detection_times(loop, options["targets"][0][1]) for loop, options in loops]


if __name__ == "__main__":
    runs = list(outcomes())
    text = {"libm": libm_digest(), "digests": [key for key, _ in runs]}
    lines = ",\n ".join(json.dumps(row) for _, row in runs)
    times = ",\n ".join(json.dumps(row) for row in worst_times())
    FILE.write_text(
        f'{json.dumps(text)[:-1]},\n"runs": [{lines}],\n"times": [{times}]}}\n', encoding="utf-8"
    )
