"""The reference: energy balance in extended precision, its first root by halving.

Written from section III-E's balance and independent of `mechanics.stop.exact`, which is measured
against it as everything else is.
"""

from __future__ import annotations

import numpy as np

from benchmarks.comparators.drops import Answer, Array, Drops, Force


def _work(slip: Array, force: Force) -> Array:
    """Integral of the brake's force from 0 to slip [J]."""
    start = np.minimum(slip, force.saturation)
    sleeve = force.root * start * np.sqrt(start) * 2 / 3
    sleeve = sleeve + (slip - start) * (force.step + force.rise * (slip + start) / 2)
    return force.onset * slip - force.c * slip**2 / 2 + sleeve


def _balance(drops: Drops, force: Force, weight: Array) -> Array:
    """Slip at which the falling force meets the weight, or the end of travel [m].

    Until there the kinetic energy has one root at most.
    """
    end = np.full(len(drops), drops.travel, dtype=np.longdouble)
    top = np.minimum((force.root / (2 * force.c)) ** 2, end)
    low, high = top, end
    for _ in range(70):
        middle = (low + high) / 2
        strong = force.at(middle) > weight
        low, high = np.where(strong, middle, low), np.where(strong, high, middle)
    return np.where(force.at(end) > weight, end, high)


def solve(drops: Drops) -> Answer:
    """Travel and peak force of drops in which the brake slides, to about 1e-18 m.

    The sleeve must not stiffen faster than the sheets' friction falls (vacuum above 1.06 kPa for
    the paper's Kapton brake).
    """
    wide = [np.asarray(a, dtype=np.longdouble) for a in (drops.mass, drops.speed)]
    mass, speed = wide
    force = Force(*(np.asarray(a, dtype=np.longdouble) for a in drops.force))
    if np.any(force.c <= force.rise):
        raise ValueError("the reference needs a force that falls at the end")
    spring, weight = np.longdouble(drops.spring), mass * np.longdouble(drops.gravity)
    begin = mass * speed**2 / 2 + (weight * force.onset - force.onset**2 / 2) / spring

    def energy(slip: Array) -> Array:
        now = force.at(slip)
        stretch = (weight * (now - force.onset) - (now**2 - force.onset**2) / 2) / spring
        return begin + weight * slip - _work(slip, force) + stretch

    high = np.sqrt(_balance(drops, force, weight))
    stops, low = energy(high**2) <= 0, np.zeros_like(high)
    for _ in range(70):
        middle = (low + high) / 2
        moving = energy(middle**2) > 0
        low, high = np.where(moving, middle, low), np.where(moving, high, middle)
    travel = np.where(stops, high**2, np.longdouble(drops.travel))
    top = np.minimum((force.root / (2 * force.c)) ** 2, travel)
    return Answer(travel, np.maximum(force.at(top), force.at(travel)))
