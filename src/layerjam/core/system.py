"""Differences between operating systems: file names, locks, commands as typed, file errors."""

import contextlib
import errno
import importlib
import os
import re
import shlex
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath
from typing import Any

from layerjam.core.errors import FileError, QuantityError

WINDOWS = os.name == "nt"
DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"} | {
    f"{port}{n}" for port in ("COM", "LPT") for n in "123456789¹²³"
}
LONGEST = 260
"""Longest path that Windows accepts by default, including its terminator [characters]."""
LOCKED = 0x4000_0400
"""Position of the byte to lock. Windows does not let other programs read a locked byte. SQLite
neither locks this byte nor stores data in the page around it."""
LAST_DATE = 253_402_300_799
"""End of the year 9999, the last date that Python can write [s since 1970]."""
_PLAIN = re.compile(r"[\w.:/\\*?=+~-]+")
"""Pattern of words that need no quotes in cmd.exe and PowerShell."""


def is_windows() -> bool:
    """Return whether this is Windows."""
    return WINDOWS


def check_source_date() -> None:
    """Raise QuantityError for a SOURCE_DATE_EPOCH that NumPy or Matplotlib cannot read."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "0")
    if not (epoch.isascii() and epoch.isdigit()):
        raise QuantityError.of("SOURCE_DATE_EPOCH", f"'{epoch[:60]}' is not a number of seconds")
    if len(epoch) > 20 or int(epoch) > LAST_DATE:
        raise QuantityError.of(
            "SOURCE_DATE_EPOCH", f"{epoch[:60]} s is after the year 9999; at most {LAST_DATE} s"
        )


def check_file_name(path: PurePath) -> None:
    """Raise FileError for a path with a file or folder name that Windows rejects.

    Call this first, because on Windows the name of a device counts as an existing file.
    """
    for name in path.parts[bool(path.anchor) :] if WINDOWS else ():
        if name != ".." and (problem := _explain_refusal(name)):
            raise FileError(path, f"cannot be written: {problem}")


def _explain_refusal(name: str) -> str | None:
    """Return the reason why Windows rejects a name, or None.

    A device name is reserved with any extension: text written to `con.toml` goes to the console.
    """
    if name.split(".", maxsplit=1)[0].rstrip(" ").upper() in DEVICES:
        return f"'{name}' is a device name on Windows; use a different one"
    if name != name.rstrip(". "):
        return f"'{name}' ends with a dot or a space, which Windows drops; use a different name"
    if forbidden := sorted({c for c in name if c in '<>:"|?*' or ord(c) < 32}):
        return f"{' '.join(map(repr, forbidden))} in '{name}' is not allowed on Windows"
    return None


@contextlib.contextmanager
def report_failure(path: str | PurePath, problem: str) -> Iterator[None]:
    """Turn a system error inside the block into a FileError: `path`: `problem` and the reason."""
    try:
        yield
    except (OSError, ValueError) as error:
        is_name = isinstance(error, UnicodeEncodeError) or "embedded null" in str(error)
        if not (isinstance(error, OSError) or is_name):
            raise
        place = PurePath(getattr(error, "filename2", None) or path)
        raise FileError(str(path)[:200], f"{problem}: {_describe_error(error, place)}") from None


def _describe_error(error: Exception, path: PurePath) -> str:
    """Return the system's message, with a hint if the system is Windows."""
    message = getattr(error, "strerror", None) or str(error)
    if not WINDOWS:
        return message
    if isinstance(error, PermissionError) and os.path.isfile(path):
        return f"{message}; if another program, such as a spreadsheet, has it open, close it there"
    if len(os.path.abspath(path)) >= LONGEST:
        return f"{message}; the path exceeds the {LONGEST - 1} characters that Windows accepts"
    return message


def is_reader_gone(error: OSError) -> bool:
    """Return whether a reader such as `head` has read enough, which is not an error.

    Windows reports this as an invalid argument.
    """
    return isinstance(error, BrokenPipeError) or (WINDOWS and error.errno == errno.EINVAL)


def lock_file(file: int, wait: bool = False) -> bool:
    """Lock an open file until it is closed or the process ends.

    Returns False if another program has locked it, or if locking is impossible.
    """
    try:
        if WINDOWS:
            system: Any = importlib.import_module("msvcrt")
            os.lseek(file, LOCKED, os.SEEK_SET)
            system.locking(file, system.LK_LOCK if wait else system.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def format_command_line(words: Iterable[str]) -> str:
    """Return a command as a user types it, with its words quoted for the system's command line."""
    return " ".join(map(quote_word, words))


def quote_word(word: str) -> str:
    """Return a word of a command, quoted if necessary.

    Windows needs double quotes, because cmd.exe passes single quotes to the program. Backslashes
    before a quote are doubled (Microsoft C, "Parsing C command-line arguments").
    """
    if not WINDOWS:
        return shlex.quote(word)
    if _PLAIN.fullmatch(word):
        return word
    text = re.sub(r'(\\*)("|$)', lambda m: m[1] * 2 + ('\\"' if m[2] else ""), word)
    return f'"{text}"'


def quote_pattern(folder: Path, name: str) -> str:
    """Return a path whose name has wildcards, quoted so that these still work.

    On Windows layerjam expands them, on other systems, the shell does.
    """
    return quote_word(str(folder / name)) if WINDOWS else f"{shlex.quote(str(folder))}/{name}"
