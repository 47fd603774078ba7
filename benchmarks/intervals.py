"""Time that an interval adds to a prediction. Aim: at most 20 ms, warm."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import ModuleType
from typing import Any
from unittest.mock import patch

import layerjam
from benchmarks.timing import Row, median
from layerjam.brake.simulate import pull_spread, stop_spread
from layerjam.core.evolve import evolve

MOST, RUNS = 0.02, 9
CYCLE = "evacuate to 45 kPa; pull at 13 mm/s until 40 mm; return at 13 mm/s until 10 mm"


def rows() -> list[Row]:
    """Whole calls of short commands; of others the part that finds the interval."""
    file = layerjam.load("choi2018-kapton")
    fanned = evolve(file, brake=file.brake.with_(spacers=False))
    stop = {"mass": 1.0, "speed": 2.0, "rope_stiffness": 16.8e3}
    calls: dict[str, Callable[[], object]] = {
        "force": lambda: layerjam.force(file, slip=0.02, vacuum=45e3),
        "vacuum": lambda: layerjam.vacuum(file, slip=0.02, force=40.0),
        "tensile": lambda: layerjam.tensile(file, vacuum=45e3, speed=0.013, elongation=0.04),
        "tune": lambda: layerjam.tune(file, travel=0.04, **stop),
    }

    def drop(**more: Any) -> Callable[[], object]:
        return lambda: layerjam.drop(**{"brake": file, "vacuum": 45e3, **stop, **more})

    def pull(**more: Any) -> Callable[[], object]:
        case = {"brake": file, "vacuum": 45e3, "speed": 0.013, "elongation": 0.04}
        return lambda: layerjam.tensile(**{**case, **more})

    parts: dict[str, tuple[Callable[[], object], ModuleType, str]] = {
        "drop": (drop(), stop_spread, "spread_stop"),
        "drop without spacers": (drop(brake=fanned), stop_spread, "spread_stop"),
        "drop with a leak": (drop(leak_time=1.0), stop_spread, "spread_stop"),
        "drop with a damped rope": (drop(rope_damping=20.0), stop_spread, "spread_stop"),
        "tensile without spacers": (pull(brake=fanned), pull_spread, "spread_pull"),
        "tensile sheet by sheet": (pull(model="stack"), pull_spread, "spread_pull"),
        "tensile, static friction": (
            pull(model="stack", static=True),
            pull_spread,
            "spread_pull",
        ),
        "tensile of a cycle": (
            lambda: layerjam.tensile(file, procedure=CYCLE),
            pull_spread,
            "spread_pull",
        ),
    }
    return [
        *(Row(f"{name} with its interval", median(call), MOST) for name, call in calls.items()),
        *(Row(f"interval of {name}", _time_part(*part), MOST) for name, part in parts.items()),
    ]


def _time_part(call: Callable[[], object], module: ModuleType, name: str) -> float:
    """Return the median CPU time [s] that a call spends in a function of a module."""
    function, times = getattr(module, name), []

    def timed(*args: Any, **keywords: Any) -> Any:
        start = time.process_time()
        result = function(*args, **keywords)
        times.append(time.process_time() - start)
        return result

    with patch.object(module, name, timed):
        for _ in range(RUNS + 1):
            call()
    return sorted(times[1:])[RUNS // 2]
