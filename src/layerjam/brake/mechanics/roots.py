"""Roots of array functions, element by element, between two arrays of bounds.

Bisections are never differentiated. If a gradient is needed, one Newton step after the search
carries it (implicit function theorem).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.arrays import (
    choose,
    derivative,
    freeze,
    is_jax,
    repeat,
    repeat_while,
    xp,
)

_PARTS, _MOST_STEPS = 64, 80
_SETTLED = 1e-13
"""Relative size of the last step of a search below which the next one has no effect."""


def rising_zero(
    function: Callable[[Any], Any],
    low: Any,
    high: Any,
    halvings: int = 80,
    ends: tuple[Any, Any] | None = None,
) -> Any:
    """Return the zero of a rising array function between two arrays; no gradient.

    `ends` are its values there, if they are known.
    """

    def bisect(_: int, bounds: tuple[Any, Any]) -> tuple[Any, Any]:
        below, above = bounds
        middle = (below + above) / 2
        weak = function(middle) < 0
        return xp.where(weak, middle, below), xp.where(weak, above, middle)

    first, last = (function(low), function(high)) if ends is None else ends
    if is_jax(first) or is_jax(last) or is_jax(low) or is_jax(high):
        return freeze(repeat(halvings, bisect, (low, high))[1])
    return _interpolate_zero(function, (low, first), (high, last))


def _interpolate_zero(
    function: Callable[[Any], Any], start: tuple[Any, Any], end: tuple[Any, Any]
) -> Any:
    """Return the same zero by Chandrupatla's method, which needs a tenth of the evaluations.

    It is not for JAX, where a loop of unknown length has no reverse derivative.
    """
    # like a bisection, count NaN as negative at the lower end and as positive elsewhere
    (a, fa), (b, fb) = start, end
    fa, fb = xp.where(xp.isnan(fa), -xp.inf, fa), xp.where(xp.isnan(fb), xp.inf, fb)
    low, high, is_below, is_above = a, b, fb < 0, fa >= 0
    # start where a straight line crosses zero
    line = fa / (fa - fb)
    t = xp.where((line > 0) & (line < 1), line, 0.5)
    for _ in range(_MOST_STEPS):
        x = a + t * (b - a)
        f = function(x)
        f = xp.where(xp.isnan(f), xp.inf, f)
        has_same_sign = (f < 0) == (fa < 0)
        c, fc = xp.where(has_same_sign, a, b), xp.where(has_same_sign, fa, fb)
        b, fb, a, fa = xp.where(has_same_sign, b, a), xp.where(has_same_sign, fb, fa), x, f
        best = xp.where(xp.abs(fa) < xp.abs(fb), a, b)
        tiny = 2.3e-16 * xp.abs(best) / xp.abs(b - a)
        is_open = (tiny < 0.5) & (f != 0) & (a != b) & ~is_below & ~is_above
        if not xp.any(is_open):
            break
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        fits = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi) & xp.isfinite(t)
        t = xp.where(is_open, xp.clip(xp.where(fits, t, 0.5), tiny, 1 - tiny), 0.0)
    root = xp.where(fa < 0, b, a)
    return xp.where(is_below, high, xp.where(is_above, low, root))


def implicit_root(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Return the root of a rising array function between two arrays, never outside them.

    It is found by 80 bisections. One Newton step carries the gradient (implicit function theorem).
    """
    guess = rising_zero(function, low, high)
    return carry_gradient(function, guess, low, high)


def crossing(
    function: Callable[[Any], Any],
    low: Any,
    high: Any,
    solve: Callable[[Any, Any], Any] | None = None,
) -> Any:
    """Return `implicit_root` where the function crosses zero between two arrays, else NaN.

    `solve` finds the root between two arrays, if there is a faster way than a search.
    """
    ends = function(low), function(high)
    if solve is None:
        root = rising_zero(function, low, high, ends=ends)
    else:
        root = freeze(xp.clip(solve(low, high), low, high))
    root = carry_gradient(function, root, low, high)
    return xp.where((ends[0] <= 0) & (ends[1] >= 0), root, xp.nan)


def carry_gradient(function: Callable[[Any], Any], root: Any, low: Any, high: Any) -> Any:
    """Return a root that was found without gradient, with the gradient of the implicit function."""
    if not is_jax(root):
        return root
    slope = freeze(derivative(function, root))
    slope = xp.where(slope > 0, slope, xp.inf)
    return xp.clip(root - function(root) / slope, low, high)


def sample(low: Any, high: Any) -> Any:
    """Return the 65 places between two arrays at which `first_fall` looks, along a first axis."""
    parts = np.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * xp.ndim(low + high))
    return low + parts * (high - low)


