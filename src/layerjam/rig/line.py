"""One serial line to a board: a question in a frame, its answer, tried again where it is lost."""

from __future__ import annotations

import os
import re
import select
import socket
import threading
import time
from collections.abc import Callable
from typing import Protocol

from layerjam.errors import FileError, LayerjamError, MissingExtraError
from layerjam.rig.frame import first, pack

TRIES = 5
WAIT = 0.5
"""Seconds that an answer is waited for, each time."""
QUIET = 0.05
"""Seconds after which nothing more comes of an answer that has begun."""
PROMPTS = (b">>> ", b"Traceback (most recent call last)")
"""What a board says whose firmware does not run."""


class LineError(LayerjamError):
    """A line that does not answer, or on which something else answers."""

    key = "line"


class SpoiltError(LineError):
    """A line on which answers come, but none of them whole."""

    key = "line-spoilt"


class Ends(Protocol):
    """Both ends of a line of bytes."""

    def read(self, wait: float) -> bytes:
        """What came, waiting at most so many seconds; LineError where the line is closed."""

    def write(self, data: bytes) -> None:
        """Send all of it."""

    def close(self) -> None:
        """Give the line back."""


class Pipes:
    """A line of two descriptors; `closing` ends what is behind them."""

    def __init__(self, incoming: int, outgoing: int, closing: Callable[[], None]) -> None:
        self._in, self._out, self._closing = incoming, outgoing, closing

    def read(self, wait: float) -> bytes:
        """What came within so many seconds."""
        if not select.select([self._in], [], [], wait)[0]:
            return b""
        data = os.read(self._in, 65536)
        if not data:
            raise LineError("the board's line is closed")
        return data

    def write(self, data: bytes) -> None:
        """Send all of it."""
        try:
            os.write(self._out, data)
        except BrokenPipeError:
            raise LineError("the board's line is closed") from None

    def close(self) -> None:
        """End what is behind it."""
        self._closing()


class Sockets:
    """A line of one connected socket; `closing` ends what is behind it."""

    def __init__(self, joined: socket.socket, closing: Callable[[], None]) -> None:
        self._joined, self._closing = joined, closing

    def read(self, wait: float) -> bytes:
        """What came within so many seconds."""
        try:
            if not select.select([self._joined], [], [], wait)[0]:
                return b""
            data = self._joined.recv(65536)
        except ConnectionError:
            data = b""
        if not data:
            raise LineError("the board's line is closed")
        return data

    def write(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._joined.sendall(data)
        except ConnectionError:
            raise LineError("the board's line is closed") from None

    def close(self) -> None:
        """End what is behind it."""
        self._closing()


def _why(error: OSError) -> str:
    """What the system says about a port, without pyserial's words around it.

    On POSIX pyserial keeps the system's number; on Windows it writes the system's error as code:
    could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5).
    """
    if error.errno is not None and error.errno > 0:
        return os.strerror(error.errno)
    written = re.search(r"\(\d+, (['\"])(.*?)\1", str(error))
    return (written[2] if written else str(error).split(": ")[-1]).rstrip(".")[:200]


class Serial:
    """A serial port, kept from everybody else."""

    def __init__(self, port: str) -> None:
        with MissingExtraError.raise_if_missing("a serial port", "bench"):
            import serial
        try:
            self._port = serial.Serial(port, 115200, timeout=0, write_timeout=2, exclusive=True)
        except (serial.SerialException, OSError) as error:
            raise FileError(port, f"cannot be opened: {_why(error)}") from None

    def read(self, wait: float) -> bytes:
        """What came within so many seconds."""
        try:
            self._port.timeout = wait
            data: bytes = self._port.read(1)
            return data + self._port.read(self._port.in_waiting) if data else data
        except OSError as error:
            raise LineError(f"the serial line is gone: {error}") from None

    def write(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._port.write(data)
        except OSError as error:
            raise LineError(f"the serial line is gone: {error}") from None

    def close(self) -> None:
        """Give the port back."""
        self._port.close()


class Line:
    """Questions of up to 15 sessions, one after the other; may be asked from any thread."""

    def __init__(self, ends: Ends, name: str) -> None:
        self.name = name
        self.tries = 0
        """Frames sent, those sent again counted."""
        self._ends = ends
        self._lock = threading.Lock()
        self._numbers = [0] * 16
        self._buffer = b""
        self._spoilt = False

    def ask(self, session: int, text: bytes, *, tries: int = TRIES) -> bytes:
        """The answer to one line, empty where SCPI has none; executed once however often sent.

        An answer that comes spoilt is asked for again at once. Raises LineError after `tries` times
        0.5 s, SpoiltError where something came, and where a Python prompt answers.
        """
        with self._lock:
            number = self._numbers[session] = (self._numbers[session] + 1) % 256
            packed, self._spoilt = pack(session, number, text), False
            for attempt in range(tries):
                end, again = time.monotonic() + WAIT, attempt > 0
                while time.monotonic() < end:
                    # what is left of a torn frame ends with the LF before the next
                    self._ends.write(b"\n" + packed if again else packed)
                    self.tries += 1
                    answer = self._answer(session, number, end)
                    if answer is not None:
                        return answer
                    again = True
            kind = SpoiltError if self._spoilt else LineError
            raise kind(f"{self.name} does not answer: {tries} tries of {WAIT:g} s each")

    def send(self, session: int, text: bytes) -> None:
        """Send one line and leave its answer where it is."""
        with self._lock:
            number = self._numbers[session] = (self._numbers[session] + 1) % 256
            self._ends.write(pack(session, number, text))
            self.tries += 1

    def heard(self) -> list[bytes]:
        """All answers that wait, until nothing more comes for 0.5 s."""
        got: list[bytes] = []
        with self._lock:
            while data := self._ends.read(WAIT):
                self._buffer += data
                one, done = first(self._buffer)
                while one is not None:
                    got.append(one[2])
                    self._buffer = self._buffer[done:]
                    one, done = first(self._buffer)
        return got

    def _answer(self, session: int, number: int, end: float) -> bytes | None:
        """The payload of the frame asked for, None where it is spoilt or not there in time."""
        while True:
            found, done = first(self._buffer)
            if found is None and any(prompt in self._buffer for prompt in PROMPTS):
                self._buffer = b""
                raise LineError(
                    f"{self.name}: a Python prompt or a traceback answers; the firmware is not "
                    "running"
                )
            passed, self._buffer = self._buffer[:done], self._buffer[done:]
            if found is not None:
                if found[:2] == (session, number):
                    return found[2]
                continue
            left, begun = end - time.monotonic(), bool(passed or self._buffer)
            ended = passed.endswith(b"\n") and not self._buffer
            more = (
                b"" if ended or left <= 0 else self._ends.read(min(left, QUIET if begun else left))
            )
            if not more and (begun or left <= 0):
                self._buffer, self._spoilt = b"", self._spoilt or begun
                return None
            self._buffer += more

    def greet(self, patience: float) -> str:
        """The board's `*IDN?`, waited for while it starts; leftovers of earlier clients ended."""
        end = time.monotonic() + patience
        while True:
            try:
                said = self.ask(1, b"*IDN?", tries=1)
                break
            except LineError:
                if time.monotonic() > end:
                    raise LineError(f"{self.name} does not answer: {patience:g} s") from None
        for session in range(1, 16):
            self.ask(session, b"")
        return said.decode("ascii", "replace")

    def close(self) -> None:
        """Give the line back."""
        self._ends.close()
