"""Hardware around a virtual board: a thread simulates the vacuum line and its sensor."""

import math
import random
import struct
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from layerjam.bench.control.exact import Rates, step_factors
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant, linearise_line
from layerjam.bench.control.sample import advance_plant
from layerjam.bench.rig.address import Address
from layerjam.bench.rig.uneven import SUBSTEP, Uneven
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.fluid.line_file import load_line
from layerjam.core.errors import QuantityError
from layerjam.core.units import check, parse

if TYPE_CHECKING:
    from layerjam.bench.rig.child import Child
    from layerjam.bench.rig.machine import VirtualMachine
from typing import Any

import numpy as np

from layerjam.brake.simulate.accelerometer import ADXL193, STANDARD_GRAVITY

TOLD = struct.Struct("<dIBBH")
"""Message from the board: pump, board's clock [us, 30 bits], vent power, request and count."""
READING, SAMPLES, START = 1, 2, 3
"""Requests: a reading, accelerometer samples, or their scale, which starts the sampling."""
SHOWN = struct.Struct("<dHhBBHd")
"""Message to the board: vacuum [Pa], raw counts, temperature [0.01 degC], flags, unused, time for
which the sample keeps the board busy [ms], reading of a second sensor [Pa]."""
WRAP = 1 << 30
ESTOP, SUPPLY_LOW, DIAGNOSTIC, SECOND, CONTACT = 1, 2, 4, 8, 16
RANGE = 103421.0
"""Default range of the sensor [Pa]: 15 psi, Honeywell HSC 015PD."""
COUNTS = (1638, 13108)
"""Counts at the lowest reading of such a sensor, and the span above that."""
LINEAR_AT = 60e3
"""Vacuum [Pa] at which a line's leak and valve are linearised, unless the address states `at`."""
ROOM_TEMPERATURE = 2300
HEALTHY = FaultInjection()
SCALE = struct.Struct("<4d")
"""Counts at 0, m/s^2 per count, range [m/s^2], rate [Hz]."""
SENSITIVITY = 8e-3
"""Sensitivity of a 250 g ADXL193 at 5 V [V/g]; from memory, not checked in the data sheet."""
DIVIDER, REFERENCE, CODES = 2 / 3, 3.3, 4096
ZERO = 2.5 * DIVIDER / REFERENCE * CODES
"""Counts at 0."""
GAIN = STANDARD_GRAVITY / (SENSITIVITY * DIVIDER / REFERENCE * CODES)
"""m/s^2 per count."""
ACCELERATION_RANGE = float(ADXL193.range or 0.0)
NOISE = 1.2
"""Noise, RMS [counts]: 0.97 to 1.36 were measured on an RP2040 (pico-adc.markomo.me)."""
Array = np.ndarray[Any, Any]


class VirtualAccelerometer:
    """An ADXL193 behind a divider on a 12-bit converter; it measures specific force in counts.

    At rest it shows 1 g; `set_force` applies a signal.
    """

    def __init__(self, seed: int) -> None:
        self._draw = np.random.default_rng(seed)
        self._rate, self._begun, self._given = 8000, 0.0, 0
        self._signal: tuple[float, Array, Array] | None = None

    def set_force(self, start: float, time: Array, force: Array) -> None:
        """Apply a specific force [m/s^2] at ascending times [s] after `start` [s]; shapes (N,).

        `start` is a plant time. Before that time the sensor is at rest; after the signal its last
        value persists.
        """
        self._signal = (start, np.asarray(time, float), np.asarray(force, float))

    def start_sampling(self, rate: int, plant_time: float) -> bytes:
        """Start sampling and return the packed scale."""
        self._rate, self._begun, self._given = rate, plant_time, 0
        return SCALE.pack(ZERO, GAIN, ACCELERATION_RANGE, float(rate))

    def read_samples(self, count: int) -> bytes:
        """Return the next samples, int16, little-endian."""
        times = self._begun + (self._given + np.arange(count)) / self._rate
        self._given += count
        force = np.full(count, STANDARD_GRAVITY)
        if self._signal is not None:
            begin, time, values = self._signal
            force = np.interp(times - begin, time, values, left=STANDARD_GRAVITY)
        voltage = np.clip(force, -ACCELERATION_RANGE, ACCELERATION_RANGE) / GAIN + ZERO
        codes = np.round(voltage + NOISE * self._draw.standard_normal(count))
        return np.clip(codes, 0, CODES - 1).astype("<i2").tobytes()


