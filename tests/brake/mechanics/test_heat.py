"""Heat of a stop: balances, dimensions, by hand, the lasting state of many stops."""

from __future__ import annotations

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.device.brake import Brake, mass, sheet_mass
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.energy import sheet_work, slip_heat, slip_work
from layerjam.brake.mechanics.heat import (
    local_rise,
    outer_area,
    rubbing_mass,
    stops_per_minute,
    temperature_rise,
    temperature_rise_of_sheets,
)
from strategies import KAPTON, PTFE, change, points, random_brakes

seeds = st.integers(0, 2**32 - 1)
GRADIENT = jax.jit(jax.grad(temperature_rise, argnums=1))


def warm(seed: int, n: int) -> tuple[Brake, np.ndarray]:
    """Random brakes with a specific heat, and a heat [J] for each."""
    rng = np.random.default_rng(seed + 2)
    brakes = change(random_brakes(seed, n), film__specific_heat=rng.uniform(500, 2000, n))
    return brakes, np.exp(rng.uniform(-3, 4, n))


def test_kapton_by_hand() -> None:
    """11 sheets of 13 by 0.254 mm, 68 mm overlap, 1420 kg/m^3, 1090 J/(kg K); E(40 mm)."""
    heat = float(slip_work(0.040, 94.5e3, KAPTON))
    assert heat == pytest.approx(5.33458230, abs=5e-9)
    film = 11 * 0.013 * 0.254e-3 * 0.068 * 1420
    assert float(rubbing_mass(KAPTON)) == pytest.approx(film, rel=1e-12)
    assert film == pytest.approx(3.507e-3, abs=5e-7)
    assert float(temperature_rise(heat, KAPTON)) == pytest.approx(heat / (film * 1090), rel=1e-12)
    assert float(temperature_rise(heat, KAPTON)) == pytest.approx(1.3954, abs=5e-5)
    assert float(temperature_rise_of_sheets(heat, KAPTON)) == pytest.approx(1.1163, abs=5e-5)
    # 0.875 x 0.24 x 94.5 kPa x 40 mm over 1420 x 1090 x 0.254 mm
    assert float(local_rise(0.040, 94.5e3, KAPTON)) == pytest.approx(793.8 / 393.1412, rel=1e-6)
    # around (13 + 2.794 mm) and four walls of 1 mm, twice; 90 mm long
    assert float(outer_area(KAPTON)) == pytest.approx(2 * 19.794e-3 * 0.090, rel=1e-12)


def test_the_heat_of_a_stop_is_less_than_the_work() -> None:
    """Half of the sleeve's work is stored, not lost."""
    heat, work = slip_heat(0.04, 94.5e3, KAPTON), slip_work(0.04, 94.5e3, KAPTON)
    assert 0.9 * work < heat < work
    assert temperature_rise(heat, KAPTON) < temperature_rise(work, KAPTON)


@given(seeds)
def test_mass_times_specific_heat_times_rise_is_the_heat(seed: int) -> None:
    brakes, heat = warm(seed, 50)
    rise = np.asarray(temperature_rise(heat, brakes))
    film = brakes.sheets.count * sheet_mass(brakes)
    rubbing = film * brakes.sheets.overlap / brakes.sheets.length
    np.testing.assert_allclose(rubbing * brakes.film.specific_heat * rise, heat, rtol=1e-12)
    whole = np.asarray(temperature_rise_of_sheets(heat, brakes))
    np.testing.assert_allclose(film * brakes.film.specific_heat * whole, heat, rtol=1e-12)
    assert (whole < rise).all(), "the rubbing part is the smaller one"
    assert (np.asarray(rubbing_mass(brakes)) < mass(brakes)).all()


@given(seeds, st.floats(0.1, 10))
def test_dimensions(seed: int, scale: float) -> None:
    """Heat goes with length^3, time constants with length, areas with length^2."""
    brakes, heat = warm(seed, 20)
    larger = change(
        brakes,
        **{
            f"sheets__{key}": getattr(brakes.sheets, key) * scale
            for key in ("width", "thickness", "length", "overlap", "free_left", "free_right")
        },
        enclosure__wall=brakes.enclosure.wall * scale,
    )
    np.testing.assert_allclose(
        temperature_rise(heat * scale**3, larger), temperature_rise(heat, brakes), rtol=1e-9
    )
    np.testing.assert_allclose(outer_area(larger), scale**2 * outer_area(brakes), rtol=1e-12)
    np.testing.assert_allclose(
        stops_per_minute(heat * scale**3, 1e4, 10.0 * scale, larger),
        stops_per_minute(heat, 1e4, 10.0, brakes),
        rtol=1e-9,
    )
    # Pa m over J/(m^3 K) m: slip and thickness both grow
    slip, vacuum = points(seed, brakes)
    np.testing.assert_allclose(
        local_rise(scale * slip, vacuum, larger), local_rise(slip, vacuum, brakes), rtol=1e-9
    )


