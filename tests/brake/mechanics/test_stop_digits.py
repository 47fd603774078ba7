"""The exact stop against 40-digit arithmetic that shares no line with it."""

from __future__ import annotations

import decimal

import numpy as np
import pytest

from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, STOPPED, stop
from strategies import KAPTON, PTFE

D = decimal.Decimal
decimal.getcontext().prec = 40
G = 9.80665


class Exact:
    """The drop in decimal arithmetic, from the formulas of the paper as corrected."""

    def __init__(self, brake, mass, speed, vacuum, spring, gravity):
        sheets, film, skin = brake.sheets, brake.film, brake.enclosure
        p, w = D(vacuum), D(sheets.width)
        self.mass, self.k, self.g = D(mass), D(spring), D(gravity)
        self.c = D(brake.scale_factor) * D(film.kinetic) * (int(sheets.count) - 1) * w * p
        self.overlap, self.travel = D(sheets.overlap), D(sheets.usable_travel)
        self.ea = D(skin.modulus) * w * D(skin.wall)
        self.q = D(film.friction_on_silicone) * w * p
        self.reach = (D(sheets.free_left) + self.overlap + D(sheets.free_right)) / 2
        self.full = self.q * self.reach**2 / self.ea
        self.onset = self.c * self.overlap
        self.came = self.mass * D(speed) ** 2 / 2

    def sleeve(self, s):
        if s < self.full:
            return 2 * (self.ea * self.q * s).sqrt()
        return self.ea * s / self.reach + self.q * self.reach

    def sleeve_work(self, s):
        start = min(s, self.full)
        work = 4 * (self.ea * self.q).sqrt() * start * start.sqrt() / 3
        if s > self.full:
            work += self.ea * (s**2 - self.full**2) / (2 * self.reach)
            work += self.q * self.reach * (s - self.full)
        return work

    def force(self, s):
        return self.c * (self.overlap - s) + self.sleeve(s)

    def energy(self, s):
        """Energy of motion left once the brake has slipped by s."""
        y = self.force(s)
        work = self.c * (self.overlap * s - s**2 / 2) + self.sleeve_work(s)
        return self.came + self.mass * self.g * (s + y / self.k) - work - y**2 / (2 * self.k)

    def slides(self):
        weight = self.mass * self.g
        return weight + (weight**2 + 2 * self.k * self.came).sqrt() > self.onset

    def standstill(self):
        """First root, by a walk in small steps and halvings; None if it runs past the travel."""
        steps = 1000
        low = D(0)
        for i in range(1, steps + 1):
            high = self.travel * i * i / steps**2
            if self.energy(high) <= 0:
                for _ in range(110):
                    middle = (low + high) / 2
                    low, high = (middle, high) if self.energy(middle) > 0 else (low, middle)
                return high
            low = high
        return None


def drops(brake, n, seed):
    random = np.random.default_rng(seed)
    for _ in range(n):
        yield (
            brake, float(10 ** random.uniform(-1, 1.1)), float(random.uniform(0.05, 4.0)),
            float(random.choice([2e3, 2e4, 6e4, 9.45e4]) * random.uniform(0.8, 1.05)),
            float(random.choice([14.9e3, 131e3, 1e6])), float(random.choice([0.0, G])),
        )  # fmt: skip


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
def test_travel_to_ten_digits_of_the_overlap(brake):
    seen, near = 0, 0
    for case in drops(brake, 60, 5):
        exact, (_, *given) = Exact(*case), case
        ours = stop(*given, brake)
        if not exact.slides():
            assert int(ours.outcome) == NEVER_SLID
            continue
        right = exact.standstill()
        if right is None:
            assert int(ours.outcome) == BOTTOMED_OUT
            end = (2 * exact.energy(exact.travel) / exact.mass).sqrt()
            assert float(ours.end_speed) == pytest.approx(float(end), rel=1e-10)
            continue
        assert int(ours.outcome) == STOPPED
        slip = D(float(ours.slip))
        hold = exact.force(right)
        if hold - exact.mass * exact.g >= hold / 1000:
            seen += 1
            assert abs(slip - right) <= D("1e-10") * exact.overlap
        else:
            near += 1
        # backward: the energy that is left where it is said to stand
        size = exact.came + exact.mass * exact.g * right
        assert abs(exact.energy(slip)) <= D("1e-13") * size
    assert seen >= 15


def test_close_to_balance_the_energy_is_right():
    """A weight just below what the brake holds at its standstill: the root is nearly double."""
    k = 131e3
    for left in (1e-2, 1e-4, 1e-6, 1e-8):
        # mass and slip with Y = M g (1 + left), and the speed that ends there
        exact = Exact(KAPTON, 1.0, 0.0, 94.5e3, k, G)
        slip = D("0.02")
        mass = float(exact.force(slip) / (1 + D(left)) / D(G))
        exact = Exact(KAPTON, mass, 0.0, 94.5e3, k, G)
        speed = float((-2 * exact.energy(slip) / exact.mass).sqrt())
        exact = Exact(KAPTON, mass, speed, 94.5e3, k, G)
        ours = stop(mass, speed, 94.5e3, k, G, KAPTON)
        assert int(ours.outcome) == STOPPED
        off = abs(exact.energy(D(float(ours.slip))))
        assert off <= D("1e-13") * (exact.came + exact.mass * exact.g * slip)
