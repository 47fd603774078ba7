"""Stribeck's curve, the saw of a slow pull, critical speeds, wet sheets."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from layerjam.brake.mechanics.friction import holding_force, sheet_friction
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stick_slip.laws import (
    critical_speed,
    film_curve,
    sliding_force,
    slow_saw,
    stable_speed,
    stiffness_without_stick_slip,
    stribeck_friction,
    undamped_saw,
)
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck
from layerjam.brake.mechanics.stick_slip.wet import ILLUSTRATIVE, WetFilm, wet_force, wet_stress
from strategies import KAPTON, PTFE, unchecked

FULL = 94.5e3
CURVE = Stribeck(static=0.32, kinetic=0.24, speed=2e-3)


def table_one(brake: Any) -> tuple[float, float]:
    """Static and kinetic force at rest, full vacuum."""
    return float(holding_force(FULL, brake)), float(sheet_friction(0.0, FULL, brake))


def test_curve_between_static_and_kinetic() -> None:
    assert float(stribeck_friction(0.0, CURVE)) == 0.32
    assert float(stribeck_friction(2e-3, CURVE)) == pytest.approx(0.24 + 0.08 / np.e, rel=1e-14)
    assert float(stribeck_friction(1.0, CURVE)) == pytest.approx(0.24, rel=1e-14)
    assert float(stribeck_friction(-2e-3, CURVE)) == float(stribeck_friction(2e-3, CURVE))
    thick = dataclasses.replace(CURVE, viscous=3.0, exponent=2.0)
    expected = 0.24 + 0.08 * np.exp(-((1e-3 / 2e-3) ** 2)) + 3e-3
    assert float(stribeck_friction(1e-3, thick)) == pytest.approx(expected, rel=1e-14)


def test_the_jump_law_is_the_limit_of_a_small_speed() -> None:
    jump = dataclasses.replace(CURVE, speed=0.0)
    assert float(stribeck_friction(0.0, jump)) == 0.32
    for speed in (1e-9, 1e-3):
        assert float(stribeck_friction(speed, jump)) == 0.24
        near = dataclasses.replace(CURVE, speed=1e-12)
        assert float(stribeck_friction(speed, near)) == pytest.approx(0.24, rel=1e-12)


def test_impossible_curve_gives_nan() -> None:
    assert np.isnan(stribeck_friction(1e-3, Stribeck(static=0.2, kinetic=0.3, speed=1e-3)))


def test_gradient_at_rest_is_the_mean_of_both_sides() -> None:
    slope = jax.grad(lambda v: stribeck_friction(v, CURVE))
    assert float(slope(0.0)) == 0.0
    assert float(slope(1e-9)) == pytest.approx(-0.08 / 2e-3, rel=1e-5)
    assert float(slope(-1e-9)) == pytest.approx(0.08 / 2e-3, rel=1e-5)
    by_curve = jax.grad(lambda c: stribeck_friction(2e-3, c))(CURVE)
    assert float(by_curve.static) == pytest.approx(1 / np.e, rel=1e-12)
    jump = dataclasses.replace(CURVE, speed=0.0)
    assert all(np.isfinite(v) for v in dataclasses.astuple(
        jax.grad(lambda c: stribeck_friction(1e-3, c))(jump)
    ))  # fmt: skip


@pytest.mark.parametrize("slip", [0.0, 0.01, 0.04])
def test_dry_force_is_that_of_the_paper_at_every_speed(slip: float) -> None:
    flat = dataclasses.replace(film_curve(KAPTON), static=KAPTON.film.kinetic)
    speeds = np.array([0.0, 1e-3, 25e-3, 1.0])
    force = np.asarray(sliding_force(slip, speeds, FULL, KAPTON, flat))
    assert np.allclose(force, float(brake_force(slip, FULL, KAPTON)), rtol=1e-14)


def test_at_rest_the_curve_gives_the_holding_force() -> None:
    force = float(sliding_force(0.0, 0.0, FULL, KAPTON, film_curve(KAPTON, 1e-3)))
    assert force == pytest.approx(float(holding_force(FULL, KAPTON)), rel=1e-14)


def test_slow_saw_of_kapton() -> None:
    static, kinetic = table_one(KAPTON)
    saw = slow_saw(static, kinetic, 131e3, 0.01, 1e-3)
    assert float(saw.force_high) == pytest.approx(233.9064, abs=5e-5)
    assert float(saw.force_low) == pytest.approx(2 * kinetic - static, rel=1e-14)
    assert float(saw.slip) == pytest.approx(2 * (static - kinetic) / 131e3, rel=1e-14)
    stuck = 2 * (static - kinetic) / (131e3 * 1e-3)
    half = np.pi * np.sqrt(0.01 / 131e3)
    assert float(saw.period) == pytest.approx(stuck + half, rel=1e-14)
    assert not bool(saw.slack)


def test_slow_saw_of_ptfe_goes_slack() -> None:
    static, kinetic = table_one(PTFE)
    assert static > 2 * kinetic
    saw = slow_saw(static, kinetic, 55e3, 0.01, 1e-3)
    assert bool(saw.slack) and float(saw.force_low) == 0.0
    # the spring's energy turns into friction heat over the slip
    assert kinetic * float(saw.slip) == pytest.approx(static**2 / (2 * 55e3), rel=1e-14)


@given(st.floats(0.01, 0.99), st.floats(1e3, 1e6), st.floats(1e-3, 10))
@settings(deadline=None, max_examples=30)
def test_saw_at_speed_tends_to_the_slow_one(drop: float, spring: float, mass: float) -> None:
    for kinetic in (100.0, 30.0):
        static = kinetic + drop * 100.0
        if abs(static - 2 * kinetic) <= 0.05 * kinetic:
            continue  # at the very corner the spring goes slack through speed alone
        # stuck for all but a millionth of the period
        speed = 1e-6 * (static - kinetic) / np.sqrt(spring * mass)
        slow = slow_saw(static, kinetic, spring, mass, speed)
        exact = undamped_saw(static, kinetic, spring, mass, speed)
        for name in ("force_high", "slip", "period"):
            assert float(getattr(exact, name)) == pytest.approx(
                float(getattr(slow, name)), rel=1e-5
            )
        assert float(exact.slip_time) == pytest.approx(float(slow.slip_time), rel=1e-4)


def test_saw_is_continuous_where_it_goes_slack() -> None:
    taut, slack = (slow_saw(200 + d, 100.0, 1e5, 1.0, 1e-3) for d in (-1e-9, 1e-9))
    for a, b in zip(taut[:-1], slack[:-1], strict=True):
        assert float(a) == pytest.approx(float(b), rel=1e-4, abs=1e-6)


def reference(ratio: float) -> float:
    """Critical (F_s - F_k)/(V sqrt(k m)) from the free swing itself, without the law's algebra."""
    q = np.sqrt(1 - ratio**2)

    def over(kappa: float) -> float:
        s = np.linspace(1e-3, 4 * np.pi / q, 20_001)
        swing = np.exp(-ratio * s) * (np.cos(q * s) + (ratio - kappa) / q * np.sin(q * s))
        turned = int(np.argmin(swing))
        return float(swing[turned:].max() - 1)

    return float(brentq(over, 1e-3, 1e7, xtol=1e-12, rtol=1e-10))


