"""What comes after the travel is used up: the mass on its rope alone, behind an end that is rigid.

No record says how much the end of a brake's travel gives. One that gives nothing is the worst: the
rope alone stretches on, from what it bears and from the speed that the mass has left (ours).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.record import DropRecord, Outcome

Array = np.ndarray[Any, np.dtype[np.float64]]
SAMPLES = 400


@dataclass(frozen=True)
class Crash:
    """The mass from the end of the travel to its standstill; arrays of shape (N,), SI."""

    time: Array
    """From the taut rope [s]."""
    travel: Array
    """Displacement of the mass from the taut rope [m]."""
    speed: Array
    """Of the mass [m/s]."""
    force: Array
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
    brake, mass = record.brake.brake, record.mass
    decay, square = record.rope_damping / (2 * mass), rope / mass
    sag = record.gravity / square
    drawn = float(record.force[-1]) / float(working_stiffness(brake))
    stretch = float(record.travel[-1] - record.slip[-1]) - drawn
    speed = float(record.speed_of_mass[-1])
    after = _instants(stretch - sag, speed, decay, square)
    place, pace = _swing(after, stretch - sag, speed, decay, square)
    return Crash(
        time=float(record.time[-1]) + after,
        travel=float(record.travel[-1]) + place + sag - stretch,
        speed=pace,
        force=rope * (place + sag) + record.rope_damping * pace,
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


def _instants(start: float, speed: float, decay: float, square: float) -> Array:
    """Seconds from the end of the travel to the standstill, with that of the greatest force."""
    beat = square - decay**2
    if beat <= 0:  # no swing: dense where the damper answers
        slow = square / (decay + math.sqrt(-beat))
        return np.append(0.0, np.geomspace(1e-9, 10.0, 4 * SAMPLES) / slow)
    beat = math.sqrt(beat)
    # v' at the start; v and, a fixed angle before it, the force's own slope pass through zero
    slope = -2 * decay * speed - square * start
    last = math.atan2(speed * beat, -(slope + decay * speed)) / beat
    top = last - 2 * math.asin(decay / math.sqrt(square)) / beat
    return np.unique(np.append(np.linspace(0.0, last, SAMPLES), min(max(top, 0.0), last)))


def _swing(time: Array, start: float, speed: float, decay: float, square: float) -> Any:
    """Place [m], counted from where the weight hangs, and speed [m/s] of a damped swing."""
    beat, push = math.sqrt(abs(square - decay**2)), speed + decay * start
    if beat < 1e-6 * decay:
        fades = np.exp(-decay * time)
        return fades * (start + push * time), fades * (speed - decay * push * time)
    if square > decay**2:
        fades, turn, lift = np.exp(-decay * time), np.cos(beat * time), np.sin(beat * time) / beat
        falls = square * start + decay * speed
        return fades * (start * turn + push * lift), fades * (speed * turn - falls * lift)
    fast, slow = decay + beat, square / (decay + beat)
    late = (speed + fast * start) / (2 * beat) * np.exp(-slow * time)
    soon = -(speed + slow * start) / (2 * beat) * np.exp(-fast * time)
    return late + soon, -slow * late - fast * soon
