"""Stacks in C: the bits of the Python loops, the numbers of the former numba loops, interrupts."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from c_printers import loop_printer
from counts import cases
from independent.random_stacks import COUNT, make_case, summarise_pull
from layerjam.brake.kernel import stack as stacks
from layerjam.brake.kernel.compiler import SOURCES, find_on_path
from layerjam.brake.kernel.engine import SWITCH
from layerjam.brake.kernel.stack import find_peaks, pull_stack
from layerjam.brake.mechanics.stack.history import StackPull
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import make_stack
from layerjam.core.errors import LayerjamError, QuantityError
from strategies import KAPTON

COMPILER = pytest.mark.skipif(find_on_path() is None, reason="there is no C compiler here")
HERE = Path(__file__).parent
REFERENCE = HERE / "random_stacks.npz"
"""Results of `make_case`, by the loops as numba compiled them until 28 November 2026."""
NAMES = ("peak", "elongation", "slip", "stiffness", "onset")
END = 0.12


def follow(seed: int) -> tuple[StackPull | None, np.ndarray]:
    """The pull of a random stack, None if it cannot be followed, and the peak of another one."""
    fields, path, friction = make_case(seed)
    stack = Stack(**fields)
    peaks = find_peaks(stack, friction[None], stack.length[None], END)
    found = np.array([getattr(peaks, name)[0] for name in NAMES])
    try:
        pull = pull_stack(path, stack)
    except LayerjamError:
        return None, found
    return (pull if len(pull.force) else None), found


@contextmanager
def in_python() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "off")
        yield


# --- the same numbers


def check_reference(seeds: range) -> None:
    """Every number agrees with numba's to 1e-12, as a share of itself or of the peak force."""
    with np.load(REFERENCE) as kept:
        pulls, peaks = kept["pulls"], kept["peaks"]
    for seed in seeds:
        pull, found = follow(seed)
        assert found == pytest.approx(peaks[seed], rel=1e-12, nan_ok=True), seed
        assert (pull is None) == np.isnan(pulls[seed, 0]), seed
        if pull is not None:
            assert summarise_pull(pull) == pytest.approx(pulls[seed], rel=1e-12, abs=1e-15), seed


@COMPILER
def test_a_hundred_stacks_are_those_of_numba() -> None:
    check_reference(range(100))


@COMPILER
@pytest.mark.slow
def test_many_stacks_are_those_of_numba() -> None:
    check_reference(range(100, cases(COUNT, 300)))


@COMPILER
def test_python_and_c_compute_the_same_bits() -> None:
    seeds = (22, 23, 24, 25, 27, 28, 29, 30)  # which Python computes in seconds
    compiled = [follow(seed) for seed in seeds]
    with in_python():
        plain = [follow(seed) for seed in seeds]
    for seed, (fast, found), (slow, same) in zip(seeds, compiled, plain, strict=True):
        np.testing.assert_array_equal(found, same, err_msg=str(seed))
        assert (fast is None) == (slow is None)
        for one, two in zip(fast or (), slow or (), strict=True):
            np.testing.assert_array_equal(one, two, err_msg=str(seed))


@COMPILER
def test_friction_that_is_renewed_is_the_same_in_python() -> None:
    """The arrays of the stack change between the increments, as for sheets that fan out."""

    def renew(slip: np.ndarray, stack: Stack) -> bool:
        stack.friction[:] = 10 / (1 + 100 * np.abs(slip))
        return bool(np.abs(slip).max() < 5e-3)

    fields, _, _ = make_case(3)
    path = np.linspace(0, 0.02, 60)
    fast = pull_stack(path, Stack(**fields), renew=renew)
    with in_python():
        slow = pull_stack(path, Stack(**make_case(3)[0]), renew=renew)
    assert 0 < len(fast.force) < 60
    for one, two in zip(fast, slow, strict=True):
        np.testing.assert_array_equal(one, two)


def test_arrays_of_other_types_and_orders_are_taken() -> None:
    fields, path, _ = make_case(5)
    whole = {**fields, "springs": np.round(fields["springs"])}
    other = {
        **whole,
        "springs": whole["springs"].astype(int),
        "right": whole["right"].astype(int),
        "friction": np.repeat(whole["friction"], 2)[::2],
        "ends": list(whole["ends"]),
    }
    one, two = pull_stack(path, Stack(**whole)), pull_stack(list(path), Stack(**other))
    np.testing.assert_array_equal(one.force, two.force)
    with pytest.raises(QuantityError, match="numbers for each stack"):
        find_peaks(Stack(**fields), fields["friction"][None], np.ones((1, 2)), END)


# --- without the kernel


RUN = """
import numpy as np
from layerjam.brake.kernel.stack import find_peaks, pull_stack
from layerjam.brake.mechanics.stack.solve import Stack
ones = np.ones(2)
stack = Stack(np.full(3, 3e5), np.array([0, 1, 0]), 5 * ones, ones, ones, np.inf, [0, 2], [0, 0, 1])
print(pull_stack(np.linspace(0, 1e-3, 5), stack).force)
print(find_peaks(stack, stack.friction[None], stack.length[None], 0.1).peak)
"""


