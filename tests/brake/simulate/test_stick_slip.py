"""True stick, exact saw, order of the integrator, energy, and when judder dies."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.friction import holding_force, sheet_friction
from layerjam.brake.mechanics.stick_slip.laws import critical_speed, film_curve, undamped_saw
from layerjam.brake.mechanics.stick_slip.slide import slide
from layerjam.brake.mechanics.stick_slip.slide_step import (
    STUCK,
    TAUT,
    Slide,
    State,
    exact_step,
    hermite_root,
)
from layerjam.brake.simulate.record import Outcome
from layerjam.brake.simulate.stick_slip import (
    StickSlipRecord,
    amplitude_map,
    find_critical_speed,
    force_bounds,
    make_slide,
    moving_mass,
    series_stiffness,
    stick_slip,
)
from layerjam.core.errors import FitError, QuantityError

FULL = 94.5e3
KAPTON, PTFE = load("choi2018-kapton"), load("choi2018-ptfe")
SAMPLES = 5000
"""Rows of a trace, one number for all blocks of constant friction: each number is compiled."""


def block(**given: Any) -> Slide:
    """A block of constant friction, 100 N kinetic, 130 N static."""
    values: dict[str, Any] = {
        "mass": 0.01, "spring": 131e3, "damping": 0.0, "speed": 0.05, "ramp": np.inf, "end": 1.0,
        "step": np.inf, "level": 100.0, "fall": 0.0, "rise": 0.3, "stribeck": 0.0, "exponent": 1.0,
        "viscous": 0.0, "base": 0.0, "enclosure": None, "overlap": np.inf, "start": 0.0,
        "events": 3.0, "tolerance": 1e-10,
    }  # fmt: skip
    return Slide(**{**values, **given})


@pytest.mark.parametrize(
    ("step", "start", "pace"),
    [(np.inf, 0.0, 0.0), (600.0, 0.0123, 0.0), (7.0, 0.0, 1e-3), (0.1, 0.0123, 1e-3)],
)
def test_a_load_below_static_friction_is_held_for_an_hour(
    step: float, start: float, pace: float
) -> None:
    frozen = make_slide(
        KAPTON.brake, vacuum=FULL, speed=1e-3, mass=0.01, stiffness=131e3, slip=start, frozen=True
    )
    load = 0.999 * float(force_bounds(frozen).static)
    record = stick_slip(
        KAPTON, vacuum=FULL, speed=1e-3, slip=start, travel=load / 131e3, hold=3600.0, step=step,
        stribeck=film_curve(KAPTON.brake, pace),
    )  # fmt: skip
    assert record.outcome is Outcome.STUCK and len(record.events) == 0
    assert record.time[-1] == pytest.approx(3600.0 + load / 131.0, rel=1e-14)
    assert {s.hex() for s in record.slip.tolist()} == {start.hex()}, "bit for bit"
    assert not record.sliding.any() and not record.speed_of_mass.any()
    held = record.time >= load / 131.0
    # force F stretches the spring by F/k and nothing more
    assert np.allclose(record.elongation[held], load / 131e3, rtol=1e-12, atol=0)
    assert np.allclose(record.elongation, record.force / 131e3, rtol=1e-12, atol=1e-17)
    if np.isfinite(step) and step < 10:
        assert len(record.time) > 3600 / step


def test_a_little_more_breaks_loose() -> None:
    static = float(holding_force(FULL, KAPTON.brake))
    record = stick_slip(KAPTON, vacuum=FULL, speed=1e-3, travel=1.001 * static / 131e3, hold=1.0)
    assert len(record.events) == 1
    assert record.events.force_at_break[0] == pytest.approx(static, rel=1e-13)
    # it holds again on the lower force for the rest of the second
    assert record.sliding[-1] == 0 and record.force[-1] < static


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize(
    ("kinetic", "rise", "speed"),
    [
        (175.4, 1 / 3, 1e-3),
        (51.8, 1.4, 0.3),
        pytest.param(175.4, 1 / 3, 1.0, marks=pytest.mark.slow),
        pytest.param(51.8, 1.4, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_undamped_block_follows_the_closed_form(
    exact: bool, kinetic: float, rise: float, speed: float
) -> None:
    at = block(level=kinetic, rise=rise, speed=speed, end=1e3)
    state = slide(at, exact=exact, samples=SAMPLES if exact else 1)
    saw = undamped_saw(kinetic * (1 + rise), kinetic, 131e3, 0.01, speed)
    row = np.asarray(state.table)[:3]
    tight = 1e-9 if exact else 1e-6
    assert int(state.count) == 3
    assert np.allclose(row[:, 2], kinetic * (1 + rise), rtol=1e-11)
    assert np.allclose(row[:, 3], float(saw.force_high), rtol=1e-4)  # from a cubic over a step
    assert np.allclose(row[:, 4], float(saw.force_low), rtol=1e-4, atol=1e-6)
    assert np.allclose(row[:, 5], float(saw.slip), rtol=tight)
    assert np.allclose(np.diff(row[:, 0]), float(saw.period), rtol=tight)
    assert np.allclose(row[:, 1] - row[:, 0], float(saw.slip_time), rtol=tight)


def test_a_slip_against_friction_that_falls_with_it_follows_the_closed_form() -> None:
    """Friction that falls by c per metre of slip takes c from the spring while the mass slides."""
    fall, drop, spring, mass, speed = 20e3, 30.0, 131e3, 0.01, 0.05
    state = slide(block(fall=fall, speed=speed, events=1.0))
    # m y'' + (k - c) y = drop + k V t from y = y' = 0, until y' = 0 again
    softer = spring - fall
    omega = np.sqrt(softer / mass)
    angle = 2 * (np.pi - np.arctan(drop * omega / (spring * speed)))
    slip = (drop * (1 - np.cos(angle)) + spring * speed / omega * (angle - np.sin(angle))) / softer
    begin, end, *_, travel = np.asarray(state.table)[0]
    assert travel == pytest.approx(slip, rel=1e-8)
    assert end - begin == pytest.approx(angle / omega, rel=1e-8)


@pytest.mark.parametrize("damping", [0.0, 5.0])
def test_a_crosshead_does_no_work_on_a_slack_spring(damping: float) -> None:
    """After each slip the spring is slack, and many short steps pass until it is taut."""
    slack = block(level=50.0, rise=1.5, damping=damping, step=2e-5, end=0.06)
    state = slide(slack, samples=SAMPLES)
    rows = np.asarray(state.trace)[: int(state.written)]
    _, crosshead, _, slip, speed, work, heat, sliding = rows.T
    waits = (crosshead < slip) & (sliding == 0)
    waits = waits[:-1] & waits[1:]
    assert waits.sum() > 20 and (np.diff(work)[waits] == 0).all()
    stored = 131e3 / 2 * np.maximum(crosshead - slip, 0.0) ** 2 + 0.01 / 2 * speed**2
    assert np.allclose(work, heat + stored, rtol=0, atol=1e-9 * work.max())


def test_a_run_that_ends_at_rest_keeps_where_the_mass_last_broke_loose() -> None:
    state = slide(block(end=0.025, step=1e-3), samples=SAMPLES)
    assert int(state.mode) == STUCK and int(state.count) == 1
    # 130 N stretch the spring by 130/k from the start at rest
    expected = [130 / (131e3 * 0.05), 0.0, 130.0]
    assert np.asarray(state.broke) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 1.7, 4.0])
def test_a_step_against_constant_friction_is_the_matrix_exponential(ratio: float) -> None:
    """Extension e and its rate u: m u' = F_k - k e - d u, and the mass moves at V - u."""
    mass, spring, friction, drive, h = 0.25, 100.0, 20.0, 0.3, 0.08
    drag = 2 * ratio * np.sqrt(mass * spring)  # 10 N s/m is critical
    at = block(mass=mass, spring=spring, damping=drag, speed=drive, level=friction, rise=0.5)
    matrix = np.array([[0.0, 1.0], [-spring / mass, -drag / mass]])
    offset = np.array([0.26 - friction / spring, drive - 0.1])

    def after(time: float) -> Any:
        return expm(matrix * time) @ offset

    def pull(time: float) -> float:
        return float(friction + np.array([spring, drag]) @ after(time))

    zero = np.zeros(())
    start = State(**dict.fromkeys(State._fields, zero))
    start = start._replace(mode=TAUT, slip=-0.26, velocity=0.1)
    trial = exact_step(start, h, at)
    stretch, rate = after(h)
    assert float(trial.velocity) == pytest.approx(drive - rate, rel=1e-12)
    travel = drive * h - (stretch - offset[0])
    assert float(trial.travel) == pytest.approx(travel, rel=1e-11)
    work = drive * quad(pull, 0, h, epsabs=0, epsrel=1e-12)[0]
    assert float(trial.work) == pytest.approx(work, rel=1e-11)
    lost = drag * quad(lambda t: float(after(t)[1] ** 2), 0, h, epsabs=0, epsrel=1e-12)[0]
    assert float(trial.heat) == pytest.approx(friction * travel + lost, rel=1e-10)


