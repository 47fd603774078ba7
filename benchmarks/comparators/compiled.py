"""C kernels compiled on the spot for the machine at hand, and called through ctypes."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.comparators.drops import Array, Drops

HERE = Path(__file__).parent
FLAGS = ("-O3", "-march=native", "-fopenmp")
VECTOR = (*FLAGS, "-fno-math-errno", "-fno-trapping-math")
"""The last two help C: without both GCC 12 makes no vector code of the loop in stop.c."""
Doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
Integers = np.ctypeslib.ndpointer(np.intc, flags="C_CONTIGUOUS")


class Brake(ctypes.Structure):
    """`Brake` of stop.c."""

    _fields_ = [
        (name, ctypes.c_double)
        for name in (
            "friction", "overlap", "travel", "stiffness", "drag", "reach", "spring", "gravity",
        )
    ]  # fmt: skip


def compiler() -> str | None:
    """The C compiler `cc`, or None where there is none."""
    return shutil.which("cc")


def cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def library(name: str, flags: tuple[str, ...] = FLAGS) -> ctypes.CDLL:
    """`NAME.c` of this folder, compiled into a temporary folder and loaded.

    Raises RuntimeError with what the compiler said. OpenMP takes as many threads as there are
    cores unless OMP_NUM_THREADS says otherwise.
    """
    command = compiler()
    if command is None:
        raise RuntimeError("no C compiler: there is no cc on the path")
    os.environ.setdefault("OMP_NUM_THREADS", str(cores()))
    with tempfile.TemporaryDirectory() as folder:
        built = Path(folder) / f"{name}.so"
        words = [
            command,
            *flags,
            "-shared",
            "-fPIC",
            "-o",
            str(built),
            str(HERE / f"{name}.c"),
            "-lm",
        ]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr)
        return ctypes.CDLL(str(built))


def function(
    name: str, arguments: Sequence[Any], flags: tuple[str, ...] = FLAGS
) -> Callable[..., None]:
    """The void function NAME of NAME.c with its argument types."""
    found = getattr(library(name, flags), name)
    found.argtypes, found.restype = list(arguments), None
    return found


def brake_of(drops: Drops) -> Brake:
    """The brake and rope of some drops, as stop.c wants them."""
    brake, sheets = drops.brake, drops.brake.sheets
    return Brake(
        friction=brake.scale_factor * brake.film.kinetic * (sheets.count - 1) * sheets.width,
        overlap=sheets.overlap,
        travel=drops.travel,
        stiffness=brake.enclosure.modulus * sheets.width * brake.enclosure.wall,
        drag=brake.film.friction_on_silicone * sheets.width,
        reach=(sheets.free_left + sheets.overlap + sheets.free_right) / 2,
        spring=drops.spring,
        gravity=drops.gravity,
    )


def prepare(drops: Drops, flags: tuple[str, ...] = FLAGS) -> Callable[[], tuple[Array, ...]]:
    """A call that solves the drops by stop.c into arrays allocated once.

    Gives slip, peak force, end speed, heat, stored energy (SI) and the outcome's code, as
    `layerjam.brake.mechanics.stop.exact.stop` does.
    """
    places = [Doubles] * 3 + [ctypes.POINTER(Brake)] + [Doubles] * 5 + [Integers]
    kernel = function("stop", [ctypes.c_long, *places], flags)
    given = [np.ascontiguousarray(a) for a in (drops.mass, drops.speed, drops.vacuum)]
    answers = tuple(np.zeros(len(drops), kind) for kind in (float,) * 5 + (np.intc,))
    brake = brake_of(drops)

    def run() -> tuple[Array, ...]:
        kernel(len(drops), *given, brake, *answers)
        return answers

    return run


def prepare_march(drops: Drops, step: float, steps: int) -> Callable[[], tuple[Array, ...]]:
    """A call that marches the drops in time by step.c: slip, peak force, time, to the last step."""
    places = [Doubles] * 3 + [ctypes.POINTER(Brake), ctypes.c_double, ctypes.c_long]
    kernel = function("step", [ctypes.c_long, *places, *[Doubles] * 3])
    given = [np.ascontiguousarray(a) for a in (drops.mass, drops.speed, drops.vacuum)]
    answers = tuple(np.zeros(len(drops)) for _ in range(3))
    brake = brake_of(drops)

    def run() -> tuple[Array, ...]:
        kernel(len(drops), *given, brake, step, steps, *answers)
        return answers

    return run
