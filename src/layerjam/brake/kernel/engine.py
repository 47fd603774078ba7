"""History of a brake, computed by the kernel if it has the brake's law, otherwise by JAX.

Every process must compile `brake_cycle` for every length of history, but the kernel is compiled
once per machine. Both compute the same numbers up to rounding, so the choice affects only the time.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.compiler import (
    SHIPPED,
    STOPS,
    build_library,
    cached_library,
    find_on_path,
    shipped_library,
)
from layerjam.brake.kernel.kernel import CODE, Kernel, load_library, load_stop_loop
from layerjam.brake.kernel.library import SWITCH, is_switched_on
from layerjam.brake.mechanics.cycle import Cycle
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.speed_effects import ignore_speed
from layerjam.core.errors import CompilerError, QuantityError
from layerjam.core.threads import cache_threadsafe

LONGEST = 60.0
"""Maximum compile time [s]; gcc needs a third of a second, but far more on a busy machine."""
BLOCK = 512
"""Number of samples in a block, fixed because JAX compiles a law again for every length."""
Engine = Literal["kernel", "law"]
Array = np.ndarray[Any, np.dtype[np.float64]]


def make_quick_kernel(brake: Brake, vacuum: float) -> Kernel | None:
    """Return the kernel of a brake up to a vacuum [Pa], or None if only `brake_cycle` can be used.

    `brake_cycle` is needed if the kernel lacks the brake's law (sheets that fan out, a speed law, a
    hyperelastic enclosure) or if the brake is so soft that it snaps. It is also needed if there is
    neither a library nor a compiler, or if LAYERJAM_KERNEL=off. Raises QuantityError for any other
    value of that variable.
    """
    if not is_switched_on() or not _is_available():
        return None
    try:
        kernel = Kernel(brake)
    except QuantityError:
        return None
    numbers = kernel.parameters
    if not all(map(math.isfinite, numbers)) or min(numbers[:6]) <= 0:
        return None
    least_friction = numbers.contact * vacuum * (vacuum / numbers.test_pressure) ** numbers.exponent
    # if both are equal, rounding determines whether it snaps, so use the law
    return kernel if numbers.stiffness > least_friction * (1 + 1e-9) else None


def find_stop_loop() -> Callable[..., int] | None:
    """Return the compiled function `lj_stops`, or None if only the law can be used.

    Raises QuantityError for an unknown value of LAYERJAM_KERNEL.
    """
    return load_stop_loop() if is_switched_on() and _is_available(STOPS) else None


def follow_history(
    elongation: Array, vacuum: Array, brake: Brake, speed: Array | None = None
) -> tuple[Cycle, Engine]:
    """Return the `brake_cycle` of a history, shape (N,), as NumPy arrays, and the engine used.

    With `speed` [m/s], the speed law applies; otherwise, friction is that at its test speed.
    """
    kernel = None
    if speed is None:
        highest = float(np.max(vacuum, initial=0.0))
        kernel = make_quick_kernel(ignore_speed(brake), highest)
    twin = None if kernel is None else kernel.exact_cycle(elongation, vacuum)
    if twin is not None:
        return twin, "kernel"
    histories = (elongation, vacuum) if speed is None else (elongation, vacuum, speed)
    return run_in_blocks(lambda u, p, *v: brake_cycle(u, p, brake, *v), *histories), "law"


def run_in_blocks(run: Callable[..., Cycle], *histories: Array) -> Cycle:
    """Return the result of `run` for histories, shape (N,), padded to whole blocks of samples."""
    count = len(histories[0])
    longer = [np.pad(history, (0, -count % BLOCK), mode="edge") for history in histories]
    return Cycle(*(np.asarray(values)[:count] for values in run(*longer)))


def describe_engine() -> str:
    """Return a description of the engine that computes histories in this process.

    Raises QuantityError for an unknown value of LAYERJAM_KERNEL.
    """
    if not is_switched_on():
        return f"law ({SWITCH}=off)"
    if not _is_available():
        return "law (no compiled kernel for this machine, and no C compiler to build it)"
    path = Path(load_library("double")[0]._name)
    came = "shipped with layerjam" if path.parent == SHIPPED else "compiled on this machine"
    return f"kernel ({came}: {path})"


@cache_threadsafe
def _is_available(sources: tuple[Path, ...] = CODE) -> bool:
    """Return whether the library exists or can be built now; checked once per process."""
    try:
        if shipped_library(sources) is None and cached_library(sources) is None:
            if find_on_path() is None:
                return False
            build_library(sources, limit=LONGEST)
        if sources == STOPS:
            load_stop_loop()
        else:
            load_library("double")
    except (CompilerError, OSError):
        return False
    return True
