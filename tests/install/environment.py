"""An environment that holds the built wheel and chosen dependencies, and nothing else."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
import zipfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import (
    Distribution,
    PackageNotFoundError,
    PathDistribution,
    distribution,
)
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]


def built(folder: Path) -> Path:
    """The wheel that pip builds from this checkout, without a download."""
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check")
    words = [sys.executable, "-m", "pip", "wheel", "-q", *options, "-w", str(folder), str(ROOT)]
    subprocess.run(words, check=True, env=bare(), timeout=60)
    (wheel,) = folder.glob("*.whl")
    return wheel


def bare() -> dict[str, str]:
    """This process's environment without what would let an installation see this checkout."""
    apart = ("PYTHON", "PYTEST", "NICEGUI", "LAYERJAM", "VIRTUAL_ENV")
    return {k: v for k, v in os.environ.items() if not k.startswith(apart)}


def required(wheel: Path, extras: tuple[str, ...]) -> dict[str, Distribution]:
    """What a wheel needs of other distributions, taken from what is installed here.

    The wheel's own metadata say it. Raises LookupError for what is not installed here, or in
    another version than is asked for.
    """
    found: dict[str, Distribution] = {}
    (inside,) = (p for p in zipfile.Path(wheel).iterdir() if p.name.endswith(".dist-info"))
    ours = PathDistribution(inside)
    waiting = list(_follow(ours, set(extras)))
    seen: set[str] = set()
    while waiting:
        wanted = waiting.pop()
        if str(wanted) in seen:
            continue
        seen.add(str(wanted))
        if wanted.name == "layerjam":
            waiting.extend(_follow(ours, wanted.extras))
            continue
        try:
            here = distribution(wanted.name)
        except PackageNotFoundError:
            raise LookupError(f"{wanted} is not installed here") from None
        if wanted.specifier and not wanted.specifier.contains(here.version, prereleases=True):
            raise LookupError(f"{wanted} is asked for, {here.version} is here")
        found[here.metadata["Name"].lower()] = here
        waiting.extend(_follow(here, wanted.extras))
    return found


def _follow(here: Distribution, extras: set[str]) -> Iterator[Requirement]:
    for text in here.requires or ():
        inner = Requirement(text)
        cases = [{"extra": name} for name in ("", *extras)]
        if inner.marker is None or any(inner.marker.evaluate(case) for case in cases):
            yield inner


def link(dists: dict[str, Distribution], folder: Path) -> None:
    """Fill a folder with links to the files of distributions, as `pip install` would copy them."""
    tops = {
        name: {p.parts[0] for p in d.files or () if p.parts[0] != ".."} for name, d in dists.items()
    }
    shared = {top for top, n in Counter(t for some in tops.values() for t in some).items() if n > 1}
    folder.mkdir()
    for name, dist in dists.items():
        for top in tops[name] - shared - {"__pycache__"}:
            (folder / top).symlink_to(Path(str(dist.locate_file(top))).resolve())
        for path in dist.files or ():
            if path.parts[0] in shared and path.parts[0] != "__pycache__":
                at = folder / path
                at.parent.mkdir(parents=True, exist_ok=True)
                if not at.exists():
                    at.symlink_to(Path(str(dist.locate_file(path))).resolve())


@dataclass(frozen=True)
class Environment:
    """A virtual environment with the wheel in it; which other distributions it sees can change."""

    folder: Path
    wheel: Path

    @property
    def python(self) -> Path:
        return self.folder / "bin" / "python"

    def offer(self, *extras: str) -> set[str]:
        """Let the environment see what the wheel with these extras requires, and nothing more."""
        at = self.folder / f"dists-{'-'.join(extras)}"
        dists = required(self.wheel, extras)
        if not at.exists():
            link(dists, at)
        (pure,) = self.folder.glob("lib/python*/site-packages")
        (pure / "offered.pth").write_text(f"{at}\n", encoding="utf-8")
        return set(dists)

    def install(self, *extras: str) -> subprocess.CompletedProcess[str]:
        """Let pip install the wheel with extras where no index can be asked."""
        words = f"{self.wheel}[{','.join(extras)}]" if extras else str(self.wheel)
        return self._run(
            sys.executable,
            "-m",
            "pip",
            "--python",
            str(self.python),
            "install",
            "-q",
            "--no-index",
            "--disable-pip-version-check",
            words,
        )

    def run(self, *words: str) -> subprocess.CompletedProcess[str]:
        """One `layerjam` command, typed in an empty folder."""
        return self._run(str(self.folder / "bin" / "layerjam"), *words)

    def code(self, text: str) -> subprocess.CompletedProcess[str]:
        """A few lines of Python."""
        return self._run(str(self.python), "-c", text)

    def holds(self) -> list[str]:
        """Names of the files in the wheel."""
        return zipfile.ZipFile(self.wheel).namelist()

    @property
    def work(self) -> Path:
        """The folder where commands are typed."""
        return self.folder / "work"

    def clean(self) -> None:
        """Remove what a command wrote by the name `new`."""
        for path in self.work.glob("new*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def env(self) -> dict[str, str]:
        """Variables of its processes: caches of its own."""
        return {**bare(), "XDG_CACHE_HOME": str(self.folder / "cache")}

    def _run(self, *words: str) -> subprocess.CompletedProcess[str]:
        self.work.mkdir(exist_ok=True)
        return subprocess.run(
            words,
            cwd=self.work,
            env=self.env(),
            text=True,
            capture_output=True,
            timeout=120,
            check=False,
        )


def environment(folder: Path) -> Environment:
    """A new environment that sees the core's dependencies; the wheel is not installed yet."""
    made = folder / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(made)], check=True)
    one = Environment(made, built(folder / "wheel"))
    one.offer()
    return one


def _read(address: str) -> str:
    with urllib.request.urlopen(address, timeout=20) as page:
        return str(page.read().decode())


def serving(one: Environment) -> str:
    """The page that the workbench serves in an environment, which is ended then."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = (str(one.folder / "bin" / "layerjam"), "workbench", "--no-show", "--port", str(port))
    with subprocess.Popen(
        words, cwd=one.work, env=one.env(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as server:
        try:
            for _ in range(300):
                with contextlib.suppress(OSError):
                    return _read(f"http://127.0.0.1:{port}/")
                if server.poll() is not None:
                    break
                time.sleep(0.1)
            raise AssertionError(f"no page: {server.stderr.read() if server.poll() else 'silent'}")
        finally:
            server.terminate()
