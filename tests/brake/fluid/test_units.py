"""Vacuum lines in other units of length: volumes, flows and energies follow, times stay.

Pressure and time keep their units, because the viscosity of air and the normal pressure of a sonic
conductance are fixed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from dimensions import Units
from layerjam.brake.fluid import closed_forms, flow, network, timing, tube, vacuum_energy
from layerjam.brake.fluid.line import Chamber, Leak, Line, Pump, Reservoir, Tube, Valve

LINES = {
    "rigid": Line(
        chamber=Chamber(volume=12e-6, compliance=2e-11),
        pump=Pump(flow=6e-6, count=2, ultimate=3e3, backwards=4e-6, power=1.2),
        valve=Valve(conductance=1e-10, critical_ratio=0.4, delay=0.01),
    ),
    "leaking": Line(
        chamber=Chamber(volume=12e-6),
        pump=Pump(flow=6e-6, ultimate=3e3, backwards=4e-6),
        leak=Leak(laminar=4e-8),
    ),
    "soft": Line(
        chamber=Chamber(volume=9e-6, volume_per_slip=3e-5, shrink=2e-11),
        pump=Pump(flow=2e-5, ultimate=2e3),
        tube=Tube(length=0.8, bore=2e-3),
        valve=Valve(conductance=1e-10),
        leak=Leak(laminar=3e-8, orifice=2e-8),
        reservoir=Reservoir(volume=2e-4, conductance=2e-9),
        polytropic=1.2,
    ),
}
RESULTS: dict[str, tuple[str, Callable[[Line, Units], Any]]] = {
    "final pressure": ("Pa", lambda line, _: closed_forms.final_pressure(line)),
    "pump flow": ("m^3/s", lambda line, _: closed_forms.total_pump_flow(line)),
    "rise": ("s", lambda line, _: timing.air_rise_time(5e4, line)[0]),
    "fall": ("s", lambda line, _: timing.air_fall_time(5e4, line)[0]),
    "emptying": ("J", lambda line, _: vacuum_energy.emptying_work(3e4, line.chamber.volume, 1e5)),
    "jam": ("J", lambda line, _: vacuum_energy.jam_work(5e4, line)),
    "refill": ("J", lambda line, _: vacuum_energy.refill_work(2e4, 5e4, line)),
    "volume": ("m^3", lambda line, u: network.gas_volume(line, 4e4, 0.01 * u.length)),
    "ends": ("m^3", lambda line, _: [network.pump_volume(line), network.end_volume(line)]),
    "vacuum": ("Pa", lambda line, _: network.respond(line, 3.0, samples=31).vacuum),
    "tube": ("Pa m^3/s", lambda _, u: flow.tube_throughput(9e4, 4e4, u.length, 2e-3 * u.length)),
}
"""{result: (unit, function of the line and the units)}"""
ONLY = {"jam": ("rigid", "leaking"), "refill": ("rigid", "leaking")}


@pytest.mark.parametrize("kind", LINES)
@pytest.mark.parametrize("name", RESULTS)
def test_a_line_does_not_depend_on_the_unit_of_length(name: str, kind: str) -> None:
    if kind not in ONLY.get(name, LINES):
        pytest.skip("the law is for other lines")
    unit, result = RESULTS[name]
    line = LINES[kind]
    one = np.asarray(result(line, Units()), float)
    for size in (3.0, 0.5):
        units = Units(length=size, mass=size)
        other = np.asarray(result(units.scale(line), units), float)
        assert other == pytest.approx(one * units.factor(unit), rel=1e-6), name


@pytest.mark.parametrize("kind", LINES)
def test_twice_the_pumps_and_leaks_and_volumes_take_the_same_time(kind: str) -> None:
    """Two lines side by side are one line of twice the size."""
    line = LINES[kind]
    double = replace(
        line,
        chamber=replace(
            line.chamber,
            volume=2 * line.chamber.volume,
            shrink=2 * line.chamber.shrink,
            volume_per_slip=2 * line.chamber.volume_per_slip,
        ),
        pump=replace(line.pump, count=2 * line.pump.count),
        leak=Leak(laminar=2 * line.leak.laminar, orifice=2 * line.leak.orifice),
        valve=replace(line.valve, conductance=2 * line.valve.conductance) if line.valve else None,
        tube=None,
        reservoir=None,
    )
    single = replace(line, tube=None, reservoir=None)
    for law in (timing.air_rise_time, timing.air_fall_time):
        assert law(4e4, double)[0] == pytest.approx(law(4e4, single)[0], rel=1e-6)
    made = [network.respond(one, 3.0, samples=31).vacuum for one in (single, double)]
    assert made[1] == pytest.approx(made[0], rel=1e-6, abs=1.0)
    assert closed_forms.final_pressure(double) == pytest.approx(
        closed_forms.final_pressure(single), rel=1e-9
    )


def test_a_wave_needs_the_length_over_the_speed_of_sound() -> None:
    for size in (1.0, 2.0, 5.0):
        delay = tube.wave_delay(Tube(length=size, bore=2e-3), 1.4)
        assert delay * tube.sound_speed(1.4) == pytest.approx(size, rel=1e-12)
    assert tube.sound_speed(1.4) == pytest.approx(343.2, rel=2e-3)  # dry air at 20 °C
