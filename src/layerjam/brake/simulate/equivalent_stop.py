"""A stop with linear friction that replaces one that no law solves for many brakes at once.

Sheets without spacers, a speed law, rubber, a damped rope and a changing vacuum need a quadrature
or time steps for each brake. A factor of friction makes a brake with linear friction slip as far at
constant vacuum. The exact law of that brake then solves many with other numbers.
"""

import math
from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.effects import remove_slip_effects, use_single_modulus
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.mechanics.stop.exact import stop
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.core.evolve import evolve

FACTORS = 0.02, 50.0
"""Range of the factor of friction."""


class StopCase(NamedTuple):
    """A mass [kg] that arrives with a speed [m/s] at constant vacuum [Pa].

    `rope` is the stiffness of the rope [N/m], None for a rigid one; `gravity` [m/s^2] acts along
    the pull.
    """

    mass: Any
    speed: Any
    vacuum: Any
    rope: Any
    gravity: Any

    def arguments(self, brake: Brake) -> tuple[Any, ...]:
        """Return the arguments of `stop`."""
        spring = rope_spring(self.rope, brake)
        return self.mass, self.speed, self.vacuum, spring, self.gravity, brake


def make_linear(brake: Brake, speed: float) -> Brake:
    """Return the brake with friction linear in slip, that of a speed [m/s], and one modulus."""
    return use_single_modulus(remove_slip_effects(fix_speed(speed, brake)))


def match_stop(brake: Brake, case: StopCase, slip: float, end_speed: float) -> Brake:
    """Return a linear brake with a factor of friction that gives a slip [m] and end speed [m/s].

    It is the brake itself if the stop is the same already, or no factor gives it.
    """
    from scipy.optimize import brentq

    def scale(level: float) -> Brake:
        return evolve(brake, scale_factor=brake.scale_factor * math.exp(level))

    def exceed(level: float) -> float:
        result = stop(*case.arguments(scale(level)))
        # with less friction, first the slip rises to the usable travel, then the end speed
        excess = float(result.slip - slip + result.end_speed - end_speed)
        return -1.0 if math.isnan(excess) else excess  # so much friction that the brake snaps

    low, high = map(math.log, FACTORS)
    if exceed(0.0) == 0 or not exceed(low) > 0 > exceed(high):
        return brake
    return scale(brentq(exceed, low, high, xtol=1e-6))
