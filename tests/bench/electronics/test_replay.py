"""Traces of the simulated power side at the pins of the firmware, sampled at every phase."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.electronics.spice import missing
from bench.electronics.traces import BEGIN, CASES, SENSES, trace
from bench.rig.boards import Hal, Rig
from layerjam.bench.rig.wiring import load_wiring

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
WIRED = load_wiring("pico").firmware_pins()
LEAST = WIRED["least_supply"] / WIRED["supply_ratio"]
THRESHOLD = 1.4
"""Voltage [V] between the RP2040's greatest for low, 0.8 V, and its least for high, 2.0 V."""
PHASES = 8
"""Moments within a sample at which the event begins."""


class Powered(Hal):
    """A HAL whose two senses follow a trace from the moment `begin` [us] on."""

    def __init__(self) -> None:
        super().__init__()
        self.played: dict[str, np.ndarray] | None = None
        self.begin = 0

    def pin(self, name: str) -> float:
        if self.played is None:
            return 3.0
        time = (self.now - self.begin) * 1e-6
        return float(np.interp(time, self.played["time"], self.played[name]))

    def has_supply(self) -> bool:
        return self.pin("supply_adc") >= LEAST

    def is_stop_pressed(self) -> bool:
        return self.pin("estop_sense") < THRESHOLD


@pytest.mark.parametrize("case", CASES)
def test_the_board_names_what_happens_to_its_supply(case: str, tmp_path: Path) -> None:
    played = trace(case, tmp_path)
    assert min(played[name][played["time"] < BEGIN][-1] for name in SENSES) > THRESHOLD
    for phase in range(PHASES):
        rig = Rig(Powered())
        hal = rig.hal
        assert isinstance(hal, Powered)
        rig.on()
        rig.run(0.1, talk=True)
        assert rig.bench.state == 1 and hal.pump > 0
        hal.played, hal.begin = played, hal.now + phase * 10_000 // PHASES
        tripped = None
        while hal.now - hal.begin < played["time"][-1] * 1e6 - 10_000:
            rig.run(0.01, talk=True)
            if tripped is None and rig.bench.state != 1:
                tripped = (hal.now - hal.begin) * 1e-6 - BEGIN
        name = rig.say("OUTP:PROT:FAUL?").split('"')[1]
        assert name == (CASES[case] or "HEALTHY"), phase
        if CASES[case]:
            # three samples of 10 ms, and up to 25 ms of a slow sag before its limit
            assert tripped is not None and 0 <= tripped <= 0.06
            assert hal.pump == 0 and hal.vent_open
