"""The C kernel as WebAssembly, for one brake on a page in a browser.

The module lies next to its source `c/web/web.c`, so that no checkout or wheel needs a compiler. Its
name contains a digest of the sources: after a change, `read_module` compiles them if the package
ziglang is installed, and `python -m layerjam.brake.kernel.web` replaces the stored module.
"""

import hashlib
import re
from pathlib import Path

from layerjam.brake.kernel.compiler import (
    FLAGS,
    SOURCES,
    find_cross_compiler,
    library_folder,
    run_compiler,
)

FOLDER = SOURCES / "web"
TARGET = "wasm32-freestanding"
CODE = (
    FOLDER / "web.c",
    *(SOURCES / f for f in ("layerjam.c", "layerjam.h", "formulas.h", "stop_formulas.h")),
)
"""Source, and the files that it includes."""
OPTIONS = (*FLAGS, "-Dsqrt=__builtin_sqrt", "-g0", "-s", "-nostdlib", f"-I{SOURCES}")
"""Compiler options; the square root is an instruction, and the page supplies `pow`."""
LINKING = ("-Wl,--no-entry", "-Wl,--import-symbols")


def find_stored_module() -> Path:
    """Return the path of the stored module of the present sources; it may not exist."""
    texts = (path.read_text(encoding="utf-8") for path in CODE)
    code = " ".join(re.sub(r"/\*.*?\*/", "", "\n".join(texts), flags=re.DOTALL).split())
    options = [TARGET, *OPTIONS[:-1], *LINKING]
    digest = hashlib.sha256("\n".join([*options, code]).encode()).hexdigest()
    return FOLDER / f"kernel-{digest[:16]}.wasm"


def build_module(path: Path) -> None:
    """Compile the module; raises CompilerError if the Python package ziglang is missing."""
    words = [*find_cross_compiler(TARGET), *OPTIONS, str(CODE[0]), *LINKING]
    run_compiler(words, path)
    path.chmod(0o644)  # linkers mark it as executable


def read_module() -> bytes:
    """Return the module: the stored one, or else one compiled on this machine.

    Raises CompilerError if the sources changed and the Python package ziglang is missing.
    """
    path = find_stored_module()
    if not path.exists():
        path = library_folder() / path.name
    if not path.exists():
        build_module(path)
    return path.read_bytes()


if __name__ == "__main__":
    for old in FOLDER.glob("*.wasm"):
        old.unlink()
    build_module(find_stored_module())
