"""Closed forms against numerical quadrature, root finding and each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from layerjam.brake.mechanics.enclosure import (
    enclosure_law,
    enclosure_stretch,
    make_enclosure,
    saturation_slip,
)
from layerjam.brake.mechanics.energy import energy_capacity, pull_work, slip_heat, slip_work
from layerjam.brake.mechanics.limits import buckling_force, self_closing_vacuum
from layerjam.brake.mechanics.pull import brake_force, peak, slip_at_elongation
from strategies import KAPTON, PTFE, change, one, random_brakes

WEAK = change(KAPTON, film__kinetic=0.02, sheets__count=2)
CASES = [(KAPTON, 94.5e3), (KAPTON, 900.0), (PTFE, 20e3), (PTFE, 300.0), (WEAK, 5e3)]


def force(x: float, vacuum: float, brake) -> float:
    """F(x) in plain floats, both branches of the sleeve."""
    s, film, sleeve = brake.sheets, brake.film, brake.enclosure
    c = brake.scale_factor * film.kinetic * (s.count - 1) * s.width * vacuum
    return c * max(s.overlap - x, 0.0) + sleeve_force(x, vacuum, s, film, sleeve)


def sleeve_force(x, vacuum, s, film, sleeve):
    stiffness = sleeve.modulus * s.width * sleeve.wall
    q = film.friction_on_silicone * s.width * vacuum
    reach = (s.free_left + s.overlap + s.free_right) / 2
    if x < q * reach**2 / stiffness:
        return 2 * (stiffness * q * x) ** 0.5
    return 2 * (stiffness * x / (2 * reach) + q * reach / 2)


def integral(function, end: float, kink: float) -> float:
    inner = [p for p in (kink, end) if p <= end]
    total, start = 0.0, 0.0
    for stop in sorted({*inner, end}):
        total += quad(function, start, stop, epsabs=1e-14, epsrel=1e-12)[0]
        start = stop
    return total


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_work_is_the_integral_of_force(brake, vacuum):
    kink = float(saturation_slip(vacuum, brake))
    for end in (1e-4, 0.01, 0.04, 0.067):
        expected = integral(lambda x: force(x, vacuum, brake), end, kink)
        assert float(slip_work(end, vacuum, brake)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_stored_energy_and_heat_of_the_sleeve_from_its_tension(brake, vacuum):
    """Energy from T(s) = T0 - q s, heat from q times the way of every point; quadrature in s."""
    sleeve = enclosure_law(vacuum, brake)
    q, stiff, reach = (float(v) for v in (sleeve.friction, sleeve.stiffness, sleeve.reach))
    for x in (1e-4, 0.01, 0.04):
        end = float(sleeve.force(x)) / 2
        deep = min(end / q, reach)
        energy = quad(lambda s, t=end: (t - q * s) ** 2 / (2 * stiff), 0, deep)[0]
        assert float(sleeve.stored_energy(x)) == pytest.approx(4 * energy, rel=1e-9)

        def moved(s, t=end, d=deep):
            return ((t * d - q * d**2 / 2) - (t * s - q * s**2 / 2)) / stiff

        heat = quad(lambda s: q * moved(s), 0, deep)[0]
        assert float(sleeve.heat(x)) == pytest.approx(4 * heat, rel=1e-9)
        assert moved(0.0) == pytest.approx(x / 2, rel=1e-12)
        total = sleeve.stored_energy(x) + sleeve.heat(x)
        assert float(sleeve.work(x)) == pytest.approx(float(total), rel=1e-13)
        assert float(enclosure_stretch(x, vacuum, brake)) == pytest.approx(end / stiff, rel=1e-13)


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_inverse_of_the_first_loading(brake, vacuum):
    sleeve = enclosure_law(vacuum, brake)
    x = np.array([0.0, 1e-7, 1e-4, 0.003, 0.04, 0.3])
    assert np.asarray(sleeve.find_slip(sleeve.force(x), 0.0)) == pytest.approx(x, rel=1e-12)


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_heat_is_all_friction(brake, vacuum):
    sleeve = enclosure_law(vacuum, brake)
    x = np.array([0.0, 0.001, 0.02, 0.05])
    left = np.asarray(slip_work(x, vacuum, brake) - slip_heat(x, vacuum, brake))
    assert left == pytest.approx(np.asarray(sleeve.stored_energy(x)), rel=1e-10, abs=1e-14)


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_slip_at_elongation_solves_the_series(brake, vacuum):
    k = brake.stiffness_measured
    onset = force(0.0, vacuum, brake) / k
    for u in onset + np.array([1e-6, 1e-4, 0.01, 0.04, 0.2]):
        x = brentq(lambda x, u=u: k * (u - x) - force(x, vacuum, brake), 0, u, xtol=1e-15)
        assert float(slip_at_elongation(u, vacuum, brake)) == pytest.approx(x, rel=1e-8)
    assert float(slip_at_elongation(onset * (1 - 1e-9), vacuum, brake)) == 0.0


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_pull_work_is_the_integral_over_the_crosshead(brake, vacuum):
    k, end = brake.stiffness_measured, 0.03
    onset = force(0.0, vacuum, brake) / k
    past = np.linspace(0, 1, 4001) ** 2 * (end - onset) + onset
    f = k * (past - np.asarray(slip_at_elongation(past, vacuum, brake)))
    numeric = onset * force(0.0, vacuum, brake) / 2
    numeric += float(((f[1:] + f[:-1]) / 2 * np.diff(past)).sum())
    assert float(pull_work(end, vacuum, brake)) == pytest.approx(numeric, rel=2e-6)


@pytest.mark.parametrize(("brake", "vacuum"), CASES)
def test_peak_is_the_greatest_force(brake, vacuum):
    """A search over the plain force finds nothing greater, and the same place."""
    found = peak(vacuum, 0.06, brake)
    x = np.linspace(0, 0.06, 20001)
    most = max(force(v, vacuum, brake) for v in x)
    assert float(found.force) >= most * (1 - 1e-14)
    if bool(found.inside):
        best = minimize_scalar(
            lambda v: -force(v, vacuum, brake), bounds=(0, 0.06), options={"xatol": 1e-9}
        )
        assert float(found.slip) == pytest.approx(best.x, rel=2e-3)
    assert float(found.force) == pytest.approx(force(float(found.slip), vacuum, brake), rel=1e-13)


@pytest.mark.parametrize("strength", [1.0, 2.0])
def test_slip_under_a_force_and_a_spring_in_every_branch(strength):
    for vacuum in (0.0, 50.0, 900.0, 94.5e3):
        sleeve = enclosure_law(vacuum, KAPTON)
        sleeve = make_enclosure(sleeve.stiffness, strength * sleeve.friction, sleeve.reach)
        for spring in (0.0, 10.0, 5e4):
            drive = np.array([1e-6, 0.01, 1.0, 30.0, 900.0])
            y = np.asarray(sleeve.find_slip(drive, spring))
            back = spring * y + np.asarray(sleeve.force(y))
            assert back == pytest.approx(drive, rel=1e-10)
            assert float(sleeve.find_slip(-1.0, spring)) == 0.0
            assert float(sleeve.find_slip(0.0, spring)) == 0.0


@pytest.mark.parametrize("seed", range(12))
def test_self_closing_vacuum_is_where_friction_meets_the_sleeve(seed):
    brakes = random_brakes(seed, 40)
    for index in range(40):
        brake = one(brakes, index)
        s, film, sleeve = brake.sheets, brake.film, brake.enclosure
        x = s.overlap * 0.6
        vacuum = float(self_closing_vacuum(x, brake))
        pull = sleeve_force(x, vacuum, s, film, sleeve)
        assert force(x, vacuum, brake) - pull == pytest.approx(pull, rel=1e-9)
        less = sleeve_force(x, vacuum * 0.99, s, film, sleeve)
        assert less > force(x, vacuum * 0.99, brake) - less


def test_self_closing_at_the_ends_of_the_overlap():
    assert float(self_closing_vacuum(0.0, KAPTON)) == 0.0
    # at rest nothing is stretched, however hard the sleeve holds on once it is
    sticky = replace(KAPTON, film=replace(KAPTON.film, friction_on_silicone=5.0))
    assert float(self_closing_vacuum(0.0, sticky)) == 0.0
    assert np.isinf(float(self_closing_vacuum(0.068, KAPTON)))
    assert np.isnan(float(self_closing_vacuum(-1e-3, KAPTON)))


def test_self_closing_with_a_pressure_exponent_just_below_the_atmosphere():
    """Where full vacuum holds the sleeve by less than a newton, the closing vacuum is near it."""
    brake = change(KAPTON, pressure_exponent=0.1, test_pressure=3900.0)
    full = brake.site.atmosphere

    def spare(x: float) -> float:
        held = float(brake_force(x, full, brake))
        pull = float(sleeve_force(x, full, brake.sheets, brake.film, brake.enclosure))
        return held - 2 * pull

    x = brentq(lambda x: spare(x) - 0.5, 0.03, 0.0679)
    assert 0.9 * full < float(self_closing_vacuum(x, brake)) < full
    assert np.isinf(float(self_closing_vacuum(brentq(spare, 0.03, 0.0679) + 1e-5, brake)))


def test_the_longer_free_length_buckles_first():
    left = change(KAPTON, sheets__free_left=0.02)
    right = change(KAPTON, sheets__free_right=0.02)
    assert float(buckling_force(0.0, left)) == float(buckling_force(0.0, right))
    assert float(buckling_force(0.0, left)) < float(buckling_force(0.0, KAPTON))


def test_a_relaxed_sleeve_stores_and_pulls_nothing_at_any_vacuum():
    for vacuum in (0.0, 10.0, 9e4):
        at = enclosure_law(vacuum, KAPTON)
        assert float(at.force(0.0)) == 0.0
        assert float(at.stored_energy(0.0)) == 0.0


def test_capacity_uses_travel_and_atmosphere():
    brake = change(PTFE, sheets__usable_travel=0.03, site__atmosphere=80e3)
    kink = float(saturation_slip(80e3, brake))
    expected = integral(lambda x: force(x, 80e3, brake), 0.03, kink)
    assert float(energy_capacity(brake)) == pytest.approx(expected, rel=1e-10)


def test_force_over_the_grid_is_the_plain_one():
    for brake, vacuum in CASES:
        x = np.linspace(0, brake.sheets.overlap, 41)
        plain = [force(v, vacuum, brake) for v in x]
        assert np.asarray(brake_force(x, vacuum, brake)) == pytest.approx(plain, rel=1e-13)


def test_past_the_overlap_only_the_sleeve_is_left():
    u = 0.4
    x = float(slip_at_elongation(u, 94.5e3, KAPTON))
    assert x > 0.068
    k = KAPTON.stiffness_measured
    assert k * (u - x) == pytest.approx(force(x, 94.5e3, KAPTON), rel=1e-9)
