"""What a vacuum costs: closed forms, the integrated run, conservation over cycles, limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.fluid.closed_forms import final_pressure
from layerjam.brake.fluid.line import Leak, Reservoir
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.fluid.network import Drive, respond, state_at_pressure
from layerjam.brake.fluid.vacuum_energy import (
    electric_energy,
    emptying_work,
    heat_per_joule,
    holding_cost,
    jam_work,
    pumped_work,
    refill_work,
)

PAPER = load_line("choi2018").line
A = 101325.0


@pytest.mark.parametrize("vacuum", [1e3, 3e4, 94.5e3])
@pytest.mark.parametrize("shrink", [0.0, 3e-11])
def test_a_jam_costs_what_the_pump_did_along_the_run(vacuum, shrink):
    """The closed form against ln(a/p) dN summed over an integrated run without leak."""
    line = replace(PAPER, chamber=replace(PAPER.chamber, shrink=shrink))
    made = respond(line, 12.0, samples=8001)
    cut = int(np.argmax(made.vacuum >= vacuum))
    assert cut > 0
    run = replace(made, time=made.time[: cut + 1], states=made.states[: cut + 1])
    assert pumped_work(run) == pytest.approx(jam_work(float(run.vacuum[-1]), line), rel=1e-4)


def test_by_hand():
    """7.503 mL at 94.5 kPa: V (a - p - p ln a/p), p = 6825 Pa."""
    p = A - 94.5e3
    by_hand = 7.503e-6 * (A - p - p * math.log(A / p))
    assert jam_work(94.5e3, PAPER) == pytest.approx(by_hand, rel=1e-12)
    assert rise("choi2018", target="94.5 kPa").gas_work == pytest.approx(by_hand, rel=1e-12)
    assert jam_work(A, PAPER) == pytest.approx(7.503e-6 * A, rel=1e-12)
    water = PAPER.chamber.compliance * 94.5e3**2 / 2
    assert jam_work(94.5e3, PAPER, water=True) == pytest.approx(water, rel=1e-12)


@given(st.floats(0, 0.999), st.floats(0, 0.999))
def test_work_adds_up_and_rises(first, second):
    low, high = sorted((first * A, second * A))
    whole = jam_work(high, PAPER)
    assert jam_work(low, PAPER) + jam_work(high, PAPER, standing=low) == pytest.approx(
        whole, abs=1e-9 * A * 7.5e-6
    )
    assert 0 <= whole <= A * PAPER.chamber.volume
    assert jam_work(low, PAPER) <= whole + 1e-15


def test_small_vacuums_cost_as_a_spring():
    """Up to second order W = V P^2 / 2a."""
    assert jam_work(10.0, PAPER) == pytest.approx(PAPER.chamber.volume * 100 / (2 * A), rel=1e-4)


def test_holding_is_what_the_leak_lets_in():
    line = replace(PAPER, leak=Leak(laminar=2e-8), pump=replace(PAPER.pump, power=3.0))
    held = holding_cost(60e3, line)
    p = A - 60e3
    leak = 2e-8 * (A * A - p * p) / (2 * A)
    assert held.leak == pytest.approx(leak, rel=1e-12)
    assert held.least_power == pytest.approx(leak * math.log(A / p), rel=1e-12)
    assert held.duty == pytest.approx(leak / (3.33e-6 * p), rel=1e-12)
    assert held.electric_power == pytest.approx(held.duty * 6.0, rel=1e-12)
    # the run that holds: the pump at this duty keeps the pressure and does that work
    made = respond(line, 5.0, Drive(pump=held.duty), state_at_pressure(line, p))
    assert made.vacuum[-1] == pytest.approx(60e3, rel=1e-9)
    assert pumped_work(made) / 5.0 == pytest.approx(held.least_power, rel=1e-9)


def test_the_pump_works_all_the_time_at_the_lowest_pressure():
    line = replace(PAPER, leak=Leak(laminar=2e-8, orifice=0.0))
    assert holding_cost(A - final_pressure(line), line).duty == pytest.approx(1.0, rel=1e-9)
    assert holding_cost(A - final_pressure(line) / 2, line).electric_power is None


def test_no_leak_costs_nothing_to_hold():
    assert holding_cost(90e3, PAPER)[:3] == (0.0, 0.0, 0.0)
    assert holding_cost(90e3, PAPER).electric_power is None
    powered = replace(PAPER, pump=replace(PAPER.pump, power=3.0))
    assert holding_cost(90e3, powered).electric_power == 0.0
    assert electric_energy(4.0, powered) == pytest.approx(24.0)
    assert electric_energy(4.0, PAPER) is None


def test_a_reservoir_is_emptied_again_for_what_it_took():
    tank = replace(PAPER, reservoir=Reservoir(volume=1e-4, conductance=2e-9))
    whole = refill_work(A, 5e3, tank)
    assert whole == pytest.approx(emptying_work(5e3, 1e-4, A), rel=1e-12)
    assert refill_work(A, 2e4, tank) + refill_work(2e4, 5e3, tank) == pytest.approx(whole)
    assert refill_work(2e4, 5e3, PAPER) == 0.0


def test_joules_per_joule():
    assert heat_per_joule(3.0, 0.5) == 6.0
    assert heat_per_joule(3.0, None) is None
    assert heat_per_joule(3.0, 0.0) is None
