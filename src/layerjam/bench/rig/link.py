"""Access of a driver to its instrument, as owner of the line or as a client of a gateway."""

import re
import socket
import time
from typing import Any, Protocol

from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.board import VirtualBoard, connect
from layerjam.bench.rig.frame import PENDING
from layerjam.bench.rig.line import Line, LineError
from layerjam.bench.rig.token import read_token
from layerjam.core.errors import FileError, MissingExtraError

PATIENCE = 5.0
"""Longest wait for a gateway's response [s]."""
WAITS = re.compile(r"\*(OPC|WAI)", re.IGNORECASE)
"""Commands that may wait for the end of a capture, with no time limit."""
SESSION = 1
CHECK = "*OPT?;:SYST:ERR?"
"""Query with a recognisable response, beginning with 0, that marks the end of earlier ones."""
CHECKED = re.compile(rb'0;([+-]?\d+),"(.*)"')
POLL = 0.02
"""Time between two queries about a line that waits for a capture [s]."""


class Link(Protocol):
    """One client's side of an instrument."""

    def exchange(self, text: str) -> tuple[bytes, int, str]:
        """Return the response to a SCPI line, and the number (or 0) and text of the first error."""

    def close(self) -> None:
        """Disconnect; the session ends."""


def parse_check(answer: bytes) -> tuple[int, str]:
    """Return number and text in a response to CHECK; raises LineError for any other response."""
    match = CHECKED.fullmatch(answer)
    if match is None:
        raise LineError(f"expected an error number, got {answer[:60]!r}")
    return int(match.group(1)), match.group(2).decode("ascii", "replace").replace('""', '"')


class BoardLink:
    """Client that owns the serial line and sends frames."""

    def __init__(self, line: Line, board: VirtualBoard | None) -> None:
        self.line, self.board = line, board

    def exchange(self, text: str) -> tuple[bytes, int, str]:
        """Send the line, then read the oldest error in the session's queue."""
        answer = self.line.ask(SESSION, text.encode("ascii"))
        while answer == PENDING:
            time.sleep(POLL)
            answer = self.line.ask(SESSION, PENDING)
        return answer, *parse_check(self.line.ask(SESSION, CHECK.encode()))

    def close(self) -> None:
        """End the session and close the line."""
        try:
            self.line.ask(SESSION, b"", tries=1)
        except LineError:
            pass
        finally:
            self.line.close()


def connect_socket(address: Address) -> socket.socket:
    """Return a socket for a `tcp:` address; raises FileError if no gateway listens there."""
    try:
        connection = socket.create_connection(address.host_port, PATIENCE)
    except OSError as error:
        reason = error.strerror or str(error)
        raise FileError(str(address), f"no response: {reason}") from None
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    return connection


class SocketLink:
    """A client of a gateway that uses plain SCPI over a socket or VISA."""

    def __init__(self, address: Address) -> None:
        self._socket = VisaEnds(address) if address.kind == "visa" else connect_socket(address)
        self._buffer = b""
        self._name = str(address)
        if "token" in address.options:
            self._send_token(read_token(address.options["token"]))

    def _send_token(self, token: str) -> None:
        """Send the gateway's token; raises FileError if the gateway has a different one."""
        self._socket.sendall(f'SYST:PASS:CEN "{token}"\nSYST:PASS:CEN:STAT?\n'.encode("ascii"))
        if self._read_response() != b"1":
            self.close()
            raise FileError(self._name, "the gateway has a different token; copy its --token-file")

    def exchange(self, text: str) -> tuple[bytes, int, str]:
        """Send the line and CHECK in one packet, because a rejected line returns no response."""
        self._socket.settimeout(None if WAITS.search(text) else PATIENCE)
        try:
            self._socket.sendall(text.encode("ascii") + b"\n" + CHECK.encode() + b"\n")
        except OSError as error:
            raise LineError(f"connection to {self._name} lost: {error}") from None
        first = self._read_response()
        match = CHECKED.fullmatch(first)
        if match is not None:
            return b"", *parse_check(first)
        return first, *parse_check(self._read_response())

    def _read_response(self) -> bytes:
        """Return one response: a block by its length, anything else up to the LF."""
        while True:
            end = self._find_end()
            if end and len(self._buffer) >= end:
                answer, self._buffer = self._buffer[: end - 1], self._buffer[end:]
                return answer
            try:
                data = self._socket.recv(65536)
            except OSError as error:
                raise LineError(f"{self._name} does not respond: {error}") from None
            if not data:
                raise LineError(f"{self._name} closed the connection")
            self._buffer += data

    def _find_end(self) -> int:
        """Return the end, with its LF, of the first response in the buffer, or 0."""
        if self._buffer[:1] == b"#":
            digits = self._buffer[1:2]
            begin = 2 + int(digits) if digits.isdigit() else 0
            if not begin or len(self._buffer) < begin:
                return 0
            # other responses may follow a block
            return self._buffer.find(b"\n", begin + int(self._buffer[2:begin])) + 1
        return self._buffer.find(b"\n") + 1

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()


def open_link(address: str | Address) -> Link:
    """Return a client of a gateway (`tcp:`, `visa:`), or the owner of the board's line."""
    target = address_of(address)
    if target.kind in ("tcp", "visa"):
        return SocketLink(target)
    return BoardLink(*connect(target))


class VisaEnds:
    """A VISA resource with the methods of a connected socket; all errors are OSError.

    Its address is `visa:TCPIP::10.0.0.7::5025::SOCKET` or `visa:ASRL/dev/ttyACM0::INSTR`. PyVISA
    uses the installed VISA library or, if there is none, its backend in pure Python.
    """

    def __init__(self, address: Address) -> None:
        with MissingExtraError.raise_if_missing("a VISA address", "visa"):
            import pyvisa
        self._error: type[Exception] = pyvisa.Error
        try:
            self._manager: Any = pyvisa.ResourceManager()
        except (OSError, ValueError) as error:
            raise FileError(str(address), f"no VISA library was found: {error}") from None
        try:
            self._resource: Any = self._manager.open_resource(
                address.where, read_termination="\n", write_termination="\n"
            )
            self.settimeout(PATIENCE)
        except (pyvisa.Error, OSError, ValueError, AttributeError) as error:
            self._manager.close()
            raise FileError(str(address), f"no response: {error}") from None

    def settimeout(self, seconds: float | None) -> None:
        """Limit the wait for a response [s], or remove the limit."""
        self._resource.timeout = None if seconds is None else 1e3 * seconds

    def sendall(self, data: bytes) -> None:
        """Send all bytes."""
        try:
            self._resource.write_raw(data)
        except self._error as error:
            raise OSError(str(error)) from None

    def recv(self, _limit: int) -> bytes:
        """Return the bytes up to the next LF, or to the end of a message."""
        try:
            return bytes(self._resource.read_raw())
        except self._error as error:
            raise OSError(str(error)) from None

    def close(self) -> None:
        """Close the resource."""
        self._resource.close()
        self._manager.close()
