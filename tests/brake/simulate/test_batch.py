"""Batches: the same numbers as one by one, labelled, bounded, stoppable."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import brake_force, peak
from layerjam.brake.mechanics.stop.exact import stop
from layerjam.brake.mechanics.stop.motion import stop_in_time
from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from layerjam.brake.simulate import batch as module
from layerjam.brake.simulate.batch import batch
from layerjam.core.errors import QuantityError, UnknownNameError
from strategies import KAPTON, PTFE, unchecked

G, SPRING = 9.80665, 14.9e3
SWEEP = {
    "mass": np.linspace(0.3, 3.0, 6), "speed": np.linspace(0.1, 4.0, 11),
    "vacuum": np.linspace(0.0, 101e3, 13), "spring": SPRING, "gravity": G,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("brake", [KAPTON, PTFE])
def test_the_compiled_loop_is_the_law(brake):
    made = batch(stop, SWEEP, brake=brake)
    right = stop(
        SWEEP["mass"][:, None, None], SWEEP["speed"][:, None], SWEEP["vacuum"], SPRING, G, brake
    )
    assert made.slip.dims == ("mass", "speed", "vacuum")
    np.testing.assert_array_equal(made.outcome, right.outcome)
    for name in ("slip", "peak_force", "end_speed", "heat", "stored"):
        np.testing.assert_allclose(made[name], getattr(right, name), rtol=1e-11, atol=1e-12)
    assert made.mass.units == "kg"
    assert made.slip.units == "m"
    assert made.attrs["spring"] == SPRING


@pytest.mark.slow
def test_odd_drops_too():
    """Wide over all decades: soft springs, weak vacuums, no gravity, what three steps miss."""
    random, n = np.random.default_rng(4), 20000
    values = {
        "mass": 10 ** random.uniform(-2, 1.3, n), "speed": 10 ** random.uniform(-2, 1, n),
        "vacuum": 10 ** random.uniform(0, 5, n), "spring": 10 ** random.uniform(3.0, 6, n),
        "gravity": random.choice([0.0, G], n),
    }  # fmt: skip
    made = batch(stop, {k: ("drop", v) for k, v in values.items()}, brake=KAPTON)
    right = stop(**values, brake=KAPTON)
    np.testing.assert_array_equal(made.outcome, right.outcome)
    np.testing.assert_allclose(made.slip, right.slip, rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(made.peak_force, right.peak_force, rtol=1e-12)
    assert len(np.unique(made.outcome)) == 4


def test_impossible_input_is_nan_as_in_the_law():
    made = batch(stop, SWEEP | {"mass": ("mass", [-1.0, 0.0, 1.0]), "speed": 2.0}, brake=KAPTON)
    assert (made.outcome[:2] == -1).all()
    assert (made.outcome[2] >= 0).all()
    film = unchecked(KAPTON.film, kinetic=np.nan)
    lost = batch(stop, SWEEP | {"mass": 1.0}, brake=unchecked(KAPTON, film=film))
    assert (lost.outcome == -1).all()
    assert np.isnan(lost.slip).all()
    assert np.isnan(made.slip[:2]).all()
    assert np.isfinite(made.slip[2]).all()


@pytest.mark.slow
def test_fields_of_the_device_sweep_too():
    made = batch(
        stop, SWEEP | {"vacuum": 9e4, "brake.film.kinetic": np.array([0.2, 0.24])}, brake=KAPTON,
        wanted=["slip"],
    )  # fmt: skip
    assert list(made.data_vars) == ["slip"]
    less = dataclasses.replace(KAPTON, film=dataclasses.replace(KAPTON.film, kinetic=0.2))
    right = stop(SWEEP["mass"][:, None], SWEEP["speed"], 9e4, SPRING, G, less).slip
    np.testing.assert_allclose(made.slip[..., 0], right, rtol=1e-12, atol=1e-15)


def test_other_laws_and_shared_axes():
    force = batch(brake_force, {"slip": [0.0, 0.02], "vacuum": [1e4, 5e4, 9e4]}, brake=KAPTON)
    right = brake_force(np.array([[0.0], [0.02]]), np.array([1e4, 5e4, 9e4]), KAPTON)
    np.testing.assert_allclose(force.brake_force, right, rtol=1e-14)
    tops = batch(peak, {"vacuum": [1e4, 5e4], "travel": 0.06}, brake=KAPTON)
    np.testing.assert_allclose(tops.force, peak(np.array([1e4, 5e4]), 0.06, KAPTON).force)
    way = ("drop", np.array([0.02, 0.04]))
    tuned = batch(
        tuned_vacuum, {"mass": 1.0, "speed": ("drop", [2.0, 2.5]), "slip": way, "spring": SPRING,
                       "gravity": G}, brake=KAPTON,
    )  # fmt: skip
    assert tuned.tuned_vacuum.dims == ("drop",)


def test_a_sink_gets_everything_in_order_and_nothing_is_kept(monkeypatch):
    monkeypatch.setattr(module, "CHUNK", 100)
    got, told = [], []

    def sink(first, values):
        got.append((first, values["slip"].copy()))

    count = batch(
        stop, SWEEP, brake=KAPTON, wanted=["slip"], sink=sink, progress=lambda *a: told.append(a)
    )
    whole = batch(stop, SWEEP, brake=KAPTON, wanted=["slip"]).slip.values.ravel()
    assert count == whole.size == 6 * 11 * 13
    assert [first for first, _ in got] == list(range(0, count, 100))
    np.testing.assert_array_equal(np.concatenate([v for _, v in got]), whole)
    assert told[-1] == (count, count)


def test_it_fills_the_arrays_it_is_given():
    slip = np.empty((6, 11, 13))
    made = batch(stop, SWEEP, brake=KAPTON, out={"slip": slip})
    assert list(made.data_vars) == ["slip"]
    np.testing.assert_array_equal(slip, batch(stop, SWEEP, brake=KAPTON).slip)
    with pytest.raises(QuantityError, match="array of 858 float64"):
        batch(stop, SWEEP, brake=KAPTON, out={"slip": np.empty(5)})
    with pytest.raises(UnknownNameError):
        batch(stop, SWEEP, brake=KAPTON, out={"slap": np.empty(858)})


def test_an_interrupt_ends_it_without_a_result(monkeypatch):
    monkeypatch.setattr(module, "CHUNK", 100)

    def enough(done, _):
        if done >= 300:
            raise KeyboardInterrupt

    pieces = []
    for sink in (None, lambda first, _: pieces.append(first)):
        with pytest.raises(KeyboardInterrupt):
            batch(stop, SWEEP, brake=KAPTON, progress=enough, sink=sink)
    assert pieces == [0, 100, 200]


def test_what_does_not_fit_is_refused():
    with pytest.raises(UnknownNameError, match="weight"):
        batch(stop, SWEEP | {"weight": 1.0}, brake=KAPTON)
    with pytest.raises(QuantityError, match="gravity is missing"):
        batch(stop, {k: v for k, v in SWEEP.items() if k != "gravity"}, brake=KAPTON)
    with pytest.raises(QuantityError, match="others on the axis 'a' have 2"):
        batch(stop, SWEEP | {"mass": ("a", [1, 2]), "speed": ("a", [1, 2, 3])}, brake=KAPTON)
    with pytest.raises(QuantityError, match="a number or a 1-D array"):
        batch(stop, SWEEP | {"mass": np.ones((2, 2))}, brake=KAPTON)
    with pytest.raises(UnknownNameError, match="result of the law"):
        batch(stop, SWEEP, brake=KAPTON, wanted=["slips"])
    huge = {k: np.linspace(1, 2, 1000) for k in ("mass", "speed", "vacuum")}
    with pytest.raises(QuantityError, match="pass a sink"):
        batch(stop, SWEEP | huge, brake=KAPTON)


TIMES, VENT = np.array([0.0, 0.01, 0.06]), np.array([94.5e3, 94.5e3, 40e3])
MARCH = {"rope": 16.8e3, "damping": None, "gravity": G, "step": 1e-4, "steps": 4000.0}


@pytest.mark.slow
def test_a_history_is_held_fixed_for_all_cases():
    fixed = {"vacuum": VENT, "times": TIMES, **MARCH}
    speed = np.array([1.0, 2.0, 2.5])
    made = batch(stop_in_time, {"mass": [0.5, 1.0], "speed": speed}, fixed=fixed, brake=KAPTON)
    assert made.slip.dims == ("mass", "speed")
    one = stop_in_time(1.0, 2.5, VENT, TIMES, 16.8e3, None, G, 1e-4, 4000.0, KAPTON)
    assert float(made.slip[1, 2]) == pytest.approx(float(one.slip), rel=1e-12)
    assert "enclosure" not in made
    assert (made.speed_reached == 0).all()
    np.testing.assert_array_equal(made.speed, speed)


@pytest.mark.campaign
def test_a_constant_vacuum_may_be_swept_in_time():
    speed = np.array([1.0, 2.0, 2.5])
    steady = batch(
        stop_in_time, {"mass": 1.0, "speed": speed, "vacuum": 94.5e3},
        fixed={"times": None, **MARCH}, brake=KAPTON,
    )  # fmt: skip
    right = stop(1.0, speed, 94.5e3, 1 / (1 / 131e3 + 1 / 16.8e3), G, KAPTON)
    np.testing.assert_allclose(steady.slip, right.slip, atol=1e-10)


def test_a_brake_may_be_a_file_or_its_name():
    right = batch(stop, SWEEP, brake=KAPTON).slip
    for brake in ("choi2018-kapton", load("choi2018-kapton")):
        np.testing.assert_array_equal(batch(stop, SWEEP, brake=brake).slip, right)


def test_what_python_would_say_is_said_plainly():
    march = {"mass": 1.0, "speed": [1.0, 2.0], "vacuum": 9e4, **MARCH, "damping": 0.0}
    with pytest.raises(QuantityError, match="in fixed"):
        batch(stop_in_time, march | {"times": 0.0}, brake=KAPTON)
    with pytest.raises(QuantityError, match="times: None cannot be swept; pass it in fixed"):
        batch(stop_in_time, march | {"times": None}, brake=KAPTON)
    with pytest.raises(QuantityError, match="mass: '1kg' is not a number"):
        batch(stop, SWEEP | {"mass": "1kg"}, brake=KAPTON)
    with pytest.raises(QuantityError, match="block: 0 cases"):
        batch(stop, SWEEP, brake=KAPTON, block=0)
    with pytest.raises(QuantityError, match="brake: a float is not a brake"):
        batch(stop, SWEEP, brake=1.0)
    with pytest.raises(QuantityError, match="speed: both swept and fixed"):
        batch(stop, SWEEP, brake=KAPTON, fixed={"speed": [1.0]})
