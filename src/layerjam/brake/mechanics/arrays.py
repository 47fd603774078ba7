"""Array functions and loops that run on NumPy, or on JAX if an argument is an array of JAX.

A law is written once, with `xp` in place of `numpy`. Called with numbers, it runs at once and
nothing is compiled. Called with arrays of JAX, or within `jax.jit`, `grad` or `vmap`, each
operation on a traced value runs in JAX. JAX is never imported here: only a caller can bring its
arrays.
"""

import math
import sys
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from layerjam.core.errors import QuantityError

_KINDS: dict[type, bool] = {}
"""{type of a value: whether it is an array of JAX}, filled as types appear."""
_NUMBERS = frozenset((float, int, bool, np.float64, np.int64, np.bool_))
_PLAIN = _NUMBERS | {np.ndarray}
_FLAGS = frozenset((bool, np.bool_))
_F8 = np.float64


def is_jax(value: Any) -> bool:
    """Return whether a value is an array of JAX or a tracer, or a sequence that contains one."""
    kind = type(value)
    answer = _KINDS.get(kind)
    if answer is None:
        if isinstance(value, tuple | list):
            return any(map(is_jax, value))
        answer = _KINDS[kind] = kind.__module__.partition(".")[0] in ("jax", "jaxlib")
    return answer


def leaves(tree: Any) -> list[Any]:
    """Return the numbers and arrays in nested tuples and records; None is left out."""
    if isinstance(tree, tuple | list):
        return [leaf for part in tree for leaf in leaves(part)]
    if is_dataclass(tree):
        return [leaf for f in fields(tree) for leaf in leaves(getattr(tree, f.name))]
    return [] if tree is None else [tree]


def uses_jax(tree: Any) -> bool:
    """Return whether nested tuples and records contain an array of JAX."""
    return "jax" in sys.modules and any(map(is_jax, leaves(tree)))


def map_leaves(function: Callable[..., Any], tree: Any, *others: Any) -> Any:
    """Return the tree with `function` applied to the leaves of trees of the same form."""
    if isinstance(tree, tuple | list):
        parts = [map_leaves(function, *group) for group in zip(tree, *others, strict=True)]
        return type(tree)(*parts) if hasattr(tree, "_fields") else type(tree)(parts)
    if is_dataclass(tree):
        rec: Any = object.__new__(type(tree))
        for f in fields(tree):
            rec.__dict__[f.name] = map_leaves(
                function, *(getattr(t, f.name) for t in (tree, *others))
            )
        return rec
    return None if tree is None else function(tree, *others)


class _Namespace:
    """Functions and constants of NumPy; given an array of JAX, a function runs in JAX."""

    def __getattr__(self, name: str) -> Any:
        plain: Any = getattr(np, name)
        if callable(plain) and not isinstance(plain, type):
            plain = _make_dispatcher(name, _QUICK.get(name), plain)
        setattr(self, name, plain)
        return plain


def _make_dispatcher(name: str, quick: Any, plain: Any) -> Any:
    def function(*args: Any, **keywords: Any) -> Any:
        if quick is not None:
            result = quick(*args)
            if result is not None:
                return result
        for arg in args:
            if type(arg) not in _PLAIN and is_jax(arg):
                return getattr(sys.modules["jax.numpy"], name)(*args, **keywords)
        result = plain(*args, **keywords)
        # NumPy's functions return arrays without axes where its operators return numbers
        return result[()] if type(result) is np.ndarray and not result.ndim else result

    return function


# NumPy takes ten times as long for plain numbers; None means "not plain numbers"


def _number(value: Any) -> Any:
    """Return a number of Python as one of NumPy, which may be divided by zero."""
    return _F8(value) if type(value) is float else value


def _select(condition: Any, yes: Any, no: Any) -> Any:
    if type(condition) in _FLAGS and type(yes) in _NUMBERS and type(no) in _NUMBERS:
        return _number(yes if condition else no)
    return None


def _maximum(a: Any, b: Any) -> Any:
    if type(a) in _NUMBERS and type(b) in _NUMBERS:
        return _number(a if a >= b or a != a else b)
    return None


