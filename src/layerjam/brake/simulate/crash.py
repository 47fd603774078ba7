"""Motion after the travel is used up: the mass on its rope alone, against a rigid end.

No source states the compliance at the end of a brake's travel. layerjam assumes the worst case, a
rigid end: only the rope stretches further, starting from its force and the mass's remaining speed.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.rope_alone import (
    displacement,
    make_oscillator,
    peak_time,
    standstill_time,
)
from layerjam.core.evolve import evolve

Array = np.ndarray[Any, np.dtype[np.float64]]
SAMPLES = 400


@dataclass(frozen=True)
class Crash:
    """Motion of the mass from the end of the travel to its standstill; arrays of shape (N,), SI."""

    time: Array = field(repr=False)
    """Time since the rope became taut [s]."""
    displacement: Array = field(repr=False)
    """Displacement of the mass since the rope became taut [m]."""
    speed: Array = field(repr=False)
    """Speed of the mass [m/s]."""
    force: Array = field(repr=False)
    """Return the force of the rope on the mass [N]."""

    @property
    def travel(self) -> Array:
        """Former name of `displacement`."""
        return self.displacement

    @property
    def peak_force(self) -> float:
        """Largest force [N]."""
        return float(self.force.max())


def crash(record: DropRecord) -> Crash | None:
    """Return the motion after a drop that BOTTOMED_OUT on a rigid end; None for other drops.

    Also None without a rope, because the force then has no known bound. It lasts up to the first
    standstill, or until an overdamped rope has practically brought the mass to rest.
    """
    rope = record.rope_stiffness
    if record.outcome is not Outcome.BOTTOMED_OUT or rope is None:
        return None
    mass, damping = record.mass, record.rope_damping
    system = make_oscillator(mass, rope, damping)
    sag = record.gravity / system.stiff
    brake_stretch = float(record.force[-1]) / float(working_stiffness(record.brake.brake))
    stretch = float(record.displacement[-1] - record.slip[-1]) - brake_stretch
    speed = float(record.speed_of_mass[-1])
    # the weight minus the rope's force; in equilibrium the mass is `sag - stretch` lower
    force_left = system.stiff * (sag - stretch)
    if system.square <= 0:  # there is no swing, so sample densely within the damper's response time
        slow_rate = system.stiff / (system.decay + math.sqrt(-system.square))
        swing_times = np.append(0.0, np.geomspace(1e-9, 10.0, 4 * SAMPLES) / slow_rate)
    else:
        stands = standstill_time(mass, speed, rope, damping, force_left)
        top = peak_time(mass, speed, system, force_left, stands)
        swing_times = np.unique(np.append(np.linspace(0.0, stands, SAMPLES), top))
    place = displacement(swing_times, stretch - sag, speed, system)
    pace = displacement(swing_times, speed, force_left - 2 * system.decay * speed, system)
    return Crash(
        time=float(record.time[-1]) + swing_times,
        displacement=float(record.displacement[-1]) + place + sag - stretch,
        speed=pace,
        force=rope * (place + sag) + damping * pace,
    )


def append_crash(record: DropRecord, motion: Crash) -> DropRecord:
    """Return the drop, extended by the motion after the end of the travel; the brake is still."""
    crash_columns: dict[str, Array] = {
        "time": motion.time,
        "displacement": motion.displacement,
        "speed_of_mass": motion.speed,
        "force": motion.force,
    }
    for name in ("slip", "vacuum_in_time", "dissipated_energy"):
        crash_columns[name] = np.full(len(motion.time), getattr(record, name)[-1])
    columns: dict[str, Any] = {
        name: np.append(getattr(record, name), column[1:]) for name, column in crash_columns.items()
    }
    return evolve(record, **columns)
