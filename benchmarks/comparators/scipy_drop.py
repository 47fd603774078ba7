"""The drop in SciPy: `solve_ivp` over the stuck, then the sliding phase, with terminal events.

State: way z and speed v of the mass. The massless brake is in series with the spring k, so while
it slides z = s + Y(s)/k; in w = sqrt(s) that is a quadratic, so s(z) is closed and its start
smooth. A state (s, v) would begin at a singular slope of Y.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.comparators.drops import Array, Drops

LONGEST = 2.0
"""Seconds after which a drop must have ended."""
LONGEST_STEP = 4e-3
"""Of both phases [s]. A longer one can pass an event and come back behind it unseen; half a swing
lasts 14 to 45 ms."""
TOLERANCE = {
    "LSODA": {1e-6: 1e-6, 1e-8: 1e-9},
    "DOP853": {1e-6: 1e-7, 1e-8: 1e-9},
}
"""Per accuracy [m]: the loosest power of ten as rtol with which no travel is further off."""


def _one(
    mass: float, speed: float, force: tuple[float, ...], spring: float, gravity: float,
    travel: float, method: str, rtol: float,
) -> float:  # fmt: skip
    """Slip at the end of one drop [m]."""
    c, onset, root, saturation, step, rise = force
    start = onset / spring
    a, b = 1 - c / spring, root / spring
    whole = saturation * (1 + (rise - c) / spring) + step / spring

    def slip(z: float) -> float:
        over = z - start
        if over <= 0:
            return 0.0
        if over >= whole:
            return (over - step / spring) / (1 + (rise - c) / spring)
        w = 2 * over / (b + sqrt(b * b + 4 * a * over))
        return w * w

    def stuck(_t: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], gravity - spring * y[0] / mass

    def slides(_t: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], gravity - spring * (y[0] - slip(y[0])) / mass

    def onset_reached(_t: float, y: np.ndarray) -> float:
        return y[0] - start

    def standstill(_t: float, y: np.ndarray) -> float:
        return y[1]

    def used_up(_t: float, y: np.ndarray) -> float:
        return slip(y[0]) - travel

    for event in (onset_reached, standstill, used_up):
        event.terminal = True  # type: ignore[attr-defined]
    atol = rtol * 1e-2, rtol
    how = {"method": method, "rtol": rtol, "atol": atol, "max_step": LONGEST_STEP}
    begin = 0.0, speed
    first = solve_ivp(stuck, (0, LONGEST), begin, events=(onset_reached, standstill), **how)
    if len(first.t_events[0]):
        begin = first.y_events[0][0]
    elif first.y[0, -1] <= start:
        return 0.0
    # else the last step passed the onset and ended in a standstill beyond: slide from the rope on
    second = solve_ivp(slides, (0, LONGEST), begin, events=(standstill, used_up), **how)
    if second.status != 1:
        raise RuntimeError(second.message)
    return slip(second.y[0, -1])


def prepare(drops: Drops, method: str, rtol: float) -> Callable[[], Array]:
    """A call that gives each drop's travel [m], one after the other; `method` as in solve_ivp."""
    forces = np.stack(drops.force, axis=1).tolist()
    cases = list(zip(drops.mass.tolist(), drops.speed.tolist(), map(tuple, forces), strict=True))
    fixed = drops.spring, drops.gravity, drops.travel, method, rtol

    def run() -> Array:
        return np.array([_one(*case, *fixed) for case in cases])

    return run
