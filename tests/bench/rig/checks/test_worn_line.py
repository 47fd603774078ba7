"""Check 24: through socat, a line on which one byte in a thousand goes wrong, either way."""

from __future__ import annotations

import contextlib
import json
import sqlite3
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bench.rig.checks.served import RUN, answered, environment, ours, serving

pytestmark = pytest.mark.slow
HERE = Path(__file__).parent
COMMANDS = 400
BOARD = r"sim\:choi2018?at=40kPa"
"""Its line is made linear where the procedure of RUN goes."""


@contextlib.contextmanager
def spoilt(folder: Path, program: str, one_in: int, *kinds: str) -> Iterator[tuple[str, Path]]:
    """A serial port whose board is behind a line that spoils one byte in so many."""
    port, counts = folder / "line", folder / "counts"
    # a colon ends a word of socat's
    board = rf"{ours()} {HERE / 'noisy_line.py'} {BOARD} {one_in} {counts} {' '.join(kinds)}"
    process = subprocess.Popen(
        [program, f"PTY,link={port},raw,echo=0,wait-slave", f"EXEC:{board}"], env=environment()
    )
    try:
        for _ in range(200):
            if port.exists():
                break
            time.sleep(0.05)
        yield str(port), counts
    finally:
        process.terminate()
        process.wait(20)


def test_24_no_command_is_executed_twice(
    tmp_path: Path, tool: Callable[[str], str], figure: Callable[[str], None]
) -> None:
    """Each wrong command makes one error: two would be a command that was executed twice."""
    pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")
    from bench.rig.checks.visa import client

    with (
        spoilt(tmp_path, tool("socat"), 1000, "changed") as (port, counts),
        serving(tmp_path, f"serial:{port}") as made,
        client(made) as use,
    ):
        boot = use.query("SYST:BOOT?").split(",")[0]
        doubled = lost = 0
        for n in range(COMMANDS):
            use.write(f"TRIED{n}")
            # LINE_CORRUPT (126) may stand between them
            count = use.query("SYST:ERR:ALL?").count(f'TRIED{n}"')
            doubled, lost = doubled + (count > 1), lost + (count < 1)
        assert use.query("SYST:BOOT?").split(",")[0] == boot
        passed, changed = json.loads(counts.read_text("utf-8"))
    assert (doubled, lost) == (0, 0) and changed > 20
    figure(f"24  {passed:,} bytes, {changed} changed: {COMMANDS} commands, 0 doubled, 0 lost")


@pytest.mark.parametrize("kinds", [("changed",), ("changed", "lost", "doubled")], ids="-".join)
def test_24_a_run_ends_well(
    tmp_path: Path,
    tool: Callable[[str], str],
    figure: Callable[[str], None],
    kinds: tuple[str, ...],
) -> None:
    """`bench run` on that serial port finishes, and its file holds each sample once."""
    path = tmp_path / "a.ljrun"
    with spoilt(tmp_path, tool("socat"), 1000, *kinds) as (port, counts):
        made = answered("bench", "run", f"serial:{port}", *RUN, "--out", str(path), "--json")
        passed, wrong = json.loads(counts.read_text("utf-8"))
    assert (made["outcome"], made["gaps"], made["fault"]) == ("FINISHED", 0, None)
    assert all(step["reached"] for step in made["steps"]) and wrong > 20
    with contextlib.closing(sqlite3.connect(path)) as base:
        count, span = base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1 FROM samples"
        ).fetchone()
    assert count == span == made["samples"] > 400
    figure(
        f"24  bench run, {passed:,} bytes, {wrong} {', '.join(kinds)}: "
        f"{made['outcome']}, {count} samples, none missing"
    )
