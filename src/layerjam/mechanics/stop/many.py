"""Millions of exact stops: the algebra of a stop as one machine-code loop over all cores."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import EnclosureLaw, enclosure_at
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.stop import algebra
from layerjam.mechanics.stop.exact import SETTLED
from layerjam.mechanics.threads import once

BLOCK = 512
"""Drops in one piece of work, whose arrays stay in the fastest cache."""
Array = np.ndarray[Any, Any]


class Axis(NamedTuple):
    """One quantity over a flat grid: drop i has `values[(i // stride) % len(values)]`."""

    values: Array
    stride: int


class Constants(NamedTuple):
    """What the loop needs of a brake; SI."""

    friction: float
    """c per pascal [N/m/Pa]."""
    drag: float
    """q per pascal [N/m/Pa]."""
    overlap: float
    travel: float
    stiffness: float
    reach: float


def constants_of(brake: Brake) -> Constants | None:
    """The constants of a brake; None where friction is no straight line over slip and vacuum."""
    bent = (brake.pressure_exponent, brake.speed_law, brake.mount.spacers)
    if any(part is not None for part in bent):
        return None
    enclosure = enclosure_at(1.0, brake)
    sheets, c = brake.sheets, friction_per_contact(1.0, brake)
    values = (c, enclosure.friction, sheets.overlap, sheets.usable_travel)
    return Constants(*(float(v) for v in (*values, enclosure.stiffness, enclosure.reach)))


def _fill(part, count, values, stride, first):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Drops from `first` on of one axis."""
    n, done = len(values), 0
    if n == 1:
        for i in range(count):
            part[i] = values[0]
        return
    j, rest = (first // stride) % n, first % stride
    while done < count:
        if stride == 1:
            run = min(n - j, count - done)
            for i in range(run):
                part[done + i] = values[j + i]
            j = 0
        else:
            run = min(stride - rest, count - done)
            same = values[j]
            for i in range(run):
                part[done + i] = same
            rest, j = 0, (j + 1) % n
        done += run


@once
def kernel() -> Any:
    """The loop, compiled on first use (a few seconds)."""
    import numba

    from layerjam.mechanics.compiled import scalar

    setup, search, guess = scalar(algebra.setup), scalar(algebra.search), scalar(algebra.guess)
    curved, polished = scalar(algebra.curved), scalar(algebra.polished)
    fill = numba.njit(_fill)
    slope_of, end_of = scalar(algebra.slope_of), scalar(algebra.end_of)

    @numba.njit(error_model="numpy", fastmath={"contract"})  # type: ignore[untyped-decorator]
    def block(drops, count, of, ends, settled):  # type: ignore[no-untyped-def]
        mass, speed, vacuum, spring, gravity = drops
        slip, peak, pace, heat, stored, outcome = ends
        for i in range(count):
            q, ea, reach = of.drag * vacuum[i], of.stiffness, of.reach
            enclosure = EnclosureLaw(ea, q, reach, 2 * math.sqrt(ea * q), q * reach * reach / ea)
            m, v, c = mass[i], speed[i], of.friction * vacuum[i]
            at = setup(m, v, c, of.overlap, enclosure, spring[i], gravity[i])
            found = search(at, of.travel)
            energy, low, high = found.energy, found.low, found.high
            before = guess(energy, low, high)
            before = curved(energy, before, low, high)
            before = curved(energy, before, low, high)
            root = curved(energy, before, low, high)
            settled[i] = not abs(root - before) > SETTLED * high
            root = polished(energy, root, slope_of(energy, root))
            end = end_of(at, found, root, of.travel)
            fine = (m > 0) & (v >= 0) & (vacuum[i] >= 0)
            fine = fine & (spring[i] > 0) & (gravity[i] >= 0)
            fine = fine & (at.onset + enclosure.root >= 0)
            bad = 0.0 if fine else math.nan
            slip[i] = end.slip + bad
            peak[i] = end.peak_force + bad
            pace[i] = end.end_speed + bad
            heat[i] = end.heat + bad
            stored[i] = end.stored + bad
            outcome[i] = end.outcome if fine else algebra.NOT_A_CASE

    @numba.njit(nogil=True)  # type: ignore[untyped-decorator]
    def run(first, count, axes, of, out, settled):  # type: ignore[no-untyped-def]
        for piece in range((count + BLOCK - 1) // BLOCK):
            start = piece * BLOCK
            size = min(BLOCK, count - start)
            part, made = np.empty((5, BLOCK)), np.empty((6, BLOCK))
            for k in range(5):
                fill(part[k], size, axes[k].values, axes[k].stride, first + start)
            drops = (part[0], part[1], part[2], part[3], part[4])
            ends = (made[0], made[1], made[2], made[3], made[4], made[5])
            block(drops, size, of, ends, settled[start:])
            for k in range(6):
                if out[k].size:
                    for i in range(size):
                        out[k][start + i] = made[k, i]

    return run
