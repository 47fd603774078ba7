"""The wiring of a board as a circuit diagram, drawn with schemdraw from its declaration."""

import itertools
import textwrap
from collections.abc import Iterator
from typing import Any

from layerjam.bench.rig.circuit import GATES, UNITS, Circuit
from layerjam.bench.rig.electronics import find_conflicts
from layerjam.core.errors import MissingExtraError

SYMBOLS = {
    "resistor": "ResistorIEC",
    "capacitor": "Capacitor",
    "schottky": "Schottky",
    "tvs": "Zener",
    "fuse": "Fuse",
    "motor": "Motor",
    "coil": "Inductor2",
}
"""{kind of component: its symbol in schemdraw}."""
TEXT, LABEL = 14.0, 12.0
"""Font sizes of notes and of parts [pt]: readable if a page scales the drawing to 700 pixels."""
WIDTH, BOTTOM = 26.0, -43.0
"""Width, and height of the first line of notes, in the units of the drawing (36 pt)."""
LINE, LETTERS = 0.57, 4.4
"""Distance between lines of text, and mean number of letters in a unit."""
AIR = (
    "AIR: brake – T-piece (pressure sensor) – common port of the 3/2 valve – pump inlet.",
    "Safe state RELEASE: the port that is open when unpowered (NO) leads to the atmosphere.",
    "Safe state HOLD: the port that is closed when unpowered (NC) leads to the atmosphere, "
    "and the pump has a non-return valve.",
)


def draw_wiring(circuit: Circuit) -> str:
    """Return the SVG of a board's wiring; raises MissingExtraError if schemdraw is missing."""
    with MissingExtraError.raise_if_missing("a circuit diagram (schemdraw)", "bench"):
        import schemdraw
        from schemdraw import elements
    sheet = schemdraw.Drawing(canvas="svg", show=False, fontsize=LABEL, unit=2.2, lw=1.6)
    sheet.config(font="DejaVu Sans, Helvetica, Arial, sans-serif", bgcolor="white")
    pen = _Pen(sheet, elements, circuit)
    pen.write(0, 3.4, f"Wiring of {circuit.board}", size=22)
    pen.write(
        0,
        2.4,
        "Board from above, USB at the top. Identical framed labels, and all GND, are connected.",
    )
    pen.board((5.2, 1.2))
    pen.signals(16.1, 0.4)
    pen.bridge(13.4, -17.2)
    pen.power(0.4, -22.0)
    for row, line in enumerate(_list_lines(circuit)):
        pen.write(0, BOTTOM - LINE * row, line)
    return str(sheet.get_imagedata("svg").decode("utf-8"))


