"""Pulls of stacks, sheet by sheet: by the compiled kernel, or by the same loops in Python."""

import ctypes
import functools
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.kernel.compiler import STACK
from layerjam.brake.kernel.library import open_library_if_possible
from layerjam.brake.mechanics.stack.enclosure import CHATTER, DEPTH, DONE, OVERFLOW, SNAPPED, Faces
from layerjam.brake.mechanics.stack.history import StackPull, follow_path
from layerjam.brake.mechanics.stack.lasso import Array, Knots
from layerjam.brake.mechanics.stack.peaks import MAX_STEPS, RESULTS, Curve, follow_peaks
from layerjam.brake.mechanics.stack.solve import VALUES, Stack, State, Trial
from layerjam.core.errors import LayerjamError, ProcedureError, QuantityError
from layerjam.core.threads import Workers

BLOCK, PYTHON_BLOCK = 200_000, 200
"""Number of sheets times increments between two progress reports, and without the kernel."""
STACKS, PYTHON_STACKS = 2000, 10
"""Number of sheets times stacks that a thread pulls before it can be interrupted."""


@dataclass(frozen=True)
class Peaks:
    """Results of M stacks; arrays of shape (M,).

    NaN if a mount was too soft, or if static friction broke and recovered endlessly.
    """

    peak: Array = field(repr=False)
    """Largest force of each pull [N]."""
    elongation: Array = field(repr=False)
    """Elongation at that force [m]."""
    slip: Array = field(repr=False)
    """Mean slip of the interfaces at that force [m]."""
    stiffness: Array = field(repr=False)
    """Secant stiffness between 1/5 and 4/5 of that force [N/m], as used in a calibration."""
    onset: Array = field(repr=False)
    """Force at which the first interface slips [N]."""


_INTEGER, _NUMBER, _ADDRESS = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
_SIGNATURES: dict[str, tuple[Any, Any]] = {
    "lj_follow_path": ((_INTEGER, _INTEGER, *(_ADDRESS,) * 6), _INTEGER),
    "lj_follow_peaks": ((_INTEGER, _INTEGER, _NUMBER, _NUMBER, *(_ADDRESS,) * 9), None),
}
"""{function: (types of the arguments, type of the result)}."""


def find_loop(name: str) -> Callable[..., Any] | None:
    """Return a function of the compiled loops, or None with one line on stderr that says why.

    Raises QuantityError for an unknown value of LAYERJAM_KERNEL.
    """
    library = open_library_if_possible(STACK, "the sheet-by-sheet model runs")
    if library is None:
        return None
    function = getattr(library, name)
    function.argtypes, function.restype = _SIGNATURES[name]
    return function  # type: ignore[no-any-return]


