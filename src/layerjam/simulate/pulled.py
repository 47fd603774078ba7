"""A brake pulled sample by sample, while nobody knows yet what comes next."""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.kernel.engine import quick_kernel
from layerjam.mechanics.enclosure import one_modulus
from layerjam.mechanics.friction import growth_of
from layerjam.mechanics.hysteresis import stepped, untouched
from layerjam.mechanics.law import double_precision, register_records
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import counted, follows_speed


class Pulled:
    """A brake and its memory; one call gives one point of what `brake_cycle` gives of a history.

    The kernel steps it where that can be, the law elsewhere, whose first call compiles. Raises
    QuantityError for a hyperelastic enclosure, which is followed as a whole only.
    """

    def __init__(self, brake: Brake) -> None:
        one_modulus(brake)
        self._kernel = quick_kernel(counted(brake), brake.site.atmosphere)
        register_records()
        self._brake, self._paced = brake, follows_speed(brake)
        with double_precision():
            spring = jnp.asarray(working_stiffness(brake), jnp.float64)
        self._step = jax.jit(functools.partial(stepped, spring=spring, brake=brake))
        self._state: Any = None

    def to(self, elongation: float, vacuum: float, speed: float = 0.0) -> tuple[float, float]:
        """(force [N], slip [m]) at an elongation [m] and a vacuum [Pa] up to the atmosphere.

        `speed` [m/s] is that of the crosshead, for a brake with a speed law. The force is NaN where
        the brake snaps.
        """
        if self._kernel is not None:
            if not self._state:
                self._kernel.start(vacuum)
                self._state = True
            return self._kernel.move(elongation, vacuum), self._kernel.slip
        with double_precision():
            grown = np.float64(growth_of(speed, self._brake)) if self._paced else None
            if self._state is None:
                # plain arrays, as every later state has them: otherwise it compiles twice
                start = untouched(np.float64(vacuum), grown)
                self._state = jax.tree.map(lambda leaf: jnp.asarray(np.asarray(leaf)), start)
            self._state, found = self._step(
                self._state, np.float64(elongation), np.float64(vacuum), grown
            )
            return float(found.force), float(found.slip)
