"""Every number that mechanics.md prints in sections 1 and 2, to every digit printed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_stretch, saturation_slip
from layerjam.brake.mechanics.energy import energy_capacity, pull_work, slip_work
from layerjam.brake.mechanics.friction import holding_force, sheet_friction
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.limits import (
    buckling_force,
    clamp_stress,
    self_closing_vacuum,
    sheet_stress,
    travel_left,
)
from layerjam.brake.mechanics.pull import (
    brake_force,
    force_limits,
    least_stiffness,
    peak,
    peak_vacuum,
    slip_at_elongation,
    vacuum_for_force,
)
from layerjam.brake.mechanics.stiffness import (
    mount_stiffness,
    stiffness_before_slip,
    stiffness_sliding,
    working_stiffness,
)
from strategies import KAPTON, PTFE, padded

FULL = 94.5e3
BOTH = [KAPTON, PTFE]


def prints_as(value: float, text: str) -> bool:
    """True where the value, rounded to the digits of the text, is the text."""
    return f"{float(value):.{len(text.partition('.')[2])}f}" == text


def force_at(elongation: float, brake) -> float:
    k = brake.stiffness_measured
    return k * (elongation - float(slip_at_elongation(elongation, FULL, brake)))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (lambda: sheet_friction(0.0, FULL, KAPTON), "175.4298"),
        (lambda: sheet_friction(0.0, FULL, PTFE), "51.79356"),
        (lambda: brake_force(0.02, FULL, KAPTON), "133.942755"),
        (lambda: brake_force(0.04, FULL, KAPTON), "86.5334362"),
        (lambda: peak(FULL, 0.06, KAPTON).force, "175.925038"),
        (lambda: peak(FULL, 0.06, PTFE).force, "52.2758181"),
        (lambda: peak(FULL, 0.06, KAPTON).slip * 1e3, "0.19196391"),
        (lambda: peak(FULL, 0.06, PTFE).slip * 1e3, "0.63315880"),
        (lambda: peak(FULL, 0.06, KAPTON).elongation * 1e3, "1.53490313"),
        (lambda: peak(FULL, 0.06, PTFE).elongation * 1e3, "1.58362822"),
        (lambda: force_at(0.04, KAPTON), "88.1486228"),
        (lambda: force_at(0.04, PTFE), "29.3481365"),
        (lambda: pull_work(0.04, FULL, KAPTON), "5.30546849"),
        (lambda: pull_work(0.04, FULL, PTFE), "1.65910443"),
        (lambda: slip_work(0.04, FULL, KAPTON), "5.33458230"),
        (lambda: slip_work(0.04, FULL, PTFE), "1.66683982"),
        (lambda: energy_capacity(KAPTON), "7.03"),
        (lambda: sheet_friction(0.0, FULL, KAPTON) / 10, "17.543"),
    ],
)
def test_check_table(value, text):
    assert prints_as(value(), text)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (lambda: stiffness_before_slip(KAPTON) / 1e3, "808"),
        (lambda: stiffness_sliding(0.0, KAPTON) / 1e3, "2047"),
        (lambda: stiffness_sliding(0.04, KAPTON) / 1e3, "441"),
        (lambda: stiffness_sliding(0.0, PTFE) / 1e3, "409"),
        (lambda: mount_stiffness(KAPTON) / 1e3, "156"),
        (lambda: mount_stiffness(PTFE) / 1e3, "83"),
        (lambda: peak_vacuum(KAPTON) / 1e3, "1.06"),
        (lambda: peak_vacuum(PTFE) / 1e3, "3.58"),
        (lambda: self_closing_vacuum(0.04, KAPTON) / 1e3, "3.70"),
        (lambda: self_closing_vacuum(0.04, PTFE) / 1e3, "12.2"),
        (lambda: least_stiffness(FULL, KAPTON) / 1e3, "2.58"),
        (lambda: brake_cycle(*padded([0.04], FULL)[:2], KAPTON).force[0], "88.1486228"),
    ],
)
def test_printed_in_the_text(value, text):
    assert prints_as(value(), text)


def test_stretch_is_550_percent_and_a_sixth_of_the_force():
    assert float(enclosure_stretch(0.04, 101325.0, KAPTON)) == pytest.approx(5.5, rel=0.05)
    share = float(enclosure_force(0.04, FULL, KAPTON) / brake_force(0.04, FULL, KAPTON))
    assert share == pytest.approx(1 / 6, rel=0.05)


@pytest.mark.parametrize("brake", BOTH)
def test_forces_by_hand(brake):
    """The closed forms, written down a second time from section 2 with plain floats."""
    s, film, a = brake.sheets, brake.film, brake.scale_factor
    area = s.width * brake.enclosure.wall
    c = a * film.kinetic * (s.count - 1) * s.width * FULL
    e = 2 * math.sqrt(brake.enclosure.modulus * area * film.friction_on_silicone * s.width * FULL)
    x = 0.013
    assert float(brake_force(x, FULL, brake)) == pytest.approx(
        c * (s.overlap - x) + e * math.sqrt(x), rel=1e-14
    )
    assert float(sheet_friction(x, FULL, brake)) == pytest.approx(c * (s.overlap - x), rel=1e-14)
    assert float(sheet_friction(s.overlap * 1.1, FULL, brake)) == 0
    work = c * (s.overlap * x - x * x / 2) + 2 / 3 * e * x**1.5
    assert float(slip_work(x, FULL, brake)) == pytest.approx(work, rel=1e-14)
    found = peak(FULL, 0.06, brake)
    assert float(found.slip) == pytest.approx((e / 2 / c) ** 2, rel=1e-13)
    assert float(found.force) == pytest.approx(c * s.overlap + e * e / 4 / c, rel=1e-13)
    assert bool(found.inside)
    assert float(least_stiffness(FULL, brake)) == pytest.approx(c, rel=1e-14)
    ratio = film.static / film.kinetic
    assert float(holding_force(FULL, brake)) == pytest.approx(c * s.overlap * ratio, rel=1e-14)


@pytest.mark.parametrize("brake", BOTH)
def test_saturation_is_continuous_in_value_and_slope(brake):
    vacuum = 800.0
    q = brake.film.friction_on_silicone * brake.sheets.width * vacuum
    stiffness = brake.enclosure.modulus * brake.sheets.width * brake.enclosure.wall
    x = float(saturation_slip(vacuum, brake))
    assert x == pytest.approx(q * 0.045**2 / stiffness, rel=1e-14)
    assert float(enclosure_force(x, vacuum, brake)) == pytest.approx(2 * q * 0.045, rel=1e-12)
    at = x * (1 + np.array([-2e-6, -1e-6, 1e-6, 2e-6]))
    f = np.asarray(enclosure_force(at, vacuum, brake))
    slopes = np.diff(f) / np.diff(at)
    assert slopes == pytest.approx(stiffness / 0.045, rel=1e-5)
    beyond = 2 * (stiffness * 1.7 * x / 0.09 + q * 0.045 / 2)
    assert float(enclosure_force(1.7 * x, vacuum, brake)) == pytest.approx(beyond, rel=1e-13)


@pytest.mark.parametrize("brake", BOTH)
def test_limits_of_no_and_full_vacuum(brake):
    stiffness = brake.enclosure.modulus * brake.sheets.width * brake.enclosure.wall
    x = np.linspace(0, 0.06, 7)
    alone = stiffness * x / 0.045
    assert np.asarray(brake_force(x, 0.0, brake)) == pytest.approx(alone, rel=1e-13)
    assert np.asarray(brake_force(x, 1e-9, brake)) == pytest.approx(alone, rel=1e-6, abs=1e-9)
    low, high = force_limits(x, brake)
    assert np.asarray(low) == pytest.approx(alone, rel=1e-13)
    full = brake_force(x, brake.site.atmosphere, brake)
    assert np.asarray(high) == pytest.approx(np.asarray(full), rel=1e-13)
    near = np.asarray(full) * (1 - 1e-12)
    assert np.asarray(vacuum_for_force(near, x, brake)) == pytest.approx(101325.0, rel=1e-10)


@pytest.mark.parametrize("brake", BOTH)
def test_peak_only_above_its_vacuum(brake):
    bound = float(peak_vacuum(brake))
    below, above = peak(bound * 0.98, 1.0, brake), peak(bound * 1.02, 1.0, brake)
    assert not bool(below.inside) and float(below.slip) == 1.0
    assert bool(above.inside)
    short = peak(FULL, 1e-4, brake)
    assert not bool(short.inside) and float(short.slip) == 1e-4
    assert float(short.force) == pytest.approx(float(brake_force(1e-4, FULL, brake)), rel=1e-14)
    k = brake.stiffness_measured
    assert float(short.elongation) == pytest.approx(1e-4 + float(short.force) / k, rel=1e-14)


def test_odd_and_even_stacks():
    """ceil(n/2) sheets left, floor(n/2) right; without a measured k the computed one stands in."""
    from strategies import change

    for count, left, right in ((11, 6, 5), (10, 5, 5), (2, 1, 1), (3, 2, 1)):
        brake = change(KAPTON, sheets__count=count, sheets__free_right=0.02)
        one = 2.5e9 * 0.013 * 0.254e-3
        stuck = one / (0.011 / left + 0.068 / count + 0.02 / right)
        sliding = one / (0.016 / left + 0.025 / right)
        assert float(stiffness_before_slip(brake)) == pytest.approx(stuck, rel=1e-13)
        assert float(stiffness_sliding(0.005, brake)) == pytest.approx(sliding, rel=1e-13)
        assert float(working_stiffness(brake)) == 131e3
        free = change(brake, stiffness_measured=None)
        assert float(working_stiffness(free)) == pytest.approx(stuck, rel=1e-13)
        assert float(mount_stiffness(free)) == math.inf
        assert float(sheet_stress(100.0, brake)) == pytest.approx(
            100 / (right * 0.013 * 0.254e-3), rel=1e-13
        )
        assert float(clamp_stress(100.0, brake)) == pytest.approx(
            100 / (right * 0.010 * 0.254e-3), rel=1e-13
        )


def test_buckling_and_travel():
    inertia = 0.013 * 0.254e-3**3 / 12
    expected = math.pi**2 * 2.5e9 * inertia / (4 * 0.031**2)
    assert float(buckling_force(0.02, KAPTON)) == pytest.approx(expected, rel=1e-13)
    assert np.asarray(travel_left([0.0, 0.07], KAPTON)) == pytest.approx([0.068, -0.002])
