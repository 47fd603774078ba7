"""Compiled code kept between processes, and a message on stderr if compiling takes seconds."""

import functools
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from layerjam.core.store import Appearing

LONG = 2.0
"""JAX compile time after which a process prints a message [s]."""
THRESHOLDS = {
    "jax_persistent_cache_min_compile_time_secs": (1.0, 0.0),
    "jax_persistent_cache_min_entry_size_bytes": (0, -1),
}
"""{JAX setting: (default, value here)}; small programs are cached too, since hundreds add up."""
COMPILED = "/jax/core/compile/backend_compile_duration"
LOADED = "/jax/compilation_cache/cache_retrieval_time_sec"


@functools.cache
def keep_compiled_code() -> bool:
    """Let JAX keep compiled code in the user's cache folder; return whether this is possible.

    The settings do not change if the process has set its own folder for JAX's compiled code, or if
    no folder is writable.
    """
    import jax

    if jax.config.jax_compilation_cache_dir is not None:
        return False
    folder = find_user_cache("compiled")
    if folder is None:
        return False
    jax.config.update("jax_compilation_cache_dir", str(folder))
    for name, (default, threshold) in THRESHOLDS.items():
        if getattr(jax.config, name) == default:
            jax.config.update(name, threshold)
    jax.monitoring.register_event_duration_secs_listener(_Stopwatch().count)
    return True


def find_user_cache(name: str) -> Path | None:
    """Return a folder in the user's cache, else in the temporary folder, else None.

    The folder belongs to the user, so nobody else can replace the code in it.
    """
    import platformdirs

    user = os.getuid() if hasattr(os, "getuid") else None
    for folder in (
        Path(platformdirs.user_cache_dir("layerjam")) / name,
        Path(tempfile.gettempdir()) / f"layerjam-{name}-{user or 0}",
    ):
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if os.access(folder, os.W_OK) and user in (None, folder.stat().st_uid):
                return folder
        except OSError:
            continue
    return None


@functools.cache
def announce_compilation() -> None:
    """Print once per process that a first call compiles; not in a thread after an interrupt."""
    Appearing.raise_lost_interrupt()
    print("layerjam: compiling, once per machine", file=sys.stderr, flush=True)


class _Stopwatch:
    """Time that JAX has spent compiling in this process, excluding reading of compiled code."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def count(self, event: str, duration_secs: float, **_: Any) -> None:
        """Add the duration of one JAX event [s]."""
        if event in (COMPILED, LOADED):
            self.seconds += duration_secs if event == COMPILED else -duration_secs
            if self.seconds > LONG:
                announce_compilation()
