"""What must hold of the files a command is to write, before anything is computed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from layerjam.errors import FileError
from layerjam.records.windows import refusal

PICTURES = (".svg", ".png", ".pdf")


def check_figure(path: Path | None, force: bool, flag: str = "--force") -> None:
    """Refuse a figure that could not be drawn or written, before anything is computed."""
    check_target(path, force, PICTURES, flag)
    if path is not None:
        from layerjam.report.style import look

        with look():
            pass


def check_target(
    path: Path | None, force: bool, endings: tuple[str, ...], flag: str = "--force"
) -> None:
    """Refuse an output file of another kind, or one that exists unless `force` (option `flag`)."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        known = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
        raise FileError(path, f"the ending '{path.suffix}' is not known; use {known}")
    try:
        there = os.path.lexists(path)
        if there and not path.is_file():
            raise FileError(path, "is a folder or no regular file")
        if there and not force:
            raise FileError(path, f"exists already; {flag} replaces it")
        if not path.parent.is_dir():
            raise FileError(path, f"cannot be written: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK):
            raise FileError(path, f"cannot be written: the folder {path.parent} is read-only")
        if why := refusal(path):
            raise FileError(path, f"cannot be written: {why}")
        if len(os.fsencode(path.name)) > 200:
            raise FileError(f"{path.name[:60]}...", "cannot be written: the name is too long")
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(str(path)[:200], f"cannot be written: {reason}") from None
