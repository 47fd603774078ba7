"""What a virtual board is connected to: the line's plant and a sensor, answered by a thread."""

from __future__ import annotations

import math
import random
import struct
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from layerjam.control.exact import Rates, factors
from layerjam.control.faults import FaultInjection
from layerjam.control.plant import Plant, plant_of
from layerjam.errors import QuantityError
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Sensor
from layerjam.rig.address import Address
from layerjam.units import check, parse

if TYPE_CHECKING:
    from layerjam.rig.child import Child
    from layerjam.rig.machine import VirtualMachine
from typing import Any

import numpy as np

from layerjam.simulate.accelerometer import ADXL193, STANDARD_GRAVITY

TOLD = struct.Struct("<dIBBH")
"""From the board: pump, board's clock [us, 30 bits], power of the vent, what it asks, how many."""
READING, SAMPLES, START = 1, 2, 3
"""What it asks: a reading; accelerometer samples; their scale, and samples from now on."""
SHOWN = struct.Struct("<dHhBBHd")
"""To the board: vacuum [Pa], raw counts, temperature [0.01 degC], flags, nothing, time for which
the sample keeps the board busy [ms], what a second sensor shows [Pa]."""
WRAP = 1 << 30
ESTOP, SUPPLY_LOW, DIAGNOSTIC, SECOND, CONTACT = 1, 2, 4, 8, 16
RANGE = 103421.0
"""Of the sensor [Pa] where neither line nor address states one: 15 psi, Honeywell HSC 015PD."""
COUNTS = (1638, 13108)
"""Counts at the lowest reading and the span above it, of such a sensor."""
AT = 60e3
"""Vacuum [Pa] at which a line's leak and valve are made linear, unless the address says `at`."""
ROOM_TEMPERATURE = 2300
HEALTHY = FaultInjection()
SCALE = struct.Struct("<4d")
"""Counts at 0, m/s^2 a count, range [m/s^2], rate [Hz]."""
SENSITIVITY = 8e-3
"""Of an ADXL193 of 250 g on 5 V [V/g], half the supply at 0 g; remembered, no sheet was opened."""
DIVIDER, REFERENCE, CODES = 2 / 3, 3.3, 4096
ZERO = 2.5 * DIVIDER / REFERENCE * CODES
"""Counts at 0."""
GAIN = STANDARD_GRAVITY / (SENSITIVITY * DIVIDER / REFERENCE * CODES)
"""m/s^2 a count."""
ACCELERATION_RANGE = float(ADXL193.range or 0.0)
NOISE = 1.2
"""Counts, RMS: 0.97 to 1.36 were measured of an RP2040's converter (pico-adc.markomo.me)."""
Array = np.ndarray[Any, Any]


class VirtualAccelerometer:
    """An ADXL193 behind a divider, on a converter of 12 bits: specific force in counts.

    At rest it shows 1 g. `play` puts a signal on it.
    """

    def __init__(self, seed: int) -> None:
        self._draw = np.random.default_rng(seed)
        self._rate, self._begun, self._given = 8000, 0.0, 0
        self._signal: tuple[float, Array, Array] | None = None

    def play(self, at: float, time: Array, force: Array) -> None:
        """From the plant's time `at` [s] on a specific force [m/s^2]; shapes (N,), rising times.

        Before it the sensor is at rest, after it the last value stays.
        """
        self._signal = (at, np.asarray(time, float), np.asarray(force, float))

    def start(self, rate: int, now: float) -> bytes:
        """Begin to sample; the scale, packed."""
        self._rate, self._begun, self._given = rate, now, 0
        return SCALE.pack(ZERO, GAIN, ACCELERATION_RANGE, float(rate))

    def samples(self, count: int) -> bytes:
        """The next samples, int16, little-endian."""
        at = self._begun + (self._given + np.arange(count)) / self._rate
        self._given += count
        force = np.full(count, STANDARD_GRAVITY)
        if self._signal is not None:
            begin, time, values = self._signal
            force = np.interp(at - begin, time, values, left=STANDARD_GRAVITY)
        shown = np.clip(force, -ACCELERATION_RANGE, ACCELERATION_RANGE) / GAIN + ZERO
        codes = np.round(shown + NOISE * self._draw.standard_normal(count))
        return np.clip(codes, 0, CODES - 1).astype("<i2").tobytes()


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
    second: bool = False
    """Whether a second sensor, of the first one's kind, sits on the same chamber."""


