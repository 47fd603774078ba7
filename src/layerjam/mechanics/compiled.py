"""Numba's loops: a line when one is compiled, and when it is compiled again."""

import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from numba.core import event

from layerjam.mechanics.compilation import announce, keep_compiled_code


class _Announcer(event.Listener):  # type: ignore[misc]
    """Announces the loops that numba compiles and caches; each takes seconds."""

    def on_start(self, event: Any) -> None:
        if event.data["dispatcher"]._cache.cache_path is not None and keep_compiled_code():
            announce()

    def on_end(self, event: Any) -> None:
        pass


event.register("numba:compile", _Announcer())  # type: ignore[no-untyped-call]


def stamp_of(files: Iterable[Path]) -> str:
    """Return a hash that changes with the files.

    Numba's cache notices changes only in the compiled file. A loop that refers to the stamp of all
    its source files is compiled again if any of them has changed.
    """
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()
