"""The loops of the controller in C, or in Python if there is no compiled library."""

import ctypes
from array import array
from collections.abc import Sequence
from typing import Any

from layerjam.bench.control import closed_loop_run, trial
from layerjam.bench.control.closed_loop_run import Array, Chain, Course
from layerjam.bench.control.exact import Rates
from layerjam.bench.control.noise import LAYERS, Layers, Word
from layerjam.brake.kernel.compiler import LOOPS
from layerjam.brake.kernel.library import open_library_if_possible
from layerjam.core.threads import cache_threadsafe

_KINDS: dict[Any, Any] = {
    float: ctypes.c_double,
    int: ctypes.c_int64,
    Sequence[float]: ctypes.POINTER(ctypes.c_double),
    Sequence[int]: ctypes.POINTER(ctypes.c_int64),
}
"""{type of a field in Python: type in C}, as `tests/c_printers` prints them."""


def _make_structure(record: Any) -> Any:
    fields = [(name, _KINDS[kind]) for name, kind in record.__annotations__.items()]
    return type(record.__name__, (ctypes.Structure,), {"_fields_": fields})


_RATES, _CHAIN, _COURSE, _LAYERS = map(_make_structure, (Rates, Chain, Course, Layers))


def run_loop(
    key: Word,
    settings: tuple[tuple[float, ...], tuple[float, ...]],
    plants: tuple[Rates, Rates],
    chains: tuple[Chain, Chain],
    course: Course,
    out: Array,
    history: Array,
) -> None:
    """Call `closed_loop_run.run_loop`; `history` has a row for each sample, or no row."""
    library, rows = _load_library(), len(history)
    if library is None:
        flat_history = history.reshape(-1)
        closed_loop_run.run_loop(
            key, settings, plants, chains, course, LAYERS, out, rows, flat_history
        )
        return
    library.lj_run_loop(
        key, _pack_numbers(*settings[0], *settings[1]), _pack_records(_RATES, plants),
        _pack_records(_CHAIN, chains), _pack_record(_COURSE, course), _pack_layers(),
        out.ctypes.data, rows, history.ctypes.data,
    )  # fmt: skip


def run_trial(
    plant: Rates,
    watch: tuple[float, ...],
    memory: tuple[float, ...],
    vacuums: tuple[float, float, float],
    course: tuple[float, float, int],
    offset: float,
) -> tuple[float, float]:
    """Call `trial.run_trial`; `course` is the sample [s], the lag [s] and the number of samples."""
    library = _load_library()
    if library is None:
        return trial.run_trial(plant, watch, memory, *vacuums, *course, offset)
    rates, settings, state, out = (array("d", row) for row in (plant, watch, memory, (0.0, 0.0)))
    library.lj_run_trial(
        *map(_get_address, (rates, settings, state)), *vacuums, *course, offset, _get_address(out)
    )
    return out[0], out[1]


def _get_address(numbers: "array[float]") -> int:
    return numbers.buffer_info()[0]


@cache_threadsafe
def _load_library() -> Any:
    library = open_library_if_possible(LOOPS, "the controller's closed loops run")
    if library is not None:
        real, integer, address = ctypes.c_double, ctypes.c_int64, ctypes.c_void_p
        key, rates = ctypes.c_uint64, ctypes.POINTER(_RATES)
        numbers = ctypes.POINTER(real)
        chains, course, layers = map(ctypes.POINTER, (_CHAIN, _COURSE, _LAYERS))
        library.lj_run_loop.argtypes = (
            key, numbers, rates, chains, course, layers, address, integer, address,
        )  # fmt: skip
        library.lj_run_trial.argtypes = (
            *(address,) * 3, *(real,) * 5, integer, real, address,
        )  # fmt: skip
        library.lj_run_loop.restype = library.lj_run_trial.restype = None
    return library


def _pack_numbers(*numbers: float) -> Any:
    return (ctypes.c_double * len(numbers))(*numbers)


def _pack_records(structure: Any, records: Sequence[Any]) -> Any:
    return (structure * len(records))(*(structure(*record) for record in records))


def _pack_record(structure: Any, record: Any) -> Any:
    """Return a record in C, with its sequences."""
    values = []
    for value, (_, kind) in zip(record, structure._fields_, strict=True):
        is_sequence = isinstance(value, Sequence)
        values.append((kind._type_ * len(value))(*value) if is_sequence else value)
    return structure(*values)


@cache_threadsafe
def _pack_layers() -> Any:
    return _pack_record(_LAYERS, LAYERS)
