"""What a tube delays: speed of sound, resonance in closed form, the wave's arrival, limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from layerjam.brake.fluid.line import Chamber, Tube, validate
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.fluid.network import (
    CHAMBER,
    SIDE,
    SIZE,
    Drive,
    gas_imbalance,
    gas_volume,
    pump_volume,
    respond,
    state_at_pressure,
    state_rates,
)
from layerjam.brake.fluid.timing import air_rise_time
from layerjam.brake.fluid.tube import (
    cell_rates,
    filling_lag,
    reynolds_number,
    sound_speed,
    tube_area,
    wave_delay,
)
from layerjam.core.errors import QuantityError
from strategies import unchecked

PAPER = load_line("choi2018").line
A = 101325.0


def with_tube(cells, length=2.0, bore=2e-3, **chamber):
    made = replace(PAPER.chamber, **chamber) if chamber else PAPER.chamber
    return replace(PAPER, chamber=made, tube=Tube(length=length, bore=bore, cells=cells))


def test_the_speed_of_sound():
    """343 m/s in air at 20 degC without exchange of heat; Newton's isothermal value below."""
    assert sound_speed(1.4) == pytest.approx(343.2, abs=0.1)
    assert sound_speed() == pytest.approx(sound_speed(1.4) / np.sqrt(1.4))
    assert wave_delay(Tube(length=2.9, bore=1e-3)) == pytest.approx(0.01, rel=1e-3)


def test_a_tube_too_short_for_the_integrator_is_refused_in_one_sentence():
    """No warning of the integrator's beside the error: pytest makes one an error of its own."""
    with pytest.raises(QuantityError, match="at least 1 mm"):
        with_tube(0, length=1e-12)
    thin = unchecked(Tube(length=1e-3, bore=2.5e-3), length=1e-12)
    with pytest.raises(QuantityError, match="at least 1 mm"):
        validate(replace(PAPER, tube=thin))
    chamber = replace(PAPER.chamber, volume_per_slip=4e-5)
    stiff = unchecked(replace(PAPER, chamber=chamber, polytropic=1.2), tube=thin)
    with pytest.raises(QuantityError, match="cannot be integrated"):
        respond(stiff, 1.2)
    assert respond(with_tube(0, length=1e-3), 1.2).vacuum[-1] == pytest.approx(
        respond(PAPER, 1.2).vacuum[-1], rel=1e-3
    )


def test_at_rest_cells_are_poiseuilles_law():
    """Equal flow everywhere: p falls as the root of a straight line, whatever the cells."""
    tube = Tube(length=1.5, bore=2e-3, cells=7)
    a, b = 9e4, 4e4
    nodes = np.sqrt(a * a + (b * b - a * a) * np.arange(1, 8) / 7)
    flow = np.pi * 2e-3**4 / (256 * 1.81e-5 * 1.5) * (a * a - b * b)
    pressed, pace = cell_rates(a, nodes, np.full(7, flow), flow, tube, 1.0)
    assert np.abs(pressed).max() < 1e-6
    assert np.abs(pace).max() < 1e-9 * flow * sound_speed() ** 2


def oscillations(line):
    """Natural frequencies [rad/s] about rest at the atmosphere, pump off, from the equations."""
    base, count = state_at_pressure(line), line.tube.cells
    # the pump's node stands twice in the state
    places = [CHAMBER, *range(SIZE, SIZE + 2 * count)]
    rows = []
    for place in places:
        step = 1.0 if place < SIZE + count else 1e-6
        moved = base.copy()
        moved[place] += step
        rows.append(state_rates(moved, Drive(pump=0.0), line)[places] / step)
    roots = np.linalg.eigvals(np.array(rows).T)
    return np.sort(roots.imag[roots.imag > 1.0])


