"""Pumps by flow curve: against the displacement law, in closed form, at altitude, refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.bench.control.plant import linearise_line
from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.fluid import closed_forms as forms
from layerjam.brake.fluid.line import Chamber, Leak, Line, Pump, Tube, validate
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.fluid.network import respond
from layerjam.brake.fluid.pump import displacement_at_pressure, lowest_pressure, pump_throughput
from layerjam.brake.fluid.pump_curve import STANDARD, check_curve, free_flow
from layerjam.brake.fluid.timing import air_fall_time, air_rise_time
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.units import get

CURVE = ((0.0, 50e-6), (20e3, 33e-6), (45e3, 12e-6), (70e3, 0.0))
LINE = Line(chamber=Chamber(volume=12e-6), pump=Pump(curve=CURVE, count=2))
TEXT = 'name = "a"\n[chamber]\nvolume = "12 mL"\n[pump]\ncurve = {}\n'


@st.composite
def curves(draw):
    """Any curve that falls from no vacuum to no flow."""
    steps = draw(st.lists(st.floats(0.05, 1), min_size=1, max_size=6))
    drops = draw(st.lists(st.floats(0.05, 1), min_size=len(steps), max_size=len(steps)))
    most, top = draw(st.floats(1e3, STANDARD)), draw(st.floats(1e-7, 1e-3))
    vacuums = np.concatenate(([0.0], np.cumsum(steps) / sum(steps))) * most
    flows = np.concatenate((np.cumsum(drops[::-1])[::-1] / sum(drops), [0.0])) * top
    return tuple(zip(np.minimum(vacuums, STANDARD).tolist(), flows.tolist(), strict=True))


def test_a_straight_curve_is_a_pump_of_constant_displacement():
    """Free air Q (1 - P/P_u) at the standard atmosphere is Q a/P_u (p - p_u)."""
    straight = Pump(curve=((0.0, 50e-6), (60e3, 0.0)))
    same = Pump(flow=50e-6 * STANDARD / 60e3, ultimate=STANDARD - 60e3)
    for p in (42e3, 60e3, 1e5, STANDARD, 1.1e5):
        at = pump_throughput(p, straight, STANDARD)
        if p <= STANDARD:
            assert at == pytest.approx(pump_throughput(p, same, STANDARD), rel=1e-12)
        else:  # the inlet takes in no more than at the atmosphere
            assert at == pytest.approx(50e-6 * p, rel=1e-12)
    assert pump_throughput(41e3, straight, STANDARD) == 0.0


def test_to_a_full_vacuum_it_is_the_papers_pump():
    line = replace(LINE, pump=Pump(curve=((0.0, 3.33e-6), (STANDARD, 0.0))))
    plain = replace(LINE, pump=Pump(flow=3.33e-6))
    for rise_of in (forms.rise_time, lambda t, made: air_rise_time(t, made)[0]):
        assert rise_of(90e3, line) == pytest.approx(rise_of(90e3, plain), rel=1e-8)


@given(curves())
@settings(max_examples=40, deadline=None)
def test_flow_falls_and_meets_the_points(points):
    check_curve(points, "curve")
    vacuums = np.linspace(-1e4, STANDARD, 200)
    flows = np.array([free_flow(v, points) for v in vacuums])
    assert (np.diff(flows) <= 0).all()
    for vacuum, flow in points:
        assert free_flow(vacuum, points) == pytest.approx(flow, rel=1e-9, abs=1e-18)


@given(curves(), st.floats(0.3, 0.97), st.floats(5e4, 1.1e5), st.integers(1, 3))
@settings(max_examples=15, deadline=None)
def test_the_closed_form_by_stretches_is_the_integral(points, part, atmosphere, count):
    """dt = -V dp / q, summed finely."""
    line = Line(
        chamber=Chamber(volume=1e-5), pump=Pump(curve=points, count=count),
        site=replace(LINE.site, atmosphere=atmosphere),
    )  # fmt: skip
    target = part * forms.reachable_vacuum(line)
    p = np.linspace(atmosphere - 0.1 * target, atmosphere - 0.9 * target, 20001)
    rate = np.array([1e-5 / (count * pump_throughput(v, line.pump, atmosphere)) for v in p])
    area = -np.sum((rate[1:] + rate[:-1]) / 2 * np.diff(p))
    assert forms.rise_time(target, line) == pytest.approx(area, rel=1e-5)


def test_integrated_and_closed_rise_agree_two_in_parallel():
    one = replace(LINE, pump=Pump(curve=CURVE))
    for line in (LINE, one):
        time, made = air_rise_time(60e3, line)
        assert time == pytest.approx(forms.rise_time(60e3, line), rel=1e-7)
        assert made.imbalance < 1e-12
    assert air_rise_time(60e3, one)[0] == pytest.approx(2 * air_rise_time(60e3, LINE)[0], rel=1e-7)


def test_what_is_reached_against_leak_and_tube():
    """In the end nothing changes: the line is run long and agrees with the balance."""
    assert forms.reachable_vacuum(LINE) == pytest.approx(70e3, rel=1e-12)
    leaky = replace(LINE, leak=Leak(laminar=4e-6, orifice=2e-6), tube=Tube(length=1.0, bore=1.5e-3))
    made = respond(leaky, 30.0)
    assert forms.reachable_vacuum(leaky) == pytest.approx(float(made.vacuum[-1]), rel=1e-7)
    assert forms.reachable_vacuum(leaky) < forms.reachable_vacuum(replace(leaky, tube=None)) < 70e3


def test_an_orifice_leak_counts_against_a_plain_pump():
    line = replace(LINE, pump=Pump(flow=20e-6), leak=Leak(orifice=5e-6))
    assert forms.reachable_vacuum(line) == pytest.approx(
        float(respond(line, 60.0).vacuum[-1]), rel=1e-8
    )
    assert air_rise_time(90e3, line) == (None, None)


def test_altitude_shrinks_all_in_proportion():
    """A pump moves volumes: at 70 % of the atmosphere 70 % of the vacuum, in the same time."""
    high = replace(LINE, site=replace(LINE.site, atmosphere=0.7 * STANDARD))
    assert lowest_pressure(LINE.pump, 0.7 * STANDARD) == pytest.approx(0.7 * (STANDARD - 70e3))
    assert forms.rise_time(0.7 * 50e3, high) == pytest.approx(forms.rise_time(50e3, LINE))


@pytest.mark.parametrize("vacuum", [1e3, 30e3, 69e3, 70e3, 80e3])
def test_the_regulators_plant_takes_in_as_much_at_its_vacuum(vacuum):
    line = replace(LINE, pump=replace(LINE.pump, backwards=1e-6))
    plant, p = linearise_line(line, vacuum=vacuum), STANDARD - vacuum
    made = plant.rate * (plant.top - vacuum) * line.chamber.volume
    if vacuum < 70e3:
        assert made == pytest.approx(2 * pump_throughput(p, line.pump, STANDARD), rel=1e-9)
    assert plant.top == pytest.approx(70e3)
    last = STANDARD * 12e-6 / 25e3
    if vacuum >= 69e3:
        assert displacement_at_pressure(p, line.pump, STANDARD) == pytest.approx(last, rel=1e-9)


def test_release_needs_something_that_lets_in():
    assert air_fall_time(50e3, LINE) == (None, None)
    back = replace(LINE, pump=replace(LINE.pump, backwards=10e-6))
    time, by = air_fall_time(50e3, back)
    assert by == "pumps run backwards"
    assert time == pytest.approx(forms.fall_by_pump(50e3, back), rel=1e-9)


def test_a_curve_in_a_file():
    text = TEXT.format('[["0 kPa", "3 L/min"], ["300 mbar", "1 L/min"], ["60 kPa", "0 L/min"]]')
    line = LineFile.read(text, "a.toml").line
    assert line.pump.flow is None
    assert line.pump.curve[1] == pytest.approx((30e3, 1e-3 / 60))
    answer = rise(LineFile.read(text, "a.toml"), target="50 kPa")
    assert answer.rise_time == pytest.approx(answer.closed_form, rel=1e-7)
    sourced = TEXT.format(
        '{ value = [["0 kPa", "3 L/min"], ["60 kPa", "0 L/min"]], kind = "measured" }'
    )
    assert LineFile.read(sourced, "a.toml").sources["pump.curve"].kind == "measured"
    assert get(line, "pump.ultimate") == 0.0


GOOD = '[["0 kPa", "3 L/min"], ["60 kPa", "0 L/min"]]'


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ('[["0 kPa", "3 L/min"]]', "has 1 point; give at least two"),
        ("[]", "0 point"),
        ('"3 L/min"', "is not a list such as"),
        ('[["0 kPa", "3 L/min", "1"]]', "is not a list such as"),
        ('[["5 kPa", "3 L/min"], ["60 kPa", "0 L/min"]]', "starts at 5 kPa; its first point"),
        ('[["0 kPa", "3 L/min"], ["0 kPa", "0 L/min"]]', "the vacuum does not rise from 0 kPa"),
        (
            '[["0 kPa", "3 L/min"], ["30 kPa", "3 L/min"], ["60 kPa", "0 L/min"]]',
            "the flow does not fall from 50 mL/s at 0 kPa to 50 mL/s at 30 kPa",
        ),
        ('[["0 kPa", "3 L/min"], ["60 kPa", "1 L/min"]]', "ends with 16.67 mL/s at 60 kPa"),
        ('[["0 kPa", "3 L/min"], ["102 kPa", "0 L/min"]]', "0 mL/s at 102 kPa is not allowed"),
        ('[["0 kPa", "-3 L/min"], ["60 kPa", "0 L/min"]]', "is not allowed"),
        ('[["0 kPa", "3 kPa"], ["60 kPa", "0 L/min"]]', "'3 kPa' is not in units of"),
        ('[["0", "3 L/min"], ["60 kPa", "0 L/min"]]', "has no unit"),
        (
            GOOD + '\nflow = "3 L/min"',
            "pump.flow: a pump needs either a flow or a flow curve.* both",
        ),
        (GOOD + '\nultimate = "3 kPa"', "pump.ultimate: a flow curve already ends at the lowest"),
    ],
)
def test_what_is_refused(curve, words):
    with pytest.raises(FileError, match=f"line [56]: .*{words}"):
        LineFile.read(TEXT.format(curve), "a.toml")


def test_a_record_is_checked_too():
    with pytest.raises(QuantityError, match="neither is given"):
        validate(replace(LINE, pump=Pump()))
    with pytest.raises(QuantityError, match="at most 200"):
        check_curve(tuple((i * 1.0, 1e-4 - i * 1e-7) for i in range(300)), "curve")


def test_water_by_a_curve_of_air_is_refused():
    wet = replace(LINE, chamber=replace(LINE.chamber, compliance=6e-11))
    for ask in (lambda: forms.reachable_vacuum(wet, True), lambda: linearise_line(
        replace(wet, pump=replace(wet.pump, backwards=1e-6)), vacuum=5e4, water=True
    )):  # fmt: skip
        with pytest.raises(QuantityError, match="does not apply to water"):
            ask()


def test_the_log_mean_by_hand():
    """One stretch from the atmosphere to 50 kPa of vacuum, q straight: V dp / log mean."""
    line = replace(LINE, pump=Pump(curve=((0.0, 50e-6), (60e3, 0.0))))
    q0, q1 = STANDARD * 50e-6, STANDARD * 50e-6 / 6
    by_hand = 12e-6 * 50e3 * math.log(q0 / q1) / (q0 - q1)
    assert forms.pumping_time(STANDARD, STANDARD - 50e3, line) == pytest.approx(by_hand, rel=1e-12)
