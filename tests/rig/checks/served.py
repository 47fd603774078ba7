"""A gateway as a user starts it, for checks that run in an environment without layerjam."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
OURS = os.environ.get("LAYERJAM_PYTHON") or str(Path(sys.prefix).parent / "bin" / "python")
START = "from layerjam.cli.start import run; run()"


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


def command(*words: str) -> list[str]:
    """`layerjam` with these words, run by the project's interpreter."""
    return [OURS, "-c", START, *words]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT / "src")}


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
