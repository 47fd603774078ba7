"""Checks 1 and 2: Debian's lxi-tools."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable

import pytest

from bench.rig.checks.served import Served

pytestmark = pytest.mark.slow


def lxi(program: str, *words: str) -> str:
    done = subprocess.run([program, *words], capture_output=True, text=True, timeout=60, check=True)
    return done.stdout


def test_1_four_fields(
    served: Served, tool: Callable[[str], str], figure: Callable[[str], None]
) -> None:
    said = lxi(tool("lxi"), "scpi", "-r", "-a", "127.0.0.1", "-p", str(served.port), "*IDN?")
    assert len(said.strip().split(",")) == 4
    figure(f" 1  lxi scpi *IDN?: {said.strip()}")


def test_2_a_thousand_answers_a_second(
    served: Served, tool: Callable[[str], str], figure: Callable[[str], None]
) -> None:
    words = ["benchmark", "-r", "-a", "127.0.0.1", "-p", str(served.port), "-c", "2000"]
    said = lxi(tool("lxi"), *words)
    rate = float(re.findall(r"([\d.]+) requests/second", said)[-1])
    figure(f" 2  lxi benchmark, 2,000 requests: {rate:,.0f}/s (at least 1,000)")
    assert rate >= 1000
