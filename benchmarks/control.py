"""The control law: one step in CPython, and thousands of closed-loop hours."""

from __future__ import annotations

from benchmarks.timing import Row, median
from layerjam.bench.control import law
from layerjam.bench.control.closed_loop import simulate_run, simulate_runs
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.brake.fluid.line import Sensor

LINE = Plant(rate=0.4438, top=101325.0, leak=0.002, vent=5.0)
SENSOR = Sensor(range=103e3, lag=0.005, noise=50.0, resolution=25.0)
TARGETS = [(60.0, 80e3), (30.0, 40e3)]
HOURS, WANTED = 320, 10_000


def rows() -> list[Row]:
    """Seconds a step with all detectors, and seconds 10,000 hours at 100 Hz would take."""
    out = []
    for kind in ("bang-bang", "pi", "scheduled"):
        made = Regulator(plant=LINE, sensor=SENSOR, kind=kind, safe_state="release")
        history = simulate_run(made, TARGETS, duration=90.0)
        settings = made.pack()
        # floats, as a board has them: NumPy's scalars take twice as long
        samples = list(zip(history.measured.tolist(), history.target.tolist(), strict=True))

        def steps(samples=samples, settings=settings) -> None:  # type: ignore[no-untyped-def]
            state = law.fresh()
            for measured, target in samples:
                state, *_ = law.step(settings, state, measured, target)

        out.append(Row(f"a step in CPython, {kind}", median(steps, 5) / len(history.time), 5e-6))
    for kind in ("bang-bang", "pi", "scheduled"):
        made = Regulator(plant=LINE, sensor=SENSOR, kind=kind, safe_state="release")
        seconds = median(
            lambda made=made: simulate_runs(made, TARGETS, runs=HOURS, duration=3600.0), 3
        )
        name = f"10,000 h at 100 Hz, {kind}, by {HOURS} h"
        out.append(Row(name, seconds * WANTED / HOURS, 120.0))
    return out
