"""The four machines: what they must do by their own physics."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.fluid.closed_forms import time_constant
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.mechanics.pull import brake_force
from layerjam.core.units import parse
from layerjam.studies.machines import (
    ankle_clutch,
    injury,
    neck_guard,
    readiness,
    rehabilitation,
    seat_belt,
)
from layerjam.studies.machines.pulse import make_drive
from layerjam.studies.machines.registry import load_scenario, scenarios
from layerjam.studies.machines.restraint import Trial, make_limiter
from layerjam.studies.machines.verdict import Result
from machine_scenarios import changed

NOTHING = np.zeros(4001)
VACUUM = 94.5e3


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    return {name: load_scenario(name).analyse() for name in scenarios()}


# the machines


@pytest.mark.slow
def test_the_seat_belt_s_limiter_just_uses_the_space(results: dict[str, Result]) -> None:
    own, numbers = results["seat-belt"].own, results["seat-belt"].scenario
    assert own["limiter_excursion"] == pytest.approx(numbers.limits.space, rel=1e-3)
    assert own["limiter_excursion"] > own["webbing_excursion"]
    assert own["limiter_belt_force"] < own["webbing_belt_force"]
    # no constant force stops it in less than car and chest have of way together
    mass = numbers.occupant.mass * numbers.occupant.share
    crush = own["change"] * numbers.crash.duration / 2
    bound = mass * own["change"] ** 2 / 2 / (crush + numbers.limits.space)
    assert own["limiter_force"] * numbers.belt.payout > bound
    # slack and webbing take part of the space, so that it is more, but not three times as much
    assert own["limiter_force"] * numbers.belt.payout < 3 * bound


def test_the_seat_belt_s_brakes_are_far_too_few(results: dict[str, Result]) -> None:
    made = results["seat-belt"]
    own = made.own
    assert not made.feasible and own["bottomed_out"] and not own["snaps"]
    # what they can take up is a small part of what comes
    assert own["energy_slipped"] <= own["energy_capacity"] < 0.05 * own["energy_put_in"]
    assert made.brakes_needed == own["needed_series"] * own["needed_parallel"] > 100
    assert own["needed_mass"] == pytest.approx(made.brakes_needed * 0.02, rel=1e-3)
    assert not own["needed_meets_loads"] and "ideal limiter" in made.verdict


@pytest.mark.slow
def test_two_dozen_brakes_hold_what_the_energy_asks_for(results: dict[str, Result]) -> None:
    """75 kg at 2 m/s: 150 J at 7.03 J a brake are 21.3, and they stop in the space."""
    made = results["slow-stop"]
    own, energy = made.own, 75 * 2.0**2 / 2
    assert made.feasible, made.verdict
    assert own["needed_meets_loads"] and own["needed_as_built"]
    assert energy / 7.03 < own["needed_count"] < 1.4 * energy / 7.03
    assert own["energy_slipped"] == pytest.approx(energy, rel=0.05)
    needed = {
        "brakes__parallel": str(own["needed_parallel"]),
        "brakes__series": str(own["needed_series"]),
    }
    built = changed("slow-stop", **needed).analyse()
    assert built.feasible and built.own["excursion"] == pytest.approx(
        own["needed_excursion"], rel=0.02
    )
    # tuned to the crash the force is less, but then the vacuum must be made in no time
    soft = changed("slow-stop", brakes__mode='"tuned"').analyse()
    assert soft.own["vacuum"] < made.own["vacuum"] and not soft.own["bottomed_out"]
    assert soft.own["excursion"] > made.own["excursion"]
    assert not soft.feasible and "time to reach the vacuum" in soft.reason


@pytest.mark.parametrize("vacuum", [pytest.param("94.5 kPa", marks=pytest.mark.slow), "40 kPa"])
def test_the_seat_belt_s_capacity_is_at_its_own_vacuum(vacuum: str) -> None:
    """The area under force over slip, by trapezia: it falls with the scenario's vacuum."""
    made = changed("seat-belt", brakes__vacuum=f'"{vacuum}"').analyse()
    scenario = made.scenario
    slip = scenario.brake.brake.sheets.usable_travel * np.linspace(0, 1, 4001) ** 2
    force = np.asarray(brake_force(slip, made.own["vacuum"], scenario.brake.brake))
    work = scenario.brakes.count * np.trapezoid(force, slip)
    assert made.own["vacuum"] == parse(vacuum, "Pa", "vacuum")
    assert made.own["energy_capacity"] == pytest.approx(work, rel=1e-6)
    # bottomed out, the brakes have taken up all of it, as closely as the ride keeps energy
    assert made.own["bottomed_out"]
    assert made.own["energy_slipped"] == pytest.approx(made.own["energy_capacity"], rel=4e-4)


