"""Worst case of the bench's electronics: voltages, currents, times and heat, with their limits.

Formulas and sources are in docs/hardware.md. Every tolerance is taken at its worst limit.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from layerjam.bench.rig.circuit import GATES, Circuit

HIGH, LOW = 2.0, 0.8
"""RP2040 input thresholds [V]: high above the first, low below the second (datasheet, 5.2.3)."""
OUTPUT, DRIVE = 2.62, 12e-3
"""Lowest voltage [V] of a high output, and its maximum rated current [A] (same source)."""
LEAKAGE = 1e-6
"""Maximum current into an input [A] (same source)."""
REFERENCE = (0.971, 1.02)
"""Limits of the converter's reference relative to its nominal value: ±2 % of 3.3 V (assumed), less
30 mV across its filter (Pico datasheet, 4.3)."""
CONVERTER = 10 / 4096
"""Error of the converter relative to its range: 7.85 LSB were measured (pico-adc.markomo.me)."""
SAMPLE = 0.01
"""Time between two samples of the board [s]."""
NOMINAL, VALVE = 12.0, 0.85
"""Supply voltage [V], and the fraction of it that the valve needs (SMC: -15 %, source not read)."""
PLATEAU = 1.5
"""Assumed gate voltage [V] at which a transistor switches; higher than for any listed part."""
BOARD = 0.1
"""Current of board and sensors [A] at 5 V; also used for 12 V, where the current is smaller."""
CARRIED = 0.75
"""Fraction of its rated current that a fuse can carry continuously."""


@dataclass(frozen=True)
class Margin:
    """Worst-case value of a quantity in the circuit, and the limit that it must not cross."""

    name: str
    unit: str
    value: float
    least: float = -math.inf
    most: float = math.inf

    def fields(self) -> dict[str, object]:
        """Return the fields as a dictionary, without infinite limits."""
        return {key: v for key, v in vars(self).items() if isinstance(v, str) or math.isfinite(v)}

    @property
    def is_within_limits(self) -> bool:
        """Whether the value is within the limits."""
        return self.least <= self.value <= self.most

    @property
    def sentence(self) -> str:
        """Return a sentence with the value and its limit."""
        limit = (
            f"at most {self.most:.3g}" if math.isfinite(self.most) else f"at least {self.least:.3g}"
        )
        return f"{self.name}: {self.value:.3g} {self.unit}, {limit} {self.unit}"


def compute_margins(circuit: Circuit) -> tuple[Margin, ...]:
    """Return the quantities of the circuit with their limits."""
    groups = (_sense_margins, _supply_margins, _gate_margins, _power_margins)
    return tuple(margin for group in groups for margin in group(circuit))


def find_conflicts(circuit: Circuit) -> tuple[str, ...]:
    """Return the pin conflicts of a circuit or, if there are none, the limits that it violates."""
    return circuit.list_conflicts() or tuple(
        m.sentence for m in compute_margins(circuit) if not m.is_within_limits
    )


def trip_voltages(circuit: Circuit) -> tuple[float, float]:
    """Return the lowest and highest supply [V] at which the board may report a low supply."""
    upper, lower, _ = circuit.find_divider("supply_adc")
    wiring, ends = circuit.file.wiring, []
    for sign, reference in zip((-1, 1), REFERENCE, strict=True):
        pin = wiring.least_supply / wiring.supply_ratio * reference
        pin += sign * CONVERTER * wiring.reference_voltage
        ratio = 1.0 + upper.value_at(sign) / lower.value_at(-sign)
        ends.append(pin * ratio + sign * LEAKAGE * upper.value_at(1))
    return ends[0], ends[1]


def pin_voltage(circuit: Circuit, use: str, volts: float, sign: int) -> float:
    """Return the lowest (sign -1) or highest (1) voltage [V] at the pin of a divider."""
    upper, lower = (
        part.value_at(s) for part, s in zip(circuit.find_divider(use), (-sign, sign), strict=False)
    )
    return lower / (upper + lower) * (volts + sign * LEAKAGE * upper)


def _sense_margins(circuit: Circuit) -> Iterator[Margin]:
    parts, stop = circuit.components, "estop_sense"
    high, least_supply = circuit.rails["12V"][1], circuit.rails["3V3"][0]
    closed_voltage = pin_voltage(circuit, stop, trip_voltages(circuit)[0], -1)
    yield Margin("pin voltage, emergency stop closed", "V", closed_voltage, least=HIGH)
    for use in (stop, "supply_adc", "accelerometer_adc"):
        rail = circuit.rails[circuit.get_series_part(use)[1]][1]
        highest_voltage = pin_voltage(circuit, use, rail, 1)
        yield Margin(f"highest voltage at {use}", "V", highest_voltage, most=least_supply)
    # with the stop open, R7 pulls the node down; the filter discharges through R7, R8 and R9
    upper, lower, capacitor = (part.value_at(1) for part in circuit.find_divider(stop))
    resistance = 1.0 / (1.0 / (upper + parts["R7"].value_at(1)) + 1.0 / lower)
    open_voltage, begin = LEAKAGE * resistance, pin_voltage(circuit, stop, high, 1)
    yield Margin("pin voltage, emergency stop open", "V", open_voltage, most=LOW)
    time = capacitor * resistance * math.log((begin - open_voltage) / (LOW - open_voltage))
    yield Margin("time until an open stop is sensed", "s", time, most=SAMPLE)
    yield Margin("power of R7", "W", high**2 / parts["R7"].value_at(-1), most=parts["R7"].power)


def _supply_margins(circuit: Circuit) -> Iterator[Margin]:
    parts, five = circuit.components, circuit.rails["5V"]
    lowest, highest = trip_voltages(circuit)
    yield Margin("lowest supply voltage that is accepted", "V", lowest, least=VALVE * NOMINAL)
    yield Margin(
        "highest supply voltage that is reported as low",
        "V",
        highest,
        most=circuit.rails["12V"][0],
    )
    yield Margin("input voltage of U1", "V", lowest, least=parts["U1"].least_input)
    yield Margin("lowest voltage at VSYS", "V", five[0] - parts["D3"].forward, least=1.8)
    yield Margin("highest voltage at VSYS", "V", five[1], most=5.5)


def _gate_margins(circuit: Circuit) -> Iterator[Margin]:
    for use in GATES:
        gate = circuit.get_series_part(use)[1]
        (series,) = circuit.find_parts(use, gate)
        (down,) = circuit.find_parts(gate, "GND")
        (switch,) = (c for c in circuit.components.values() if c.nodes[1] == gate != c.nodes[-1])
        gate_voltage = OUTPUT * down.value_at(-1) / (down.value_at(-1) + series.value_at(1))
        yield Margin(f"gate voltage of {switch.ref}, on", "V", gate_voltage, least=switch.gate)
        reset = LEAKAGE * down.value_at(1)
        yield Margin(f"gate voltage of {switch.ref}, in reset", "V", reset, most=switch.threshold)
        peak = circuit.rails["3V3"][1] / series.value_at(-1)
        yield Margin(f"current into the gate of {switch.ref}", "A", peak, most=DRIVE)


def switching_heat(circuit: Circuit) -> float:
    """Return the switching loss of Q1 while the pump runs [W]; an edge lasts Q_gd / I_gate."""
    parts = circuit.components
    edges = 2.0 * parts["Q1"].miller * parts["R1"].value_at(1) / (OUTPUT - PLATEAU)
    energy = 0.5 * circuit.rails["12V"][1] * parts["M1"].running * edges
    return energy * circuit.file.wiring.pump_frequency


def _power_margins(circuit: Circuit) -> Iterator[Margin]:
    parts, high, clamp = circuit.components, circuit.rails["12V"][1], circuit.components["D4"].clamp
    heats = {"Q1": switching_heat(circuit), "Q2": 0.0}
    for n, name in (("1", "M1"), ("2", "Y1")):
        switch, diode, load = parts[f"Q{n}"], parts[f"D{n}"], parts[name]
        drain = clamp + diode.forward
        yield Margin(f"drain–source voltage of {switch.ref}", "V", drain, most=switch.voltage)
        heat = heats[switch.ref] + load.running**2 * switch.value
        yield Margin(f"power of {switch.ref}", "W", heat, most=switch.power)
        # heat with a stalled load at half power, where the diode and C1 carry the most current
        half = 0.5 * high / load.value
        yield Margin(f"mean current of {diode.ref}", "A", half, most=diode.current)
        yield Margin(f"reverse voltage of {diode.ref}", "V", clamp, most=diode.voltage)
    ripple = 0.5 * high / parts["M1"].value
    yield Margin("ripple current of C1", "A", ripple, most=parts["C1"].ripple)
    yield Margin("voltage of C1", "V", high, most=parts["C1"].voltage)
    yield Margin("voltage of C2", "V", clamp, most=parts["C2"].voltage)
    yield Margin("current of D5", "A", parts["M1"].running, most=parts["D5"].current)
    yield Margin("current of D3", "A", BOARD, most=parts["D3"].current)
    yield Margin("stand-off voltage of D4", "V", high, most=parts["D4"].standoff)
    total = parts["M1"].running + parts["Y1"].running + BOARD
    yield Margin("current of F1", "A", total, most=CARRIED * parts["F1"].current)
    start_current = high / parts["M1"].value + parts["Y1"].running
    yield Margin(
        "current of S1 while the pump starts", "A", start_current, most=parts["S1"].current
    )


def release_time(circuit: Circuit, volts: float, release_share: float = 0.3) -> float:
    """Return the time [s] for the valve's current to fall to the fraction `release_share`.

    `volts` is the diode voltage that opposes the current: 0.5 V, or more with a Zener diode.
    """
    coil = circuit.components["Y1"]
    ratio = (NOMINAL + volts) / (release_share * NOMINAL + volts)
    return coil.inductance / coil.value * math.log(ratio)
