"""A process of its own for what would stay in the server's memory: results, errors, its end."""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
from pathlib import Path

import pytest

from layerjam.core.errors import FileError, LayerjamError
from layerjam.workbench.alone import run_in_subprocess

pytestmark = pytest.mark.slow
LARGE = 100 * 2**20


def loads_a_module(name, tell):
    tell("loading", 0.5)
    before = name in sys.modules
    __import__(name)
    held = bytearray(os.urandom(2**20) * (LARGE // 2**20))
    return os.getpid(), before, len(held)


def refuses(path, tell):
    raise FileError(Path(path), "is of no use", 7)


def is_wrong(tell):
    return {}["nothing"]


def ends(tell):
    os._exit(3)


def stays_in(where, tell):
    with tempfile.TemporaryDirectory() as folder:
        Path(where).write_text(folder)
        tell("staying", 0.5)
        while True:
            pass


def nothing(what, share):
    pass


def test_what_it_loads_stays_away_from_here():
    heard = []
    name = "wave" if "wave" not in sys.modules else "nntplib"
    process, before, held = run_in_subprocess(
        loads_a_module, name, progress=lambda *told: heard.append(told)
    )
    assert process != os.getpid()
    assert not before
    assert held == LARGE
    assert name not in sys.modules
    assert ("loading", 0.5) in heard
    assert not multiprocessing.active_children()


def test_its_errors_are_raised_here_with_all_they_know():
    with pytest.raises(FileError) as caught:
        run_in_subprocess(refuses, "x.csv", progress=nothing)
    own = FileError(Path("x.csv"), "is of no use", 7)
    assert str(caught.value) == str(own)
    assert vars(caught.value) == vars(own)
    with pytest.raises(KeyError) as wrong:
        run_in_subprocess(is_wrong, progress=nothing)
    assert any("is_wrong" in note for note in wrong.value.__notes__)
    with pytest.raises(LayerjamError, match="ended unexpectedly, with exit code 3"):
        run_in_subprocess(ends, progress=nothing)


def test_stopped_it_leaves_neither_process_nor_folder(tmp_path):
    class Enough(Exception):
        pass

    def tell(what, share):
        if what == "staying":
            raise Enough

    where = tmp_path / "where"
    with pytest.raises(Enough):
        run_in_subprocess(stays_in, str(where), progress=tell)
    assert not multiprocessing.active_children()
    assert not Path(where.read_text()).exists()
