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
from layerjam.mechanics.stop import (
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


def rope_only(mass: float, speed: float, spring: float, gravity: float) -> tuple[float, float]:
    """Peak force [N] and time to the first standstill [s] of a mass on a spring alone."""
    weight, omega = mass * gravity, (spring / mass) ** 0.5
    force = weight + (weight**2 + spring * mass * speed**2) ** 0.5
    phase = float(np.arctan2(gravity / omega**2, speed / omega))
    return force, (np.pi / 2 + phase) / omega


def damped_rope_only(
    mass: float, speed: float, spring: float, damping: float, gravity: float
) -> tuple[float, float, float]:
    """Peak force [N], time to the first standstill [s] and heat [J] of a mass on a damped rope."""
    from scipy.integrate import quad
    from scipy.optimize import brentq, minimize_scalar

    omega = (spring / mass) ** 0.5
    # z = sag + Re(...) of the two complex modes, which coincide only at critical damping exactly
    decay = damping / (2 * mass)
    swing = np.sqrt(complex(omega**2 - decay**2)) or 1e-8 * omega
    modes = np.array([-decay + 1j * swing, -decay - 1j * swing])
    sag = gravity / omega**2
    parts = np.linalg.solve(np.array([[1, 1], modes]), np.array([-sag, speed]))

    def place(time: float, order: int) -> float:
        value = (parts * modes**order * np.exp(modes * time)).sum().real
        return float(value) + (sag if order == 0 else 0.0)

    end = 1 / omega
    while place(end, 1) > 0:
        end *= 1.5
    time = brentq(lambda t: place(t, 1), 0.0, end, xtol=1e-16, rtol=1e-14)
    grid = np.linspace(0, time, 2001)
    pull = np.array([spring * place(t, 0) + damping * place(t, 1) for t in grid])
    top = int(np.argmax(pull))
    around = (grid[max(top - 1, 0)], grid[min(top + 1, 2000)])
    best = minimize_scalar(
        lambda t: -(spring * place(t, 0) + damping * place(t, 1)), bounds=around, method="bounded",
        options={"xatol": 1e-12},
    )  # fmt: skip
    force = max(float(pull[top]), -float(best.fun))
    heat, _ = quad(lambda t: damping * place(t, 1) ** 2, 0, time, epsabs=0, epsrel=1e-12)
    return force, time, heat


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

    `gravity` [m/s^2] acts along the pull; the site's unless given, 0 for a horizontal stop. Gives
    the exact Stop (numbers) and a record sampled along the way. The outcome is STOPPED, NEVER_SLID,
    BOTTOMED_OUT (the travel was used up, the mass still moving) or SNAPS.
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
        least = show(float(least_stiffness(vacuum, brake)), "N/m")
        warnings.append(
            f"rope and brake together give {show(spring, 'N/m')}; the sliding brake softens faster "
            f"and snaps. Needed is more than {least}"
        )
    if outcome is Outcome.BOTTOMED_OUT:
        warnings.append(
            f"the brake ran out of its {show(brake.sheets.usable_travel, 'm')} with the mass at "
            f"{show(result.end_speed, 'm/s')}"
        )
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
        # dense at both ends, where the force bends and the speed falls away
        share = np.sin(np.linspace(0, np.pi / 2, SAMPLES + 1)[1:]) ** 2
        slid = result.slip * np.unique(np.append(share, _peak_share(result.slip, vacuum, brake)))
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
