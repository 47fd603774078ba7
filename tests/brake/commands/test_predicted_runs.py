"""Intervals of stops without a law, plans and followed forces, against single brakes."""

import math

import numpy as np
import pytest

import layerjam
from brake.commands.test_predicted import DROP, NUMBERS, Z, ends, proven
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.simulate import prediction as predicting
from layerjam.core.evolve import evolve


@pytest.fixture
def without_speed_scatter(monkeypatch):
    monkeypatch.setattr(predicting, "SPEED_SD", 0.0)


STOPS_WITHOUT_A_LAW = {
    "without spacers": {"spacers": False},
    "with a speed law": {
        "speed_law_power": 0.08,
        "speed_law_test_speed": 0.013,
        "speed_law_rest_speed": 1e-4,
    },
    "with a leak": {},
    "with a damped rope": {},
    "that use up the travel": {"spacers": False},
}
CASES = {
    "with a leak": {"leak_time": 0.1, "vacuum": 60e3},
    "with a damped rope": {"rope_damping": 100.0},
    "that use up the travel": {"vacuum": 10e3},
}


COMPILED = ("without spacers", "with a speed law", "with a leak", "with a damped rope")
"""Stops that JAX compiles for up to half a minute."""


@pytest.mark.usefixtures("without_speed_scatter")
@pytest.mark.parametrize(
    "stops",
    [
        *(pytest.param(name, marks=pytest.mark.slow) for name in COMPILED),
        *(name for name in STOPS_WITHOUT_A_LAW if name not in COMPILED),
    ],
)
def test_ends_of_stops_without_a_law_are_the_stops_of_these_brakes(stops):
    """All numbers change in one direction with the scale factor, so its quantiles give the ends."""
    sd, case = 0.1, {"vacuum": 60e3, **DROP, **CASES.get(stops, {})}
    file = proven(sd, changes=STOPS_WITHOUT_A_LAW[stops])
    result, runs = layerjam.drop(file, **case), []
    for sign in (-1, 1):
        factor = file.brake.scale_factor * math.exp(sign * Z * sd)
        brake = evolve(file.brake, scale_factor=factor)
        runs.append(layerjam.drop(evolve(file, brake=brake), **case))
    for name in (*NUMBERS, "end_speed"):
        exact = sorted(getattr(run, name) for run in runs)
        tolerance = 0.12 * (exact[1] - exact[0]) + 1e-9
        assert ends(result, name) == pytest.approx(exact, abs=tolerance, rel=0), name


COLLISION = {"mass": 1.0, "speed": 1.0, "warning": 1.0, "travel": 0.05, "mass_sd": 0.1}


def test_plan_judges_the_next_stop_whichever_interval_it_prints():
    file = proven(0.1, of="test")
    following, mean = (
        layerjam.plan("choi2018", file, interval=of, **COLLISION) for of in ("next", "mean")
    )
    for name in ("slip", "needed"):
        (low, high), (inner, outer) = ends(following, name), ends(mean, name)
        assert low < inner <= outer < high
    for field in ("safe_vacuum", "full_beyond", "tuned_vacuum", "slip"):
        assert getattr(mean, field) == getattr(following, field)


FOLLOWED = {"profile": "sine", "low": 20.0, "high": 80.0, "period": 10.0, "duration": 10.0}
FOLLOWED |= {"speed": 1e-3, "safe_state": "release", "sensor_range": 103e3}


def test_compare_and_follow_narrow_from_next_to_mean():
    file = proven(0.1, of="test")
    rows = [layerjam.compare(file, interval=of).devices[0]["intervals"] for of in ("next", "mean")]
    outside, inside = (row["max_force"] for row in rows)
    assert outside["low"] < inside["low"] < inside["high"] < outside["high"]
    bands = [
        layerjam.follow("choi2018", file, interval=of, **FOLLOWED).record[2]
        for of in ("next", "mean")
    ]
    widths = [np.mean(band.high - band.low) for band in bands]
    assert widths[0] > 2 * widths[1]


@pytest.mark.usefixtures("without_speed_scatter")
def test_the_band_of_a_followed_force_is_that_of_the_law():
    """The vacuum is the controller's, so each brake holds its own force at it."""
    sd = 0.1
    run, _, band = layerjam.follow("choi2018", proven(sd, speed=(1e-5, 0.1)), **FOLLOWED).record
    brake = layerjam.load("choi2018-kapton").brake
    slip, vacuum = (np.interp(band.time, run.time, a) for a in (run.slip, run.loop.vacuum))
    for sign, end in ((-1, band.low), (1, band.high)):
        factor = brake.scale_factor * math.exp(sign * Z * sd)
        force = brake_force(slip, vacuum, evolve(brake, scale_factor=factor))
        assert end == pytest.approx(force, rel=5e-3, abs=0.1)
    assert band.is_tested.mean() > 0.9
