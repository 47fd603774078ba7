"""Common parts of all laws: two kinds of law, conversion of arguments, errors, domains.

A `law` runs on NumPy if it is called with numbers, and on JAX if it is called with arrays of JAX
or traced. A `compiled` function marches in small steps. JAX compiles it for numbers as well,
because a step on one number takes NumPy as long as a step on a thousand.
"""

import functools
import inspect
import sys
from collections.abc import Callable
from dataclasses import is_dataclass
from typing import Any, TypeVar, overload

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.arrays import is_jax, uses_jax, xp
from layerjam.brake.mechanics.blocks import in_blocks
from layerjam.core.errors import ArgumentError, QuantityError, short_text
from layerjam.core.evolve import field_names
from layerjam.core.record_classes import RECORDS

F = TypeVar("F", bound=Callable[..., Any])


@overload
def law(function: F) -> F: ...
@overload
def law(*, of_points: bool) -> Callable[[F], F]: ...
def law(function: Any = None, *, of_points: bool = False) -> Any:
    """Return a pure array function of SI quantities and records.

    A BrakeFile is accepted in place of its brake. Arrays, scalars and mixed shapes broadcast and
    are converted to float64. Called with numbers it runs in NumPy. Called with arrays of JAX it is
    compiled, once for each shape, and can be traced, batched and differentiated (see `Program`).
    A law of points, which do not depend on each other, computes large arrays in blocks.
    Raises ArgumentError for missing or unknown arguments, and QuantityError for arguments that are
    not numbers in SI units or do not broadcast.
    """
    if function is None:
        return functools.partial(law, of_points=of_points)
    compute = in_blocks(function) if of_points else function
    places, program = inspect.signature(function), _as_program(_convert_traced(function))

    @functools.wraps(function)
    def wrapper(*args: Any, **keywords: Any) -> Any:
        # pass by position, because keyword arguments would compile again
        try:
            exact = not keywords and len(args) == len(places.parameters)
            arguments = args if exact else places.bind(*args, **keywords).args
        except TypeError:
            takes = ", ".join(places.parameters)
            raise ArgumentError(f"{function.__name__}() takes {takes}") from None
        try:
            numbers = tuple(map(_as_numbers, arguments))
            if any(v is _JAX for v in numbers):
                return program(True, *map(_plain_argument, arguments, numbers))
            with np.errstate(all="ignore"):  # outside its domain a law returns NaN
                return compute(*numbers)
        except (TypeError, ValueError, AttributeError):
            if not _is_tracing(arguments):
                _explain_failure(function.__name__, places, arguments)
            raise

    return wrapper


@overload
def compiled(function: F) -> F: ...
@overload
def compiled(*, static: tuple[str, ...]) -> Callable[[F], F]: ...
def compiled(function: Any = None, *, static: tuple[str, ...] = ()) -> Any:
    """Return an array function that JAX compiles, for numbers as well.

    It is for marching solvers and large batches. `static` names arguments that are compiled in,
    which are passed by name.
    """
    if function is None:
        return functools.partial(compiled, static=static)
    program = _as_program(function, static)

    @functools.wraps(function)
    def wrapper(*args: Any, **keywords: Any) -> Any:
        return program(uses_jax(args), *args, **keywords)

    return wrapper