class _Pen:
    """Elements of one drawing, placed at points of its sheet."""

    def __init__(self, sheet: Any, elements: Any, circuit: Circuit) -> None:
        self.sheet, self.elements, self.circuit = sheet, elements, circuit

    def add(self, item: Any, spot: Any, end: Any = None, label: str = "", loc: str = "top") -> Any:
        """Place an element at a point, or between two points, and return it."""
        item = item.at(spot)
        if end is not None:
            item = item.to(end)
        return self.sheet.add(item.label(label, loc=loc, fontsize=LABEL) if label else item)

    def wire(self, *points: Any) -> None:
        """Draw a wire through points."""
        for start, end in itertools.pairwise(points):
            self.add(self.elements.Line(), start, end)

    def write(self, x: float, y: float, text: str, size: float = TEXT) -> None:
        """Write a text that starts at a point."""
        item = self.elements.Label().label(text, fontsize=size, halign="left", ofst=0)
        self.sheet.add(item.at((x, y)))

    def part(self, ref: str, start: Any, end: Any, loc: str = "top") -> Any:
        """Draw a component between two points, with its reference and value."""
        part = self.circuit.components[ref]
        name = f"{ref}\n{part.text}" if part.kind in UNITS else ref
        return self.add(getattr(self.elements, SYMBOLS[part.kind])(), start, end, name, loc)

    def ground(self, ref: str, point: Any, length: float = 2.2) -> None:
        """Draw a component from a point on a wire to GND."""
        end = (point[0], point[1] - length)
        is_turned = self.circuit.components[ref].kind == "tvs"
        self.add(self.elements.Dot(), point)
        self.part(ref, end if is_turned else point, point if is_turned else end, "bottom")
        self.add(self.elements.Ground(), end)

    def tag(self, point: Any, text: str, direction: str = "right") -> None:
        """Draw a framed label; all labels with the same text are connected."""
        item = self.elements.Tag(width=max(1.6, 0.2 * len(text) + 0.6))
        self.add(getattr(item.theta(0), direction)(), point, None, text, "center")

    def chip(self, point: Any, anchor: str, sides: dict[str, str], size: Any, name: str) -> Any:
        """Draw a box with pins, {name: side}, placed by one of its anchors; return the anchors."""
        pins = [
            self.elements.IcPin(name=pin, side=side, anchorname=pin) for pin, side in sides.items()
        ]
        item = (
            self.elements.Ic(pins=pins, size=size, leadlen=0.5, lblsize=LABEL)
            .theta(0)
            .anchor(anchor)
        )
        return self.add(item, point, None, name, "top").absanchors

    def board(self, top: tuple[float, float]) -> None:
        """Draw the socket below a point, with the use of each pin that has one."""
        circuit, half = self.circuit, self.circuit.pins // 2
        labels = {pin: label for label, pin in circuit.socket.items()}
        labels |= dict.fromkeys(circuit.grounds, "GND")
        order = [*range(half, 0, -1), *range(half + 1, circuit.pins + 1)]
        pins = [
            self.elements.IcPin(
                name=labels.get(pin, ""),
                pin=str(pin),
                side="left" if pin <= half else "right",
                anchorname=f"pin{pin}",
            )
            for pin in order
        ]
        size = (4.2, half * 0.92 + 0.6)
        socket = self.elements.Ic(pins=pins, size=size, pinspacing=0.92, leadlen=0.5, lblsize=LABEL)
        socket = self.add(socket.anchor("center"), (top[0], top[1] - size[1] / 2), None, "USB")
        for wire in circuit.wires:
            if wire.pin is not None:
                left = wire.pin <= half
                x, y = socket.absanchors[f"pin{wire.pin}"]
                self.tag((x, y), wire.use or wire.label, "left" if left else "right")

    def signals(self, x: float, y: float) -> None:
        """Draw a row for each wire outside the power section, with its parts and its other end."""
        power = (*GATES, "pump_back_gate", "estop_sense", "supply_adc")
        for wire in self.circuit.wires:
            if wire.use in power or wire.label in ("GND", "VSYS"):
                continue
            series = self.circuit.get_series_part(wire.use)[0] if wire.use else None
            begin = (x + 3.6 * bool(wire.shunt), y)
            end = (begin[0] + (1.0 if series is None else 2.4), y)
            self.tag((x, y), wire.use or wire.label, "left")
            self.wire((x, y), begin)
            self.wire(begin, end) if series is None else self.part(series.ref, begin, end)
            for row, text in enumerate(textwrap.wrap(wire.to, int(LETTERS * (WIDTH - end[0])))):
                self.write(end[0] + 0.2, y - 0.15 - LINE * row, text)
            shunts = self.circuit.find_parts(wire.use, "GND") if wire.use and wire.shunt else []
            for n, shunt in enumerate(shunts):
                self.ground(shunt.ref, (x + 0.6 + 1.8 * n, y), 1.9)
            y -= 3.6 if shunts else 1.75

    def divider(self, use: str, point: Any) -> None:
        """Draw a divider from a point down to a pin's label, with its filter."""
        upper, lower, capacitor = (part.ref for part in self.circuit.find_divider(use))
        middle, right = (point[0], point[1] - 2.2), (point[0] + 2.0, point[1] - 2.2)
        self.add(self.elements.Dot(), point)
        self.part(upper, point, middle, "bottom")
        self.ground(lower, middle)
        self.wire(middle, right)
        self.ground(capacitor, right)
        self.tag(right, use)

    def power(self, x: float, y: float) -> None:
        """Draw the 12 V supply, fuse, emergency stop, converter, pump and valve with switches."""
        self.write(
            x,
            y + 1.6,
            "Power: the emergency stop disconnects the pump and the valve, not the board",
        )
        self.tag((x + 1.8, y), "+12 V", "left")
        self.part("F1", (x + 1.8, y), (x + 4.0, y))
        self.wire((x + 4.0, y), (x + 20.0, y))
        self.ground("D4", (x + 4.6, y))
        self.ground("C1", (x + 6.4, y))
        self.wire((x + 8.6, y), (x + 8.6, y - 2.2))
        self.add(self.elements.Dot(), (x + 8.6, y))
        sides = {"12 V": "left", "5 V": "right", "GND": "bottom"}
        pins = self.chip((x + 8.6, y - 2.2), "12 V", sides, (2.6, 1.6), "U1")
        self.add(self.elements.Ground(), pins["GND"])
        five = pins["5 V"]
        self.part("D3", five, (five[0] + 1.8, five[1]))
        self.tag((five[0] + 1.8, five[1]), "VSYS")
        self.divider("supply_adc", (x + 17.0, y))
        self.tag((x + 20.0, y), "12 V")
        y, stop = y - 6.2, x + 4.0
        self.tag((x + 1.8, y), "12 V", "left")
        self.add(self.elements.Button(nc=True), (x + 1.8, y), (stop, y), "S1 E-STOP")
        self.ground("R7", (stop + 0.8, y))
        self.divider("estop_sense", (stop + 2.8, y))
        self.load("2", "Y1", "vent_gate", (stop + 14.0, y))
        self.wire((stop, y), (stop + 16.4, y))
        self.tag((stop + 16.4, y), "12 V after stop")
        y -= 7.0
        self.tag((stop, y), "12 V after stop", "left")
        self.part("D5", (stop, y), (stop + 2.0, y))
        self.wire((stop + 2.0, y), (stop + 16.4, y))
        self.tag((stop + 16.4, y), "pump plus")
        self.ground("C2", (stop + 3.4, y))
        self.load("1", "M1", "pump_gate", (stop + 14.0, y))

    def load(self, number: str, load: str, use: str, point: Any) -> None:
        """Draw a load from 12 V to its transistor, with diode, gate resistor and pull-down."""
        bottom, side = (point[0], point[1] - 2.6), point[0] + 1.6
        self.add(self.elements.Dot(), point)
        self.part(load, point, bottom)
        self.wire(bottom, (side, bottom[1]))
        self.part(f"D{number}", (side, bottom[1]), (side, point[1]), "bottom")
        switch = self.elements.NFet().anchor("drain").reverse().theta(0)
        ends = self.add(switch, bottom, None, f"Q{number}", "right").absanchors
        self.add(self.elements.Ground(), ends["source"])
        net = self.circuit.get_series_part(use)[1]
        (series,), (pull,) = (
            self.circuit.find_parts(use, net),
            self.circuit.find_parts(net, "GND"),
        )
        corner = (ends["gate"][0] - 0.7, ends["gate"][1])
        self.wire(ends["gate"], corner)
        self.ground(pull.ref, corner)
        self.part(series.ref, (corner[0] - 1.8, corner[1]), corner)
        self.tag((corner[0] - 1.8, corner[1]), use, "left")

    def bridge(self, x: float, y: float) -> None:
        """Draw the H-bridge that replaces Q1 and D1 if the pump runs in both directions."""
        self.write(x, y + 3.4, "H-bridge H1 instead of Q1 and D1,")
        self.write(x, y + 3.4 - LINE, "for a pump that runs in both directions")
        sides = {"IN2": "left", "IN1": "left", "OUT2": "right", "OUT1": "right"}
        sides |= {"VM": "top", "GND": "bottom"}
        pins = self.chip((x + 5.6, y), "IN1", sides, (4.4, 3.4), "")
        self.tag(pins["VM"], "pump plus")
        self.add(self.elements.Ground(), pins["GND"])
        for name, use in (("IN1", "pump_gate"), ("IN2", "pump_back_gate")):
            self.tag(pins[name], use, "left")
        ends = [(pins[name][0] + 0.8, pins[name][1]) for name in ("OUT1", "OUT2")]
        for name, end in zip(("OUT1", "OUT2"), ends, strict=True):
            self.wire(pins[name], end)
        self.part("M1", ends[0], ends[1], "bottom")


def _list_lines(circuit: Circuit) -> Iterator[str]:
    yield from AIR
    rules = (
        "Solder the pull-downs R2 and R4 first: while the board is in reset its pins "
        "float, and a gate without a pull-down may switch on the pump.",
        "Unpowered, the vent must go to your safe state by itself. Test this with the "
        "board unplugged: RELEASE opens, HOLD stays shut. No program can compensate for "
        "a wrong valve.",
        "Mount D1 and D2 with the bar towards the positive supply; without them, Q1 and Q2 fail.",
        "A single sensor cannot detect its own drift: do not hang a person on this bench.",
        *(f"CONFLICT: {text}" for text in find_conflicts(circuit)),
    )
    yield ""
    for number, rule in enumerate(rules, 1):
        yield from textwrap.wrap(f"{number}. {rule}", int(LETTERS * WIDTH), break_on_hyphens=False)
    yield ""
    yield from (f"{part.refs}: {part.name}, {part.number}" for part in circuit.parts)