class Loop:
    """A loop over a range of cases with fixed arguments, compiled if the kernel is available."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self.function, self.arguments = function, arguments
        self.c_function = find_loop(f"lj_{function.__name__}")
        if self.c_function is not None:
            self.c_arguments = [_pass_argument(argument) for argument in arguments]

    def __call__(self, first: int, last: int) -> Any:
        """Run the cases `first` to before `last`."""
        if self.c_function is not None:
            return self.c_function(first, last, *self.c_arguments)
        with np.errstate(all="ignore"):  # divisions by zero are infinite, as in C
            return self.function(first, last, *self.arguments)


def _pass_argument(value: Any) -> Any:
    """Return an argument for C: an array or a record by address, a number as it is."""
    if isinstance(value, np.ndarray):
        return value.ctypes.data
    return ctypes.byref(_make_structure(value)) if isinstance(value, tuple) else value


def _make_structure(record: Any) -> ctypes.Structure:
    """Return a record as `c/stack_loops.h` declares it: its fields, then its properties."""
    kind: Any = type(record)
    properties = [getattr(record, name) for name in _list_properties(kind)]
    values = [_make_structure(v) if isinstance(v, tuple) else v for v in (*record, *properties)]
    kinds = tuple(_C_TYPES.get(type(value), type(value)) for value in values)
    numbers = (v.ctypes.data if isinstance(v, np.ndarray) else v for v in values)
    return _make_type(kind, kinds)(*numbers)


_C_TYPES: dict[type, Any] = {
    np.ndarray: ctypes.c_void_p,
    float: ctypes.c_double,
    int: ctypes.c_int64,
    bool: ctypes.c_int64,
}


@functools.cache
def _list_properties(record: Any) -> list[str]:
    return [name for name, member in vars(record).items() if isinstance(member, property)]


@functools.cache
def _make_type(record: Any, kinds: tuple[Any, ...]) -> type[ctypes.Structure]:
    fields = list(zip((*record._fields, *_list_properties(record)), kinds, strict=True))
    return type(record.__name__, (ctypes.Structure,), {"_fields_": fields})


def rest_state(n: int) -> State:
    """Return the state of a stack of n sheets at rest."""
    counts, heading = np.zeros(2, np.int64), np.ones(2, np.int64)
    turns = np.zeros((2, DEPTH)), np.zeros((2, DEPTH))
    return State(
        past=np.zeros(n - 1),
        slides=np.zeros(n - 1, np.int64),
        moving=np.zeros(n - 1, np.bool_),
        sheets=np.zeros(n),
        interface=np.zeros(n - 1),
        values=np.zeros(VALUES),
        faces=Faces(*turns, counts, heading, np.zeros(2), np.zeros(2), np.zeros(2)),
    )


def make_knots(n: int) -> Knots:
    """Return work arrays of `fused_lasso` for n sheets."""
    return Knots(np.zeros(2 * n), np.zeros(2 * n), np.zeros(2 * n), np.zeros(n), np.zeros(n))


def _make_trial(n: int) -> Trial:
    """Return work arrays for the increments of n sheets."""
    sizes = {"slides": n - 1, "force": n - 1, "slip": n - 1, "bound": n - 1, "marks": n - 1}
    sizes |= {"push": 2, "pull": 2, "values": 2}
    kinds: dict[str, Any] = {"slides": np.int64, "group": np.int64, "marks": np.bool_}
    arrays: dict[str, Any] = {
        name: np.zeros(sizes.get(name, n), kinds.get(name, np.float64)) for name in Trial._fields
    }
    return Trial(**{**arrays, "terms": np.zeros((n, 4)), "knots": make_knots(n)})


def check_stack(stack: Stack) -> Stack:
    """Return the stack with arrays as the loops need them.

    Raises QuantityError for arrays that do not fit together, or numbers that are not allowed.
    """
    kinds = {"right": np.bool_, "ends": np.int64}
    stack = stack._replace(
        mount=float(stack.mount),
        one_by_one=bool(stack.one_by_one),
        **{
            name: np.ascontiguousarray(value, kinds.get(name, np.float64))
            for name, value in stack._asdict().items()
            if name not in ("mount", "one_by_one")
        },
    )
    n = stack.sheet_count
    rows = (stack.friction, stack.ratio, stack.length)
    if n < 2 or len(stack.right) != n or any(len(a) != n - 1 for a in rows):
        raise QuantityError(f"stack: {n} sheets need {n - 1} interfaces, at least one")
    if stack.face.shape != (3,) or stack.ends.shape != (2,):
        raise QuantityError("stack: face needs three numbers, and ends two")
    if not 0 <= stack.ends[0] < stack.ends[1] < n:
        raise QuantityError(f"stack: ends {stack.ends} are not two of {n} sheets in their order")
    numbers = (stack.springs, stack.friction, stack.ratio, stack.face)
    if not all(np.isfinite(a).all() for a in numbers) or np.isnan(stack.length).any():
        raise QuantityError("stack: only lengths may be infinite, and every number must be known")
    if not ((stack.friction >= 0).all() and (stack.ratio >= 1).all()):
        raise QuantityError("stack: friction is negative, or static friction is below kinetic")
    if not ((stack.springs > 0).all() and stack.mount > 0):
        raise QuantityError("stack: springs and mount must be above 0 N/m")
    return stack


def pull_stack(
    path: Array,
    stack: Stack,
    progress: Callable[[float], None] | None = None,
    renew: Callable[[Array, Stack], bool] | None = None,
) -> StackPull:
    """Move the crosshead along `path` [m], shape (N,), from rest; it may turn.

    The motion is for tension only: if the crosshead would have to push, the brake rests without
    load, its force is zero, and `slack` is set until the crosshead returns. Buckling of single
    sheets is not checked. The arrays end when no interface overlaps any more, or before the mount
    is too soft to continue. The length of an increment has no effect while interfaces rest or slide
    in one direction. If they reverse within an increment, the heat is that of its net slip.

    `renew` is called before each increment with the slip of the interfaces [m], shape (n - 1,), and
    may change the friction in the stack's arrays; False ends the pull. `progress` is called with
    the completed fraction (0 to 1). Raises QuantityError for numbers that are not allowed, and for
    arrays that do not fit together. Raises ProcedureError for more nested turns than can be stored.
    """
    stack, path = check_stack(stack), np.ascontiguousarray(path, float)
    if not np.isfinite(path).all():
        raise QuantityError.of("path", "every elongation must be a finite number")
    n, count = stack.sheet_count, len(path)
    widths = {"sheets": n, "faces": 2, **dict.fromkeys(("interface", "slip", "sliding"), n - 1)}
    tracks: dict[str, Any] = {
        name: np.zeros(
            (count, widths[name]) if name in widths else count,
            bool if name in ("sliding", "slack") else float,
        )
        for name in StackPull._fields[:-1]
    }
    motion = StackPull(**tracks, snapped=False)
    state, codes = rest_state(n), np.zeros(1, np.int64)
    flat_motion = StackPull._make([*(track.reshape(-1) for track in motion[:-1]), False])
    follow = Loop(follow_path, path, stack, state, _make_trial(n), flat_motion, codes)
    report_every = max(1, (BLOCK if follow.c_function else PYTHON_BLOCK) // n)
    block, first = 1 if renew else report_every, 0
    while first < count and codes[0] == DONE:
        if renew and not renew(np.where(stack.right[:-1], -state.past, state.past), stack):
            break
        last = min(first + block, count)
        first = follow(first, last)
        if progress and (first % report_every == 0 or not renew):
            progress(1.0 if first < last else first / count)
        if first < last:
            break
    _check_code(codes[0], path, first)
    is_snapped = bool(codes[0] == SNAPPED)
    return StackPull._make([*(track[:first] for track in motion[:-1]), is_snapped])


def _check_code(code: int, path: Array, point: int) -> None:
    """Raise the error of an increment to `path[point]` that has no result."""
    if code == OVERFLOW:
        raise ProcedureError(
            f"procedure: more than {DEPTH} nested reversals; the enclosure's memory "
            "cannot store more"
        )
    if code == CHATTER:
        raise LayerjamError(
            f"stack: static friction breaks and recovers endlessly near {path[point]:.6g} "
            "m; use smaller increments or kinetic friction only"
        )
    if code not in (DONE, SNAPPED):
        raise LayerjamError(
            f"stack: no equilibrium was found at an elongation of {path[point]:.6g} m; please "
            "report this brake"
        )


def find_peaks(stack: Stack, friction: Array, length: Array, end: float) -> Peaks:
    """Pull stacks from rest to their peak, at most to the elongation `end` [m].

    They are identical to `stack` except for `friction` [N] and `length` [m], shape (M, n - 1).
    Breaks of static friction are located exactly. Otherwise the peak is found by increments: COARSE
    of them up to the sum of all friction, then LEVELS x PARTS around the largest. Each stack is
    independent of the others, so neither their number nor the threads change its result.
    """
    stack = check_stack(stack)
    n, shape = stack.sheet_count, (len(friction), stack.sheet_count - 1)
    friction, length = (np.ascontiguousarray(a, float) for a in (friction, length))
    if not friction.shape == length.shape == shape:
        raise QuantityError(f"stack: friction and length need {shape[1]} numbers for each stack")
    out = np.full((len(friction), RESULTS), np.nan)
    max_compliance = 4 / float(stack.springs.sum()) + 1 / stack.mount
    probe = 0.01 * float(stack.friction.sum()) * max_compliance
    stop_event = threading.Event()

    def pull_share(first: int, last: int) -> None:
        copy = stack._replace(friction=stack.friction.copy(), length=stack.length.copy())
        states, track = (rest_state(n) for _ in range(3)), np.zeros((2, MAX_STEPS + 2))
        rows = (friction.reshape(-1), length.reshape(-1))
        work = (_make_trial(n), Curve(*track), out.reshape(-1))
        follow = Loop(follow_peaks, probe, float(end), *rows, copy, *states, *work)
        block = max(1, (STACKS if follow.c_function else PYTHON_STACKS) // n)
        for start in range(first, last, block):
            if stop_event.is_set():
                break
            follow(start, min(start + block, last))

    with Workers() as pool:
        try:
            pool.share(len(out), pull_share)
        except KeyboardInterrupt:
            stop_event.set()
            raise
    return Peaks(*out.T)
