"""The README's lines of Python by hand: the paper's law, `solve_ivp` and `brentq`.

Run as a script, as a user without layerjam would: it imports nothing else.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

MASS, SPEED, TRAVEL, GRAVITY = 1.0, 2.5, 0.04, 9.80665
SCALE, KINETIC, SHEETS, WIDTH, OVERLAP, FREE = 0.875, 0.24, 11, 0.013, 0.068, 0.011
MODULUS, WALL, ON_SILICONE = 0.1e6, 1e-3, 0.8
STIFFNESS = 1 / (1 / 131e3 + 1 / 16.8e3)
"""Of brake and rope in series [N/m]."""
REACH = FREE + OVERLAP / 2
VACUUMS = (55e3, 80e3)
"""Least and greatest vacuum to try [Pa]."""


def force(slip: float, vacuum: float) -> float:
    """Force of the brake while it slides [N]."""
    sheets = SCALE * KINETIC * (SHEETS - 1) * WIDTH * (OVERLAP - slip) * vacuum
    stiff, grip = MODULUS * WIDTH * WALL, ON_SILICONE * WIDTH * vacuum
    if slip < grip * REACH**2 / stiff:
        return sheets + 2 * sqrt(stiff * grip * max(slip, 0.0))
    return sheets + grip * REACH + stiff * slip / REACH


def slip_at(way: float, vacuum: float) -> float:
    """Slip [m] at which brake and spring together have given way [m]."""

    def excess(slip: float) -> float:
        return slip + force(slip, vacuum) / STIFFNESS - way

    return 0.0 if excess(0.0) >= 0 else float(brentq(excess, 0.0, way, xtol=1e-13))


def drop(vacuum: float) -> tuple[float, float]:
    """Slip at standstill [m] and peak force [N] of a drop."""

    def move(_: float, state: np.ndarray) -> tuple[float, float]:
        slip = slip_at(state[0], vacuum)
        return state[1], GRAVITY - STIFFNESS * (state[0] - slip) / MASS

    def standstill(_: float, state: np.ndarray) -> float:
        return float(state[1])

    standstill.terminal = True  # type: ignore[attr-defined]
    standstill.direction = -1  # type: ignore[attr-defined]
    run = solve_ivp(
        move, (0, 0.2), (0.0, SPEED), events=standstill, rtol=1e-8, atol=1e-10, max_step=1e-3
    )
    slips = [slip_at(way, vacuum) for way in run.y[0]]
    forces = STIFFNESS * (run.y[0] - slips)
    return slips[-1], float(forces.max())


def main() -> None:
    """Print vacuum and peak force."""
    vacuum = float(brentq(lambda p: drop(p)[0] - TRAVEL, *VACUUMS, xtol=0.1))
    print(f"{vacuum / 1e3:.2f} kPa, {drop(vacuum)[1]:.1f} N")


if __name__ == "__main__":
    main()
