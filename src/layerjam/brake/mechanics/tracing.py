"""JAX below the laws: records as pytrees, double precision, compiled programs.

Importing this module imports JAX. Laws do so at their first call with arrays of JAX, and marching
solvers at their first call.
"""

import contextlib
import dataclasses
import functools
import operator
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any, TypeVar

import numpy as np

from layerjam.brake.mechanics.compilation import keep_compiled_code
from layerjam.core.errors import PlatformError, PrecisionError
from layerjam.core.evolve import field_names
from layerjam.core.record_classes import follow_records
from layerjam.core.units import FlagSpec

__all__ = ["Program", "double_precision", "in_double_precision", "is_tracing", "jax", "jnp"]
F = TypeVar("F", bound=Callable[..., Any])


@contextlib.contextmanager
def _delay_interrupts() -> Iterator[None]:
    """Delay interrupts inside the block, because they crash Python while compiled modules load."""
    old_handler = signal.getsignal(signal.SIGINT)
    if old_handler is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    caught: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: caught.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, old_handler)
    if caught:
        signal.raise_signal(signal.SIGINT)


os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
with _delay_interrupts():
    import jax
    import jax.numpy as jnp


def _check_platforms() -> None:
    """Raise PlatformError if the user has named platforms on which JAX cannot compute."""
    platforms = str(jax.config.jax_platforms or "")
    if platforms in ("", "cpu"):
        return
    try:
        jax.devices()
    except (RuntimeError, AssertionError) as error:
        raise PlatformError(platforms) from error


_check_platforms()
keep_compiled_code()


def _register(cls: type) -> None:
    """Make a record class a JAX pytree, so that brakes can be traced, batched and stacked.

    JAX stores arrays and placeholders in it, which bypasses the constructor's checks.
    """
    names = field_names(cls)
    keys = [jax.tree_util.GetAttrKey(name) for name in names]
    specs = [f.metadata.get("quantity") for f in dataclasses.fields(cls)]
    read = operator.attrgetter(*names) if len(names) > 1 else _make_field_reader(names[0])
    has_integers = any(
        isinstance(spec, FlagSpec) or getattr(spec, "whole", False) for spec in specs
    )

    def flatten(rec: Any) -> tuple[Any, None]:
        return read(rec), None

    if has_integers:  # JAX differentiates only with respect to floats

        def flatten(rec: Any) -> tuple[Any, None]:
            return tuple(float(v) if isinstance(v, int) else v for v in read(rec)), None

    def unflatten(_: None, leaves: Any) -> Any:
        rec: Any = object.__new__(cls)
        rec.__dict__.update(zip(names, leaves, strict=True))
        return rec

    def flatten_with_keys(rec: Any) -> tuple[Any, None]:
        return tuple(zip(keys, flatten(rec)[0], strict=True)), None

    jax.tree_util.register_pytree_with_keys(cls, flatten_with_keys, unflatten, flatten)


def _make_field_reader(name: str) -> Callable[[Any], tuple[Any, ...]]:
    return lambda rec: (getattr(rec, name),)


follow_records(_register)


def double_precision() -> AbstractContextManager[None]:
    """Return a context in which JAX computes in float64, in this thread only."""
    already: bool = jax.config.jax_enable_x64
    return contextlib.nullcontext() if already else jax.enable_x64(True)


def in_double_precision(function: F) -> F:
    """Return the function, run in `double_precision` regardless of the process's settings."""

    @functools.wraps(function)
    def wrapper(*args: Any, **keywords: Any) -> Any:
        with double_precision():
            return function(*args, **keywords)

    return wrapper  # type: ignore[return-value]


_make_constant = jax.jit(lambda: True)
"""Returns a tracer while JAX traces, in a sixth of the time of `jnp.zeros(())`."""


def is_tracing(tree: Any = None) -> bool:
    """Return whether JAX traces values of a tree, or the current computation."""
    return any(map(_is_tracer, [*jax.tree.leaves(tree), _make_constant()]))


def _is_tracer(leaf: Any) -> bool:
    return isinstance(leaf, jax.core.Tracer)


FEW = 1000
"""Size of the largest array with which a program is compiled for few numbers."""
_UNFUSED = {"xla_cpu_use_fusion_emitters": False}
"""Option of a program for few numbers, which then compiles in half the time and runs as fast. Ten
thousand stops in time would take 1.6 times as long."""


class Program:
    """An array function that JAX compiles, once for each shape, in double precision.

    Called with numbers while nothing is traced, it returns NumPy's numbers, which JAX cannot
    truncate afterwards; so does a call with JAX's arrays while JAX works in single precision. A
    trace in single precision would truncate them: it raises PrecisionError.
    """

    def __init__(self, function: Callable[..., Any], static: tuple[str, ...] = ()) -> None:
        self._jitted = jax.jit(function, static_argnames=static)
        self._for_few = jax.jit(function, static_argnames=static, compiler_options=_UNFUSED)

    def __call__(self, has_jax: bool, *args: Any, **static: Any) -> Any:
        """Return the function's result; `has_jax`: whether an argument is an array of JAX."""
        is_double = jax.config.jax_enable_x64
        if has_jax and is_double:
            return self._jitted(*args, **static)
        if is_tracing(args):
            if not is_double:
                raise PrecisionError
            return self._jitted(*args, **static)
        is_large = any(getattr(leaf, "size", 1) > FEW for leaf in jax.tree.leaves(args))
        with double_precision():
            result = (self._jitted if is_large else self._call_for_few)(*args, **static)
        return jax.tree.map(lambda leaf: np.asarray(leaf)[()], result)

    def _call_for_few(self, *args: Any, **static: Any) -> Any:
        try:
            return self._for_few(*args, **static)
        except jax.errors.JaxRuntimeError:  # a later version of JAX may not know the option
            self._for_few = self._jitted
            return self._jitted(*args, **static)
