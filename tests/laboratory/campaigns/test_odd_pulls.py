"""Faults of grips, seats and single pulls are what they say, against a solution of our own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from layerjam.core.errors import QuantityError
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.campaign_files import format_truth
from layerjam.laboratory.campaigns.spec import Faults, Odd, Pulls, Spec, Truth
from strategies import KAPTON

VACUUM, SPEED, STIFFNESS = 70e3, 10e-3, 131e3
SPEC = Spec(
    brakes=(Truth(brake="choi2018-kapton"),),
    pulls=Pulls(vacuums=(40e3, VACUUM), speeds=(SPEED, 2 * SPEED), repeats=2, travel=0.04),
    machine=Faults(sampling_rate=1000.0),
)


def by_hand(u: float, share: float, fades: float, depth: float, load: float) -> float:
    """Force [N] at an elongation, written from mechanics.md, by bisection on the force.

    The slip that a force leaves is u - F/k - s(F); the force that holds there must be F.
    """
    film, sheets, rubber = KAPTON.film, KAPTON.sheets, KAPTON.enclosure
    width = sheets.width
    per_length = KAPTON.scale_factor * film.kinetic * (sheets.count - 1) * width * VACUUM
    area = width * rubber.wall
    root = 2 * math.sqrt(rubber.modulus * area * VACUUM * film.friction_on_silicone * width)

    def left(force: float) -> float:
        slip = u - force / STIFFNESS - depth * (1 - math.exp(-force / load))
        if slip <= 0:
            return 1.0  # stuck: the force would be less
        sheet = per_length * (sheets.overlap - slip)
        return force - sheet * (1 + share * math.exp(-slip / fades)) - root * math.sqrt(slip)

    # stuck until the elongation is used up, then the greatest force at which it holds
    low, high = 0.0, 400.0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (low, middle) if left(middle) > 0 else (middle, high)
    return low


@pytest.mark.parametrize(("share", "depth"), [(0.0, 2e-4), (0.15, 0.0), (0.15, 2e-4)])
def test_overshoot_and_seat_follow_their_law(share: float, depth: float) -> None:
    machine = replace(
        SPEC.machine, overshoot=share, overshoot_slip=2e-3, seating=depth, seating_force=40.0
    )
    one = replace(SPEC.pulls, vacuums=(VACUUM,), speeds=(SPEED,), repeats=1)
    [trace] = campaign(replace(SPEC, pulls=one, machine=machine)).traces()
    at = [20, 60, 90, 120, 140, 150, 170, 200, 400, 1000, 4000]
    expected = [by_hand(float(trace.elongation[i]), share, 2e-3, depth, 40.0) for i in at]
    np.testing.assert_allclose(trace.force[at], expected, rtol=1e-6, atol=1e-6)


def test_a_friction_that_falls_too_fast_is_refused() -> None:
    steep = replace(SPEC.machine, overshoot=0.5, overshoot_slip=1e-4)
    with pytest.raises(QuantityError, match="the brake would snap"):
        campaign(replace(SPEC, machine=steep)).traces()


def test_only_the_odd_pulls_change_and_the_truth_names_them() -> None:
    plain = campaign(SPEC).traces()
    made = campaign(replace(SPEC, odd=Odd(how_many=3, friction_change=0.2, stiffness_change=-0.1)))
    odd = {i for i, test in enumerate(made.tests) if test.odd}
    assert len(odd) == 3
    for i, (before, after) in enumerate(zip(plain, made.traces(), strict=True)):
        if i not in odd:
            np.testing.assert_array_equal(before.force, after.force)
            continue
        assert after.force.max() == pytest.approx(1.2 * before.force.max(), rel=0.01)
        stuck = slice(5, 20)
        np.testing.assert_allclose(after.force[stuck], 0.9 * before.force[stuck], rtol=1e-9)
    assert format_truth(made).count("odd = true") == 3
    assert "odd = true" not in format_truth(campaign(SPEC))


def test_a_whole_vacuum_and_a_speed() -> None:
    made = campaign(replace(SPEC, odd=Odd(how_many=1, per="vacuum", vacuum_change=-0.1)))
    odd = [test for test in made.tests if test.odd]
    assert len({test.vacuum for test in odd}) == 1 and len(odd) == 4
    assert all(test.true_vacuum == pytest.approx(0.9 * test.vacuum) for test in odd)
    fast = campaign(replace(SPEC, odd=Odd(how_many=1, speed_change=0.25)))
    for test, trace in zip(fast.tests, fast.traces(), strict=True):
        pace = float(trace.elongation[-1] / trace.time[-1])
        assert trace.facts.speed == test.speed
        assert pace == pytest.approx((1.25 if test.odd else 1.0) * test.speed, rel=1e-6)


@pytest.mark.parametrize(
    ("odd", "words"),
    [
        (Odd(how_many=9, friction_change=0.1), "only 8 are possible"),
        (Odd(how_many=3, per="vacuum", friction_change=0.1), "only 2 are possible"),
        (Odd(how_many=8, vacuum_change=0.5), "cannot exceed atmospheric pressure"),
    ],
)
def test_what_cannot_be_is_refused(odd: Odd, words: str) -> None:
    with pytest.raises(QuantityError, match=words):
        campaign(replace(SPEC, odd=odd))
