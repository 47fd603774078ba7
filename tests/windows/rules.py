"""Windows' rules for files, pipes and the console, imposed on this process.

What is imposed: names that Windows does not take, paths beyond 259 characters, CRLF in text files,
no replacing, renaming or deleting of a file that this
process has open, no replacing of folders, a console that cannot print every letter, and nothing of
what POSIX alone has.
"""

from __future__ import annotations

import builtins
import ctypes
import fcntl
import io
import ntpath
import os
import signal
import struct
import sys
import types
from collections.abc import Callable
from pathlib import Path, PureWindowsPath
from typing import Any

import pytest

from layerjam.bench.rig import child
from layerjam.core import system

POSIX = ("geteuid", "getuid", "getgid", "set_blocking", "sched_getaffinity", "fork", "openpty")
SIGNALS = ("SIGKILL", "SIGALRM", "SIGHUP")
MODULES = ("fcntl", "grp", "pty", "pwd", "resource", "termios", "tty")


def is_reserved(name: str) -> bool:
    """Whether Windows keeps a name for a device, as Python itself has it."""
    if sys.version_info >= (3, 13):
        return ntpath.isreserved(name)
    return PureWindowsPath(name).is_reserved()


def taken(path: Any) -> None:
    """Raise what Windows answers to a name that it does not take."""
    if not isinstance(path, str | os.PathLike):
        return
    text = os.fspath(path)
    if not isinstance(text, str) or text.startswith(("/proc", "/dev", "/sys")):
        return
    if len(os.path.abspath(text)) >= 260:
        raise FileNotFoundError(2, "The system cannot find the path specified", text)
    for name in Path(text).parts[1:]:
        reserved = is_reserved(name) or name != name.rstrip(". ")
        if name != ".." and (reserved or set(name) & set('<>:"|?*')):
            raise OSError(22, "Invalid argument", text)


def held(path: Any) -> bool:
    """Whether this process has a file open, or one inside a folder."""
    full = os.path.realpath(path)
    for descriptor in os.listdir("/proc/self/fd"):
        try:
            target = os.readlink(f"/proc/self/fd/{descriptor}")
        except OSError:
            continue
        if (target == full or target.startswith(full + "/")) and not os.path.isdir(target):
            return True
    return False


def opening(real: Callable[..., Any]) -> Callable[..., Any]:
    """`open` as Windows has it."""

    def made(
        file: Any,
        mode: str = "r",
        buffering: int = -1,
        encoding: str | None = None,
        errors: str | None = None,
        newline: str | None = None,
        **rest: Any,
    ) -> Any:
        taken(file)
        if "b" not in mode and newline is None and set(mode) & set("wax+"):
            newline = "\r\n"
        return real(file, mode, buffering, encoding, errors, newline, **rest)

    return made


def locking(file: int, mode: int, length: int) -> None:
    """`msvcrt.locking`: of the bytes from a file's position on, and refused to other openings."""
    begin = os.lseek(file, 0, os.SEEK_CUR)
    assert begin < 2**31, "its position is a C long"
    span = struct.pack("hhqqi", fcntl.F_WRLCK, os.SEEK_SET, begin, length, 0)
    fcntl.fcntl(file, fcntl.F_OFD_SETLKW if mode == LK_LOCK else fcntl.F_OFD_SETLK, span)


LK_LOCK, LK_NBLCK = 1, 2


def library(name: str, *words: Any, **rest: Any) -> Any:
    """`ctypes.CDLL`: there is no library of the process itself."""
    if name is None:
        raise TypeError("argument of type 'NoneType' is not iterable")
    return LIBRARY(name, *words, **rest)


LIBRARY = ctypes.CDLL


def impose(patch: pytest.MonkeyPatch) -> None:
    """All of it, until the test ends."""
    replace, rename, unlink, mkdir = os.replace, os.rename, os.unlink, os.mkdir

    def replaces(source: Any, target: Any, **rest: Any) -> None:
        taken(target)
        if held(source) or held(target) or os.path.isdir(target):
            raise PermissionError(13, "Access is denied", os.fspath(source), 5, os.fspath(target))
        replace(source, target, **rest)

    def renames(source: Any, target: Any, **rest: Any) -> None:
        taken(target)
        if os.path.lexists(target):
            raise FileExistsError(17, "Cannot create a file when that file already exists")
        if held(source):
            raise PermissionError(13, "Access is denied", os.fspath(source), 5, os.fspath(target))
        rename(source, target, **rest)

    def unlinks(path: Any, *, dir_fd: int | None = None) -> None:
        full = path if dir_fd is None else f"/proc/self/fd/{dir_fd}/{path}"
        if held(full):
            raise PermissionError(13, "The process cannot access the file", os.fspath(path))
        unlink(path, dir_fd=dir_fd)

    def mkdirs(path: Any, *more: Any, **rest: Any) -> None:
        taken(path)
        mkdir(path, *more, **rest)

    patch.setattr(builtins, "open", opening(builtins.open))
    patch.setattr(io, "open", opening(io.open))
    for name, made in (("replace", replaces), ("rename", renames), ("unlink", unlinks),
                       ("remove", unlinks), ("mkdir", mkdirs), ("linesep", "\r\n")):  # fmt: skip
        patch.setattr(os, name, made)
    for name in POSIX:
        patch.delattr(os, name, raising=False)
    for name in SIGNALS:
        patch.delattr(signal, name, raising=False)
    for name in MODULES:
        patch.setitem(sys.modules, name, None)
    msvcrt = types.SimpleNamespace(locking=locking, LK_LOCK=LK_LOCK, LK_NBLCK=LK_NBLCK)
    patch.setitem(sys.modules, "msvcrt", msvcrt)
    patch.setattr(ctypes, "CDLL", library)
    patch.setattr(system, "WINDOWS", True)
    patch.setattr(child, "PIPES", False)


class Console:
    """Standard output and error as a console or a file of one code page has them."""

    def __init__(self, patch: pytest.MonkeyPatch, page: str) -> None:
        self.page = page
        self._out, self._err = io.BytesIO(), io.BytesIO()
        patch.setattr(sys, "stdout", io.TextIOWrapper(self._out, page, "strict", newline="\r\n"))
        said = io.TextIOWrapper(self._err, page, "backslashreplace", newline="\r\n")
        patch.setattr(sys, "stderr", said)

    def said(self) -> tuple[str, str]:
        """What was printed since the last time, to output and error."""
        texts = []
        for stream, raw in ((sys.stdout, self._out), (sys.stderr, self._err)):
            stream.flush()
            texts.append(raw.getvalue().decode(self.page).replace("\r\n", "\n"))
            raw.seek(0)
            raw.truncate()
        return texts[0], texts[1]
