"""When Ctrl-C stops a command, and when its whole result is already appearing."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.cli import demo
from layerjam.cli.interrupts import _raise_interrupt
from layerjam.core.drawing.folder import write_folder
from layerjam.core.store import Appearing, store_file

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
