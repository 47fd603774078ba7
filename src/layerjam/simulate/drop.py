"""A mass falls on the brake (paper, section III-E): constant vacuum, exact.

Time counts from the taut rope. Without a brake the mass hangs on the rope alone.
"""

from __future__ import annotations

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.mechanics.energy import slip_heat
from layerjam.mechanics.pull import brake_force, least_stiffness, peak
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    SNAPS,
    STOPPED,
    Stop,
    speed_at_slip,
    stop,
    time_at_slip,
)
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.units import show

OUTCOMES = {
    STOPPED: Outcome.STOPPED,
    NEVER_SLID: Outcome.NEVER_SLID,
    BOTTOMED_OUT: Outcome.BOTTOMED_OUT,
    SNAPS: Outcome.SNAPS,
}
SAMPLES = 400


def spring_of(brake: Brake, rope_stiffness: float | None) -> float:
    """Rope and brake in series [N/m]."""
    own = float(working_stiffness(brake))
    return own if rope_stiffness is None else 1 / (1 / own + 1 / rope_stiffness)


def snap_reason(
    spring: float, slip: float, vacuum: float, brake: Brake, damped: bool = False
) -> str:
    """Why the brake snapped at a slip [m] and a vacuum [Pa] on a spring [N/m], and what is safe."""
    least = show(float(least_stiffness(vacuum, brake)), "N/m")
    what = "the brake gives" if damped else "rope and brake together give"
    return (
        f"{what} {show(spring, 'N/m')}; at {show(slip, 'm')} of slip the force of the sliding "
        f"brake falls faster than that, and it snaps. {least} or more cannot snap at any slip"
    )


def ran_out(speed: float, brake: Brake) -> str:
    """What to say of a mass that is still moving [m/s] at the end of the travel."""
    travel = show(brake.sheets.usable_travel, "m")
    return f"the brake ran out of its {travel} with the mass at {show(speed, 'm/s')}"


def drop(
    file: BrakeFile,
    *,
    mass: float,
    speed: float,
    vacuum: float,
    rope_stiffness: float | None = None,
    gravity: float | None = None,
) -> tuple[Stop, DropRecord]:
    """Stop a mass [kg] that arrives with `speed` [m/s] at a constant vacuum [Pa].

    `gravity` [m/s^2] acts along the pull; the site's unless given, 0 for a horizontal stop. The
    first result is the exact Stop (numbers), the second its record. The outcome is STOPPED,
    NEVER_SLID, BOTTOMED_OUT (the travel was used up, the mass still moving) or SNAPS.
    """
    brake = file.brake
    pull = brake.site.gravity if gravity is None else gravity
    spring = spring_of(brake, rope_stiffness)
    case = (mass, speed, vacuum, spring, pull, brake)
    raw = stop(*case)
    result = Stop(*(float(v) for v in raw))
    outcome = OUTCOMES[int(result.outcome)]
    warnings = list(file.warnings())
    if outcome is Outcome.SNAPS:
        warnings.append(snap_reason(spring, result.slip, vacuum, brake))
    if outcome is Outcome.BOTTOMED_OUT:
        warnings.append(ran_out(result.end_speed, brake))
    return result, _record(file, result, outcome, case, rope_stiffness, warnings)


def _record(
    file: BrakeFile,
    result: Stop,
    outcome: Outcome,
    case: tuple[float, float, float, float, float, Brake],
    rope_stiffness: float | None,
    warnings: list[str],
) -> DropRecord:
    """Samples of the elastic part, equally spaced in time, then of the sliding one."""
    mass, speed, vacuum, spring, gravity, brake = case
    first = float(time_at_slip(0.0, *case))
    omega = (spring / mass) ** 0.5
    time = np.linspace(0, first, SAMPLES // 4 + 1)
    sag, swing = gravity / omega**2, speed / omega
    travel = sag * (1 - np.cos(omega * time)) + swing * np.sin(omega * time)
    moving = sag * omega * np.sin(omega * time) + speed * np.cos(omega * time)
    slip = np.zeros_like(time)
    force, heat = spring * travel, np.zeros_like(time)
    if result.slip > 0:
        # dense at both ends, where the force bends and the speed falls away; as many with the
        # peak as without, or the laws would be compiled for both
        top = _peak_share(result.slip, vacuum, brake)
        share = np.sin(np.linspace(0, np.pi / 2, SAMPLES + 1 - len(top))[1:]) ** 2
        slid = result.slip * np.unique(np.append(share, top))
        resist = np.asarray(brake_force(slid, vacuum, brake))
        time = np.append(time, np.asarray(time_at_slip(slid, *case)))
        moving = np.append(moving, np.asarray(speed_at_slip(slid, *case)))
        travel = np.append(travel, slid + resist / spring)
        slip, force = np.append(slip, slid), np.append(force, resist)
        heat = np.append(heat, np.asarray(slip_heat(slid, vacuum, brake)))
    return DropRecord(
        time=time,
        travel=travel,
        speed_of_mass=moving,
        force=force,
        slip=slip,
        vacuum_in_time=np.full_like(time, vacuum),
        dissipated_energy=heat,
        mass=mass,
        speed=speed,
        vacuum=vacuum,
        rope_stiffness=rope_stiffness,
        gravity=gravity,
        outcome=outcome,
        brake=file,
        warnings=tuple(warnings),
    )


def _peak_share(slip: float, vacuum: float, brake: Brake) -> list[float]:
    """Where the greatest force lies, as a part of the whole slip."""
    top = float(peak(vacuum, brake.sheets.usable_travel, brake).slip)
    return [top / slip] if 0 < top < slip else []
