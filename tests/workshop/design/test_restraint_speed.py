"""Machines whose brakes have a speed law: against scipy, and what they say of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.bench.control.follow import follow
from layerjam.bench.control.plant import linearise_line
from layerjam.bench.control.settings import Regulator
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.fluid.line_file import load_line
from layerjam.studies.machines.ankle_clutch import AnkleClutch
from layerjam.studies.machines.pulse import make_drive
from layerjam.studies.machines.registry import load_scenario
from layerjam.studies.machines.restraint import (
    Body,
    can_snap,
    difference_growth,
    make_strap,
    simulate_extremes,
    simulate_ride,
)
from strategies import KAPTON, unchecked

LAW = SpeedLaw(power=0.15, test_speed=0.013, rest_speed=1e-2)
FAST = replace(KAPTON, speed_law=LAW)
VACUUM = 60e3


def pace_of(force: float, slip: float, vacuum: float, brake: Brake) -> float:
    """Speed [m/s] at which one brake slides under a force [N]; from the formulas of the docs."""
    sheets, film, shell, law = brake.sheets, brake.film, brake.enclosure, brake.speed_law
    assert law is not None
    c = brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width * vacuum
    ea, q = shell.modulus * sheets.width * shell.wall, film.friction_on_silicone * sheets.width
    share = (force - 2 * np.sqrt(ea * q * vacuum * max(slip, 0.0))) / (c * (sheets.overlap - slip))
    whole = (law.rest_speed + law.test_speed) * max(share, 0.0) ** (1 / law.power)
    return float(max(whole - law.rest_speed, 0.0))


def thrown(push: Any, until: float, chains: int, series: int, body: Body, webbing: float) -> Any:
    """A body behind chains whose every brake slides by itself: way, greatest force, slips."""
    assert KAPTON.stiffness_measured is not None
    spring = 1 / (series / (chains * KAPTON.stiffness_measured) + 1 / webbing)

    def force(y: Any) -> float:
        return float(max(spring * (body.ratio * y[0] - body.slack - y[2:].sum()), 0.0))

    def change(t: float, y: Any) -> list[float]:
        pull = force(y)
        slides = [pace_of(pull / chains, x, VACUUM, FAST) for x in y[2:]]
        return [y[1], push(t) - body.ratio * pull / body.mass, *slides]

    start = [0.0, 0.0, *np.zeros(series)]
    made: Any = solve_ivp(
        change, (0, until), start, "LSODA", rtol=1e-8, atol=1e-10, max_step=2e-3, dense_output=True
    )
    rows = made.sol(np.linspace(0, until, 4001))
    return rows[0].max(), max(force(row) for row in rows.T), made.y[2:, -1]


@pytest.mark.parametrize(
    ("chains", "series"), [pytest.param(16, 1, marks=pytest.mark.slow), (10, 3)]
)
def test_a_body_in_its_strap_is_what_another_integrator_finds(chains: int, series: int) -> None:
    duration = 0.06
    body, webbing = Body(20.0, 1.2, 0.002), 2e5
    errors = []
    pulse, until = (lambda t: 4.0 / duration * (1 - np.cos(2 * np.pi * t / duration))), 0.09

    def push(t: float) -> float:
        return float(pulse(t)) if t < duration else 0.0

    way, force, slips = thrown(push, until, chains, series, body, webbing)
    assert np.ptp(slips) < 1e-6 * slips.max()
    strap = make_strap(chains, series, VACUUM, webbing, FAST)
    assert not bool(can_snap(strap))
    for steps in (1000, 4000):
        free, dt, change = make_drive("haversine", 4.0, duration, until - duration, steps, Path())
        assert change == pytest.approx(4.0, rel=1e-6)
        made = simulate_ride(free, dt, body, strap)
        assert 5e-3 < made.slip[-1] / series < 0.04
        errors.append(abs(made.slip[-1] / slips.sum() - 1))
    assert made.way.max() == pytest.approx(way, rel=2e-4)
    assert made.force.max() == pytest.approx(force, rel=2e-4)
    assert errors[1] < 2e-4
    assert errors[1] < 0.5 * errors[0]
    # lanes are single rides
    most = simulate_extremes(
        free, dt, body, make_strap(np.array([2, chains]), series, VACUUM, webbing, FAST)
    )
    assert most.slip[1] == pytest.approx(made.slip[-1], rel=1e-8)
    # and friction at the test speed lets the body go farther
    plain = simulate_ride(free, dt, body, make_strap(chains, series, VACUUM, webbing, KAPTON))
    assert plain.way.max() > 1.1 * made.way.max()


def test_a_difference_between_two_brakes_of_a_chain_grows_as_stated() -> None:
    soft = unchecked(FAST, enclosure=unchecked(FAST.enclosure, modulus=1e-3))
    assert KAPTON.stiffness_measured is not None
    spring, rate = KAPTON.stiffness_measured / 2, 1.0

    def change(t: float, y: Any) -> list[float]:
        pull = spring * (rate * t - y.sum())
        return [pace_of(pull, x, VACUUM, soft) for x in y]

    before = np.array([1e-7, 0.0])
    made: Any = solve_ivp(change, (0, 0.05), before, "LSODA", rtol=1e-10, atol=1e-14)
    after = made.y[:, -1]
    times = (after[0] - after[1]) / 1e-7
    # the elastic start and the slow one are left out of what is stated
    assert times > 10
    assert difference_growth(float(after.sum()), rate / 2, 2, soft) == pytest.approx(times, rel=0.1)


def test_the_clutch_slips_as_another_integrator_says() -> None:
    clutch = load_scenario("ankle-clutch")
    assert isinstance(clutch, AnkleClutch)
    file = replace(clutch.brake, brake=replace(clutch.brake.brake, speed_law=LAW))
    weak = replace(clutch, brake=file, brakes=replace(clutch.brakes, vacuum=30e3))
    rate = weak.gait.stride_rate
    stride = weak.simulate_stride(rate, None)
    part, _, payout, _ = weak.stretch_spring()
    time = (part - part[0]) / rate
    n, own = weak.brakes.parallel, file.brake
    chain = weak.brakes.series / (n * (own.stiffness_measured or np.nan))
    spring = 1 / (1 / weak.spring.stiffness + chain)

    def change(t: float, y: Any) -> list[float]:
        pull = max(spring * (np.interp(t, time, payout) - y[0]), 0.0)
        each = pace_of(pull / n, y[0] / weak.brakes.series, 30e3, own)
        return [weak.brakes.series * each]

    made: Any = solve_ivp(
        change, (0, time[-1]), [0.0], "LSODA", rtol=1e-8, atol=1e-11, max_step=time[1] * 4
    )
    assert stride.slip.max() > 1e-3
    assert stride.slip.max() == pytest.approx(made.y[0, -1], rel=2e-3)
    # several rates at once are each by itself
    two = weak.simulate_stride(np.array([rate, 2 * rate]), None)
    np.testing.assert_allclose(two.slip[:, 0], stride.slip, rtol=1e-7, atol=1e-12)
    # held at rest it lets go sooner than at the speed of the test
    share = (LAW.rest_speed / (LAW.rest_speed + LAW.test_speed)) ** LAW.power
    plain = replace(weak, brake=clutch.brake).simulate_stride(rate, None)
    assert stride.hold[0] == pytest.approx(share * plain.hold[0], rel=1e-12)


def test_a_force_is_followed_with_the_friction_of_the_slip() -> None:
    line = load_line("choi2018").record
    made = Regulator(
        plant=linearise_line(line, vacuum=60e3),
        sensor=Sensor(range=103e3, noise=0.0),
        kind="scheduled",
        safe_state="release",
        sample_time=0.01,
        reversible=True,
        tuned_at=60e3,
    )
    time, speed = np.arange(800) * 0.01, 2e-3
    wanted = 50 + 5 * np.sin(time)
    grows = ((LAW.rest_speed + speed) / (LAW.rest_speed + LAW.test_speed)) ** LAW.power
    other = replace(KAPTON, scale_factor=KAPTON.scale_factor * grows)
    ours, theirs = (follow(made, brake, wanted, speed * time) for brake in (FAST, other))
    np.testing.assert_allclose(ours.force, theirs.force, rtol=1e-9)
    np.testing.assert_allclose(ours.loop.vacuum, theirs.loop.vacuum, rtol=1e-9)


def test_a_machine_says_how_fast_its_sheets_slide_and_how_its_chains_do() -> None:
    belt: Any = load_scenario("seat-belt")
    assert "speed-law-unmeasured" in [getattr(n, "key", "") for n in belt.warnings()]
    law = replace(LAW, fastest=0.1)
    file = load("choi2018-kapton")
    known = replace(belt, brake=replace(file, brake=replace(KAPTON, speed_law=law)))
    assert "speed-law" in [getattr(n, "key", "") for n in known.warnings()]
    paces = np.array([0.0, 5.0 * known.brakes.series])
    keys = [n.key for n in known.note_slip(0.01 * known.brakes.series, paces)]
    assert keys[0] == "speed-law-beyond"
    assert ("speed-law-chain" in keys) == (known.brakes.series > 1)
    assert known.note_slip(0.01, None) == []
