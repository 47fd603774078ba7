"""Metric screws, nuts and clearance holes of the clamp, in mm."""

from __future__ import annotations

from dataclasses import dataclass

LENGTHS = (4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60)
"""Screw lengths that are sold (ISO 888)."""


@dataclass(frozen=True)
class Thread:
    """One size: screw head of ISO 4762, nut of ISO 4032, medium clearance hole of ISO 273 [mm]."""

    size: float
    head: float
    """Diameter of the head."""
    head_height: float
    nut: float
    """Width across flats of the nut."""
    nut_height: float
    clearance: float
    """Diameter of the clearance hole."""

    @property
    def name(self) -> str:
        """As a shop calls it, M3."""
        return f"M{self.size:g}"


THREADS = (
    Thread(2, 3.8, 2, 4, 1.6, 2.4),
    Thread(2.5, 4.5, 2.5, 5, 2, 2.9),
    Thread(3, 5.5, 3, 5.5, 2.4, 3.4),
    Thread(4, 7, 4, 7, 3.2, 4.5),
    Thread(5, 8.5, 5, 8, 4.7, 5.5),
    Thread(6, 10, 6, 10, 5.2, 6.6),
)


def thread_for(hole: float) -> Thread | None:
    """The largest thread that goes through a hole of the sheets [mm]; None below M2."""
    return max(
        (t for t in THREADS if t.size <= hole * (1 + 1e-9)), key=lambda t: t.size, default=None
    )


def length_for(least: float) -> int | None:
    """The shortest screw that is sold of at least some length [mm]; None above 60 mm."""
    return next((length for length in LENGTHS if length >= least * (1 - 1e-12)), None)
