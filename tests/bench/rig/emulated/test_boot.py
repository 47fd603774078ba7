"""The real image: it starts, says who it is, and knows why it started."""

from __future__ import annotations

import pytest

from bench.rig.emulated.emulator import Emulated, firmware_hash, missing
from layerjam.bench.rig.board import law_hash

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]


def test_it_starts_and_says_who_it_is() -> None:
    board = Emulated()
    board.boot()
    identity = board.ask("*IDN?").split(",")
    assert identity[:2] == ["layerjam", "Raspberry Pi Pico"]
    assert identity[3].endswith(f"/law-{law_hash()[:8]}/double")
    _, cause, _, firmware = board.ask("SYST:BOOT?").split(",")
    assert (cause, firmware) == ('"POWER_ON"', f'"{firmware_hash()[:16]}"')
    board.vacuum = 50e3
    board.run(0.02)  # the next samples see it
    assert float(board.ask("MEAS:VAC?")) == pytest.approx(50e3, abs=16)
    assert board.ask("*TST?") == "0"
    assert (board.pump, board.vent) == (0.0, False)
