"""What a drop says beside its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.commands.drop import drop, observed
from layerjam.brake.commands.sensor import Sensing
from layerjam.brake.commands.tuning import tune
from layerjam.brake.device.load import load
from layerjam.brake.simulate.drop_in_time import History
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.evolve import evolve

CASE = {"mass": "1 kg", "speed": "2.5 m/s", "vacuum": "tuned", "travel": "40 mm",
        "rope_stiffness": "20 kN/m"}  # fmt: skip


@pytest.mark.slow
def test_a_damped_rope_takes_energy_that_the_tuned_vacuum_counted_on():
    plain = drop("choi2018-kapton", **CASE)
    damped = drop("choi2018-kapton", **CASE, rope_damping="50 N*s/m")
    assert abs(plain.slip - 0.040) < 1e-9
    assert damped.slip < plain.slip
    said = [w for w in damped.warnings if "tuned for a rope without damping" in w]
    assert len(said) == 1 and "not 40 mm" in said[0]
    assert not any("tuned for" in w for w in plain.warnings)


BARE = {"mass": "1 kg", "no_brake": True, "rope_stiffness": "16.8 kN/m"}


def test_a_mass_that_creeps_to_rest_on_its_rope_never_stands_still():
    answer = drop("choi2018-kapton", speed="2.5 m/s", rope_damping="5000 N s/m", **BARE)
    assert answer.stopping_time is None
    assert answer.end_speed is None
    assert answer.outcome is None
    assert "never comes to rest" in answer.reason
    assert answer.peak_force == pytest.approx(12500)
    level = drop(
        "choi2018-kapton", speed="2.5 m/s", rope_damping="5000 N s/m", horizontal=True, **BARE
    )
    assert level.outcome == "STOPPED"
    assert level.stopping_time > 0


def test_the_bare_drop_has_a_reading():
    bare = drop("choi2018-kapton", speed="3.7 m/s", **BARE)
    shown = observed(bare, Sensing(accelerometer="adxl193", filter_class="cfc180"))
    assert 0.9 * bare.peak_g < shown.measured_peak_g < bare.peak_g
    assert shown.filter == "cfc180"
    assert shown.temperature_rise is None
    ideal = observed(bare)
    assert ideal.measured_peak_g == pytest.approx(bare.peak_g, rel=1e-5)


@pytest.mark.slow
def test_a_snap_in_a_rising_history_gives_its_reason_not_a_remark():
    rising = History(np.array([0.001, 0.03]), np.array([20e3, 94.5e3]))
    answer = drop(
        "choi2018-kapton", mass="30 kg", speed="2.5 m/s", rope_stiffness="2.4 kN/m",
        vacuum_history=rising,
    )  # fmt: skip
    assert answer.outcome == "SNAPS"
    assert "the brake snaps" in answer.reason
    assert answer.reason not in answer.warnings
    assert 2400 < answer.least_stiffness < 2579


@pytest.mark.slow
def test_not_stopped_yet():
    answer = drop(
        "choi2018-kapton", mass="1 kg", speed="2.5 m/s", vacuum="94.5 kPa", duration="5 ms",
        rope_stiffness="16.8 kN/m",
    )  # fmt: skip
    assert answer.outcome == "FINISHED"
    assert answer.stopping_time is None
    assert answer.record.time[-1] == 0.005


def test_both_solvers_agree_on_what_snaps():
    how = {"mass": "30 kg", "speed": "2.5 m/s", "rope_stiffness": "2.55 kN/m"}
    exact = drop("choi2018-kapton", vacuum="94.5 kPa", **how)
    timed = drop("choi2018-kapton", vacuum="94.5 kPa", duration="1 s", **how)
    assert exact.outcome == timed.outcome == "BOTTOMED_OUT"


def test_tuned_in_capitals_is_a_hint():
    with pytest.raises(UnknownNameError, match="did you mean tuned"):
        drop("choi2018-kapton", mass=1.0, speed=2.5, vacuum="Tuned", travel=0.04)


@pytest.mark.parametrize("how", [{"horizontal": True, "mass": 1.0}, {"mass": 0.001}])
def test_too_slow_because_of_the_sleeve_and_not_the_weight(how):
    answer = tune("choi2018-kapton", speed=0.1, travel=0.04, **how)
    assert not answer.feasible
    assert "the enclosure alone" in answer.reason
    assert "weight" not in answer.reason


def test_tune_tells_numbers_apart_and_says_when_nothing_would_do():
    with pytest.raises(QuantityError, match="60.0001 mm is beyond the usable travel of 60 mm"):
        tune("choi2018-kapton", mass=1.0, speed=1.0, travel="60.0001 mm")
    fast = tune("choi2018-kapton", mass=1.0, speed=1e4, travel=0.04)
    assert "999 brakes" in fast.reason
    with pytest.raises(QuantityError, match="rope stiffness: 0 .* must be at least 1 N/m"):
        tune("choi2018-kapton", mass=1.0, speed=1.0, travel=0.04, rope_stiffness="0 kN/m")
    with pytest.raises(QuantityError, match="mass"):
        tune("choi2018-kapton", mass=1e-300, speed=1.0, travel=0.04)


def test_too_few_samples_for_a_drop_are_a_warning():
    stopped = drop("choi2018-kapton", mass=1.0, speed=2.5, vacuum=94.5e3, rope_stiffness=16.8e3)
    (sparse,) = observed(stopped, Sensing(sampling=100.0)).checks
    assert sparse["level"] == "warning" and "the peak may lie between them" in sparse["sentence"]
    (dense,) = observed(stopped, Sensing(sampling=20e3)).checks
    assert dense["level"] == "passed"


def test_a_record_that_ends_moving_is_not_called_stopped():
    swings = drop(
        "choi2018-kapton", mass=1.0, speed=2.5, vacuum=94.5e3, rope_stiffness=16.8e3,
        rope_damping=5.0, duration=0.022,
    )  # fmt: skip
    said = [w for w in observed(swings).warnings if "ends under load" in w]
    assert said
    assert all("FINISHED" in w for w in said)


@pytest.mark.parametrize("run", [drop, tune])
def test_rope_of_the_brake_file_is_included_as_the_notice_says(run):
    """A rope belongs to a test: without the option no stop has one, and a notice says so."""
    case = {key: CASE[key] for key in ("mass", "speed", "travel")}
    case |= {"vacuum": "tuned"} if run is drop else {}
    (notice,) = [w for w in run("choi2018-kapton", **case).warnings if w.key == "rope-not-used"]
    typed = notice.rpartition("--rope-stiffness ")[2]
    assert typed == "16.8kN/m"
    roped = run("choi2018-kapton", rope_stiffness=typed, **case)
    assert roped.vacuum == pytest.approx(59.93e3, rel=1e-4)
    bare = load("choi2018-kapton").brake
    none = run(evolve(bare, rope=None), **case)
    for answer in (roped, none):
        assert "rope-not-used" not in [w.key for w in answer.warnings]
    assert none.vacuum == run(bare, **case).vacuum


def test_stop_without_a_brake_or_that_snaps_states_its_rope():
    bare = drop("choi2018-kapton", speed="2.5 m/s", **BARE)
    assert "rope-not-used" not in [w.key for w in bare.warnings]
    soft = load("choi2018-kapton").brake.with_(stiffness_measured=2000.0, rope_stiffness="3 kN/m")
    snapped = drop(soft, mass="30 kg", speed="2.5 m/s", vacuum="94.5 kPa")
    (notice,) = [w for w in snapped.warnings if w.key == "rope-not-used"]
    assert notice.endswith("--rope-stiffness 3kN/m") and snapped.outcome == "SNAPS"
