"""What a virtual board is connected to: the line's plant and a sensor, answered by a thread."""

from __future__ import annotations

import math
import os
import random
import struct
import threading
from dataclasses import dataclass, replace
from typing import Any

from layerjam.control.closed_loop import FaultInjection
from layerjam.control.closed_loop_run import factors
from layerjam.control.plant import Plant, plant_of
from layerjam.control.through_tube import advanced
from layerjam.errors import QuantityError
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Sensor
from layerjam.rig.address import Address
from layerjam.units import check, parse

TOLD = struct.Struct("<dIBBH")
"""From the board: pump, board's clock [us, 30 bits], power of the vent, whether it asks."""
SHOWN = struct.Struct("<dHhBBH")
"""To the board: vacuum [Pa], raw counts, temperature [0.01 degC], flags."""
WRAP = 1 << 30
ESTOP, SUPPLY_LOW, DIAGNOSTIC = 1, 2, 4
RANGE = 103421.0
"""Of the sensor [Pa] where neither line nor address states one: 15 psi, Honeywell HSC 015PD."""
COUNTS = (1638, 13108)
"""Counts at the lowest reading and the span above it, of such a sensor."""
AT = 60e3
"""Vacuum [Pa] at which a line's leak and valve are made linear, unless the address says `at`."""
ROOM_TEMPERATURE = 2300
HEALTHY = FaultInjection()
FACTORS: Any = factors.py_func
"""The loop's own text, not compiled: a sample at a time gains nothing by it."""


@dataclass(frozen=True)
class Behind:
    """What is behind a virtual board."""

    name: str
    plant: Plant
    sensor: Sensor
    normally_open: bool
    """Whether the vent valve is open without power."""
    speed: float
    """Of the board's clock over the host's; 0: as fast as samples are computed."""
    seed: int


def behind(address: Address) -> Behind:
    """The line, sensor and valve that a `sim:` address states.

    Raises UnknownNameError for a line nobody knows, QuantityError for what cannot be.
    """
    said = address.options
    line = load_line(address.where).line
    at = parse(said["at"], "Pa", "address: at") if "at" in said else AT
    plant = plant_of(line, vacuum=at)
    sensor = line.sensor or Sensor(range=RANGE)
    for name, field in (("range", "range"), ("noise", "noise")):
        if name in said:
            sensor = replace(sensor, **{field: parse(said[name], "Pa", f"address: {name}")})
    check(sensor, "sensor.")
    rest, speed = said.get("rest", "open"), said.get("speed", "1")
    if rest not in ("open", "closed"):
        raise QuantityError.of("address", f"rest={rest[:40]} is not 'open' or 'closed'")
    factor = parse(speed, "1", "address: speed")
    if not (factor == 0 or 0.01 <= factor <= 1000):
        raise QuantityError.of("address", f"speed={speed} is not 0 or 0.01 to 1000")
    seed = said.get("seed", "0")
    if not seed.isdecimal():
        raise QuantityError.of("address", f"seed={seed[:40]} is no whole number")
    name = address.where.rpartition("/")[2].removesuffix(".toml")
    return Behind(name, plant, sensor, rest == "open", factor, int(seed))


class VirtualPlant:
    """Vacuum and sensor in the board's time; `injected` breaks them, `estop` and `supply_low` too.

    Pump and vent are those of `outputs`, held until set anew. `trace`, where it is a
    list, is given (time [s], pump, vent open, vacuum [Pa]) at each change of the outputs.
    """

    def __init__(self, made: Behind) -> None:
        self.behind = made
        self.injected = HEALTHY
        self.estop = self.supply_low = False
        self.vacuum = self.side = self.shown = 0.0
        self.time = 0.0
        self.outputs = (0.0, made.normally_open)
        self.trace: list[tuple[float, float, bool, float]] | None = None
        self._draw = random.Random(made.seed)
        self._last = 0.0

    def set_outputs(self, pump: float, power: bool) -> None:
        """Pump -1 to 1; whether the vent has power."""
        outputs = (pump, self.behind.normally_open != power)
        if outputs != self.outputs and self.trace is not None:
            self.trace.append((self.time, *outputs, self.vacuum))
        self.outputs = outputs

    def advance(self, dt: float) -> None:
        """So many seconds on, exact for outputs that stand still (see `closed_loop_run.py`)."""
        if dt <= 0.0:
            return
        pump, vent = self.outputs
        rates, lag = self.injected.on(self.behind.plant), self.behind.sensor.lag
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        a, b, gain, sensed = FACTORS(rates, pump, float(vent), dt, lag, left)
        if rates.side > 0.0:
            self.vacuum, self.side, self.shown = advanced(
                self.vacuum, self.side, self.shown, a, b - rates.leak, rates, dt, lag
            )
        else:
            slope = a - b * self.vacuum
            after = self.vacuum + slope * gain
            if after > rates.top:
                after, slope = rates.top, (rates.top - self.vacuum) / gain
            more = left * (self.vacuum - self.shown) + slope * sensed
            self.shown = self.shown + more if lag > 0.0 else after
            self.vacuum = after
        self.time += dt

    def reading(self) -> tuple[float, int]:
        """(what the sensor shows [Pa], its raw counts)."""
        sensor, broken = self.behind.sensor, self.injected.sensor
        if broken == "nan":
            return math.nan, 0
        if broken == "rail":
            self._last = self.injected.value
        elif broken != "stuck":
            y = self.shown + sensor.offset + (self.injected.value if broken else 0.0)
            y += sensor.noise * self._draw.gauss(0.0, 1.0) if sensor.noise else 0.0
            if sensor.resolution:
                y = round(y / sensor.resolution) * sensor.resolution
            self._last = min(max(y, -sensor.range), sensor.range)
        share = 0.5 + 0.5 * self._last / sensor.range
        return self._last, round(COUNTS[0] + share * COUNTS[1])


class PlantThread(threading.Thread):
    """Answers a virtual board's questions until its pipe ends."""

    def __init__(self, plant: VirtualPlant, told: int, shown: int) -> None:
        super().__init__(name="plant", daemon=True)
        self.plant = plant
        self._told, self._shown = told, shown

    def run(self) -> None:
        """Each message moves the plant to the board's time, then says the outputs from there."""
        last: int | None = None
        plant = self.plant
        try:
            while len(data := _exactly(self._told, TOLD.size)) == TOLD.size:
                pump, now, power, asks, _ = TOLD.unpack(data)
                passed = 0 if last is None else (now - last + WRAP // 2) % WRAP - WRAP // 2
                last = now
                plant.advance(passed * 1e-6)
                plant.set_outputs(pump, bool(power))
                if asks:
                    vacuum, raw = plant.reading()
                    flags = (ESTOP if plant.estop else 0) | (SUPPLY_LOW if plant.supply_low else 0)
                    flags |= DIAGNOSTIC if vacuum != vacuum else 0
                    os.write(self._shown, SHOWN.pack(vacuum, raw, ROOM_TEMPERATURE, flags, 0, 0))
        except OSError:
            pass  # the board is gone
        finally:
            os.close(self._told)
            os.close(self._shown)


def _exactly(descriptor: int, size: int) -> bytes:
    """So many bytes, or fewer at the end of a pipe."""
    data = b""
    while len(data) < size:
        more = os.read(descriptor, size - len(data))
        if not more:
            break
        data += more
    return data
