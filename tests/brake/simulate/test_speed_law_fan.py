"""Sheets without spacers whose friction grows with speed: a fan at the friction of that speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import layerjam as lj
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.friction import sheet_friction_at
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.drop_in_time import drop_in_time
from layerjam.brake.simulate.record import Outcome

G = 9.80665
DEPTH, WEIGHT = np.polynomial.legendre.leggauss(16)
FANNED = load("choi2018-kapton").with_(
    count=31,
    spacers=False,
    amplification_held=None,
    stiffness_measured="400 kN/m",
    speed_law_power=0.1,
    speed_law_test_speed=0.013,
    speed_law_rest_speed=1e-2,
)


def sheet_by_sheet(slip: float, pace: float, vacuum: float, brake: Brake) -> float:
    """Friction [N] of a fan: the tension of each depth, with the coefficient of this speed."""
    law, sheets = brake.speed_law, brake.sheets
    assert law is not None
    grows = ((law.rest_speed + pace) / (law.rest_speed + law.test_speed)) ** law.power
    mu = brake.scale_factor * brake.film.kinetic * grows
    free = 1 / (sheets.free_left + slip) + 1 / (sheets.free_right + slip)
    # from the outermost sheet inwards: dT/di = -2 mu T t i (1/L1 + 1/L3), i from n/4 to 0
    i = (DEPTH + 1) / 2 * sheets.count / 4
    tension = np.exp(mu * sheets.thickness * free * ((sheets.count / 4) ** 2 - i**2))
    plain = mu * (sheets.count - 1) * sheets.width * vacuum * (sheets.overlap - slip)
    return float(plain * (WEIGHT / 2 * tension).sum())


def fanned_stop(brake: Brake, mass: float, speed: float, vacuum: float, spring: float) -> Any:
    """Slip, peak force and time by scipy's Radau, the pace from the force by Brent's root."""
    sheets, film, shell = brake.sheets, brake.film, brake.enclosure
    ea, q = shell.modulus * sheets.width * shell.wall, film.friction_on_silicone * sheets.width
    stretch = 2 * np.sqrt(ea * q * vacuum)

    def pace(z: float, x: float) -> float:
        pull = spring * (z - x) - stretch * np.sqrt(max(x, 0.0))
        if pull <= sheet_by_sheet(x, 0.0, vacuum, brake):
            return 0.0

        def excess(u: float) -> float:
            return sheet_by_sheet(x, u, vacuum, brake) - pull

        if excess(50.0) < 0:  # in a trial step
            return 50.0
        return float(brentq(excess, 0.0, 50.0, xtol=1e-13, rtol=1e-12))

    def change(_: float, y: Any) -> list[float]:
        return [y[1], G - spring * (y[0] - y[2]) / mass, pace(y[0], y[2])]

    def stands(_: float, y: Any) -> float:
        return float(y[1])

    stands.terminal, stands.direction = True, -1.0  # type: ignore[attr-defined]
    made: Any = solve_ivp(
        change, (0, 1), [0, speed, 0], "Radau", rtol=1e-8, atol=1e-11, events=stands,
        dense_output=True,
    )  # fmt: skip
    z, _, x = made.sol(np.linspace(0, made.t[-1], 4001))
    return float(x[-1]), float((spring * (z - x)).max()), float(made.t[-1])


@pytest.mark.campaign
def test_a_fan_whose_friction_grows_with_speed_is_amplified_at_that_friction() -> None:
    mass, speed, vacuum = 4.0, 2.5, 60e3
    timed, record = drop(FANNED, mass=mass, speed=speed, vacuum=vacuum)
    slip, peak, time = fanned_stop(FANNED.brake, mass, speed, vacuum, 400e3)
    assert timed.outcome is Outcome.STOPPED
    assert (timed.slip, timed.peak_force, timed.time) == pytest.approx((slip, peak, time), rel=2e-5)
    # energy: what arrived and what gravity gave is heat, or held
    gained = mass * speed**2 / 2 + mass * G * float(record.travel[-1])
    assert timed.heat + timed.stored == pytest.approx(gained, rel=2e-6)


@pytest.mark.campaign
def test_the_motion_in_time_which_shares_nothing_of_the_march_agrees() -> None:
    case = {"mass": 4.0, "speed": 2.5, "vacuum": 60e3}
    timed, other = drop(FANNED, **case)[0], drop_in_time(FANNED, **case)[0]
    assert (other.slip, other.peak_force) == pytest.approx((timed.slip, timed.peak_force), rel=5e-6)


def test_the_friction_of_a_fan_is_that_of_its_sheets_at_the_speed() -> None:
    for slip, pace in ((0.0, 1.0), (0.01, 0.0), (0.03, 0.2)):
        force = float(sheet_friction_at(slip, pace, 60e3, FANNED.brake))
        assert force == pytest.approx(sheet_by_sheet(slip, pace, 60e3, FANNED.brake), rel=1e-9)
    # the factor at the test speed would leave out much of it
    apart = float(sheet_friction_at(0.0, 0.013, 60e3, FANNED.brake)) * (1.01 / 0.023) ** 0.1
    assert float(sheet_friction_at(0.0, 1.0, 60e3, FANNED.brake)) > 1.2 * apart


@pytest.mark.slow
def test_a_pull_of_a_fan_is_that_at_the_friction_of_its_speed() -> None:
    pulled = lj.tensile(FANNED, vacuum=40e3, speed=0.2, travel=0.02)
    there = lj.force(FANNED, slip=float(pulled.record.slip[-1]), vacuum=40e3, sliding_speed=0.2)
    assert pulled.force_at_end == pytest.approx(there.force, rel=1e-6)
    # at the speed of the test it is the brake without the law
    slow = lj.tensile(FANNED, vacuum=40e3, speed=0.013, travel=0.02)
    bare = lj.tensile(
        replace(FANNED, brake=replace(FANNED.brake, speed_law=None)),
        vacuum=40e3, speed=0.013, travel=0.02,
    )  # fmt: skip
    np.testing.assert_allclose(slow.record.force, bare.record.force, rtol=1e-9)
