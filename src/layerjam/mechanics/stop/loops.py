"""Millions of exact stops: the algebra of a stop as machine-code loops over all cores.

A block of drops goes through short loops, one for each part of the algebra; what they hand on lies
in rows that stay in the fastest cache. One long loop is slower: in a drop each root waits for the
one before, and the processor cannot look so far ahead that it begins the next drops meanwhile.
"""

import math
from pathlib import Path
from typing import Any

import numba
import numpy as np

from layerjam.mechanics import compiled
from layerjam.mechanics.compiled import scalar, stamp_of
from layerjam.mechanics.enclosure import EnclosureLaw
from layerjam.mechanics.stop import algebra, exact
from layerjam.mechanics.threads import once

BLOCK = 128
"""Drops in one piece of work, whose rows stay in the fastest cache."""
ROW = BLOCK + 8
"""From one row to the next; rows a power of two apart would share few lines of the cache."""
ROUNDS = 5
"""More steps of the root's search, at most, for the drops that three have not settled."""
# where each row begins: the drop, and what the loops hand on
MASS, SPEED, VACUUM, SPRING, GRAVITY = range(0, 5 * ROW, ROW)
ROOT, A0, A1, A2, A3, A4, LOW, HIGH, STOPS, FAR, SNAPS, W, STEP = range(5 * ROW, 18 * ROW, ROW)
ROWS = 18 * ROW
SETTLED = exact.SETTLED
setup, search, end_of = scalar(algebra.setup), scalar(algebra.search), scalar(algebra.end_of)
guess, curved = scalar(algebra.guess), scalar(algebra.curved)
polished, slope_of = scalar(algebra.polished), scalar(algebra.slope_of)


def _inlined(function: Any) -> Any:
    return numba.njit(error_model="numpy", forceinline=True, fastmath={"contract"})(function)


def _loop(function: Any) -> Any:
    return numba.njit(error_model="numpy", fastmath={"contract"})(function)


@_loop
def _copy(into, given):  # type: ignore[no-untyped-def]  # pragma: no cover
    for i in range(len(into)):
        into[i] = given[i]


@_loop
def _repeat(into, value):  # type: ignore[no-untyped-def]  # pragma: no cover
    for i in range(len(into)):
        into[i] = value


@_inlined
def setup_of(rows, i, of, root):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return the constants of drop i of a block."""
    vacuum, ea, reach = rows[VACUUM + i], of.stiffness, of.reach
    saturation = of.drag * reach * reach / ea * vacuum
    enclosure = EnclosureLaw(ea, of.drag * vacuum, reach, root, saturation)
    mass, speed, c = rows[MASS + i], rows[SPEED + i], of.friction * vacuum
    return setup(mass, speed, c, of.overlap, enclosure, rows[SPRING + i], rows[GRAVITY + i])


@_inlined
def search_of(rows, i):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return what the first loops have found of drop i of a block."""
    energy = algebra.Quartic(rows[A0 + i], rows[A1 + i], rows[A2 + i], rows[A3 + i], rows[A4 + i])
    low, high, far = rows[LOW + i], rows[HIGH + i], rows[FAR + i]
    return algebra.Search(energy, low, high, rows[STOPS + i] > 0, far, rows[SNAPS + i] > 0)


@_loop
def opening(rows, of):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Find between which slips the roots lie, and as which quartic."""
    for i in range(BLOCK):
        root = 2 * math.sqrt(of.stiffness * of.drag * rows[VACUUM + i])
        found = search(setup_of(rows, i, of, root), of.travel)
        rows[ROOT + i] = root
        rows[A0 + i], rows[A1 + i], rows[A2 + i] = found.energy[:3]
        rows[A3 + i], rows[A4 + i] = found.energy[3:]
        rows[LOW + i], rows[HIGH + i] = found.low, found.high
        rows[STOPS + i] = 1.0 if found.stops else 0.0
        rows[FAR + i] = found.far
        rows[SNAPS + i] = 1.0 if found.snaps else 0.0


@_loop
def begin(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Guess the roots."""
    for i in range(BLOCK):
        at = search_of(rows, i)
        rows[W + i] = guess(at.energy, at.low, at.high)


@_loop
def step(rows, steps):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Step towards the roots."""
    for _ in range(steps):
        for i in range(BLOCK):
            at, before = search_of(rows, i), rows[W + i]
            rows[W + i] = curved(at.energy, before, at.low, at.high)
            rows[STEP + i] = abs(rows[W + i] - before)


@_loop
def unsettled(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return how many roots have not settled."""
    some = 0
    for i in range(BLOCK):
        some += rows[STEP + i] > SETTLED * rows[HIGH + i]
    return some


