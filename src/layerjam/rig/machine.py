"""A virtual test machine in the plant of a virtual board: it moves in the board's time."""

from __future__ import annotations

import math

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.fluid.line import Line
from layerjam.simulate.pulled import Pulled


class VirtualMachine:
    """A crosshead with a brake on it whose chamber is the line's.

    The force follows from the brake's law at the true vacuum; the slip makes the chamber larger by
    `volume_per_slip`, so that the gas in it expands.
    """

    def __init__(self, brake: Brake, line: Line) -> None:
        chamber = line.chamber
        self.elongation = self.slip = self.force = 0.0
        self.moving = False
        self._end = self._speed = 0.0
        self._pulled = Pulled(brake)
        self._larger = chamber.volume_per_slip / chamber.volume
        self._exponent, self._atmosphere = line.polytropic, line.site.atmosphere
        self._shown: dict[int, tuple[float, float]] = {}
        self._pulled.to(0.0, 0.0)  # compiles before the board waits for it

    @property
    def swell(self) -> float:
        """The chamber's volume over that at rest."""
        return 1.0 + self._larger * self.slip

    def go(self, end: float, speed: float) -> None:
        """Move to an elongation [m] at a speed [m/s]."""
        self._end, self._speed, self.moving = end, speed, True

    def halt(self) -> None:
        """Stand where it is."""
        self.moving = False

    def advance(self, dt: float, vacuum: float) -> float:
        """So many seconds on; the vacuum [Pa] once the chamber has its new volume."""
        if self.moving:
            left, most = self._end - self.elongation, self._speed * dt
            self.moving = abs(left) > most
            self.elongation += math.copysign(most, left)
            if not self.moving:
                self.elongation = self._end
        elif not self.elongation:
            return vacuum
        was = self.swell
        pressed = min(max(vacuum, 0.0), self._atmosphere)
        self.force, self.slip = self._pulled.to(self.elongation, pressed, self._speed)
        absolute = (self._atmosphere - vacuum) * (was / self.swell) ** self._exponent
        return self._atmosphere - absolute if self.swell != was else vacuum

    def sample(self, number: int) -> None:
        """Keep what it shows at the board's sample of this number."""
        self._shown[number] = (self.elongation, self.force)

    def taken(self, number: int) -> tuple[float, float]:
        """(elongation [m], force [N]) at a sample; before it was there it stood still."""
        return self._shown.pop(number, (0.0, 0.0))


def check_brake(brake: Brake, end: float) -> None:
    """Raise QuantityError for a move [m] that would part the sheets."""
    if end >= brake.sheets.overlap:
        raise QuantityError.of(
            "procedure",
            f"an elongation of {end * 1e3:g} mm is not allowed on a virtual crosshead; the sheets "
            f"overlap by {brake.sheets.overlap * 1e3:g} mm",
        )
