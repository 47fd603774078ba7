"""Stops of a mass by a plain brake: the balance of energy in 64-bit mantissas, by bisection.

It shares no code with the product. Formulas are those of the paper as corrected: the sheets'
friction c (L2 - s), and the enclosure's 2 sqrt(EA q s), which is EA s/l + q l beyond q l^2/EA.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Real = np.longdouble
POINTS = 1000
"""Slips at which the sign of the energy is looked at before the bisection, densest at zero."""


class Drop:
    """Drops on one brake; numbers or arrays of one shape, in SI units."""

    def __init__(
        self, brake: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any
    ) -> None:
        arrays = np.broadcast_arrays(
            *(np.asarray(v, Real) for v in (mass, speed, vacuum, spring, gravity))
        )
        self.mass, self.speed, pressure, self.spring, self.gravity = arrays
        sheets, film, wall = brake.sheets, brake.film, brake.enclosure
        width = Real(sheets.width)
        self.c = (
            brake.scale_factor * Real(film.kinetic) * (int(sheets.count) - 1) * width * pressure
        )
        self.overlap, self.travel = Real(sheets.overlap), Real(sheets.usable_travel)
        self.face = Real(wall.modulus) * width * Real(wall.wall)
        self.drag = Real(film.friction_on_silicone) * width * pressure
        self.reach = (Real(sheets.free_left) + self.overlap + Real(sheets.free_right)) / 2
        self.full = self.drag * self.reach**2 / self.face

    def force(self, slip: Any) -> Any:
        """Return the sliding force [N] at a slip [m]."""
        part = 2 * np.sqrt(self.face * self.drag * slip)
        whole = self.face * slip / self.reach + self.drag * self.reach
        return self.c * (self.overlap - slip) + np.where(slip < self.full, part, whole)

    def energy(self, slip: Any) -> Any:
        """Return the kinetic energy [J] left at a slip [m]; negative: it never gets there."""
        first = np.minimum(slip, self.full)
        work = self.c * (self.overlap - slip / 2) * slip
        work = work + 4 * np.sqrt(self.face * self.drag * first) * first / 3
        rest = slip - first
        work = work + rest * (
            self.face * (slip + first) / (2 * self.reach) + self.drag * self.reach
        )
        weight, force = self.mass * self.gravity, self.force(slip)
        came = self.mass * self.speed**2 / 2
        return came + weight * (slip + force / self.spring) - work - force**2 / (2 * self.spring)

    def place(self, slip: Any) -> Any:
        """Return the displacement of the mass [m]; the brake snaps where it falls."""
        return slip + self.force(slip) / self.spring

    def slides(self) -> Any:
        """Return whether the brake slides at all."""
        weight = self.mass * self.gravity
        swing = np.sqrt(weight**2 + self.spring * self.mass * self.speed**2)
        return weight + swing > self.c * self.overlap

    def standstill(self) -> Any:
        """Return the slip [m] of the first standstill, infinite if none lies within the travel.

        NaN if the brake snaps before it, or does not slide.
        """
        share = np.linspace(0, 1, POINTS + 1).astype(Real)[1:] ** 4
        slips = self.travel * share.reshape((-1,) + (1,) * self.mass.ndim)
        slips = np.broadcast_to(slips, (POINTS, *self.mass.shape))
        below = self.energy(slips) <= 0
        at = np.argmax(below, axis=0)[None]
        high = np.take_along_axis(slips, at, 0)[0]
        low = np.where(at[0] > 0, np.take_along_axis(slips, np.maximum(at - 1, 0), 0)[0], 0)
        for _ in range(80):
            middle = (low + high) / 2
            stands = self.energy(middle) <= 0
            low, high = np.where(stands, low, middle), np.where(stands, middle, high)
        root = np.where(below.any(axis=0), high, np.inf)
        fall = np.diff(self.place(slips), axis=0) < 0
        snaps = (fall & (slips[1:] <= root)).any(axis=0)
        return np.where(self.slides() & ~snaps, root, np.nan)

    def time(self, slip: Any, parts: int = 4000) -> Any:
        """Return the time [s] from the taut rope to a slip [m], by the midpoint rule.

        Substituting s = slip sin^2 makes the integrand smooth at a standstill.
        """
        omega = np.sqrt(self.spring / self.mass)
        sag, swing = self.gravity / omega**2, self.speed / omega
        size = np.hypot(sag, swing)
        onset = np.arcsin(np.clip((self.c * self.overlap / self.spring - sag) / size, -1, 1))
        start = (onset + np.arctan2(sag, swing)) / omega
        edges = np.linspace(0, np.pi / 2, parts + 1).astype(Real)
        edges = edges.reshape((-1,) + (1,) * self.mass.ndim)
        places = self.place(slip * np.sin(edges) ** 2)
        middle = slip * np.sin((edges[1:] + edges[:-1]) / 2) ** 2
        pace = np.sqrt(2 * np.maximum(self.energy(middle), 0) / self.mass)
        return start + (np.diff(places, axis=0) / pace).sum(axis=0)
