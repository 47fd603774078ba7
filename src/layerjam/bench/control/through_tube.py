"""The plant with a tube, between two samples: two vacuums, with adaptive steps.

The equations are stiff if the tube is short and wide. They are solved by a Rosenbrock method of
order two with an error estimate (Shampine and Reichelt, SIAM Journal on Scientific Computing 18,
1997, 1-22: `ode23s`).
"""

import math

from layerjam.bench.control.exact import Rates

D = 1.0 / (2.0 + math.sqrt(2.0))
E = 6.0 + math.sqrt(2.0)
CLOSE = 1e-7
"""Error tolerance of a vacuum in one step, relative to the atmosphere."""


def _slopes(v: float, w: float, a: float, b: float, plant: Rates) -> tuple[float, float]:
    p, s = plant.atmosphere - v, plant.atmosphere - w
    flow = plant.passes * (p * p - s * s)
    return flow - plant.leak * v, (a - b * w - flow) / plant.side


def advance(
    v: float, w: float, display: float, a: float, b: float, plant: Rates, dt: float, lag: float
) -> tuple[float, float, float]:
    """Return (vacuum of chamber, vacuum of side, sensor reading) after a time `dt` [s].

    The side is pumped at a - b w, in Pa/s relative to the chamber's volume.
    """
    time_left, h, side = dt, dt, plant.side
    while time_left > 0.0:
        h = min(h, time_left)
        f, g = _slopes(v, w, a, b, plant)
        p, s = plant.atmosphere - v, plant.atmosphere - w
        dp, ds = 2.0 * plant.passes * p, 2.0 * plant.passes * s
        m11, m12 = 1.0 + h * D * (dp + plant.leak), -h * D * ds
        m21, m22 = -h * D * dp / side, 1.0 + h * D * (ds + b) / side
        det = m11 * m22 - m12 * m21
        k1v, k1w = (m22 * f - m12 * g) / det, (m11 * g - m21 * f) / det
        f1, g1 = _slopes(v + 0.5 * h * k1v, w + 0.5 * h * k1w, a, b, plant)
        rv, rw = f1 - k1v, g1 - k1w
        k2v = (m22 * rv - m12 * rw) / det + k1v
        k2w = (m11 * rw - m21 * rv) / det + k1w
        v1, w1 = v + h * k2v, w + h * k2w
        f2, g2 = _slopes(v1, w1, a, b, plant)
        rv = f2 - E * (k2v - f1) - 2.0 * (k1v - f)
        rw = g2 - E * (k2w - g1) - 2.0 * (k1w - g)
        k3v, k3w = (m22 * rv - m12 * rw) / det, (m11 * rw - m21 * rv) / det
        error = h / 6.0 * max(abs(k1v - 2.0 * k2v + k3v), abs(k1w - 2.0 * k2w + k3w))
        error /= CLOSE * plant.atmosphere
        if not error > 1.0 or h <= 1e-9 * dt:  # NaN ends the search too
            if lag > 0.0:
                # the chamber's vacuum is nearly linear within such a short step
                delay, fades = (v1 - v) / h * lag, math.exp(-h / lag)
                display = v1 - delay + (display - v + delay) * fades
            else:
                display = v1
            v, w, time_left = v1, w1, time_left - h
        h *= min(max(0.8 * error ** (-1.0 / 3.0), 0.2), 5.0) if error > 0.0 else 5.0
    return v, w, display
