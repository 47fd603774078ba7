"""What comes after the travel is used up: the mass on its rope alone, behind an end that is rigid.

No record says how much the end of a brake's travel gives. One that gives nothing is the worst: the
rope alone stretches on, from what it bears and from the speed that the mass has left (ours).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.rope_alone import course, damped, standstill, time_of_peak

Array = np.ndarray[Any, np.dtype[np.float64]]
SAMPLES = 400


@dataclass(frozen=True)
class Crash:
    """The mass from the end of the travel to its standstill; arrays of shape (N,), SI."""

    time: Array = field(repr=False)
    """From the taut rope [s]."""
    travel: Array = field(repr=False)
    """Displacement of the mass from the taut rope [m]."""
    speed: Array = field(repr=False)
    """Of the mass [m/s]."""
    force: Array = field(repr=False)
    """Of the rope on the mass [N]."""

    @property
    def peak_force(self) -> float:
        """Greatest force [N]."""
        return float(self.force.max())


def crash(record: DropRecord) -> Crash | None:
    """How a drop goes on that BOTTOMED_OUT, at an end that does not give; None for other drops.

    None without a rope too: then nothing is known that gives, and the force has no bound. Up to the
    first standstill, or until an overdamped rope has all but brought the mass to rest.
    """
    rope = record.rope_stiffness
    if record.outcome is not Outcome.BOTTOMED_OUT or rope is None:
        return None
    mass, damping = record.mass, record.rope_damping
    of = damped(mass, rope, damping)
    sag = record.gravity / of.stiff
    drawn = float(record.force[-1]) / float(working_stiffness(record.brake.brake))
    stretch = float(record.travel[-1] - record.slip[-1]) - drawn
    speed = float(record.speed_of_mass[-1])
    # as if the weight were less by what the rope bears already: that hangs `sag - stretch` lower
    left = of.stiff * (sag - stretch)
    if of.square <= 0:  # no swing: dense where the damper answers
        slow = of.stiff / (of.decay + math.sqrt(-of.square))
        after = np.append(0.0, np.geomspace(1e-9, 10.0, 4 * SAMPLES) / slow)
    else:
        stands = standstill(mass, speed, rope, damping, left)
        top = time_of_peak(mass, speed, of, left, stands)
        after = np.unique(np.append(np.linspace(0.0, stands, SAMPLES), top))
    place = course(after, stretch - sag, speed, of)
    pace = course(after, speed, left - 2 * of.decay * speed, of)
    return Crash(
        time=float(record.time[-1]) + after,
        travel=float(record.travel[-1]) + place + sag - stretch,
        speed=pace,
        force=rope * (place + sag) + damping * pace,
    )


def with_crash(record: DropRecord, found: Crash) -> DropRecord:
    """The drop with what comes after the end of its travel: the brake stays as it is."""
    after: dict[str, Array] = {
        "time": found.time,
        "travel": found.travel,
        "speed_of_mass": found.speed,
        "force": found.force,
    }
    for name in ("slip", "vacuum_in_time", "dissipated_energy"):
        after[name] = np.full(len(found.time), getattr(record, name)[-1])
    whole: dict[str, Any] = {
        name: np.append(getattr(record, name), column[1:]) for name, column in after.items()
    }
    return replace(record, **whole)
