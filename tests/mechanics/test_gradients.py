"""Gradients of every law, for every argument and every float of the brake, against differences."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.mechanics import enclosure, energy, friction, limits, pull, stiffness
from layerjam.mechanics.enclosure import saturation_slip
from layerjam.mechanics.hysteresis import brake_cycle
from layerjam.mechanics.memory import enclosure_cycle
from strategies import KAPTON, points, random_brakes

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


def floats(brakes):
    """The float leaves of a stack of brakes as one array (n, fields), and the way back."""
    leaves, tree = jax.tree.flatten(brakes)
    kept = [i for i, leaf in enumerate(leaves) if np.asarray(leaf).dtype == np.float64]

    def rebuilt(values, whole):
        made = list(jax.tree.leaves(whole))
        for place, i in enumerate(kept):
            made[i] = values[place]
        return jax.tree.unflatten(tree, made)

    return np.stack([leaves[i] for i in kept], axis=1), rebuilt


def arguments(kinds, seed, brakes):
    slip, vacuum = points(seed, brakes)
    force = np.asarray(jax.vmap(pull.brake_force)(slip, vacuum, brakes))
    known = {"x": slip, "p": vacuum, "f": force}
    known["u"] = slip + force / brakes.stiffness_measured
    return np.stack([known[k] for k in kinds], axis=1) if kinds else np.zeros((N, 0))


def smooth(seed, brakes):
    """Points away from where the second derivative jumps (saturation, end of overlap, peak)."""
    slip, vacuum = points(seed, brakes)
    near = np.abs(slip / np.asarray(jax.vmap(saturation_slip)(vacuum, brakes)) - 1) < 2e-2
    top = jax.vmap(pull.peak)(vacuum, slip, brakes)
    return (
        ~near
        & (slip < 0.98 * brakes.sheets.overlap)
        & (np.asarray(top.inside) == (np.asarray(top.slip) < 0.98 * slip))
    )


@pytest.mark.parametrize("exponent", [False, True], ids=["", "exponent"])
@pytest.mark.parametrize("name", LAWS)
def test_gradient_is_the_difference_quotient(name, exponent):
    """Central differences, extrapolated once (error h^4); 1e-6 relative to the largest term."""
    function, kinds = LAWS[name]
    brakes = random_brakes(11, N, exponent=exponent)
    values, rebuilt = floats(brakes)
    given = arguments(kinds, 11, brakes)
    theta = np.concatenate([given, values], axis=1)
    m = given.shape[1]

    def flat(v, brake):
        return function(*(v[i] for i in range(m)), rebuilt(v[m:], brake))

    both = jax.jit(jax.vmap(jax.value_and_grad(flat), in_axes=(0, 0)), static_argnums=())
    floaty = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float64), brakes)
    exact = np.asarray(both(theta, floaty)[1])
    assert np.isfinite(exact).all()
    # a law may say "never" (an infinite vacuum); a difference of infinities is no slope
    answered = np.isfinite(np.asarray(both(theta, floaty)[0]))
    count = theta.shape[1]
    grid = jax.jit(jax.vmap(jax.vmap(flat, in_axes=(0, None)), in_axes=(0, 0)))
    step = 2e-4

    def quotient(h):
        shift = np.eye(count)[None] * h * theta[:, None, :]
        up, down = theta[:, None] + shift, theta[:, None] - shift
        above, below = np.asarray(grid(up, floaty)), np.asarray(grid(down, floaty))
        return (above - np.where(answered[:, None], below, 0.0)) / (2 * h)

    # where there is no answer, there is none beside it either
    numeric = np.where(answered[:, None], (4 * quotient(step / 2)) / 3, 0.0)
    numeric = numeric - np.where(answered[:, None], quotient(step) / 3, 0.0)
    scaled = exact * theta
    value = np.abs(np.asarray(both(theta, floaty)[0]))[:, None]
    good = smooth(11, brakes) & answered
    size = np.maximum(np.abs(scaled), np.abs(numeric)).max(axis=1, keepdims=True)
    wrong = np.abs(scaled - numeric) / np.maximum(size, 1e-3 * value + 1e-300)
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


CORNERS = [(x, p) for x in (0.0, 0.02, 0.068, 0.08) for p in (0.0, 94.5e3)]


@pytest.mark.parametrize("name", LAWS)
def test_gradients_are_finite_everywhere(name):
    """At zero slip, zero vacuum, the end of the overlap and beyond."""
    function, kinds = LAWS[name]
    slip, vacuum = np.array(CORNERS).T
    force = np.asarray(pull.brake_force(slip, vacuum, KAPTON))
    known = {"x": slip, "p": vacuum, "f": force, "u": slip + force / 131e3}
    args = [known[k] for k in kinds]
    both = jax.value_and_grad(function, argnums=tuple(range(len(args) + 1)))
    many = jax.jit(jax.vmap(both, in_axes=(*(0 for _ in args), None), axis_size=len(slip)))
    value, made = many(*args, KAPTON_FLOAT)
    apart = (slip >= 0.068) if name == "self_closing_vacuum" else np.zeros(len(slip), bool)
    assert (np.isfinite(value) == ~apart).all()
    for leaf in jax.tree.leaves(made):
        assert np.isfinite(leaf[~apart]).all()


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


@pytest.mark.slow
def test_gradient_of_the_sleeves_history():
    def energy_left(top, vacuum):
        path = jnp.stack([jnp.zeros(()), top, top / 3, top / 2])
        return enclosure_cycle(path, vacuum, KAPTON_FLOAT)[1][-1]

    made = np.array(jax.jit(jax.grad(energy_left, argnums=(0, 1)))(0.03, 3e4))
    pairs = [((0.03001, 3e4), (0.02999, 3e4)), ((0.03, 3e4 + 3), (0.03, 3e4 - 3))]
    for i, (a, b) in enumerate(pairs):
        numeric = (float(energy_left(*a)) - float(energy_left(*b))) / (a[i] - b[i])
        assert made[i] == pytest.approx(numeric, rel=1e-6)
