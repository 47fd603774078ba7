"""The workbench's first page in Chromium: from the command to its numbers, in both times."""

from __future__ import annotations

import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.first_answers import SCRIPT
from benchmarks.timing import Row, cpu, fresh

LONG = 90_000
"""Milliseconds a first answer may take."""


def at(ident: str) -> str:
    """How the page finds an element of ours."""
    return f'[data-testid="{ident}"]'


def free_port() -> int:
    """One that nothing listens on."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def wait_for(port: int) -> None:
    """Until something listens there."""
    while True:
        with socket.socket() as line:
            if line.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.01)


@contextmanager
def started(
    port: int | None = None, caches: Path | None = None
) -> Iterator[tuple[str, int, float]]:
    """(address, process, moment of the command) of a workbench of its own.

    `caches` is a folder for all of its caches, instead of the user's.
    """
    port = port or free_port()
    program = str(Path(sys.executable).with_name("layerjam"))
    began = time.perf_counter()
    process = subprocess.Popen(
        [program, "workbench", "--no-show", "--port", str(port)],
        stdout=subprocess.PIPE,
        env=None if caches is None else fresh(caches),
    )
    try:
        assert process.stdout is not None
        process.stdout.readline()
        wait_for(port)  # a browser that is refused is busy for a while with its own page about that
        yield f"http://127.0.0.1:{port}/", process.pid, began
    finally:
        process.terminate()
        process.wait(30)


def first_page(context: Any, port: int, caches: Path | None = None) -> tuple[float, float]:
    """From the command to the numbers and the picture of the first page.

    Returns (seconds, seconds of the server's processor time).
    """
    page = context.new_page()
    with started(port, caches) as (place, process, began):
        page.goto(place, wait_until="commit")
        page.wait_for_selector(at("start-chart") + " canvas", timeout=LONG)
        page.wait_for_function(
            "document.querySelector('[data-testid=start-force]').innerText.endsWith('N')",
            timeout=LONG,
        )
        took = time.perf_counter() - began, spent(process)
        page.close()
        return took


def spent(process: int) -> float:
    """Seconds of processor time of a process and of those that it has waited for."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def first_numbers(browser: Any) -> list[Row]:
    """From the command to the first numbers, after a start that fills the caches."""
    context, port = browser.new_context(), free_port()
    first_page(context, port)
    times = [first_page(context, port)[0] for _ in range(5)]
    script, server = [], []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as folder:
            script.append(cpu(SCRIPT, Path(folder)))
            server.append(first_page(context, port, Path(folder))[1])
    context.close()
    return [
        Row("first page, from the command (warm cache)", statistics.median(times), 2.0),
        Row(
            "first numbers, CPU, empty caches", statistics.median(server), None,
            statistics.median(script), "SciPy script", target_ratio=3.0,
        ),
    ]  # fmt: skip