@pytest.mark.parametrize(
    "roots", [(0.7, -3.0, -5.0), (1.9, 2.5, 7.0), (0.6, 1.3, -5.0), (1e-3, 2.1, -1.0)]
)
def test_the_first_zero_of_a_cubic_over_a_step(roots: tuple[float, float, float]) -> None:
    """Over a step of 2, from values and slopes at its ends; the third ends above zero again."""
    cubic = np.poly1d(roots, r=True)
    cubic = cubic * np.sign(cubic(0.0))
    slope = cubic.deriv()
    crosses, zero = hermite_root(2.0, cubic(0.0), slope(0.0), cubic(2.0), slope(2.0))
    assert bool(crosses) and float(zero) == pytest.approx(roots[0], rel=1e-11)
    crosses, _ = hermite_root(2.0, 1.0, -0.4, 0.5, 0.1)
    assert not bool(crosses)


def test_order_of_the_integrator_is_five() -> None:
    """Stribeck friction through break, slip and stop: halving the step, events included."""
    at = block(stribeck=0.4, damping=4.0, speed=0.2, end=1.0, events=1.0)
    best = np.asarray(slide(at._replace(tolerance=1e-13)).table)[0]
    sizes = 5e-5 / 2.0 ** np.arange(4)
    errors = []
    for size in sizes:
        row = np.asarray(slide(at._replace(tolerance=0.0, step=size)).table)[0]
        errors.append(abs(row[5] - best[5]) / best[5])
    order = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert 4.6 < order < 5.6, (order, errors)