def first_fall(
    function: Callable[[Any], Any], low: Any, high: Any, values: Any = None
) -> tuple[Any, Any]:
    """Return where an array function first falls below zero, else `high`, and whether it does.

    Finds the first of 64 parts in which it falls below zero, and searches there. `values` are those
    of the function at the ends of the parts (see `sample`), if they are known.
    """
    is_negative = (function(sample(low, high)) if values is None else values) < 0
    is_crossing = is_negative[1:] & ~is_negative[:-1]
    first = xp.argmax(is_crossing, axis=0)
    width = (high - low) / _PARTS
    any_ = is_crossing.any(axis=0)
    start = low + first * width

    def search(start: Any) -> Any:
        first, last = -function(start), -function(start + width)
        # if the part starts at a zero, the function may rise before it falls
        ends = xp.where(first < 0, first, -xp.abs(last)), last
        return rising_zero(lambda x: -function(x), start, start + width, ends=ends)

    root = choose(xp.any(any_), search, lambda start: start + width, start)
    return xp.where(any_, root, freeze(high)), any_


def newton_root(
    function: Callable[[tuple[Any, Any]], tuple[Any, Any, Any]],
    guess: Any,
    low: Any,
    high: Any,
    hint: Any = None,
) -> Any:
    """Return the root of a rising array function by Newton steps kept between `low` and `high`.

    Each element takes its own steps until it settles: its root never depends on the others.
    `function` takes (place, hint) and returns value, slope and the hint of the next step. In
    reverse mode the values that the function captures must have no gradient.
    """
    tolerance = _SETTLED * (high - low)

    def step(state: tuple[Any, ...]) -> tuple[Any, ...]:
        x, low, high, size, hint, count = state
        value, slope, hint = function((x, hint))
        low, high = xp.where(value < 0, x, low), xp.where(value > 0, x, high)
        move = -value / xp.where(slope > 0, slope, 1.0)
        next_x = x + move
        is_inside = (slope > 0) & (next_x >= low) & (next_x <= high)
        is_done = ((slope > 0) & (xp.abs(move) <= tolerance)) | xp.isnan(value)
        new = xp.where(is_done | is_inside, next_x, (low + high) / 2)
        is_open, size = size > tolerance, xp.where(is_done, 0.0, xp.abs(new - x))
        return xp.where(is_open, new, x), low, high, xp.where(is_open, size, 0.0), hint, count + 1

    def is_unfinished(state: tuple[Any, ...]) -> Any:
        return xp.any(state[3] > tolerance) & (state[5] < _MOST_STEPS)

    start = (guess, low, high, xp.full_like(guess, xp.inf), hint, 0)
    return repeat_while(is_unfinished, step, start)[0]


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
    `rounds` steps. No slope is needed, and the function is compiled once. A value that has ended
    does not change while others go on.
    """

    def goes_on(bracket: Bracket) -> Any:
        is_open = xp.abs(bracket.high - bracket.low) > 1e-12 * xp.abs(bracket.high)
        return (bracket.turn < 2) | (bracket.is_met & (bracket.error > close) & is_open)

    def is_unfinished(bracket: Bracket) -> Any:
        return (bracket.turn < rounds) & xp.any(goes_on(bracket))

    def step(bracket: Bracket) -> Bracket:
        # the first two iterations evaluate the ends
        first, last = bracket.turn == 0, bracket.turn == 1
        share = -bracket.below / xp.where(
            bracket.above > bracket.below, bracket.above - bracket.below, 1.0
        )
        # every third step bisects, because false position approaches a jump too slowly
        share = xp.where(bracket.turn % 3 == 1, 0.5, xp.clip(share, 0.0, 1.0))
        x = bracket.low + (bracket.high - bracket.low) * share
        x = xp.where(first, bracket.low, xp.where(last, bracket.high, x))
        value = rising(x)
        is_low = first | (~last & (value < 0))
        closer = xp.abs(value) < bracket.error
        new = Bracket(
            bracket.turn + 1,
            xp.where(is_low, x, bracket.low),
            xp.where(is_low, value, xp.where(last, bracket.below, bracket.below / 2)),
            xp.where(is_low, bracket.high, x),
            xp.where(is_low, bracket.above / 2, value),
            xp.where(closer, x, bracket.best),
            xp.where(closer, xp.abs(value), bracket.error),
        )
        state = (
            xp.where(goes_on(bracket), *pair) for pair in zip(new[1:], bracket[1:], strict=True)
        )
        return Bracket(new.turn, *state)

    zero = xp.zeros_like(low + high)
    start = Bracket(xp.asarray(0), low + zero, zero - 1, high + zero, zero + 1, zero, zero + xp.inf)
    return repeat_while(is_unfinished, step, start)
