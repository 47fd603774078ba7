"""Which sheets move when: a pull sheet by sheet at a few hundred of its elongations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from layerjam.mechanics.stack.pull import StackPull
    from layerjam.simulate.record import TensileRecord

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

EVEN, MOST = 300, 2000
"""Samples spread over the pull, and samples at most, those where an interface changes included."""


@dataclass(frozen=True, kw_only=True)
class SheetMotion:
    """What n sheets and the interfaces between them do at M samples of a pull, in its order.

    The samples are spread evenly over those of the record, and hold those just before and after an
    interface begins or ceases to slide. A housing's walls count as sheets. SI units.
    """

    elongation: Array
    """(M,) of the crosshead [m]."""
    force: Array
    """(M,) at the crosshead [N]."""
    cap: Array
    """(M,) displacement of the moving cap [m]; what the mount stretches is not in it."""
    sheets: Array
    """(M, n) displacement of each sheet [m], away from the cap that is held."""
    slip: Array
    """(M, n - 1) slip of each interface [m], positive as the brake lengthens."""
    sliding: Flags
    """(M, n - 1) True where the interface slides."""
    moving: Flags
    """(n,) True for a sheet that is clamped in the moving cap."""


def motion_of(record: TensileRecord, pull: StackPull) -> SheetMotion:
    """The motion of a pull's sheets, out of all that the stack did."""
    count, sheets = pull.sheets.shape
    walls = sheets - int(record.brake.brake.sheets.count)
    # every second sheet; a wall hangs on the cap opposite to that of the sheet it rubs on
    moving = np.arange(sheets) % 2 != (walls // 2) % 2
    rows = np.linspace(0, count - 1, min(EVEN, count)).astype(int)
    turns = np.flatnonzero((pull.sliding[1:] != pull.sliding[:-1]).any(axis=1))
    if len(turns) > (most := (MOST - EVEN) // 2):
        turns = turns[np.linspace(0, len(turns) - 1, most).astype(int)]
    rows = np.unique(np.concatenate([rows, turns, turns + 1]))
    return SheetMotion(
        elongation=record.elongation[rows],
        force=record.force[rows],
        cap=pull.cap[rows],
        sheets=pull.sheets[rows],
        slip=pull.slip[rows],
        sliding=pull.sliding[rows],
        moving=moving,
    )