def _minimum(a: Any, b: Any) -> Any:
    if type(a) in _NUMBERS and type(b) in _NUMBERS:
        return _number(a if a <= b or a != a else b)
    return None


def _sqrt(a: Any) -> Any:
    return _F8(math.sqrt(a)) if type(a) in _NUMBERS and a >= 0 else None


def _fill(number: float) -> Any:
    def quick(a: Any, *_: Any) -> Any:
        kind = type(a)
        return _F8(number) if kind is _F8 or kind is float else None

    return quick


def _broadcast_arrays(*args: Any) -> Any:
    return tuple(map(_F8, args)) if all(type(a) in _NUMBERS for a in args) else None


_QUICK: dict[str, Any] = {
    "where": _select,
    "maximum": _maximum,
    "minimum": _minimum,
    "sqrt": _sqrt,
    "zeros_like": _fill(0.0),
    "ones_like": _fill(1.0),
    "broadcast_arrays": _broadcast_arrays,
}
xp = _Namespace()
"""Stands for `numpy` in the laws."""


def erf(value: Any) -> Any:
    """Return the error function."""
    if is_jax(value):
        return sys.modules["jax"].lax.erf(value)
    if np.ndim(value) == 0:
        return _F8(math.erf(value))
    from scipy.special import erf as erf_of_arrays

    return erf_of_arrays(value)


def freeze(tree: Any) -> Any:
    """Return the values without their gradient."""
    return sys.modules["jax"].lax.stop_gradient(tree) if uses_jax(tree) else tree


def without_gradient(value: Any, name: str, reason: str) -> Any:
    """Return the value; its derivative raises QuantityError."""
    if not is_jax(value):
        return value

    def reject(_: Any, __: Any) -> Any:
        raise QuantityError.of(name, reason)

    identity = sys.modules["jax"].custom_jvp(lambda x: x)
    identity.defjvp(reject)
    return identity(value)


def derivative(function: Callable[[Any], Any], place: Any) -> Any:
    """Return the derivative of an array function, element by element: in NumPy by a difference."""
    if is_jax(place):
        return sys.modules["jax"].jvp(function, (place,), (xp.ones_like(place),))[1]
    gap = 1e-6 * (xp.abs(place) + 1e-6)
    return (function(place + gap) - function(place - gap)) / (2 * gap)


def put(array: Any, place: Any, value: Any) -> Any:
    """Return the array with one entry of its first axis replaced; for compiled code only."""
    return sys.modules["jax"].lax.dynamic_update_index_in_dim(array, value, place, 0)


def repeat(count: int, step: Callable[[Any, Any], Any], state: Any, first: int = 0) -> Any:
    """Return the state after `step(index, state)` for each index up to `count`."""
    for index in range(first, count):
        # traced from the start, or once a captured value has entered the state
        if index - first < 2 and uses_jax(state):
            return sys.modules["jax"].lax.fori_loop(index, count, step, state)
        state = step(index, state)
    return state


def repeat_while(goes_on: Callable[[Any], Any], step: Callable[[Any], Any], state: Any) -> Any:
    """Return the state after as many steps as `goes_on(state)` allows."""
    while True:
        goes_on_now = goes_on(state)
        if is_jax(goes_on_now):
            return sys.modules["jax"].lax.while_loop(goes_on, step, state)
        if not goes_on_now:
            return state
        state = step(state)


def choose(condition: Any, yes: Callable[..., Any], no: Callable[..., Any], *args: Any) -> Any:
    """Return `yes(*args)` if a single condition is true, else `no(*args)`; only one is computed."""
    if is_jax(condition):
        return sys.modules["jax"].lax.cond(condition, yes, no, *args)
    return (yes if condition else no)(*args)


def scan(step: Callable[[Any, Any], Any], state: Any, rows: Any) -> Any:
    """Return the last state, and the results of `step(state, row)` stacked along a first axis.

    For compiled code only: a history in NumPy takes a thousand times as long.
    """
    return sys.modules["jax"].lax.scan(step, state, rows)


def is_double(value: Any) -> bool:
    """Return whether a value has double precision."""
    return xp.result_type(value) == np.float64
