"""A law over millions of cases: any mix of swept quantities, all cores, bounded memory."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.errors import MissingExtraError, QuantityError, UnknownNameError
from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.stop.exact import Stop, stop
from layerjam.mechanics.stop.many import Axis, constants_of
from layerjam.mechanics.threads import Workers
from layerjam.units import quantities

if TYPE_CHECKING:
    import xarray

CHUNK = 1 << 17
"""Cases between two reports of progress: their results stay in the cache of the cores."""
QUICK = 16
"""Chunks at once of the compiled loop, some 20 ms, where nobody asks for the pieces."""
LARGEST = 4 << 30
"""Bytes of results kept in memory; more goes to a sink."""
Array = np.ndarray[Any, Any]
Sink = Callable[[int, Mapping[str, Array]], None]
Run = Callable[[int, int, Mapping[str, Array]], None]
"""Evaluates flat cases, given the first and how many, into arrays of that length."""
_NOTHING = np.empty(0)
_NAMES = {
    "kg": "mass",
    "m/s": "speed end_speed",
    "Pa": "vacuum",
    "N/m": "spring",
    "m/s^2": "gravity",
    "m": "slip elongation travel",
    "N": "force peak_force",
    "J": "heat stored",
}
_UNITS = {name: unit for unit, names in _NAMES.items() for name in names.split()}


@dataclass(frozen=True)
class Swept:
    """One quantity of a batch: its dimension, its values and its stride over the flat grid."""

    name: str
    dimension: str | None
    values: Array = field(repr=False)
    stride: int = 1

    def at(self, cases: Array) -> Array:
        """Values of the flat cases."""
        return self.values[(cases // self.stride) % len(self.values)]


@in_double_precision
def batch(
    law: Callable[..., Any],
    sweep: Mapping[str, Any],
    *,
    brake: Brake | BrakeFile | str,
    fixed: Mapping[str, Any] | None = None,
    wanted: Sequence[str] | None = None,
    sink: Sink | None = None,
    out: Mapping[str, Array] | None = None,
    progress: Callable[[int, int], None] | None = None,
    block: int = 8192,
) -> xarray.Dataset | int:
    """Evaluate a law of the mechanics on every combination of swept quantities; SI.

    `sweep` gives each argument of `law` but the brake: a number, an array (its own axis, named
    after it) or (axis, array), so that quantities share an axis. ``"brake.film.kinetic"`` and its
    like sweep a field of the device. `fixed` goes to the law as it is, the same for every case: the
    samples of a history, None for what is not there. `brake` may be the file or its name. The
    result is labelled: a Dataset with the axes in the order given; a result named as an axis (the
    speed of a march) is NAME_reached there. With `sink`, called as sink(first, {name: values}) with
    flat pieces in order, nothing is kept and the number of cases is returned. `wanted` picks of the
    law's results; `out` gives arrays of float64 to put them into, which saves making new ones.
    `progress` is called with (done, all). Ctrl-C ends it with what is done; the rest is NaN,
    attribute `done`.

    Works in blocks of `block` cases on all cores; the exact `stop` runs as one compiled loop.
    Raises QuantityError for arrays that do not fit, and for more than 4 GiB without a sink.
    """
    if block < 1:
        raise QuantityError(f"block: {block} cases are not allowed; give 1 or more")
    brake, fixed = _brake_of(brake), dict(fixed or {})
    sweep = {**sweep, **{n: v for n, v in fixed.items() if _is_number(v) and n not in sweep}}
    fixed = {n: v for n, v in fixed.items() if n not in sweep or not _is_number(v)}
    swept = _laid_out(law, sweep, fixed, brake)
    sizes = {s.dimension: len(s.values) for s in swept if s.dimension}
    total = math.prod(sizes.values())
    run, names, quick = _runner(law, swept, fixed, brake, block)
    kept = tuple(out or names) if wanted is None else tuple(wanted)
    for name in kept:
        if name not in names:
            raise UnknownNameError("result of the law", name, names)
    if sink is None and total * len(kept) * 8 > LARGEST:
        raise QuantityError(
            f"batch: {total} cases of {len(kept)} results take "
            f"{total * len(kept) * 8 / 1e9:.3g} GB; give a sink, or fewer of the results as wanted"
        )
    size = total if sink is None else min(CHUNK, total)
    whole = {n: _flat(n, out, size) for n in kept}
    done, most = 0, CHUNK * (QUICK if quick and sink is None and progress is None else 1)
    with Workers() as pool:
        try:
            while done < total:
                count = min(most, total - done)
                place = slice(done, done + count) if sink is None else slice(0, count)
                piece = {n: values[place] for n, values in whole.items()}
                pool.share(count, functools.partial(_some, run, done, piece))
                if sink is not None:
                    sink(done, piece)
                done += count
                if progress is not None:
                    progress(done, total)
        except KeyboardInterrupt:
            if sink is not None:
                return done
    if sink is not None:
        return done
    for values in whole.values():
        values[done:] = np.nan
    return _labelled(whole, swept, sizes, law.__name__, done)


def _some(run: Run, done: int, piece: Mapping[str, Array], first: int, last: int) -> None:
    run(done + first, last - first, {n: values[first:last] for n, values in piece.items()})


def _flat(name: str, out: Mapping[str, Array] | None, size: int) -> Array:
    """Where a result goes: the array given, seen as one row, or a new one."""
    if out is None:
        return np.empty(size)
    given = out[name]
    if given.size != size or given.dtype != np.float64 or not given.flags.c_contiguous:
        raise QuantityError(f"out: {name} must be a row of {size} float64 numbers")
    return given.reshape(-1)


def _brake_of(brake: Brake | BrakeFile | str) -> Brake:
    if isinstance(brake, str):
        return load(brake).brake
    if isinstance(brake, BrakeFile):
        return brake.brake
    if not isinstance(brake, Brake):
        raise QuantityError(f"brake: a {type(brake).__name__} is no brake, brake file or name")
    return brake


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _row(name: str, given: Any) -> Array:
    """Values of one quantity; QuantityError for what is no number or one row of them."""
    if given is None:
        raise QuantityError(f"{name}: None cannot be swept; give it in fixed")
    try:
        values = np.asarray(given, float)
    except (TypeError, ValueError):
        text = repr(given)
        raise QuantityError(
            f"{name}: {text if len(text) < 60 else text[:57] + '...'} is no number or row of "
            "numbers; a batch takes SI"
        ) from None
    if values.ndim > 1 or values.size == 0:
        raise QuantityError(f"{name}: has shape {values.shape}; it is a number or one row")
    return values


def _laid_out(
    law: Callable[..., Any], sweep: Mapping[str, Any], fixed: Mapping[str, Any], brake: Brake
) -> list[Swept]:
    """Every argument with its stride; QuantityError or UnknownNameError for what does not fit."""
    arguments = [n for n in inspect.signature(law).parameters if n != "brake"]
    fields = [f"brake.{path}" for path, _, _ in quantities(type(brake))]
    for name in (*sweep, *fixed):
        if name not in arguments and (name not in fields or name in fixed):
            raise UnknownNameError("quantity", name, arguments + fields)
        if name in sweep and name in fixed:
            raise QuantityError(f"{name}: swept and fixed; give it once")
    for name in arguments:
        if name not in sweep and name not in fixed:
            raise QuantityError(f"{name}: missing; the law {law.__name__} needs it")
    lengths: dict[str, int] = {}
    plain: list[tuple[str, str | None, Array]] = []
    for name, given in sweep.items():
        pair = isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], str)
        values = _row(name, given[1] if pair else given)
        dimension = (given[0] if pair else name) if values.ndim else None
        if dimension is not None and lengths.setdefault(dimension, len(values)) != len(values):
            raise QuantityError(
                f"{name}: has {len(values)} values, others on the axis '{dimension}' have "
                f"{lengths[dimension]}"
            )
        plain.append((name, dimension, np.ascontiguousarray(np.atleast_1d(values))))
    strides, stride = {}, 1
    for dimension in reversed(lengths):
        strides[dimension] = stride
        stride *= lengths[dimension]
    return [Swept(n, d, v, strides[d] if d else 1) for n, d, v in plain]


def _runner(
    law: Callable[..., Any], swept: list[Swept], fixed: Mapping[str, Any], brake: Brake, block: int
) -> tuple[Run, tuple[str, ...], bool]:
    """What evaluates flat cases, the names of its results, and whether it is the compiled loop."""
    constants = constants_of(brake) if law is stop else None
    if constants is not None and not fixed and not any(s.name.startswith("brake.") for s in swept):
        from layerjam.mechanics.stop.loops import kernel

        order = [n for n in inspect.signature(law).parameters if n != "brake"]
        by_name = {s.name: s for s in swept}
        axes = tuple(Axis(by_name[n].values, by_name[n].stride) for n in order)

        def stops(first: int, count: int, out: Mapping[str, Array]) -> None:
            into = tuple(out.get(n, _NOTHING) for n in Stop._fields)
            lost = np.zeros(count, bool)
            if kernel()(first, count, axes, constants, into, lost):
                # the few whose root the steps did not find: bracketed, by the law itself
                where = np.flatnonzero(lost)
                again = stop(**{s.name: s.at(first + where) for s in swept}, brake=brake)
                for name, values in out.items():
                    values[where] = np.asarray(getattr(again, name))

        return stops, Stop._fields, True
    return *_traced(law, swept, fixed, brake, block), False


@functools.lru_cache(maxsize=64)
def _many(law: Callable[..., Any], names: tuple[str, ...]) -> tuple[Any, Any]:
    """The law on one block, and compiled for blocks one after the other that stay in the cache."""
    order = [n for n in inspect.signature(law).parameters if n != "brake"]

    def one(values: tuple[Any, ...], fixed: Mapping[str, Any], brake: Brake) -> Any:
        given = {**dict(zip(names, values, strict=True)), **fixed}
        for name in names:
            if name.startswith("brake."):
                brake = _with(brake, name.split(".")[1:], given[name])
        return law(*(given[n] for n in order), brake)

    return one, jax.jit(
        lambda values, fixed, brake: jax.lax.map(lambda v: one(v, fixed, brake), values)
    )


def _traced(
    law: Callable[..., Any], swept: list[Swept], fixed: Mapping[str, Any], brake: Brake, block: int
) -> tuple[Run, tuple[str, ...]]:
    one, many = _many(law, tuple(s.name for s in swept))
    held = {n: None if v is None else _samples(n, v) for n, v in fixed.items()}

    def shaped(shape: tuple[int, ...]) -> Any:
        row = tuple(jax.ShapeDtypeStruct(shape, jnp.float64) for _ in swept)
        return jax.eval_shape(one, row, held, brake)

    try:
        # one case alone: what the law takes as samples would pass for them in a block of cases
        shaped(())
        # three cases, so that a result of one case's shape is told from samples and from one number
        shape = shaped((3,))
    except (TypeError, ValueError, IndexError) as err:
        why = str(err).splitlines()[0][:200]
        raise QuantityError(
            f"batch: the law {law.__name__} does not take these quantities ({why}); what has the "
            "same samples for every case, or is None, goes into fixed"
        ) from None
    named = shape._asdict() if hasattr(shape, "_asdict") else {law.__name__: shape}
    # what has no number for each case, such as a memory, is left out
    fields = tuple(n for n, v in named.items() if getattr(v, "shape", None) == (3,))

    def run(first: int, count: int, out: Mapping[str, Array]) -> None:
        size = min(block, max(count, 1))
        rows = 1 << max(0, math.ceil(math.log2(count / size)))
        # filled up with the last case, so that every piece has one of few shapes
        cases = np.minimum(np.arange(first, first + rows * size), first + count - 1)
        made = many(tuple(s.at(cases).reshape(rows, size) for s in swept), held, brake)
        flat = made._asdict() if hasattr(made, "_asdict") else {law.__name__: made}
        for name, values in out.items():
            values[:] = np.asarray(flat[name]).reshape(-1)[:count]

    return run, fields


def _samples(name: str, given: Any) -> Array:
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError):
        raise QuantityError(f"{name}: fixed, but neither None nor numbers") from None


def _with(record: Any, path: list[str], value: Any) -> Any:
    """The record with one field, however deep, replaced; nothing is checked, as it is traced."""
    names = {n: getattr(record, n) for n in record.__dataclass_fields__}
    names[path[0]] = value if len(path) == 1 else _with(names[path[0]], path[1:], value)
    new = object.__new__(type(record))
    for name, held in names.items():
        object.__setattr__(new, name, held)
    return new


def _labelled(
    whole: Mapping[str, Array], swept: list[Swept], sizes: Mapping[Any, int], law: str, done: int
) -> xarray.Dataset:
    with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
        import xarray
    shape, axes = tuple(sizes.values()), tuple(sizes)
    fields = {f"brake.{path}": m.unit for path, m, _ in quantities(Brake)}
    coordinates = {
        s.name: (s.dimension, s.values, {"units": _UNITS.get(s.name, fields.get(s.name, ""))})
        for s in swept
        if s.dimension
    }
    data = {}
    for name, values in whole.items():
        key = f"{name}_reached" if name in coordinates else name
        data[key] = (axes, values.reshape(shape), {"units": _UNITS.get(name, "")})
    fixed = {s.name: float(s.values[0]) for s in swept if not s.dimension}
    return xarray.Dataset(data, coords=coordinates, attrs={"law": law, "done": done, **fixed})
