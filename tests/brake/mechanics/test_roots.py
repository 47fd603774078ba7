"""Searches for roots of array functions between bounds."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.brake.mechanics.roots import false_position, first_fall, newton_root
from layerjam.brake.mechanics.tracing import double_precision


def test_false_position_finds_the_cube_roots_of_an_array() -> None:
    """Of five numbers; the root of the last one is above the upper bound."""
    cubes = np.array([1e-3, 1.0, 2.0, 7.9, 8.1])
    with np.errstate(all="ignore"):
        end = false_position(lambda x: x**3 - cubes, np.zeros(5), np.full(5, 2.0), 1e-11, 62)
    assert np.asarray(end.is_met).tolist() == [True] * 4 + [False]
    assert (np.asarray(end.error)[:4] <= 1e-11).all()
    assert np.asarray(end.best)[:4] == pytest.approx(np.cbrt(cubes[:4]), rel=1e-8)


def test_false_position_meets_the_zeros_of_straight_lines_after_the_two_ends() -> None:
    at, slope = np.array([0.1, 0.5, 0.97]), np.array([1.0, 3.0, 0.2])
    with np.errstate(all="ignore"):
        end = false_position(lambda x: slope * (x - at), np.zeros(3), np.ones(3), 1e-14, 62)
    assert int(end.turn) == 3
    assert np.asarray(end.best) == pytest.approx(at, abs=1e-13)


@pytest.mark.parametrize("at", [0.1, 1 / 3, 0.9])
def test_false_position_narrows_a_jump_of_any_height_to_a_millionth_in_62_steps(at: float) -> None:
    """After the two ends twenty times three, one of which halves: 2**-20 is below 1e-6."""
    below, above = 10.0 ** np.array([[0, 0, 9, 0, 15], [0, 9, 0, 15, 0]])

    def jump(x: np.ndarray) -> np.ndarray:
        return np.where(x < at, -below, above)

    with np.errstate(all="ignore"):
        end = false_position(jump, np.zeros(5), np.ones(5), 0.0, 62)
    low, high = np.asarray(end.low), np.asarray(end.high)
    assert (low < at).all() and (high >= at).all()
    assert (high - low < 1e-6).all()


def test_no_root_depends_on_the_roots_beside_it() -> None:
    """Bit for bit, in NumPy and in JAX: the neighbours need three times as many steps."""
    rng = np.random.default_rng(4)
    easy, hard = rng.uniform(0.1, 1.0, 40), 10 ** rng.uniform(-12, -8, 40)
    kept = np.arange(40) % 3 == 0

    def newton(aim: Any) -> Any:
        def excess(state: Any) -> Any:
            return state[0] ** 3 - aim, 3 * state[0] ** 2, None

        return newton_root(excess, 0.5 + 0.0 * aim, 0.0 * aim, 1.0 + 0.0 * aim)

    def position(aim: Any) -> Any:
        return false_position(lambda x: x**3 - aim, 0.0 * aim, 1.0 + 0.0 * aim, 1e-13, 60).best

    for search in (newton, position):
        for array in (np.asarray, jnp.asarray):
            alone, among = (
                np.asarray(search(array(aim))) for aim in (easy, np.where(kept, easy, hard))
            )
            assert alone == pytest.approx(np.cbrt(easy), rel=1e-9)
            assert np.array_equal(alone[kept], among[kept])


@pytest.mark.parametrize("module", [np, jnp])
def test_a_fall_is_found_after_a_rise_that_begins_at_zero(module: Any) -> None:
    """The slope of a force of which the top lies within the first of the 64 parts."""
    tops = np.array([1e-4, 0.004, 0.3, 0.9, -0.2])
    with double_precision(), np.errstate(all="ignore"):  # as in every law
        low, high = module.zeros(5), module.ones(5)
        places, falls = first_fall(lambda w: w * (module.asarray(tops) - w), low, high)
    np.testing.assert_allclose(places, [*tops[:4], 0.0], atol=1e-12)
    assert np.all(falls)
