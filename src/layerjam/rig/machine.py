"""A virtual test machine in the plant of a virtual board, which moves in the board's time."""

import functools
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.fluid.line import Line
from layerjam.kernel.engine import make_quick_kernel
from layerjam.mechanics.enclosure import check_modulus
from layerjam.mechanics.friction import brake_growth
from layerjam.mechanics.hysteresis import new_state, step_state
from layerjam.mechanics.law import double_precision, register_records
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import remove_idle_speed_law


class SteppedBrake:
    """A brake with its load history; each call of `step_to` adds one point, as in `brake_cycle`.

    The kernel computes the step if it can; otherwise the brake's law does, compiled on the first
    call. Raises QuantityError for a hyperelastic enclosure, whose history cannot be stepped.
    """

    def __init__(self, brake: Brake) -> None:
        check_modulus(brake)
        self._kernel = make_quick_kernel(remove_idle_speed_law(brake), brake.site.atmosphere)
        register_records()
        self._brake, self._paced = brake, brake.active_speed_law is not None
        with double_precision():
            spring = jnp.asarray(working_stiffness(brake), jnp.float64)
        self._step = jax.jit(functools.partial(step_state, spring=spring, brake=brake))
        self._state: Any = None

    def step_to(self, elongation: float, vacuum: float, speed: float = 0.0) -> tuple[float, float]:
        """Return force [N] and slip [m] at an elongation [m] and a vacuum [Pa].

        `speed` [m/s] is that of the crosshead; it matters only with a speed law. The force is NaN
        if the brake snaps.
        """
        if self._kernel is not None:
            if not self._state:
                self._kernel.start(vacuum)
                self._state = True
            return self._kernel.move(elongation, vacuum), self._kernel.slip
        with double_precision():
            growth = np.float64(brake_growth(speed, self._brake)) if self._paced else None
            if self._state is None:
                # plain arrays, like later states, because another type would trigger recompilation
                start = new_state(np.float64(vacuum), growth)
                self._state = jax.tree.map(lambda leaf: jnp.asarray(np.asarray(leaf)), start)
            self._state, point = self._step(
                self._state, np.float64(elongation), np.float64(vacuum), growth
            )
            return float(point.force), float(point.slip)


class VirtualMachine:
    """A crosshead with a brake whose chamber is part of the vacuum line.

    The force follows from the brake's law at the true vacuum. Slip enlarges the chamber by
    `volume_per_slip`, and the gas in it expands.
    """

    def __init__(self, brake: Brake, line: Line) -> None:
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
            left, step = self._end - self.elongation, self._speed * dt
            self.moving = abs(left) > step
            self.elongation += math.copysign(step, left)
            if not self.moving:
                self.elongation = self._end
        elif not self.elongation:
            return vacuum
        was = self.volume_ratio
        vacuum_now = min(max(vacuum, 0.0), self._atmosphere)
        self.force, self.slip = self._pulled.step_to(self.elongation, vacuum_now, self._speed)
        absolute = (self._atmosphere - vacuum) * (was / self.volume_ratio) ** self._exponent
        return self._atmosphere - absolute if self.volume_ratio != was else vacuum

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
