"""The power side as the emulated board sees it: a supply that is lost, a stop that is pressed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.electronics.spice import missing as spice_missing
from bench.electronics.traces import BEGIN, CASES, SENSES, trace
from bench.rig.boards import PLANT
from bench.rig.emulated.emulator import SUPPLY, Emulated, missing
from bench.rig.emulated.test_safe import start

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
PULL_DOWN, PULL_UP = 4, 8
"""Bits of a pad's register (RP2040's datasheet, section 2.19.6.3)."""


@pytest.fixture(scope="module")
def board() -> Iterator[Emulated]:
    made = Emulated()
    made.plant = PLANT
    made.boot()
    yield made


def test_no_resistor_of_the_chip_is_on_the_senses(board: Emulated) -> None:
    for use in ("estop_sense", "supply_adc"):
        pad = board.chip.gpio[board.firmware_pins[use]].pad_value
        assert not pad & (PULL_DOWN | PULL_UP), (use, bin(pad))


@pytest.mark.parametrize(
    ("before", "behind", "fault"),
    [
        (SUPPLY, 0.0, '123,"EMERGENCY_STOP"'),
        (0.0, 0.0, '122,"SUPPLY_LOW"'),
        (9.9, 9.9, '122,"SUPPLY_LOW"'),
    ],
    ids=["stop", "lost", "low"],
)
def test_a_lost_supply_and_a_stop_have_their_own_names(
    board: Emulated, before: float, behind: float, fault: str
) -> None:
    board.supply(SUPPLY)
    board.synchronise()
    start(board, 5.0)
    board.supply(before, behind)
    begin = board.time
    assert board.run(0.1, lambda: board.pump == 0.0)
    assert board.time - begin <= 0.031, board.time - begin
    assert board.ask("OUTP:PROT:FAUL?") == fault
    board.supply(SUPPLY)
    board.run(0.03)
    assert board.ask("OUTP:PROT:CLE;*CLS;*OPC?") == "1"


@pytest.mark.skipif(bool(spice_missing()), reason=spice_missing())
@pytest.mark.parametrize("case", CASES)
def test_the_simulated_power_side_at_the_pins(board: Emulated, case: str, tmp_path: Path) -> None:
    """What ngspice computes for the declared circuit is what the two senses see."""
    played = trace(case, tmp_path)
    board.supply(SUPPLY)
    board.synchronise()
    start(board, 5.0)
    begin, last = board.time, float(played["time"][-1])

    def step() -> bool:
        time = board.time - begin
        board.senses(*(float(np.interp(time, played["time"], played[name])) for name in SENSES))
        return bool(CASES[case]) and time > BEGIN and board.pump == 0.0

    stopped = board.run(last, step)
    assert stopped == bool(CASES[case])
    name = board.ask("OUTP:PROT:FAUL?").split('"')[1]
    assert name == (CASES[case] or "HEALTHY")
    board.supply(SUPPLY)
    board.run(0.03)
    assert board.ask("OUTP OFF;:OUTP:PROT:CLE;*CLS;*OPC?") == "1"
