"""Check 25: clients with bad manners."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import Served, serving
from bench.rig.checks.visa import client, error

pytestmark = pytest.mark.slow


def test_25_two_megabytes_without_a_line(
    served: Served, tool: Callable[[str], str], figure: Callable[[str], None]
) -> None:
    """The one that sends them is closed; another client goes on meanwhile."""
    nc = tool("nc")
    with client(served) as other:
        process = subprocess.Popen(
            [nc, "127.0.0.1", str(served.port)], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
        )
        assert process.stdin is not None
        begun = time.monotonic()
        with contextlib.suppress(BrokenPipeError):
            process.stdin.write(b"A" * 2_000_000)
            process.stdin.flush()
            while process.poll() is None and time.monotonic() - begun < 10:
                assert other.query("*OPC?") == "1"
                process.stdin.write(b"A")
                process.stdin.flush()
                time.sleep(0.01)
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        closed = process.wait(10)
        assert other.query("FETC:ALL?").split(",")[5] == "SAFE" and error(other) == 0
    figure(f"25  nc with 2 MB without LF: closed after {time.monotonic() - begun:.2f} s ({closed})")


def test_25_twenty_connections(served: Served, figure: Callable[[str], None]) -> None:
    """As many as there are sessions may command, all are served; then all are free again."""
    lines = [socket.create_connection(("127.0.0.1", served.port), 5) for _ in range(20)]
    assert all(asked(line, b"*IDN?").startswith(b"layerjam,") for line in lines)
    answers = [asked(line, b"*ESE 0", b"SYST:ERR?") for line in lines]
    for line in lines:
        line.close()
    good = sum(answer.startswith(b"0,") for answer in answers)
    assert good == 13  # the fourteenth is the serial port's
    assert sum(b"sessions are in use" in answer for answer in answers) == 20 - good
    for _ in range(100):
        with (
            contextlib.suppress(OSError),
            socket.create_connection(("127.0.0.1", served.port), 5) as again,
        ):
            if asked(again, b"*OPC?") == b"1\n":
                break
        time.sleep(0.05)
    else:
        raise AssertionError("nobody is served any more")
    figure(f"25  20 connections: {good} command, {20 - good} may switch off, then all free again")


def test_25_six_wrong_tokens(tmp_path: Path, figure: Callable[[str], None]) -> None:
    token = tmp_path / "token"
    with serving(tmp_path, "sim:choi2018", "--host", "127.0.0.1", "--token-file", str(token)) as at:
        right = token.read_text("utf-8").strip().encode()
        assert token.stat().st_mode & 0o077 == 0
        with socket.create_connection(("127.0.0.1", at.port), 5) as line:
            assert asked(line, b"MEAS:VAC?;:SYST:ERR?", b"SYST:ERR?").startswith(b"-203")
            for _ in range(6):
                with contextlib.suppress(OSError):
                    line.sendall(b'SYST:PASS:CEN "0123456789abcdef"\n')
            begun = time.monotonic()
            with socket.create_connection(("127.0.0.1", at.port), 5) as other:
                other.sendall(b'SYST:PASS:CEN "' + right + b'"\n')
                assert asked(other, b"OUTP?") == b"0\n"
            waited = time.monotonic() - begun
            assert rest(line) == b"" and time.monotonic() - begun > 3
    assert waited < 2
    figure(f"25  6 wrong tokens: closed, another is heard after {waited:.2f} s, board unmoved")


def asked(line: socket.socket, *texts: bytes) -> bytes:
    """One answer, nothing where the connection is closed."""
    with contextlib.suppress(OSError):
        line.sendall(b"".join(text + b"\n" for text in texts))
        return received(line)
    return b""


def received(line: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        more = line.recv(4096)
        if not more:
            break
        data += more
    return data


def rest(line: socket.socket) -> bytes:
    """What still comes up to the end of the connection."""
    data: Any = b""
    with contextlib.suppress(ConnectionError):
        while more := line.recv(4096):
            data += more
    return bytes(data)