@dataclass(frozen=True)
class Hardware:
    """Simulated hardware of a virtual board."""

    name: str
    plant: Plant
    sensor: Sensor
    normally_open: bool
    """Whether the vent valve is open when unpowered."""
    speed: float
    """Speed of the board's clock relative to the host's; 0: as fast as samples are computed."""
    seed: int
    second: bool = False
    """Whether a second sensor of the same kind measures the vacuum of the same chamber."""
    uneven: Uneven | None = None
    """Flows that differ from those of the linear plant, if any."""


def read_hardware(address: Address) -> Hardware:
    """Return the simulated hardware that a `sim:` address describes.

    Raises UnknownNameError for an unknown line, QuantityError for impossible values.
    """
    options = address.options
    line = load_line(address.where).line
    vacuum = parse(options["at"], "Pa", "address: at") if "at" in options else LINEAR_AT
    plant = linearise_line(line, vacuum=vacuum)
    if "leak" in options:
        plant = replace(plant, leak=_read_rate(options, "leak"))
    if "vent" in options:
        plant = replace(plant, vent=_read_rate(options, "vent"))
    check(plant, "plant.")
    sensor = line.sensor or Sensor(range=RANGE)
    for name, field in (("range", "range"), ("noise", "noise")):
        if name in options:
            sensor = replace(sensor, **{field: parse(options[name], "Pa", f"address: {name}")})
    check(sensor, "sensor.")
    vent_rest, speed = options.get("rest", "open"), options.get("speed", "1")
    if vent_rest not in ("open", "closed"):
        raise QuantityError.of("address", f"rest={vent_rest[:40]} is not 'open' or 'closed'")
    second = options.get("second", "0")
    if second not in ("0", "1"):
        raise QuantityError.of("address", f"second={second[:40]} is not 0 or 1")
    factor = parse(speed, "1", "address: speed")
    if not (factor == 0 or 0.01 <= factor <= 1000):
        raise QuantityError.of("address", f"speed={speed} must be 0 or from 0.01 to 1000")
    seed = options.get("seed", "0")
    if not seed.isdecimal():
        raise QuantityError.of("address", f"seed={seed[:40]} is not a whole number")
    name = address.where.replace("\\", "/").rpartition("/")[2].removesuffix(".toml")
    normally_open = vent_rest == "open"
    return Hardware(name, plant, sensor, normally_open, factor, int(seed), second == "1")


behind = read_hardware  # former name


def _read_rate(options: Mapping[str, str], name: str) -> float:
    """Return a rate [1/s]: the inverse of a time constant in the address."""
    lasting = parse(options[name], "s", f"address: {name}")
    if not lasting > 0:
        raise QuantityError.of("address", f"{name}={options[name][:40]} is not above zero")
    return 1 / lasting


