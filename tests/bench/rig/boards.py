"""The firmware's modules in this process, and a HAL whose plant is a few lines of the test."""

from __future__ import annotations

import importlib
import math
import struct
import sys
import tempfile
import types
import zlib
from functools import cache
from pathlib import Path
from typing import Any

from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.board import firmware_files, write_firmware
from layerjam.brake.fluid.line import Sensor

CHIP = ("converter.py", "hal_rp2.py", "sensor_adc.py", "sensor_hsc.py")
"""Files that need a chip's own modules."""
PLANT = Plant(rate=0.44, top=95e3, leak=0.004, vent=8.0)
SENSOR = Sensor(range=103421.0, noise=8.0, resolution=15.8)


def regulator(**other: Any) -> Regulator:
    return Regulator(**{"plant": PLANT, "sensor": SENSOR, "safe_state": "release", **other})


def law_words(made: Regulator) -> str:
    """`CONT:LAW`'s two strings."""
    first, second = made.pack()
    raw = struct.pack(f"<{len(first) + len(second)}d", *first, *second)
    return f'"{raw.hex().upper()}","{zlib.crc32(raw):08X}"'


@cache
def firmware() -> types.SimpleNamespace:
    """The modules as a board has them; their flat names are taken back afterwards."""
    names = [name.removesuffix(".py") for name in firmware_files() if name not in CHIP]
    kept = {name: sys.modules.pop(name, None) for name in names}
    with tempfile.TemporaryDirectory() as folder:
        write_firmware(Path(folder))
        sys.path.insert(0, folder)
        writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
        try:
            made = {name: importlib.import_module(name) for name in names}
        finally:
            sys.dont_write_bytecode = writes
            sys.path.remove(folder)
            for name, module in kept.items():
                sys.modules.pop(name, None)
                if module is not None:
                    sys.modules[name] = module
    return types.SimpleNamespace(**made)


class Hal:
    """A plant by Euler's rule in `steps` steps a sample, without noise: independent of ours."""

    steps = 20
    collected = 0

    def __init__(self) -> None:
        self.now, self.cause = 0, "POWER_ON"
        self.vacuum, self.pump, self.power = 0.0, 0.0, 0
        self.shows: float | None = None
        self.estop_open = self.supply_low = False
        self.slots: list[bytes | None] = [None, None]
        self.normally_open = True
        self.pump_works = 1.0
        self.wakes = 0

    def ticks_us(self) -> int:
        return self.now % 2**30

    def read_sensor(self) -> tuple[float, int, int, int]:
        self.wakes += 1  # one count more or less each time: a sensor that never stands still
        shown = self.vacuum + 4.0 * (self.wakes % 2) if self.shows is None else self.shows
        return shown, 7, 2300, 1 if math.isnan(shown) else 0

    def set_outputs(self, pump: float, power: int) -> None:
        self.pump, self.power = pump, power

    @property
    def vent_open(self) -> bool:
        return self.normally_open != bool(self.power)

    def is_stop_pressed(self) -> bool:
        return self.estop_open

    def has_supply(self) -> bool:
        return not self.supply_low

    def arm_watchdog(self) -> None: ...
    def feed_watchdog(self) -> None: ...

    def load(self, slot: int) -> bytes | None:
        return self.slots[slot]

    def save(self, slot: int, data: bytes) -> None:
        self.slots[slot] = data

    def time_since_save(self) -> int:
        return 10**7

    def identity(self) -> tuple[str, str]:
        return "test bench", "T1"

    def reset_cause(self) -> str:
        return self.cause

    def reset(self) -> None:
        raise RuntimeError("reset")

    def enter_maintenance(self) -> None:
        raise RuntimeError("maintenance")

    def advance(self, us: int) -> None:
        """The plant goes on by so many microseconds."""
        self.now += us
        dt = us * 1e-6 / self.steps
        for _ in range(self.steps):
            flow = PLANT.rate * self.pump * self.pump_works * (PLANT.top - self.vacuum)
            out = PLANT.leak + (PLANT.vent if self.vent_open else 0.0)
            self.vacuum += dt * (flow - out * self.vacuum)


class Rig:
    """A bench on such a HAL, talked to in words."""

    def __init__(self, hal: Hal | None = None) -> None:
        self.code = firmware()
        self.hal = hal or Hal()
        self.bench = self.code.bench.Bench(self.hal)
        self.port = self.code.port.Port(self.bench)
        self.run(0.01)

    def say(self, text: str | bytes, session: int = 0) -> str:
        line = text if isinstance(text, bytes) else text.encode("latin-1")
        return self.port.execute(line, session).decode("latin-1")

    def error(self, session: int = 0) -> int:
        return int(self.say("SYST:ERR?", session).split(",")[0])

    def run(self, time: float, *, talk: bool = False, late: int = 0) -> None:
        for _ in range(round(time * 100)):
            self.hal.advance(10_000)
            if talk:
                self.say("*OPC?")
            self.bench.tick(late)

    def ready(self, made: Regulator | None = None) -> None:
        for text in ("OUTP:SAFE REL", "OUTP:VENT:REST OPEN",
                     "CONT:LAW " + law_words(made or regulator())):  # fmt: skip
            self.say(text)
        assert self.error() == 0

    def on(self, target: float = 60e3) -> None:
        self.ready()
        self.say(f"SOUR:VAC {target};:OUTP ON")
        assert self.error() == 0
