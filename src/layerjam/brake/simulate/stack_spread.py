"""Monte Carlo simulation of stacks: scatter of peak and stiffness due to scatter of interfaces."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.stack import Peaks, find_loop, find_peaks
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.prediction import log_normal
from layerjam.brake.simulate.stack_layout import Housing, Interfaces, make_stack
from layerjam.core.errors import LayerjamError, QuantityError

Array = np.ndarray[Any, np.dtype[np.float64]]
CHUNK, PYTHON_CHUNK = 22_000, 220
"""Number of sheets times stacks between two progress reports, and without the compiled kernel."""


@dataclass(frozen=True)
class Spread(Peaks):
    """Results of M stacks."""

    scatter: float
    seed: int

    @property
    def count(self) -> int:
        """Number of stacks pulled."""
        return len(self.peak)


def draw_normal(first: int, last: int, count: int, seed: int) -> Array:
    """Return standard normal numbers for samples `first` to `last`, shape (last - first, count).

    Each sample uses its own counter in the generator, so the numbers do not depend on chunks.
    """
    # not a Latin hypercube as in `Prediction`: a stack has a friction for each of thousands of
    # interfaces, and stacks are added until the user stops
    from scipy.special import ndtri

    words = -(-count // 4)
    source = np.random.Philox(key=seed).advance(first * words)
    raw = source.random_raw((last - first) * words * 4).reshape(last - first, -1)[:, :count]
    return np.asarray(ndtri(((raw >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53))


def peak_spread(
    file: BrakeFile,
    vacuum: float,
    scatter: float,
    samples: int = 200,
    seed: int = 1,
    *,
    interfaces: Interfaces | None = None,
    housing: Housing | None = None,
    static: bool = False,
    one_by_one: bool = False,
    progress: Callable[[int, int], None] | None = None,
    chunk: int | None = None,
) -> Spread:
    """Pull many stacks whose interface friction scatters log-normally with relative SD `scatter`.

    The mean friction is unchanged. `interfaces`, `housing`, `static` and `one_by_one` apply to all
    stacks. The numbers depend only on `seed`, not on `chunk` or the number of threads. `progress`
    is called with (done, asked) after each chunk of stacks, by default after a fraction of a
    second.
    """
    if not 0 <= scatter <= 2:
        raise QuantityError(f"scatter: {scatter!r} is not allowed; use 0 to 2")
    if samples < 1 or (chunk is not None and chunk < 1) or seed < 0:
        raise QuantityError("samples and chunk must be at least 1, and seed at least 0")
    if not vacuum > 0:
        raise QuantityError.of(
            "vacuum",
            f"at {vacuum!r} Pa there is no friction to vary; use a higher vacuum",
        )
    brake = file.brake
    layout: Any = {"interfaces": interfaces, "housing": housing, "static": static}
    stack = make_stack(brake, vacuum, one_by_one=one_by_one, **layout)
    top = float(peak(vacuum, brake.sheets.overlap, brake).force)
    end = brake.sheets.usable_travel + 2 * top / float(working_stiffness(brake))
    first, last = (int(e) for e in stack.ends)
    if chunk is None:
        cost = PYTHON_CHUNK if find_loop("lj_follow_peaks") is None else CHUNK
        chunk = max(1, cost // stack.sheet_count)
    parts: list[Peaks] = []
    for start in range(0, samples, chunk):
        stop = min(start + chunk, samples)
        friction = np.tile(stack.friction, (stop - start, 1))
        normal = draw_normal(start, stop, last - first, seed)
        friction[:, first:last] *= log_normal(normal, 1.0, scatter)
        length = np.broadcast_to(stack.length, friction.shape)
        parts.append(find_peaks(stack, friction, length, end))
        if progress:
            progress(stop, samples)
    columns: Any = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(Peaks)
    }
    spread = Spread(**columns, scatter=scatter, seed=seed)
    if (spread.peak < 0).any():
        raise LayerjamError("stack: no equilibrium was found; please report this brake")
    return spread
