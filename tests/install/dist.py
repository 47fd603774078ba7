"""Wheel and source archive, built twice with the same bytes and checked.

`python tests/install/dist.py FOLDER` builds them into a folder. Raises an error for files that
differ, that are missing or that do not belong there; `twine check` reads their metadata.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIBRARIES = 5
PROCESSORS = {"linux": 2, "darwin": 2, "win32": 1}
KERNELS = LIBRARIES * sum(PROCESSORS.values())
"""Five libraries for Linux and macOS on two processors each, and for Windows."""
REQUIRED = ("LICENSE", "layerjam/py.typed", "layerjam/__init__.pyi", "layerjam/_names.pyi")


def build(folder: Path, date: str) -> dict[str, bytes]:
    """{name: bytes} of the files, whose entries all have the date [s since 1970]."""
    words = (sys.executable, "-m", "hatchling", "build", "-d", str(folder))
    env = {**os.environ, "SOURCE_DATE_EPOCH": date}
    subprocess.run(words, cwd=ROOT, env=env, check=True, stdout=subprocess.DEVNULL)
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def contents(path: Path) -> list[str]:
    """Names of the files in a wheel or a source archive."""
    if path.suffix == ".whl":
        return zipfile.ZipFile(path).namelist()
    with tarfile.open(path) as archive:
        return archive.getnames()


def faults(names: list[str]) -> list[str]:
    """What is missing among names of files, and what does not belong there."""
    missing = [f"{end} is missing" for end in REQUIRED if not any(n.endswith(end) for n in names)]
    tests = [n for n in names if "tests" in Path(n).parts or Path(n).name.startswith("test_")]
    caches = [n for n in names if "__pycache__" in n]
    return [*missing, *(f"{name} does not belong there" for name in (*tests, *caches))]


def main() -> None:
    """Build, compare and check."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for old in (*folder.glob("layerjam-*.whl"), *folder.glob("layerjam-*.tar.gz")):
        old.unlink()
    commit = ("git", "log", "-1", "--format=%ct")
    date = subprocess.run(commit, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        files = build(Path(first), date.strip())
        if files != build(Path(second), date.strip()):
            raise SystemExit("two builds of the same sources differ")
    for name, data in files.items():
        (folder / name).write_bytes(data)
        if found := faults(contents(folder / name)):
            raise SystemExit(f"{name}: {'; '.join(found)}")
    (wheel,) = folder.glob("layerjam-*.whl")
    kernels = [name for name in contents(wheel) if "/kernel/built/" in name]
    systems = os.environ.get("LAYERJAM_SYSTEMS", "").split() or PROCESSORS
    due = LIBRARIES * sum(PROCESSORS[system] for system in systems)
    if len(kernels) != due:
        raise SystemExit(f"the wheel contains {len(kernels)} kernels instead of {due}")
    paths = [str(folder / name) for name in files]
    subprocess.run((sys.executable, "-m", "twine", "check", "--strict", *paths), check=True)


if __name__ == "__main__":
    main()
