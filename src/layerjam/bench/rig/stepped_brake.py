"""A brake that is moved step by step, by the kernel or by the law that JAX compiles."""

import functools
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.engine import make_quick_kernel
from layerjam.brake.mechanics.enclosure import check_modulus
from layerjam.brake.mechanics.hysteresis import new_state, step_state
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.speed_effects import (
    brake_growth,
    depends_on_speed,
    remove_idle_speed_law,
)
from layerjam.brake.mechanics.stiffness import working_stiffness


class SteppedBrake:
    """A brake with its load history; each call of `step_to` adds one point, as in `brake_cycle`.

    The kernel computes the step if it can; otherwise the brake's law does, compiled on the first
    call. Raises QuantityError for a hyperelastic enclosure, whose history cannot be stepped.
    """

    def __init__(self, brake: Brake) -> None:
        check_modulus(brake)
        self._kernel = make_quick_kernel(remove_idle_speed_law(brake), brake.site.atmosphere)
        self._brake, self._paced = brake, depends_on_speed(brake)
        spring = working_stiffness(brake)
        self._step = compiled(functools.partial(step_state, spring=spring, brake=brake))
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
        growth = np.float64(brake_growth(speed, self._brake)) if self._paced else None
        if self._state is None:
            self._state = new_state(np.float64(vacuum), growth)
        self._state, point = self._step(
            self._state, np.float64(elongation), np.float64(vacuum), growth
        )
        return float(point.force), float(point.slip)
