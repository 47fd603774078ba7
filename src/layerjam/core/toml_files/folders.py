"""Folders that are written completely or not at all, and leftovers of killed runs."""

import contextlib
import os
import re
import shutil
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from layerjam.core.store import Appearing
from layerjam.core.system import lock_file

HIDDEN = re.compile(r"\.layerjam-(?:[0-9a-f]{16}|(?:report|dataset)-[0-9a-f]{32})")
"""Names of hidden folders; those that contain a word are from earlier versions."""
TARGET, OLD = "target", "old"
AT_FDCWD, EXCHANGE = -100, 2
DAY = 86_400.0


@contextlib.contextmanager
def make_hidden_folder(parent: Path) -> Iterator[Path]:
    """Create a hidden folder in `parent` in which to prepare another folder; remove it at the end.

    Hidden folders of killed runs in `parent` are removed first. Raises OSError.
    """
    clear_leftovers(parent)
    while True:
        folder = parent / f".layerjam-{os.urandom(8).hex()}"
        folder.mkdir()
        lock = _lock_folder(folder, wait=True)
        if folder.is_dir():  # another run may have removed it before it was locked
            break
        _unlock_folder(lock)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        _unlock_folder(lock)


def clear_leftovers(parent: Path) -> None:
    """Remove the hidden folders of killed runs, except those that a running process has locked.

    A folder that a killed run had moved away, to put a new one in its place, is restored.
    """
    with contextlib.suppress(OSError):
        for folder in [p for p in parent.iterdir() if HIDDEN.fullmatch(p.name)]:
            with contextlib.suppress(OSError):
                if folder.is_symlink() or not folder.is_dir():
                    continue
                lock = _lock_folder(folder)
                if lock is None and not _is_stale_without_locks(folder):
                    continue
                _restore_folder(folder)
                shutil.rmtree(folder, ignore_errors=True)
                _unlock_folder(lock)


def write_files(folder: Path, content: Mapping[str, str | bytes]) -> None:
    """Write files, {path inside `folder`: content}, and create their folders; raises OSError."""
    for name, text in content.items():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(text if isinstance(text, bytes) else text.encode())


def replace_folder(source: Path, out: Path) -> None:
    """Move `source`, which is inside a hidden folder, to `out`.

    A folder that exists at `out` is exchanged with `source`, atomically if the system supports
    that, and removed with the hidden folder. Raises OSError.
    """
    Appearing.begin()
    if not out.exists():
        os.rename(source, out)
    elif not _exchange_folders(source, out):
        old = source.with_name(OLD)
        source.with_name(TARGET).write_text(str(out.absolute()), encoding="utf-8")
        os.rename(out, old)
        try:
            os.rename(source, out)
        except OSError:
            os.rename(old, out)
            raise


def _restore_folder(left: Path) -> None:
    """Restore a folder that a killed run had moved away."""
    if (left / OLD).is_dir() and (left / TARGET).is_file():
        target = Path((left / TARGET).read_text(encoding="utf-8"))
        if not os.path.lexists(target):
            os.rename(left / OLD, target)


def _lock_folder(folder: Path, wait: bool = False) -> int | None:
    """Lock a folder while this process runs; return its handle, or None if this is impossible.

    Another process may have locked it, or the system may be unable to lock folders.
    """
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return None
    if lock_file(handle, wait):
        return handle
    os.close(handle)
    return None


def _unlock_folder(handle: int | None) -> None:
    if handle is not None:
        os.close(handle)


def _is_stale_without_locks(folder: Path) -> bool:
    """Return whether the system cannot lock folders and this one has not changed for a day."""
    return os.name == "nt" and time.time() - folder.stat().st_mtime > DAY


def _exchange_folders(first: Path, second: Path) -> bool:
    """Exchange two paths in one step (renameat2 on Linux); return False if the system cannot."""
    import ctypes

    with contextlib.suppress(OSError, AttributeError, TypeError):  # Windows rejects CDLL(None)
        library = ctypes.CDLL(None, use_errno=True)
        names = os.fsencode(first), os.fsencode(second)
        return bool(library.renameat2(AT_FDCWD, names[0], AT_FDCWD, names[1], EXCHANGE) == 0)
    return False
