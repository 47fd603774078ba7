"""Intervals of a batch against brakes drawn one by one, and the cases that tests cover."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.device.evidence import Evidence, Part
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import stop
from layerjam.brake.simulate.batch import batch
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve

FILE, SD = load("choi2018-kapton"), 0.08
NAMES = ("scale_factor", "enclosure_force")
TESTS = Evidence(
    command="calibrate",
    date="2026-01-01",
    tests=5,
    names=NAMES,
    exponent_sd=1e-9,
    ranges={"vacuum": (40e3, 60e3), "slip": (0.0, 0.06), "speed": (1e-3, 10.0)},
    fitted={},
    parts=(Part("test", ((SD**2, 0.0), (0.0, SD**2))),),
)
TESTED = evolve(FILE, evidence=(TESTS,))
SPRING, GRAVITY = 14.9e3, 9.80665
STOPS = {"mass": [0.8, 1.2], "speed": 2.0, "vacuum": [45e3, 60e3, 90e3]}
STOPS |= {"spring": SPRING, "gravity": GRAVITY}


def draw_brakes(count: int):
    """Return the brake with independent random numbers, shape (count,)."""
    friction, rubber = np.exp(SD * np.random.default_rng(3).standard_normal((2, count)))
    brake = FILE.brake
    return evolve(
        brake,
        scale_factor=brake.scale_factor * friction,
        enclosure=evolve(brake.enclosure, modulus=brake.enclosure.modulus * rubber),
        film=evolve(brake.film, friction_on_silicone=brake.film.friction_on_silicone * rubber),
    )


def test_stops_agree_with_brakes_drawn_one_by_one():
    grid, count = batch(stop, STOPS, brake=TESTED, interval="next"), 20_000
    brakes, unit = draw_brakes(count), np.ones(count)
    for m, mass in enumerate(STOPS["mass"]):
        for p, vacuum in enumerate(STOPS["vacuum"]):
            end = stop(mass * unit, 2.0 * unit, vacuum * unit, SPRING * unit, GRAVITY, brakes)
            for name in ("slip", "peak_force", "heat"):
                due = np.quantile(getattr(end, name), (0.025, 0.975))
                found = [float(grid[f"{name}_{end}"][m, p]) for end in ("low", "high")]
                assert found == pytest.approx(list(due), rel=0.03)
                assert found[0] < float(grid[name][m, p]) < found[1]
    assert grid.slip_low.attrs["units"] == "m"
    assert grid.attrs["interval_of"] == "next test"
    # 90 kPa is beyond the tests
    assert grid.tested.values.tolist() == [[1.0, 1.0, 0.0]] * 2
    # outcomes are words
    assert "outcome_low" not in grid


def test_a_law_of_one_result_has_an_interval_as_well():
    slips = np.linspace(0.001, 0.04, 7)
    grid = batch(brake_force, {"slip": slips, "vacuum": 50e3}, brake=TESTED, interval="next")
    brakes = draw_brakes(20_000)
    due = [np.quantile(brake_force(slip, 50e3, brakes), (0.025, 0.975)) for slip in slips]
    found = np.transpose([grid.brake_force_low, grid.brake_force_high])
    np.testing.assert_allclose(found, due, rtol=0.02)


def test_the_mean_of_many_has_no_scatter_between_tests():
    grid = batch(stop, STOPS, brake=TESTED, interval="mean", wanted=["slip"])
    np.testing.assert_allclose(grid.slip_low, grid.slip, rtol=1e-3)
    np.testing.assert_allclose(grid.slip_high, grid.slip, rtol=1e-3)
    assert set(grid) == {"slip", "slip_low", "slip_high", "tested"}


def test_a_sink_gets_the_intervals_too():
    pieces = []
    sweep = {"slip": np.linspace(0.001, 0.04, 1200), "vacuum": 50e3}
    batch(
        *(brake_force, sweep),
        brake=TESTED,
        interval="next",
        sink=lambda first, piece: pieces.append({k: v.copy() for k, v in piece.items()}),
    )
    whole = batch(brake_force, sweep, brake=TESTED, interval="next")
    for name in ("brake_force", "brake_force_low", "brake_force_high", "tested"):
        joined = np.concatenate([piece[name] for piece in pieces])
        np.testing.assert_array_equal(joined, whole[name])


def test_a_brake_without_tests_has_wider_intervals_and_is_never_tested():
    narrow, wide = (
        batch(stop, STOPS, brake=brake, interval="next", wanted=["peak_force"])
        for brake in (TESTED, FILE)
    )
    assert wide.attrs["basis"] == "handbook"
    copy = FILE.with_(count=15)
    grid = batch(brake_force, {"slip": 0.0, "vacuum": 5e4}, brake=copy, interval="next")
    assert "sheets.count was 11, is 15" in grid.attrs["notes"]
    assert not wide.tested.any()
    assert (wide.peak_force_high > narrow.peak_force_high).all()
    plain = batch(stop, STOPS, brake=TESTED)
    assert set(plain) == set(stop(1.0, 2.0, 5e4, SPRING, GRAVITY, FILE.brake)._fields)


def test_a_batch_that_tests_do_not_cover_is_rejected():
    with pytest.raises(QuantityError, match="scale_factor is swept"):
        batch(stop, {**STOPS, "brake.scale_factor": [0.8, 0.9]}, brake=TESTED, interval="next")

    def add_history(slip, history, brake):
        return brake_force(slip, 50e3, brake) + history[0]

    fixed = {"history": [0.0, 1.0]}
    with pytest.raises(QuantityError, match="history is fixed"):
        batch(add_history, {"slip": [0.01]}, brake=TESTED, interval="next", fixed=fixed)
