"""The plugin `layerjam.brake`: compiled once for each MuJoCo, and loaded.

`import mujoco` calls `register` through the entry point of the group `mujoco.plugins`, so that a
model with a brake opens without a line of code.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from typing import Any

from layerjam.errors import CompilerError, MissingExtraError
from layerjam.kernel.compiler import SOURCES, library

SOURCE = Path(__file__).parent / "c" / "mujoco_plugin.c"
_loaded: list[ctypes.CDLL] = []


def plugin() -> Path:
    """The plugin's library for the MuJoCo that is installed, compiled unless that was done before.

    Raises MissingExtraError without MuJoCo, CompilerError without a C compiler or where MuJoCo's
    own library is not found.
    """
    mujoco = installed()
    home = Path(mujoco.HEADERS_DIR).parents[1]
    engine = [
        file
        for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
        for file in sorted(home.glob(pattern))
    ]
    if not engine:
        raise CompilerError(f"MuJoCo's library is not beside its headers, in {home}")
    headers = Path(mujoco.HEADERS_DIR)
    return library(
        [SOURCE, SOURCES / "layerjam.c"],
        includes=[headers.parent, headers],
        libraries=[str(engine[0])],
    )


def installed() -> Any:
    """The module mujoco; MissingExtraError where it is not installed."""
    with MissingExtraError.raise_if_missing("a brake in MuJoCo", "mujoco"):
        import mujoco
    return mujoco


def load() -> None:
    """Load the plugin into MuJoCo; a second call does nothing. Raises as `plugin` does."""
    if not _loaded:
        installed()  # it may load the plugin itself, through `register`
    if not _loaded:
        _loaded.append(ctypes.CDLL(str(plugin())))


def register() -> None:
    """What MuJoCo calls when it is imported; without a C compiler there is no plugin, in silence.

    `load`, `attach` and `layerjam export mujoco` say so to whoever asks for it.
    """
    try:
        if not _loaded and "mujoco" in sys.modules:
            _loaded.append(ctypes.CDLL(str(plugin())))
    except CompilerError:
        return