@_loop
def again(rows, rounds):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Step on until the roots have settled; return how many have not."""
    while rounds > 0 and unsettled(rows) > 0:
        for i in range(BLOCK):
            at, before, length = search_of(rows, i), rows[W + i], rows[STEP + i]
            after = curved(at.energy, before, at.low, at.high)
            # what has settled stays as it is, whatever is in the same block
            moves = length > SETTLED * at.high
            rows[W + i] = after if moves else before
            rows[STEP + i] = abs(after - before) if moves else length
        rounds -= 1
    return unsettled(rows)


@_loop
def polish(rows):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Take the last Newton step."""
    for i in range(BLOCK):
        energy, root = search_of(rows, i).energy, rows[W + i]
        rows[W + i] = polished(energy, root, slope_of(energy, root))


@_loop
def ending(rows, of, into):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Write how the drops end into six arrays; NaN for what is not a case."""
    slip, peak, pace, heat, stored, outcome = into
    for i in range(BLOCK):
        at = setup_of(rows, i, of, rows[ROOT + i])
        end = end_of(at, search_of(rows, i), rows[W + i])
        fine = (rows[MASS + i] > 0) & (rows[SPEED + i] >= 0) & (rows[VACUUM + i] >= 0)
        fine = fine & (rows[SPRING + i] > 0) & (rows[GRAVITY + i] >= 0)
        fine = fine & (at.onset + at.enclosure.root >= 0)
        bad = 0.0 if fine else math.nan
        slip[i] = end.slip + bad
        peak[i] = end.peak_force + bad
        pace[i] = end.end_speed + bad
        heat[i] = end.heat + bad
        stored[i] = end.stored + bad
        outcome[i] = end.outcome if fine else algebra.NOT_A_CASE


@_loop
def filling(part, values, stride, first):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Fill in drops from `first` on of one axis; slices, which the compiler vectorises."""
    n, done, count = len(values), 0, len(part)
    if n == 1:
        _repeat(part, values[0])
        return
    j, rest = (first // stride) % n, first % stride
    while done < count:
        if stride == 1:
            run = min(n - j, count - done)
            _copy(part[done : done + run], values[j : j + run])
            j = 0
        else:
            run = min(stride - rest, count - done)
            _repeat(part[done : done + run], values[j])
            rest, j = 0, (j + 1) % n
        done += run


@once
def kernel() -> Any:
    """The loops, compiled once (a few seconds) and kept on disk: how many of `lost` they set.

    They write into what they are given of `out` and set `lost` where the root was not found.
    """
    parts = (algebra.__file__, compiled.__file__, exact.__file__, __file__)
    stamp = stamp_of(map(Path, parts))

    @numba.njit(nogil=True, cache=True)  # type: ignore[untyped-decorator]
    def run(first, count, axes, of, out, lost):  # type: ignore[no-untyped-def]
        len(stamp)
        rows, spare, all_lost, wanted = np.empty(ROWS), np.empty((6, ROW)), 0, 0
        kept = (spare[0], spare[1], spare[2], spare[3], spare[4], spare[5])
        for k in range(6):
            wanted += out[k].size > 0
        for start in range(0, count, BLOCK):
            size = min(BLOCK, count - start)
            for k in range(5):
                # whole blocks only: past the last drop the grid begins again
                if start == 0 or len(axes[k].values) > 1:
                    part = rows[k * ROW : k * ROW + BLOCK]
                    filling(part, axes[k].values, axes[k].stride, first + start)
            opening(rows, of)
            begin(rows)
            step(rows, 3)
            if again(rows, ROUNDS):
                for i in range(size):
                    if rows[STEP + i] > SETTLED * rows[HIGH + i]:
                        lost[start + i] = True
                        all_lost += 1
            polish(rows)
            # straight to where the results belong, if all of a whole block are wanted
            straight = size == BLOCK and wanted == 6
            at, to = (start, out) if straight else (0, kept)
            end = at + BLOCK
            into = (to[0][at:end], to[1][at:end], to[2][at:end], to[3][at:end])
            ending(rows, of, (*into, to[4][at:end], to[5][at:end]))
            for k in range(6):
                if out[k].size and not straight:
                    _copy(out[k][start : start + size], kept[k][:size])
        return all_lost

    return run