def test_the_bare_head_turns_as_the_blow_says(results: dict[str, Result]) -> None:
    made = results["neck-guard"]
    own, blow = made.own, made.scenario.blow
    change = blow.peak * blow.duration * 2 / math.pi
    assert own["bare_acceleration"] == pytest.approx(blow.peak, rel=1e-6)
    assert own["bare_speed"] == pytest.approx(change, rel=1e-6)
    assert own["bare_bric"] == pytest.approx(change / injury.BRIC_CRITICAL[1], rel=1e-6)
    assert own["acceleration"] < own["bare_acceleration"]
    assert not made.feasible and "time to reach the vacuum" in made.reason


def test_the_head_feels_tangential_and_centripetal_acceleration() -> None:
    made = neck_guard.head_acceleration(np.array([300.0, 0.0]), np.array([20.0, 20.0]), 0.1)
    np.testing.assert_allclose(made, [50.0, 40.0])


def test_a_belt_that_has_not_stopped_yet_does_not_count() -> None:
    scenario = load_scenario("slow-stop")
    assert isinstance(scenario, seat_belt.SeatBelt)
    push, dt, _ = make_drive("half-sine", 2.0, 0.02, 0.5, 8000, Path())
    trial = Trial(scenario, scenario.make_trial()[0].body, 2e5, push, dt)
    whole = scenario.list_stopping_belts(trial, series=4, parallel=[6, 8])
    assert list(whole["count"]) == [24, 32] and whole.sound.all() and whole.as_built.all()
    short = trial._replace(drive=push[:800])
    assert scenario.list_stopping_belts(short, series=4, parallel=[6, 8]).empty


def test_turning_is_moving_with_inertia_over_lever_squared() -> None:
    """Twice the lever: four times the stiffness and twice the force felt; same turn."""
    scenario = changed("neck-guard", brakes__parallel="4")
    assert isinstance(scenario, neck_guard.NeckGuard)
    near = scenario.simulate_turn("near", scenario.make_trial()[0], make_limiter(200.0, 4e5))
    guard = replace(scenario.guard, lever=2 * scenario.guard.lever)
    wide: neck_guard.NeckGuard = replace(scenario, guard=guard)
    far = wide.simulate_turn("far", wide.make_trial()[0], make_limiter(100.0, 1e5))
    np.testing.assert_allclose(far.angular, near.angular, rtol=1e-9, atol=1e-6)
    assert far.rotation == pytest.approx(near.rotation, rel=1e-9)
    assert scenario.inertia == pytest.approx(0.0852, rel=1e-3)


def test_enough_brakes_in_stiff_straps_keep_the_head_below_the_paper_s_limit(
    results: dict[str, Result],
) -> None:
    own = results["neck-guard"].own
    assert own["needed_count"] and not own["needed_as_built"]
    scenario = changed(
        "neck-guard", brakes__parallel=str(own["needed_count"]),
        guard__stiffness=f'"{own["needed_stiffness"]} N/m"',
    )  # fmt: skip
    made = scenario.analyse()
    assert made.own["acceleration"] <= 3500 * 1.001 and made.own["needed_as_built"]
    # jammed for good, the wearer could not turn the head
    standing = changed(
        "neck-guard", brakes__parallel=str(own["needed_count"]), supply__mode='"standing"',
        guard__stiffness=f'"{own["needed_stiffness"]} N/m"',
    )  # fmt: skip
    held = standing.analyse()
    assert not held.feasible and "own turning" in held.reason
    assert held.own["locked_torque"] == pytest.approx(own["needed_torque"], rel=1e-9)


def test_a_clutch_that_holds_gives_all_back(results: dict[str, Result]) -> None:
    made = results["ankle-clutch"]
    own, numbers = made.own, made.scenario
    stiff = own["spring_force"] / own["stretch"]
    brakes = numbers.brakes.parallel * 131e3
    assert 1 / stiff == pytest.approx(1 / numbers.spring.stiffness + 1 / brakes, rel=1e-9)
    exact = stiff * own["stretch"] ** 2 / 2
    assert own["energy_stored_if_ready"] == pytest.approx(exact, rel=1e-4)
    assert own["energy_returned_if_ready"] == pytest.approx(exact, rel=1e-4)
    # with the paper's line it slips: what is lost and given back was put in, up to the samples
    assert own["energy_lost"] > own["energy_returned"] > 0
    assert own["energy_returned"] == pytest.approx(own["energy_stored"], rel=0.01)
    assert own["static_holding_force"] / own["holding_force"] == pytest.approx(4 / 3)
    assert not made.feasible and made.brakes_needed == 2


