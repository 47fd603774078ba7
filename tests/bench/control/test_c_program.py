"""The printed loops: up to date, without warnings, and the bits of earlier versions."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from bench.control import random_loops
from bench.control.random_loops import COUNT, NUMBERS, digest, draw_loop, libm_digest, run_loop
from c_printers.c_program import format_loops
from layerjam.bench.control import engine
from layerjam.bench.control.detection import detection_times
from layerjam.brake.kernel import compiler, library
from layerjam.brake.kernel.compiler import LOOPS, find_on_path
from layerjam.brake.kernel.library import SWITCH
from layerjam.core.installation import install_command

FIXTURE: dict[str, Any] = json.loads(random_loops.FILE.read_text("utf-8"))
SAME_LIBM = FIXTURE["libm"] == libm_digest()
"""Whether exp, expm1, log and pow here have the bits of the machine that wrote the fixture."""


@pytest.fixture
def in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """The loops run in Python, as on a machine without a library."""
    monkeypatch.setattr(engine, "_load_library", lambda: None)


def check_run(number: int) -> None:
    run = run_loop(number)
    if SAME_LIBM:
        assert digest(run) == FIXTURE["digests"][number]
    made = [float(getattr(run, name)) for name in NUMBERS]
    assert made == pytest.approx(FIXTURE["runs"][number], rel=1e-6, abs=1e-6, nan_ok=True)


def test_the_file_is_what_the_sources_print() -> None:
    """`python tests/print_c.py` rewrites it."""
    assert LOOPS[0].read_text("utf-8") == format_loops()


@pytest.mark.skipif(find_on_path() is None, reason="there is no C compiler here")
def test_it_compiles_without_a_warning(tmp_path: Path) -> None:
    command = [*(find_on_path() or ()), *compiler.FLAGS, "-Wall", "-Wextra", "-Werror", "-pedantic"]
    subprocess.run([*command, "-c", str(LOOPS[0]), "-o", str(tmp_path / "loops.o")], check=True)


@pytest.mark.parametrize("number", range(COUNT))
def test_random_loops_keep_their_bits(number: int) -> None:
    """A third with a tube; the fixture was written by the loops that numba compiled."""
    check_run(number)


@pytest.mark.usefixtures("in_python")
def test_python_runs_the_same_loops() -> None:
    for number in range(0, COUNT, 4):
        check_run(number)


@pytest.mark.parametrize("row", range(COUNT // 8))
def test_detection_times_stay_the_same(row: int) -> None:
    """To rounding: NumPy's own exp and log have other last bits on other processors."""
    loop, options = draw_loop(8 * row)
    times = detection_times(loop, options["targets"][0][1])
    assert times == pytest.approx(FIXTURE["times"][row], rel=1e-12 if SAME_LIBM else 1e-6)


@pytest.mark.usefixtures("in_python")
def test_python_runs_the_same_trials() -> None:
    loop, options = draw_loop(8)
    times = detection_times(loop, options["targets"][0][1])
    assert times == pytest.approx(FIXTURE["times"][1], rel=1e-6)
    assert math.isfinite(times["NO_VACUUM"])


def test_without_a_compiler_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv(SWITCH, raising=False)
    monkeypatch.setattr(compiler, "SHIPPED", tmp_path)
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(engine, "_load_library", engine._load_library.__wrapped__)
    monkeypatch.setattr(library, "_open_once", library.open_library)
    assert shutil.which("cc") is None
    check_run(0)
    assert capsys.readouterr().err == (
        "layerjam: the controller's closed loops run in Python, many times slower than in C: no C "
        f"compiler found: install gcc or clang, or {install_command('fmu')}\n"
    )


def test_the_switch_turns_c_off(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(SWITCH, "off")
    monkeypatch.setattr(engine, "_load_library", engine._load_library.__wrapped__)
    check_run(1)
    assert f"{SWITCH}=off; unset it" in capsys.readouterr().err