@given(seeds)
def test_the_hottest_place_is_above_the_mean_and_meets_it_where_it_must(seed: int) -> None:
    brakes, _ = warm(seed, 50)
    slip, vacuum = points(seed, brakes)
    hottest = np.asarray(local_rise(slip, vacuum, brakes))
    mean = np.asarray(temperature_rise(sheet_work(slip, vacuum, brakes), brakes))
    count = brakes.sheets.count
    assert (hottest > mean).all()
    # n - 1 interfaces in n sheets, and the contact that the slip has shortened
    contact = 1 - slip / 2 / brakes.sheets.overlap
    np.testing.assert_allclose(mean / hottest, (count - 1) / count * contact, rtol=1e-9)


@given(seeds, st.floats(0, 100))
def test_linear_in_the_heat_and_its_gradient(seed: int, heat: float) -> None:
    brake = jax.tree.map(lambda leaf: float(leaf[0]), warm(seed, 1)[0])
    one = float(temperature_rise(1.0, brake))
    assert float(temperature_rise(heat, brake)) == pytest.approx(heat * one, rel=1e-12)
    assert float(jax.grad(temperature_rise)(heat, brake)) == pytest.approx(one, rel=1e-12)
    along = GRADIENT(heat, brake)
    expected = -heat * one / brake.film.specific_heat
    assert float(along.film.specific_heat) == pytest.approx(expected, rel=1e-9)
    assert float(along.sheets.overlap) == pytest.approx(-heat * one / brake.sheets.overlap)


def test_stops_until_the_rise_is_reached_and_no_more() -> None:
    """Warm by dT, cool by exp(-h A t/C), again and again: it settles at the rise allowed."""
    heat, allowed, film = 5.33, 20.0, 10.0
    number = float(stops_per_minute(heat, allowed, film, KAPTON))
    assert number == pytest.approx(7.74, abs=5e-3)
    capacity = float(rubbing_mass(KAPTON)) * 1090
    fades = np.exp(-film * float(outer_area(KAPTON)) / capacity * 60 / number)
    rise, highest = 0.0, 0.0
    for _ in range(2000):
        rise = rise * fades + heat / capacity
        highest = max(highest, rise)
    assert highest == pytest.approx(allowed, rel=1e-9)


def test_of_small_stops_the_power_given_off_counts_whatever_the_mass() -> None:
    power = 10.0 * float(outer_area(KAPTON)) * 20.0
    number = float(stops_per_minute(1e-4, 20.0, 10.0, KAPTON))
    assert number == pytest.approx(60 * power / 1e-4, rel=1e-4)
    heavy = change(KAPTON, film__density=2 * KAPTON.film.density)
    assert float(stops_per_minute(1e-4, 20.0, 10.0, heavy)) == pytest.approx(number, rel=1e-4)


def test_none_where_one_stop_is_too_much() -> None:
    limit = float(temperature_rise(5.0, KAPTON))
    assert float(stops_per_minute(5.0, limit * 0.999, 10.0, KAPTON)) == 0.0
    assert float(stops_per_minute(5.0, limit, 10.0, KAPTON)) == 0.0
    just = float(stops_per_minute(5.0, limit * 1.0001, 10.0, KAPTON))
    assert 0 < just < float(stops_per_minute(5.0, limit * 2, 10.0, KAPTON))


@given(seeds)
def test_more_heat_fewer_stops_and_finite_gradients(seed: int) -> None:
    brakes, heat = warm(seed, 20)
    rises = np.asarray(temperature_rise(heat, brakes)) * np.linspace(1.01, 50, 20)
    number = np.asarray(stops_per_minute(heat, rises, 10.0, brakes))
    assert (number > 0).all()
    assert (np.asarray(stops_per_minute(heat * 1.005, rises, 10.0, brakes)) < number).all()
    assert (np.asarray(stops_per_minute(heat, rises, 12.0, brakes)) > number).all()

    def total(heat: object, rises: object) -> object:
        return stops_per_minute(heat, rises, 10.0, brakes).sum()

    slopes = jax.grad(total, argnums=(0, 1))(heat, rises)
    step = 1e-6
    numeric = [
        (np.asarray(stops_per_minute(heat * (1 + s), rises * (1 + r), 10.0, brakes)) - number)
        for s, r in ((step, 0), (0, step))
    ]
    np.testing.assert_allclose(slopes[0] * heat * step, numeric[0], rtol=2e-3)
    np.testing.assert_allclose(slopes[1] * rises * step, numeric[1], rtol=2e-3)
    stopped = jax.grad(total, argnums=(0, 1))(heat * 1000, rises)
    assert all(np.isfinite(s).all() for s in stopped)


def test_outside_the_domain_and_of_an_unknown_film() -> None:
    unknown = load("choi2018-ptfe-fiberglass").brake
    assert unknown.film.specific_heat is None
    for law in (temperature_rise, temperature_rise_of_sheets):
        assert np.isnan(float(law(-1.0, PTFE)))
        assert float(law(0.0, PTFE)) == 0.0
        assert np.isnan(float(law(1.0, unknown)))
    assert np.isnan(float(stops_per_minute(1.0, 20.0, 10.0, unknown)))
    for case in ((0.0, 20.0, 10.0), (1.0, 0.0, 10.0), (1.0, 20.0, 0.0), (-1.0, 20.0, 10.0)):
        assert np.isnan(float(stops_per_minute(*case, KAPTON)))
    for slip, vacuum in ((-1e-9, 1e4), (0.069, 1e4), (0.01, -1.0)):
        assert np.isnan(float(local_rise(slip, vacuum, KAPTON)))