class VirtualPlant:
    """Plant of a virtual board: vacuum and sensor in the board's time, with injected faults.

    `injected` is a fault in the pump, line or sensor. `drift` [Pa/s] raises the sensor's reading
    steadily. `stall` [s] keeps the board busy in its next sample. `estop` and `supply_low` cut off
    pump and valve: the board then measures no voltage downstream of the emergency stop and, with
    `supply_low`, none upstream either. Pump and vent follow the commanded `outputs`. `trace`, if it
    is a list, receives (time [s], pump, vent open, vacuum [Pa]) at each change of the outputs.
    `watch` is called at each sample; `schedule` calls a function between two samples. `pace` [s]
    delays each sample in the host's time. `contact` closes the trigger contact. `accelerometer` may
    receive a drop (`drop.py`).
    """

    def __init__(self, hardware: Hardware) -> None:
        self.behind = hardware
        self.injected = HEALTHY
        self.estop = self.supply_low = self.contact = False
        self.drift = self.stall = self.pace = 0.0
        self.watch: Callable[[], None] | None = None
        self.machine: VirtualMachine | None = None
        """Machine that pulls the brake of this chamber."""
        self.recorded: Callable[[], object] | None = None
        """Function of the recorder that is called before each sample and may delay it."""
        self.accelerometer = VirtualAccelerometer(hardware.seed)
        self.vacuum = self.side = self.shown = 0.0
        self.time = 0.0
        self.asked = self.wraps = 0
        """Numbers of samples taken by the board, and of overflows of its 30-bit clock."""
        self.outputs = (0.0, hardware.normally_open)
        self.trace: list[tuple[float, float, bool, float]] | None = None
        self._last = self._climbed = 0.0
        self._due: tuple[float, Callable[[], None]] | None = None
        self._broken: tuple[FaultInjection, Hardware, Rates] | None = None
        self.reseed(hardware.seed)

    def reseed(self, seed: int) -> None:
        """Restart the sensors' random noise with this seed."""
        self._draw = random.Random(seed)
        self._other = random.Random(seed + 1)

    def clear_faults(self) -> None:
        """Remove all faults and pending actions."""
        self.watch = self._due = None
        self.injected = HEALTHY
        self.estop = self.supply_low = self.contact = False
        self.drift = self.stall = self.pace = self._climbed = 0.0

    def schedule_action(self, time: float, act: Callable[[], None]) -> None:
        """Call a function at a plant time [s], in the plant's thread; only one can be pending."""
        self._due = time, act

    def set_outputs(self, pump: float, power: bool) -> None:
        """Set the pump (-1 to 1), and whether the vent valve has power."""
        outputs = (pump, self.behind.normally_open != power)
        if outputs != self.outputs and self.trace is not None:
            self.trace.append((self.time, *outputs, self.vacuum))
        self.outputs = outputs

    def advance(self, dt: float) -> None:
        """Advance by `dt` [s], and call the pending function if its time has come."""
        due = self._due
        if due is not None and self.time + dt >= due[0]:
            self._due = None
            first = max(due[0] - self.time, 0.0)
            self._move_vacuum(first)
            due[1]()
            dt -= first
        self._move_vacuum(dt)

    def _current_rates(self) -> Rates:
        cache, hardware = self._broken, self.behind
        if cache is None or cache[0] is not self.injected or cache[1] is not hardware:
            rates = self.injected.break_plant(hardware.plant)
            cache = self._broken = self.injected, hardware, rates
        if self.machine is not None and self.machine.volume_ratio != 1.0:
            larger = replace(self.injected, volume=self.injected.volume * self.machine.volume_ratio)
            return larger.break_plant(hardware.plant)
        return cache[2]

    def _move_vacuum(self, dt: float) -> None:
        """Advance by `dt` [s]; uneven flows are treated as constant for up to 2 ms."""
        rates, uneven = self._current_rates(), self.behind.uneven
        if uneven is None:
            self._move_evenly(dt, rates)
            return
        count = math.ceil(dt / SUBSTEP)
        for _ in range(count):
            pump, orifice = uneven.pump_ratio(self.time), uneven.orifice_ratio(self.vacuum)
            real = rates._replace(
                rate=rates.rate * pump, leak=rates.leak * orifice, vent=rates.vent * orifice
            )
            self._move_evenly(dt / count, real)

    def _move_evenly(self, dt: float, rates: Rates) -> None:
        """Advance by `dt` [s]; this is exact for constant outputs (see `control/exact.py`)."""
        if dt <= 0.0:
            return
        pump, vent = self.outputs
        if self.estop or self.supply_low:  # unpowered, the valve goes to its rest position
            pump, vent = 0.0, self.behind.normally_open
        self._climbed += self.drift * dt
        lag = self.behind.sensor.lag
        lag_gain = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        factors = step_factors(rates, pump, float(vent), dt, lag, lag_gain)
        self.vacuum, self.side, self.shown = advance_plant(
            self.vacuum, self.side, self.shown, factors, rates, dt, lag, lag_gain
        )
        if self.machine is not None:
            vacuum_before, self.vacuum = self.vacuum, self.machine.advance(dt, self.vacuum)
            if lag == 0.0:
                self.shown += self.vacuum - vacuum_before
        self.time += dt

    def read_sensor(self) -> tuple[float, int]:
        """Return the sensor's reading [Pa] and its raw counts."""
        sensor, fault = self.behind.sensor, self.injected.sensor
        if fault == "nan":
            return math.nan, 0
        if fault == "rail":
            self._last = self.injected.value
        elif fault != "stuck":
            y = self.shown + sensor.offset + (self.injected.value if fault else 0.0)
            self._last = self._measure_reading(y + self._climbed, self._draw)
        share = 0.5 + 0.5 * self._last / sensor.range
        return self._last, round(COUNTS[0] + share * COUNTS[1])

    def read_second_sensor(self) -> float:
        """Return the reading of the second sensor [Pa], which never has a fault."""
        return self._measure_reading(self.shown, self._other) if self.behind.second else 0.0

    def _measure_reading(self, y: float, draw: random.Random) -> float:
        """Return a reading [Pa] with noise and resolution, limited to the sensor's range."""
        sensor = self.behind.sensor
        y += sensor.noise * draw.gauss(0.0, 1.0) if sensor.noise else 0.0
        if sensor.resolution:
            y = round(y / sensor.resolution) * sensor.resolution
        return min(max(y, -sensor.range), sensor.range)

    def make_board_data(self, asks: int = READING, count: int = 0) -> bytes:
        """Return the data for the board: a reading, or samples of its accelerometer."""
        if asks == START:
            return self.accelerometer.start_sampling(count, self.time)
        if asks == SAMPLES:
            return self.accelerometer.read_samples(count)
        self.asked += 1
        if self.recorded is not None:
            self.recorded()
        if self.machine is not None:
            self.machine.store_sample(self.asked - 1)
        if self.watch is not None:
            self.watch()
        if self.pace:
            time.sleep(self.pace)
        vacuum, raw = self.read_sensor()
        # without a supply, there is no voltage downstream of the emergency stop either
        flags = ESTOP | SUPPLY_LOW if self.supply_low else ESTOP if self.estop else 0
        flags |= (DIAGNOSTIC if vacuum != vacuum else 0) | (SECOND if self.behind.second else 0)
        flags |= CONTACT if self.contact else 0
        busy, self.stall = round(1e3 * self.stall), 0.0
        second = self.read_second_sensor()
        return SHOWN.pack(vacuum, raw, ROOM_TEMPERATURE, flags, 0, busy, second)


