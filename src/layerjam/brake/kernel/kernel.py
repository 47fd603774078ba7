"""The C kernel in Python: moves of a brake, a hundred times faster than `brake_cycle`."""

import contextlib
import ctypes
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.compiler import (
    KERNEL,
    SOURCES,
    STOPS,
    build_library,
    cached_library,
    shipped_library,
)
from layerjam.brake.kernel.parameters import parameters
from layerjam.brake.mechanics.cycle import Cycle
from layerjam.core.errors import CompilerError, QuantityError
from layerjam.core.threads import cache_threadsafe

Precision = Literal["double", "single"]
T = TypeVar("T")
REFUSED, SLACK, SEPARATED, CLOSED, SNAPPED, OVERFLOW = (1 << bit for bit in range(6))
"""Flags of a state, as in `layerjam.h`."""
DEPTH = 16
PARTED = 1e-12
"""Remaining fraction at which the overlap counts as used up, as in `brake_cycle`."""
_REALS: dict[Precision, Any] = {"double": ctypes.c_double, "single": ctypes.c_float}


class _Structures:
    """`lj_brake`, `lj_state` and `lj_row` for one precision, as the C headers declare them."""

    def __init__(self, precision: Precision) -> None:
        self.real = _REALS[precision]
        types = _read_headers(self.real)
        self.brake, self.state = types["lj_brake"], types["lj_state"]
        self.number, self.row = np.dtype(self.real), np.dtype(types["lj_row"])


def _read_headers(real: Any) -> dict[str, Any]:
    """Return {name: type} of the structures that the headers declare."""
    types = {"lj_real": real, "uint32_t": ctypes.c_uint32, "uint8_t": ctypes.c_uint8}
    text = "".join((SOURCES / name).read_text("utf-8") for name in ("layerjam.h", "history.h"))
    lengths = {name: int(number) for name, number in re.findall(r"#define (\w+) (\d+)\n", text)}
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    for body, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.DOTALL):
        fields = []
        for kind, members in re.findall(r"(\w+) ([^;]+);", body):
            for member, length in re.findall(r"(\w+)(?:\[(\w+)\])?", members):
                fields.append((member, types[kind] * lengths[length] if length else types[kind]))
        types[name] = type(name, (ctypes.Structure,), {"_fields_": fields})
    return types


def state_bytes(precision: Precision) -> int:
    """Return the size of `lj_state` [bytes]."""
    return ctypes.sizeof(_Structures(precision).state)


CODE = KERNEL


@cache_threadsafe
def load_library(precision: Precision) -> tuple[Any, _Structures]:
    """Return the library that came with layerjam, or one compiled here, and its structures.

    Raises CompilerError if it cannot be compiled or loaded.
    """
    defines = () if precision == "double" else ("LJ_SINGLE",)
    return _load(CODE, defines, lambda path: bind_library(path, precision))


@cache_threadsafe
def load_stop_loop() -> Callable[..., int]:
    """Return the function `lj_stops`, from a library of its own; errors as in `load_library`."""
    return _load(STOPS, (), _bind_stops)


def _load(sources: Sequence[Path], defines: Sequence[str], bind: Callable[[Path], T]) -> T:
    wheel_library = shipped_library(sources, defines)
    if wheel_library is not None:
        with contextlib.suppress(
            OSError
        ):  # the library may be for a system with a different C library
            return bind(wheel_library)
    path = cached_library(sources, defines) or build_library(sources, defines)
    try:
        return bind(path)
    except OSError as error:
        raise CompilerError(f"the kernel's library cannot be loaded: {error}") from None


def _bind_stops(path: Path) -> Callable[..., int]:
    loop: Any = ctypes.CDLL(str(path)).lj_stops
    loop.argtypes = (ctypes.c_int64, ctypes.c_int64, *(ctypes.c_void_p,) * 6)
    loop.restype = ctypes.c_int64
    return loop


