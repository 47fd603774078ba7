"""Which sheet slides when (ours): a stack followed along a history of elongations.

One increment is a weighted one-dimensional fused lasso (`solve`); breaks of static friction,
slack and energy are in `step`, the enclosure's faces in `enclosure`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from layerjam.errors import LayerjamError, ProcedureError, QuantityError
from layerjam.mechanics.compiled import stamp_of
from layerjam.mechanics.stack.enclosure import CHATTER, DEPTH, DONE, OVERFLOW, SNAPPED
from layerjam.mechanics.stack.solve import (
    CAP,
    FORCE,
    HEAT,
    SLACK,
    STORED,
    WORK,
    Stack,
    State,
    Trial,
)
from layerjam.mechanics.stack.step import advance, apart, at_rest, room_for
from layerjam.mechanics.threads import once

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLOCK = 200_000
"""Sheets times increments that are followed before anyone hears of it."""


class StackPull(NamedTuple):
    """What a stack did along N elongations; a housing's walls count as sheets."""

    force: Array
    """(N,) at the crosshead [N]."""
    cap: Array
    """(N,) displacement of the moving cap [m]."""
    sheets: Array
    """(N, n) displacement of each sheet [m]."""
    interface: Array
    """(N, n - 1) force of each interface [N]."""
    slip: Array
    """(N, n - 1) slip of each interface, positive as the brake lengthens [m]."""
    sliding: Flags
    """(N, n - 1) True where the interface slides."""
    faces: Array
    """(N, 2) force of the enclosure's faces [N]."""
    work: Array
    """(N,) work done at the crosshead so far [J]."""
    heat: Array
    """(N,) energy dissipated so far [J]: friction, enclosure, and what breaks of static friction
    release."""
    stored: Array
    """(N,) elastic energy in sheets, mount and enclosure [J]."""
    slack: Flags
    """(N,) True where the crosshead has come closer than the brake is long."""
    snapped: bool
    """True where the mount was too soft to go on; the arrays end before it."""


def kernel_stamp() -> str:
    """What the cache of a loop over stacks is valid for."""
    return stamp_of(Path(__file__).parent.glob("*.py"))


@once
def _follow() -> Any:
    """The loop over a path."""
    stamp = kernel_stamp()

    @numba.njit(cache=True, error_model="numpy")
    def follow(
        path: Array, stack: Stack, state: State, room: tuple[Trial, Flags], made: StackPull
    ) -> tuple[int, int]:  # pragma: no cover
        len(stamp)
        n, (trial, which) = len(stack.springs), room
        for step in range(len(path)):
            code = advance(path[step], stack, state, trial, which)
            if code != DONE:
                return step, code
            values = state.values
            made.force[step], made.cap[step] = values[FORCE], values[CAP]
            made.work[step], made.heat[step] = values[WORK], values[HEAT]
            made.stored[step], made.slack[step] = values[STORED], values[SLACK] > 0.0
            for e in range(2):
                made.faces[step, e] = state.faces.push[e]
            for i in range(n):
                made.sheets[step, i] = state.sheets[i]
            for i in range(n - 1):
                made.interface[step, i] = state.interface[i]
                made.slip[step, i] = -state.past[i] if stack.right[i] else state.past[i]
                made.sliding[step, i] = state.slides[i] != 0
            if apart(stack, state):
                return step + 1, DONE
        return len(path), DONE

    return follow


def check_stack(stack: Stack) -> None:
    """Raise QuantityError for a stack whose arrays do not fit together."""
    n = len(stack.springs)
    each = (stack.friction, stack.ratio, stack.length)
    if n < 2 or len(stack.right) != n or any(len(a) != n - 1 for a in each):
        raise QuantityError(f"stack: {n} sheets need {n - 1} interfaces, at least one")
    if not ((stack.friction >= 0).all() and (stack.ratio >= 1).all()):
        raise QuantityError("stack: friction must not be negative, nor static below kinetic")


def pull_stack(
    path: Array, stack: Stack, progress: Callable[[float], None] | None = None
) -> StackPull:
    """Move the crosshead along `path` [m], shape (N,), from rest; it may turn.

    Tension only: where the crosshead would have to push, the brake stays as it is without load, its
    force is zero, and `slack` says so until the crosshead is back. Whether a single sheet would
    buckle is not asked. The arrays end where no interface overlaps any more, or before the mount is
    too soft to go on. Where interfaces are at rest or slide in one direction, the length of an
    increment changes nothing; where they turn within one, heat is counted for the slip between its
    ends.

    `progress` is called with the share done (0 to 1). Raises QuantityError for a stack whose
    arrays do not fit together and ProcedureError for more nested turns than are remembered.
    """
    check_stack(stack)
    n, count = len(stack.springs), len(path)
    path = np.ascontiguousarray(path, float)
    wide = {"sheets": n, "faces": 2, **dict.fromkeys(("interface", "slip", "sliding"), n - 1)}
    tracks: dict[str, Any] = {
        name: np.zeros(
            (count, wide[name]) if name in wide else count,
            bool if name in ("sliding", "slack") else float,
        )
        for name in StackPull._fields[:-1]
    }
    made = StackPull(**tracks, snapped=False)
    state, room = at_rest(stack), room_for(stack)
    block, done, code = max(1, BLOCK // n), 0, DONE
    while done < count and code == DONE:
        part = slice(done, min(done + block, count))
        steps, code = _follow()(path[part], stack, state, room, _cut(made, part))
        done += steps
        if progress:
            progress(1.0 if done < part.stop else done / count)
        if done < part.stop:
            break
    if code == OVERFLOW:
        raise ProcedureError(
            f"procedure: more than {DEPTH} turns nested in each other; the enclosure remembers no "
            "more"
        )
    if code == CHATTER:
        raise LayerjamError(
            f"stack: static friction breaks and heals without end around {path[done]:.6g} m; take "
            "smaller increments or kinetic friction only"
        )
    if code not in (DONE, SNAPPED):
        raise LayerjamError(
            f"stack: no equilibrium was found at an elongation of {path[done]:.6g} m; please "
            "report this brake"
        )
    return _cut(made, slice(done), code == SNAPPED)


def _cut(made: StackPull, part: slice, snapped: bool = False) -> StackPull:
    """A stretch of the increments."""
    return StackPull(*(track[part] for track in made[:-1]), snapped)  # type: ignore[arg-type]
