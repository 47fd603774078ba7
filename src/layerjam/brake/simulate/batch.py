"""Evaluation of a law over millions of cases, on all cores and in limited memory."""

import functools
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.kernel.engine import find_stop_loop
from layerjam.brake.mechanics.effects import is_linear
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.stop.algebra import NOT_A_CASE
from layerjam.brake.mechanics.stop.exact import Stop, stop
from layerjam.brake.simulate.batch_spread import BatchSpread, Run, Sweep
from layerjam.brake.simulate.drop import OUTCOMES
from layerjam.core.errors import (
    MissingExtraError,
    QuantityError,
    UnknownNameError,
    explain_arguments,
)
from layerjam.core.threads import Workers
from layerjam.core.units import quantities

if TYPE_CHECKING:
    import xarray

Array = np.ndarray[Any, Any]
F = TypeVar("F", bound=Callable[..., Any])


class Constants(NamedTuple):
    """Constants of a brake for the compiled loop, in the order of `kernel/c/stops.c`; SI."""

    friction: float
    """c per unit of vacuum [N/m/Pa]."""
    drag: float
    """q per unit of vacuum [N/m/Pa]."""
    overlap: float
    travel: float
    stiffness: float
    reach: float


def loop_constants(brake: Brake) -> Constants | None:
    """Return a brake's constants for the compiled loop, or None if the loop lacks a law of it."""
    if not is_linear(brake):
        return None
    enclosure = enclosure_law(1.0, brake)
    sheets, c = brake.sheets, friction_per_contact(1.0, brake)
    values = (c, enclosure.friction, sheets.overlap, sheets.usable_travel)
    return Constants(*(float(v) for v in (*values, enclosure.stiffness, enclosure.reach)))


CHUNK = 1 << 17
"""Number of cases between two progress reports; their results stay in the cores' caches."""
QUICK = 16
"""Number of chunks per call of the compiled loop (about 20 ms) if there is no sink."""
LARGEST = 4 << 30
"""Largest size of results in memory [bytes]; larger ones need a sink."""
Sink = Callable[[int, Mapping[str, Array]], None]
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


def _refuse_commands(function: F) -> F:
    """Make a function that takes a law name the laws if it is given a command."""

    @functools.wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        law: Any = args[0] if args else named.get("law")
        if hasattr(law, "declaration"):
            raise QuantityError(
                f"batch: {law.__name__} is a command; batch evaluates a law, such as "
                'batch(layerjam.laws.stop, {"mass": [1, 2], ...}, brake=...)'
            )
        return function(*args, **named)

    return call  # type: ignore[return-value]


