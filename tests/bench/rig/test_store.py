"""Settings of a virtual board in a file: they outlast the board, and a torn file never counts."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from bench.rig.boards import law_words, regulator
from layerjam.bench.rig.board import VirtualBoard, connect, interpreter_command
from layerjam.core.errors import LayerjamError

ONES = ["cpython"] + (["micropython"] if "micropython" in interpreter_command()[0] else [])


def board(store: Path, python: str) -> VirtualBoard:
    _, made = connect(f"sim:choi2018?speed=0&python={python}&store={store}")
    assert made is not None
    return made


def ask(made: VirtualBoard, text: str) -> str:
    return made.line.ask(1, text.encode()).decode()


def kill(made: VirtualBoard) -> None:
    """As a power cut does it."""
    os.kill(made.pid, getattr(signal, "SIGKILL", signal.SIGTERM))  # Windows ends it at once
    made.line.close()


@pytest.mark.parametrize("python", ONES)
def test_settings_outlast_a_power_cut(tmp_path: Path, python: str) -> None:
    store = tmp_path / "settings"
    made = board(store, python)
    ask(made, "OUTP:SAFE REL;VENT:REST OPEN;:CONT:LAW " + law_words(regulator()))
    ask(made, "SENS:VAC:CAL 12.5,1.01,'first'")
    ask(made, "SYST:SETT:STOR")
    assert ask(made, "SYST:ERR?").startswith("0,")
    law = ask(made, "CONT:LAW?")
    ask(made, "SENS:VAC:CAL 99,1.01,'never stored'")
    kill(made)
    made = board(store, python)
    assert ask(made, "OUTP:SAFE?;VENT:REST?;:CONT:LAW?") == f"REL;OPEN;{law}"
    assert ask(made, "SENS:VAC:CAL?;:SYST:SETT:COUN?") == '12.5,1.01,"first";1'
    kill(made)


@pytest.mark.parametrize("python", ONES[-1:])
def test_a_torn_file_is_never_taken(tmp_path: Path, python: str) -> None:
    """The newer of two cut at several lengths: the older one, and 125; both cut: none, and -314."""
    store = tmp_path / "settings"
    for name in ("old", "new"):
        made = board(store, python)
        ask(made, f"SENS:VAC:CAL 0,1,'{name}';:SYST:SETT:STOR")
        kill(made)
    newer = tmp_path / "settings.0"
    older = tmp_path / "settings.1"
    whole = newer.read_bytes()
    assert b"new" in whole and b"old" in older.read_bytes()
    for length in (0, len(whole) // 2, len(whole) - 1):
        newer.write_bytes(whole[:length])
        made = board(store, python)
        assert ask(made, "SENS:VAC:CAL?") == '0,1,"old"'
        assert ask(made, "SYST:ERR?").startswith("125,")
        kill(made)
    older.write_bytes(b"")
    made = board(store, python)
    assert ask(made, "OUTP:SAFE?") == "NONE"
    assert ask(made, "SYST:ERR?").startswith("-314,")
    kill(made)


def test_without_a_file_they_last_as_long_as_the_process(tmp_path: Path) -> None:
    _, made = connect("sim:choi2018?speed=0")
    assert made is not None
    ask(made, "SENS:VAC:CAL 0,1,'gone';:SYST:SETT:STOR")
    kill(made)
    _, made = connect("sim:choi2018?speed=0")
    assert made is not None
    assert ask(made, "SENS:VAC:CAL?") == '0,1,""'
    made.line.close()
    with pytest.raises(LayerjamError):
        connect("sim:choi2018?store=")