def test_a_pump_twice_as_fast_follows_twice_the_stride_rate() -> None:
    scenario = load_scenario("ankle-clutch")
    assert isinstance(scenario, ankle_clutch.AnkleClutch)
    line = readiness.scale_line(scenario.line.line, 2)
    fast = replace(line, pump=replace(line.pump, flow=2 * line.pump.flow))
    rates = np.array([0.05, 0.1, 0.2, 0.8])
    np.testing.assert_allclose(
        scenario.simulate_stride(2 * rates, fast).slip, scenario.simulate_stride(rates, line).slip,
        rtol=1e-6, atol=1e-9,
    )  # fmt: skip
    assert (np.diff(scenario.simulate_stride(rates, line).slip.max(axis=0)) >= 0).all()


def test_the_vacuum_rises_as_its_closed_form() -> None:
    line = load_line("choi2018").line
    time = np.linspace(0, 5, 50)
    a, tau = line.site.atmosphere, time_constant(line)
    made = ankle_clutch.pumped_vacuum(time, 94.5e3, line)
    np.testing.assert_allclose(made, np.minimum(a * -np.expm1(-time / tau), 94.5e3), rtol=1e-3)
    assert time_constant(readiness.scale_line(line, 4)) == pytest.approx(4 * tau)
    assert readiness.vacuum_time(94.5e3, line) == pytest.approx(tau * math.log(a / (a - 94.5e3)))
    assert readiness.vacuum_time(1.02e5, line) == math.inf


FAST_LINE = """
name = "fast"
chamber = { volume = "7.5 mL" }
pump = { flow = "200 mL/s" }
valve = { conductance = "0.3 L/(s bar)" }
"""


def test_a_fast_line_makes_clutch_and_exercise_feasible(tmp_path: Path) -> None:
    (tmp_path / "fast.toml").write_text(FAST_LINE)
    clutch = changed("ankle-clutch", tmp_path, line='"fast.toml"').analyse()
    assert clutch.feasible, clutch.verdict
    assert clutch.own["energy_returned"] == pytest.approx(
        clutch.own["energy_returned_if_ready"], rel=0.05
    )
    clock = {"line": '"fast.toml"', "control__sample_time": '"2 ms"'}
    arm = changed("rehabilitation", tmp_path, **clock).analyse()
    assert arm.feasible, arm.verdict
    assert arm.own["rms_error"] < 0.1 and arm.own["possible"] == 1
    locked = changed("rehabilitation", tmp_path, **clock, safe_state='"hold"').analyse()
    assert not locked.feasible and "safe state" in locked.reason


def test_the_exercise_goes_from_start_to_end_and_back() -> None:
    scenario = load_scenario("rehabilitation")
    exercise = scenario.exercise
    assert isinstance(scenario, rehabilitation.Rehabilitation)
    made = scenario.make_session(exercise.speed, 3, 0.01)
    assert made.angle.min() == pytest.approx(exercise.start)
    assert made.angle.max() == pytest.approx(exercise.end, rel=1e-3)
    flexion = made.speed[made.flexing]
    assert flexion.mean() == pytest.approx(exercise.speed, rel=0.01)
    assert made.torque[made.speed < -0.01].max() == 0
    # at rest the torque of the start is ready, and speed adds its own
    wanted = scenario.target_torque(np.array([exercise.start]), np.array([0.0]))
    assert wanted[0] == pytest.approx(1.0) and made.torque[0] == pytest.approx(1.0)
    faster = scenario.target_torque(np.array([exercise.start]), np.array([2.0]))
    assert faster[0] - wanted[0] == pytest.approx(2.0 * exercise.viscosity)


def test_slower_flexion_can_be_followed_better(results: dict[str, Result]) -> None:
    record: rehabilitation.Record = results["rehabilitation"].record
    assert record.shares[0] == 1 and record.shares[-1] < 0.1
    assert (np.diff(record.shares) < 0.02).all()
    own = results["rehabilitation"].own
    assert 0 < own["fastest_speed"] < results["rehabilitation"].scenario.exercise.speed
    given = record.given[record.session.flexing]
    error = given - record.session.torque[record.session.flexing]
    assert own["rms_error"] == pytest.approx(float(np.sqrt(np.mean(error**2))))