@pytest.mark.parametrize("ratio", [0.001, 0.05, 0.3, 0.7, 0.9])
def test_critical_speed(ratio: float) -> None:
    spring, mass = 131e3, 0.01
    impedance = np.sqrt(spring * mass)
    found = float(critical_speed(233.9, 175.4, spring, mass, 2 * ratio * impedance))
    assert found == pytest.approx(58.5 / (impedance * reference(ratio)), rel=1e-6)
    back = float(stiffness_without_stick_slip(found, 233.9, 175.4, mass, ratio))
    assert back == pytest.approx(spring, rel=1e-10)


def test_critical_speed_with_little_and_much_damping() -> None:
    spring, mass = 131e3, 0.01
    impedance = np.sqrt(spring * mass)
    light = float(critical_speed(233.9, 175.4, spring, mass, 2e-5 * impedance))
    assert light == pytest.approx(58.5 / (np.sqrt(4 * np.pi * 1e-5) * impedance), rel=1e-3)
    assert np.isinf(critical_speed(233.9, 175.4, spring, mass, 0.0))
    assert float(critical_speed(233.9, 175.4, spring, mass, 2 * impedance)) == 0.0
    near = critical_speed(233.9, 175.4, spring, mass, np.array([1.9, 1.99, 1.999]) * impedance)
    assert (np.diff(np.asarray(near)) < 0).all() and (np.asarray(near) > 0).all()
    assert np.isnan(critical_speed(100.0, 175.4, spring, mass, 1.0))