@_refuse_commands
@explain_arguments
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
    interval: Literal["next", "mean"] | None = None,
) -> "xarray.Dataset | int":
    """Evaluate a law of the mechanics on every combination of swept quantities; SI.

    `sweep` specifies each argument of `law` except the brake: a number, an array (its own axis,
    named after it) or (axis, array), to share an axis. ``"brake.film.kinetic"`` sweeps a field of
    the device. `fixed` passes values unchanged: samples of a history, or None for no input. `brake`
    may be a file or its name; the `spring` of a stop must include the rope, which is not read.

    The result is a labelled Dataset with the axes in the order given. A result with the name of an
    axis (the speed of a march) is renamed NAME_reached. Attributes of an `outcome` name its codes.
    With `sink`, called as sink(first, {name: values}) with flat pieces in order, nothing is stored
    and the number of cases is returned. `wanted` selects results of the law; `out` provides arrays
    of float64 to reuse. `progress` is called with (done, all).

    With `interval`, each result also has the ends NAME_low and NAME_high of the 95 % interval for
    the next test, or for the mean of many, and `tested` marks cases within the tested range.

    Blocks of `block` cases run on all cores; the exact `stop` runs as one compiled loop.
    Raises QuantityError for arrays of mismatched shapes, and for more than 4 GiB without a sink.
    """
    if block < 1:
        raise QuantityError(f"block: {block} cases are not allowed; use 1 or more")
    file_or_name, brake, fixed = brake, _plain_brake(brake), dict(fixed or {})
    sweep = {**sweep, **{n: v for n, v in fixed.items() if _is_number(v) and n not in sweep}}
    fixed = {n: v for n, v in fixed.items() if n not in sweep or not _is_number(v)}
    sweeps = _lay_out_sweeps(law, sweep, fixed, brake)
    sizes = {s.dimension: len(s.values) for s in sweeps if s.dimension}
    total = math.prod(sizes.values())
    run, names, quick = _make_runner(law, sweeps, fixed, brake, block)
    results = tuple(out or names) if wanted is None else tuple(wanted)
    for name in set(results) - {*names}:
        raise UnknownNameError("result of the law", name, names)
    attributes = {}
    if interval is not None:
        spread = BatchSpread(law, file_or_name, sweeps, results, interval == "mean")
        run, results, attributes = spread.extend(run), (*results, *spread.keys), spread.state()
    if sink is None and total * len(results) * 8 > LARGEST:
        raise QuantityError(
            f"batch: {total} cases with {len(results)} results each need "
            f"{total * len(results) * 8 / 1e9:.3g} GB; pass a sink, or request fewer results"
        )
    size = total if sink is None else min(CHUNK, total)
    columns = {n: _flat_array(n, out, size) for n in results}
    first, chunk = 0, CHUNK * (QUICK if quick and sink is None and progress is None else 1)
    with Workers() as pool:
        while first < total:
            count = min(chunk, total - first)
            place = slice(first, first + count) if sink is None else slice(0, count)
            piece = {n: values[place] for n, values in columns.items()}
            pool.share(count, functools.partial(_run_share, run, first, piece))
            if sink is not None:
                sink(first, piece)
            first += count
            if progress is not None:
                progress(first, total)
    if sink is not None:
        return total
    return _label_results(columns, sweeps, sizes, {"law": law.__name__, **attributes})


def _run_share(run: Run, start: int, piece: Mapping[str, Array], first: int, last: int) -> None:
    run(start + first, last - first, {n: values[first:last] for n, values in piece.items()})


def _flat_array(name: str, out: Mapping[str, Array] | None, size: int) -> Array:
    if out is None:
        return np.empty(size)
    array = out[name]
    if array.size != size or array.dtype != np.float64 or not array.flags.c_contiguous:
        raise QuantityError(f"out: {name} must be an array of {size} float64 numbers")
    return array.reshape(-1)


def _plain_brake(brake: Brake | BrakeFile | str) -> Brake:
    if isinstance(brake, str):
        return load(brake).brake
    if isinstance(brake, BrakeFile):
        return brake.brake
    if not isinstance(brake, Brake):
        raise QuantityError(f"brake: a {type(brake).__name__} is not a brake, brake file or name")
    return brake


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _check_row(name: str, data: Any) -> Array:
    """Return values of one quantity; raises QuantityError unless it is a number or a row."""
    if data is None:
        raise QuantityError(f"{name}: None cannot be swept; pass it in fixed")
    try:
        values = np.asarray(data, float)
    except (TypeError, ValueError):
        text = repr(data)
        raise QuantityError(
            f"{name}: {text if len(text) < 60 else text[:57] + '...'} is not a number or a row "
            "of numbers in SI units"
        ) from None
    if values.ndim > 1 or values.size == 0:
        raise QuantityError(f"{name}: has shape {values.shape}; pass a number or a 1-D array")
    return values


