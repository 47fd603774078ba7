"""A gateway as a user starts it, for checks that run in an environment without layerjam."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[4]
OURS = os.environ.get("LAYERJAM_PYTHON") or str(Path(sys.prefix).parent / "bin" / "python")
THEIRS = sysconfig.get_path("purelib")
"""Where this environment has PyVISA: behind the project's own packages, for `visa:` addresses."""
START = f"import sys; sys.path.append({THEIRS!r}); from layerjam.cli.start import run; run()"
RUN = (
    *("--procedure", "evacuate to 40 kPa and hold 2 s; vent; hold 1 s"),
    *("--brake", "choi2018-kapton", "--line", "choi2018", "--sensor-range", "103kPa"),
    *("--safe-state", "release", "--vent-rest", "open"),
)
"""What `bench run` is told besides an address and a file."""


@dataclass(frozen=True)
class Served:
    """A gateway: its port, its serial port, its process, the folder of both."""

    port: int
    pty: str
    process: subprocess.Popen[str]
    folder: Path

    @property
    def resource(self) -> str:
        return f"TCPIP::127.0.0.1::{self.port}::SOCKET"


def ours() -> str:
    """The project's own interpreter, or a skipped test."""
    if not Path(OURS).exists():
        pytest.skip("the project's own interpreter is not there: `make bench-checks` has it")
    return OURS


def command(*words: str) -> list[str]:
    """`layerjam` with these words, run by the project's interpreter."""
    return [ours(), "-c", START, *words]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT / "src")}


def answered(*words: str) -> dict[str, Any]:
    """What a command with `--json` says; it must leave with 0."""
    made = subprocess.run(
        command(*words), capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert made.returncode == 0, (made.stdout, made.stderr)
    said: dict[str, Any] = json.loads(made.stdout)
    return said


@contextlib.contextmanager
def serving(folder: Path, address: str, *more: str) -> Iterator[Served]:
    """`layerjam bench serve ADDRESS`, ended by SIGTERM, which must leave with 0."""
    pty = folder / "bench"
    process = subprocess.Popen(
        [*command("bench", "serve", address), "--port", "0", "--pty", str(pty), *more],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
    )
    assert process.stdout is not None and process.stderr is not None
    try:
        first = process.stdout.readline()
        assert first, process.stderr.read()
        port = int(json.loads(first)["listening"].rpartition(":")[2])
        yield Served(port, str(pty), process, folder)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        process.communicate(timeout=30)
    assert process.returncode == 0
