"""Circuit around a board: socket, wires with their parts, and contradictions."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from layerjam.rig.wiring import WiringFile, load_wiring

PICO = Path(__file__).parent / "circuits" / "pico.toml"
PULL_DOWN = 8.2e3
"""Greatest pull-down [ohm] that holds a gate at GND while a pin floats (RP2350's erratum E9)."""
GATES = ("pump_gate", "pump_back_gate", "vent_gate")
"""Outputs that must be off while the board is in reset."""
INSIDE = ("led_out",)
"""Pins of the chip that need no wire."""
SPI = {"spi_miso": 0, "spi_cs": 1, "spi_sck": 2, "spi_mosi": 3}
"""Place of a use among four pins in a row; GP n is on SPI (n // 8) mod 2 (RP2040's datasheet)."""
OHMS = re.compile(r"([0-9]+(?:\.[0-9]+)?)\s*(k|M)?(?:Ω|ohm)")
FACTORS = {None: 1.0, "k": 1e3, "M": 1e6}


@dataclass(frozen=True, kw_only=True)
class Wire:
    """One wire of the board: from a pin of its socket, past parts, to an end."""

    pin: int | None
    """Pin of the socket, the first of several with the same name, or None."""
    label: str
    """Label of the pin: GP16, GND, VSYS."""
    use: str | None
    """Name of the use in the board's file, None for a supply."""
    name: str
    to: str
    series: str | None
    shunt: str | None
    """Parts from the line to GND: after `series` at a gate, else at the pin."""
    volts: float | None
    """Greatest voltage at its end [V]."""
    source: str


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part to buy, and the certainty of its choice."""

    name: str
    pick: str
    status: str
    source: str


@dataclass(frozen=True, kw_only=True)
class Circuit:
    """A board with all connected parts."""

    file: WiringFile
    pins: int
    socket: Mapping[str, int]
    """{label: pin of the socket}, the first of several."""
    grounds: tuple[int, ...]
    wires: tuple[Wire, ...]
    parts: tuple[Part, ...]

    @property
    def board(self) -> str:
        """The board's name."""
        return self.file.title or self.file.name

    def conflicts(self) -> tuple[str, ...]:
        """Return the contradictions of the circuit, a sentence each."""
        return (*_sockets(self), *_channels(self), *_bus(self), *_gates(self), *_voltages(self))


def load_circuit(board: str | Path, circuit: Path = PICO) -> Circuit:
    """Return the circuit of a board, by its name or TOML file; `circuit` has socket and parts.

    Raises UnknownNameError or FileError.
    """
    file = load_wiring(board)
    data = tomllib.loads(circuit.read_text("utf-8"))
    socket = {
        label: pin if isinstance(pin, int) else pin[0]
        for label, pin in data["socket"].items()
        if label != "count"
    }
    numbers = asdict(file.wiring.pins)
    return Circuit(
        file=file,
        pins=data["socket"]["count"],
        socket=socket,
        grounds=tuple(data["socket"]["GND"]),
        wires=tuple(_wire(entry, socket, numbers) for entry in data["wire"]),
        parts=tuple(Part(**entry) for entry in data["part"]),
    )


def _wire(entry: Mapping[str, Any], socket: Mapping[str, int], numbers: Mapping[str, int]) -> Wire:
    use = entry.get("use")
    label = entry["pin"] if use is None else f"GP{numbers[use]}"
    return Wire(
        pin=socket.get(label),
        label=label,
        use=use,
        name=entry["name"],
        to=entry["to"],
        series=entry.get("series"),
        shunt=entry.get("shunt"),
        volts=entry.get("volts"),
        source=entry.get("source", ""),
    )


def ohms(text: str | None) -> float | None:
    """Return the resistance [ohm] in a text such as "8.2 kΩ, 10 nF", or None."""
    match = OHMS.search(text or "")
    return float(match[1]) * FACTORS[match[2]] if match else None


def _sockets(circuit: Circuit) -> Iterator[str]:
    """Yield pins of the chip that the socket does not have."""
    for use, number in asdict(circuit.file.wiring.pins).items():
        if use not in INSIDE and f"GP{number}" not in circuit.socket:
            yield f"{use}: GP{number} leads to no pin of the socket"


def _channels(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict if both sides of the pump share a PWM channel."""
    pins = circuit.file.wiring.pins
    pump, reverse = pins.pump_gate, pins.pump_back_gate
    if pump % 16 == reverse % 16:
        yield f"pump_gate and pump_back_gate: GP{pump} and GP{reverse} are one PWM channel"


def _bus(circuit: Circuit) -> Iterator[str]:
    """Yield SPI pins that are not on one port, or not in their places."""
    if circuit.file.wiring.sensor_kind != "hsc":
        return
    numbers, ports = asdict(circuit.file.wiring.pins), set()
    for use, spot in SPI.items():
        number = numbers[use]
        if use == "spi_cs":  # any pin works
            continue
        ports.add(number // 8 % 2)
        if number % 4 != spot:
            yield f"{use}: GP{number} is another pin of SPI; GP{spot}, GP{spot + 4} and so on do"
    if len(ports) > 1:
        yield "the SPI pins belong to two different ports"


def _gates(circuit: Circuit) -> Iterator[str]:
    """Yield gates that float in reset, without a small pull-down."""
    for wire in circuit.wires:
        down = ohms(wire.shunt)
        if wire.use in GATES and (down is None or down > PULL_DOWN):
            yield (
                f"{wire.use}: {wire.label} needs a pull-down of 8.2 kΩ or less at the gate, and "
                f"has {wire.shunt or 'none'}: the pin floats while the board is in reset"
            )


def _voltages(circuit: Circuit) -> Iterator[str]:
    """Yield pins that get too much voltage from a divider."""
    limit = circuit.file.wiring.reference_voltage
    for wire in circuit.wires:
        if wire.volts is None:
            continue
        above, below = ohms(wire.series), ohms(wire.shunt)
        left = wire.volts
        if above is not None and below is not None:
            left *= below / (above + below)
        if left > limit:
            yield f"{wire.name}: {left:.2f} V reach {wire.label}, which bears {limit:.2f} V"
