"""Motion of the sheets in a sheet-by-sheet pull, at a few hundred elongations."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from layerjam.brake.mechanics.stack.history import StackPull
    from layerjam.brake.simulate.record import TensileRecord

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

EVEN, MAX_SAMPLES = 300, 2000
"""Number of evenly spread samples, and maximum number with those at changes of interfaces."""


@dataclass(frozen=True, kw_only=True)
class SheetMotion:
    """Motion of n sheets and the interfaces between them at M samples of a pull, in order.

    The samples are spread evenly over those of the record, and include those just before and after
    an interface starts or stops sliding. Walls of a housing count as sheets. Values are in SI
    units.
    """

    elongation: Array
    """(M,) elongation at the crosshead [m]."""
    force: Array
    """(M,) force at the crosshead [N]."""
    cap: Array
    """(M,) displacement of the moving cap [m], without the stretch of the mount."""
    sheets: Array
    """(M, n) displacement of each sheet [m], away from the fixed cap."""
    slip: Array
    """(M, n - 1) slip of each interface [m], positive as the brake lengthens."""
    sliding: Flags
    """(M, n - 1) True if the interface slides."""
    moving: Flags
    """(n,) True for a sheet clamped in the moving cap."""


def sheet_motion(record: "TensileRecord", pull: "StackPull") -> SheetMotion:
    """Return the motion of a pull's sheets from all samples of the stack."""
    count, sheets = pull.sheets.shape
    walls = sheets - int(record.brake.brake.sheets.count)
    # every second sheet moves; a wall moves with the cap opposite that of the sheet it rubs on
    moving = np.arange(sheets) % 2 != (walls // 2) % 2
    rows = np.linspace(0, count - 1, min(EVEN, count)).astype(int)
    turns = np.flatnonzero((pull.sliding[1:] != pull.sliding[:-1]).any(axis=1))
    if len(turns) > (limit := (MAX_SAMPLES - EVEN) // 2):
        turns = turns[np.linspace(0, len(turns) - 1, limit).astype(int)]
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
