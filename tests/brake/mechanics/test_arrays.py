"""One name, three kinds of numbers: Python's, NumPy's arrays and JAX's give the same results."""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.brake.mechanics import arrays
from layerjam.brake.mechanics.arrays import derivative, xp
from strategies import KAPTON

VALUES = [-2.5, -0.0, 0.0, 1e-300, 0.3, 7.0, math.inf, -math.inf, math.nan]
PAIRS = {"maximum", "minimum", "where", "broadcast_arrays"}


@pytest.mark.parametrize("name", ["maximum", "minimum", "sqrt", "zeros_like", "ones_like", "where"])
def test_plain_numbers_are_treated_as_numpy_treats_them(name: str) -> None:
    """The shortcuts for plain numbers, NaN and infinity included."""
    law, numpy = getattr(xp, name), getattr(np, name)
    for a in VALUES:
        for b in VALUES if name in PAIRS else [0.0]:
            args: tuple[Any, ...] = (a, b) if name in PAIRS else (a,)
            args = (a > b, *args) if name == "where" else args
            with np.errstate(invalid="ignore"):
                expected, made = numpy(*args), law(*args)
            assert np.array_equal(made, expected, equal_nan=True), (name, args)
            in_jax = law(*(jnp.asarray(arg) for arg in args))
            assert isinstance(in_jax, jax.Array)
            assert np.array_equal(in_jax, expected, equal_nan=True)


def test_a_plain_number_may_be_divided_by_zero_afterwards() -> None:
    with np.errstate(divide="ignore"):
        for made in (xp.maximum(0.0, -1.0), xp.where(True, 0.0, 1.0), xp.zeros_like(3.0)):
            assert math.isinf(1 / made)
    assert [type(one) for one in xp.broadcast_arrays(1, 2.5)] == [np.float64] * 2


@pytest.mark.parametrize("place", [1e-9, 1e-6, -1e-3, 0.05, 1.0, -40.0, 3e5])
def test_differences_are_derivatives_at_any_size(place: float) -> None:
    functions = {
        (lambda x: 3 * x): 3.0,
        (lambda x: (x / place) ** 3): 3 / place,
        (lambda x: np.sin(x / place)): math.cos(1) / place,
        (lambda x: np.exp(-x / place)): -math.exp(-1) / place,
    }
    for function, slope in functions.items() if abs(place) > 1e-4 else [*functions.items()][:1]:
        assert derivative(function, np.float64(place)) == pytest.approx(slope, rel=1e-6)
    traced = derivative(lambda x: jnp.sin(x / place), jnp.asarray(place))
    assert float(traced) == pytest.approx(math.cos(1) / place, rel=1e-12)


def test_the_error_function_of_numbers_arrays_and_jax() -> None:
    places = np.linspace(-3, 3, 25)
    expected = [math.erf(x) for x in places]
    assert [arrays.erf(float(x)) for x in places] == expected
    assert arrays.erf(places) == pytest.approx(expected, rel=1e-14)
    assert np.asarray(arrays.erf(jnp.asarray(places))) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("first", [0, 3])
def test_a_loop_of_numbers_is_one_of_jax(first: int) -> None:
    def step(index: Any, state: Any) -> Any:
        return state * 1.5 + index

    number = arrays.repeat(9, step, 2.0, first)
    assert float(arrays.repeat(9, step, jnp.asarray(2.0), first)) == pytest.approx(number)
    # a captured value of JAX enters the state in the first step
    captured = jnp.asarray(1.5)
    late = arrays.repeat(9, lambda index, state: state * captured + index, 2.0, first)
    assert float(late) == pytest.approx(number)
    by_hand = 2.0
    for index in range(first, 9):
        by_hand = by_hand * 1.5 + index
    assert number == by_hand
    ends = [
        arrays.repeat_while(lambda x: x < 50.0, lambda x: 3 * x, one) for one in (2.0, captured)
    ]
    assert [float(end) for end in ends] == [54.0, 121.5]


@pytest.mark.parametrize("kind", [bool, jnp.asarray])
def test_only_the_branch_that_is_chosen_counts(kind: Any) -> None:
    for condition, expected in ((True, 5.0), (False, 6.0)):
        made = arrays.choose(kind(condition), lambda a: a + 2, lambda a: a * 2, 3.0)
        assert float(made) == expected


def test_leaves_of_a_record_come_back_in_place() -> None:
    numbers = arrays.leaves(KAPTON)
    double = arrays.map_leaves(lambda one: 2 * one, KAPTON)
    assert arrays.leaves(double) == [2 * one for one in numbers] and None not in numbers
    same = arrays.map_leaves(lambda one, other: other - one, KAPTON, double)
    assert same == KAPTON and type(same.sheets) is type(KAPTON.sheets)
    assert not arrays.uses_jax(KAPTON)
    assert arrays.uses_jax((1.0, [KAPTON, jnp.ones(2)])) and arrays.is_jax((1.0, jnp.ones(2)))
    assert arrays.freeze(3.0) == 3.0


def test_only_double_precision_is_double() -> None:
    for value in (1.0, np.ones(2), np.float64(3), KAPTON.film.kinetic):
        assert arrays.is_double(value)
    for value in (np.ones(2, np.float32), jnp.ones(2, jnp.float32), np.float16(3)):
        assert not arrays.is_double(value)
