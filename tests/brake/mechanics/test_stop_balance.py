"""Every stop balances its energy, whatever its end; faster or heavier masses go further."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, STOPPED, stop
from strategies import KAPTON, change

SPRING = 2e4
BRAKES = {
    "plain": KAPTON,
    "exponent": replace(KAPTON, pressure_exponent=-0.2, test_pressure=1e4),
    "fan": change(KAPTON, mount__spacers=False, amplification_held=1.1, stiffness_measured=None),
    "rubber": replace(KAPTON, hyperelastic=Hyperelastic(strain=12.0, c10=11e3, c20=300.0)),
    "softening": replace(
        KAPTON,
        hyperelastic=Hyperelastic(
            strain=12.0, c10=11e3, c20=300.0, softening_r=1.7, softening_m=4e3, softening_beta=0.2
        ),
    ),
}
SPEEDS = np.concatenate(([0.02, 0.05], np.linspace(0.2, 6, 30)))


def stops(brake: Brake, vacuum: float, gravity: float) -> Any:
    return stop(0.8, SPEEDS, vacuum, SPRING, gravity, brake)


@pytest.mark.parametrize("gravity", [0.0, 9.8])
@pytest.mark.parametrize("vacuum", [2e4, 9e4])
@pytest.mark.parametrize("kind", BRAKES)
def test_arrival_and_weight_become_heat_tension_and_speed(
    kind: str, vacuum: float, gravity: float
) -> None:
    """Where the sheets have slid, the spring's force is the brake's at that slip."""
    brake = BRAKES[kind]
    made = stops(brake, vacuum, gravity)
    outcomes = set(np.asarray(made.outcome).astype(int).tolist())
    assert {STOPPED, NEVER_SLID, BOTTOMED_OUT} <= outcomes, outcomes
    slid = (made.outcome == STOPPED) | (made.outcome == BOTTOMED_OUT)
    end_force = np.asarray(brake_force(made.slip, vacuum, brake))
    place = np.where(slid, made.slip + end_force / SPRING, np.asarray(made.peak_force) / SPRING)
    gained = 0.4 * SPEEDS**2 + 0.8 * gravity * place
    used = np.asarray(made.heat + made.stored + 0.4 * made.end_speed**2)
    assert used == pytest.approx(gained, rel=1e-6)
    assert np.all((made.end_speed > 0) == (made.outcome == BOTTOMED_OUT))


@pytest.mark.parametrize("kind", BRAKES)
def test_a_faster_mass_goes_further_and_warms_the_brake_more(kind: str) -> None:
    made = stops(BRAKES[kind], 6e4, 9.8)
    for rising in (made.slip, made.heat, made.peak_force, made.end_speed):
        assert np.all(np.diff(rising) >= -1e-9 * np.abs(rising).max())
    ends = made.outcome == BOTTOMED_OUT
    assert made.slip[ends] == pytest.approx(BRAKES[kind].sheets.usable_travel, rel=1e-12)
