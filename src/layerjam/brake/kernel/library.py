"""Compiled C library, or None, so that the caller's own Python is used instead."""

import contextlib
import ctypes
import functools
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from layerjam.brake.kernel.compiler import (
    build_library,
    cached_library,
    find_compiler,
    shipped_library,
)
from layerjam.brake.mechanics.compilation import announce_compilation
from layerjam.core.errors import CompilerError, QuantityError
from layerjam.core.threads import cache_threadsafe

SWITCH = "LAYERJAM_KERNEL"
"""Environment variable; `off` runs everything in Python or by JAX."""
LONGEST = 120.0
"""Maximum compile time [s]; gcc needs a second, the first run of ziglang half a minute."""


def is_switched_on() -> bool:
    """Return whether C may be used; raises QuantityError for any other LAYERJAM_KERNEL."""
    setting = os.environ.get(SWITCH, "")
    if setting not in ("", "on", "off"):
        raise QuantityError.of(SWITCH, f"'{setting}' is not allowed; set it to off, or unset it")
    return setting != "off"


def open_library(sources: Sequence[Path]) -> ctypes.CDLL:
    """Return the library that came with layerjam, or one compiled on this machine.

    Raises CompilerError if it cannot be compiled or loaded.
    """
    wheel_library = shipped_library(sources)
    if wheel_library is not None:
        with contextlib.suppress(OSError):  # it may be for a system with a different C library
            return ctypes.CDLL(str(wheel_library))
    path = cached_library(sources)
    if path is None:
        if find_compiler()[0] == sys.executable:  # ziglang takes seconds to start
            announce_compilation()
        path = build_library(sources, limit=LONGEST)
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise CompilerError(f"{path.stem} cannot be loaded: {error}") from None


_open_once = cache_threadsafe(open_library)
"""The digest of the sources takes as long as the pull of a small stack."""


def open_library_if_possible(sources: Sequence[Path], work: str) -> "ctypes.CDLL | None":
    """Return the library for some work, or None, with one line on stderr that says why.

    Raises QuantityError for an unknown value of LAYERJAM_KERNEL.
    """
    try:
        if is_switched_on():
            return _open_once(sources)
        reason = f"{SWITCH}=off; unset it"
    except CompilerError as error:
        reason = str(error)
    _announce(f"layerjam: {work} in Python, many times slower than in C: {reason}")
    return None


@functools.cache
def _announce(text: str) -> None:
    """Print a line once per process."""
    print(text, file=sys.stderr, flush=True)
