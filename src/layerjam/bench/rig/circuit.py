"""Circuit around a board: socket, wires, components, parts to order, and conflicts."""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

from layerjam.bench.rig.wiring import WiringFile, load_wiring

PICO = Path(__file__).parent / "circuits" / "pico.toml"
PULL_DOWN = 8.2e3
"""Largest pull-down [ohm] that keeps a gate at GND while its pin floats (RP2350 erratum E9)."""
GATES = ("pump_gate", "vent_gate")
"""Outputs that must be off while the board is held in reset."""
INSIDE = ("led_out",)
"""Pins that are connected on the board itself and need no wire."""
SPI = {"spi_miso": 0, "spi_cs": 1, "spi_sck": 2, "spi_mosi": 3}
"""{SPI signal: GP number mod 4}; GP n belongs to SPI port (n // 8) mod 2 (datasheet)."""
UNITS = {"resistor": "Ω", "capacitor": "F"}
PREFIXES = {6: "M", 3: "k", 0: "", -6: "µ", -9: "n", -12: "p"}


@dataclass(frozen=True, kw_only=True)
class Wire:
    """One wire, from a pin of the board's socket, through any parts, to its far end."""

    pin: int | None
    """Pin of the socket, or None; if several have the same label, the first one."""
    label: str
    """Label of the pin, such as GP16, GND or VSYS."""
    use: str | None
    """Name of the pin's function in the board file; None for a supply pin."""
    name: str
    to: str
    series: str | None
    shunt: str | None
    """Parts between the wire and GND: after `series` at a gate, otherwise at the pin."""
    volts: float | None
    """Highest voltage at the far end of the wire [V]."""
    source: str


@dataclass(frozen=True, kw_only=True)
class Component:
    """One component: its nodes in SPICE order, and its value and limits in SI units."""

    ref: str
    kind: str
    nodes: tuple[str, ...]
    numbers: Mapping[str, float]

    def __getattr__(self, name: str) -> float:
        try:
            return self.numbers[name]
        except KeyError:
            raise AttributeError(f"{self.ref} has no {name}") from None

    def value_at(self, sign: int) -> float:
        """Return the value at a limit of its tolerance (sign -1 or 1) or its nominal value (0)."""
        return self.value * (1.0 + sign * self.tolerance)

    @property
    def text(self) -> str:
        """Return the value with its unit, such as 8.2 kΩ; the reference if it has no value."""
        unit = UNITS.get(self.kind)
        if unit is None:
            return f"{self.kind} {self.ref}"
        power = max(p for p in PREFIXES if self.value >= 10.0**p * (1 - 1e-9))
        return f"{self.value / 10.0**power:g} {PREFIXES[power]}{unit}"


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part to order: its number, alternatives, limits (data sheet) and computed values."""

    refs: str
    name: str
    number: str
    alternatives: tuple[str, str]
    sheet: str
    ours: str
    read: str
    """Values that were read from a copy of the data sheet."""


@dataclass(frozen=True, kw_only=True)
class Circuit:
    """A board with all parts connected to it."""

    file: WiringFile
    pins: int
    socket: Mapping[str, int]
    """{label: pin of the socket}; if several pins have the same label, the first one."""
    grounds: tuple[int, ...]
    rails: Mapping[str, tuple[float, float]]
    """{node: lowest and highest voltage [V]}."""
    declared: tuple[Mapping[str, str], ...]
    """Wires as declared in the file."""
    components: Mapping[str, Component]
    parts: tuple[Part, ...]

    @property
    def board(self) -> str:
        """Return the board's name."""
        return self.file.title or self.file.name

    @cached_property
    def wires(self) -> tuple[Wire, ...]:
        """Return the wires with the parts on them."""
        return tuple(_make_wire(self, entry) for entry in self.declared)

    def find_parts(self, first: str, *others: str) -> list[Component]:
        """Return the components between the node `first` and one of `others`."""
        pairs = [{first, node} for node in others]
        return [c for c in self.components.values() if len(c.nodes) == 2 and set(c.nodes) in pairs]

    def get_series_part(self, node: str) -> tuple[Component | None, str]:
        """Return the part in series with a pin, or None, and the node after it."""
        for part in self.components.values():
            if len(part.nodes) == 2 and node in part.nodes and "GND" not in part.nodes:
                return part, part.nodes[part.nodes[0] == node]
        return None, node

    def find_divider(self, use: str) -> tuple[Component, Component, Component]:
        """Return (upper resistor, lower resistor, capacitor) of a pin's divider."""
        lower, capacitor = sorted(self.find_parts(use, "GND"), key=lambda c: c.kind, reverse=True)
        (upper,) = self.find_parts(use, *self.rails)
        return upper, lower, capacitor

    def list_conflicts(self) -> tuple[str, ...]:
        """Return each conflict between pins and parts as a sentence."""
        rules = (_check_sockets, _check_channels, _check_bus, _check_gates, _check_ratio)
        return tuple(text for rule in rules for text in rule(self))


