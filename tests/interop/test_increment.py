"""The increment in JAX is the compiled kernel, in either precision, past the overlap too."""

from __future__ import annotations

import shutil

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from counts import cases
from layerjam.brake.device.load import load
from layerjam.brake.kernel.kernel import SEPARATED, Kernel
from layerjam.core.errors import QuantityError
from layerjam.interop.increment import Increment, make_motion, move_state

CC = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler here"
)
STEPS = 300
COMPILED = jax.jit(move_state)
KAPTON = load("choi2018-kapton").brake
NUMBERS = Kernel(KAPTON).parameters if shutil.which("cc") else None


def walk(seed):
    """Elongations that go slack, turn often and part the sheets; vacuums; compliances."""
    rng = np.random.default_rng(seed)
    ahead = np.cumsum(rng.normal(3e-4 * (seed % 3), 2e-3, STEPS))
    path = np.clip(ahead, -1e-3, 0.12)
    vacuum = np.repeat(rng.uniform(0, 1e5, STEPS // 10), 10)
    return path, vacuum, rng.choice([0.0, 1e-6, 1e-5], STEPS)


def traced(path, vacuum, compliance, dtype):
    def step(state, point):
        state = move_state(state, point[0], point[1], NUMBERS, point[2])
        return state, (state.force, state.slip, state.brake.heat)

    points = tuple(each.astype(dtype) for each in (path, vacuum, compliance))
    return jax.lax.scan(step, make_motion(dtype), points)[1]


@CC
@pytest.mark.slow
@pytest.mark.parametrize(("dtype", "newtons"), [(jnp.float64, 1e-9), (jnp.float32, 5e-3)])
def test_the_increment_is_the_kernel(dtype, newtons):
    """In single precision up to where the sheets part: nobody holds anything beyond."""
    parted = 0
    run = jax.jit(traced, static_argnums=3)
    for seed in range(12):
        path, vacuum, compliance = walk(seed)
        force, slip, heat = map(np.asarray, run(path, vacuum, compliance, dtype))
        assert force.dtype == dtype
        kernel, rows = Kernel(KAPTON), []
        for point in zip(path, vacuum, compliance, strict=True):
            kernel.move(*point)
            if dtype == jnp.float32 and kernel.flags & SEPARATED:
                break
            rows.append((kernel.force, kernel.slip, kernel.heat))
        parted += kernel.flags & SEPARATED > 0
        expected, n = np.array(rows), len(rows)
        assert n > 40
        assert np.abs(force[:n] - expected[:, 0]).max() <= newtons
        assert np.abs(slip[:n] - expected[:, 1]).max() <= newtons * 1e-5
        assert np.abs(heat[:n] - expected[:, 2]).max() <= newtons * 1e-1
    assert parted >= 2


@pytest.mark.slow
@CC
def test_the_twin_without_a_compiler_moves_refuses_and_remembers():
    twin, kernel = Increment(NUMBERS), Kernel(KAPTON)
    path, vacuum, compliance = walk(1)
    for point in zip(path[:60], vacuum, compliance, strict=False):
        assert twin.move(*point) == pytest.approx(kernel.move(*point), abs=1e-9)
    kept = twin.state
    before = (twin.force, twin.slip, twin.heat)
    for elongation, bad in ((np.nan, 1e3), (0.01, -1.0), (0.01, np.inf)):
        with pytest.raises(QuantityError):
            twin.move(elongation, bad)
    assert twin.state == kept
    twin.move(0.05, 0.0)
    twin.state = kept
    assert (twin.force, twin.slip, twin.heat) == before
    with pytest.raises(QuantityError, match="expected"):
        twin.state = kept[:-1]
    endless = np.frombuffer(kept[:8], np.float64) * np.inf
    with pytest.raises(QuantityError, match="out of range"):
        twin.state = endless.tobytes() + kept[8:]
    places = np.cumsum([0, *(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(twin._state))])
    for leaf, place in zip(jax.tree.leaves(twin._state), places, strict=False):
        if np.asarray(leaf).dtype == np.int64:
            with pytest.raises(QuantityError, match="out of range"):
                twin.state = kept[:place] + np.int64(37).tobytes() + kept[place + 8 :]
    assert twin.state == kept


@CC
@pytest.mark.slow
def test_a_held_load_changes_no_bit_however_often_it_is_asked_for():
    """At 99.9 % of what friction holds; at 100.1 % it slides."""
    hold = NUMBERS.contact * 94.5e3 * NUMBERS.overlap
    for dtype in (jnp.float64, jnp.float32):
        up = jnp.asarray(0.999 * hold / NUMBERS.stiffness, dtype)
        first = last = COMPILED(make_motion(dtype), up, 94.5e3, NUMBERS)
        for _ in range(cases(10_000, 1000)):
            last = COMPILED(last, up, 94.5e3, NUMBERS)
        assert first.slip == 0
        for a, b in zip(jax.tree.leaves(first), jax.tree.leaves(last), strict=True):
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes()
        assert COMPILED(last, 1.001 * hold / NUMBERS.stiffness, 94.5e3, NUMBERS).slip > 0


@pytest.mark.slow
@CC
def test_numbers_that_mean_nothing_leave_the_last_vacuum():
    """Traced code cannot raise: the plugin does the same with a control that is no number."""
    state = COMPILED(make_motion(), 0.02, 5e4, NUMBERS)
    for bad in (np.nan, -1.0, np.inf):
        same = COMPILED(state, 0.021, bad, NUMBERS)
        assert same.force == COMPILED(state, 0.021, 5e4, NUMBERS).force
        assert same.brake.vacuum == 5e4
    assert COMPILED(state, np.nan, 5e4, NUMBERS).force == state.force