def test_the_tolerance_is_kept() -> None:
    at = block(stribeck=2e-3, damping=4.0, events=1.0)
    best = np.asarray(slide(at._replace(tolerance=1e-13)).table)[0, 5]
    for tolerance in (1e-6, 1e-8, 1e-10):
        found = np.asarray(slide(at._replace(tolerance=tolerance)).table)[0, 5]
        assert found == pytest.approx(best, rel=100 * tolerance)


@pytest.mark.slow
def test_batched_runs_equal_single_ones() -> None:
    speeds = np.geomspace(1e-3, 5, 4)
    at = block(damping=3.0, stribeck=1e-2, speed=speeds)
    many = slide(at)
    for i, speed in enumerate(speeds):
        one = slide(at._replace(speed=speed))
        assert int(one.reason) == int(many.reason[i]) and int(one.count) == int(many.count[i])
        assert np.allclose(one.table, many.table[i], rtol=1e-9, equal_nan=True)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.05, 0.6])
@pytest.mark.parametrize("pace", [0.0, 1e-9])
def test_judder_dies_at_the_critical_speed(ratio: float, pace: float) -> None:
    drag = 2 * ratio * np.sqrt(131e3 * 0.01)
    critical = float(critical_speed(130.0, 100.0, 131e3, 0.01, drag))
    speeds = critical * np.array([0.9, 0.999, 1.001, 1.1])
    at = block(damping=drag, speed=speeds, end=130 / (131e3 * speeds) + 1.0, stribeck=pace)
    assert np.asarray(slide(at).count > 0).tolist() == [True, True, False, False]


