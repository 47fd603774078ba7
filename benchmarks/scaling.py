"""The march in time beside a C loop of the same steps, and the cost of a drop from 1e5 to 1e8."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.comparators import compiled
from benchmarks.comparators.drops import population

STEP, STEPS, MARCHED = 1e-5, 1000, 8192
SIDES = {10**5: (10, 100, 100), 10**6: (100, 100, 100), 10**7: (100, 1000, 100)}
SIDES |= {10**8: (1000, 1000, 100)}


class March(NamedTuple):
    """What a march gives here."""

    slip: Any
    peak: Any
    outcome: Any


def median(call: Callable[[], Any], rounds: int = 5) -> float:
    """Median seconds after one uncounted call."""
    call()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return sorted(times)[rounds // 2]


def march(mass: Any, speed: Any, vacuum: Any, rope: Any, gravity: Any, brake: Any) -> March:
    """Our solver in time, in steps of 10 us."""
    from layerjam.brake.mechanics.stop.motion import stop_in_time

    run = stop_in_time(mass, speed, vacuum, None, rope, None, gravity, STEP, STEPS, brake)
    return March(run.slip, run.peak, run.outcome * 1.0)


def marches() -> list[tuple[str, float, float]]:
    """(name, seconds a step, worst slip against ours) of 1,000 steps of 10 us, 8,192 drops."""
    from layerjam.brake.simulate.batch import batch

    drops = population(MARCHED)
    assert drops.brake.rope is not None
    sweep: dict[str, Any] = {n: ("drop", getattr(drops, n)) for n in ("mass", "speed", "vacuum")}
    sweep |= {"rope": drops.brake.rope.stiffness, "gravity": drops.gravity}

    def ours() -> Any:
        return batch(march, sweep, brake=drops.brake, block=256)

    rows = [("layerjam, stop_in_time", median(ours), 0.0)]
    if compiled.compiler():
        loop = compiled.prepare_march(drops, STEP, STEPS)
        # C leaves a drop one step short of its end, ours goes on to it: compared while they move
        made = ours()
        off = np.abs(made.slip.values - loop()[0])[made.outcome.values == 0].max(initial=0.0)
        rows.append(("C loop, same steps", median(loop), float(off)))
    return [(name, seconds / MARCHED / STEPS, off) for name, seconds, off in rows]


def sizes() -> list[tuple[int, float]]:
    """(drops, seconds a drop) over grids of mass, speed and vacuum that go to a sink."""
    from layerjam.brake.mechanics.stop.exact import stop
    from layerjam.brake.simulate.batch import batch

    drops = population(10)
    rows = []
    for count, sides in SIDES.items():
        sweep = {
            "mass": np.linspace(0.3, 3.0, sides[0]), "speed": np.linspace(0.5, 3.5, sides[1]),
            "vacuum": np.linspace(40e3, 101e3, sides[2]), "spring": drops.spring,
            "gravity": drops.gravity,
        }  # fmt: skip
        least = [0.0]

        def sink(_: int, values: Any, least: list[float] = least) -> None:
            least[0] = max(least[0], float(values["slip"].max()))

        def run(sweep: Any = sweep, sink: Any = sink) -> None:
            batch(stop, sweep, brake=drops.brake, sink=sink)

        rows.append((count, median(run, 3 if count < 10**8 else 1) / count))
    return rows


def report() -> list[str]:
    """Two tables as Markdown."""
    lines = ["| march in time | a step | times ours | worst slip apart | wanted |"]
    lines += ["|---|---:|---:|---:|---|"]
    rows = marches()
    for name, seconds, off in rows:
        ratio, goal = seconds / rows[0][1], ""
        if name.startswith("C"):
            goal = f"at least {1 / 1.5:.2f}: {'met' if ratio >= 1 / 1.5 else 'MISSED'}"
        lines.append(f"| {name} | {seconds * 1e9:.3g} ns | {ratio:.3g} | {off:.0e} m | {goal} |")
    lines += ["", "| drops, to a sink | a drop | times 1e5 | wanted |", "|---:|---:|---:|---|"]
    grown = sizes()
    for count, seconds in grown:
        ratio = seconds / grown[0][1]
        goal = f"at most 1.3: {'met' if ratio <= 1.3 else 'MISSED'}"
        lines.append(f"| {count:,} | {seconds * 1e9:.3g} ns | {ratio:.3g} | {goal} |")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    lines += ["", f"Most memory of the whole process so far: {most:.2f} GB (wanted: at most 2)."]
    return lines