def _lay_out_sweeps(
    law: Callable[..., Any], sweep: Mapping[str, Any], constants: Mapping[str, Any], brake: Brake
) -> list[Sweep]:
    """Return every quantity with its stride; raises QuantityError or UnknownNameError."""
    arguments = [n for n in inspect.signature(law).parameters if n != "brake"]
    fields = [f"brake.{path}" for path, _, _ in quantities(type(brake))]
    for name in (*sweep, *constants):
        if name not in arguments and (name not in fields or name in constants):
            raise UnknownNameError("quantity", name, arguments + fields)
        if name in sweep and name in constants:
            raise QuantityError(f"{name}: both swept and fixed; pass it only once")
    for name in arguments:
        if name not in sweep and name not in constants:
            raise QuantityError(f"{name} is missing; the law {law.__name__} requires it")
    lengths: dict[str, int] = {}
    plain: list[tuple[str, str | None, Array]] = []
    for name, data in sweep.items():
        pair = isinstance(data, tuple) and len(data) == 2 and isinstance(data[0], str)
        values = _check_row(name, data[1] if pair else data)
        dimension = (data[0] if pair else name) if values.ndim else None
        if dimension is not None and lengths.setdefault(dimension, len(values)) != len(values):
            raise QuantityError(
                f"{name}: has {len(values)} values, but others on the axis '{dimension}' have "
                f"{lengths[dimension]}"
            )
        plain.append((name, dimension, np.ascontiguousarray(np.atleast_1d(values))))
    strides, stride = {}, 1
    for dimension in reversed(lengths):
        strides[dimension] = stride
        stride *= lengths[dimension]
    return [Sweep(n, d, v, strides[d] if d else 1) for n, d, v in plain]


def _make_runner(
    law: Callable[..., Any],
    sweeps: list[Sweep],
    law_constants: Mapping[str, Any],
    brake: Brake,
    block: int,
) -> tuple[Run, tuple[str, ...], bool]:
    """Return the evaluator of flat cases, its results' names, and whether it is compiled C."""
    constants = loop_constants(brake) if law is stop else None
    of_brake = any(s.name.startswith("brake.") for s in sweeps)
    loop = None if constants is None or law_constants or of_brake else find_stop_loop()
    if loop is not None:
        return _make_compiled_run(loop, np.array(constants), sweeps, brake), Stop._fields, True
    return *_make_traced_run(law, sweeps, law_constants, brake, block), False


def _make_compiled_run(
    loop: Callable[..., int], constants: Array, sweeps: list[Sweep], brake: Brake
) -> Run:
    """Return the evaluator of exact stops by the compiled kernel."""
    by_name = {s.name: s for s in sweeps}
    axes = [by_name[n] for n in inspect.signature(stop).parameters if n != "brake"]
    grid = (
        np.array([axis.values.ctypes.data for axis in axes], np.uintp),
        np.array([len(axis.values) for axis in axes], np.int64),
        np.array([axis.stride for axis in axes], np.int64),
        constants,
    )

    def run(first: int, count: int, out: Mapping[str, Array]) -> None:
        into = [out[n].ctypes.data if n in out else 0 for n in Stop._fields]
        has_missed = np.zeros(count, bool)
        arrays = (*grid, np.array(into, np.uintp), has_missed)
        if loop(first, count, *(array.ctypes.data for array in arrays)):
            # the law itself brackets the few roots that the loop missed
            rows = np.flatnonzero(has_missed)
            stop_result = stop(**{s.name: s.take_cases(first + rows) for s in sweeps}, brake=brake)
            for name, results in out.items():
                results[rows] = np.asarray(getattr(stop_result, name))

    return run


@functools.lru_cache(maxsize=64)
def _compile_blocks(law: Callable[..., Any], names: tuple[str, ...]) -> tuple[Any, Any]:
    """Return the law for one block, and its compiled form for several blocks."""
    order = [n for n in inspect.signature(law).parameters if n != "brake"]

    def evaluate(values: tuple[Any, ...], constants: Mapping[str, Any], brake: Brake) -> Any:
        inputs = {**dict(zip(names, values, strict=True)), **constants}
        for name in names:
            if name.startswith("brake."):
                brake = _replace_field(brake, name.split(".")[1:], inputs[name])
        return law(*(inputs[n] for n in order), brake)

    @compiled
    def evaluate_rows(values: Any, fixed: Mapping[str, Any], brake: Brake) -> Any:
        import jax

        return jax.lax.map(lambda v: evaluate(v, fixed, brake), values)

    return evaluate, evaluate_rows