def test_critical_speed_by_runs_meets_the_closed_form() -> None:
    at = block(damping=5.0)
    closed = find_critical_speed(at)
    assert closed == pytest.approx(float(critical_speed(130, 100, 131e3, 0.01, 5.0)), rel=1e-12)
    assert np.isinf(find_critical_speed(block()))
    assert find_critical_speed(block(rise=0.0, damping=1.0)) == 0.0


@given(
    st.floats(1e-3, 3.0), st.floats(0.0, 1.2), st.sampled_from([0.0, 1e-3, 0.1]),
    st.floats(5e3, 101e3), st.sampled_from([KAPTON, PTFE]), st.floats(0, 0.03),
)  # fmt: skip
@settings(deadline=None, max_examples=12)
def test_energy_is_kept(
    speed: float, ratio: float, pace: float, vacuum: float, file: BrakeFile, slip: float
) -> None:
    mass, spring = moving_mass(file.brake), series_stiffness(file.brake)
    record = stick_slip(
        file, vacuum=vacuum, speed=speed, damping=2 * ratio * np.sqrt(mass * spring), slip=slip,
        stribeck=film_curve(file.brake, pace),
    )  # fmt: skip
    balance = record.work - record.dissipated_energy - record.stored_energy
    size = float(record.work.max()) + float(record.stored_energy[0])
    assert np.abs(balance + record.stored_energy[0]).max() < 1e-8 * size
    # heat and work only ever grow; the mass never runs backwards; the spring only pulls
    assert (np.diff(record.dissipated_energy) > -1e-9 * size).all()
    assert (record.speed_of_mass > -1e-9).all() and (record.force >= 0).all()
    assert (np.diff(record.slip) >= -1e-15).all()
    stuck = (record.sliding[:-1] == 0) & (record.sliding[1:] == 0)
    assert (np.diff(record.slip)[stuck] == 0).all()


def test_kapton_saws_and_ptfe_goes_slack() -> None:
    for file, high, slack in ((KAPTON, 233.9064, False), (PTFE, 124.3045, True)):
        record = stick_slip(file, vacuum=FULL, speed=1e-3)
        assert record.outcome is Outcome.JUDDERS and len(record.events) >= 12
        assert record.events.force_high[0] == pytest.approx(high, rel=1e-6)
        kinetic = float(sheet_friction(0.0, FULL, file.brake))
        low = 0.0 if slack else 2 * kinetic - high
        # the sleeve carries half a newton by the end of the first slip
        assert record.events.force_low[0] == pytest.approx(low, abs=1.0)
        # friction, and with it every tooth, falls as the overlap is used up
        assert (np.diff(record.events.force_high) < 0).all()


@pytest.mark.slow
def test_amplitude_map() -> None:
    brake = KAPTON.brake
    mass, spring = moving_mass(brake), series_stiffness(brake)
    drag = 0.1 * np.sqrt(mass * spring)
    speeds, vacuums = np.geomspace(1e-3, 5, 8)[:, None], np.array([20e3, 50e3, FULL])[None, :]
    found = amplitude_map(
        brake, speeds, vacuums, mass=mass, stiffness=spring, damping=drag, swings=60
    )
    assert found.amplitude.shape == (8, 3)
    edge = np.asarray(critical_speed(
        *force_bounds(make_slide(brake, vacuum=vacuums[0], speed=1.0, mass=mass, stiffness=spring,
                            frozen=True)), spring, mass, drag,
    ))  # fmt: skip
    assert (found.judders == (speeds < edge)).all()
    assert (found.amplitude[~found.judders] == 0).all()
    # slow: proportional to vacuum
    assert np.allclose(found.amplitude[0] / vacuums[0], found.amplitude[0, 0] / 20e3, rtol=1e-4)