@pytest.mark.parametrize("ratio", [1 - 1e-9, 1 - 1e-6, 1.0, 1.5])
def test_critical_speed_does_not_change_around_and_above_critical_damping(ratio: float) -> None:
    # it falls as e^(-pi zeta/sqrt(1 - zeta^2)), which is below 1e-308 for zeta > 1 - 1e-5
    damping = 2 * ratio * np.sqrt(131e3 * 0.01)
    slopes = jax.grad(critical_speed, argnums=range(5))(233.9, 175.4, 131e3, 0.01, damping)
    assert [float(slope) for slope in slopes] == [0.0] * 5
    slope = jax.grad(stiffness_without_stick_slip, argnums=4)(0.2, 233.9, 175.4, 0.01, ratio)
    assert float(slope) == 0.0


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("damping", [0.01, 1.0, 50.0])
def test_stable_speed_is_where_the_slope_meets_the_damping(exponent: float, damping: float) -> None:
    drop, pace = 58.5, 3e-3
    speed = float(stable_speed(drop, pace, exponent, damping))
    curve = Stribeck(static=1.0, kinetic=1.0, speed=pace, exponent=exponent)
    curve = unchecked(curve, static=drop + 1)
    slope = jax.grad(lambda v: stribeck_friction(v, curve))
    assert float(slope(speed)) == pytest.approx(-damping, rel=1e-8)
    assert float(slope(1.01 * speed)) > -damping
    if exponent == 1.0:
        assert speed == pytest.approx(pace * np.log(drop / (damping * pace)), rel=1e-12)


def test_stable_speed_of_any_exponent_is_that_of_a_search_in_its_logarithm() -> None:
    rng = np.random.default_rng(7)
    n = 400
    drop, pace = 10 ** rng.uniform(-1, 2, n), 10 ** rng.uniform(-5, -1, n)
    power = rng.uniform(0.4, 3.0, n)
    slope = drop / pace * 10 ** rng.uniform(-6, 2, n)
    drop[0], pace[0], power[0], slope[0] = 2.248, 0.03987, 0.9443, 1851.0
    found = np.asarray(stable_speed(drop, pace, power, slope))
    for i in range(n):

        def excess(x: float, i: int = i) -> float:
            """ln(-dF/dv over the damping) at v = v_s e^x."""
            steep = np.log(drop[i] * power[i] / (pace[i] * slope[i]))
            return float(steep + (power[i] - 1) * x - np.exp(power[i] * x))

        # above its steepest point -dF/dv falls with the speed
        top = np.log(1 - 1 / power[i]) / power[i] if power[i] > 1 else -2e4
        if excess(top) <= 0:
            assert found[i] == 0.0
            continue
        there = float(brentq(excess, top, 10.0, xtol=1e-14, rtol=1e-14))
        if there < -690:  # below the least double
            assert found[i] < 1e-300
        else:
            assert np.log(found[i] / pace[i]) == pytest.approx(there, rel=1e-9, abs=1e-9)


def test_stable_speed_at_its_ends() -> None:
    assert float(stable_speed(58.5, 1.0, 1.0, 100.0)) == 0.0
    assert float(stable_speed(58.5, 1.0, 2.0, 100.0)) == 0.0
    assert np.isinf(stable_speed(58.5, 1e-3, 1.0, 0.0))
    assert float(stable_speed(0.0, 1e-3, 1.0, 1.0)) == 0.0


