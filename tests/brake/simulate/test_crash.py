"""After the travel is used up: against an integrator of its own, energy, and simple limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.commands.drop import drop
from layerjam.brake.device.load import load
from layerjam.brake.simulate.crash import append_crash, crash

KAPTON = "choi2018-kapton"
FALL = {"mass": "1 kg", "speed": "2.5 m/s", "vacuum": "5 kPa"}


@pytest.fixture(scope="module")
def fallen():
    made = drop(KAPTON, **FALL, rope_stiffness=16.8e3)
    assert made.outcome == "BOTTOMED_OUT"
    return made


@pytest.mark.parametrize("damping", [0.0, 20.0, 259.2, 259.2296279363144, 259.3, 600.0])
@pytest.mark.parametrize("g", [9.80665, 0.0])
def test_the_mass_goes_on_as_an_integrator_says(fallen, damping, g):
    """From the last sample of a drop: M a = M g - k x - c v; 2 sqrt(k M) = 259.2 N s/m."""
    record = replace(fallen.record, rope_damping=damping, gravity=g)
    made = crash(record)
    # how far the rope is drawn out: what neither the slip nor the brake's own spring accounts for
    drawn = record.travel[-1] - record.slip[-1] - record.force[-1] / 131e3
    if not damping:
        assert drawn == pytest.approx(record.force[-1] / 16.8e3, rel=1e-6)

    def moves(_, state):
        return state[1], g - 16.8e3 * state[0] - damping * state[1]

    after = made.time - record.time[-1]
    start = (drawn, record.speed_of_mass[-1])
    how = {"rtol": 1e-10, "atol": 1e-13, "method": "Radau" if damping > 1000 else "DOP853"}
    own = solve_ivp(moves, (0, after[-1]), start, t_eval=after, dense_output=True, **how)
    force = 16.8e3 * own.y[0] + damping * own.y[1]
    assert made.force == pytest.approx(force, rel=1e-6, abs=1e-4)
    assert made.travel == pytest.approx(record.travel[-1] + own.y[0] - drawn, abs=1e-8)
    assert made.speed == pytest.approx(own.y[1], abs=1e-6)
    place, speed = own.sol(np.linspace(0, min(after[-1], 0.2), 20_001))
    most = float((16.8e3 * place + damping * speed)[: _until_rest(speed)].max())
    assert made.peak_force == pytest.approx(most, rel=2e-5)


def _until_rest(speed) -> int:
    stands = np.flatnonzero(speed < 0)
    return int(stands[0]) if len(stands) else len(speed)


def test_energy_bounds_the_crash(fallen):
    """Without damping the rope takes what was left: k (x1^2 - x0^2) / 2 = M v^2 / 2 + M g dx."""
    made = fallen
    assert made.crash_g == pytest.approx(made.crash_force / 9.80665)
    first, last = made.record.force[-1] / 16.8e3, made.crash_force / 16.8e3
    left = made.end_speed**2 / 2 + 9.80665 * (last - first)
    assert 16.8e3 * (last**2 - first**2) / 2 == pytest.approx(left, rel=1e-9)
    assert made.crash.speed[-1] == pytest.approx(0.0, abs=1e-9)
    assert made.crash.force[0] == pytest.approx(made.record.force[-1])
    # a stiffer rope crashes harder; a mass that only just bottoms out hardly crashes
    assert drop(KAPTON, **FALL, rope_stiffness=50e3).crash_force > made.crash_force
    # nothing left: the weight swings about where the rope bears it
    rest = replace(made.record, speed_of_mass=made.record.speed_of_mass * 0)
    assert crash(rest).peak_force == pytest.approx(2 * 9.80665 - made.record.force[-1])


def test_what_is_not_known_is_said_and_what_does_not_crash_has_none():
    alone = drop(KAPTON, **FALL)
    assert alone.crash is None and alone.crash_force is None and alone.crash_g is None
    assert "crash-unknown" in [w.key for w in alone.warnings if hasattr(w, "key")]
    stops = drop(KAPTON, mass="1 kg", speed="2.5 m/s", vacuum="94.5 kPa", rope_stiffness=16.8e3)
    assert stops.crash is None and stops.crash_force is None
    assert not [w for w in stops.warnings if "crash" in getattr(w, "key", "")]
    assert load(KAPTON).brake.sheets.usable_travel == pytest.approx(alone.slip)


def test_the_drop_and_its_crash_are_one_record(fallen):
    whole = append_crash(fallen.record, fallen.crash)
    assert (np.diff(whole.time) > 0).all()
    assert len(whole.time) == len(fallen.record.time) + len(fallen.crash.time) - 1
    assert whole.slip[-1] == fallen.slip
    # speed is what the displacement changes by
    middle = (whole.speed_of_mass[1:] + whole.speed_of_mass[:-1]) / 2 * np.diff(whole.time)
    assert middle.sum() == pytest.approx(whole.travel[-1] - whole.travel[0], rel=1e-3)
