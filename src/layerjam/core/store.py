"""Files that are written completely or not at all."""

import contextlib
import functools
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import ParamSpec, TypeVar

from layerjam.core.errors import FileError
from layerjam.core.system import check_file_name, report_failure

P = ParamSpec("P")
R = TypeVar("R")


class Appearing:
    """Whether the files of a command have begun to appear; an interrupt is then too late."""

    begun = False
    interrupted = False
    """Whether an interrupt came before; some libraries drop the exception that it raises."""
    output_paths: frozenset[Path] = frozenset()
    """Paths that the user gave to the command."""

    @classmethod
    def begin(cls) -> None:
        """Make interrupts too late; raises KeyboardInterrupt if one was lost before."""
        cls.raise_lost_interrupt()
        cls.begun = True

    @classmethod
    def raise_lost_interrupt(cls) -> None:
        """Raise KeyboardInterrupt if an interrupt came and the command went on."""
        if cls.interrupted and not cls.begun:
            raise KeyboardInterrupt

    @classmethod
    def reset(cls, output_paths: Iterable[Path] = ()) -> None:
        """Begin a command with the paths that it was given."""
        cls.begun = cls.interrupted = False
        cls.output_paths = frozenset(output_paths)


def accept_force_option(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function accept `force` as the former name of its parameter `overwrite`."""

    @functools.wraps(function)
    def call(*args: P.args, **keywords: P.kwargs) -> R:
        if "force" in keywords:
            keywords["overwrite"] = keywords.pop("force")
        return function(*args, **keywords)

    return call


def store_file(
    path: str | Path, content: str | bytes | Callable[[Path], object], overwrite: bool = False
) -> Path:
    """Fill a temporary file next to `path`, then move it there in one step.

    `content` is the text (written as UTF-8), the bytes, or a function that fills the file at a
    path. Raises FileError, and leaves nothing behind, if the file cannot be written, or if it
    exists and `overwrite` is not set.
    """
    path = Path(path)
    check_file_name(path)
    with report_failure(path, "cannot be written"):
        exists = os.path.lexists(path)
    if exists and not overwrite:
        raise FileError(path, "already exists; --overwrite replaces it")
    if path.is_dir():
        raise FileError(path, "is a folder, not a file")
    with report_failure(path, "cannot be written"), contextlib.ExitStack() as leftovers:
        temporary = _make_temporary_file(path)
        leftovers.callback(temporary.unlink, missing_ok=True)
        if isinstance(content, str | bytes):
            temporary.write_bytes(content if isinstance(content, bytes) else content.encode())
        else:
            content(temporary)
        if path in Appearing.output_paths:
            Appearing.begin()
        os.replace(temporary, path)
    return path


def _make_temporary_file(path: Path) -> Path:
    """Create an empty file with a random name and the permissions of the user's umask."""
    name = f".{path.stem[:40]}-{os.urandom(8).hex()}{path.suffix}"
    path_of_file = path.with_name(name)
    # let the system apply the umask, because reading it would change it for the entire process
    os.close(os.open(path_of_file, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    return path_of_file