@pytest.mark.slow
def test_critical_speed_with_a_slack_spring() -> None:
    # a slack spring lets the mass stop above the taut one's critical speed
    slack = block(level=50.0, rise=1.5, damping=3.0)
    assert find_critical_speed(slack) > 1.02 * float(critical_speed(125, 50, 131e3, 0.01, 3.0))


@pytest.mark.slow
def test_critical_speed_of_a_steep_curve_is_the_jump_laws() -> None:
    at = block(damping=5.0)
    found = find_critical_speed(at._replace(stribeck=1e-6))
    assert found == pytest.approx(find_critical_speed(at), rel=2e-3)


def test_faster_than_critical_it_slides_steadily() -> None:
    record = stick_slip(KAPTON, vacuum=FULL, speed=2.5, damping=7.2)
    assert record.outcome is Outcome.STEADY_SLIDING and len(record.events) == 0
    assert record.speed_of_mass[-1] == pytest.approx(2.5, rel=0.03)


def test_other_ends() -> None:
    assert stick_slip(KAPTON, vacuum=FULL, speed=1e-3, travel=1e-3).outcome is Outcome.STUCK
    heavy = stick_slip(PTFE, vacuum=FULL, speed=0.5, mass=20.0, slip=0.02, travel=0.047)
    assert heavy.outcome is Outcome.SEPARATED
    closed = stick_slip(KAPTON, vacuum=1e3, speed=1e-3, slip=0.04, travel=1e-6)
    assert closed.outcome is Outcome.CLOSED_BY_SLEEVE
    flat = dataclasses.replace(film_curve(KAPTON.brake), static=KAPTON.brake.film.kinetic)
    with pytest.raises(FitError, match="more than"):
        stick_slip(KAPTON, vacuum=FULL, speed=1e-3, stribeck=flat, mass=1e-6, travel=0.03)


def test_record_states_its_conditions(tmp_path: Any) -> None:
    record = stick_slip(KAPTON, vacuum=FULL, speed=1e-3, travel=3e-3)
    assert isinstance(record, StickSlipRecord)
    frame = record.to_frame()
    assert frame.attrs["units"]["speed_of_mass"] == "m/s"
    text = record.to_csv(tmp_path / "run.csv").read_text()
    for line in (
        "# made_by",
        "# mass: ",
        "# damping: 0.0 N s/m",
        "# Stribeck speed: ",
        "synthetic",
    ):
        assert line in text or line == "# made_by"
    with pytest.raises(dataclasses.FrozenInstanceError):
        record.speed = 1.0  # type: ignore[misc]


def test_without_vacuum_nothing_sticks() -> None:
    run = stick_slip(KAPTON, vacuum=0.0, speed=1e-3)
    assert np.isfinite(run.force).all()
    # only the unloaded sleeve is left
    assert run.force.max() < 0.1


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"vacuum": np.nan}, "vacuum"), ({"vacuum": 2e5}, "vacuum"), ({"speed": 0.0}, "speed"),
        ({"mass": -1.0}, "mass"), ({"travel": np.nan}, "travel"), ({"step": np.nan}, "step"),
        ({"hold": np.inf}, "hold"), ({"hold": 3600.0, "step": 0.05}, "longer steps"),
    ],
)  # fmt: skip
def test_what_cannot_be_pulled_is_refused(given: dict[str, float], word: str) -> None:
    with pytest.raises(QuantityError, match=word):
        stick_slip(KAPTON, **{"vacuum": 94.5e3, "speed": 1e-3, **given})
