"""Time of a prediction with its interval, and of a drop without one. Aim: 20 ms more, warm."""

from __future__ import annotations

from collections.abc import Callable
from unittest.mock import patch

import layerjam
from benchmarks.timing import Row, median
from layerjam.brake.simulate import stop_spread

MOST = 0.02


def rows() -> list[Row]:
    """Whole calls of the commands; only a drop takes longer than the aim with its interval."""
    file = layerjam.load("choi2018-kapton")
    stop = {"mass": 1.0, "speed": 2.0, "rope_stiffness": 16.8e3}
    calls: dict[str, Callable[[], object]] = {
        "force": lambda: layerjam.force(file, slip=0.02, vacuum=45e3),
        "vacuum": lambda: layerjam.vacuum(file, slip=0.02, force=40.0),
        "tensile": lambda: layerjam.tensile(file, vacuum=45e3, speed=0.013, elongation=0.04),
        "tune": lambda: layerjam.tune(file, travel=0.04, **stop),
    }

    def drop() -> object:
        return layerjam.drop(file, vacuum=45e3, **stop)

    with patch.object(stop_spread, "_solve_samples", lambda prediction, record: {}):
        bare = median(drop)
    return [
        *(Row(f"{name} with its interval", median(call), MOST) for name, call in calls.items()),
        Row("drop with its interval", median(drop), bare + MOST, bare, "without"),
    ]
