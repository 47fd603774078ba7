"""Metric screws, nuts and clearance holes of the clamp, in mm.

All values were compared with transcriptions of the standards. The sources are FreeCAD's Fasteners
workbench for heads and lengths (ISO 4762) and nuts (ISO 4032), engineersedge for nuts (BS EN ISO
4032:2001) and coarse pitches (ISO 261), and two tables for clearance holes (ISO 273).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

LENGTHS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60)
"""Screw lengths on sale (ISO 888)."""


@dataclass(frozen=True)
class Thread:
    """One size of screw, nut and hole [mm]."""

    size: float
    """Nominal diameter of the thread, which has the coarse pitch (ISO 261)."""
    pitch: float
    head: float
    """Diameter of the head (dk of a plain, unknurled head in ISO 4762)."""
    head_height: float
    nut: float
    """Width across flats of the nut (ISO 4032)."""
    nut_height: float
    """Maximum height of the nut."""
    close: float
    """Diameter of the fine clearance hole (ISO 273)."""
    clearance: float
    """Diameter of the medium clearance hole."""
    shortest: int
    """Shortest length of the screw in ISO 4762."""
    longest: int
    """Longest length in ISO 4762; longer screws are hard to find."""
    key: float
    """Size of the hex key."""

    @property
    def name(self) -> str:
        """Designation, such as M3."""
        return f"M{self.size:g}"

    @property
    def stress_area(self) -> float:
        """Stress area of the thread [mm²], from the mean of pitch diameter and minor diameter.

        It is pi/4 ((d2 + d3)/2)^2 (ISO 898-1), with d2 = d - 3/8 sqrt(3) P and d3 = d - 17/24
        sqrt(3) P.
        """
        mean = self.size - (3 / 8 + 17 / 24) / 2 * math.sqrt(3) * self.pitch
        return math.pi / 4 * mean**2


THREADS = (
    Thread(2, 0.4, 3.8, 2, 4, 1.6, 2.2, 2.4, 3, 20, 1.5),
    Thread(2.5, 0.45, 4.5, 2.5, 5, 2, 2.7, 2.9, 4, 25, 2),
    Thread(3, 0.5, 5.5, 3, 5.5, 2.4, 3.2, 3.4, 5, 30, 2.5),
    Thread(4, 0.7, 7, 4, 7, 3.2, 4.3, 4.5, 6, 40, 3),
    Thread(5, 0.8, 8.5, 5, 8, 4.7, 5.3, 5.5, 8, 50, 4),
    Thread(6, 1, 10, 6, 10, 5.2, 6.4, 6.6, 8, 60, 5),
)


def find_thread(hole: float) -> Thread | None:
    """Return the largest thread that passes through a sheet's hole [mm]; None if none does."""
    return max(
        (t for t in THREADS if t.size <= hole * (1 + 1e-9)), key=lambda t: t.size, default=None
    )


def find_screw_length(min_length: Any, thread: Thread) -> Any:
    """Return the shortest screw length on sale from `min_length` [mm]; NaN above 60 mm."""
    min_length = np.maximum(min_length, thread.shortest) * (1 - 1e-12)
    return np.array([*LENGTHS, np.nan])[np.searchsorted(LENGTHS, min_length)]
