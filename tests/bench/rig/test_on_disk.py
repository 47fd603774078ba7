"""What the system's calls show: a sample is on disk before the board is told to forget it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bench.rig.gateways import gateway
from bench.rig.test_kill import CODE
from layerjam.laboratory.measure.runs import read_run

FILLING = """
import os, sys, threading, time
def fill():
    while not os.path.exists(sys.argv[2] + "-wal"):
        time.sleep(0.01)
    folder = os.path.dirname(sys.argv[2])
    with open(os.path.join(folder, "more"), "wb") as file:
        room = os.statvfs(folder)
        file.write(bytes(max(room.f_bavail * room.f_frsize - 1_000_000, 0)))
threading.Thread(target=fill, daemon=True).start()
"""
"""Leaves a log one megabyte of its disk."""
pytestmark = pytest.mark.slow


def test_every_acknowledgement_comes_after_a_flush(tmp_path: Path) -> None:
    strace = shutil.which("strace")
    if strace is None:
        pytest.skip("strace is not installed")
    path, trace = tmp_path / "a.ljrun", tmp_path / "trace"
    with gateway("sim:choi2018") as (port, _):
        made = subprocess.run(
            [strace, "-f", "-y", "-s", "64", "-e", "trace=fdatasync,sendto,recvfrom", "-o", trace,
             sys.executable, "-c", CODE, f"tcp:127.0.0.1:{port}", path, "new", "1.5"],
            capture_output=True, text=True, timeout=120, env={**os.environ}, check=False,
        )  # fmt: skip
    if "ptrace" in made.stderr:
        pytest.skip("processes may not be traced here")
    assert made.returncode == 0, made.stderr
    acts = []
    for line in trace.read_text().splitlines():
        if "STR:ACK" in line:
            acts.append("acknowledge")
        elif re.search(r"recvfrom.*\"#[2-4]\d\d", line):
            acts.append("block")
        elif "fdatasync" in line and line.endswith("= 0"):
            acts.append("flush")
    blocks = [n for n, act in enumerate(acts) if act == "block"]
    assert len(blocks) >= 3 and acts.count("acknowledge") == len(blocks)
    for begin, end in zip(blocks, [*blocks[1:], len(acts)], strict=True):
        part = acts[begin:end]
        assert part[0] == "block" and "flush" in part[: part.index("acknowledge")], part
    assert read_run(path).samples >= 150


def test_a_disk_that_is_full(tmp_path: Path) -> None:
    """A small file system, where one may be mounted, filled up while the log runs."""
    disk = tmp_path / "disk"
    disk.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=12m", "tmpfs", disk], capture_output=True, check=False
    )
    if made.returncode:
        pytest.skip("no file system may be mounted here")
    try:
        with gateway("sim:choi2018?speed=20") as (port, _):
            path = disk / "a.ljrun"
            code = FILLING + CODE
            done = subprocess.run(
                [sys.executable, "-c", code, f"tcp:127.0.0.1:{port}", path, "new", "1e6"],
                capture_output=True, text=True, timeout=120, env={**os.environ}, check=False,
            )  # fmt: skip
        assert done.returncode == 0, done.stderr
        outcome, samples, gaps, *reason = done.stdout.split()
        run = read_run(path)
        assert (outcome, int(samples)) == ("DISK_FULL", run.samples) and "full" in " ".join(reason)
        assert run.samples > 100 and int(gaps) == run.gaps
    finally:
        subprocess.run(["umount", disk], check=True)
