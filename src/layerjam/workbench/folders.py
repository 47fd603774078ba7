"""Temporary folders, deleted at the latest when the program next starts.

A folder contains a file that its program keeps locked. If the program is killed, the lock is
released, and the next workbench deletes the folder. On Windows, folders of killed programs remain,
because an open lock file cannot be renamed.
"""

import contextlib
import os
import shutil
import tempfile
import weakref
from pathlib import Path

from layerjam.core.system import lock_file

PREFIX = "layerjam-workbench-"
LOCK = ".in-use"


class Folder:
    """A new folder at `path`, deleted by `remove` or at exit."""

    def __init__(self) -> None:
        root = Path(tempfile.mkdtemp(prefix=PREFIX))
        self.path = root / "files"
        self.path.mkdir()
        making = root / f"{LOCK}-"
        lock = os.open(making, os.O_CREAT | os.O_RDWR, 0o600)
        if lock_file(lock):
            with contextlib.suppress(PermissionError):  # Windows cannot rename an open file
                making.replace(root / LOCK)  # a lock with this name is never unlocked
        self._end = weakref.finalize(self, _remove_folder, root, lock)

    def remove(self) -> None:
        """Delete the folder and its content."""
        self._end()


def _remove_folder(path: Path, lock: int) -> None:
    with contextlib.suppress(OSError):
        os.close(lock)
    shutil.rmtree(path, ignore_errors=True)


def remove_stale_folders() -> list[Path]:
    """Delete this user's folders left by killed programs, and return their paths."""
    removed_paths = []
    for path in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        # another workbench is also cleaning up, or the folder belongs to another user
        with contextlib.suppress(OSError):
            if _is_abandoned(path):
                shutil.rmtree(path, ignore_errors=True)
                removed_paths.append(path)
    return removed_paths


def _is_abandoned(path: Path) -> bool:
    """Return whether this user owns an unlocked folder; raises OSError if it has no lock file."""
    if path.is_symlink() or (hasattr(os, "getuid") and path.lstat().st_uid != os.getuid()):
        return False
    lock = os.open(path / LOCK, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
    try:
        return lock_file(lock)
    finally:
        os.close(lock)
