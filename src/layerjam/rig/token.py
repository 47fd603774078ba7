"""Who may command a bench that others on the network can reach: a token, compared in equal time."""

from __future__ import annotations

import hmac
import os
import re
import secrets
import time
from pathlib import Path

from layerjam.errors import FileError

FREE = re.compile(
    rb":?(\*IDN\?|SYST(EM)?:ERR(OR)?(:NEXT)?\?|OUTP(UT)?(:STAT(E)?)?[ \t]+(OFF|0)|ABOR(T)?)[ \t]*",
    re.IGNORECASE,
)
"""What is served without a token: who it is, what was wrong, and off."""
GIVEN = re.compile(
    rb":?SYST(?:EM)?:PASS(?:WORD)?:CEN(?:ABLE)?[ \t]+(['\"])(.{0,200})\1[ \t]*", re.IGNORECASE
)
ASKED = re.compile(rb":?SYST(EM)?:PASS(WORD)?(:CEN(ABLE)?)?:STAT(E)?\?[ \t]*", re.IGNORECASE)
ERRORS = re.compile(rb":?SYST(EM)?:ERR(OR)?(:NEXT)?\?[ \t]*", re.IGNORECASE)
TRIES = 5
WAIT = 10.0
"""Seconds for which nobody from an address is heard after so many wrong tokens."""
DENIED = b'-203,"Command protected;SYST:PASS:CEN ""token"" comes first"'


def token_of(file: str | Path) -> str:
    """The token in a file; a new one of 32 digits, readable for the owner alone, where none is.

    Raises FileError for a file that others may read or that holds no token.
    """
    path = Path(file)
    try:
        made = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        pass
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    else:
        with os.fdopen(made, "w", encoding="utf-8") as out:
            out.write(secrets.token_hex(16) + "\n")
    try:
        text, mode = path.read_text("utf-8").strip(), path.stat().st_mode
    except (OSError, UnicodeDecodeError):
        raise FileError(path, "cannot be read as a token") from None
    if os.name == "posix" and mode & 0o077:  # elsewhere these bits say nothing of who may read
        raise FileError(path, "others may read the token; chmod 600 keeps it")
    if not re.fullmatch(r"[0-9a-zA-Z]{16,128}", text):
        raise FileError(path, "a token is 16 to 128 letters and digits")
    return text


class Shut:
    """Addresses that gave wrong tokens, and until when nobody from there is heard."""

    def __init__(self) -> None:
        self._until: dict[str, float] = {}

    def close(self, peer: str) -> None:
        """Hear nobody from there for a while."""
        self._until[peer] = time.monotonic() + WAIT

    def out(self, peer: str) -> bool:
        """Whether nobody from there is heard now."""
        return time.monotonic() < self._until.get(peer, 0.0)


class Door:
    """One client before a token: what it says is let through, answered here, or neither."""

    def __init__(self, token: str) -> None:
        self._token = token
        self.open = not token
        self.wrong = 0
        self._denied = 0

    def through(self, line: bytes) -> tuple[bool, bytes]:
        """(whether the board is to hear the line, the answer where it is not, maybe empty)."""
        given = GIVEN.fullmatch(line)
        if given is not None:
            if not self._token or hmac.compare_digest(given.group(2), self._token.encode()):
                self.open = True
            else:
                self.wrong += 1
                self._denied += 1
            return False, b""
        if ASKED.fullmatch(line):
            return False, b"1" if self.open else b"0"
        if self._denied and ERRORS.fullmatch(line):
            self._denied -= 1
            return False, DENIED
        if self.open or FREE.fullmatch(line):
            return True, b""
        self._denied = min(self._denied + 1, 16)
        return False, b""
