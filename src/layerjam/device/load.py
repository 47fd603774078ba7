"""Brakes by catalogue name or path, and files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

from layerjam.device.brake import Brake, validate
from layerjam.device.file import BrakeFile, materials
from layerjam.errors import FileError
from layerjam.records.shipped import shipped, text_of
from layerjam.records.windows import reason, refusal

READING = "-eq9"
"""Ending of a brake whose factor and stiffness are what the paper's eq. 8 and 9 were given."""


def _texts() -> dict[str, str]:
    return shipped("layerjam.device", "catalogue", "brakes")


def catalogue() -> list[str]:
    """Names of the brakes in the catalogue."""
    return list(_texts())


def devices() -> list[str]:
    """Names of the brakes in the catalogue, without second readings of one device's numbers."""
    return [name for name in catalogue() if not name.endswith(READING)]


def load(brake: str | Path) -> BrakeFile:
    """A brake by catalogue name, or from the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    name = str(brake)
    if name not in _texts():
        return BrakeFile.read(*text_of("brake", brake, _texts()))
    found = _shipped(name)
    return replace(found, sources=dict(found.sources), notes=dict(found.notes))


@cache
def _shipped(name: str) -> BrakeFile:
    return BrakeFile.read(*text_of("brake", name, _texts()))


def brake_of(anything: str | Path | BrakeFile | Brake) -> Brake:
    """The brake itself, checked: from its name or path, its file, or the plain record.

    Raises UnknownNameError, FileError, or QuantityError for a record that contradicts itself.
    """
    if isinstance(anything, str | Path):
        return load(anything).brake
    brake = anything.brake if isinstance(anything, BrakeFile) else anything
    validate(brake)
    return brake


def write_whole(
    path: str | Path, content: str | bytes | Callable[[Path], object], force: bool = False
) -> Path:
    """Fill a temporary file beside `path`, then move it there in one step.

    `content` is the text (written in UTF-8), the bytes, or what fills the file of a given path.

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
    if why := refusal(path):
        raise FileError(path, f"cannot be written: {why}")
    temporary = None
    try:
        temporary = _new_beside(path)
        if isinstance(content, str | bytes):
            temporary.write_bytes(content if isinstance(content, bytes) else content.encode())
        else:
            content(temporary)
        os.replace(temporary, path)
        temporary = None
    except OSError as err:
        raise FileError(path, f"cannot be written: {reason(err, path)}") from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
    return path


def _new_beside(path: Path) -> Path:
    """A new, empty file of a random name, with the rights that the user's umask leaves."""
    name = f".{path.stem[:40]}-{secrets.token_hex(8)}{path.suffix}"
    made = path.with_name(name)
    # asked of the system for this one file: the umask itself belongs to the whole process
    os.close(os.open(made, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return made


__all__ = ["brake_of", "catalogue", "load", "materials", "write_whole"]
