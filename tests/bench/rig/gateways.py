"""A gateway in a process of its own, and clients of the plainest kind."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

CODE = """
import sys
from layerjam.bench.rig.serve import serve
def announce(at):
    print(at.port, at.pid, at.identity, flush=True)
serve(sys.argv[1], announce, port=0, **eval(sys.argv[2]))
"""


@contextlib.contextmanager
def gateway(address: str, **more: Any) -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """(port, process) of a gateway, ended by SIGTERM."""
    process = subprocess.Popen(
        [sys.executable, "-c", CODE, address, repr(more)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ},
    )  # fmt: skip
    try:
        assert process.stdout is not None and process.stderr is not None
        first = process.stdout.readline()
        assert first, process.stderr.read()
        yield int(first.split()[0]), process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        process.communicate(timeout=30)


class Client:
    """A socket and lines."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), 10)
        self.file = self.socket.makefile("rb")

    def send(self, text: str | bytes) -> None:
        self.socket.sendall((text if isinstance(text, bytes) else text.encode()) + b"\n")

    def ask(self, text: str | bytes) -> str:
        self.send(text)
        return self.file.readline().decode().removesuffix("\n")

    def error(self) -> int:
        return int(self.ask("SYST:ERR?").split(",")[0])

    def closed(self) -> bool:
        try:
            return self.file.readline() == b""
        except ConnectionError:
            return True

    def close(self) -> None:
        self.file.close()
        self.socket.close()
