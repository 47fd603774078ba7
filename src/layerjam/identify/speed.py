"""Friction of a brake at the speed of a pull, if the brake file has a speed law."""

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.mechanics.friction import brake_growth, fix_speed
from layerjam.simulate.speed import is_speed_dependent


def friction_growth(brake: Brake, speed: float | None, path: str) -> float:
    """Return the ratio of friction at a speed [m/s] to that at the test speed; 1 without a law.

    Raises FitError if the brake has a law and the speed of the pull is unknown.
    """
    if not is_speed_dependent(brake):
        return 1.0
    if speed is None:
        raise FitError.of(
            path,
            "has neither a speed nor a time, but the friction of this brake depends on "
            "speed ([speed_law]); state the speed in a sidecar, or use the brake without "
            "that table",
        )
    return float(brake_growth(speed, brake))


def fix_friction_speed(brake: Brake, speed: float | None, path: str) -> Brake:
    """Return the brake with its friction at a crosshead speed [m/s]; raises as `friction_growth`.

    A scale factor fitted with this brake is valid at the law's test speed.
    """
    friction_growth(brake, speed, path)
    return brake if speed is None else fix_speed(speed, brake)
