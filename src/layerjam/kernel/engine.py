"""A whole history of a brake by the kernel where it gives the law's answer, by the law elsewhere.

`brake_cycle` is traced and compiled anew in every process and for every length; the kernel is
compiled once on a machine. Both give the same numbers to rounding, so that which of them ran shows
in nothing but the time.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import CompilerError, QuantityError
from layerjam.kernel.compiler import built, compiler_on_path, library
from layerjam.kernel.kernel import CODE, Kernel, loaded
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.hysteresis import brake_cycle
from layerjam.mechanics.threads import once

SWITCH = "LAYERJAM_KERNEL"
"""Environment variable; `off` keeps every simulation on `brake_cycle`."""
LONGEST = 10.0
"""Seconds that a compiler may take before nobody waits for it; gcc takes a third of one."""
BLOCK = 512
"""Samples; JAX compiles a law anew for every other length of a history."""
Engine = Literal["kernel", "law"]
Array = np.ndarray[Any, np.dtype[np.float64]]


def quick_kernel(brake: Brake, vacuum: float) -> Kernel | None:
    """The kernel of a brake at vacuums [Pa] up to one; None where only `brake_cycle` will do.

    That is where the kernel lacks the brake's law (sheets that fan out, a speed law, a
    hyperelastic enclosure), where the brake snaps on its stiffness, where there is neither a
    library nor a compiler to make one, and where LAYERJAM_KERNEL=off. Raises QuantityError for
    another value of that variable.
    """
    if not _switched_on() or not _is_there():
        return None
    try:
        kernel = Kernel(brake)
    except QuantityError:
        return None
    numbers = kernel.parameters
    if not all(map(math.isfinite, numbers)) or min(numbers[:6]) <= 0:
        return None
    least = numbers.contact * vacuum * (vacuum / numbers.test_pressure) ** numbers.exponent
    # where both are equal rounding decides whether it snaps, and that is the law's to say
    return kernel if numbers.stiffness > least * (1 + 1e-9) else None


def followed(
    elongation: Array, vacuum: Array, brake: Brake, speed: Array | None = None
) -> tuple[Cycle, Engine]:
    """`brake_cycle` along a history, shape (N,), in NumPy arrays, and what computed it.

    With `speed` [m/s] a speed law counts; without, friction is that at the law's test speed.
    """
    kernel = None
    if speed is None:
        highest = float(np.max(vacuum, initial=0.0))
        kernel = quick_kernel(replace(brake, speed_law=None), highest)
    twin = None if kernel is None else kernel.twin(elongation, vacuum)
    if twin is not None:
        return twin, "kernel"
    given = (elongation, vacuum) if speed is None else (elongation, vacuum, speed)
    return in_blocks(lambda u, p, *v: brake_cycle(u, p, brake, *v), *given), "law"


def in_blocks(run: Callable[..., Cycle], *histories: Array) -> Cycle:
    """What `run` makes of histories, shape (N,), that it is given in whole blocks of samples."""
    count = len(histories[0])
    longer = [np.pad(each, (0, -count % BLOCK), mode="edge") for each in histories]
    return Cycle(*(np.asarray(values)[:count] for values in run(*longer)))


def _switched_on() -> bool:
    said = os.environ.get(SWITCH, "")
    if said not in ("", "on", "off"):
        raise QuantityError.of(SWITCH, f"'{said}' is not known; set it to off, or leave it out")
    return said != "off"


@once
def _is_there() -> bool:
    """Whether the library is there or can be made at once; asked once in a process."""
    try:
        if built(CODE) is None:
            if compiler_on_path() is None:
                return False
            library(CODE, limit=LONGEST)
        loaded("double")
    except (CompilerError, OSError):
        return False
    return True