def load_circuit(board: str | Path, circuit: Path = PICO) -> Circuit:
    """Return the circuit of a board; `circuit` is the TOML file of its socket and parts.

    Raises UnknownNameError or FileError.
    """
    data = tomllib.loads(circuit.read_text("utf-8"))
    socket = {
        label: pin if isinstance(pin, int) else pin[0]
        for label, pin in data["socket"].items()
        if label != "count"
    }
    common_keys = ("ref", "kind", "nodes")
    return Circuit(
        file=load_wiring(board),
        pins=data["socket"]["count"],
        socket=socket,
        grounds=tuple(data["socket"]["GND"]),
        rails={name: (low, high) for name, (low, high) in data["rails"].items()},
        declared=tuple(data["wire"]),
        components={
            row["ref"]: Component(
                ref=row["ref"],
                kind=row["kind"],
                nodes=tuple(row["nodes"]),
                numbers={key: value for key, value in row.items() if key not in common_keys},
            )
            for row in data["component"]
        },
        parts=tuple(
            Part(**{**row, "alternatives": tuple(row["alternatives"])}) for row in data["part"]
        ),
    )


def _make_wire(circuit: Circuit, entry: Mapping[str, str]) -> Wire:
    use = entry.get("use")
    node = use or entry["pin"]
    series, end = (None, node) if node in ("GND", *circuit.rails) else circuit.get_series_part(node)
    rail = circuit.rails.get(end) if use else None
    # a divider ends at a rail, and at a gate the pull-down comes after the series resistor
    shunts = circuit.find_parts(node if end in circuit.rails else end, "GND")
    label = entry["pin"] if use is None else f"GP{getattr(circuit.file.wiring.pins, use)}"
    return Wire(
        pin=circuit.socket.get(label),
        label=label,
        use=use,
        name=entry["name"],
        to=entry["to"],
        series=series.text if series else None,
        shunt=", ".join(c.text for c in shunts) if use and shunts else None,
        volts=rail[1] if rail else None,
        source=entry.get("source", ""),
    )


def _check_sockets(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict for each pin in use that the socket does not have."""
    for use, number in asdict(circuit.file.wiring.pins).items():
        if use not in INSIDE and f"GP{number}" not in circuit.socket:
            yield f"{use}: GP{number} is not connected to a pin of the socket"


def _check_channels(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict if the two inputs of the pump driver share a PWM channel."""
    pins = circuit.file.wiring.pins
    pump, reverse = pins.pump_gate, pins.pump_back_gate
    if pump % 16 == reverse % 16:
        yield f"pump_gate and pump_back_gate: GP{pump} and GP{reverse} share one PWM channel"


def _check_bus(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict for each unsuitable SPI pin, and if the pins belong to different ports."""
    if circuit.file.wiring.sensor_kind != "hsc":
        return
    numbers, ports = asdict(circuit.file.wiring.pins), set()
    for use, spot in SPI.items():
        number = numbers[use]
        if use == "spi_cs":  # any pin works
            continue
        ports.add(number // 8 % 2)
        if number % 4 != spot:
            yield f"{use}: GP{number} is a different SPI pin; use GP{spot}, GP{spot + 4} and so on"
    if len(ports) > 1:
        yield "the SPI pins belong to two different ports"


def _check_gates(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict for each gate that has no pull-down small enough to hold it at GND."""
    for wire in circuit.wires:
        if wire.use not in GATES:
            continue
        down = circuit.find_parts(circuit.get_series_part(wire.use)[1], "GND")
        if not down or down[0].value > PULL_DOWN:
            yield (
                f"{wire.use}: {wire.label} needs a pull-down of 8.2 kΩ or less at the gate but "
                f"has {wire.shunt or 'none'}; the pin floats while the board is in reset"
            )


def _check_ratio(circuit: Circuit) -> Iterator[str]:
    """Yield a conflict if the board file and the circuit have different supply divider ratios."""
    upper, lower, _ = circuit.find_divider("supply_adc")
    ratio, in_file = 1.0 + upper.value / lower.value, circuit.file.wiring.supply_ratio
    if abs(ratio / in_file - 1.0) > 1e-3:
        yield f"supply_ratio is {in_file:g}, but the resistors of the supply sense give {ratio:g}"
