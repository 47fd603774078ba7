"""Stop of a mass by a brake, exact where that is possible, otherwise integrated in time."""

from collections.abc import Callable

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.drop import TimedStop, drop
from layerjam.brake.simulate.record import DropRecord
from layerjam.brake.simulate.vacuum_history import History


def simulate_stop(
    file: BrakeFile,
    *,
    mass: float,
    speed: float,
    vacuum: float | History,
    rope_stiffness: float | None = None,
    rope_damping: float = 0.0,
    gravity: float | None = None,
    duration: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[TimedStop, DropRecord]:
    """Stop a mass [kg] that arrives with `speed` [m/s]; all in SI.

    At one vacuum [Pa], without damping [N s/m] and without a `duration` [s], the result is that of
    `drop`, in closed form. Otherwise it is that of `drop_in_time`, with its progress. Raises the
    errors of both.
    """
    if not (isinstance(vacuum, History) or rope_damping or duration is not None):
        return drop(
            file,
            mass=mass,
            speed=speed,
            vacuum=vacuum,
            rope_stiffness=rope_stiffness,
            gravity=gravity,
        )
    from layerjam.brake.simulate.drop_in_time import drop_in_time

    return drop_in_time(
        file,
        mass=mass,
        speed=speed,
        vacuum=vacuum,
        rope_stiffness=rope_stiffness,
        rope_damping=rope_damping,
        gravity=gravity,
        duration=duration,
        progress=progress,
    )
