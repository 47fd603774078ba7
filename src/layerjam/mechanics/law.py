"""Common parts of all laws: double precision, broadcasting, compilation."""

import contextlib
import dataclasses
import functools
import inspect
import operator
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.errors import ArgumentError, PrecisionError, QuantityError, short_text
from layerjam.mechanics.compilation import keep_compiled_code
from layerjam.units import RECORDS, FlagSpec

F = TypeVar("F", bound=Callable[..., Any])
_known_records: set[type] = set()
keep_compiled_code()


def register_records() -> None:
    """Make every record class a JAX pytree, so that brakes can be traced, batched and stacked."""
    for cls in RECORDS:
        if cls not in _known_records:
            _register(cls)
            _known_records.add(cls)


def _register(cls: type) -> None:
    """Register one record class.

    JAX stores arrays and placeholders in it, which bypasses the constructor's checks.
    """
    names = list(cls.__dataclass_fields__)  # type: ignore[attr-defined]
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


def double_precision() -> AbstractContextManager[None]:
    """Return a context in which JAX computes in float64, in this thread only."""
    already: bool = jax.config.jax_enable_x64
    return contextlib.nullcontext() if already else jax.enable_x64(True)


def in_double_precision(function: F) -> F:
    """Return the function, run in `double_precision` regardless of the process's settings."""

    @functools.wraps(function)
    def wrapper(*args: Any, **named: Any) -> Any:
        with double_precision():
            return function(*args, **named)

    return wrapper  # type: ignore[return-value]


def law(function: F) -> F:
    """Return a pure array function of SI quantities and records.

    A BrakeFile is accepted in place of its brake.

    Arrays, scalars and mixed shapes broadcast and are converted to float64; the function is
    compiled once per shape and can be traced, batched and differentiated. While JAX works in single
    precision a call still computes in `double_precision` and returns NumPy's numbers, which JAX
    cannot truncate afterwards. A trace in single precision would truncate them, so the law then
    raises PrecisionError.
    """
    register_records()
    program, places = jax.jit(function), inspect.signature(function)

    def call(values: Any) -> Any:
        try:
            return program(*map(_as_argument, values))
        except (TypeError, ValueError, AttributeError):
            if not _is_tracing(values):
                _explain_failure(function.__name__, places, values)
            raise

    @functools.wraps(function)
    def wrapper(*args: Any, **named: Any) -> Any:
        if len(_known_records) < len(RECORDS):  # an additional effect on the friction
            register_records()
        # pass by position, because keyword arguments would compile again
        try:
            exact = not named and len(args) == len(places.parameters)
            arguments = args if exact else places.bind(*args, **named).args
        except TypeError:
            takes = ", ".join(places.parameters)
            raise ArgumentError(f"{function.__name__}() takes {takes}") from None
        if jax.config.jax_enable_x64:
            return call(arguments)
        if _is_tracing(arguments):
            raise PrecisionError
        with double_precision():
            result = call(arguments)
        return jax.tree.map(lambda leaf: np.asarray(leaf)[()], result)

    return wrapper  # type: ignore[return-value]


def fuse(function: F) -> F:
    """Compile a small array function as one program if it is called with numbers.

    Otherwise JAX would compile each of its operations separately, for every shape. Within a trace
    the function is inlined.
    """
    return jax.jit(function, inline=True)  # type: ignore[return-value]


_make_constant = jax.jit(lambda: True)
"""Returns a tracer while JAX traces, in a sixth of the time of `jnp.zeros(())`."""


def _is_tracing(arguments: Any) -> bool:
    """Return whether JAX traces the arguments or the current computation."""
    leaves = [*jax.tree.leaves(arguments), _make_constant()]
    return any(isinstance(leaf, jax.core.Tracer) for leaf in leaves)


def _as_argument(value: Any) -> Any:
    if isinstance(value, BrakeFile):
        return value.brake
    if type(value) in _known_records or value is None:
        return value
    if isinstance(value, int | float | np.floating | np.integer) or (
        isinstance(value, np.ndarray) and value.dtype.kind in "fiu"
    ):
        return np.asarray(value, dtype=np.float64)  # JAX would compile a program to convert it
    if hasattr(value, "units") or hasattr(value, "unit"):
        raise QuantityError(
            f"laws take numbers in SI units, not '{str(value)[:60]}'; convert it, for example with "
            ".to('Pa').magnitude, or call a command's function, which converts it"
        )
    if getattr(getattr(value, "dtype", None), "kind", "f") not in "fiub":
        raise TypeError
    return jnp.asarray(value, dtype=jnp.float64)


def _explain_failure(name: str, places: inspect.Signature, values: Any) -> None:
    """Raise QuantityError if a failed call has arguments that no law accepts."""
    records = {cls.__name__: cls for cls in RECORDS}
    arguments = dict(zip(places.parameters, values, strict=False))
    for key, value in arguments.items():
        parameter = places.parameters[key]
        is_record = type(value) in _known_records or isinstance(value, BrakeFile)
        is_optional = parameter.default is not parameter.empty
        record = records.get(parameter.annotation, parameter.annotation)  # name or class
        if record in RECORDS:
            fits, kind = is_record, f"a {record.__name__}, such as layerjam.load(NAME).brake"
        else:
            fits = _is_real(value) or (is_optional and (is_record or value is None))
            kind = "a number or an array of numbers in SI units"
        if not fits:
            raise QuantityError.of(f"{name}, {key}", f"{short_text(value)} is not {kind}")
    shapes = {k: np.shape(v) for k, v in arguments.items() if type(v) not in _known_records}
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        text = " and ".join(f"{key} {shape}" for key, shape in shapes.items() if shape)
        raise QuantityError.of(name, f"shapes do not broadcast: {text}") from None


def _is_real(value: Any) -> bool:
    """Return whether a value is a real number or an array of real numbers."""
    try:
        return np.asarray(value).dtype.kind in "fiub"
    except ValueError:  # reject rows of different lengths
        return False


@fuse
def safe_sqrt(value: Any) -> Any:
    """Return the square root; its derivative at zero is 0 instead of infinite. NaN below zero."""
    positive = value > 0
    root = jnp.sqrt(jnp.where(positive, value, 1.0))
    return jnp.where(positive, root, jnp.where(value == 0, 0.0, jnp.nan))


def keep_if(domain: Any, value: Any) -> Any:
    """Return `value` where `domain` is true, otherwise NaN: a traced law cannot raise errors."""
    return jnp.where(domain, value, jnp.nan)
