"""Through which files does a number travel? A command runs twice with one number changed.

A function counts if what it receives or returns differs between the runs, but not between two runs
with the same number. JAX runs without compiling for a typed number, so that numbers are seen inside
the laws too; reports would take too long that way and count the functions outside compiled laws.
FIRST and SECOND are texts that replace {} in the command, or folders that are copied to ./data,
which then replaces {}; quote patterns such as '{}/pull-*.csv'.
Usage: python tests/follow.py FIRST SECOND [--compiled] -- COMMAND...
    python tests/follow.py 1.2345678kg 1.2345679kg -- \
        drop choi2018-kapton --mass {} --speed 2.5m/s --vacuum 94.5kPa --figure a.svg
"""

from __future__ import annotations

import argparse
import collections
import enum
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

HOME = Path(__file__).resolve().parent.parent / "src" / "layerjam"
DEPTH, LONGEST = 5, 4000
OPTIMISED = 1
"""Flag of the code of a function, which that of a class or a module lacks."""


def fingerprint(value: Any, depth: int = DEPTH) -> str:
    """Return a text that differs if a number in a value differs."""
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | enum.Enum):
        return repr(value)
    if hasattr(value, "__array__"):
        try:
            array = np.asarray(value)
        except Exception:  # a value that JAX traces
            return type(value).__name__
        return f"{array.shape}{hashlib.md5(array.tobytes()).hexdigest()}"
    if depth == 0 or callable(value):
        return type(value).__name__
    if isinstance(value, list | tuple):
        return str([fingerprint(item, depth - 1) for item in value[:LONGEST]])
    if isinstance(value, set | frozenset):
        return str(sorted(fingerprint(item, depth - 1) for item in value))
    fields = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    return type(value).__name__ + str(
        [(fingerprint(k, 1), fingerprint(v, depth - 1)) for k, v in [*fields.items()][:LONGEST]]
    )


class Recorder:
    """Fingerprints of the arguments and results of layerjam's functions, as Python's profiler."""

    def __init__(self) -> None:
        self.seen: dict[str, set[str]] = {}
        self.is_busy = False

    def __call__(self, frame: FrameType, event: str, result: Any) -> None:
        code = frame.f_code
        ours = code.co_filename.startswith(str(HOME)) and code.co_flags & OPTIMISED
        if self.is_busy or not ours or event not in ("call", "return"):
            return
        self.is_busy = True
        count = code.co_argcount + code.co_kwonlyargcount
        names = (*code.co_varnames[:count], *code.co_freevars)
        values = [frame.f_locals.get(n) for n in names] if event == "call" else [result]
        text = event + "".join(map(fingerprint, values))
        key = f"{Path(code.co_filename).relative_to(HOME).as_posix()}:{code.co_qualname}"
        self.seen.setdefault(key, set()).add(hashlib.md5(text.encode()).hexdigest())
        self.is_busy = False


def record(out: str, words: list[str]) -> None:
    """Run a command in this process and write what its functions saw."""
    from layerjam.cli.main import main as layerjam

    sys.argv, recorder = ["layerjam", *words], Recorder()
    threading.setprofile(recorder)
    sys.setprofile(recorder)
    try:
        layerjam()
    except SystemExit as end:
        print("exit code", end.code or 0, file=sys.stderr)
    finally:
        sys.setprofile(None)
        threading.setprofile(None)
    Path(out).write_text(json.dumps({key: sorted(texts) for key, texts in recorder.seen.items()}))


def run(given: str, words: list[str], compiled: bool) -> dict[str, list[str]]:
    """Return what each function saw in a fresh process and folder."""
    with tempfile.TemporaryDirectory() as folder:
        text = given
        if Path(given).is_dir():
            shutil.copytree(given, Path(folder) / "data")
            text = "data"
        out = Path(folder) / "seen.json"
        command = [sys.executable, str(Path(__file__).resolve()), "--record", str(out)]
        settings = os.environ | {"PYTHONPATH": str(HOME.parent)}
        settings |= {} if compiled else {"JAX_DISABLE_JIT": "1"}
        line: list[str] = []
        for word in (word.replace("{}", text) for word in words):
            paths = sorted(Path(folder).glob(word)) if "*" in word else []
            line += [p.relative_to(folder).as_posix() for p in paths] or [word]
        subprocess.run([*command, "--", *line], cwd=folder, env=settings, check=True, stdout=-3)
        seen: dict[str, list[str]] = json.loads(out.read_text())
        return seen


def main() -> None:
    """Print the files with the number of their functions through which the number passes."""
    split = sys.argv.index("--")
    words = sys.argv[split + 1 :]
    if sys.argv[1] == "--record":
        return record(sys.argv[2], words)
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("first")
    parser.add_argument("second")
    parser.add_argument("--compiled", action="store_true", help="let JAX compile")
    args = parser.parse_args(sys.argv[1:split])
    given = (args.first, args.first, args.second)
    one, again, other = (run(text, words, args.compiled) for text in given)
    keys = {key for key in {*one, *other} if one.get(key) != other.get(key)}
    keys -= {key for key in {*one, *again} if one.get(key) != again.get(key)}
    files = collections.Counter(key.partition(":")[0] for key in keys)
    for name, count in sorted(files.items()):
        print(f"{count:4}  {name}")
    print(f"{len(keys)} functions in {len(files)} files")
    return None


if __name__ == "__main__":
    main()
