"""The calculated worst case against corners that are enumerated here, and what breaks it."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import pytest

from layerjam.bench.rig.circuit import PICO, load_circuit
from layerjam.bench.rig.electronics import (
    compute_margins,
    find_conflicts,
    release_time,
    trip_voltages,
)


def corners(volts: float, upper: float, lower: float, tolerance: float) -> list[float]:
    """Voltages of a divider with 1 uA into or out of its pin, at all corners: Kirchhoff's law."""
    found = []
    for a, b, leak in itertools.product((-1, 1), (-1, 1), (-1e-6, 1e-6)):
        high, low = upper * (1 + a * tolerance), lower * (1 + b * tolerance)
        found.append((volts / high + leak) / (1 / high + 1 / low))
    return found


def value(name: str) -> float:
    return {m.name: m.value for m in compute_margins(load_circuit("pico"))}[name]


def test_every_margin_is_kept() -> None:
    circuit = load_circuit("pico")
    assert len(compute_margins(circuit)) > 30 and find_conflicts(circuit) == ()


def test_the_chip_s_pull_down_spoilt_the_sense() -> None:
    """As it was: 100 kohm over 33 kohm beside 50 to 80 kohm inside the chip; 2.0 V are needed."""
    for inside, volts in ((50e3, 1.99), (80e3, 2.27)):
        both = 1 / (1 / 33e3 + 1 / inside)
        assert 12.0 * both / (100e3 + both) == pytest.approx(volts, abs=0.01)
    # with today's resistors and the pull-down the least supply would not be read as high
    both = 1 / (1 / 30e3 + 1 / 50e3)
    assert 10.2 * both / (100e3 + both) < 2.0


def test_the_senses_at_all_corners() -> None:
    least, most = trip_voltages(load_circuit("pico"))
    closed = value("pin voltage, emergency stop closed")
    assert closed == pytest.approx(min(corners(least, 1e5, 3e4, 0.01)), rel=1e-6) and closed > 2.0
    greatest = value("highest voltage at estop_sense")
    assert greatest == pytest.approx(max(corners(12.6, 1e5, 3e4, 0.01)), rel=1e-6)
    assert max(corners(0.0, 1e5, 3e4, 0.01)) < 0.8
    # the converter's number at which the firmware stops, seen from the supply
    for volts, ends in ((least, min), (most, max)):
        seen = [
            pin / (3.3 * reference) * 3.3 * 13 / 3
            for pin in corners(volts, 1e5, 3e4, 0.001)
            for reference in (0.971, 1.02)
        ]
        reach = 13 / 3 * 10 / 4096 * 3.3
        if ends is min:
            assert max(seen) + reach == pytest.approx(10.7, abs=0.02)
        else:
            assert min(seen) - reach == pytest.approx(10.7, abs=0.02)


def test_the_filter_s_time() -> None:
    """In small steps: R7 and R8 in series, beside R9, and 1 uA into the pin, from 12.6 V on."""
    volts, t, dt = max(corners(12.6, 1e5, 3e4, 0.01)), 0.0, 1e-7
    while volts > 0.8:
        current = 1e-6 - volts / (1.01e5 + 1.01e4) - volts / 3.03e4
        volts, t = volts + dt * current / (47e-9 * 1.1), t + dt
    assert value("time until an open stop is sensed") == pytest.approx(t, rel=1e-3)


def test_the_valve_s_diode() -> None:
    """L di/dt = -R i - V, in small steps, from 12 V over 36 ohm to 30 % of that."""
    for volts in (0.5, 24.5):
        i, t, dt = 12 / 36, 0.0, 1e-6
        while i > 0.3 * 12 / 36:
            i -= dt * (36 * i + volts) / 0.18
            t += dt
        assert release_time(load_circuit("pico"), volts) == pytest.approx(t, rel=2e-3)


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ('value = 300.0\ntolerance', 'value = 150.0\ntolerance', "current into the gate of Q1"),
        ('value = 300.0\ntolerance', 'value = 1000.0\ntolerance', "gate voltage of Q1, on"),
        ("clamp = 24.4", "clamp = 32.4", "drain–source voltage of Q1"),
        ("value = 30000.0\ntolerance = 0.01", "value = 22000.0\ntolerance = 0.01", "closed"),
        ("value = 4.7e-08\ntolerance = 0.1", "value = 4.7e-07\ntolerance = 0.1", "is sensed"),
        ("ripple = 1.6", "ripple = 0.4", "ripple current of C1"),
        ("current = 2.0", "current = 1.5", "current of F1"),
        ("= 30000.0\ntolerance = 0.001", "= 33000.0\ntolerance = 0.001", "supply_ratio is 4.3"),
    ],
)  # fmt: skip
def test_a_part_that_does_not_fit_is_named(tmp_path: Path, old: str, new: str, names: str) -> None:
    text = PICO.read_text("utf-8")
    assert old in text
    other = tmp_path / "other.toml"
    other.write_text(text.replace(old, new), encoding="utf-8")
    found = find_conflicts(load_circuit("pico", other))
    assert any(names in one for one in found), found


def test_every_component_is_in_the_list_of_parts() -> None:
    circuit = load_circuit("pico")
    listed: set[str] = set()
    for part in circuit.parts:
        for one in part.refs.split(", "):
            first, _, last = one.partition(" to ")
            numbers = range(int(first[1:]), int(last[1:]) + 1) if last else ()
            listed |= {first, *(f"{first[0]}{n}" for n in numbers)}
        assert len(part.alternatives) == 2 and part.number and part.sheet and part.ours
    assert set(circuit.components) <= listed


def test_the_resistors_order_numbers_are_their_values() -> None:
    """Three digits and a power of ten, as the sheet of the MRS25 has them."""
    circuit = load_circuit("pico")
    ordered = {
        ref: float(f"{number[1]}e{number[2]}")
        for part in circuit.parts
        if (number := re.fullmatch(r"Vishay MRS25000C(\d{3})(\d)FCT00", part.number))
        for ref in part.refs.split(", ")
    }
    coarse = {
        ref: one.numbers["value"]
        for ref, one in circuit.components.items()
        if one.kind == "resistor" and one.numbers["tolerance"] == 0.01
    }
    assert ordered == coarse and len(coarse) == 10
