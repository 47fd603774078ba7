"""Roots of array functions, element by element, between two arrays.

Halvings are never differentiated. Where a gradient is needed, one Newton step after the search
carries it (implicit function theorem).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

_PARTS, _MOST_STEPS = 64, 80
_SETTLED = 1e-13
"""Last step of a search, over its bracket, below which the next one changes nothing."""


def rising_zero(function: Callable[[Any], Any], low: Any, high: Any, halvings: int = 80) -> Any:
    """Return where a rising array function passes zero between two arrays; no gradient."""

    def halve(_: int, bounds: tuple[Any, Any]) -> tuple[Any, Any]:
        below, above = bounds
        middle = (below + above) / 2
        weak = function(middle) < 0
        return jnp.where(weak, middle, below), jnp.where(weak, above, middle)

    return jax.lax.stop_gradient(jax.lax.fori_loop(0, halvings, halve, (low, high))[1])


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

    `function` takes (place, hint) and returns value, slope and the hint of the next step. In
    reverse mode the values that it encloses must have no gradient.
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


class Bracket(NamedTuple):
    """State of a search by false position; arrays of one shape."""

    turn: Any
    low: Any
    under: Any
    """Value at `low`, halved each time that the other end moves."""
    high: Any
    above: Any
    best: Any
    """Place with the value nearest to zero so far."""
    near: Any
    """Distance of that value from zero."""

    @property
    def is_met(self) -> Any:
        """Whether the function passes zero between the ends."""
        return (self.under <= 0) & (self.above >= 0)


def false_position(
    rising: Callable[[Any], Any], low: Any, high: Any, close: Any, rounds: int
) -> Bracket:
    """Search where a rising array function passes zero, by Illinois' false position.

    It ends once all values are within `close` of zero, the ends meet (at a jump), or after so many
    rounds. No slope is needed, and the function is compiled once.
    """

    def goes_on(at: Bracket) -> Any:
        apart = jnp.abs(at.high - at.low) > 1e-12 * jnp.abs(at.high)
        still = at.is_met & (at.near > close) & apart
        return (at.turn < 2) | ((at.turn < rounds) & jnp.any(still))

    def step(at: Bracket) -> Bracket:
        # the first two turns evaluate the ends
        first, last = at.turn == 0, at.turn == 1
        share = -at.under / jnp.where(at.above > at.under, at.above - at.under, 1.0)
        # every third step halves: a jump would be approached too slowly
        share = jnp.where(at.turn % 3 == 1, 0.5, jnp.clip(share, 0.0, 1.0))
        x = at.low + (at.high - at.low) * share
        x = jnp.where(first, at.low, jnp.where(last, at.high, x))
        here = rising(x)
        less = first | (~last & (here < 0))
        closer = jnp.abs(here) < at.near
        return Bracket(
            at.turn + 1,
            jnp.where(less, x, at.low),
            jnp.where(less, here, jnp.where(last, at.under, at.under / 2)),
            jnp.where(less, at.high, x),
            jnp.where(less, jnp.where(first, at.above, at.above / 2), here),
            jnp.where(closer, x, at.best),
            jnp.where(closer, jnp.abs(here), at.near),
        )

    zero = jnp.zeros_like(low + high)
    start = Bracket(jnp.array(0), low + zero, zero - 1, high + zero, zero + 1, zero, zero + jnp.inf)
    return jax.lax.while_loop(goes_on, step, start)