def behind(address: Address) -> Behind:
    """The line, sensor and valve that a `sim:` address states.

    Raises UnknownNameError for a line nobody knows, QuantityError for what cannot be.
    """
    said = address.options
    line = load_line(address.where).line
    at = parse(said["at"], "Pa", "address: at") if "at" in said else AT
    plant = plant_of(line, vacuum=at)
    if "leak" in said:
        plant = replace(plant, leak=_rate(said, "leak"))
    if "vent" in said:
        plant = replace(plant, vent=_rate(said, "vent"))
    check(plant, "plant.")
    sensor = line.sensor or Sensor(range=RANGE)
    for name, field in (("range", "range"), ("noise", "noise")):
        if name in said:
            sensor = replace(sensor, **{field: parse(said[name], "Pa", f"address: {name}")})
    check(sensor, "sensor.")
    rest, speed = said.get("rest", "open"), said.get("speed", "1")
    if rest not in ("open", "closed"):
        raise QuantityError.of("address", f"rest={rest[:40]} is not 'open' or 'closed'")
    second = said.get("second", "0")
    if second not in ("0", "1"):
        raise QuantityError.of("address", f"second={second[:40]} is not 0 or 1")
    factor = parse(speed, "1", "address: speed")
    if not (factor == 0 or 0.01 <= factor <= 1000):
        raise QuantityError.of("address", f"speed={speed} is not 0 or 0.01 to 1000")
    seed = said.get("seed", "0")
    if not seed.isdecimal():
        raise QuantityError.of("address", f"seed={seed[:40]} is no whole number")
    name = address.where.rpartition("/")[2].removesuffix(".toml")
    normally_open = rest == "open"
    return Behind(name, plant, sensor, normally_open, factor, int(seed), second == "1")


def _rate(said: Mapping[str, str], name: str) -> float:
    """One over a time constant that an address states [1/s]."""
    lasting = parse(said[name], "s", f"address: {name}")
    if not lasting > 0:
        raise QuantityError.of("address", f"{name}={said[name][:40]} is no time above zero")
    return 1 / lasting


