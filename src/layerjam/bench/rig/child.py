"""Starting the firmware in a separate process, connected by pipes, or by sockets on Windows.

On Windows a child inherits only three file descriptors, and `select` accepts only sockets.
"""

import os
import secrets
import socket
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from layerjam.bench.rig.line import ChildEnds, Ends, LineError

PIPES = sys.platform != "win32"
"""Whether this system can connect the virtual board by pipes."""
PATIENCE = 15.0
"""Time within which the firmware's process must connect [s]."""


@dataclass(frozen=True)
class Child:
    """The firmware's process with two connections: `line` for commands, one to the plant."""

    process: subprocess.Popen[bytes]
    line: Ends
    ends: tuple[int, int]
    receive: Callable[[int], bytes]
    send: Callable[[bytes], object]
    leave: Callable[[], None]
    """Function that closes the plant's connection."""
    hang_up: Callable[[], None]
    """Function that closes the connection for commands."""


def has_pipes() -> bool:
    """Return whether this system can connect the virtual board by pipes."""
    return PIPES


def start_child(command: Sequence[str], words: Sequence[str], closing: Callable[[], None]) -> Child:
    """Run `command`; its arguments are two that identify the plant's connection, then `words`.

    `closing` is called when `Child.line` is closed. Raises LineError if the child does not connect.
    """
    return (_use_pipes if has_pipes() else _use_sockets)(command, words, closing)


def _use_pipes(command: Sequence[str], words: Sequence[str], closing: Callable[[], None]) -> Child:
    from_board, to_board, line_in, line_out = os.pipe(), os.pipe(), os.pipe(), os.pipe()
    # the firmware handles the data that is waiting, then continues sampling
    os.set_blocking(line_in[0], False)
    process = subprocess.Popen(
        [*command, str(to_board[0]), str(from_board[1]), *words],
        stdin=line_in[0],
        stdout=line_out[1],
        stderr=subprocess.DEVNULL,
        pass_fds=(to_board[0], from_board[1]),
        start_new_session=True,
    )
    for descriptor in (to_board[0], from_board[1], line_in[0], line_out[1]):
        os.close(descriptor)
    pipes = [(from_board[0], to_board[1]), (line_out[0], line_in[1])]
    (receive, send), line = ((partial(os.read, a), partial(os.write, b)) for a, b in pipes)
    leave, hang_up = (partial(_close_descriptors, *ends) for ends in pipes)
    ends = ChildEnds(pipes[1][0], *line, closing)
    return Child(process, ends, pipes[1], receive, send, leave, hang_up)


def _close_descriptors(*descriptors: int) -> None:
    for descriptor in descriptors:
        os.close(descriptor)


def _use_sockets(
    command: Sequence[str], words: Sequence[str], closing: Callable[[], None]
) -> Child:
    token = secrets.token_hex(16)
    with socket.create_server(("127.0.0.1", 0)) as door:
        door.settimeout(PATIENCE)
        process = subprocess.Popen(
            [*command, f"tcp:{door.getsockname()[1]}", token, *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # a keyboard interrupt in this terminal must not reach the board
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        try:
            line, plant = _accept_child(door, token + "L"), _accept_child(door, token + "P")
        except OSError:
            process.kill()
            process.wait()
            raise LineError("the virtual board's process did not start") from None
    ends, numbers = ChildEnds(line, line.recv, line.sendall, closing), (line.fileno(),) * 2
    return Child(process, ends, numbers, plant.recv, plant.sendall, plant.close, line.close)


def _accept_child(door: socket.socket, token: str) -> socket.socket:
    """Return the first connection that begins with `token`; close all others."""
    while True:
        connection, _ = door.accept()
        connection.settimeout(PATIENCE)
        received_words = b""
        while len(received_words) < len(token) and (
            data := connection.recv(len(token) - len(received_words))
        ):
            received_words += data
        if secrets.compare_digest(received_words, token.encode("ascii")):
            connection.settimeout(None)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return connection
        connection.close()
