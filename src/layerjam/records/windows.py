"""What Windows allows of a file's name, and says where another program has the file open."""

from __future__ import annotations

import os
from pathlib import PurePath

WINDOWS = os.name == "nt"
DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"} | {
    f"{port}{n}" for port in ("COM", "LPT") for n in "123456789¹²³"
}
LONGEST = 260
"""Characters of a path, its end counted, that Windows takes as it is usually set."""


def is_windows() -> bool:
    """Whether this is Windows."""
    return WINDOWS


def refusal(path: PurePath) -> str | None:
    """Why Windows takes no file of this name; None where it does, and on other systems.

    A device's name is one with any ending: what is written to `con.toml` goes to the console.
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
    """What the system says, and on Windows what may be done about it."""
    said = error.strerror or str(error)
    if not WINDOWS:
        return said
    if isinstance(error, PermissionError) and os.path.isfile(path):
        return f"{said}; if another program, such as a spreadsheet, has it open, close it there"
    if len(os.path.abspath(path)) >= LONGEST:
        return f"{said}; the path is longer than the {LONGEST - 1} characters that Windows takes"
    return said
