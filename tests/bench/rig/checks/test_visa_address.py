"""`visa:` addresses: our own driver, through PyVISA with its Python backend, behind a gateway."""

from __future__ import annotations

import contextlib
import re
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import RUN, Served, answered, command, environment, serving

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A gateway to a board whose clock runs five times as fast as ours."""
    with serving(tmp_path_factory.mktemp("quick"), "sim:choi2018?speed=5&at=40kPa") as made:
        yield made


def places(at: Served) -> dict[str, str]:
    return {"socket": f"visa:{at.resource}", "serial port": f"visa:ASRL{at.pty}::INSTR"}


@pytest.mark.parametrize("place", ["socket", "serial port"])
def test_what_a_visa_address_says(quick: Served, place: str) -> None:
    """The same as the gateway's own address, but for what time changes."""
    mine = answered("bench", "status", places(quick)[place], "--json")
    plain = answered("bench", "status", f"tcp:127.0.0.1:{quick.port}", "--json")
    changing = {"vacuum", "uptime", "late_ticks", "worst_lateness", "samples_lost", "zero_age"}
    assert mine.keys() == plain.keys() and mine["identity"].startswith("layerjam,virtual bench,")
    assert {k: v for k, v in mine.items() if k not in changing} == {
        k: v for k, v in plain.items() if k not in changing
    }


@pytest.mark.parametrize("place", ["socket", "serial port"])
def test_a_run_through_visa(
    quick: Served, tmp_path: Path, figure: Callable[[str], None], place: str
) -> None:
    """Blocks with the LF of a line inside them are taken whole, and each sample is kept once."""
    path = tmp_path / "a.ljrun"
    made = answered("bench", "run", places(quick)[place], *RUN, "--out", str(path), "--json")
    assert (made["outcome"], made["gaps"], made["simulated"]) == ("FINISHED", 0, True)
    with contextlib.closing(sqlite3.connect(path)) as base:
        seen = [row[0] for row in base.execute("SELECT seq FROM samples ORDER BY seq")]
    assert seen == list(range(seen[0], seen[0] + made["samples"])) and len(seen) > 400
    # in 24 bytes of a record the number alone brings a byte 10 in each 256
    assert len({n & 0xFF for n in seen}) == 256
    figure(f"    bench run visa: over a {place}: {made['outcome']}, {len(seen)} samples")


def test_nobody_there() -> None:
    words = command("bench", "status", "visa:TCPIP::127.0.0.1::9::SOCKET")
    made = subprocess.run(
        words, capture_output=True, text=True, env=environment(), timeout=60, check=False
    )
    assert made.returncode == 2 and "Traceback" not in made.stderr
    assert re.search(r"visa:TCPIP::127.0.0.1::9::SOCKET.*refused", made.stderr), made.stderr
