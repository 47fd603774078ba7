"""The firmware in a process of its own, joined to this one by pipes, or by sockets on Windows.

There a child inherits no descriptor beyond the first three, and `select` knows sockets alone.
"""

from __future__ import annotations

import os
import secrets
import socket
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from layerjam.rig.line import Ends, LineError, Pipes, Sockets

PIPES = sys.platform != "win32"
"""Whether pipes do what the virtual board needs of them."""
PATIENCE = 15.0
"""Seconds in which the child must have called back."""


@dataclass(frozen=True)
class Child:
    """The process; its line, with what this side reads and writes; the plant's end; how to part."""

    process: subprocess.Popen[bytes]
    line: Ends
    ends: tuple[int, int]
    receive: Callable[[int], bytes]
    send: Callable[[bytes], object]
    leave: Callable[[], None]
    """Closes the plant's end."""
    hang_up: Callable[[], None]
    """Closes the line."""


def has_pipes() -> bool:
    """Whether the virtual board may be joined by pipes here."""
    return PIPES


def start(command: Sequence[str], words: Sequence[str], closing: Callable[[], None]) -> Child:
    """Run `command` with two words about the plant's end and then `words`.

    `closing` is called where the line is closed. Raises LineError where the child does not call.
    """
    join = _by_pipes if has_pipes() else _by_sockets
    return join(command, words, closing)


def _by_pipes(command: Sequence[str], words: Sequence[str], closing: Callable[[], None]) -> Child:
    told, shown, heard, said = os.pipe(), os.pipe(), os.pipe(), os.pipe()
    # the firmware reads what is there and goes on with its samples
    os.set_blocking(heard[0], False)
    process = subprocess.Popen(
        [*command, str(shown[0]), str(told[1]), *words],
        stdin=heard[0],
        stdout=said[1],
        stderr=subprocess.DEVNULL,
        pass_fds=(shown[0], told[1]),
        start_new_session=True,
    )
    for descriptor in (shown[0], told[1], heard[0], said[1]):
        os.close(descriptor)
    return Child(
        process,
        Pipes(said[0], heard[1], closing),
        (said[0], heard[1]),
        lambda size: os.read(told[0], size),
        lambda data: os.write(shown[1], data),
        lambda: _close(told[0], shown[1]),
        lambda: _close(said[0], heard[1]),
    )


def _close(*descriptors: int) -> None:
    for descriptor in descriptors:
        os.close(descriptor)


def _by_sockets(command: Sequence[str], words: Sequence[str], closing: Callable[[], None]) -> Child:
    token = secrets.token_hex(16)
    with socket.create_server(("127.0.0.1", 0)) as door:
        door.settimeout(PATIENCE)
        process = subprocess.Popen(
            [*command, f"tcp:{door.getsockname()[1]}", token, *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # an interrupt typed here is not the board's
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        try:
            line, plant = _called(door, token + "L"), _called(door, token + "P")
        except OSError:
            process.kill()
            process.wait()
            raise LineError("the virtual board's process does not start") from None
    ends = (line.fileno(), line.fileno())
    return Child(
        process, Sockets(line, closing), ends, plant.recv, plant.sendall, plant.close, line.close
    )


def _called(door: socket.socket, expected: str) -> socket.socket:
    """The connection of a child that says the words expected; others are sent away."""
    while True:
        made, _ = door.accept()
        made.settimeout(PATIENCE)
        said = b""
        while len(said) < len(expected) and (more := made.recv(len(expected) - len(said))):
            said += more
        if secrets.compare_digest(said, expected.encode("ascii")):
            made.settimeout(None)
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return made
        made.close()