def _make_traced_run(
    law: Callable[..., Any], sweeps: list[Sweep], fixed: Mapping[str, Any], brake: Brake, block: int
) -> tuple[Run, tuple[str, ...]]:
    from layerjam.brake.mechanics.tracing import in_double_precision, jax

    evaluate, evaluate_block = _compile_blocks(law, tuple(s.name for s in sweeps))
    constants = {n: None if v is None else _check_samples(n, v) for n, v in fixed.items()}

    @in_double_precision
    def result_shape(shape: tuple[int, ...]) -> Any:
        row = tuple(jax.ShapeDtypeStruct(shape, np.float64) for _ in sweeps)
        return jax.eval_shape(evaluate, row, constants, brake)

    try:
        # a single case, because a law that takes samples would mistake a block of cases for samples
        result_shape(())
        # three cases, to distinguish one result per case from samples and from one number
        shape = result_shape((3,))
    except (TypeError, ValueError, IndexError) as err:
        reason = str(err).splitlines()[0][:200]
        raise QuantityError(
            f"batch: the law {law.__name__} does not accept these quantities ({reason}); pass "
            "samples that are the same for every case, or None, in fixed"
        ) from None
    results = shape._asdict() if hasattr(shape, "_asdict") else {law.__name__: shape}
    # results that are not one number per case, such as a memory, are omitted
    fields = tuple(n for n, v in results.items() if getattr(v, "shape", None) == (3,))

    def run(first: int, count: int, out: Mapping[str, Array]) -> None:
        size = min(block, max(count, 1))
        rows = 1 << max(0, math.ceil(math.log2(count / size)))
        # padded with the last case, so that pieces have few different shapes
        cases = np.minimum(np.arange(first, first + rows * size), first + count - 1)
        pieces = tuple(s.take_cases(cases).reshape(rows, size) for s in sweeps)
        answer = evaluate_block(pieces, constants, brake)
        flat = answer._asdict() if hasattr(answer, "_asdict") else {law.__name__: answer}
        for name, values in out.items():
            values[:] = np.asarray(flat[name]).reshape(-1)[:count]

    return run, fields


def _check_samples(name: str, data: Any) -> Array:
    try:
        return np.asarray(data, float)
    except (TypeError, ValueError):
        raise QuantityError(f"{name}: a fixed value must be None or numbers") from None


def _replace_field(record: Any, path: list[str], value: Any) -> Any:
    """Return the record with one field, at any depth, replaced by a traced, unvalidated value."""
    names = {n: getattr(record, n) for n in record.__dataclass_fields__}
    names[path[0]] = value if len(path) == 1 else _replace_field(names[path[0]], path[1:], value)
    new = object.__new__(type(record))
    for name, entry in names.items():
        object.__setattr__(new, name, entry)
    return new


def _label_results(
    columns: Mapping[str, Array],
    sweeps: list[Sweep],
    sizes: Mapping[Any, int],
    facts: Mapping[str, Any],
) -> "xarray.Dataset":
    with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
        import xarray
    shape, axes = tuple(sizes.values()), tuple(sizes)
    fields = {f"brake.{path}": m.unit for path, m, _ in quantities(Brake)}
    coordinates = {
        s.name: (s.dimension, s.values, {"units": _UNITS.get(s.name, fields.get(s.name, ""))})
        for s in sweeps
        if s.dimension
    }
    data = {}
    for name, values in columns.items():
        key = f"{name}_reached" if name in coordinates else name
        quantity = name.removesuffix("_low").removesuffix("_high")
        attributes: dict[str, Any] = {"units": _UNITS.get(quantity, "")}
        if name == "outcome":
            attributes |= {
                "flag_values": np.array([*OUTCOMES, NOT_A_CASE], np.float64),
                "flag_meanings": " ".join([*map(str, OUTCOMES.values()), "NOT_A_CASE"]),
            }
        data[key] = (axes, values.reshape(shape), attributes)
    constants = {s.name: float(s.values[0]) for s in sweeps if not s.dimension}
    return xarray.Dataset(data, coords=coordinates, attrs={**facts, **constants})