class VirtualPlant:
    """Vacuum and sensor in the board's time, and what breaks them.

    `injected` breaks pump, line or sensor, `drift` [Pa/s] lets the sensor climb, `stall` [s] keeps
    the board busy in its next sample; `estop` cuts the power of pump and valve and goes to the
    board, as does `supply_low`. Pump and vent are those of `outputs`, as commanded, held until set
    anew. `trace`, where it is a list, is given (time [s], pump, vent open, vacuum [Pa]) at each
    change of the outputs. `watch` is called at each sample, `at` something at a moment between two;
    `pace` [s] holds each sample back, in the host's time. `contact` closes the contact for a
    trigger; `accelerometer` may be given a drop (`drop.py`).
    """

    def __init__(self, made: Behind) -> None:
        self.behind = made
        self.injected = HEALTHY
        self.estop = self.supply_low = self.contact = False
        self.drift = self.stall = self.pace = 0.0
        self.watch: Callable[[], None] | None = None
        self.machine: VirtualMachine | None = None
        """What pulls a brake whose chamber this is."""
        self.recorded: Callable[[], object] | None = None
        """Called before each sample by who records it: what it waits for, the board waits for."""
        self.accelerometer = VirtualAccelerometer(made.seed)
        self.vacuum = self.side = self.shown = 0.0
        self.time = 0.0
        self.asked = self.wraps = 0
        """Samples that the board took, and how often its clock went beyond its 30 bits."""
        self.outputs = (0.0, made.normally_open)
        self.trace: list[tuple[float, float, bool, float]] | None = None
        self._last = self._climbed = 0.0
        self._due: tuple[float, Callable[[], None]] | None = None
        self._broken: tuple[FaultInjection, Behind, Rates] | None = None
        self.reseed(made.seed)

    def reseed(self, seed: int) -> None:
        """Begin the sensors' noise anew."""
        self._draw = random.Random(seed)
        self._other = random.Random(seed + 1)

    def heal(self) -> None:
        """Everything works again, and nothing waits to happen."""
        self.watch = self._due = None
        self.injected = HEALTHY
        self.estop = self.supply_low = self.contact = False
        self.drift = self.stall = self.pace = self._climbed = 0.0

    def at(self, time: float, act: Callable[[], None]) -> None:
        """Do something at a time [s] of the plant, in its thread; one thing can wait."""
        self._due = time, act

    def set_outputs(self, pump: float, power: bool) -> None:
        """Pump -1 to 1; whether the vent has power."""
        outputs = (pump, self.behind.normally_open != power)
        if outputs != self.outputs and self.trace is not None:
            self.trace.append((self.time, *outputs, self.vacuum))
        self.outputs = outputs

    def advance(self, dt: float) -> None:
        """So many seconds on, with what is to happen on the way."""
        due = self._due
        if due is not None and self.time + dt >= due[0]:
            self._due = None
            first = max(due[0] - self.time, 0.0)
            self._move(first)
            due[1]()
            dt -= first
        self._move(dt)

    def _rates(self) -> Rates:
        """Those of the plant as it is broken now."""
        known, made = self._broken, self.behind
        if known is None or known[0] is not self.injected or known[1] is not made:
            known = self._broken = self.injected, made, self.injected.on(made.plant)
        if self.machine is not None and self.machine.swell != 1.0:
            larger = replace(self.injected, volume=self.injected.volume * self.machine.swell)
            return larger.on(made.plant)
        return known[2]

    def _move(self, dt: float) -> None:
        """So many seconds on, exact for outputs that stand still (see `control/exact.py`)."""
        if dt <= 0.0:
            return
        pump, vent = self.outputs
        if self.estop:  # no power: the valve rests
            pump, vent = 0.0, self.behind.normally_open
        self._climbed += self.drift * dt
        rates, lag = self._rates(), self.behind.sensor.lag
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        a, b, gain, sensed = factors(rates, pump, float(vent), dt, lag, left)
        if rates.side > 0.0:
            from layerjam.control.through_tube import advanced  # numba takes half a second

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
        if self.machine is not None:
            before, self.vacuum = self.vacuum, self.machine.advance(dt, self.vacuum)
            if lag == 0.0:
                self.shown += self.vacuum - before
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
            self._last = self._seen(y + self._climbed, self._draw)
        share = 0.5 + 0.5 * self._last / sensor.range
        return self._last, round(COUNTS[0] + share * COUNTS[1])

    def second_reading(self) -> float:
        """What the second sensor shows [Pa]; it stays healthy."""
        return self._seen(self.shown, self._other) if self.behind.second else 0.0

    def _seen(self, y: float, draw: random.Random) -> float:
        """A reading with noise, in steps, within the sensor's range [Pa]."""
        sensor = self.behind.sensor
        y += sensor.noise * draw.gauss(0.0, 1.0) if sensor.noise else 0.0
        if sensor.resolution:
            y = round(y / sensor.resolution) * sensor.resolution
        return min(max(y, -sensor.range), sensor.range)

    def answer(self, asks: int = READING, count: int = 0) -> bytes:
        """What the board gets at a sample, or of its accelerometer."""
        if asks == START:
            return self.accelerometer.start(count, self.time)
        if asks == SAMPLES:
            return self.accelerometer.samples(count)
        self.asked += 1
        if self.recorded is not None:
            self.recorded()
        if self.machine is not None:
            self.machine.sample(self.asked - 1)
        if self.watch is not None:
            self.watch()
        if self.pace:
            time.sleep(self.pace)
        vacuum, raw = self.reading()
        flags = (ESTOP if self.estop else 0) | (SUPPLY_LOW if self.supply_low else 0)
        flags |= (DIAGNOSTIC if vacuum != vacuum else 0) | (SECOND if self.behind.second else 0)
        flags |= CONTACT if self.contact else 0
        busy, self.stall = round(1e3 * self.stall), 0.0
        second = self.second_reading()
        return SHOWN.pack(vacuum, raw, ROOM_TEMPERATURE, flags, 0, busy, second)


class PlantThread(threading.Thread):
    """Answers a virtual board's questions until its end of the line is closed."""

    def __init__(self, plant: VirtualPlant, child: Child) -> None:
        super().__init__(name="plant", daemon=True)
        self.plant = plant
        self._child = child

    def run(self) -> None:
        """Each message moves the plant to the board's time, then says the outputs from there."""
        last: int | None = None
        plant = self.plant
        try:
            while len(data := _exactly(self._child.receive, TOLD.size)) == TOLD.size:
                pump, now, power, asks, count = TOLD.unpack(data)
                passed = 0 if last is None else (now - last + WRAP // 2) % WRAP - WRAP // 2
                plant.wraps += last is not None and passed > 0 and now < last
                last = now
                plant.advance(passed * 1e-6)
                plant.set_outputs(pump, bool(power))
                if asks:
                    self._child.send(plant.answer(asks, count))
        except OSError:
            pass  # the board is gone
        finally:
            self._child.leave()


def _exactly(receive: Callable[[int], bytes], size: int) -> bytes:
    """So many bytes, or fewer at the end."""
    data = b""
    while len(data) < size:
        more = receive(size - len(data))
        if not more:
            break
        data += more
    return data
