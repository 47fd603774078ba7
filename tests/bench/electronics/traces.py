"""Traces of the power side from ngspice, to be played to a board: dips, a lost supply, a break.

A trace has "time" [s] and the voltages at the pins of the two senses [V]. The first 20 ms are a
sound supply.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.electronics.spice import simulate
from layerjam.bench.rig.circuit import load_circuit

SENSES = ("supply_adc", "estop_sense")
BEGIN = 20e-3
"""Time [s] of the event."""
DIPS = {
    "a dip to 11.4 V": ("PWL(0 12 20m 12 20.1m 11.4 40m 11.4 40.1m 12)", ""),
    "5 ms without supply": ("PWL(0 12 20m 12 20.1m 0 25m 0 25.1m 12)", ""),
    "a slow sag to 10 V": ("PWL(0 12 20m 12 50m 10)", "SUPPLY_LOW"),
    "12 V lost": ("PWL(0 12 20m 12 20.1m 0)", "SUPPLY_LOW"),
}
"""Supply as ngspice takes it, and the fault that the board has to report."""
BROKEN = {
    "F1": "SUPPLY_LOW",
    "R5": "SUPPLY_LOW",
    "R8": "EMERGENCY_STOP",
    "S1": "EMERGENCY_STOP",
}
"""Component whose first wire breaks, and the fault that the board has to report."""
CASES = {**{name: fault for name, (_, fault) in DIPS.items()}, **BROKEN}
LENGTH = 80e-3


def trace(case: str, folder: Path) -> dict[str, np.ndarray]:
    """Return the trace of a case."""
    circuit = load_circuit("pico")
    # the emergency stop of the netlist opens after 2 ms: here it stays closed
    stop = circuit.components["S1"]
    closed = type(stop)(ref="S1", kind="fuse", nodes=stop.nodes, numbers=stop.numbers)
    circuit = type(circuit)(**{**vars(circuit), "components": {**circuit.components, "S1": closed}})
    if case in DIPS:
        return simulate(folder, circuit, supply=DIPS[case][0], drives=False, end=LENGTH)
    # a wire that breaks: the sound circuit, then the broken one from the state of a cold start,
    # whose filters fill in 2 ms
    sound = simulate(folder, circuit, drives=False, end=BEGIN)
    after = simulate(folder, circuit, broken=(case, 0), drives=False, end=LENGTH - BEGIN)
    joined = {name: np.concatenate([sound[name], after[name]]) for name in SENSES}
    return {"time": np.concatenate([sound["time"], after["time"] + BEGIN]), **joined}
