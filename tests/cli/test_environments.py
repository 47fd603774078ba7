"""The same numbers in every environment: locale, time zone, folders, caches and no network."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import layerjam

FORCE = ("force", "choi2018-kapton", "--slip", "20mm", "--vacuum", "94.5kPa", "--json")
FIGURE = ("show", "choi2018-kapton", "--json", "--figure", "größe µ.svg")
PLACES = {
    "turkish": {"LANG": "tr_TR.UTF-8", "LC_ALL": "tr_TR.UTF-8"},
    "ascii": {"LANG": "C", "LC_ALL": "C"},
    "kolkata": {"TZ": "Asia/Kolkata"},
    "no home": {
        "HOME": "/proc/none",
        "XDG_CACHE_HOME": "/proc/none",
        "XDG_CONFIG_HOME": "/proc/none",
    },
}


READ_ONLY = (
    *("unshare", "--mount", "--propagation", "private", "sh", "-ec"),
    'mount --bind "$0" "$0"; mount -o remount,bind,ro "$0"; test ! -w "$0"; exec "$@"',
    str(Path(layerjam.__file__).parents[1]),
)
"""Start of a command that sees the source on a read-only disk."""


def run(folder: Path, words: tuple[str, ...], *, after: Sequence[str] = (), **more: str) -> object:
    """The answer of a command in a folder; it must end well."""
    here = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"} | more
    line = [*after, sys.executable, "-m", "layerjam", *words]
    done = subprocess.run(line, cwd=folder, env=here, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> list[object]:
    """The answers in this environment."""
    folder = tmp_path_factory.mktemp("usual")
    return [run(folder, words) for words in (FORCE, FIGURE)]


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_the_numbers_are_the_same(place: str, tmp_path: Path, usual: list[object]) -> None:
    folder = tmp_path / "Bau  Größe µ"
    folder.mkdir()
    assert [run(folder, words, **PLACES[place]) for words in (FORCE, FIGURE)] == usual
    assert (folder / "größe µ.svg").read_bytes().startswith(b"<?xml")


@pytest.mark.slow
def test_no_network_is_needed(tmp_path: Path, usual: list[object]) -> None:
    """No socket is connected, and no name is looked up."""
    (tmp_path / "sitecustomize.py").write_text(
        "import socket\n"
        "def refuse(*_, **__): raise AssertionError('a connection')\n"
        "socket.socket.connect = refuse\nsocket.getaddrinfo = refuse\n",
        encoding="utf-8",
    )
    path = os.pathsep.join((str(tmp_path), os.environ.get("PYTHONPATH", "")))
    assert [run(tmp_path, words, PYTHONPATH=path) for words in (FORCE, FIGURE)] == usual


@pytest.mark.slow
def test_the_source_may_lie_on_a_read_only_disk(tmp_path: Path, usual: list[object]) -> None:
    if not sys.platform.startswith("linux") or subprocess.call((*READ_ONLY, "true")):
        pytest.skip("this user may not mount a disk")
    places = {"PYTHONDONTWRITEBYTECODE": "", "XDG_CACHE_HOME": str(tmp_path)}
    answers = [run(tmp_path, words, after=READ_ONLY, **places) for words in (FORCE, FIGURE)]
    assert answers == usual
