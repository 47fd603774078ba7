"""The line in time: closed forms, conservation of gas, order of convergence, limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.brake.fluid import closed_forms as forms
from layerjam.brake.fluid.line import Chamber, Leak, Line, Pump, Reservoir, Tube, Valve
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.fluid.network import (
    CHAMBER,
    Drive,
    advance,
    gas_imbalance,
    respond,
    state_at_pressure,
)
from layerjam.core.errors import QuantityError

PAPER = load_line("choi2018").line
FULL, ATMOSPHERE = 94.5e3, 101325.0


def between(made, first, second):
    return made.crossing(second) - made.crossing(first)


def test_the_papers_rise_times_to_a_percent():
    """Fig. 5: 3.9 s in air, 1.5 s in water, 2.6 times."""
    air, water = forms.rise_time(FULL, PAPER), forms.rise_time(FULL, PAPER, water=True)
    assert air == pytest.approx(3.9, rel=0.01)
    assert water == pytest.approx(1.5, rel=0.01)
    assert air / water == pytest.approx(2.6, rel=0.01)


@pytest.mark.parametrize("laminar", [0.0, 1e-8, 5e-8])
@pytest.mark.parametrize("ultimate", [0.0, 4e3])
def test_integrated_and_closed_rise_agree(laminar, ultimate):
    line = replace(PAPER, leak=Leak(laminar=laminar), pump=replace(PAPER.pump, ultimate=ultimate))
    target = 0.95 * forms.reachable_vacuum(line)
    made = respond(line, 20.0, samples=2001)
    rise = between(made, 0.1 * target, 0.9 * target)
    assert rise == pytest.approx(forms.rise_time(target, line), rel=1e-8)
    assert made.imbalance < 1e-12
    assert made.vacuum[-1] < forms.reachable_vacuum(line)


def test_what_is_never_reached():
    line = replace(PAPER, pump=replace(PAPER.pump, ultimate=10e3))
    assert forms.rise_time(91.5e3, line) is None
    assert forms.rise_time(91.0e3, line) is not None
    assert forms.rise_time(100e3, PAPER, water=True) is None
    assert respond(line, 60.0).vacuum[-1] == pytest.approx(ATMOSPHERE - 10e3, rel=1e-9)


def test_venting_by_a_valve_in_closed_form():
    line = replace(PAPER, valve=Valve(conductance=1e-10))
    start = state_at_pressure(line, ATMOSPHERE - FULL)
    made = respond(line, 4.0, Drive(pump=0.0, vent=1.0), start, samples=2001)
    fall = between(made, 0.9 * FULL, 0.1 * FULL)
    assert fall == pytest.approx(forms.fall_by_valve(FULL, line), rel=1e-7)
    assert made.vacuum[-1] == pytest.approx(0.0, abs=1.0)


def test_pumps_run_backwards():
    start = state_at_pressure(PAPER, ATMOSPHERE - FULL)
    made = respond(PAPER, 2.0, Drive(pump=-1.0), start)
    assert between(made, 0.9 * FULL, 0.1 * FULL) == pytest.approx(
        forms.fall_by_pump(FULL, PAPER), rel=1e-9
    )


WHOLE = Line(
    chamber=Chamber(volume=7.5e-6, volume_per_slip=3e-5, shrink=2e-11),
    pump=Pump(flow=2e-6, count=2, ultimate=2e3),
    tube=Tube(length=1.2, bore=2e-3), valve=Valve(conductance=2e-10, critical_ratio=0.3),
    leak=Leak(laminar=1e-8, orifice=1e-9), reservoir=Reservoir(volume=1e-4, conductance=5e-10),
)  # fmt: skip


@given(
    st.floats(0, 1), st.sampled_from([0.0, 1.0]), st.sampled_from([0.0, 1.0]),
    st.floats(-0.05, 0.05), st.floats(5e3, 1e5), st.floats(5e3, 1e5),
)  # fmt: skip
@settings(max_examples=60, deadline=None)
def test_gas_is_accounted_for_whatever_is_switched(pump, vent, store, pace, p, stored):
    start = state_at_pressure(WHOLE, p, stored, 0.01)
    end = advance(start, Drive(pump, vent, store, 0.01, pace), WHOLE, 0.1, 400)
    assert gas_imbalance(end, start) < 1e-13
    stretched = 3e-5 * (0.01 + 0.1 * pace)
    volume = WHOLE.chamber.volume + stretched - 2e-11 * (ATMOSPHERE - end[CHAMBER])
    # pressure and gas, integrated apart, still belong together
    assert end[3] == pytest.approx(end[CHAMBER] * volume, rel=1e-6)


def test_fourth_order():
    line = replace(PAPER, leak=Leak(laminar=2e-8))
    exact = advance(state_at_pressure(line), Drive(), line, 2.0, 4096)[CHAMBER]
    errors = [abs(advance(state_at_pressure(line), Drive(), line, 2.0, n)[CHAMBER] - exact)
              for n in (8, 16, 32, 64)]  # fmt: skip
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders[-1] == pytest.approx(4.0, abs=0.1)


def test_stretching_at_constant_gas_is_boyles_law():
    closed = replace(PAPER, chamber=Chamber(volume=7.5e-6, volume_per_slip=3e-5))
    start = state_at_pressure(closed, 2e4)
    end = advance(start, Drive(pump=0.0, pace=0.04), closed, 1.0, 200)
    assert end[CHAMBER] == pytest.approx(2e4 * 7.5e-6 / (7.5e-6 + 3e-5 * 0.04), rel=1e-9)
    stiff = replace(closed, polytropic=1.4)
    end = advance(start, Drive(pump=0.0, pace=0.04), stiff, 1.0, 200)
    ratio = 7.5e-6 / (7.5e-6 + 3e-5 * 0.04)
    assert end[CHAMBER] == pytest.approx(2e4 * ratio**1.4, rel=1e-9)


@pytest.mark.parametrize("n", [1.0, 1.2, 1.4])
@pytest.mark.parametrize("tube", [None, Tube(length=1.2, bore=4e-3)])
def test_books_of_a_chamber_that_is_emptied_are_those_of_a_blowdown(n, tube):
    """p over N^n stays: at n = 1.4 the books once kept 28.6 % of the gas in an empty chamber."""
    line = replace(PAPER, polytropic=n, tube=tube, pump=replace(PAPER.pump, ultimate=0.0))
    start = state_at_pressure(line)
    made = respond(line, 30.0)
    end = made.states[-1]
    assert end[CHAMBER] < 2e-2 * ATMOSPHERE
    assert end[3] / start[3] == pytest.approx((end[CHAMBER] / start[CHAMBER]) ** (1 / n), rel=1e-6)
    assert made.imbalance < 1e-10


@pytest.mark.parametrize("n", [1.2, 1.4])
def test_books_of_a_chamber_that_is_filled_are_those_of_the_first_law(n):
    """Gas from outside mixes in: its energy n q heats, N grows by q and p V by n q."""
    line = replace(PAPER, polytropic=n, leak=Leak(laminar=5e-8))
    start = state_at_pressure(line, 2e4)
    made = respond(line, 2.0, Drive(pump=0.0), start)
    risen = (made.states[-1, CHAMBER] - 2e4) * line.chamber.volume
    assert risen > 5e-3
    assert made.states[-1, 3] - start[3] == pytest.approx(risen / n, rel=1e-8)


def test_gas_that_is_pressed_together_and_let_go_keeps_its_books():
    line = replace(PAPER, polytropic=1.4, chamber=Chamber(volume=7.5e-6, volume_per_slip=3e-5))
    start = state_at_pressure(line, 2e4)
    end = advance(start, Drive(pump=0.0, pace=0.04), line, 1.0, 200)
    assert end[3] == start[3] and end[CHAMBER] < 0.85 * 2e4


def test_a_reservoir_and_the_chamber_come_to_one_pressure():
    line = replace(PAPER, reservoir=Reservoir(volume=1e-4, conductance=1e-9))
    start = state_at_pressure(line, ATMOSPHERE, 5e3)
    made = respond(line, 2.0, Drive(pump=0.0, store=1.0), start)
    mixed = (ATMOSPHERE * line.chamber.volume + 5e3 * 1e-4) / (line.chamber.volume + 1e-4)
    assert made.states[-1, 0] == pytest.approx(mixed, rel=1e-6)
    assert made.states[-1, 2] == pytest.approx(mixed, rel=1e-6)


@pytest.mark.parametrize("duration", [0.0, 5e-324, -1.0, np.inf, np.nan])
def test_a_time_that_is_none_is_refused(duration):
    with pytest.raises(QuantityError, match="duration: .* is not allowed"):
        respond(PAPER, duration)


def test_a_wide_short_tube_changes_only_the_volume():
    tube = Tube(length=0.1, bore=8e-3)
    line = replace(PAPER, tube=tube)
    more = np.pi / 4 * 8e-3**2 * 0.1
    whole = replace(PAPER, chamber=Chamber(volume=PAPER.chamber.volume + more))
    made = respond(line, 20.0, samples=2001)
    assert between(made, 0.1 * FULL, 0.9 * FULL) == pytest.approx(
        forms.rise_time(FULL, whole), rel=2e-3
    )
