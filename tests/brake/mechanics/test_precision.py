"""Laws and simulations in a process whose JAX is in single precision, as JAX starts."""

from __future__ import annotations

import os
import subprocess
import sys

import jax
import numpy as np
import pytest

import layerjam as lj
from layerjam.core.errors import PrecisionError
from layerjam.core.threads import Workers, cache_threadsafe

KAPTON = lj.load("choi2018-kapton")
SLIP = np.linspace(0.0, 0.06, 4)


def numbers() -> np.ndarray:
    """Results of laws, a march in time, batches on threads, the stack and stick–slip."""
    timed, _ = lj.drop_in_time(KAPTON, mass=3.0, speed=1.0, vacuum=90e3, rope_stiffness=5e4)
    swept = lj.batch(lj.brake_force, {"slip": SLIP, "vacuum": 9e4}, brake=KAPTON)
    stopped = lj.batch(
        lj.stop,
        {"mass": SLIP + 1, "speed": 1.0, "vacuum": 9e4, "spring": 1e5, "gravity": 9.8},
        brake=KAPTON,
    )
    map_ = lj.amplitude_map(KAPTON.brake, 1e-3, np.array([5e4, 9e4]), mass=1.0, stiffness=1e5)
    stack = lj.stack_of(KAPTON.brake, 9e4)
    found = [
        lj.brake_force(SLIP, 9e4, KAPTON),
        lj.peak(9e4, 0.06, KAPTON.brake).force,
        timed.slip,
        swept["brake_force"],
        stopped["slip"],
        map_.amplitude,
        stack.friction,
        stack.face,
    ]
    assert all(np.asarray(part).dtype == np.float64 for part in found)
    return np.concatenate([np.ravel(part) for part in found])


SCRIPT = """
import warnings

warnings.simplefilter("error")
import jax, jax.numpy as jnp, numpy as np
import layerjam as lj
from brake.mechanics.test_precision import numbers

found = numbers()
assert jnp.asarray(1.0).dtype == jnp.float32, "double precision leaked"
assert isinstance(lj.brake_force(0.01, 9e4, lj.load("choi2018-kapton")), np.float64)
print(*map(repr, found.tolist()))
"""


@pytest.mark.slow
def test_the_numbers_are_those_of_double_precision() -> None:
    env = {k: v for k, v in os.environ.items() if k != "JAX_ENABLE_X64"}
    env |= {"JAX_PLATFORMS": "cpu", "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    # what is compiled here is found there by its code, which single precision would change
    env |= {"JAX_COMPILATION_CACHE_DIR": str(jax.config.jax_compilation_cache_dir)}
    env |= {"JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0.05"}
    right = numbers()
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=env,
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert run.returncode == 0, run.stderr[-2000:]
    np.testing.assert_array_equal([float(word) for word in run.stdout.split()], right)


def test_a_trace_in_single_precision_is_refused_and_the_setting_named() -> None:
    def force(slip: jax.Array) -> jax.Array:
        return lj.brake_force(slip, 9e4, KAPTON)

    for traced in (jax.jit(force), jax.grad(force), jax.vmap(force)):
        with jax.enable_x64(False), pytest.raises(PrecisionError, match="jax_enable_x64"):
            traced(np.full(1, 0.01))


def test_a_constant_in_a_trace_in_single_precision_is_a_number_of_double_precision() -> None:
    forces = []

    @jax.jit
    def scale(slip: jax.Array) -> jax.Array:
        forces.append(lj.brake_force(0.01, 9e4, KAPTON))
        return slip * forces[0]

    with jax.enable_x64(False):
        scale(1.0)
    assert type(forces[0]) is np.float64
    assert forces[0] == lj.brake_force(0.01, 9e4, KAPTON)


def test_what_is_made_once_is_made_by_one_thread() -> None:
    made = []

    @cache_threadsafe
    def slow(name: str) -> list[str]:
        made.append(name)
        return [name]

    with Workers(8) as pool:
        first, *rest = pool.map(slow, ["a"] * 32)
    assert made == ["a"]
    assert all(one is first for one in rest)
    assert slow("b") == ["b"]
