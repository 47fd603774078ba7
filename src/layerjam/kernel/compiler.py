"""The machine's C compiler, and libraries built by it once and kept."""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from layerjam.errors import CompilerError

SOURCES = Path(__file__).parent / "c"
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno")
"""No contraction: a fused multiply-add would give other last bits on other processors."""
KNOWN = ("cc", "gcc", "clang")
ENDINGS = {"darwin": ".dylib", "win32": ".dll"}


def compiler() -> tuple[str, ...]:
    """The command of a C compiler: $CC, cc, gcc, clang, or that of the Python package ziglang.

    Raises CompilerError where there is none.
    """
    on_path = compiler_on_path()
    if on_path is not None:
        return on_path
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc")
    raise CompilerError('no C compiler found: install gcc or clang, or pip install "layerjam[fmu]"')


def compiler_on_path() -> tuple[str, ...] | None:
    """The command of $CC, cc, gcc or clang; None where none of them is installed.

    Raises CompilerError where $CC names what is not there.
    """
    named = _words(os.environ.get("CC", ""))
    if named:
        if shutil.which(named[0]) is None:
            raise CompilerError(f"CC: '{named[0]}' is not found; name a C compiler, or unset CC")
        return tuple(named)
    return next(((name,) for name in KNOWN if shutil.which(name) is not None), None)


def _words(text: str) -> list[str]:
    """The words of a command as it would be typed; a backslash parts folders on Windows."""
    if os.name != "nt":
        return shlex.split(text)
    return [word.strip('"') for word in shlex.split(text, posix=False)]


@functools.cache
def version(command: tuple[str, ...]) -> str:
    """What the compiler says of itself, first line."""
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return (done.stdout or done.stderr).strip().split("\n")[0]


def cache() -> Path:
    """The folder where libraries are kept: the user's cache, else the system's for short files."""
    import platformdirs

    for folder in (
        Path(platformdirs.user_cache_dir("layerjam")) / "interop",
        Path(tempfile.gettempdir()) / f"layerjam-interop-{os.getuid() if _has_users() else 0}",
    ):
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError:
            continue
        if os.access(folder, os.W_OK) and _is_ours(folder):
            return folder
    raise CompilerError("no folder to keep a compiled library in: set XDG_CACHE_HOME to one")


def _has_users() -> bool:
    return hasattr(os, "getuid")


def _is_ours(folder: Path) -> bool:
    """Nobody else may put a library there that we would load."""
    return not _has_users() or folder.stat().st_uid == os.getuid()


def cross_compiler(target: str) -> tuple[str, ...]:
    """The command that compiles for another machine, such as "aarch64-macos".

    Raises CompilerError without the Python package ziglang, which alone knows them all.
    """
    if importlib.util.find_spec("ziglang") is None:
        raise CompilerError(
            f'no compiler for {target} found: pip install "layerjam[fmu]", or leave it out'
        )
    return (sys.executable, "-m", "ziglang", "cc", "-target", target)


def library(
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
    """The path of a shared library of C sources, compiled unless that was done before.

    Every file beside the sources and in `includes` counts: when one changes, or the compiler does,
    it is compiled again. `target` names another machine than this one, as `cross_compiler` takes
    it. Raises CompilerError with what the compiler said, or where it takes longer than `limit` [s].
    """
    command = compiler() if target is None else cross_compiler(target)
    more = [*FLAGS, *flags, *(f"-D{name}" for name in defines)]
    ending = ending or ENDINGS.get(sys.platform, ".so")
    made_by = hashlib.sha256("\n".join([*command, version(command)]).encode()).hexdigest()[:12]
    name = _name(sources, includes, [*more, *libraries])
    kept = cache() / f"{name}-{made_by}{ending}"
    if not kept.exists():
        shared = ["-shared"] if ending == ENDINGS["win32"] else ["-shared", "-fPIC"]
        about = [f"-I{folder}" for folder in _folders(sources, includes)]
        made = [*command, *more, *shared, *about, *map(str, sources)]
        build(made, kept, libraries=(*libraries, "-lm"), limit=limit)
    return kept


def built(sources: Sequence[Path], defines: Sequence[str] = ()) -> Path | None:
    """A library of these sources that was compiled before, by whichever compiler; None if none."""
    name = _name(sources, (), [*FLAGS, *(f"-D{one}" for one in defines)])
    found = cache().glob(f"{name}-*{ENDINGS.get(sys.platform, '.so')}")
    return min(found, default=None)


def _folders(sources: Sequence[Path], includes: Sequence[Path]) -> list[Path]:
    return list(dict.fromkeys([*(source.parent for source in sources), *includes]))


def _name(sources: Sequence[Path], includes: Sequence[Path], more: Sequence[str]) -> str:
    """The name of a library, which says what it is made of and for which machine."""
    said = [sys.platform, platform.machine(), *more, *(source.name for source in sources)]
    stamp = hashlib.sha256("\n".join(said).encode())
    for folder in _folders(sources, includes):
        for file in sorted(folder.glob("*.[ch]")):
            stamp.update(file.name.encode() + file.read_bytes())
    return f"{sources[0].stem}-{stamp.hexdigest()[:24]}"


def build(
    command: Sequence[str],
    target: Path,
    *,
    libraries: Sequence[str] = (),
    limit: float | None = None,
) -> None:
    """Run a compiler that writes `target`, whole or not at all; CompilerError with what it says.

    One that takes longer than `limit` [s] is stopped; that is a CompilerError, too.
    """
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".build-") as folder:
        made = Path(folder) / target.name
        words = [*command, "-o", str(made), *libraries]
        try:
            done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=limit)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise CompilerError(f"{command[0]} cannot build {target.stem}: {error}") from None
        if done.returncode or not made.exists():
            said = "\n".join((done.stderr or done.stdout).strip().split("\n")[:12])
            raise CompilerError(f"{command[0]} cannot build {target.stem}: {said}")
        os.replace(made, target)
