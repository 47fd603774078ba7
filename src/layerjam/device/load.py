"""Brakes by catalogue name or path, and files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from layerjam.device.file import BrakeFile, read_brake
from layerjam.device.shipped import shipped, text_of
from layerjam.errors import FileError


def _texts(folder: str) -> dict[str, str]:
    return shipped("layerjam.device", "catalogue", folder)


def catalogue() -> list[str]:
    """Names of the brakes in the catalogue."""
    return list(_texts("brakes"))


def materials() -> dict[str, dict[str, str]]:
    """{"films": {name: TOML text}, "silicones": ...}."""
    return {folder: _texts(folder) for folder in ("films", "silicones")}


def load(brake: str | Path) -> BrakeFile:
    """A brake by catalogue name, or from the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    return read_brake(*text_of("brake", brake, _texts("brakes")), materials())


def write_whole(path: str | Path, write: Callable[[Path], None], force: bool = False) -> Path:
    """Let `write` fill a temporary file beside `path`, then move it there in one step.

    Raises FileError where `path` exists and `force` is not set, or cannot be written; nothing is
    left behind then.
    """
    path = Path(path)
    try:
        there = os.path.lexists(path)
    except (OSError, ValueError) as err:
        raise FileError(str(path)[:200], f"cannot be written: {err}") from None
    if there and not force:
        raise FileError(path, "exists already; --force replaces it")
    if path.is_dir():
        raise FileError(path, "is a folder, not a file")
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(
            prefix=f".{path.stem[:40]}-", suffix=path.suffix, dir=path.parent
        )
        os.close(handle)
        write(Path(temporary))
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, path)
        temporary = None
    except OSError as err:
        raise FileError(path, f"cannot be written: {err.strerror or err}") from None
    finally:
        if temporary and os.path.exists(temporary):
            os.unlink(temporary)
    return path
