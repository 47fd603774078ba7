"""A mass stopped by the brake: check values, energy, first root, time, gradients, tuning."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.mechanics.enclosure import enclosure_force, enclosure_law
from layerjam.brake.mechanics.energy import slip_heat, slip_work
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.pull import brake_force, peak
from layerjam.brake.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    speed_at_slip,
    stop,
    time_at_slip,
)
from layerjam.brake.mechanics.stop.tune import tuned_vacuum, vacuum_eq10
from strategies import KAPTON, PTFE, random_brakes, unchecked

G = 9.80665
ROPE = 16.8e3
SPRING = 1 / (1 / 131e3 + 1 / ROPE)


def test_the_two_check_drops():
    first = stop(1.0, 2.5, 94.5e3, SPRING, G, KAPTON)
    assert float(first.slip) == pytest.approx(17.0251044e-3, abs=5e-11)
    assert float(first.peak_force) == pytest.approx(175.925038, abs=5e-7)
    second = stop(1.0, 3.0, 80e3, SPRING, G, KAPTON)
    assert float(second.slip) == pytest.approx(44.0565365e-3, abs=5e-11)
    assert float(second.peak_force) == pytest.approx(149.007238, abs=5e-7)
    assert int(first.outcome) == int(second.outcome) == STOPPED
    assert float(first.end_speed) == 0.0


def test_too_fast_runs_out_of_travel_and_the_limit_is_where_it_does():
    fast = stop(1.0, 3.7, 94.5e3, SPRING, G, KAPTON)
    assert int(fast.outcome) == BOTTOMED_OUT
    assert float(fast.slip) == KAPTON.sheets.usable_travel
    assert float(fast.end_speed) == pytest.approx(1.29, abs=5e-3)
    outcome = np.asarray(stop(1.0, np.array([3.465, 3.475]), 94.5e3, SPRING, G, KAPTON).outcome)
    assert outcome.tolist() == [STOPPED, BOTTOMED_OUT]


def test_the_first_standstill_counts_although_the_energy_is_positive_again_later():
    heavy = stop(12.0, 0.2, 94.5e3, SPRING, G, KAPTON)
    assert float(heavy.slip) == pytest.approx(15.68e-3, abs=5e-6)
    for slip in (0.02, KAPTON.sheets.usable_travel):
        assert np.isnan(float(speed_at_slip(slip, 12.0, 0.2, 94.5e3, SPRING, G, KAPTON)))


def test_a_slow_mass_never_makes_it_slide_and_swings_on_the_spring():
    mass, speed = 1.0, 0.2
    slow = stop(mass, speed, 94.5e3, SPRING, G, KAPTON)
    assert int(slow.outcome) == NEVER_SLID
    assert float(slow.slip) == 0.0
    assert float(slow.heat) == 0.0
    elastic = mass * G + np.sqrt((mass * G) ** 2 + SPRING * mass * speed**2)
    assert float(slow.peak_force) == pytest.approx(elastic, rel=1e-14)
    swing = solve_ivp(
        lambda t, y: [y[1], G - SPRING / mass * y[0]], (0, 1), [0, speed],
        events=[_standstill], rtol=1e-12, atol=1e-14,
    )  # fmt: skip
    time = float(time_at_slip(0.0, mass, speed, 94.5e3, SPRING, G, KAPTON))
    assert time == pytest.approx(swing.t_events[0][0], rel=1e-9)


def _standstill(_: float, y: list[float]) -> float:
    return y[1]


_standstill.terminal = True
_standstill.direction = -1


def test_a_spring_softer_than_the_softening_snaps():
    soft = stop(12.0, 2.5, 94.5e3, 2000.0, G, KAPTON)
    assert int(soft.outcome) == SNAPS
    slope = float(jax.grad(lambda x: brake_force(x, 94.5e3, KAPTON))(float(soft.slip)))
    assert slope == pytest.approx(-2000.0, rel=1e-9)
    firm = stop(12.0, 2.5, 94.5e3, 2600.0, G, KAPTON)
    assert int(firm.outcome) != SNAPS


def test_a_spring_that_the_sleeve_still_helps_does_not_snap():
    """Between c - EA/l and c the force never falls faster than the spring gives."""
    at = enclosure_law(2e3, KAPTON)
    c = float(friction_per_contact(2e3, KAPTON))
    least = c - float(at.stiffness / at.reach)
    assert float(at.saturation) < KAPTON.sheets.usable_travel
    case = (5.0, 2.0, 2e3, np.array([least * 0.999, least * 1.001, c * 0.999]), G, KAPTON)
    assert np.asarray(stop(*case).outcome).tolist() == [SNAPS, BOTTOMED_OUT, BOTTOMED_OUT]


def test_what_is_no_case_is_neither_a_number_nor_an_outcome():
    bad = np.array([np.nan, 0.0, -1.0, 1.0])
    result = stop(bad, 2.5, 94.5e3, SPRING, G, KAPTON)
    assert np.asarray(result.outcome).tolist() == [NOT_A_CASE] * 3 + [STOPPED]
    assert np.isnan(result.slip[:3]).all()
    film = unchecked(KAPTON.film, kinetic=np.nan)
    lost = stop(1.0, 2.5, 94.5e3, SPRING, G, unchecked(KAPTON, film=film))
    assert int(lost.outcome) == NOT_A_CASE
    assert all(np.isnan(float(v)) for v in lost[:-1])


@pytest.mark.parametrize(("mass", "speed", "vacuum"), [(1, 2.5, 94.5e3), (3, 1.2, 60e3)])
def test_time_and_speed_agree_with_an_integration_in_time(mass, speed, vacuum):
    result = stop(mass, speed, vacuum, SPRING, G, KAPTON)
    slips = float(result.slip) * np.array([0.01, 0.1, 0.5, 0.9])
    travel = slips + np.asarray(brake_force(slips, vacuum, KAPTON)) / SPRING
    grid = np.concatenate([[0], np.geomspace(1e-9, float(result.slip) * 1.01, 20000)])
    resist = np.asarray(brake_force(grid, vacuum, KAPTON))
    way = np.concatenate([[0], grid + resist / SPRING])
    force = np.concatenate([[0], resist])
    run = solve_ivp(
        lambda t, y: [y[1], G - np.interp(y[0], way, force) / mass], (0, 0.2), [0, speed],
        events=[_standstill], rtol=1e-10, atol=1e-13, max_step=2e-5, dense_output=True,
    )  # fmt: skip
    times = np.asarray(time_at_slip(slips, mass, speed, vacuum, SPRING, G, KAPTON))
    assert run.sol(times)[0] == pytest.approx(travel, rel=2e-6)
    pace = np.asarray(speed_at_slip(slips, mass, speed, vacuum, SPRING, G, KAPTON))
    assert run.sol(times)[1] == pytest.approx(pace, rel=2e-6)
    end = float(time_at_slip(result.slip, mass, speed, vacuum, SPRING, G, KAPTON))
    assert end == pytest.approx(run.t_events[0][0], rel=1e-6)


def by_panels(mass, speed, vacuum, spring, gravity, brake, slip):
    """Seconds to `slip` [m]: sum of dz/v over panels that shrink towards every awkward point.

    Own force, own work; 12,000 panels of two Gauss points, graded to 1e-13 of the slip around
    start, end, slowest point and saturation.
    """
    sheets, skin, film = brake.sheets, brake.enclosure, brake.film
    c = brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width * vacuum
    ea, q = skin.modulus * sheets.width * skin.wall, film.friction_on_silicone * sheets.width
    q, reach = q * vacuum, (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    onset, e, whole = c * sheets.overlap, 2 * np.sqrt(ea * q), q * reach**2 / ea

    def force(x):
        beyond = ea * x / reach + q * reach
        return onset - c * x + np.where(x < whole, e * np.sqrt(x), beyond)

    def work(x):
        near = np.minimum(x, whole)
        far = x - near
        more = ea / reach * (x + near) / 2 * far + q * reach * far
        return onset * x - c * x**2 / 2 + 2 / 3 * e * near**1.5 + more

    def pace(x):
        drawn = x + force(x) / spring
        left = mass * speed**2 / 2 + mass * gravity * drawn - work(x) - force(x) ** 2 / 2 / spring
        return np.sqrt(2 / mass * np.maximum(left, 0))

    omega = np.sqrt(spring / mass)
    sag, swing = gravity / omega**2, speed / omega
    size, phase = np.hypot(sag, swing), np.arctan2(sag, swing)
    if onset / spring - sag >= size:
        return (np.pi / 2 + phase) / omega
    time = (np.arcsin((onset / spring - sag) / size) + phase) / omega
    if slip == 0:
        return time
    coarse = np.linspace(0, slip, 20_001)
    slowest = coarse[np.argmin(pace(coarse))]
    near = np.geomspace(1e-13, 1, 1500) * slip
    edges = np.concatenate([[x, *(x - near), *(x + near)] for x in (0, slip, slowest, whole)])
    edges = np.unique(edges[(edges >= 0) & (edges <= slip)])
    half, middle = np.diff(edges) / 2, (edges[1:] + edges[:-1]) / 2
    for shift in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
        x = middle + shift * half
        e_slope = np.where(x < whole, e / 2 / np.sqrt(x), ea / reach)
        v = pace(x)
        time += (half * (1 + (e_slope - c) / spring) / np.where(v > 0, v, np.inf)).sum()
    return time


def test_time_of_a_mass_that_barely_passes_or_barely_stops():
    """Near the least speed that passes the time grows as the logarithm of what is left of it."""
    mass, low, high = 12.0, 0.2, 0.3
    for _ in range(4):  # the least speed that passes
        speeds = np.linspace(low, high, 2001)
        stops = np.asarray(stop(mass, speeds, 94.5e3, SPRING, G, KAPTON).outcome) == STOPPED
        low, high = speeds[stops].max(), speeds[~stops].min()
    times = {}
    for off in (-1e-3, -1e-5, -1e-7, 1e-7, 1e-5, 1e-3):
        speed = low * (1 + off)
        end = float(stop(mass, speed, 94.5e3, SPRING, G, KAPTON).slip)
        # at the standstill itself the last digits of the slip are worth some 1e-6 of the time
        for slip, rel in ((end, 1e-5), (end * 0.9999, 1e-6)):
            times[off] = float(time_at_slip(slip, mass, speed, 94.5e3, SPRING, G, KAPTON))
            there = by_panels(mass, speed, 94.5e3, SPRING, G, KAPTON, slip)
            assert times[off] == pytest.approx(there, rel=rel), (off, slip)
    assert times[1e-7] - times[1e-5] == pytest.approx(times[1e-5] - times[1e-3], rel=0.01)
    reported = float(time_at_slip(0.06, mass, 0.24678, 94.5e3, SPRING, G, KAPTON))
    assert reported == pytest.approx(0.737, abs=5e-4)


def _random_cases(n: int, seed: int = 3):
    rng = np.random.default_rng(seed)
    brake = random_brakes(seed, n)
    top = brake.site.atmosphere
    vacuum = top * rng.uniform(0.0, 1.0, n)
    force = np.asarray(peak(vacuum, brake.sheets.usable_travel, brake).force)
    energy = np.asarray(slip_work(brake.sheets.usable_travel, vacuum, brake))
    mass = (force + 0.01) / G * 10 ** rng.uniform(-2, 0.3, n)
    speed = np.sqrt(2 * (energy + 1e-6) / mass) * 10 ** rng.uniform(-1.2, 0.3, n)
    gravity = np.where(rng.random(n) < 0.3, 0.0, G)
    return mass, speed, vacuum, brake.stiffness_measured, gravity, brake


def test_times_of_random_brakes_agree_with_a_fine_sum():
    """Stopping, passing, with the enclosure saturated on the way, on any slip."""
    mass, speed, vacuum, spring, gravity, brake = _random_cases(30, seed=21)
    vacuum = vacuum * np.where(np.arange(30) % 3 == 0, 0.05, 1.0)
    result = stop(mass, speed, vacuum, spring, gravity, brake)
    outcome = np.asarray(result.outcome)
    slips = np.asarray(result.slip) * np.where(np.arange(30) % 2, 0.97, 1.0)
    times = time_at_slip(slips, mass, speed, vacuum, spring, gravity, brake)
    seen = 0
    for i in np.flatnonzero((outcome == STOPPED) | (outcome == BOTTOMED_OUT)):
        one = jax.tree.map(lambda leaf, i=i: float(np.asarray(leaf)[i]), brake)
        case = (float(mass[i]), float(speed[i]), float(vacuum[i]), float(spring[i]))
        there = by_panels(*case, float(gravity[i]), one, float(slips[i]))
        assert float(times[i]) == pytest.approx(there, rel=1e-6), i
        seen += float(np.asarray(result.slip)[i]) > 0
    assert seen > 15


def test_energy_closes_for_thousands_of_random_brakes_in_every_outcome():
    mass, speed, vacuum, spring, gravity, brake = case = _random_cases(4000)
    result = stop(*case)
    force = np.where(
        np.asarray(result.outcome) == NEVER_SLID,
        np.asarray(result.peak_force),
        np.asarray(brake_force(result.slip, vacuum, brake)),
    )
    way = np.asarray(result.slip) + force / spring
    brought = mass * speed**2 / 2 + mass * gravity * way
    held = np.asarray(result.heat) + np.asarray(result.stored)
    left = brought - held - mass * np.asarray(result.end_speed) ** 2 / 2
    sure = np.asarray(result.outcome) != SNAPS
    assert np.abs(left[sure] / brought[sure]).max() < 1e-9
    assert {STOPPED, NEVER_SLID, BOTTOMED_OUT} <= set(np.asarray(result.outcome).tolist())
    heat = np.asarray(slip_heat(result.slip, vacuum, brake))
    assert np.asarray(result.heat) == pytest.approx(heat, rel=1e-12, abs=1e-15)


def test_no_standstill_is_passed_over_and_the_peak_is_the_greatest_force_met():
    case = _random_cases(300, seed=8)
    result = stop(*case)
    slides = np.asarray(result.outcome) != NEVER_SLID
    share = np.linspace(0, 1, 2001)[:-1]
    slips = np.asarray(result.slip)[:, None] * share
    wide = jax.tree.map(lambda values: np.asarray(values)[:, None], case)
    pace = speed_at_slip(slips, *wide)
    assert np.isfinite(np.asarray(pace)[slides]).all()
    assert (np.asarray(pace)[slides] > 0).all()
    forces = brake_force(slips, wide[2], wide[5])
    most = np.asarray(forces).max(axis=1)[slides]
    given = np.asarray(result.peak_force)[slides]
    assert (given >= most * (1 - 1e-12)).all()
    assert given == pytest.approx(most, rel=2e-3)


@pytest.mark.parametrize("of", ["slip", "peak_force", "heat"])
@pytest.mark.parametrize(
    "field", ["scale_factor", pytest.param("stiffness", marks=pytest.mark.slow)]
)
def test_gradients_with_respect_to_brake_and_spring(of, field):
    def value(change):
        brake, spring = KAPTON, SPRING
        if field == "scale_factor":
            brake = dataclasses.replace(brake, scale_factor=0.875 * change)
        else:
            spring = SPRING * change
        return getattr(stop(1.0, 2.5, 94.5e3, spring, G, brake), of)

    step = 1e-6
    numeric = float(value(1 + step) - value(1 - step)) / (2 * step)
    assert float(jax.grad(value)(1.0)) == pytest.approx(numeric, rel=1e-6, abs=1e-9)


def test_outside_the_domain_there_is_no_number():
    for bad in ((-1.0, 1.0), (1.0, -1.0)):
        assert np.isnan(float(stop(*bad, 94.5e3, SPRING, G, KAPTON).slip))
    assert np.isnan(float(stop(1.0, 1.0, -5.0, SPRING, G, KAPTON).peak_force))


def test_tuned_vacuum_stops_where_it_should_and_only_in_its_range_of_speeds():
    vacuum = float(tuned_vacuum(1.0, 2.5, 0.040, SPRING, G, KAPTON))
    assert float(stop(1.0, 2.5, vacuum, SPRING, G, KAPTON).slip) == pytest.approx(0.04, rel=1e-12)
    assert float(stop(1.0, 2.5, vacuum, SPRING, G, KAPTON).peak_force) / G == pytest.approx(
        11.40, abs=5e-3
    )
    speeds = np.array([0.4635, 0.4645, 3.3275, 3.3285])
    found = np.asarray(tuned_vacuum(1.0, speeds, 0.040, SPRING, G, KAPTON))
    assert np.isnan(found).tolist() == [True, False, False, True]
    assert float(tuned_vacuum(1.0, 3.205, 0.040, SPRING, G, KAPTON)) == pytest.approx(
        94.5e3, rel=1e-3
    )


def test_tuned_vacuum_of_random_brakes_stops_them_at_the_wanted_slip():
    mass, speed, _, spring, gravity, brake = _random_cases(2000, seed=5)
    way = brake.sheets.usable_travel * np.random.default_rng(0).uniform(0.1, 1, 2000)
    vacuum = np.asarray(tuned_vacuum(mass, speed, way, spring, gravity, brake))
    found = np.isfinite(vacuum)
    assert 200 < found.sum() < 1900
    result = stop(mass, speed, np.where(found, vacuum, 0.0), spring, gravity, brake)
    slip = np.asarray(result.slip)[found]
    # where force and weight nearly balance, any error of energy is a large one of slip
    weight = (mass * gravity)[found]
    rest = np.asarray(brake_force(way, vacuum, brake))[found]
    steep = rest > weight * 1.05
    assert slip[steep] == pytest.approx(way[found][steep], rel=1e-8)


def test_eq10_leaves_out_gravity_and_runs_50_mm_instead_of_40():
    vacuum = float(vacuum_eq10(1.0, 2.5, 0.040, KAPTON))
    assert float(slip_work(0.040, vacuum, KAPTON)) == pytest.approx(2.5**2 / 2, rel=1e-12)
    assert float(stop(1.0, 2.5, vacuum, SPRING, G, KAPTON).slip) == pytest.approx(50.4e-3, abs=5e-5)
    assert np.isnan(float(vacuum_eq10(1.0, 4.0, 0.040, KAPTON)))
    assert np.isnan(float(vacuum_eq10(1.0, 1e-4, 0.040, PTFE)))
    assert float(enclosure_force(0.04, 0.0, PTFE)) > 0
