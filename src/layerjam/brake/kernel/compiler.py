"""The machine's C compiler, and a cache of the libraries that it builds."""

import functools
import hashlib
import importlib.util
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Sequence
from pathlib import Path

from layerjam.brake.mechanics.compilation import find_user_cache
from layerjam.core.errors import CompilerError
from layerjam.core.installation import install_command

SOURCES = Path(__file__).parent / "c"
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")
"""Compiler flags without fused multiply-adds, whose last bits differ between processors."""
LONGEST = 400
"""Maximum length of a compiler's message in an error [characters]."""
KNOWN = ("cc", "gcc", "clang")
ENDINGS = {"darwin": ".dylib", "win32": ".dll"}
KERNEL = (SOURCES / "layerjam.c", SOURCES / "history.c")
STOPS = (SOURCES / "stops.c",)
"""Loop over many stops. It compiles four times as long, and a first pull does not need it."""
STACK = (SOURCES / "stack.c",)
"""Loops of the sheet-by-sheet model, printed from those in Python."""
LOOPS = (SOURCES / "loops" / "loops.c",)
"""Closed loops of the controller, printed from those in Python."""
SHADING = (SOURCES / "shading" / "shading.c",)
LIBRARIES = (KERNEL, STOPS, STACK, LOOPS, SHADING)
"""Sources of each library, compiled when first used; the folder of its first file is its own."""
SHIPPED = Path(__file__).parent / "built"
"""Folder of the libraries in a wheel, which `hatch_build.py` compiles."""
TARGETS = {
    ("linux", "x86_64"): "x86_64-linux-gnu.2.17",
    ("linux", "aarch64"): "aarch64-linux-gnu.2.17",
    ("win32", "AMD64"): "x86_64-windows-gnu",
    ("darwin", "x86_64"): "x86_64-macos",
    ("darwin", "arm64"): "aarch64-macos",
}
"""{(sys.platform, platform.machine()): target of the cross-compiler}."""


def find_compiler() -> tuple[str, ...]:
    """Return the command of a C compiler: $CC, cc, gcc, clang, or of the Python package ziglang.

    Raises CompilerError if there is none.
    """
    on_path = find_on_path()
    if on_path is not None:
        return on_path
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    raise CompilerError(f"no C compiler found: install gcc or clang, or {install_command('fmu')}")


def find_on_path() -> tuple[str, ...] | None:
    """Return the command in $CC, or cc, gcc or clang; None if none is installed.

    Raises CompilerError if $CC names a command that does not exist.
    """
    words = _split_command(os.environ.get("CC", ""))
    if words:
        if shutil.which(words[0]) is None:
            raise CompilerError(f"CC: '{words[0]}' was not found; correct or unset CC")
        return tuple(words)
    return next(((name,) for name in KNOWN if shutil.which(name) is not None), None)


def _split_command(text: str) -> list[str]:
    """Return the words of a typed command; on Windows, a backslash is not an escape character."""
    if os.name != "nt":
        return shlex.split(text)
    return [word.strip('"') for word in shlex.split(text, posix=False)]


@functools.cache
def read_version(command: tuple[str, ...]) -> str:
    """Return the first line of the compiler's version message."""
    run = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return (run.stdout or run.stderr).strip().split("\n")[0]


def library_folder() -> Path:
    """Return the folder of the libraries: the user's cache, else the system's temporary folder."""
    folder = find_user_cache("interop")
    if folder is None:
        raise CompilerError("no folder for compiled libraries: set XDG_CACHE_HOME to a folder")
    return folder


def find_cross_compiler(target: str) -> tuple[str, ...]:
    """Return the command that compiles for a different machine, such as "aarch64-macos".

    Raises CompilerError if the Python package ziglang, the only cross-compiler, is missing.
    """
    if importlib.util.find_spec("ziglang") is None:
        raise CompilerError(
            f"no compiler for {target} found: {install_command('fmu')}, or omit this target"
        )
    return (sys.executable, "-m", "ziglang", "cc", "-target", target)


