"""Rise and fall of the vacuum in a line that waits for the warning of a collision.

At the warning the pump switches to full power, and, after its delay, the reservoir's valve opens.
"""

from dataclasses import dataclass

import numpy as np

from layerjam.brake.fluid.closed_forms import final_pressure
from layerjam.brake.fluid.line import Line, water_compliance
from layerjam.brake.fluid.network import Drive, Response, respond, state_at_pressure
from layerjam.brake.simulate.coupled import integrate_line_along

SAMPLES = 401
SHORTEST = 1e-9
"""Time [s] treated as zero: the line's integrator cannot resolve much shorter times."""


@dataclass(frozen=True)
class Standby:
    """A line and its idle vacuum."""

    line: Line
    vacuum: float = 0.0
    """Idle vacuum [Pa]."""
    stored: float | None = None
    """Pressure in the reservoir [Pa absolute]; None if pump and leak determine it."""
    water: bool = False

    def respond(self, duration: float, samples: int = SAMPLES) -> Response:
        """Return the response of the line for a duration [s] after the warning."""
        line, a = self.line, self.line.site.atmosphere
        if self.water:
            time = np.linspace(0.0, duration, samples if duration else 1)
            start = state_at_pressure(line, a - self.vacuum)
            return integrate_line_along(line, start, time, np.zeros_like(time), Drive(), water=True)
        start = state_at_pressure(
            line, a - self.vacuum, final_pressure(line) if self.stored is None else self.stored
        )
        if duration <= SHORTEST:
            return Response(line=line, time=np.zeros(1), states=start[None])
        opens = np.inf if line.reservoir is None else line.reservoir.delay
        if opens >= duration - SHORTEST:
            return respond(line, duration, Drive(), start, samples)
        if opens <= SHORTEST:
            return respond(line, duration, Drive(store=1.0), start, samples)
        first = respond(line, opens, Drive(), start, max(samples // 4, 2))
        second = respond(line, duration - opens, Drive(store=1.0), first.states[-1], samples)
        time = np.append(first.time, opens + second.time[1:])
        return Response(line=line, time=time, states=np.vstack([first.states, second.states[1:]]))

    def vacuum_after(self, duration: float) -> float:
        """Return the vacuum [Pa] at a time [s] after the warning."""
        return float(self.respond(duration, samples=2).vacuum[-1])

    def vacuum_after_venting(self, duration: float) -> float:
        """Return the lowest vacuum [Pa] to which venting for a time [s] can reduce the line.

        It falls through the vent valve after its delay, or by running the pumps backwards; without
        either, it stays constant.
        """
        line = self.line
        reverse_flow = line.pump.backwards * line.pump.count
        if self.water:
            return max(self.vacuum - reverse_flow * duration / water_compliance(line), 0.0)
        wait = line.valve.delay if line.valve is not None else 0.0
        is_sealed = line.valve is None and reverse_flow == 0
        if is_sealed or duration <= wait + SHORTEST or self.vacuum == 0:
            return self.vacuum
        drive = Drive(pump=-1.0) if line.valve is None else Drive(pump=0.0, vent=1.0)
        start = state_at_pressure(line, line.site.atmosphere - self.vacuum)
        response = respond(line, duration - wait, drive, start, 2)
        return max(float(response.vacuum[-1]), 0.0)
