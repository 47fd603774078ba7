"""Stops under a falling vacuum converge at second order, against `independent.falling_vacuum`."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from independent.falling_vacuum import FallingVacuum
from layerjam.brake.device.load import load
from layerjam.brake.simulate.drop_in_time import History, drop_in_time
from layerjam.brake.simulate.record import Outcome

FILE = load("choi2018-kapton")
G = 9.80665
ROPE = 16.8e3
CASE = {"mass": 1.0, "speed": 2.0, "rope_stiffness": ROPE, "gravity": G}
FALLS = {
    "slow": ([0.0, 0.05], [94.5e3, 60e3]),
    "to a lower level": ([0.0, 0.004, 0.009], [94.5e3, 94.5e3, 50e3]),
    "in 10 us": ([0.0, 0.008, 0.00801], [94.5e3, 94.5e3, 55e3]),
}


@functools.cache
def right(fall: str) -> tuple[float, float, float]:
    spring = 1 / (1 / ROPE + 1 / FILE.brake.stiffness_measured)
    return FallingVacuum(FILE.brake, 1.0, 2.0, spring, G, *FALLS[fall]).run()


@pytest.fixture(autouse=True)
def few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """The records are not looked at: few samples of them leave most of the time to the stops."""
    monkeypatch.setattr("layerjam.brake.simulate.drop_in_time.SAMPLES", 20)


def ours(fall: str, step: float | None = None) -> tuple[float, float, float]:
    history = History(*map(np.array, FALLS[fall]))
    stop = drop_in_time(FILE, **CASE, vacuum=history, step=step)[0]
    assert stop.outcome is Outcome.STOPPED
    return stop.slip, stop.time, stop.peak_force


@pytest.mark.parametrize("fall", FALLS)
def test_slip_time_and_peak_force_are_right_at_the_default_step(fall: str) -> None:
    slip, time, peak = right(fall)
    got = ours(fall)
    assert got[:2] == pytest.approx((slip, time), rel=2e-6)
    assert got[2] == pytest.approx(peak, rel=5e-6)


@pytest.mark.parametrize(
    "fall",
    ["to a lower level", *(pytest.param(f, marks=pytest.mark.slow) for f in ("slow", "in 10 us"))],
)
def test_each_quantity_converges_at_second_order(fall: str) -> None:
    exact = np.array(right(fall))
    errors = [np.abs(np.array(ours(fall, step)) / exact - 1) for step in (4e-5, 1e-5)]
    assert (errors[1] < 2e-5).all()
    # a quarter of the step: a sixteenth of the error, until rounding of the reference
    assert (errors[1] <= np.maximum(errors[0] / 8, 2e-8)).all()
