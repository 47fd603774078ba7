"""Hours in which nothing happens, and what would be seen if something did."""

from __future__ import annotations

import json
import sys
import types
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from counts import FULL
from layerjam.bench.control.settings import KINDS
from layerjam.bench.rig import board as boards
from layerjam.bench.rig import soak as rig_soak
from layerjam.bench.rig.address import VIRTUAL
from layerjam.bench.rig.board import interpreter_command
from layerjam.bench.rig.soak import Log, soak
from layerjam.cli.main import main

KEYS = {
    "address", "board", "kind", "hours", "ticks", "orders", "false_faults", "faults", "gaps",
    "wraps", "heap_growth", "late_ticks", "complete",
}  # fmt: skip


def test_a_minute(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "soak", "--hours", "0.01", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert set(said) >= KEYS and said["complete"]
    assert (said["false_faults"], said["gaps"], said["late_ticks"]) == (0, 0, 0)
    assert said["wraps"] == 1, "the clock begins five seconds before one"
    assert 3600 <= said["ticks"] < 7200 and said["hours"] == pytest.approx(0.01, rel=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(KINDS))
def test_an_hour(kind: str) -> None:
    """An hour, or a third of it, past two wraps of the clock."""
    hours = 1.0 if FULL else 0.32
    done = soak(VIRTUAL, kind=kind, hours=hours, seed=1)
    assert (done.faults, done.gaps, done.late_ticks, done.complete) == ((), 0, 0, True)
    assert done.ticks >= 360_000 * hours and done.orders > 30 * hours
    assert done.wraps >= (4 if hours == 1.0 else 2)


def test_a_false_fault_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A detector that is too sharp stops a sound line, again and again."""
    sound = boards.firmware_files()
    sharp = sound["bench.py"].replace("if self.has_disagreement(self.settings.law[1]):",
                                      "if self.count % 1000 == 999:")  # fmt: skip
    assert sharp != sound["bench.py"]
    monkeypatch.setattr(boards, "firmware_files", lambda: {**sound, "bench.py": sharp})
    done = soak(f"{VIRTUAL}&python=cpython", hours=0.01)
    assert 1 <= len(done.faults) <= done.ticks // 1000 and set(done.faults) == {"SENSORS_DISAGREE"}
    assert done.heap_growth is None and done.gaps == 0


@pytest.mark.skipif(interpreter_command()[0] == sys.executable, reason="CPython has no such count")
def test_a_leak_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A number that each sample leaves in a list; a list keeps the numbers themselves."""
    sound = boards.firmware_files()
    judged = "self.has_disagreement(self.settings.law[1])"
    assert f"if {judged}:" in sound["bench.py"]
    leaky = sound["bench.py"].replace(f"if {judged}:", f"if KEPT.append(self.count) or {judged}:")
    leaky = leaky.replace("\nclass ", "\nKEPT = []\n\n\nclass ", 1)
    monkeypatch.setattr(boards, "firmware_files", lambda: {**sound, "bench.py": leaky})
    done = soak(VIRTUAL, hours=0.01)
    assert done.heap_growth is not None and done.heap_growth > 1000


def test_a_block_kept_by_chance_is_no_leak(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first reading, then those of each round at the end."""
    for readings, growth in (([900, 932, 932, 900], 0), ([900, *[932] * 5], 32), ([900, 868], -32)):
        left = iter(readings)
        monkeypatch.setattr(rig_soak, "_read_used_memory", lambda *_, left=left: next(left))
        assert soak(VIRTUAL, hours=0.002).heap_growth == growth
        assert next(left, None) is None


def test_gaps_are_counted() -> None:
    board: Any = types.SimpleNamespace()
    log = Log(board)

    def look(*seqs: int, at: int = 0) -> int:
        log.count_gaps(np.array(seqs), (np.array(seqs) * 10_000 + at) % (1 << 32))
        return log.gaps

    assert look(429_490, 429_491) == look(429_492, 429_493) == look(429_494, 429_500) - 1 == 0
    assert look(429_501) == 1 and look(429_501) == 2 and look(429_502, at=10) == 3
    assert look(429_503, at=10) == 3


def test_an_interrupt_ends_it_without_a_result() -> None:
    def progress(what: str, share: float) -> None:
        if share > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lj.bench_soak(line="choi2018", hours=1.0, kind="bang-bang", progress=progress)
    done = lj.bench_soak(line="choi2018", hours=0.01, kind="bang-bang")
    assert done.address == "sim:choi2018" and 0 < done.hours < 0.1
    assert (done.complete, done.exit_code, done.false_faults, done.gaps) == (True, 0, 0, 0)
    assert replace(done, gaps=1).exit_code == 1
    assert replace(done, heap_growth=16).exit_code == 1