def bind_library(path: Path, precision: Precision) -> tuple[Any, _Structures]:
    """Load a compiled library and declare its functions; return it and its structures."""
    library_, types = ctypes.CDLL(str(path)), _Structures(precision)
    brake, state, real = ctypes.POINTER(types.brake), ctypes.POINTER(types.state), types.real
    address = ctypes.c_void_p
    for name, arguments, answer in (
        ("lj_start", (state, real), None),
        ("lj_move", (brake, state, real, real, real), real),
        ("lj_tangent", (brake, state, real), real),
        ("lj_vacuum_tangent", (brake, state, real), real),
        ("lj_stored", (brake, state), real),
        ("lj_fault", (state,), ctypes.c_char_p),
        ("lj_history", (brake, state, ctypes.c_int64, address, address, address), None),
    ):
        function = getattr(library_, name)
        function.argtypes, function.restype = arguments, answer
    if library_.lj_state_size() != ctypes.sizeof(types.state):
        raise RuntimeError("the compiled lj_state does not match layerjam.h")
    return library_, types


class Kernel:
    """One brake, stepped by the C kernel; it starts at rest without vacuum.

    Raises QuantityError for a brake whose law is not in the kernel (sheets that fan out, a speed
    law, a hyperelastic enclosure), CompilerError if no C compiler is installed.
    """

    def __init__(
        self,
        brake: Brake | BrakeFile,
        *,
        rope_stiffness: float | None = None,
        precision: Precision = "double",
    ) -> None:
        self.parameters = parameters(brake, rope_stiffness)
        self._library, self._made = load_library(precision)
        self._brake = self._made.brake(**self.parameters._asdict())
        self._state: Any = self._made.state()
        self.start()

    def start(self, vacuum: float = 0.0) -> None:
        """Reset the brake to rest under a vacuum [Pa]: no slip, no force, no elongation."""
        self._library.lj_start(self._state, vacuum)

    def move(self, elongation: float, vacuum: float, compliance: float = 0.0) -> float:
        """Apply a vacuum [Pa], then move to an elongation [m]; return the force [N].

        `compliance` [m/N] in series is for solvers; see `layerjam.h`. Raises QuantityError for
        numbers that are not allowed; the state is then unchanged.
        """
        numbers = (elongation, vacuum, compliance)
        force = self._library.lj_move(self._brake, self._state, *numbers)
        if self._state.flags & REFUSED:
            self._state.flags &= ~REFUSED
            _raise_number_error(*numbers)
        return force

    def peek(self, elongation: float, vacuum: float, compliance: float = 0.0) -> float:
        """Return the force [N] that `move` would return; the state is unchanged."""
        copy = self._made.state.from_buffer_copy(self._state)
        force = self._library.lj_move(self._brake, copy, elongation, vacuum, compliance)
        if copy.flags & REFUSED:
            _raise_number_error(elongation, vacuum, compliance)
        return force

    def tangent(self, compliance: float = 0.0) -> float:
        """Return the slope of force versus elongation [N/m] if the last move continues."""
        return self._library.lj_tangent(self._brake, self._state, compliance)

    def vacuum_tangent(self, compliance: float = 0.0) -> float:
        """Return the slope of force versus vacuum [N/Pa] as it falls; a rise causes no slip."""
        return self._library.lj_vacuum_tangent(self._brake, self._state, compliance)

    @property
    def state(self) -> bytes:
        """Complete state of the brake; assign it to restore the state.

        Raises QuantityError for bytes that are not the state of a brake, which is then unchanged.
        """
        return bytes(self._state)

    @state.setter
    def state(self, data: bytes) -> None:
        size = ctypes.sizeof(self._state)
        if len(data) != size:
            raise QuantityError.of("state", f"expected {size} bytes, got {len(data)}")
        state = self._made.state.from_buffer_copy(data)
        if fault := self._library.lj_fault(state):
            raise QuantityError.of("state", f"the bytes are damaged: {fault.decode()}")
        self._state = state

    @property
    def force(self) -> float:
        """Force [N]."""
        return self._state.force

    @property
    def slip(self) -> float:
        """Slip [m]."""
        return self._state.slip

    @property
    def enclosure_force(self) -> float:
        """Force of the enclosure [N]."""
        return self._state.enclosure_force

    @property
    def work(self) -> float:
        """External work done on the brake so far [J]."""
        return self._state.work

    @property
    def heat(self) -> float:
        """Energy dissipated so far [J]."""
        return self._state.heat

    @property
    def stored(self) -> float:
        """Elastic energy [J] in enclosure, sheets, mount and rope."""
        return self._library.lj_stored(self._brake, self._state)

    @property
    def flags(self) -> int:
        """Sum of the flags SLACK, SEPARATED, CLOSED, SNAPPED and OVERFLOW."""
        return self._state.flags

    def cycle(self, elongation: ArrayLike, vacuum: ArrayLike) -> Cycle:
        """Return the `brake_cycle` of an elongation history [m] from rest, as NumPy arrays.

        `vacuum` [Pa] is one number or a history of the same shape. Force is NaN after the brake
        snaps or has too many turns for its memory. Past the end of the overlap the kernel continues
        with the enclosure alone, unlike `brake_cycle`. The kernel's own state is unchanged.
        """
        path, rows = self._run_history(elongation, vacuum)
        flags = rows["flags"]
        void = (flags & (REFUSED | SNAPPED | OVERFLOW) > 0) | (path < 0)
        return self._make_cycle(rows, np.where(void, np.nan, rows["force"]), flags & SEPARATED > 0)

    def exact_cycle(self, elongation: ArrayLike, vacuum: ArrayLike) -> Cycle | None:
        """Return the result of `brake_cycle` to within rounding, or None if the kernel may differ.

        It may differ if the brake snaps, if a number is not allowed, if the nested turns nearly
        fill the memory, or if the sheets separate between two samples. If a sample is at the end of
        the overlap, `separated` is true from there on, and later samples do not count.
        """
        path, rows = self._run_history(elongation, vacuum)
        overlap = self.parameters.overlap
        separated = rows["slip"] >= overlap * (1 - PARTED)
        count = int(np.argmax(separated)) + 1 if separated.any() else len(rows)
        rows_used = rows[:count]
        refused = rows_used["flags"] & (REFUSED | SNAPPED | OVERFLOW) > 0
        unsure = refused | (rows_used["turns"] >= DEPTH - 1) | (path[:count] < 0)
        if unsure.any() or rows_used["slip"][-1] > overlap * (1 + PARTED):
            return None
        return self._make_cycle(rows, rows["force"], np.logical_or.accumulate(separated))

    def _make_cycle(
        self, rows: NDArray[Any], force: NDArray[Any], is_separated: NDArray[Any]
    ) -> Cycle:
        flags = rows["flags"]
        return Cycle(
            force=force,
            slip=rows["slip"],
            sleeve_force=rows["enclosure_force"],
            work=rows["work"],
            heat=rows["heat"],
            stored=rows["stored"],
            slack=flags & SLACK > 0,
            closed=flags & CLOSED > 0,
            separated=is_separated,
            overflow=flags & OVERFLOW > 0,
            snapped=flags & SNAPPED > 0,
        )

    def _run_history(self, elongation: ArrayLike, vacuum: ArrayLike) -> tuple[Any, NDArray[Any]]:
        number = self._made.number
        path = np.ascontiguousarray(np.atleast_1d(np.asarray(elongation, number)))
        pressure = np.ascontiguousarray(np.broadcast_to(np.asarray(vacuum, number), path.shape))
        rows, state = np.empty(path.shape, self._made.row), self._made.state()
        self._library.lj_start(state, max(float(pressure[0]), 0.0) if path.size else 0.0)
        places = (array.ctypes.data for array in (path, pressure, rows))
        self._library.lj_history(self._brake, state, path.size, *places)
        return path, rows


def _raise_number_error(elongation: float, vacuum: float, compliance: float) -> None:
    """Raise QuantityError for the first number that the kernel rejects."""
    numbers = {"elongation": (elongation, "m"), "vacuum": (vacuum, "Pa")}
    numbers["compliance"] = (compliance, "m/N")
    for name, (value, unit) in numbers.items():
        if not np.isfinite(value):
            raise QuantityError.of(name, f"{value} is not a finite number")
        if name != "elongation" and value < 0:
            raise QuantityError.of(name, f"{value:g} {unit} is not allowed; use zero or more")
    raise QuantityError("elongation, vacuum or compliance is implausibly large")
