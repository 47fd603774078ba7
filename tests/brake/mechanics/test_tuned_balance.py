"""The tuned vacuum against Brent's method on the energy balance, for random brakes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from law_cases import BRAKES, FAMILIES
from layerjam.brake.mechanics.pull import holding_vacuum
from layerjam.laws import brake_force, saturation_slip, slip_work, tuned_vacuum
from strategies import one


@pytest.mark.parametrize(
    "family", ["plain", "spacers or a fan", "ageing and an effect", "pressure exponent"]
)
def test_the_tuned_vacuum_meets_the_energy_balance(family):
    """The work of the brake and the energy of the spring are those of the fall and of the speed."""
    brakes, random = FAMILIES[family](3), np.random.default_rng(3)

    def draw(low, high):
        return np.exp(random.uniform(np.log(low), np.log(high), BRAKES))

    mass, speed, spring = draw(0.05, 30.0), draw(0.05, 5.0), draw(1e3, 1e6)
    gravity = np.where(random.random(BRAKES) < 0.3, 0.0, 9.81)
    slip = brakes.sheets.usable_travel * random.uniform(0.001, 1.0, BRAKES)
    vacuums = tuned_vacuum(mass, speed, slip, spring, gravity, brakes)
    solved = saturated = 0
    for place, vacuum in enumerate(vacuums):
        brake, k = one(brakes, place), spring[place]
        weight, s = mass[place] * gravity[place], slip[place]

        def left(pressure, brake=brake, k=k, weight=weight, s=s, place=place):
            force = brake_force(s, pressure, brake)
            taken = slip_work(s, pressure, brake) + force**2 / (2 * k)
            return float(taken - weight * (s + force / k) - mass[place] * speed[place] ** 2 / 2)

        low, high = float(holding_vacuum(weight, s, brake)), float(brake.site.atmosphere)
        if np.isnan(low) or left(low) > 0 or left(high) < 0:
            assert np.isnan(vacuum)
            continue
        root = brentq(left, low, high, xtol=1e-9, rtol=1e-14)
        assert vacuum == pytest.approx(root, rel=1e-10)
        solved += 1
        saturated += s >= float(saturation_slip(root, brake))
    # both forms of the enclosure occur
    assert solved >= 8 and 0 < saturated < solved
