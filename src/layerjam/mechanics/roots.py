"""Roots of array functions, element by element, between two arrays of bounds.

Bisections are never differentiated. If a gradient is needed, one Newton step after the search
carries it (implicit function theorem).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

_PARTS, _MOST_STEPS = 64, 80
_SETTLED = 1e-13
"""Relative size of the last step of a search below which the next one has no effect."""


def rising_zero(function: Callable[[Any], Any], low: Any, high: Any, halvings: int = 80) -> Any:
    """Return the zero of a rising array function between two arrays; no gradient."""

    def bisect(_: int, bounds: tuple[Any, Any]) -> tuple[Any, Any]:
        below, above = bounds
        middle = (below + above) / 2
        weak = function(middle) < 0
        return jnp.where(weak, middle, below), jnp.where(weak, above, middle)

    return jax.lax.stop_gradient(jax.lax.fori_loop(0, halvings, bisect, (low, high))[1])


def implicit_root(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Return the root of a rising array function between two arrays, never outside them.

    It is found by 80 bisections. One Newton step carries the gradient (implicit function theorem).
    """
    guess = rising_zero(function, low, high)
    value, slope = jax.jvp(function, (guess,), (jnp.ones_like(guess),))
    slope = jax.lax.stop_gradient(jnp.where(slope > 0, slope, jnp.inf))
    return jnp.clip(guess - value / slope, low, high)


def first_fall(function: Callable[[Any], Any], low: Any, high: Any) -> tuple[Any, Any]:
    """Return where an array function first falls below zero, else `high`, and whether it does.

    Finds the first of 64 parts in which it falls below zero, and bisects.
    """
    shape = jnp.shape(low + high)
    parts = jnp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * len(shape))
    below = function(low + parts * (high - low)) < 0
    falls = below[1:] & ~below[:-1]
    first, width = jnp.argmax(falls, axis=0), (high - low) / _PARTS
    start = low + first * width
    root, any_ = rising_zero(lambda x: -function(x), start, start + width), falls.any(axis=0)
    return jnp.where(any_, root, jax.lax.stop_gradient(high)), any_


def newton_root(
    function: Callable[[tuple[Any, Any]], tuple[Any, Any, Any]],
    guess: Any,
    low: Any,
    high: Any,
    hint: Any = None,
) -> Any:
    """Return the root of a rising array function by Newton steps kept between `low` and `high`.

    `function` takes (place, hint) and returns value, slope and the hint of the next step. In
    reverse mode the values that the function captures must have no gradient.
    """
    close = _SETTLED * (high - low)

    def step(state: tuple[Any, ...]) -> tuple[Any, ...]:
        x, low, high, _, hint, count = state
        value, slope, hint = function((x, hint))
        low, high = jnp.where(value < 0, x, low), jnp.where(value > 0, x, high)
        move = -value / jnp.where(slope > 0, slope, 1.0)
        next_x = x + move
        inside = (slope > 0) & (next_x >= low) & (next_x <= high)
        is_done = (slope > 0) & (jnp.abs(move) <= close)
        new = jnp.where(is_done | inside, next_x, (low + high) / 2)
        return new, low, high, jnp.where(is_done, 0.0, jnp.abs(new - x)), hint, count + 1

    def is_unfinished(state: tuple[Any, ...]) -> Any:
        return jnp.any(state[3] > close) & (state[5] < _MOST_STEPS)

    start = (guess, low, high, jnp.full_like(guess, jnp.inf), hint, 0)
    return jax.lax.while_loop(is_unfinished, step, start)[0]


class Bracket(NamedTuple):
    """State of a search by false position; arrays of the same shape."""

    turn: Any
    low: Any
    below: Any
    """Value at `low`, halved each time that the other end moves."""
    high: Any
    above: Any
    best: Any
    """Argument with the value nearest to zero so far."""
    error: Any
    """Distance of that value from zero."""

    @property
    def is_met(self) -> Any:
        """Return whether the function crosses zero between the ends."""
        return (self.below <= 0) & (self.above >= 0)


def false_position(
    rising: Callable[[Any], Any], low: Any, high: Any, close: Any, rounds: int
) -> Bracket:
    """Return the bracket of a zero of a rising array function, by the Illinois method.

    It ends when all values are within `close` of zero, when the ends meet (at a jump), or after
    `rounds` steps. No slope is needed, and the function is compiled once.
    """

    def is_unfinished(bracket: Bracket) -> Any:
        is_open = jnp.abs(bracket.high - bracket.low) > 1e-12 * jnp.abs(bracket.high)
        still = bracket.is_met & (bracket.error > close) & is_open
        return (bracket.turn < 2) | ((bracket.turn < rounds) & jnp.any(still))

    def step(bracket: Bracket) -> Bracket:
        # the first two iterations evaluate the ends
        first, last = bracket.turn == 0, bracket.turn == 1
        share = -bracket.below / jnp.where(
            bracket.above > bracket.below, bracket.above - bracket.below, 1.0
        )
        # every third step bisects, because false position approaches a jump too slowly
        share = jnp.where(bracket.turn % 3 == 1, 0.5, jnp.clip(share, 0.0, 1.0))
        x = bracket.low + (bracket.high - bracket.low) * share
        x = jnp.where(first, bracket.low, jnp.where(last, bracket.high, x))
        value = rising(x)
        is_low = first | (~last & (value < 0))
        closer = jnp.abs(value) < bracket.error
        return Bracket(
            bracket.turn + 1,
            jnp.where(is_low, x, bracket.low),
            jnp.where(is_low, value, jnp.where(last, bracket.below, bracket.below / 2)),
            jnp.where(is_low, bracket.high, x),
            jnp.where(is_low, bracket.above / 2, value),
            jnp.where(closer, x, bracket.best),
            jnp.where(closer, jnp.abs(value), bracket.error),
        )

    zero = jnp.zeros_like(low + high)
    start = Bracket(jnp.array(0), low + zero, zero - 1, high + zero, zero + 1, zero, zero + jnp.inf)
    return jax.lax.while_loop(is_unfinished, step, start)
