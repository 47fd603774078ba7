"""A virtual test machine in the plant of a virtual board, which moves in the board's time."""

import math

from layerjam.brake.device.brake import Brake
from layerjam.brake.fluid.line import Line
from layerjam.core.errors import QuantityError


class VirtualMachine:
    """A crosshead with a brake whose chamber is part of the vacuum line.

    The force follows from the brake's law at the true vacuum. Slip enlarges the chamber by
    `volume_per_slip`, and the gas in it expands.
    """

    def __init__(self, brake: Brake, line: Line) -> None:
        from layerjam.bench.rig.stepped_brake import SteppedBrake  # it loads JAX

        chamber = line.chamber
        self.elongation = self.slip = self.force = 0.0
        self.moving = False
        self._end = self._speed = 0.0
        self._pulled = SteppedBrake(brake)
        self._larger = chamber.volume_per_slip / chamber.volume
        self._exponent, self._atmosphere = line.polytropic, line.site.atmosphere
        self._shown: dict[int, tuple[float, float]] = {}
        self._pulled.step_to(0.0, 0.0)  # compile now, before the board has to wait for it

    @property
    def volume_ratio(self) -> float:
        """Volume of the chamber relative to its volume at rest."""
        return 1.0 + self._larger * self.slip

    def start_motion(self, end: float, speed: float) -> None:
        """Move to an elongation [m] at a speed [m/s]."""
        self._end, self._speed, self.moving = end, speed, True

    def stop_motion(self) -> None:
        """Stop at the current position."""
        self.moving = False

    def advance(self, dt: float, vacuum: float) -> float:
        """Advance by `dt` [s]; return the vacuum [Pa] at the chamber's new volume."""
        if self.moving:
            travel_left, step = self._end - self.elongation, self._speed * dt
            self.moving = abs(travel_left) > step
            self.elongation += math.copysign(step, travel_left)
            if not self.moving:
                self.elongation = self._end
        elif not self.elongation:
            return vacuum
        volume_before = self.volume_ratio
        vacuum_now = min(max(vacuum, 0.0), self._atmosphere)
        self.force, self.slip = self._pulled.step_to(self.elongation, vacuum_now, self._speed)
        absolute = (self._atmosphere - vacuum) * (
            volume_before / self.volume_ratio
        ) ** self._exponent
        return self._atmosphere - absolute if self.volume_ratio != volume_before else vacuum

    def store_sample(self, number: int) -> None:
        """Store the readings at the board's sample with this number."""
        self._shown[number] = (self.elongation, self.force)

    def take_sample(self, number: int) -> tuple[float, float]:
        """Return elongation [m] and force [N] at a sample; 0 before the first sample."""
        return self._shown.pop(number, (0.0, 0.0))


def check_brake(brake: Brake, end: float) -> None:
    """Raise QuantityError for a move to `end` [m] that would separate the sheets."""
    if end >= brake.sheets.overlap:
        raise QuantityError.of(
            "procedure",
            f"an elongation of {end * 1e3:g} mm is not allowed on a virtual crosshead; the sheets "
            f"overlap by only {brake.sheets.overlap * 1e3:g} mm",
        )
