"""Rules of Windows for file names, and its advice for files that another program has open."""

import os
from pathlib import PurePath

WINDOWS = os.name == "nt"
DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"} | {
    f"{port}{n}" for port in ("COM", "LPT") for n in "123456789¹²³"
}
LONGEST = 260
"""Longest path that Windows accepts by default, with its end, in characters."""


def is_windows() -> bool:
    """Whether this is Windows."""
    return WINDOWS


def refusal(path: PurePath) -> str | None:
    """Return the reason why Windows rejects a file name; None if it accepts it, or elsewhere.

    A device's name counts with any ending: text written to `con.toml` goes to the console.
    """
    if not WINDOWS:
        return None
    name = path.name
    if name.split(".")[0].rstrip(" ").upper() in DEVICES:
        return f"'{name}' is a device's name on Windows; use another one"
    if name != name.rstrip(". "):
        return f"'{name}' ends with a dot or a blank, which Windows drops; use another name"
    if forbidden := sorted({c for c in name if c in '<>:"|?*' or ord(c) < 32}):
        return f"{' '.join(map(repr, forbidden))} in '{name}' is not allowed on Windows"
    return None


def reason(error: OSError, path: PurePath) -> str:
    """Return the system's message, with advice on Windows."""
    message = error.strerror or str(error)
    if not WINDOWS:
        return message
    if isinstance(error, PermissionError) and os.path.isfile(path):
        return f"{message}; if another program, such as a spreadsheet, has it open, close it there"
    if len(os.path.abspath(path)) >= LONGEST:
        return f"{message}; the path is longer than the {LONGEST - 1} characters that Windows takes"
    return message
