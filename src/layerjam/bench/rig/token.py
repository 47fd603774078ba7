"""Permission to command a bench on the network: a token, compared in constant time."""

import hmac
import os
import re
import secrets
from pathlib import Path

from layerjam.core.errors import FileError
from layerjam.core.system import check_file_name

STOP = re.compile(rb":?(OUTP(UT)?(:STAT(E)?)?[ \t]+(OFF|0)|ABOR(T)?)[ \t]*", re.IGNORECASE)
"""Lines that are accepted at any time."""
ERRORS = re.compile(rb"(\*OPT\?;)?:?SYST(EM)?:ERR(OR)?(:NEXT)?\?[ \t]*", re.IGNORECASE)
FREE = re.compile(rb"\*(IDN|OPT)\?[ \t]*|" + ERRORS.pattern + rb"|" + STOP.pattern, re.IGNORECASE)
"""Lines that the board accepts without a token: identity, options, errors and off."""
COMPLETE = re.compile(rb"\*OPC\?[ \t]*", re.IGNORECASE)
"""Query that a gateway answers with 1 to a client without a token: it has no pending operations."""
GIVEN = re.compile(
    rb":?SYST(?:EM)?:PASS(?:WORD)?:CEN(?:ABLE)?[ \t]+(['\"])(.{0,200})\1[ \t]*", re.IGNORECASE
)
ASKED = re.compile(rb":?SYST(EM)?:PASS(WORD)?(:CEN(ABLE)?)?:STAT(E)?\?[ \t]*", re.IGNORECASE)
TRIES = 5
"""Number of wrong tokens after which a client is disconnected."""
DELAY = 0.2
"""Delay after a client's first wrong token [s]; it doubles with each further one."""
QUEUE = 16
"""Number of denials stored for one client."""
DENIED = (
    b'-203,"Command protected;send SYST:PASS:CEN ""token"" first, or open the address with '
    b'?token=FILE"'
)
CROWDED = b'-203,"Command protected;all sessions are in use; only OUTP OFF is accepted"'
HTTP = re.compile(
    rb"(GET|HEAD|POST|PUT|DELETE|CONNECT|OPTIONS|TRACE|PATCH|PRI)[ \t].*|.*[ \t]HTTP/\d.*"
)
MESSAGE = re.compile(rb"[ \t;]*(\*[A-Za-z]|:?[A-Za-z])[\t -~]*")


def is_message(line: bytes) -> bool:
    """Return whether a client's first line is an instrument message, not an HTTP request.

    A web page can make a browser connect to any port on this machine. HTTP starts with a request
    line (RFC 9112, section 3), with the HTTP/2 preface or with a TLS record.
    """
    return MESSAGE.fullmatch(line) is not None and HTTP.fullmatch(line) is None


def make_token(file: str | Path) -> str:
    """Return the token in a file; a new file gets 32 digits that only its owner can read.

    Raises FileError for a file that others may read or that has no token.
    """
    path = Path(file)
    check_file_name(path)
    try:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        pass
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    else:
        with os.fdopen(descriptor, "w", encoding="utf-8") as out:
            out.write(secrets.token_hex(16) + "\n")
    return read_token(path)


def read_token(file: str | Path) -> str:
    """Return the token in a file; raises FileError if others may read it or it has no token."""
    path = Path(file)
    try:
        text, mode = path.read_text("utf-8").strip(), path.stat().st_mode
    except (OSError, UnicodeDecodeError):
        raise FileError(path, "cannot be read as a token") from None
    # on other systems, these bits do not show who may read the file
    if os.name == "posix" and mode & 0o077:
        raise FileError(path, "other users can read the token; protect it with chmod 600")
    if not re.fullmatch(r"[0-9a-zA-Z]{16,128}", text):
        raise FileError(path, "a token must have 16 to 128 letters and digits")
    return text


class Door:
    """Permission of one client: all lines if it has a token and a session, otherwise `FREE`."""

    def __init__(self, token: str) -> None:
        self._token = token
        self.open = not token
        self.wrong = 0
        """Number of wrong tokens."""
        self._denied: list[bytes] = []

    def filter_line(self, line: bytes, has_session: bool = True) -> tuple[bool, bytes]:
        """Return (whether to pass the line to the board, response if not)."""
        token_line = GIVEN.fullmatch(line)
        if token_line is not None:
            if not self._token or hmac.compare_digest(token_line.group(2), self._token.encode()):
                self.open = True
            else:
                self.wrong += 1
                self._queue_error(DENIED)
            return False, b""
        if ASKED.fullmatch(line):
            return False, b"1" if self.open else b"0"
        errors = ERRORS.fullmatch(line)
        if self._denied and errors is not None:
            return False, (b"0;" if errors.group(1) else b"") + self._denied.pop()
        if (self.open and has_session) or FREE.fullmatch(line):
            return True, b""
        if COMPLETE.fullmatch(line):
            return False, b"1"
        self._queue_error(CROWDED if self.open else DENIED)
        return False, b""

    def _queue_error(self, error: bytes) -> None:
        self._denied = [error, *self._denied][:QUEUE]
