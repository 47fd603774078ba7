"""Brakes by catalogue name or path, and files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path

from layerjam.device.file import BrakeFile, read_brake
from layerjam.device.toml import read_text
from layerjam.errors import FileError, UnknownNameError


@cache
def _texts(folder: str) -> dict[str, str]:
    place = files("layerjam.device") / "catalogue" / folder
    return {
        f.name.removesuffix(".toml"): f.read_text(encoding="utf-8")
        for f in sorted(place.iterdir(), key=lambda f: f.name)
        if f.name.endswith(".toml")
    }


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
    name = str(brake)
    texts = _texts("brakes")
    if name in texts:
        return read_brake(texts[name], name, materials())
    looks_like_path = name.endswith(".toml") or os.sep in name
    if not looks_like_path and not Path(name[:200]).is_file():
        raise UnknownNameError("brake", name, texts)
    return read_brake(read_text(Path(name)), name, materials())


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
