"""Roots of array functions, element by element, between two arrays.

The search for a root is never differentiated. Where a gradient is needed, one Newton step after the
search carries it (implicit function theorem).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

_PARTS, _MOST_STEPS = 64, 80
_SETTLED = 1e-13
"""Last step of a search, over its bracket, below which the next one changes nothing."""


def rising_zero(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Where a rising array function passes zero between two arrays, by 80 halvings; no gradient."""

    def halve(_: int, bounds: tuple[Any, Any]) -> tuple[Any, Any]:
        below, above = bounds
        middle = (below + above) / 2
        weak = function(middle) < 0
        return jnp.where(weak, middle, below), jnp.where(weak, above, middle)

    return jax.lax.stop_gradient(jax.lax.fori_loop(0, 80, halve, (low, high))[1])


def implicit_root(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Return the root of a rising array function between two arrays, never outside them.

    80 halvings find it. One Newton step carries the gradient (implicit function theorem).
    """
    guess = rising_zero(function, low, high)
    value, slope = jax.jvp(function, (guess,), (jnp.ones_like(guess),))
    slope = jax.lax.stop_gradient(jnp.where(slope > 0, slope, jnp.inf))
    return jnp.clip(guess - value / slope, low, high)


def first_fall(function: Callable[[Any], Any], low: Any, high: Any) -> tuple[Any, Any]:
    """Return where an array function first falls below zero, else `high`, and whether it does.

    The first of 64 parts at whose end it is below zero and at whose start it is not, and halvings.
    """
    shape = jnp.shape(low + high)
    parts = jnp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * len(shape))
    below = function(low + parts * (high - low)) < 0
    falls = below[1:] & ~below[:-1]
    first, width = jnp.argmax(falls, axis=0), (high - low) / _PARTS
    start = low + first * width
    found, any_ = rising_zero(lambda x: -function(x), start, start + width), falls.any(axis=0)
    return jnp.where(any_, found, jax.lax.stop_gradient(high)), any_


def newton_root(
    function: Callable[[tuple[Any, Any]], tuple[Any, Any, Any]],
    guess: Any,
    low: Any,
    high: Any,
    hint: Any = None,
) -> Any:
    """Return the root of a rising array function by Newton steps kept between `low` and `high`.

    `function` takes (place, hint) and returns value, slope and the hint of the next step. The
    values that it encloses must have no gradient.
    """
    settled = _SETTLED * (high - low)

    def step(state: tuple[Any, ...]) -> tuple[Any, ...]:
        at, low, high, _, hint, count = state
        value, slope, hint = function((at, hint))
        low, high = jnp.where(value < 0, at, low), jnp.where(value > 0, at, high)
        move = -value / jnp.where(slope > 0, slope, 1.0)
        near = at + move
        inside = (slope > 0) & (near >= low) & (near <= high)
        done = (slope > 0) & (jnp.abs(move) <= settled)
        new = jnp.where(done | inside, near, (low + high) / 2)
        return new, low, high, jnp.where(done, 0.0, jnp.abs(new - at)), hint, count + 1

    def goes_on(state: tuple[Any, ...]) -> Any:
        return jnp.any(state[3] > settled) & (state[5] < _MOST_STEPS)

    start = (guess, low, high, jnp.full_like(guess, jnp.inf), hint, 0)
    return jax.lax.while_loop(goes_on, step, start)[0]