def build_library(
    sources: Sequence[Path],
    defines: Sequence[str] = (),
    *,
    flags: Sequence[str] = (),
    includes: Sequence[Path] = (),
    libraries: Sequence[str] = (),
    ending: str = "",
    target: str | None = None,
    limit: float | None = None,
) -> Path:
    """Return the path of a shared library of C sources; compile it unless it is in the cache.

    A change to a file in the source folders or in `includes`, or to the compiler, triggers
    recompilation. `target` names a different machine, as in `find_cross_compiler`. Raises
    CompilerError with the compiler's message, or if compiling takes longer than `limit` [s].
    """
    command = find_compiler() if target is None else find_cross_compiler(target)
    options = [*FLAGS, *flags, *(f"-D{name}" for name in defines)]
    ending = ending or ENDINGS.get(sys.platform, ".so")
    made_by = hashlib.sha256("\n".join([*command, read_version(command)]).encode()).hexdigest()[:12]
    name = _library_name(sources, includes, [*options, *libraries])
    path = library_folder() / f"{name}-{made_by}{ending}"
    if not path.exists():
        kind = ["-shared"] if ending == ENDINGS["win32"] else ["-shared", "-fPIC"]
        folders = [f"-I{folder}" for folder in _source_folders(sources, includes)]
        words = [*command, *options, *kind, *folders, *map(str, sources)]
        run_compiler(words, path, libraries=(*libraries, "-lm"), limit=limit)
    return path


def shipped_library(sources: Sequence[Path], defines: Sequence[str] = ()) -> Path | None:
    """Return the library of exactly these sources that came with layerjam, or None."""
    path = SHIPPED / engine_name(sources, defines, (sys.platform, platform.machine()))
    return path if path.exists() else None


def engine_name(sources: Sequence[Path], defines: Sequence[str], machine: tuple[str, str]) -> str:
    """Return the file name of a library for a machine, with a digest of sources and options."""
    name = _library_name(sources, (), [*FLAGS, *(f"-D{d}" for d in defines)], machine)
    return name + ENDINGS.get(machine[0], ".so")


def cached_library(sources: Sequence[Path], defines: Sequence[str] = ()) -> Path | None:
    """Return a cached library of these sources, built by any compiler, or None."""
    name = _library_name(sources, (), [*FLAGS, *(f"-D{d}" for d in defines)])
    paths = library_folder().glob(f"{name}-*{ENDINGS.get(sys.platform, '.so')}")
    return min(paths, default=None)


def _source_folders(sources: Sequence[Path], includes: Sequence[Path]) -> list[Path]:
    return list(dict.fromkeys([*(source.parent for source in sources), *includes]))


def _library_name(
    sources: Sequence[Path],
    includes: Sequence[Path],
    options: Sequence[str],
    machine: tuple[str, str] | None = None,
) -> str:
    """Return a library's name with a digest of its sources and machine (this one if None)."""
    machine = machine or (sys.platform, platform.machine())
    parts = [*machine, *options, *(source.name for source in sources)]
    stamp = hashlib.sha256("\n".join(parts).encode())
    for folder in _source_folders(sources, includes):
        for file in sorted(folder.glob("*.[ch]")):
            stamp.update(file.name.encode() + file.read_bytes())
    return f"{sources[0].stem}-{stamp.hexdigest()[:24]}"


def run_compiler(
    command: Sequence[str],
    target: Path,
    *,
    libraries: Sequence[str] = (),
    limit: float | None = None,
) -> None:
    """Run a compiler; `target` is written completely or not at all.

    Raises CompilerError with the compiler's message, or if compiling takes longer than `limit` [s].
    """
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".build-") as folder:
        output = Path(folder) / target.name
        words = [*command, "-o", str(output), *libraries]
        try:
            run = subprocess.run(words, capture_output=True, text=True, check=False, timeout=limit)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise CompilerError(f"{command[0]} cannot build {target.stem}: {error}") from None
        if run.returncode == -signal.SIGINT:  # Ctrl-C also reaches the compiler
            raise KeyboardInterrupt
        if run.returncode or not output.exists():
            lines = (run.stderr or run.stdout).strip().split("\n")
            errors = [line for line in lines if "error" in line] or lines
            message = textwrap.shorten(" ".join(errors), LONGEST, placeholder=" ...")
            raise CompilerError(f"{command[0]} cannot build {target.stem}: {message}")
        os.replace(output, target)
