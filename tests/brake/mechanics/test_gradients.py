"""Gradients of every law, for every argument and every float of the brake, against differences."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.brake.mechanics import enclosure, energy, friction, limits, pull, stiffness
from layerjam.brake.mechanics.enclosure import saturation_slip
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.memory import enclosure_cycle
from strategies import KAPTON, points, random_brakes, with_fields_of

N = 24
LAWS = {
    "enclosure_force": (enclosure.enclosure_force, "xp"),
    "saturation_slip": (enclosure.saturation_slip, "p"),
    "enclosure_stretch": (enclosure.enclosure_stretch, "xp"),
    "slip_work": (energy.slip_work, "xp"),
    "slip_heat": (energy.slip_heat, "xp"),
    "pull_work": (energy.pull_work, "up"),
    "energy_capacity": (energy.energy_capacity, ""),
    "sheet_friction": (friction.sheet_friction, "xp"),
    "holding_force": (friction.holding_force, "p"),
    "buckling_force": (limits.buckling_force, "x"),
    "sheet_stress": (limits.sheet_stress, "f"),
    "clamp_stress": (limits.clamp_stress, "f"),
    "travel_left": (limits.travel_left, "x"),
    "brake_force": (pull.brake_force, "xp"),
    "peak_force": (lambda p, x, b: pull.peak(p, x, b).force, "px"),
    "peak_slip": (lambda p, x, b: pull.peak(p, x, b).slip, "px"),
    "peak_elongation": (lambda p, x, b: pull.peak(p, x, b).elongation, "px"),
    "slip_at_elongation": (pull.slip_at_elongation, "up"),
    "least_stiffness": (pull.least_stiffness, "p"),
    "vacuum_for_force": (pull.vacuum_for_force, "fx"),
    "force_limits_low": (lambda x, b: pull.force_limits(x, b)[0], "x"),
    "force_limits_high": (lambda x, b: pull.force_limits(x, b)[1], "x"),
    "peak_vacuum": (pull.peak_vacuum, ""),
    "stiffness_before_slip": (stiffness.stiffness_before_slip, ""),
    "stiffness_sliding": (stiffness.stiffness_sliding, "x"),
    "mount_stiffness": (stiffness.mount_stiffness, ""),
    "self_closing_vacuum": (limits.self_closing_vacuum, "x"),
}


EXPONENT = ("sheet_friction", "holding_force", "brake_force", "slip_work", "slip_at_elongation")
EXPONENT += ("peak_force", "least_stiffness", "vacuum_for_force", "energy_capacity")
EXPONENT += ("force_limits_low", "force_limits_high", "peak_vacuum", "self_closing_vacuum")
"""Laws that a pressure exponent changes, without those made of them."""
CASES = [pytest.param(name, False, id=name) for name in LAWS]
CASES += [pytest.param(name, True, id=f"{name}-exponent", marks=pytest.mark.slow) for name in LAWS]


def floats(brakes):
    """The leaves of a stack of brakes as one array (n, fields), and the way back."""
    leaves, tree = jax.tree.flatten(brakes)
    return np.stack([np.asarray(leaf, float) for leaf in leaves], axis=1), tree


def split(name, rows, tree):
    """Arguments of a law and its brake, from the columns of `rows` or from one row."""
    m = len(LAWS[name][1])
    return *rows[:m], jax.tree.unflatten(tree, list(rows[m:]))


@functools.cache
def slopes(names, tree):
    """Values (n,) and gradients (n, arguments and fields) of the laws in one program."""

    def slope(name, row):
        return jax.value_and_grad(lambda r: LAWS[name][0](*split(name, r, tree)))(row)

    return jax.jit(jax.vmap(lambda rows: {name: slope(name, rows[name]) for name in names}))


def arguments(kinds, seed, brakes):
    slip, vacuum = points(seed, brakes)
    force = np.asarray(pull.brake_force(slip, vacuum, brakes))
    known = {"x": slip, "p": vacuum, "f": force}
    known["u"] = slip + force / brakes.stiffness_measured
    return np.stack([known[k] for k in kinds], axis=1) if kinds else np.zeros((N, 0))


def smooth(seed, brakes):
    """Points away from where the second derivative jumps (saturation, end of overlap, peak)."""
    slip, vacuum = points(seed, brakes)
    near = np.abs(slip / np.asarray(saturation_slip(vacuum, brakes)) - 1) < 2e-2
    top = pull.peak(vacuum, slip, brakes)
    return (
        ~near
        & (slip < 0.98 * brakes.sheets.overlap)
        & (np.asarray(top.inside) == (np.asarray(top.slip) < 0.98 * slip))
    )


@functools.cache
def random_slopes(names, exponent):
    """Brakes, and for each of these laws its arguments, values and gradients there."""
    brakes = random_brakes(11, N, exponent=exponent)
    brakes = brakes if exponent else with_fields_of(KAPTON, brakes)
    values, tree = floats(brakes)
    theta = {
        name: np.concatenate([arguments(LAWS[name][1], 11, brakes), values], axis=1)
        for name in names
    }
    return brakes, theta, jax.device_get(slopes(names, tree)(theta))


@pytest.mark.parametrize(("name", "exponent"), CASES)
def test_gradient_is_the_difference_quotient(name, exponent):
    """Central differences, extrapolated once (error h^4); 1e-6 relative to the largest term."""
    names = tuple(n for n in LAWS if not exponent or (n in EXPONENT) == (name in EXPONENT))
    brakes, every, made = random_slopes(names, exponent)
    theta, (value, exact) = every[name], made[name]
    values, tree = floats(brakes)
    step, count = 2e-4, theta.shape[1]
    shift = np.eye(count)[None] * theta[:, None, :]
    # the number of sheets is a whole one, which some laws halve
    whole = count - values.shape[1] + COUNT
    shift[:, whole] = 0.0
    beside = [theta[:, None] + h * shift for h in (step, -step, step / 2, -step / 2)]
    rows = np.concatenate([theta, *(grid.reshape(-1, count) for grid in beside)])
    there = np.broadcast_to(LAWS[name][0](*split(name, rows.T, tree)), len(rows))
    np.testing.assert_allclose(value, there[:N], rtol=1e-9)
    assert np.isfinite(exact).all()
    # a law may say "never" (an infinite vacuum); a difference of infinities is no slope
    answered = np.isfinite(value)
    up, down, near_up, near_down = there[N:].reshape(4, N, count)

    def quotient(above, below, h):
        # where there is no answer, there is none beside it either
        above, below = (np.where(answered[:, None], grid, 0.0) for grid in (above, below))
        return (above - below) / (2 * h)

    numeric = (4 * quotient(near_up, near_down, step / 2) - quotient(up, down, step)) / 3
    scaled = exact * theta
    scaled[:, whole] = 0.0
    good = smooth(11, brakes) & answered
    size = np.maximum(np.abs(scaled), np.abs(numeric)).max(axis=1, keepdims=True)
    wrong = np.abs(scaled - numeric) / np.maximum(size, 1e-3 * np.abs(value)[:, None] + 1e-300)
    assert good.sum() > N / 3
    assert (wrong[good] < 1e-6).all()


@pytest.mark.parametrize("vacuum", [0.0, 1.0, 94.5e3])
def test_gradients_at_zero_slip_are_finite_and_as_documented(vacuum):
    """The sleeve's infinite slope counts as zero: what is left is the sheets' -c."""
    slope = jax.grad(pull.brake_force, argnums=(0, 1))(0.0, vacuum, KAPTON_FLOAT)
    c = float(pull.least_stiffness(vacuum, KAPTON))
    assert float(slope[0]) == pytest.approx(-c, rel=1e-14, abs=1e-12)
    per_pascal = float(pull.brake_force(0.0, 1.0, KAPTON))
    assert float(slope[1]) == pytest.approx(per_pascal, rel=1e-13)
    assert float(jax.grad(enclosure.enclosure_force)(0.0, vacuum, KAPTON_FLOAT)) == 0.0
    assert float(jax.grad(energy.slip_work)(0.0, vacuum, KAPTON_FLOAT)) == pytest.approx(
        float(pull.brake_force(0.0, vacuum, KAPTON)), rel=1e-13, abs=1e-12
    )


KAPTON_FLOAT = jax.tree.map(float, KAPTON)
PATHS = [jax.tree_util.keystr(path) for path, _ in jax.tree_util.tree_leaves_with_path(KAPTON)]
COUNT = PATHS.index(".sheets.count")


SLIDING = ("brake_force", "slip_work", "slip_heat", "vacuum_for_force")
SLIDING += ("force_limits_low", "force_limits_high")
"""Laws that are NaN once the sheets are apart."""
CORNERS = [(x, p) for x in (0.0, 0.02, 0.068, 0.08) for p in (0.0, 94.5e3)]


@functools.cache
def corner_slopes():
    """For each law its values and gradients at `CORNERS`, as many as the random ones."""
    slip, vacuum = np.resize(CORNERS, (N, 2)).T
    force = np.asarray(friction.sheet_friction(slip, vacuum, KAPTON))
    force = force + np.asarray(enclosure.enclosure_force(slip, vacuum, KAPTON))
    known = {"x": slip, "p": vacuum, "f": force, "u": slip + force / 131e3}
    values, tree = floats(jax.tree.map(lambda leaf: np.full(N, leaf), KAPTON))
    theta = {
        name: np.column_stack([*(known[k] for k in kinds), values])
        for name, (_, kinds) in LAWS.items()
    }
    return slip, jax.device_get(slopes(tuple(LAWS), tree)(theta))


@pytest.mark.parametrize("name", LAWS)
def test_gradients_are_finite_everywhere(name):
    """At zero slip, zero vacuum, the end of the overlap and beyond."""
    slip, made = corner_slopes()
    value, gradient = made[name]
    ends = {"self_closing_vacuum": slip >= 0.068} | dict.fromkeys(SLIDING, slip > 0.068)
    apart = ends.get(name, np.zeros(len(slip), bool))
    assert (np.isfinite(value) == ~apart).all()
    assert np.isfinite(gradient[~apart]).all()


@pytest.mark.slow
def test_gradient_through_a_whole_history():
    """Work of a cycle with respect to the vacuum and the friction, against differences."""
    u = np.array([0.0, 0.03, 0.028, 0.04, 0.01])

    def work(vacuum, kinetic):
        brake = jax.tree.map(jnp.asarray, KAPTON_FLOAT)
        film = type(brake.film)(**{**vars(brake.film), "kinetic": kinetic})
        return brake_cycle(u, vacuum, type(brake)(**{**vars(brake), "film": film})).work[-1]

    made = np.array(jax.jit(jax.grad(work, argnums=(0, 1)))(3e4, 0.24))
    pairs = [((3e4 + 3, 0.24), (3e4 - 3, 0.24)), ((3e4, 0.24001), (3e4, 0.23999))]
    for i, (a, b) in enumerate(pairs):
        numeric = (float(work(*a)) - float(work(*b))) / (a[i] - b[i])
        assert made[i] == pytest.approx(numeric, rel=1e-6)


@pytest.mark.campaign
def test_gradient_of_the_sleeves_history():
    def energy_left(top, vacuum):
        path = jnp.stack([jnp.zeros(()), top, top / 3, top / 2])
        return enclosure_cycle(path, vacuum, KAPTON_FLOAT)[1][-1]

    made = np.array(jax.jit(jax.grad(energy_left, argnums=(0, 1)))(0.03, 3e4))
    pairs = [((0.03001, 3e4), (0.02999, 3e4)), ((0.03, 3e4 + 3), (0.03, 3e4 - 3))]
    for i, (a, b) in enumerate(pairs):
        numeric = (float(energy_left(*a)) - float(energy_left(*b))) / (a[i] - b[i])
        assert made[i] == pytest.approx(numeric, rel=1e-6)