@pytest.mark.parametrize("polytropic", [1.0, 1.4])
def test_resonance_in_closed_form_and_second_order(polytropic):
    """A wide tube closed at the pump, a volume V at the other end: tan(kL) = -k V/A."""
    length, bore, volume = 1.0, 0.02, 5e-5
    cross = np.pi / 4 * bore**2
    k = brentq(lambda k: np.sin(k * length) + k * volume / cross * np.cos(k * length), 1.6, 3.1)
    exact = k * sound_speed(polytropic)
    errors = []
    for cells in (8, 16, 32):
        line = replace(with_tube(cells, length, bore, volume=volume), polytropic=polytropic)
        errors.append(abs(oscillations(line)[0] / exact - 1))
    assert errors[-1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def test_the_wave_arrives_when_it_should():
    """A small chamber feels the pump after L/c and then 2 q/(A c), fallen as the telegraph's front.

    The pump's step is a front of q/(A c), doubled at the closed end, damped by friction on its way
    by exp(-f L / 2c) with f = 32 mu R T / (p d^2). One lumped volume is felt at once.
    """
    length, bore = 10.0, 10e-3
    due = wave_delay(Tube(length=length, bore=bore))
    line = with_tube(40, length, bore, volume=1e-8)
    made = respond(line, 2 * due, samples=401)
    taken = A * 3.33e-6
    drag = 32 * 1.81e-5 * sound_speed() ** 2 / (A * bore**2)
    front = 2 * taken / (tube_area(line.tube) * sound_speed()) * np.exp(-drag * due / 2)
    assert made.crossing(0.5 * front) == pytest.approx(due, rel=0.02)
    plateau = made.vacuum[(made.time > 1.1 * due) & (made.time < 1.5 * due)].mean()
    assert plateau == pytest.approx(front, rel=0.06)
    assert np.abs(made.vacuum[made.time < 0.8 * due]).max() < 1e-3 * front
    lumped = respond(with_tube(0, length, bore, volume=1e-8), 2 * due, samples=401)
    assert lumped.crossing(0.2 * front) < 0.5 * due
    assert made.imbalance < 1e-12


@pytest.mark.slow
def test_cells_and_one_volume_agree_where_waves_do_not_matter():
    """A short tube: the rise time is that of the lumped one, and does not hang on the cells."""
    lumped = air_rise_time(40e3, with_tube(0, 0.3))[0]
    few, more = (air_rise_time(40e3, with_tube(n, 0.3))[0] for n in (2, 5))
    assert few == pytest.approx(more, rel=1e-5)
    assert few == pytest.approx(lumped, rel=2e-3)


def test_gas_is_accounted_for_in_cells():
    line = replace(with_tube(6), valve=None)
    start = state_at_pressure(line, 3e4)
    assert start[3:6].sum() == pytest.approx(3e4 * (gas_volume(line, 3e4) + pump_volume(line)))
    whole = PAPER.chamber.volume + tube_area(line.tube) * line.tube.length
    assert start[3:6].sum() == pytest.approx(3e4 * whole)
    made = respond(line, 0.5, Drive(pump=-1.0), start)
    assert gas_imbalance(made.states[-1], made.states[0]) < 1e-10
    assert made.states[-1, SIDE] == pytest.approx(made.states[-1, SIZE + 5], rel=1e-6)


def test_the_lag_is_that_of_a_small_step():
    """Pump's side held at p + dp: the chamber closes in with V / 2 n K p."""
    line = with_tube(0)
    p, dp = 3e4, 1.0
    state = state_at_pressure(line, p)
    state[SIDE] += dp
    pace = state_rates(state, Drive(pump=0.0), line)[CHAMBER]
    assert dp / pace == pytest.approx(filling_lag(line, p), rel=1e-4)
    assert filling_lag(PAPER, p) == 0.0
    assert filling_lag(line, 0.0) == np.inf


def test_reynolds_by_hand():
    """10 L/min of air at 101 325 Pa, 1.204 kg/m^3, in 4 mm: 4 rho Q / (pi d mu)."""
    flow = 10e-3 / 60
    assert reynolds_number(A * flow, 4e-3) == pytest.approx(
        4 * 1.204 * flow / (np.pi * 4e-3 * 1.81e-5), rel=1e-3
    )


def test_a_chamber_in_cells_still_stretches():
    """Slip into a closed line: Boyle over chamber and tube together."""
    line = replace(with_tube(4, 0.5), chamber=Chamber(volume=7.5e-6, volume_per_slip=3e-5))
    tube = tube_area(line.tube) * 0.5
    made = respond(line, 2.0, lambda t: Drive(pump=0.0, slip=0.02 * t, pace=0.02),
                   state_at_pressure(line, 4e4))  # fmt: skip
    due = 4e4 * (7.5e-6 + tube) / (7.5e-6 + tube + 3e-5 * 0.04)
    # the tube lags behind by a little of its gas
    assert made.states[-1, CHAMBER] == pytest.approx(due, rel=2e-3)
