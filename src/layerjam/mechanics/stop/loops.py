"""Millions of exact stops: the algebra of a stop as machine-code loops over all cores.

A block of drops goes through short loops, one for each part of the algebra; intermediate results
are in rows that stay in the fastest cache. One long loop is slower: within a drop, each root
depends on the previous one, and the processor cannot look far enough ahead to start the next drops.
"""

import math
from pathlib import Path
from typing import Any

import numba
import numpy as np

from layerjam.mechanics import compiled
from layerjam.mechanics.compilation import compile_loop
from layerjam.mechanics.compiled import scalar, stamp_of
from layerjam.mechanics.enclosure import EnclosureLaw
from layerjam.mechanics.stop import algebra, exact
from layerjam.mechanics.threads import cache_threadsafe

BLOCK = 128
"""Number of drops in one piece of work, whose rows stay in the fastest cache."""
ROW = BLOCK + 8
"""Distance of rows; rows a power of two apart would share few lines of the cache."""
ROUNDS = 5
"""More steps of the root's search, at most, for the drops that three have not settled."""
# start of each row: the drop, and the values passed between the loops
MASS, SPEED, VACUUM, SPRING, GRAVITY = range(0, 5 * ROW, ROW)
ROOT, A0, A1, A2, A3, A4, LOW, HIGH, STOPS, LIMIT, SNAPS, W, STEP = range(5 * ROW, 18 * ROW, ROW)
ROWS = 18 * ROW
SETTLED = exact.SETTLED
setup, search, end_of = scalar(algebra.setup), scalar(algebra.search), scalar(algebra.end_of)
guess, curvature_step = scalar(algebra.guess), scalar(algebra.curvature_step)
polish_root, slope_of = scalar(algebra.polish_root), scalar(algebra.slope_of)


def _inline(function: Any) -> Any:
    return numba.njit(error_model="numpy", forceinline=True, fastmath={"contract"})(function)


def _loop(function: Any) -> Any:
    return numba.njit(error_model="numpy", fastmath={"contract"})(function)


@_loop
def _copy(into, values):  # type: ignore[no-untyped-def]  # pragma: no cover
    for i in range(len(into)):
        into[i] = values[i]


@_loop
def _repeat(into, value):  # type: ignore[no-untyped-def]  # pragma: no cover
    for i in range(len(into)):
        into[i] = value


@_inline
def setup_of(rows, i, constants, root):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return the constants of drop i of a block."""
    vacuum, ea, reach = rows[VACUUM + i], constants.stiffness, constants.reach
    saturation = constants.drag * reach * reach / ea * vacuum
    enclosure = EnclosureLaw(ea, constants.drag * vacuum, reach, root, saturation)
    mass, speed, c = rows[MASS + i], rows[SPEED + i], constants.friction * vacuum
    return setup(mass, speed, c, constants.overlap, enclosure, rows[SPRING + i], rows[GRAVITY + i])


@_inline
def search_of(rows, i):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return the results of the first loops for drop i of a block."""
    energy = algebra.Quartic(rows[A0 + i], rows[A1 + i], rows[A2 + i], rows[A3 + i], rows[A4 + i])
    low, high, limit = rows[LOW + i], rows[HIGH + i], rows[LIMIT + i]
    return algebra.Search(energy, low, high, rows[STOPS + i] > 0, limit, rows[SNAPS + i] > 0)


@_loop
def opening(rows, constants):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Find the brackets of the roots and the quartic of each."""
    for i in range(BLOCK):
        root = 2 * math.sqrt(constants.stiffness * constants.drag * rows[VACUUM + i])
        bracket = search(setup_of(rows, i, constants, root), constants.travel)
        rows[ROOT + i] = root
        rows[A0 + i], rows[A1 + i], rows[A2 + i] = bracket.energy[:3]
        rows[A3 + i], rows[A4 + i] = bracket.energy[3:]
        rows[LOW + i], rows[HIGH + i] = bracket.low, bracket.high
        rows[STOPS + i] = 1.0 if bracket.stops else 0.0
        rows[LIMIT + i] = bracket.limit
        rows[SNAPS + i] = 1.0 if bracket.snaps else 0.0


@_loop
def begin(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Guess the roots."""
    for i in range(BLOCK):
        bracket = search_of(rows, i)
        rows[W + i] = guess(bracket.energy, bracket.low, bracket.high)


@_loop
def step(rows, steps):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Step towards the roots."""
    for _ in range(steps):
        for i in range(BLOCK):
            bracket, before = search_of(rows, i), rows[W + i]
            rows[W + i] = curvature_step(bracket.energy, before, bracket.low, bracket.high)
            rows[STEP + i] = abs(rows[W + i] - before)


@_loop
def count_unsettled(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return how many roots have not settled."""
    count = 0
    for i in range(BLOCK):
        count += rows[STEP + i] > SETTLED * rows[HIGH + i]
    return count


