"""The tuned vacuum against Brent's method on the energy balance, for random brakes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from law_cases import BRAKES, FAMILIES
from layerjam.brake.mechanics.pull import holding_vacuum
from layerjam.brake.mechanics.stop.exact import STOPPED, stop
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.mechanics.stop.tune import tuned_stop
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


@pytest.mark.parametrize(
    "family", ["plain", "spacers or a fan", "ageing and an effect", "pressure exponent"]
)
@pytest.mark.parametrize("rope", [None, 2e4])
def test_the_whole_travel_can_be_tuned_as_well_as_all_but_a_ten_millionth(family, rope):
    """Rounding must not make a stop at the end of the travel bottom out."""
    brakes, random = FAMILIES[family](5), np.random.default_rng(5)
    mass, speed = np.exp(random.uniform(np.log([0.2, 0.2]), np.log([8.0, 3.0]), (BRAKES, 2))).T
    travel = brakes.sheets.usable_travel
    for count in range(1, 5):
        case = count * mass, speed, rope, 9.81, brakes
        end, before = (
            tuned_stop(case[0], speed, slip, *case[2:]) for slip in (travel, travel * (1 - 1e-7))
        )
        solved = np.isfinite(before)
        # a vacuum above the atmosphere is needed for the last ten millionth of none of these
        assert (np.isfinite(end) == solved).all()
        assert end[solved] == pytest.approx(before[solved], rel=1e-5)
        spring = rope_spring(rope, brakes) + 0.0 * mass
        stops = stop(case[0], speed, np.where(solved, end, 1e4), spring, 9.81, brakes)
        assert (stops.outcome[solved] == STOPPED).all()
        assert stops.slip[solved] == pytest.approx(travel[solved], rel=1e-6)
    assert solved.any()


@pytest.mark.slow
def test_the_whole_travel_can_be_tuned_with_a_speed_law():
    """Near the mass that friction only just holds, the slip is most sensitive to the vacuum."""
    brakes = FAMILIES["speed law"](5)
    count = len(brakes.sheets.count)
    mass, speed = np.linspace(0.3, 2.0, count), np.full(count, 1.5)
    travel = brakes.sheets.usable_travel
    vacuum = tuned_stop(mass, speed, travel, 2e4, 9.81, brakes)
    solved = np.isfinite(vacuum)
    assert solved.sum() >= 5
    spring = rope_spring(2e4, brakes) + 0.0 * mass
    stops = stop(mass, speed, np.where(solved, vacuum, 1e4), spring, 9.81, brakes)
    assert (stops.outcome[solved] == STOPPED).all()
    assert stops.slip[solved] == pytest.approx(travel[solved], rel=2.1e-6)