def _convert_traced(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function with its arrays of JAX converted to float64."""

    def convert(value: Any) -> Any:
        if isinstance(value, tuple) or not is_jax(value):
            return value
        if value.dtype.kind not in "fiub":
            raise TypeError
        return xp.asarray(value, np.float64)

    @functools.wraps(function)
    def call_in_doubles(*args: Any) -> Any:
        return function(*map(convert, args))

    return call_in_doubles


def _as_program(function: Callable[..., Any], static: tuple[str, ...] = ()) -> Callable[..., Any]:
    """Return the function as a JAX program, which is made at its first call."""
    program: Any = None

    def call(has_jax: bool, *args: Any, **keywords: Any) -> Any:
        nonlocal program
        if program is None:
            from layerjam.brake.mechanics.tracing import Program

            program = Program(function, static)
        return program(has_jax, *args, **keywords)

    return call


_JAX = object()
"""Stands for an argument that contains an array of JAX."""
_NUMBERS = "_numbers"


def _as_numbers(value: Any) -> Any:
    """Return an argument with numbers and arrays of float64, or `_JAX`."""
    kind = type(value)
    if kind is float or kind is np.float64:
        return np.float64(value)
    if value is None or value is _JAX:
        return value
    if isinstance(value, BrakeFile):
        value = value.brake
    if is_dataclass(value):
        return _record_numbers(value)
    if is_jax(value):
        return _JAX
    if hasattr(value, "units") or hasattr(value, "unit"):
        raise QuantityError(
            f"laws take numbers in SI units, not '{str(value)[:60]}'; convert it, for example with "
            ".to('Pa').magnitude, or call a command's function, which converts it"
        )
    if isinstance(value, tuple):
        parts = tuple(map(_as_numbers, value))
        return _JAX if any(v is _JAX for v in parts) else parts
    array = np.asarray(value)
    if array.dtype.kind not in "fiub":
        raise TypeError
    return array.astype(np.float64, copy=False)[()]


def _record_numbers(rec: Any) -> Any:
    """Return a record with numbers of NumPy, which divide by zero and never turn complex.

    It is kept in the record, which cannot change, with the record's identity, which a copy that
    is changed does not have.
    """
    owner, copy = rec.__dict__.get(_NUMBERS, (0, None))
    if owner != id(rec):
        values = {name: _as_numbers(getattr(rec, name)) for name in field_names(type(rec))}
        if any(v is _JAX for v in values.values()):
            copy = _JAX
        else:
            copy = object.__new__(type(rec))
            copy.__dict__.update(values)
            copy.__dict__[_NUMBERS] = id(copy), copy
        rec.__dict__[_NUMBERS] = id(rec), copy
    return copy


def _is_tracing(arguments: Any) -> bool:
    """Return whether JAX traces the arguments or the current computation."""
    if "jax" not in sys.modules:
        return False
    from layerjam.brake.mechanics.tracing import is_tracing

    return is_tracing(arguments)


def _plain_argument(value: Any, numbers: Any) -> Any:
    """Return an argument of a traced call: its numbers, or its arrays of JAX."""
    if numbers is not _JAX:
        return numbers
    return value.brake if isinstance(value, BrakeFile) else value


def _explain_failure(name: str, places: inspect.Signature, values: Any) -> None:
    """Raise QuantityError if a failed call has arguments that no law accepts."""
    records = {cls.__name__: cls for cls in RECORDS}
    arguments = dict(zip(places.parameters, values, strict=False))
    for key, value in arguments.items():
        parameter = places.parameters[key]
        is_record = type(value) in RECORDS or isinstance(value, BrakeFile)
        is_optional = parameter.default is not parameter.empty
        record = records.get(
            parameter.annotation, parameter.annotation
        )  # the annotation is a name or a class
        if record in RECORDS:
            fits, kind = is_record, f"a {record.__name__}, such as layerjam.load(NAME).brake"
        else:
            fits = _is_real(value) or (is_optional and (is_record or value is None))
            kind = "a number or an array of numbers in SI units"
        if not fits:
            raise QuantityError.of(f"{name}, {key}", f"{short_text(value)} is not {kind}")
    shapes = {k: np.shape(v) for k, v in arguments.items() if type(v) not in RECORDS}
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


def safe_sqrt(value: Any) -> Any:
    """Return the square root; its derivative at zero is 0 instead of infinite. NaN below zero."""
    if not is_jax(value):
        with np.errstate(invalid="ignore"):
            return np.sqrt(value) + 0.0  # the root of -0.0 is 0.0, as in JAX
    positive = value > 0
    root = xp.sqrt(xp.where(positive, value, 1.0))
    return xp.where(positive, root, xp.where(value == 0, 0.0, xp.nan))


def keep_if(domain: Any, value: Any) -> Any:
    """Return `value` where `domain` is true, otherwise NaN: a traced law cannot raise errors."""
    return xp.where(domain, value, xp.nan)
