"""Accelerometer and heat as a command asks for them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.sensor import heating, parse_channel_class, reading
from layerjam.brake.device.load import load
from layerjam.brake.simulate.accelerometer import ADXL193, Accelerometer, measure_acceleration
from layerjam.core.errors import LayerjamError

G = 9.80665
KAPTON = load("choi2018-kapton")


@pytest.fixture(scope="module")
def record():
    stop = drop(KAPTON, mass=1.0, speed=2.5, vacuum=94.5e3, rope_stiffness=16.8e3)
    assert reading(stop.record).measured_peak_g == pytest.approx(stop.peak_g, rel=1e-12)
    return stop.record


def test_every_value_has_its_unit_and_agrees_with_the_reading(record):
    answer = reading(record, accelerometer="adxl193", filter="CFC180")
    direct = measure_acceleration(record, ADXL193, 180)
    assert answer.measured_peak == direct.peak and answer.record.peak == direct.peak
    assert answer.measured_peak_g == direct.peak / G
    assert answer.peak_loss == direct.loss > 0
    assert (answer.accelerometer, answer.filter, answer.saturated) == ("adxl193", "cfc180", False)
    numbers = {k for k, v in answer.values.items() if isinstance(v, float)}
    assert numbers == set(answer.units)


def test_a_low_pass_and_a_rate_of_ones_own(record):
    given = reading(record, low_pass="60 Hz", sampling="20 kHz")
    own = measure_acceleration(
        record, Accelerometer(bandwidth=60.0, kind="butterworth", sampling=20e3)
    )
    assert given.measured_peak == own.peak
    assert reading(record, accelerometer="adxl193", low_pass=60.0).record.sensor.kind == "bessel"
    assert reading(record, accelerometer=Accelerometer(range=50.0)).saturated
    assert reading(record, accelerometer=Accelerometer(range=50.0)).warnings
    assert reading(record).measured_rate is None


def test_arrays_and_the_g_they_count_in():
    time, value = np.array([0.0, 0.01, 0.02]), np.array([0.0, 98.0665, 0.0])
    assert reading((time, value)).measured_peak_g == pytest.approx(10)
    assert reading((time, value), gravity=1.62).measured_peak_g == pytest.approx(98.0665 / 1.62)
    assert reading((time, value), gravity=0.0).measured_peak_g is None


@pytest.mark.parametrize(
    ("text", "cfc"), [("cfc60", 60), ("CFC 1000", 1000), ("180", 180), ("none", None), (None, None)]
)
def test_names_of_filters(text, cfc):
    assert parse_channel_class(text) == cfc


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"filter": "cfc100"}, "filter: 'cfc100' is unknown; choose none, cfc60"),
        ({"filter": "butter"}, "'butter' is unknown"),
        ({"filter": ""}, "is unknown"),
        ({"accelerometer": "adxl999"}, "adxl193"),
        ({"low_pass": "400"}, "has no unit"),
        ({"low_pass": "-4 Hz"}, "low pass: -4 Hz is not allowed"),
        ({"sampling": "20 kg"}, "sampling: '20 kg' is not in units of Hz"),
        ({"sampling": "500 Hz", "filter": "cfc60"}, "too slow for CFC 60"),
    ],
)
def test_what_is_refused(record, how, says):
    with pytest.raises(LayerjamError, match=re.escape(says)):
        reading(record, **how)


def test_heat_of_a_stop():
    answer = heating(5.3345823, KAPTON)
    assert answer.temperature_rise == pytest.approx(1.3954, abs=5e-5)
    assert answer.temperature_rise_of_sheets == pytest.approx(1.1163, abs=5e-5)
    assert answer.stops_per_minute == pytest.approx(7.7317, abs=5e-4)
    assert (answer.allowed_rise, answer.film_coefficient) == (20.0, 10.0)
    assert set(answer.units) == set(answer.values)
    more = heating("5334.5823 mJ", KAPTON, allowed_rise="40 K", film_coefficient="20 W/(m^2 K)")
    assert more.stops_per_minute == pytest.approx(31.496, abs=5e-4)
    none = heating(0.0, KAPTON)
    assert (none.temperature_rise, none.stops_per_minute) == (0.0, None)


def test_a_film_whose_specific_heat_is_unknown():
    answer = heating(5.0, load("choi2018-ptfe-fiberglass"))
    assert answer.temperature_rise is None and answer.stops_per_minute is None
    assert "specific heat" in answer.warnings[0]


@pytest.mark.parametrize("rise", ["20 °C", "20 degC", "68 °F", "20", "-1 K", "20 C"])
def test_a_rise_is_no_temperature(rise):
    with pytest.raises(LayerjamError, match="allowed rise"):
        heating(5.0, KAPTON, allowed_rise=rise)
