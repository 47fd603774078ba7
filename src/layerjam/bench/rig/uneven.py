"""Flows of a real line: a pump that ripples and dips, and orifices as leak and vent."""

import math
import random
from dataclasses import dataclass

from layerjam.brake.device.mount import Site
from layerjam.brake.fluid.flow import flow_ratio

RIPPLE = (2.0, 20.0)
"""Range of stroke frequencies of a pump [Hz]."""
SWING = 0.3
"""Largest ripple of a pump's flow, relative to its mean."""
DIP = (0.02, 0.1)
"""Range of the duration of a dip in the supply [s]."""
EVERY = 1.0
"""Time between the starts of consecutive dips [s]."""
SUPPLY = 0.5
"""Smallest fraction of the pump's flow during a dip."""
SUBSTEP = 2e-3
"""Longest time [s] for which flows are assumed constant."""
ATMOSPHERE = Site().atmosphere


@dataclass(frozen=True, kw_only=True)
class Uneven:
    """A pump whose flow ripples and dips, and orifices as leak and vent.

    At the vacuum `right_at` [Pa], each orifice has the same flow as in the linear plant.
    """

    right_at: float
    ripple: float
    frequency: float
    phase: float
    dip: float
    lasting: float

    def pump_ratio(self, time: float) -> float:
        """Return the pump's flow at a time [s], relative to its mean."""
        share = 1 + self.ripple * math.sin(2 * math.pi * self.frequency * time + self.phase)
        return share * (self.dip if time % EVERY < self.lasting else 1.0)

    def orifice_ratio(self, vacuum: float) -> float:
        """Return the flow through an orifice at a vacuum [Pa], relative to the linear plant."""
        if vacuum <= 0.0:
            return 1.0
        return self._flow_per_vacuum(vacuum) / self._flow_per_vacuum(self.right_at)

    def _flow_per_vacuum(self, vacuum: float) -> float:
        return flow_ratio(1 - min(vacuum / ATMOSPHERE, 1.0)) / vacuum


def draw_uneven(draw: random.Random, matched_vacuum: float) -> Uneven:
    """Return a random uneven line whose orifices match the linear plant at a vacuum [Pa]."""
    return Uneven(
        right_at=matched_vacuum,
        ripple=draw.uniform(0.0, SWING),
        frequency=draw.uniform(*RIPPLE),
        phase=draw.uniform(0.0, 2 * math.pi),
        dip=draw.uniform(SUPPLY, 1.0),
        lasting=draw.uniform(*DIP),
    )
