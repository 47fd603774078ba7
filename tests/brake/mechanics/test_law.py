"""What every law promises: broadcasting, jit, vmap, NaN outside, float64, any length unit."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.brake.mechanics import enclosure, energy, friction, limits, pull, stiffness
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.law import keep_if, safe_sqrt
from layerjam.brake.mechanics.memory import enclosure_cycle
from strategies import KAPTON, change, one, points, random_brakes, stretched

TWO = {
    "enclosure_force": enclosure.enclosure_force,
    "enclosure_stretch": enclosure.enclosure_stretch,
    "slip_work": energy.slip_work,
    "slip_heat": energy.slip_heat,
    "pull_work": energy.pull_work,
    "sheet_friction": friction.sheet_friction,
    "brake_force": pull.brake_force,
    "slip_at_elongation": pull.slip_at_elongation,
}
POWER = change(KAPTON, pressure_exponent=0.2, test_pressure=3900.0)


@pytest.mark.parametrize("name", [*TWO, "vacuum_for_force", "vacuum_for_force exponent"])
def test_scalars_arrays_and_mixed_shapes_broadcast(name):
    brake = POWER if "exponent" in name else KAPTON
    function = TWO.get(name, pull.vacuum_for_force)
    first = [[0.01], [0.02], [0.03]]
    second = np.array([1e3, 2e4, 5e4, 9e4])
    if name not in TWO:
        first, second = [[10.0], [20.0], [60.0]], np.array([0.0, 0.01, 0.02, 0.03])
    made = np.asarray(function(first, second, brake))
    assert made.shape == (3, 4) and made.dtype == np.float64
    for i in range(3):
        for j in range(4):
            single = function(first[i][0], float(second[j]), brake)
            assert single.shape == ()
            assert float(single) == pytest.approx(made[i, j], rel=1e-14)
    whole = function(np.array([1, 2]), 3, brake)
    assert whole.shape == (2,) and whole.dtype == jnp.float64


@pytest.mark.parametrize("name", TWO)
def test_jit_and_vmap_over_brakes_give_the_single_answers(name):
    brakes = random_brakes(7, 20)
    slip, vacuum = points(7, brakes)
    function = TWO[name]
    batch = np.asarray(jax.jit(jax.vmap(function))(slip, vacuum, brakes))
    for i in range(0, 20, 7):
        single = float(function(slip[i], vacuum[i], one(brakes, i)))
        assert batch[i] == pytest.approx(single, rel=1e-12)


@pytest.mark.parametrize("name", TWO)
def test_nan_outside_the_domain(name):
    function = TWO[name]
    assert np.isnan(float(function(-1e-6, 1e4, KAPTON)))
    assert np.isnan(float(function(1e-3, -1.0, KAPTON)))
    assert np.isnan(float(function(float("nan"), 1e4, KAPTON)))
    assert np.isfinite(float(function(0.0, 0.0, KAPTON)))


def test_nan_outside_the_domain_for_the_rest():
    assert np.isnan(float(friction.holding_force(-1.0, KAPTON)))
    assert np.isnan(float(enclosure.saturation_slip(-1.0, KAPTON)))
    assert float(friction.holding_force(0.0, KAPTON)) == 0.0
    assert float(enclosure.saturation_slip(0.0, KAPTON)) == 0.0
    soft = change(KAPTON, stiffness_measured=2000.0)
    assert np.isnan(float(pull.slip_at_elongation(0.01, 94.5e3, soft)))
    assert np.isnan(np.asarray(pull.force_limits(-0.01, KAPTON))).all()


def test_peak_of_a_negative_vacuum_is_nan():
    assert np.isnan(float(pull.peak(-1.0, 0.06, KAPTON).force))


def test_safe_sqrt_and_within():
    values = [-1.0, -0.0, 0.0, 4.0]
    assert np.array_equal(safe_sqrt(np.array(values)), safe_sqrt(jnp.array(values)), equal_nan=True)
    assert not np.signbit(safe_sqrt(np.float64(-0.0)))  # a division by it is +inf, as in JAX
    value = safe_sqrt(jnp.array([-1.0, 0.0, 4.0]))
    assert np.isnan(value[0]) and value[1] == 0 and value[2] == 2
    assert float(jax.grad(safe_sqrt)(0.0)) == 0.0
    assert float(jax.grad(safe_sqrt)(4.0)) == 0.25
    kept = keep_if(jnp.array([True, False]), jnp.array([1.0, 2.0]))
    assert kept[0] == 1 and np.isnan(kept[1])


@pytest.mark.parametrize("exponent", [False, True], ids=["", "exponent"])
@pytest.mark.parametrize("length", [1e3, 1e-2])
def test_forces_do_not_change_when_lengths_are_given_in_millimetres(length, exponent):
    """The whole law in mm, N, MPa, N/mm, N mm: forces equal, slips and energies scaled."""
    n = 200
    brakes = random_brakes(9, n, exponent=exponent)
    slip, vacuum = points(9, brakes)
    other = stretched(brakes, length)
    x, p = slip * length, vacuum / length**2

    def same(function, a, b, power):
        ours = np.asarray(function(*a, brakes))
        theirs = np.asarray(function(*b, other))
        assert np.isfinite(ours).mean() > 0.5
        assert theirs == pytest.approx(ours * length**power, rel=1e-9, nan_ok=True)

    same(pull.brake_force, (slip, vacuum), (x, p), 0)
    same(enclosure.enclosure_force, (slip, vacuum), (x, p), 0)
    same(enclosure.enclosure_stretch, (slip, vacuum), (x, p), 0)
    same(friction.holding_force, (vacuum,), (p,), 0)
    same(energy.slip_work, (slip, vacuum), (x, p), 1)
    same(energy.slip_heat, (slip, vacuum), (x, p), 1)
    same(energy.pull_work, (slip, vacuum), (x, p), 1)
    same(energy.energy_capacity, (), (), 1)
    same(pull.slip_at_elongation, (slip, vacuum), (x, p), 1)
    same(enclosure.saturation_slip, (vacuum,), (p,), 1)
    same(pull.peak_vacuum, (), (), -2)
    same(limits.self_closing_vacuum, (slip,), (x,), -2)
    same(limits.buckling_force, (slip,), (x,), 0)
    same(stiffness.stiffness_before_slip, (), (), -1)
    same(stiffness.stiffness_sliding, (slip,), (x,), -1)
    same(stiffness.mount_stiffness, (), (), -1)
    force = np.asarray(pull.brake_force(slip, vacuum, brakes))
    same(pull.vacuum_for_force, (force, slip), (force, x), -2)
    same(limits.sheet_stress, (force,), (force,), -2)
    same(limits.clamp_stress, (force,), (force,), -2)


@pytest.mark.slow
def test_histories_in_millimetres():
    u = np.array([0.0, 0.03, 0.02, 0.04, 0.0, 0.035])
    vacuum = np.array([9e4, 9e4, 2e4, 5e3, 1e3, 3e4])
    other = stretched(KAPTON, 1e3)
    ours, theirs = brake_cycle(u, vacuum, KAPTON), brake_cycle(u * 1e3, vacuum * 1e-6, other)
    assert np.asarray(theirs.force) == pytest.approx(np.asarray(ours.force), rel=1e-9, abs=1e-9)
    assert np.asarray(theirs.slip) == pytest.approx(np.asarray(ours.slip) * 1e3, rel=1e-9)
    assert np.asarray(theirs.heat) == pytest.approx(np.asarray(ours.heat) * 1e3, rel=1e-9)
    sleeve = enclosure_cycle(u, 2e3, KAPTON)
    again = enclosure_cycle(u * 1e3, 2e3 * 1e-6, other)
    for a, b, power in zip(sleeve, again, (1, 1e3, 1e3), strict=True):
        assert np.asarray(b) == pytest.approx(np.asarray(a) * power, rel=1e-9, abs=1e-9)


def test_pressure_exponent_multiplies_the_friction():
    """F_f (P/P_test)^m: one at the test pressure, zero without vacuum, by hand elsewhere."""
    for m in (-0.5, 0.0, 0.2, 1.5):
        brake = change(KAPTON, pressure_exponent=m, test_pressure=3900.0)
        plain = float(friction.sheet_friction(0.01, 2e4, KAPTON))
        made = float(friction.sheet_friction(0.01, 2e4, brake))
        assert made == pytest.approx(plain * (2e4 / 3900) ** m, rel=1e-13)
        at_test = float(friction.sheet_friction(0.01, 3900.0, brake))
        assert at_test == pytest.approx(float(friction.sheet_friction(0.01, 3900.0, KAPTON)))
        assert float(friction.sheet_friction(0.01, 0.0, brake)) == 0.0


def test_pressure_exponent_of_zero_changes_nothing():
    brake = change(KAPTON, pressure_exponent=0.0, test_pressure=3900.0)
    x = np.linspace(0.001, 0.06, 9)
    for function, second in (
        (pull.brake_force, 3e4),
        (pull.slip_at_elongation, 3e4),
        (energy.slip_work, 3e4),
    ):
        ours, plain = function(x, second, brake), function(x, second, KAPTON)
        assert np.asarray(ours) == pytest.approx(np.asarray(plain), rel=1e-12)
    assert float(pull.peak_vacuum(brake)) == pytest.approx(float(pull.peak_vacuum(KAPTON)))
    force = pull.brake_force(x, 3e4, KAPTON)
    back = np.asarray(pull.vacuum_for_force(force, x, brake))
    assert back == pytest.approx(np.full(9, 3e4), rel=1e-11)
    closing = np.asarray(limits.self_closing_vacuum(x, brake))
    assert closing == pytest.approx(np.asarray(limits.self_closing_vacuum(x, KAPTON)), rel=1e-9)
    at = limits.self_closing_vacuum(np.array([0.0, -0.01]), brake)
    assert float(at[0]) == pytest.approx(0.0, abs=1e-6)
