"""Folders that appear whole or not at all, and leftovers of runs that were killed."""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import secrets
import shutil
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

HIDDEN = re.compile(r"\.layerjam-(?:[0-9a-f]{16}|(?:report|dataset)-[0-9a-f]{32})")
"""Names of hidden folders; those with a word are from earlier versions."""
TARGET, OLD = "target", "old"
HERE, EXCHANGE = -100, 2
DAY = 86_400.0


@contextlib.contextmanager
def hidden_folder(parent: Path) -> Iterator[Path]:
    """Make a hidden folder in `parent` to prepare another one in; it is removed at the end.

    Hidden folders of killed runs in `parent` are removed first. Raises OSError.
    """
    clear_leftovers(parent)
    while True:
        made = parent / f".layerjam-{secrets.token_hex(8)}"
        made.mkdir()
        lock = _lock(made, wait=True)
        if made.is_dir():  # another run may have removed it before it was locked
            break
        _unlock(lock)
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)
        _unlock(lock)


def clear_leftovers(parent: Path) -> None:
    """Remove the hidden folders of killed runs; one that a live run has locked stays.

    A folder that such a run had moved away, to put a new one in its place, is put back.
    """
    with contextlib.suppress(OSError):
        for left in [p for p in parent.iterdir() if HIDDEN.fullmatch(p.name)]:
            with contextlib.suppress(OSError):
                if left.is_symlink() or not left.is_dir():
                    continue
                lock = _lock(left)
                if lock is None and not _without_locks(left):
                    continue
                _restore(left)
                shutil.rmtree(left, ignore_errors=True)
                _unlock(lock)


def write_files(folder: Path, content: Mapping[str, str | bytes]) -> None:
    """Write {path inside `folder`: content}, with the folders that it needs; raises OSError."""
    for name, text in content.items():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(text if isinstance(text, bytes) else text.encode())


def replace_folder(made: Path, out: Path) -> None:
    """Move `made`, which is inside a hidden folder, to `out`.

    An existing folder changes places with it, in one step where the system can do that, and goes
    with the hidden folder. Raises OSError.
    """
    if not out.exists():
        os.rename(made, out)
    elif not _exchange(made, out):
        old = made.with_name(OLD)
        made.with_name(TARGET).write_text(str(out.absolute()), encoding="utf-8")
        os.rename(out, old)
        try:
            os.rename(made, out)
        except OSError:
            os.rename(old, out)
            raise


def _restore(left: Path) -> None:
    """Put a folder back that a killed run had moved away."""
    if (left / OLD).is_dir() and (left / TARGET).is_file():
        target = Path((left / TARGET).read_text(encoding="utf-8"))
        if not os.path.lexists(target):
            os.rename(left / OLD, target)


def _lock(folder: Path, wait: bool = False) -> int | None:
    """Lock a folder for as long as this process lives; None if another one has locked it.

    None too on systems that do not lock folders.
    """
    try:
        import fcntl
    except ImportError:  # pragma: no cover  (Windows)
        return None
    handle = None
    try:
        handle = os.open(folder, os.O_RDONLY)
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        _unlock(handle)
        return None
    return handle


def _unlock(handle: int | None) -> None:
    if handle is not None:
        os.close(handle)


def _without_locks(folder: Path) -> bool:
    """Whether the system does not lock folders and this one has not changed for a day."""
    return os.name == "nt" and time.time() - folder.stat().st_mtime > DAY


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two paths in one step (renameat2 of Linux); False if the system cannot."""
    with contextlib.suppress(OSError, AttributeError):
        library = ctypes.CDLL(None, use_errno=True)
        names = os.fsencode(one), os.fsencode(other)
        return bool(library.renameat2(HERE, names[0], HERE, names[1], EXCHANGE) == 0)
    return False
