"""When Ctrl-C stops a command, and when its whole result is already appearing."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from layerjam.bench.rig.stop import Stop
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.compiler import run_compiler
from layerjam.brake.mechanics.compilation import announce_compilation
from layerjam.cli import demo
from layerjam.cli.interrupts import _raise_interrupt
from layerjam.core.drawing.folder import write_folder
from layerjam.core.store import Appearing, store_file
from layerjam.core.threads import Workers

from .conftest import Run


@pytest.fixture
def handler(tmp_path: Path) -> Iterator[None]:
    """Our handler of interrupts, as during a command whose output file is `made.toml`."""
    before = signal.signal(signal.SIGINT, _raise_interrupt)
    Appearing.reset([tmp_path / "made.toml"])
    yield
    Appearing.reset()
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("handler")
def test_an_interrupt_is_ignored_while_a_whole_folder_appears(tmp_path: Path) -> None:
    write_folder(tmp_path / "report", {"report.html": "<p>", "figures/one.svg": b"<svg/>"})
    signal.raise_signal(signal.SIGINT)
    assert len(list((tmp_path / "report").rglob("*.*"))) == 2


@pytest.mark.usefixtures("handler")
def test_an_interrupt_is_too_late_once_the_file_of_the_result_appears(tmp_path: Path) -> None:
    def fill(path: Path) -> None:
        path.write_text("whole", encoding="utf-8")
        with pytest.raises(KeyboardInterrupt):  # a library that drops the exception
            signal.raise_signal(signal.SIGINT)

    store_file(tmp_path / "sidecar.toml", "part of a longer command")
    with pytest.raises(KeyboardInterrupt):
        store_file(tmp_path / "made.toml", fill)
    assert [path.name for path in tmp_path.iterdir()] == ["sidecar.toml"]
    Appearing.reset([tmp_path / "made.toml"])
    store_file(tmp_path / "made.toml", "whole")
    signal.raise_signal(signal.SIGINT)
    assert (tmp_path / "made.toml").read_text("utf-8") == "whole"


@pytest.mark.usefixtures("handler")
def test_a_dropped_interrupt_leaves_no_folder(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        write_folder(tmp_path / "report", {"report.html": "<p>"})
    assert not list(tmp_path.iterdir())


def test_a_command_that_drops_an_interrupt_ends_with_130(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lose(*_: object) -> list[object]:
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        return []

    monkeypatch.setattr(BrakeFile, "warnings", lose)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        ran = run("show", "choi2018-kapton")
    finally:
        signal.signal(signal.SIGINT, before)
    assert (ran.code, ran.out, ran.err) == (130, "", "layerjam: stopped\n")


def test_an_interrupted_step_of_the_demo_ends_the_demo(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo, "layerjam", lambda words: 130)
    steps = demo._Steps(tmp_path / "log.txt")
    with pytest.raises(KeyboardInterrupt):
        steps.run_step("calibrate", "calibrate")


def test_a_run_of_the_demos_bench_that_a_signal_stops_ends_the_demo(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`bench run` ends with exit code 1 and a closed file, which is not an error of the demo."""
    monkeypatch.setattr(Stop, "signalled", False)

    def run(_: object) -> int:
        with Stop():
            signal.raise_signal(signal.SIGINT)
        return 1

    monkeypatch.setattr(demo, "layerjam", run)
    with pytest.raises(KeyboardInterrupt):
        demo._Steps(tmp_path / "log.txt").run_step("bench", "bench", "run")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
def test_an_interrupted_compiler_is_not_one_that_cannot_build(tmp_path: Path) -> None:
    code = "import os, signal; signal.signal(2, signal.SIG_DFL); os.kill(os.getpid(), 2)"
    with pytest.raises(KeyboardInterrupt):
        run_compiler([sys.executable, "-c", code], tmp_path / "kernel.so")
    assert not [*tmp_path.iterdir()]


@pytest.mark.usefixtures("handler")
def test_a_thread_announces_no_compilation_after_an_interrupt(
    capsys: pytest.CaptureFixture[str],
) -> None:
    announce_compilation.cache_clear()
    Appearing.interrupted = True
    with pytest.raises(KeyboardInterrupt):
        announce_compilation()
    assert capsys.readouterr().err == ""


def test_an_interrupt_waits_only_for_work_that_has_begun() -> None:
    begun, may_end, ran = threading.Event(), threading.Event(), []

    def work() -> None:
        begun.set()
        may_end.wait()

    def interrupt() -> None:
        with Workers(1) as pool:
            pool.submit(work)
            begun.wait()
            pool.submit(ran.append, 1)
            threading.Timer(0.05, may_end.set).start()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupt()
    assert not ran