@_loop
def step_until_settled(rows, rounds):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Step on until the roots have settled; return the number that have not."""
    while rounds > 0 and count_unsettled(rows) > 0:
        for i in range(BLOCK):
            bracket, before, length = search_of(rows, i), rows[W + i], rows[STEP + i]
            after = curvature_step(bracket.energy, before, bracket.low, bracket.high)
            # a settled case does not change, whatever else is in the same block
            moves = length > SETTLED * bracket.high
            rows[W + i] = after if moves else before
            rows[STEP + i] = abs(after - before) if moves else length
        rounds -= 1
    return count_unsettled(rows)


@_loop
def polish(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Take the last Newton step."""
    for i in range(BLOCK):
        energy, root = search_of(rows, i).energy, rows[W + i]
        rows[W + i] = polish_root(energy, root, slope_of(energy, root))


@_loop
def ending(rows, constants, into):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Write the outcomes of the drops into six arrays; NaN outside the domain."""
    slip, peak, pace, heat, energy, outcome = into
    for i in range(BLOCK):
        case = setup_of(rows, i, constants, rows[ROOT + i])
        end = end_of(case, search_of(rows, i), rows[W + i])
        fine = (rows[MASS + i] > 0) & (rows[SPEED + i] >= 0) & (rows[VACUUM + i] >= 0)
        fine = fine & (rows[SPRING + i] > 0) & (rows[GRAVITY + i] >= 0)
        fine = fine & (case.onset + case.enclosure.root >= 0)
        bad = 0.0 if fine else math.nan
        slip[i] = end.slip + bad
        peak[i] = end.peak_force + bad
        pace[i] = end.end_speed + bad
        heat[i] = end.heat + bad
        energy[i] = end.stored + bad
        outcome[i] = end.outcome if fine else algebra.NOT_A_CASE


@_loop
def filling(part, values, stride, first):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Fill in drops of one axis from `first` on, as slices, which the compiler vectorises."""
    n, position, count = len(values), 0, len(part)
    if n == 1:
        _repeat(part, values[0])
        return
    j, offset = (first // stride) % n, first % stride
    while position < count:
        if stride == 1:
            run = min(n - j, count - position)
            _copy(part[position : position + run], values[j : j + run])
            j = 0
        else:
            run = min(stride - offset, count - position)
            _repeat(part[position : position + run], values[j])
            offset, j = 0, (j + 1) % n
        position += run


@cache_threadsafe
def kernel() -> Any:
    """Return the loops, compiled once (a few seconds) and kept on disk.

    They write the results into `out`, set `misses` where the root was not found, and return the
    number of misses.
    """
    parts = (algebra.__file__, compiled.__file__, exact.__file__, __file__)
    stamp = stamp_of(map(Path, parts))

    @compile_loop(nogil=True)
    def run(first, count, axes, constants, out, misses):  # type: ignore[no-untyped-def]
        len(stamp)
        rows, spare, all_lost, outputs = np.empty(ROWS), np.empty((6, ROW)), 0, 0
        buffers = (spare[0], spare[1], spare[2], spare[3], spare[4], spare[5])
        for k in range(6):
            outputs += out[k].size > 0
        for start in range(0, count, BLOCK):
            size = min(BLOCK, count - start)
            for k in range(5):
                # whole blocks only: after the last drop, the grid wraps around
                if start == 0 or len(axes[k].values) > 1:
                    part = rows[k * ROW : k * ROW + BLOCK]
                    filling(part, axes[k].values, axes[k].stride, first + start)
            opening(rows, constants)
            begin(rows)
            step(rows, 3)
            if step_until_settled(rows, ROUNDS):
                for i in range(size):
                    if rows[STEP + i] > SETTLED * rows[HIGH + i]:
                        misses[start + i] = True
                        all_lost += 1
            polish(rows)
            # write directly to the results if all results of a whole block are requested
            straight = size == BLOCK and outputs == 6
            offset, target = (start, out) if straight else (0, buffers)
            end = offset + BLOCK
            into = (
                target[0][offset:end],
                target[1][offset:end],
                target[2][offset:end],
                target[3][offset:end],
            )
            ending(rows, constants, (*into, target[4][offset:end], target[5][offset:end]))
            for k in range(6):
                if out[k].size and not straight:
                    _copy(out[k][start : start + size], buffers[k][:size])
        return all_lost

    return run
