"""One serial line to a board: queries and responses in frames, repeated if lost."""

import os
import re
import select
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from layerjam.bench.rig.frame import pack, parse_first_frame
from layerjam.core.errors import FileError, LayerjamError, MissingExtraError

TRIES = 5
WAIT = 0.5
"""Longest wait for a response in each attempt [s]."""
QUIET = 0.05
"""Silence after which a response is considered complete [s]."""
PROMPTS = (b">>> ", b"Traceback (most recent call last)")
"""Texts that a board sends if MicroPython runs without the firmware."""


class LineError(LayerjamError):
    """Raised if nothing responds on the line, or something other than the firmware."""

    key = "line"


class SpoiltError(LineError):
    """Raised if responses arrive on a line, but none of them is complete."""

    key = "line-spoilt"


class Ends(Protocol):
    """One end of a line of bytes."""

    def read(self, wait: float) -> bytes:
        """Return the bytes received within `wait` [s]; raises LineError if the line is closed."""

    def write(self, data: bytes) -> None:
        """Send all bytes."""

    def close(self) -> None:
        """Close the line."""


@dataclass
class ChildEnds:
    """A line to a subprocess: what `select` watches, its two functions, and how to end it."""

    source: int | socket.socket
    receive: Callable[[int], bytes]
    send: Callable[[bytes], object]
    closing: Callable[[], None]

    def read(self, wait: float) -> bytes:
        """Return the bytes received within `wait` [s]."""
        try:
            if not select.select([self.source], [], [], wait)[0]:
                return b""
            data = self.receive(65536)
        except ConnectionError:
            data = b""
        if not data:
            raise LineError("the connection to the board is closed")
        return data

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        try:
            self.send(data)
        except ConnectionError:
            raise LineError("the connection to the board is closed") from None

    def close(self) -> None:
        """End the process behind the line."""
        self.closing()


def _describe_error(error: OSError) -> str:
    """Return the system's message about a port, without pyserial's additions.

    On POSIX, pyserial keeps the system's error number; on Windows it prints the error as code:
    could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5).
    """
    if error.errno is not None and error.errno > 0:
        return os.strerror(error.errno)
    match = re.search(r"\(\d+, (['\"])(.*?)\1", str(error))
    return (match[2] if match else str(error).split(": ")[-1]).rstrip(".")[:200]


class Serial:
    """A serial port, opened for exclusive use."""

    def __init__(self, port: str) -> None:
        with MissingExtraError.raise_if_missing("a serial port", "bench"):
            import serial
        try:
            self._port = serial.Serial(port, 115200, timeout=0, write_timeout=2, exclusive=True)
        except (serial.SerialException, OSError) as error:
            raise FileError(port, f"cannot be opened: {_describe_error(error)}") from None

    def read(self, wait: float) -> bytes:
        """Return the bytes received within `wait` [s]."""
        try:
            self._port.timeout = wait
            data: bytes = self._port.read(1)
            return data + self._port.read(self._port.in_waiting) if data else data
        except OSError as error:
            raise LineError(f"serial connection lost: {error}") from None

    def write(self, data: bytes) -> None:
        """Send all bytes."""
        try:
            self._port.write(data)
        except OSError as error:
            raise LineError(f"serial connection lost: {error}") from None

    def close(self) -> None:
        """Close the port."""
        self._port.close()


class Line:
    """Sends the lines of up to 15 sessions, one at a time; usable from any thread."""

    def __init__(self, ends: Ends, name: str) -> None:
        self.name = name
        self.tries = 0
        """Number of frames sent, including repeats."""
        self._ends = ends
        self._lock = threading.Lock()
        self._numbers = [0] * 16
        self._buffer = b""
        self._spoilt = False

    def ask(self, session: int, text: bytes, *, tries: int = TRIES) -> bytes:
        """Return the response to one line; the line is executed only once, even if sent repeatedly.

        A damaged response is requested again immediately. Raises LineError after `tries` times 0.5
        s (SpoiltError if damaged responses arrived), or if a Python prompt responds.
        """
        with self._lock:
            number = self._numbers[session] = (self._numbers[session] + 1) % 256
            frame, self._spoilt = pack(session, number, text), False
            for attempt in range(tries):
                end, repeat = time.monotonic() + WAIT, attempt > 0
                while time.monotonic() < end:
                    # an LF ends the rest of a broken frame before the next one
                    self._ends.write(b"\n" + frame if repeat else frame)
                    self.tries += 1
                    answer = self._read_response(session, number, end)
                    if answer is not None:
                        return answer
                    repeat = True
            kind = SpoiltError if self._spoilt else LineError
            raise kind(f"{self.name} does not respond within {tries} × {WAIT:g} s")

    def send(self, session: int, text: bytes) -> None:
        """Send one line without reading its response."""
        with self._lock:
            number = self._numbers[session] = (self._numbers[session] + 1) % 256
            self._ends.write(pack(session, number, text))
            self.tries += 1

    def waiting_responses(self) -> list[bytes]:
        """Return all pending responses, until none arrives for 0.5 s."""
        payloads: list[bytes] = []
        with self._lock:
            while data := self._ends.read(WAIT):
                self._buffer += data
                frame, size = parse_first_frame(self._buffer)
                while frame is not None:
                    payloads.append(frame[2])
                    self._buffer = self._buffer[size:]
                    frame, size = parse_first_frame(self._buffer)
        return payloads

    def _read_response(self, session: int, number: int, end: float) -> bytes | None:
        """Return the payload of the response frame, or None if it is damaged or too late."""
        while True:
            frame, size = parse_first_frame(self._buffer)
            if frame is None and any(prompt in self._buffer for prompt in PROMPTS):
                self._buffer = b""
                raise LineError(
                    f"{self.name}: received a Python prompt or a traceback; the firmware "
                    "is not running"
                )
            skipped_bytes, self._buffer = self._buffer[:size], self._buffer[size:]
            if frame is not None:
                if frame[:2] == (session, number):
                    return frame[2]
                continue
            time_left, partial = end - time.monotonic(), bool(skipped_bytes or self._buffer)
            is_end = skipped_bytes.endswith(b"\n") and not self._buffer
            wait = min(time_left, QUIET if partial else time_left)
            data = b"" if is_end or time_left <= 0 else self._ends.read(wait)
            if not data and (partial or time_left <= 0):
                self._buffer, self._spoilt = b"", self._spoilt or partial
                return None
            self._buffer += data

    def greet(self, patience: float) -> str:
        """Return the `*IDN?` response of a board once it has started; end all older sessions."""
        end = time.monotonic() + patience
        while True:
            try:
                response = self.ask(1, b"*IDN?", tries=1)
                break
            except LineError:
                if time.monotonic() > end:
                    raise LineError(f"{self.name} does not respond within {patience:g} s") from None
        for session in range(1, 16):
            self.ask(session, b"")
        return response.decode("ascii", "replace")

    def close(self) -> None:
        """Release the line."""
        self._ends.close()
