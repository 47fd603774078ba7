"""The wiring of a board as a drawing: socket, wires with their parts, power, air, warnings."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from layerjam.rig.circuit import GATES, Circuit, Wire

WIDTH = 1180
ROW = 62
INK, FAINT, WARN, GROUND, POWER, SIGNAL = (
    "#1b1b1b",
    "#8a8a8a",
    "#b3261e",
    "#4a4a4a",
    "#b35900",
    "#1f5fa8",
)
BOARD_X, BOARD_Y, PITCH = 150, 96, 27
WIRES_X = 480
PORTS = (
    "Safe state RELEASE: the port that is open without power (NO) leads to the atmosphere. HOLD: "
    "the port that is closed without power (NC) does, and a non-return valve sits at the pump."
)
STYLE = """
text { font-family: DejaVu Sans, Helvetica, Arial, sans-serif; font-size: 13px; fill: #1b1b1b }
.small { font-size: 11px } .big { font-size: 20px; font-weight: bold }
.head { font-size: 15px; font-weight: bold } .faint { fill: #6b6b6b } .warn { fill: #b3261e }
.mid { text-anchor: middle } .end { text-anchor: end } .bold { font-weight: bold }
"""


class Pen:
    """Elements of an SVG, in order."""

    def __init__(self) -> None:
        self.parts: list[str] = []

    def text(self, x: float, y: float, text: str, kind: str = "") -> None:
        """A text; `kind` are classes of STYLE."""
        self.parts.append(f'<text x="{x:g}" y="{y:g}" class="{kind}">{escape(text)}</text>')

    def line(self, *points: tuple[float, float], color: str = INK, wide: float = 1.6) -> None:
        """A wire through points."""
        path = " ".join(f"{x:g},{y:g}" for x, y in points)
        self.parts.append(
            f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="{wide:g}"/>'
        )

    def box(
        self, x: float, y: float, wide: float, high: float, *, fill: str = "#fff", color: str = INK
    ) -> None:
        """A rectangle."""
        self.parts.append(
            f'<rect x="{x:g}" y="{y:g}" width="{wide:g}" height="{high:g}" rx="3" fill="{fill}" '
            f'stroke="{color}" stroke-width="1.4"/>'
        )

    def dot(self, x: float, y: float, color: str = INK) -> None:
        """Where wires are joined."""
        self.parts.append(f'<circle cx="{x:g}" cy="{y:g}" r="3.4" fill="{color}"/>')

    def ring(self, x: float, y: float, fill: str) -> None:
        """A pin of a socket."""
        self.parts.append(f'<circle cx="{x:g}" cy="{y:g}" r="7" fill="{fill}" stroke="{INK}"/>')

    def ground(self, x: float, y: float) -> None:
        """The sign of GND, hung at a point."""
        self.line((x, y), (x, y + 5), color=GROUND)
        for step, half in enumerate((9, 6, 3)):
            at = y + 5 + 3.5 * step
            self.line((x - half, at), (x + half, at), color=GROUND)

    def part(self, x: float, y: float, wide: float, text: str) -> None:
        """A part in a horizontal wire, its middle at a point."""
        self.box(x - wide / 2, y - 11, wide, 22)
        self.text(x, y + 4.5, text, "mid small")


def drawing(made: Circuit) -> str:
    """The SVG of a board's wiring."""
    pen = Pen()
    pen.text(28, 40, f"Wiring of {made.board}", "big")
    pen.text(
        28, 62, "Seen from above, USB at the top. Signals below 3.3 V; all GND are one.", "faint"
    )
    _socket(pen, made)
    bottom = _wires(pen, made)
    bottom = max(bottom, BOARD_Y + 20 * PITCH + 60) + 20
    bottom = _power(pen, bottom)
    bottom = _air(pen, bottom)
    bottom = _warnings(pen, made, bottom)
    bottom = _parts(pen, made, bottom)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {bottom:g}" '
        f'width="{WIDTH}" height="{bottom:g}">\n<style>{STYLE}</style>\n'
        f'<rect width="{WIDTH}" height="{bottom:g}" fill="#fff"/>\n'
        + "\n".join(pen.parts)
        + "\n</svg>\n"
    )


def place(pin: int, pins: int) -> tuple[float, float, bool]:
    """(x, y, whether on the left side) of a pin of the socket."""
    half = pins // 2
    left = pin <= half
    row = pin - 1 if left else pins - pin
    return BOARD_X + (0 if left else 150), BOARD_Y + 26 + PITCH * row, left


def _socket(pen: Pen, made: Circuit) -> None:
    """The board from above; used pins are filled, with what they are for."""
    half = made.pins // 2
    high = PITCH * half + 24
    pen.box(BOARD_X - 12, BOARD_Y, 174, high, fill="#e8f1e6")
    pen.box(BOARD_X + 50, BOARD_Y - 12, 50, 22, fill="#d0d0d0")
    pen.text(BOARD_X + 75, BOARD_Y + 3, "USB", "mid small")
    labels = {pin: label for label, pin in made.socket.items()}
    labels |= dict.fromkeys(made.grounds, "GND")
    uses = {wire.pin: wire for wire in made.wires}
    for pin in range(1, made.pins + 1):
        x, y, left = place(pin, made.pins)
        wire = uses.get(pin)
        color = _color(wire) if wire else "#fff"
        pen.ring(x, y, color)
        pen.text(
            x + (14 if left else -14), y + 4, labels.get(pin, ""), "small" if left else "small end"
        )
        kind = "small bold" if wire else "small faint"
        pen.text(x + (-22 if left else 22), y + 4, str(pin), f"{kind} end" if left else kind)
        if wire:
            what = wire.use or wire.label
            pen.text(x + (-44 if left else 44), y + 4, what, "small end" if left else "small")


def _color(wire: Wire) -> str:
    if wire.use is None:
        return GROUND if wire.label == "GND" else POWER
    return WARN if wire.use in GATES else SIGNAL


def _wires(pen: Pen, made: Circuit) -> float:
    """One row a wire: pin, pull-down or divider, series part, end."""
    pen.text(WIRES_X, BOARD_Y - 6, "Wires", "head")
    y = BOARD_Y + 26.0
    for wire in made.wires:
        color = _color(wire)
        pen.box(WIRES_X, y - 13, 112, 26, fill="#f4f4f4")
        pen.text(WIRES_X + 8, y + 4.5, f"{wire.label}", "bold")
        pen.text(WIRES_X + 104, y + 4.5, f"pin {wire.pin or '–'}", "end small")
        end = WIRES_X + 400
        pen.line((WIRES_X + 112, y), (end, y), color=color)
        gate = wire.use in GATES
        if wire.series:
            pen.part(WIRES_X + (180 if gate else 330), y, 70, wire.series)
        if wire.shunt:
            _shunt(pen, WIRES_X + (240 if gate else 150), y, wire.shunt, color)
        pen.text(WIRES_X + 122, y - (15 if gate else 6), wire.name, "small faint")
        pen.text(end + 8, y + 4.5, wire.to)
        y += ROW if wire.shunt else ROW - 20
    return y


def _shunt(pen: Pen, x: float, y: float, text: str, color: str) -> None:
    """A part from a point of a wire to GND."""
    pen.dot(x, y, color)
    pen.line((x, y), (x, y + 20), (x + 14, y + 20), color=color)
    pen.part(x + 63, y + 20, 98, text)
    pen.line((x + 112, y + 20), (x + 126, y + 20), color=color)
    pen.ground(x + 126, y + 20)


def _switch(pen: Pen, x: float, top: float, load: str, name: str, number: int) -> None:
    """A load between 12 V and a MOSFET, with its diode, the gate to the left."""
    pen.line((x, top), (x, top + 22), color=POWER)
    pen.box(x - 46, top + 22, 92, 34, fill="#fdf3e7")
    pen.text(x, top + 43, load, "mid")
    pen.text(x + 7, top + 17, "+", "small")
    pen.line((x, top + 56), (x, top + 96))
    pen.dot(x, top, POWER)
    pen.dot(x, top + 72)
    pen.line((x, top + 72), (x + 86, top + 72), (x + 86, top + 48))
    pen.line((x + 86, top + 30), (x + 86, top), color=POWER)
    pen.dot(x + 86, top, POWER)
    tip = f"{x + 86:g},{top + 30:g} {x + 76:g},{top + 48:g} {x + 96:g},{top + 48:g}"
    pen.parts.append(f'<polygon points="{tip}" fill="#fff" stroke="{INK}" stroke-width="1.4"/>')
    pen.line((x + 75, top + 30), (x + 97, top + 30))
    pen.text(x + 104, top + 44, f"D{number}")
    pen.text(x + 104, top + 59, "bar (cathode) to +", "small faint")
    pen.box(x - 30, top + 96, 60, 40, fill="#f4f4f4")
    pen.text(x, top + 121, f"Q{number}", "mid bold")
    pen.text(x + 8, top + 90, "drain", "small faint")
    pen.text(x + 36, top + 132, "source", "small faint")
    pen.ground(x, top + 136)
    pen.line((x - 30, top + 116), (x - 62, top + 116), color=WARN)
    pen.text(x - 66, top + 113, "gate", "end small")
    pen.text(x - 66, top + 127, name, "end small faint")


def _power(pen: Pen, top: float) -> float:
    """12 V, fuse, emergency stop, pump and valve with their transistors and diodes."""
    pen.text(28, top, "Power: the emergency stop cuts pump and valve, not the board", "head")
    y = top + 40
    pen.box(28, y - 14, 74, 28, fill="#fdf3e7")
    pen.text(65, y + 4.5, "+12 V", "mid bold")
    pen.line((102, y), (1010, y), color=POWER)
    pen.part(152, y, 54, "fuse")
    pen.dot(206, y, POWER)
    pen.line((206, y), (206, y + 46), color=POWER)
    pen.box(146, y + 46, 120, 40, fill="#fdf3e7")
    pen.text(206, y + 63, "buck 12 V → 5 V", "mid small")
    pen.text(206, y + 78, "to VSYS, pin 39", "mid small")
    pen.ground(206, y + 86)
    pen.box(330, y - 16, 128, 32, fill="#fbe9e7", color=WARN)
    pen.text(394, y - 1, "E-STOP", "mid bold")
    pen.text(394, y + 12, "normally closed", "mid small")
    pen.dot(500, y, POWER)
    pen.line((500, y), (500, y + 30), color=POWER)
    pen.text(500, y + 44, "100 kΩ to the", "mid small")
    pen.text(500, y + 57, "e-stop sense", "mid small")
    _switch(pen, 668, y, "pump", "from its 150 Ω", 1)
    _switch(pen, 924, y, "vent valve", "from its 150 Ω", 2)
    return y + 186


def _air(pen: Pen, top: float) -> float:
    """Tubes: brake, sensor, valve, pump."""
    pen.text(28, top, "Air", "head")
    y = top + 40
    for x, wide, text in (
        (28, 80, "brake"),
        (310, 150, "3/2 valve, common"),
        (560, 120, "pump, inlet"),
    ):
        pen.box(x, y - 16, wide, 32, fill="#eef3fa")
        pen.text(x + wide / 2, y + 4.5, text, "mid")
    pen.line((108, y), (310, y), color=SIGNAL, wide=3)
    pen.line((460, y), (560, y), color=SIGNAL, wide=3)
    pen.dot(200, y, SIGNAL)
    pen.line((200, y), (200, y + 34), color=SIGNAL, wide=3)
    pen.box(130, y + 34, 140, 30, fill="#eef3fa")
    pen.text(200, y + 53, "pressure sensor", "mid")
    pen.line((385, y + 16), (385, y + 38), color=SIGNAL, wide=3)
    pen.text(385, y + 54, "to the atmosphere", "mid small")
    for row, words in enumerate(_broken(PORTS, 64)):
        pen.text(720, y - 12 + 16 * row, words, "small")
    return y + 100


def _rules(made: Circuit) -> Iterator[str]:
    yield (
        "Solder the pull-downs of both gates first (8.2 kΩ or less): while the board is in reset "
        "its pins float, and a gate without one may switch the pump on."
    )
    yield (
        "Without power the vent must go to your safe state by itself. Try it with the board "
        "unplugged: RELEASE opens, HOLD stays shut. No program can make up for a wrong valve."
    )
    yield "Diodes across pump and valve, the bar to plus. Without them the transistors die."
    yield "One sensor cannot see its own drift: do not hang a person on this bench."
    for text in made.conflicts():
        yield f"CONFLICT: {text}"


def _warnings(pen: Pen, made: Circuit, top: float) -> float:
    pen.text(28, top, "Before you switch on", "head warn")
    y = top + 24
    for number, text in enumerate(_rules(made), 1):
        for line, words in enumerate(_broken(text, 136)):
            pen.text(52, y, words, "warn" if text.startswith("CONFLICT") else "")
            if line == 0:
                pen.text(30, y, f"{number}.", "bold")
            y += 19
    return y + 24


def _parts(pen: Pen, made: Circuit, top: float) -> float:
    if not made.parts:
        return top
    pen.text(28, top, "Parts", "head")
    y = top + 24
    for part in made.parts:
        pen.text(30, y, part.name, "bold")
        pen.text(300, y, part.pick)
        pen.text(820, y, part.status, "faint")
        y += 21
    return y + 16


def _broken(text: str, most: int) -> list[str]:
    """A text in lines of so many letters."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) >= most:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