class PlantThread(threading.Thread):
    """Thread that serves a virtual board until the board's end of the line is closed."""

    def __init__(self, plant: VirtualPlant, child: "Child") -> None:
        super().__init__(name="plant", daemon=True)
        self.plant = plant
        self._child = child

    def run(self) -> None:
        """Advance the plant to the time of each message, then set its outputs."""
        last: int | None = None
        plant = self.plant
        try:
            while len(data := _receive_exactly(self._child.receive, TOLD.size)) == TOLD.size:
                pump, board_time, power, asks, count = TOLD.unpack(data)
                passage = 0 if last is None else (board_time - last + WRAP // 2) % WRAP - WRAP // 2
                plant.wraps += last is not None and passage > 0 and board_time < last
                last = board_time
                plant.advance(passage * 1e-6)
                plant.set_outputs(pump, bool(power))
                if asks:
                    self._child.send(plant.make_board_data(asks, count))
        except OSError:
            pass  # the connection to the board is lost
        finally:
            self._child.leave()


def _receive_exactly(receive: Callable[[int], bytes], size: int) -> bytes:
    """Return `size` bytes, or fewer at the end of the stream."""
    data = b""
    while len(data) < size:
        data_ = receive(size - len(data))
        if not data_:
            break
        data += data_
    return data
