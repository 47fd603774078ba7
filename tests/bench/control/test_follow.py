"""A force that follows a profile: the inverse law in the loop, limits said before it is tried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from layerjam.bench.control.follow import (
    bode_response,
    check_slew,
    follow,
    rehabilitation,
    target_vacuums,
)
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.mechanics.pull import brake_force, force_limits
from layerjam.core.errors import QuantityError
from strategies import KAPTON

FAST = Plant(rate=4.0, top=100e3, leak=0.01, vent=4.0)
IDEAL = Sensor(range=110e3)
TIME = np.arange(0, 8, 0.005)


def regulator(plant: Plant = FAST, **how: object) -> Regulator:
    return Regulator(
        plant=plant, sensor=IDEAL, kind="scheduled", safe_state="release", sample_time=0.005, **how
    )  # type: ignore[arg-type]


def test_a_slow_profile_on_a_fast_line_is_followed() -> None:
    wanted = rehabilitation(TIME, low=20, high=80, period=8.0)
    made = follow(regulator(), KAPTON, wanted, 2e-3 * TIME)
    assert made.loop.outcome == "HEALTHY"
    assert made.possible.all() and made.reasons == ()
    # the vent opens 1 % of the pump's vacuum above the target: 1 kPa, nearly 2 N
    assert np.abs(made.error[400:]).max() < 2.5
    assert np.sqrt(np.mean(made.error[400:] ** 2)) < 1.0


def test_what_it_gives_is_the_law_at_the_vacuum_of_the_moment() -> None:
    made = follow(regulator(), KAPTON, np.full(1600, 60.0), np.full(1600, 0.02))
    force = np.asarray(brake_force(0.02, made.loop.vacuum, KAPTON))
    np.testing.assert_allclose(made.force, force, rtol=1e-12)
    assert made.force[-1] == pytest.approx(60.0, rel=0.01)


def test_a_wrong_model_errs_by_its_own_share() -> None:
    """The loop is closed on vacuum, not on force: 10 % more friction is nearly 10 % more force."""
    true = replace(KAPTON, scale_factor=1.1 * KAPTON.scale_factor)
    made = follow(regulator(), KAPTON, np.full(1600, 80.0), np.full(1600, 0.01), brake=true)
    assert made.force[-1] / 80.0 == pytest.approx(1.1, abs=0.015)


def test_forces_out_of_reach_are_named_and_the_nearest_is_given() -> None:
    low, high = (float(f) for f in force_limits(0.03, KAPTON))
    slip = np.full(3, 0.03)
    target, possible, reasons = target_vacuums(
        np.array([low / 2, (low + high) / 2, 1.5 * high]), slip, KAPTON, 95e3
    )
    assert possible.tolist() == [False, True, False]
    assert target[0] == 1.0 and target[2] == 95e3
    assert (
        "below the enclosure's own force" in reasons[0]
        and "exceeds the brake's force" in reasons[1]
    )


def test_changes_faster_than_pump_and_vent_are_named() -> None:
    slow = Plant(rate=0.5, top=100e3, vent=0.5)
    fine, reasons = check_slew(np.array([1e3, 1e3, 60e3, 60e3, 1e3]), 0.01, slow)
    assert fine.tolist() == [True, False, True, False, True]
    assert "the pump achieves" in reasons[0] and "the vent achieves" in reasons[1]
    gentle = np.linspace(1e3, 20e3, 2000)
    assert check_slew(gentle, 0.01, slow)[0].all()


def test_a_sine_within_reach_comes_out_whole_and_a_fast_one_does_not() -> None:
    slow = replace(FAST, rate=2.0, vent=2.0)
    made = bode_response(regulator(slow), KAPTON, slip=0.02, mean=60, amplitude=15,
                frequencies=[0.05, 0.1, 4.0])  # fmt: skip
    assert made.magnitude[:2] == pytest.approx([1.0, 1.0], abs=0.03)
    assert np.abs(made.phase[:2]).max() < 5
    assert made.magnitude[2] < 0.5
    assert 0.1 < (made.bandwidth or 0) < 4.0
    assert bode_response(regulator(), KAPTON, slip=0.02, mean=60, amplitude=2,
                frequencies=[0.1]).bandwidth is None  # fmt: skip


@pytest.mark.parametrize(
    ("wanted", "slip", "words"),
    [
        ([1.0], [0.0], "at least two samples"),
        ([1.0, 2.0], [0.0], "of the same length"),
        ([1.0, np.nan], [0.0, 0.0], "not finite"),
        ([1.0, 2.0], [0.0, 0.08], "the overlap of 68 mm"),
        ([1.0, 2.0], [-1e-3, 0.0], "slip: -1 mm"),
    ],
)
def test_what_is_no_profile(wanted: list[float], slip: list[float], words: str) -> None:
    with pytest.raises(QuantityError, match=words):
        follow(regulator(), KAPTON, np.array(wanted), np.array(slip))


def test_noise_of_the_slip_is_noise_of_the_force() -> None:
    wanted, slip = np.full(1600, 60.0), np.full(1600, 0.02)
    clean = follow(regulator(), KAPTON, wanted, slip)
    noisy = follow(regulator(), KAPTON, wanted, slip, slip_noise=1e-3)
    late = slice(800, None)
    assert np.std(noisy.force[late]) > 3 * np.std(clean.force[late])
    assert noisy.force[late].mean() == pytest.approx(60.0, rel=0.02)
