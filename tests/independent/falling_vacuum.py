"""A stop under a falling vacuum, by SciPy's integrator; it shares no code with the product.

The brake only slides out, so its force is that of first loading under the vacuum of the moment:
c (L2 - s) + 2 sqrt(EA q s), with c and q proportional to it, as long as the enclosure spreads.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp


class FallingVacuum:
    """A mass on a spring and a plain brake; `times` [s] and `pressures` [Pa] fall linearly."""

    def __init__(
        self, brake: Any, mass: float, speed: float, spring: float, gravity: float,
        times: list[float], pressures: list[float],
    ) -> None:  # fmt: skip
        sheets, film, wall = brake.sheets, brake.film, brake.enclosure
        self.mass, self.speed, self.spring, self.gravity = mass, speed, spring, gravity
        self.times, self.pressures, self.overlap = times, pressures, sheets.overlap
        self.c = brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width
        face = wall.modulus * sheets.width * wall.wall
        self.root = 2 * np.sqrt(face * film.friction_on_silicone * sheets.width)

    def vacuum(self, time: Any) -> Any:
        """Return the vacuum [Pa]."""
        return np.interp(time, self.times, self.pressures)

    def slip(self, place: Any, vacuum: Any) -> Any:
        """Return the slip [m] at a displacement of the mass: k (z - s) = F(s)."""
        c, root = self.c * vacuum, self.root * np.sqrt(vacuum)
        drive, stiff = self.spring * place - c * self.overlap, self.spring - c
        push = np.maximum(drive, 0.0)
        return (2 * push / (root + np.sqrt(root**2 + 4 * stiff * push))) ** 2

    def force(self, time: Any, place: Any) -> Any:
        """Return the force [N]."""
        return self.spring * (place - self.slip(place, self.vacuum(time)))

    def run(self) -> tuple[float, float, float]:
        """Return slip [m] and time [s] of the first standstill, and the largest force [N]."""

        def rate(time: float, state: Any) -> list[float]:
            return [state[1], self.gravity - float(self.force(time, state[0])) / self.mass]

        def standstill(_: float, state: Any) -> float:
            return float(state[1])

        def onset(time: float, state: Any) -> float:
            return float(self.spring * state[0] - self.c * self.vacuum(time) * self.overlap)

        standstill.terminal, standstill.direction = True, -1  # type: ignore[attr-defined]
        onset.terminal, onset.direction = True, 1  # type: ignore[attr-defined]
        time, state, highest = 0.0, np.array([0.0, self.speed]), 0.0
        breaks = [t for t in self.times if t > 0] + [10.0]
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "dense_output": True}
        slides = False
        while True:
            end = min(t for t in breaks if t > time)
            events = [standstill] if slides else [standstill, onset]
            part = solve_ivp(rate, (time, end), state, events=events, **options)
            grid = np.linspace(time, part.t[-1], 20_001)
            highest = max(highest, float(self.force(grid, part.sol(grid)[0]).max()))
            time, state = float(part.t[-1]), part.y[:, -1]
            if part.t_events[0].size:
                return float(self.slip(state[0], self.vacuum(time))), time, highest
            slides = slides or bool(part.status == 1)
