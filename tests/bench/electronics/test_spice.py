"""The declared circuit in ngspice: nominal, tolerances, dips of the supply, broken wires."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.electronics.spice import END, RESET, STOP, VALVE, missing, simulate
from layerjam.bench.rig.circuit import load_circuit

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
CIRCUIT = load_circuit("pico")
TERMINALS = [(ref, n) for ref, c in CIRCUIT.components.items() for n in range(len(c.nodes))]
AVALANCHE = {("D1", 0), ("D1", 1), ("D2", 0), ("D2", 1)}
"""Broken wires that let a transistor break through: only a look before power finds them."""
HIGH, LOW, TRIP = 2.0, 0.8, 10.7 * 3 / 13


def within(run: dict[str, np.ndarray], begin: float, end: float) -> np.ndarray:
    return (run["time"] >= begin) & (run["time"] <= end)


def reports(run: dict[str, np.ndarray]) -> str:
    """What the firmware would report while the stop is closed: supply first, as it does."""
    before = within(run, 1.2e-3, STOP)
    if run["supply_adc"][before].mean() < TRIP:
        return "SUPPLY_LOW"
    return "EMERGENCY_STOP" if run["estop_sense"][before].min() < LOW else ""


def check_nothing_burns(run: dict[str, np.ndarray]) -> None:
    """Pins within what their diodes carry, both transistors off in reset and within 30 V."""
    for pin in ("supply_adc", "estop_sense"):
        assert run[pin].min() > -0.5 and run[pin].max() < 4.1, (pin, run[pin].max())
    reset = within(run, 0.0, 0.9 * RESET)
    for gate in ("pump gate", "vent gate"):
        assert run[gate][reset].max() < 0.5, gate
    for drain in ("pump minus", "valve minus"):
        assert run[drain].max() < 30.0, (drain, run[drain].max())


@pytest.mark.parametrize("volts", [11.4, 12.0, 12.6])
@pytest.mark.parametrize("sign", [-1, 0, 1])
def test_tolerances(tmp_path: Path, volts: float, sign: int) -> None:
    """All upper resistors at one end, all others at the other."""
    signs = {ref: sign if ref in ("R5", "R8", "R1", "R3") else -sign for ref in CIRCUIT.components}
    run = simulate(tmp_path, supply=str(volts), signs=signs)
    check_nothing_burns(run)
    assert reports(run) == ""
    before = within(run, 1.2e-3, STOP)
    assert run["estop_sense"][before].min() > HIGH
    assert max(run["estop_sense"].max(), run["supply_adc"].max()) < 3.23
    assert (
        run["vent gate"][within(run, 1.2e-3, VALVE)].min() > 2.5
        and run["pump gate"][before].max() > 2.5
    )
    after = run["time"][(run["estop_sense"] < LOW) & (run["time"] > STOP)]
    assert after[0] - STOP < 1.65e-3, after[0] - STOP
    assert run["VSYS"].min() > 1.8 and run["VSYS"].max() < 5.5


def test_the_pump_s_own_voltage_does_not_hide_the_stop(tmp_path: Path) -> None:
    """A pump that still turns is a generator of 8 V; without D5 it holds the sense up."""
    bridged = load_circuit("pico")
    numbers = {"value": 0.01, "current": 1.0}
    old = bridged.components["D5"]
    fuse = type(old)(ref="D5", kind="fuse", nodes=old.nodes, numbers=numbers)
    bridged = type(bridged)(**{**vars(bridged), "components": {**bridged.components, "D5": fuse}})
    assert simulate(tmp_path)["estop_sense"][-1] < LOW
    assert simulate(tmp_path, bridged)["estop_sense"][-1] > LOW


@pytest.mark.parametrize(
    ("depth", "names"), [(11.4, ""), (9.0, "SUPPLY_LOW"), (0.0, "SUPPLY_LOW")], ids=str
)
def test_a_dip_is_never_an_emergency_stop(tmp_path: Path, depth: float, names: str) -> None:
    """While 12 V fall and rise, the sense is never low without the supply being low too."""
    wave = f"PWL(0 12 0.7m 12 0.75m {depth} 3m {depth} 3.05m 12)"
    run = simulate(tmp_path, supply=wave, drives=False)
    closed = within(run, 0.0, STOP)
    stopped = run["estop_sense"][closed] < HIGH
    assert (run["supply_adc"][closed][stopped] < TRIP).all()
    assert reports(run) in (names, "")
    check_nothing_burns(run)


@pytest.mark.parametrize("broken", TERMINALS, ids=lambda one: f"{one[0]}-{one[1]}")
def test_a_broken_wire_burns_nothing_and_runs_nothing(
    tmp_path: Path, broken: tuple[str, int]
) -> None:
    # without R9 the filter empties over R8 and R7 alone
    end = 14e-3 if broken[0] == "R9" else END
    run = simulate(tmp_path, broken=broken, end=end)
    if broken in AVALANCHE:
        assert max(run["pump minus"].max(), run["valve minus"].max()) > 30.0
        return
    check_nothing_burns(run)
    after = within(run, 0.97 * end, end)
    assert run["estop_sense"][after].max() < LOW, "the open stop is sensed"
    named = {"S1": "EMERGENCY_STOP", "R8": "EMERGENCY_STOP", "R5": "SUPPLY_LOW"}
    assert reports(run) == named.get(broken[0], "SUPPLY_LOW" if broken[0] == "F1" else "")