def test_laws_under_jit_vmap_and_grad() -> None:
    """In one program: the value and the slope of each law at two places."""
    laws = {
        lambda s: slow_saw(s, 175.0, 131e3, 0.01, 1e-3).slip: (230.0, 400.0),
        lambda s: undamped_saw(s, 175.0, 131e3, 0.01, 0.1).period: (230.0,),
        lambda s: undamped_saw(s, 50.0, 131e3, 0.01, 0.1).slip: (230.0,),
        lambda d: critical_speed(234.0, 175.0, 131e3, 0.01, d): (0.5, 20.0, 60.0),
        lambda v: stiffness_without_stick_slip(v, 234.0, 175.0, 0.01, 0.1): (1.0,),
        lambda d: stable_speed(58.0, 1e-3, 2.0, d): (1.0, 30.0),
        lambda v: wet_force(0.01, v, 50e3, KAPTON, ILLUSTRATIVE): (1e-3, 0.1),
        lambda v: sliding_force(0.01, v, 50e3, KAPTON, CURVE): (1e-3,),
    }
    compute = jax.jit(lambda rows: [
        jax.vmap(jax.value_and_grad(law))(row) for law, row in zip(laws, rows, strict=True)
    ])  # fmt: skip
    made = compute([jnp.array([*places, 1.1 * places[-1]]) for places in laws.values()])
    for (law, places), (values, slopes) in zip(laws.items(), made, strict=True):
        for at, value, slope in zip(places, values, slopes, strict=False):
            step = 1e-5 * at
            numeric = (float(law(at + step)) - float(law(at - step))) / (2 * step)
            assert float(slope) == pytest.approx(numeric, rel=1e-4)
            assert float(value) == pytest.approx(float(law(at)), rel=1e-13)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.1, 10))
@settings(deadline=None, max_examples=20)
def test_units_do_not_matter(force: float, length: float, time: float) -> None:
    """Other units of force, length and time change nothing but the units."""
    per = {"k": force / length, "m": force * time**2 / length, "v": length / time}
    static, kinetic, spring, mass, speed, drag = 234.0, 175.0, 131e3, 0.01, 0.2, 5.0
    one = undamped_saw(static, kinetic, spring, mass, speed)
    other = undamped_saw(
        static * force, kinetic * force, spring * per["k"], mass * per["m"], speed * per["v"]
    )
    for name, size in (("force_low", force), ("slip", length), ("period", time)):
        expected = float(getattr(one, name)) * size
        assert float(getattr(other, name)) == pytest.approx(expected, rel=1e-9)
    critical = float(critical_speed(static, kinetic, spring, mass, drag))
    drag *= force * time / length
    scaled = critical_speed(
        static * force, kinetic * force, spring * per["k"], mass * per["m"], drag
    )
    assert float(scaled) == pytest.approx(critical * per["v"], rel=1e-9)


def test_wet_without_water_is_dry() -> None:
    film = KAPTON.film
    dry = WetFilm(
        static=film.kinetic, kinetic=film.kinetic, speed=1e-2, adhesion=0.0, viscosity=0.0
    )
    slips = np.array([0.0, 0.01, 0.05])
    by_pressure = dataclasses.replace(KAPTON, pressure_exponent=0.2, test_pressure=3.9e3)
    mount = dataclasses.replace(KAPTON.mount, spacers=False)
    for brake in (KAPTON, by_pressure, dataclasses.replace(KAPTON, mount=mount)):
        for vacuum in (0.0, 31e3, FULL):
            force = np.asarray(wet_force(slips, 0.01, vacuum, brake, dry))
            assert np.allclose(force, brake_force(slips, vacuum, brake), rtol=1e-13, atol=1e-12)


def test_wet_parts_add_up() -> None:
    film = dataclasses.replace(ILLUSTRATIVE, adhesion=0.0, viscosity=0.0)
    whole = wet_stress(0.02, 50e3, ILLUSTRATIVE, 0.9)
    parts = float(wet_stress(0.02, 50e3, film, 0.9)) + ILLUSTRATIVE.adhesion
    assert float(whole) == pytest.approx(parts + 0.02 * ILLUSTRATIVE.viscosity, rel=1e-14)
    # without vacuum the sheets still hold, by adhesion over their area
    area = 10 * 0.013 * 0.068
    assert float(wet_force(0.0, 0.0, 0.0, KAPTON, ILLUSTRATIVE)) == pytest.approx(
        area * ILLUSTRATIVE.adhesion, rel=1e-13
    )
    assert np.isnan(wet_stress(-1.0, 50e3, ILLUSTRATIVE, 1.0))


def test_illustrative_water_behaves_as_the_paper_says() -> None:
    dry, end = (float(brake_force(x, FULL, KAPTON)) for x in (0.0, 0.04))
    slow, slow_end = (float(wet_force(x, 1e-3, FULL, KAPTON, ILLUSTRATIVE)) for x in (0.0, 0.04))
    assert slow > dry and slow - slow_end > dry - end
    assert float(wet_force(0.0, 25e-3, FULL, KAPTON, ILLUSTRATIVE)) < dry
