"""The declared circuit as a netlist for ngspice, with tolerances, broken wires and a scenario."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from layerjam.bench.rig.circuit import Circuit, Component, load_circuit

BROKEN = 1e9
"""Resistance of a broken wire [ohm]."""
RESET, VALVE, STOP, END = 0.5e-3, 1.6e-3, 2.0e-3, 5e-3
"""Times [s]: the board drives its pins from RESET on, the valve until VALVE; at STOP, the stop."""
MODELS = """
.model NFET NMOS(LEVEL=1 VTO=0.8 KP=20 RD=0.01 RS=0.01 CGSO=1e-9 CGDO=1e-10)
.model BODY D(IS=1e-12 RS=0.02 BV={drain})
.model SCHOTTKY D(IS=1e-6 RS=0.05 CJO=2e-10 BV=40)
.model TVS D(IS=1e-12 RS=0.1 BV=17.6 IBV=1e-3)
.model CLAMP D(IS=1e-14 RS=10)
.model GATE SW(VT=0.5 VH=0 RON=1e-3 ROFF=1e9)
"""
DRAIN = 33.0
"""Voltage at which the transistor's own diode breaks through: 10 % above its rating [V]."""
NAMES = ("supply_adc", "estop_sense", "pump gate", "vent gate", "pump minus", "valve minus", "VSYS")
"""Nodes whose voltages are looked at."""


def missing() -> str:
    """Why the tests here cannot run, "" where they can."""
    return "" if shutil.which("ngspice") else "ngspice is not installed; apt-get install ngspice"


def node(name: str) -> str:
    """Return the name of a node in SPICE."""
    return "0" if name == "GND" else "n_" + name.replace(" ", "_").lower()


def lines(part: Component, sign: int, at: Callable[[int], str]) -> Iterator[str]:
    """Yield the lines of one component between its terminals' nodes."""
    name, kind, a, b = part.ref, part.kind, at(0), at(1)
    if kind in ("resistor", "capacitor"):
        value = part.value * (1 + sign * part.tolerance)
        if name == "C1":  # with the resistance of an electrolytic capacitor
            yield f"R{name} {a} {name}_i {part.resistance}"
            a = f"{name}_i"
        yield f"{name[0]}{name} {a} {b} {value:g}"
    elif kind == "fuse":
        yield f"R{name} {a} {b} {part.value}"
    elif kind == "stop":
        yield f"V{name} {name}_c 0 PWL(0 1 {STOP} 1 {STOP + 1e-6} 0)"
        yield f"S{name} {a} {name}_s {name}_c 0 GATE"
        # a metre of cable to the switch and back
        yield f"L{name} {name}_s {name}_m 1u"
        yield f"R{name} {name}_m {b} {part.value}"
    elif kind in ("schottky", "tvs"):
        yield f"D{name} {a} {b} {kind.upper()}"
    elif kind in ("motor", "coil"):
        yield f"L{name} {a} {name}_l {part.inductance}"
        emf = 12.0 - part.running * part.value if kind == "motor" else 0.0
        yield f"R{name} {name}_l {name}_e {part.value}"
        yield f"V{name} {name}_e {b} {emf}"
    elif kind == "transistor":
        gate, source = b, at(2)
        yield f"M{name} {a} {gate} {source} {source} NFET"
        yield f"D{name} {source} {a} BODY"
        yield f"C{name} {gate} {source} 0.6n"
    elif kind == "converter":
        yield f"B{name} {name}_o 0 V=2.5*(1+tanh(4*(V({a})-6.5)))"
        yield f"R{name} {name}_o {b} 0.05"
        yield f"Rload{name} {a} 0 270"


def netlist(
    circuit: Circuit, *, supply: str = "12", signs: dict[str, int] | None = None,
    broken: tuple[str, int] | None = None, out: str = "out.txt", drives: bool = True,
    end: float = END,
) -> str:  # fmt: skip
    """Return the netlist; `broken` is (component, terminal), `supply` a voltage or a PWL."""
    rows = ["* the bench, from its declaration", MODELS.format(drain=DRAIN)]
    for part in circuit.components.values():

        def at(terminal: int, part: Component = part) -> str:
            gap = broken == (part.ref, terminal)
            return f"{part.ref}_t" if gap else node(part.nodes[terminal])

        rows += lines(part, (signs or {}).get(part.ref, 0), at)
    if broken is not None:
        whole = node(circuit.components[broken[0]].nodes[broken[1]])
        rows.append(f"Rbroken {broken[0]}_t {whole} {BROKEN}")
    rows += [f"Vplug n_plug_s 0 {supply}", "Rplug n_plug_s n_plug 0.1"]
    # the chip's pins: 1 uA of leakage and diodes to 0 V and 3.3 V; outputs of 50 ohm after reset,
    # before it the pull-down that the RP2040 has then
    rows += [
        "V33 n_3v3 0 3.3",
        "Rboard n_vsys 0 60",
        "Vacc n_accelerometer 0 2.5",
        "Rm n_marker 0 1e6",
    ]
    pins = ("supply_adc", "estop_sense", "accelerometer_adc", "pump_gate", "vent_gate", "sync_out")
    for pin in pins:
        rows += [f"D{pin}h {node(pin)} n_3v3 CLAMP", f"D{pin}l 0 {node(pin)} CLAMP"]
    for pin in pins[:2]:
        rows.append(f"I{pin} 0 {node(pin)} 1u")
    for pin in pins[3:5]:
        wave = (
            f"PULSE(0 2.62 {RESET} 20n 20n 25u 50u)"
            if pin == "pump_gate"
            else f"PWL(0 2.62 {VALVE} 2.62 {VALVE + 1e-7} 0)"
        )
        rows += [
            f"V{pin} {pin}_v 0 {wave if drives else 0}",
            f"S{pin} {pin}_v {pin}_r on 0 GATE",
            f"R{pin} {pin}_r {node(pin)} 50",
            f"Rd{pin} {node(pin)} 0 80k",
        ]
    rows.append(f"Von on 0 PWL(0 0 {RESET} 0 {RESET + 1e-7} {1 if drives else 0})")
    shown = " ".join(f"v({node(name)})" for name in NAMES)
    rows += [
        ".options reltol=2e-3 abstol=1e-8 vntol=1e-4 method=gear itl4=200",
        f".tran 4u {end} 0 4u",
        ".control", "run", "set wr_singlescale", "set wr_vecnames",
        f"wrdata {out} {shown}", "quit", ".endc", ".end",
    ]  # fmt: skip
    return "\n".join(rows)


def simulate(
    folder: Path, circuit: Circuit | None = None, **words: object
) -> dict[str, np.ndarray]:
    """Return {node: voltages} and "time" of a run."""
    text = netlist(circuit or load_circuit("pico"), out=str(folder / "out.txt"), **words)  # type: ignore[arg-type]
    file = folder / "bench.cir"
    file.write_text(text, encoding="ascii")
    done = subprocess.run(
        ["ngspice", "-b", str(file)], capture_output=True, text=True, timeout=120, check=False
    )
    out = folder / "out.txt"
    assert out.exists(), done.stdout[-2000:] + done.stderr[-2000:]
    table = np.loadtxt(out, skiprows=1)
    assert table[-1, 0] >= 0.99 * float(words.get("end", END))  # type: ignore[arg-type]
    assert np.isfinite(table).all(), done.stderr[-2000:]
    return {"time": table[:, 0], **{name: table[:, 1 + n] for n, name in enumerate(NAMES)}}