def run(home: Path, **environment: str) -> tuple[str, str]:
    """Output and messages of two pulls in a process with an empty cache."""
    env = {k: v for k, v in os.environ.items() if k not in ("CC", SWITCH)}
    env |= {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "XDG_CACHE_HOME": str(home)}
    done = subprocess.run(
        [sys.executable, "-c", RUN], env=env | environment, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@COMPILER
def test_one_line_names_the_reason_and_the_remedy(tmp_path: Path) -> None:
    said, messages = run(tmp_path)
    assert messages == ""
    (tmp_path / "empty").mkdir()
    nothing = {"PATH": str(tmp_path / "empty"), "XDG_CACHE_HOME": str(tmp_path / "none")}
    for environment, reason in (
        (nothing, "no C compiler found: install gcc or clang"),
        ({SWITCH: "off"}, "LAYERJAM_KERNEL=off; unset it"),
        ({"CC": "false", "XDG_CACHE_HOME": str(tmp_path / "none")}, "false cannot build"),
    ):
        same, messages = run(tmp_path, **environment)
        if "ziglang" in messages:
            continue  # it compiled
        assert same == said
        assert messages.count("\n") == 1 and reason in messages, messages
        assert messages.startswith("layerjam: the sheet-by-sheet model runs in Python")


# --- interrupts


@pytest.mark.timing
@pytest.mark.skipif(os.name == "nt", reason="no signal reaches a chosen thread")
@pytest.mark.parametrize("slow", [False, True], ids=["compiled", "python"])
def test_ctrl_c_ends_a_batch_after_the_blocks_that_have_begun(slow: bool) -> None:
    """Each of two threads runs at most one block after the order to stop, of hundreds left."""
    stack = make_stack(KAPTON, 94.5e3, static=True)
    friction = np.tile(stack.friction, (200_000, 1))
    length, main = np.broadcast_to(stack.length, friction.shape), threading.main_thread().ident
    begun: list[int] = []
    at_stop: list[int] = []
    run_block = stacks.Loop.__call__

    class Stop(threading.Event):
        def set(self) -> None:
            super().set()
            at_stop.append(len(begun))

    def count(loop: stacks.Loop, first: int, last: int) -> object:
        begun.append(first)
        if len(begun) == 3:
            signal.pthread_kill(main or 0, signal.SIGINT)
        return run_block(loop, first, last)

    before = set(threading.enumerate())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "off" if slow else "")
        patch.setattr("layerjam.core.threads.core_count", lambda: 2)
        patch.setattr(stacks, "threading", SimpleNamespace(Event=Stop))
        patch.setattr(stacks.Loop, "__call__", count)
        with pytest.raises(KeyboardInterrupt):
            find_peaks(stack, friction, length, END)
    assert len(at_stop) == 1 and len(begun) - at_stop[0] <= 2
    for thread in set(threading.enumerate()) - before:
        if thread.name.startswith("ThreadPoolExecutor"):  # it ends once its block is computed
            thread.join(60)
            assert not thread.is_alive()


# --- the printer


def test_the_loops_in_c_are_those_of_python() -> None:
    """`python tests/print_c.py` writes them anew."""
    for file in loop_printer.MODULES:
        kept = (SOURCES / file).read_text("utf-8")
        assert kept == loop_printer.format_loops(file)


def print_function(text: str) -> str:
    module = ModuleType("loops")
    exec(compile(text, "loops", "exec"), module.__dict__)
    printer = loop_printer.Printer()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop_printer.inspect, "getsource", lambda _: text)
        return "\n".join(printer.print_module(module))


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("a, b = b, a\n    return a", "order"),
        ("with b: pass", "cannot be printed"),
        ("return [a][0]", "cannot be printed"),
        ("return sum(a)", "'sum' is not a loop"),
        ("return a // b", "cannot be printed"),
        ("return 0 < a < b", "cannot be printed"),
    ],
)
def test_what_cannot_be_printed_is_refused(body: str, reason: str) -> None:
    with pytest.raises(TypeError, match=reason):
        print_function(f'def f(a: float, b: float) -> float:\n    """Do."""\n    {body}\n')


def test_the_order_of_operations_stays() -> None:
    body = "return a - (b - a) / (a * b) if a > b or a < 1 and not b == 2 else -(a + b) * 2"
    text = print_function(f'def f(a: float, b: float) -> float:\n    """Do."""\n    {body}\n')
    said = "a > b || (a < 1 && !(b == 2)) ? a - (b - a) / (a * b) : -(a + b) * 2"
    assert f"return {said};" in text
    ast.parse(body.removeprefix("return "))


def test_whole_numbers_are_divided_as_python_divides_them() -> None:
    text = print_function('def f(a: int) -> float:\n    """Do."""\n    b = a / 2\n    return b\n')
    assert "b = (double)a / 2;" in text and "double b;" in text


def test_records_have_the_members_that_c_declares() -> None:
    """Members follow each other in the order of the header, and the count of sheets is last."""
    header = (SOURCES / "stack_loops.h").read_text("utf-8")
    body = header.split("} Stack;")[0].rsplit("typedef struct {", 1)[1]
    names = [line.split()[-1].strip("*;") for line in body.strip().splitlines()]
    made = stacks._make_structure(stacks.check_stack(Stack(**make_case(0)[0])))
    assert names == [name for name, *_ in made._fields_]
