"""Parts of the controller's loops as C computes them."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.bench.control.exact import Rates
from layerjam.bench.control.noise import LAYERS, make_key
from layerjam.brake.kernel.compiler import LOOPS, build_library

HERE = Path(__file__).parent


@functools.cache
def library() -> Any:
    """The printed loops with `driver.c`."""
    path = build_library([HERE / "driver.c"], includes=[LOOPS[0].parent])
    made = ctypes.CDLL(str(path))
    made.lj_test_mix.restype = ctypes.c_uint64
    return made


def pack(*numbers: float) -> Any:
    return (ctypes.c_double * len(numbers))(*numbers)


def step(settings: Any, state: Any, value: float, target: float) -> Any:
    """`law.step` in C, with its answer in the same tuples."""
    out = pack(*[0.0] * 25)
    real = ctypes.c_double
    library().lj_test_step(
        pack(*settings[0], *settings[1]), pack(*state[0], *state[1]), real(value), real(target), out
    )
    drive, memory = tuple(out[:8]), tuple(out[8:22])
    return (drive, memory), out[22], int(out[23]), int(out[24])


def factors(
    plant: Rates, pump: float, vent: float, dt: float, lag: float, left: float
) -> list[float]:
    """`exact.step_factors` in C."""
    out = pack(0.0, 0.0, 0.0, 0.0)
    given = map(ctypes.c_double, (pump, vent, dt, lag, left))
    library().lj_test_factors(pack(*plant), *given, out)
    return list(out)


def noise(seed: int, stream: int, first: int, count: int) -> np.ndarray[Any, Any]:
    """Numbers of a stream of noise, in C."""
    out = np.empty(count)
    key, whole = ctypes.c_uint64(make_key(seed, stream)), ctypes.c_int64
    library().lj_test_noise(
        key, whole(first), whole(count), pack(*LAYERS.edges), pack(*LAYERS.inner),
        ctypes.c_void_p(out.ctypes.data),
    )  # fmt: skip
    return out


def mix(word: int) -> int:
    """`noise.mix_bits` in C."""
    return int(library().lj_test_mix(ctypes.c_uint64(word)))
