"""Friction that falls with pressure: inverses stay in their domain, fans stay bounded."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from layerjam.brake.device.brake import Brake, validate
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.pull import brake_force, vacuum_for_force
from layerjam.brake.mechanics.stop.tune import tuned_vacuum, vacuum_eq10
from layerjam.brake.mechanics.tracing import double_precision
from layerjam.core.errors import QuantityError

KAPTON = load("choi2018-kapton").brake
TRAVEL = 0.04


def falling(exponent: float) -> Brake:
    return replace(KAPTON, pressure_exponent=exponent, test_pressure=40e3)


def force(slip: Any, vacuum: float, brake: Brake) -> Any:
    """The law by hand: sheets over pressure, and two faces of the enclosure (mechanics.md, 2)."""
    s, e = brake.sheets, brake.enclosure
    mu = brake.scale_factor * brake.film.kinetic
    mu *= (vacuum / brake.test_pressure) ** brake.pressure_exponent  # type: ignore[operator]
    sheets = mu * (s.count - 1) * s.width * (s.overlap - slip) * vacuum
    stiffness, q = e.modulus * s.width * e.wall, brake.film.friction_on_silicone * s.width * vacuum
    reach = (s.free_left + s.overlap + s.free_right) / 2
    spreads = slip < q * reach**2 / stiffness
    face = np.where(
        spreads, np.sqrt(stiffness * q * slip), stiffness * slip / 2 / reach + q * reach / 2
    )
    return sheets + 2 * face


def balance(mass: float, speed: float, gravity: float, brake: Brake) -> float:
    """The vacuum at which the mass stops after TRAVEL, by Simpson's rule and halving."""
    slip = np.linspace(0.0, TRAVEL, 20_001)
    weights = np.ones(slip.size)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0

    def excess(vacuum: float) -> float:
        pull = force(slip, vacuum, brake)
        work = float(weights @ pull) * (slip[1] - slip[0]) / 3
        spring = float(brake.stiffness_measured or 0)
        last = float(pull[-1])
        return (
            work
            + last**2 / (2 * spring)
            - mass * speed**2 / 2
            - mass * gravity * (TRAVEL + last / spring)
        )

    low, high = 1e-3, 101325.0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return high


CASES = [*product((-0.3, -0.35, -0.4, -0.5), ((1.0, 2.5, 0.0), (0.05, 5.0, 0.0), (0.1, 6.0, 9.8)))]


@pytest.mark.parametrize(("exponent", "case"), CASES)
def test_a_mass_is_stopped_by_friction_that_falls_with_pressure(
    exponent: float, case: tuple[float, float, float]
) -> None:
    mass, speed, gravity = case
    brake = falling(exponent)
    with double_precision():
        found = float(tuned_vacuum(mass, speed, TRAVEL, brake.stiffness_measured, gravity, brake))
    assert found == pytest.approx(balance(mass, speed, gravity, brake), rel=2e-4)


def test_the_command_finds_the_vacuum_and_the_stop_ends_there() -> None:
    brake = falling(-1 / 3)
    advice = lj.tune(brake, mass=1.0, speed=2.5, travel=TRAVEL, horizontal=True)
    assert advice.feasible and 0 < advice.vacuum < 101325
    stop = lj.drop(brake, mass=1.0, speed=2.5, vacuum=advice.vacuum, horizontal=True)
    assert stop.slip == pytest.approx(TRAVEL, abs=2e-6)


@pytest.mark.parametrize("exponent", [-0.5, -1 / 3, -0.3, 0.2])
def test_no_inverse_leaves_its_domain(exponent: float) -> None:
    brake, slips = falling(exponent), np.linspace(0.0, 0.06, 13)
    with double_precision():
        alone = np.asarray(brake_force(slips, 0.0, brake))
        full = np.asarray(brake_force(slips, 101325.0, brake))
        for wanted in (alone, alone + 1e-12, (alone + full) / 2, full):
            vacuum = np.asarray(vacuum_for_force(wanted, slips, brake))
            known = vacuum[np.isfinite(vacuum)]
            assert known.size and ((known >= 0) & (known <= 101325)).all()
            again = np.asarray(brake_force(slips, vacuum, brake))
            assert np.isfinite(again[np.isfinite(vacuum)]).all()
        paper = np.asarray(vacuum_eq10(1.0, np.array([1e-9, 0.5, 2.5]), TRAVEL, brake))
        assert (paper[np.isfinite(paper)] >= 0).all() and np.isfinite(paper[1:]).all()


def fanned(exponent: float, lowest: float | None = 2e4) -> Brake:
    return replace(
        KAPTON,
        pressure_exponent=exponent,
        test_pressure=5e4,
        lowest_pressure=lowest,
        mount=replace(KAPTON.mount, spacers=False),
    )


def test_sheets_without_spacers_lose_their_friction_with_the_vacuum() -> None:
    """It grew to 4.7e85 N at 1 mPa: below the lowest measured pressure the coefficient stays."""
    brake = fanned(-0.5)
    validate(brake)
    vacuum = np.concatenate([[0.0], np.geomspace(1e-3, 101324.0, 400)])
    with double_precision():
        held = np.asarray(sheet_friction(0.0, vacuum, brake))
        pulled = np.asarray(brake_force(0.02, vacuum, brake))
        back = np.asarray(vacuum_for_force(pulled, 0.02, brake))
    assert held[0] == 0 and (np.diff(held) > 0).all() and held[1] < 1e-5
    below = vacuum[vacuum < 2e4]
    assert held[: below.size][1:] / below[1:] == pytest.approx(held[1] / vacuum[1], rel=1e-9)
    assert back == pytest.approx(vacuum, rel=1e-9, abs=1e-6)


def test_an_exponent_of_sheets_without_spacers_needs_its_range() -> None:
    with pytest.raises(QuantityError, match=r"lowest_pressure: is missing.*without bound"):
        validate(fanned(-0.3, None))
    validate(fanned(0.3, None))
    with pytest.raises(
        QuantityError, match="lowest_pressure: is only valid with a pressure_exponent of"
    ):
        replace(fanned(-0.3), mount=replace(KAPTON.mount, spacers=True))
    with pytest.raises(QuantityError, match="their friction would fall as the vacuum rises"):
        replace(fanned(-0.6), sheets=replace(KAPTON.sheets, count=45))
