"""The plugin `layerjam.brake`: compiled once for each version of MuJoCo, then loaded.

`import mujoco` calls `register` through the entry point of the group `mujoco.plugins`, so that a
model with a brake can be opened without any extra code.
"""

import ctypes
import sys
from pathlib import Path
from typing import Any

from layerjam.brake.kernel.compiler import SOURCES, build_library
from layerjam.core.errors import CompilerError, MissingExtraError

SOURCE = Path(__file__).parent / "c" / "mujoco_plugin.c"
_libraries: list[ctypes.CDLL] = []


def plugin() -> Path:
    """Return the plugin's library for the installed MuJoCo, compiled if it is not in the cache.

    Raises MissingExtraError if MuJoCo is missing, CompilerError if there is no C compiler or
    MuJoCo's library is not found.
    """
    mujoco = import_mujoco()
    home = Path(mujoco.HEADERS_DIR).parents[1]
    engine = [
        file
        for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll")
        for file in sorted(home.glob(pattern))
    ]
    if not engine:
        raise CompilerError(f"MuJoCo's library was not found next to its headers, in {home}")
    headers = Path(mujoco.HEADERS_DIR)
    return build_library(
        [SOURCE],  # the plugin's source includes the kernel
        includes=[SOURCES, headers.parent, headers],
        libraries=[str(engine[0])],
    )


def import_mujoco() -> Any:
    """Return the mujoco module; raises MissingExtraError if it is not installed."""
    with MissingExtraError.raise_if_missing("a brake in MuJoCo", "mujoco"):
        import mujoco
    return mujoco


def load() -> None:
    """Load the plugin into MuJoCo; a second call does nothing. Raises the errors of `plugin`."""
    if not _libraries:
        import_mujoco()  # MuJoCo may already have loaded the plugin through `register`
    if not _libraries:
        _libraries.append(ctypes.CDLL(str(plugin())))


def register() -> None:
    """Load the plugin when MuJoCo is imported; do nothing if there is no C compiler.

    `load`, `attach` and `layerjam export mujoco` report a missing compiler.
    """
    try:
        if not _libraries and "mujoco" in sys.modules:
            _libraries.append(ctypes.CDLL(str(plugin())))
    except CompilerError:
        return
