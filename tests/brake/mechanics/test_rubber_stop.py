"""A mass stopped by a brake with a hyperelastic enclosure, against its integrated motion."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.energy import slip_heat
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    speed_at_slip,
    stop,
    time_at_slip,
)
from layerjam.brake.mechanics.tracing import double_precision
from layerjam.brake.simulate.drop import drop
from layerjam.core.errors import QuantityError
from strategies import KAPTON

pytestmark = pytest.mark.slow

G = 9.80665
SOFT = replace(
    KAPTON,
    hyperelastic=Hyperelastic(
        strain=12.0, c10=11e3, c20=300.0, softening_r=1.7, softening_m=4e3, softening_beta=0.2
    ),
)
FIRM = replace(SOFT, hyperelastic=Hyperelastic(strain=12.0, c10=11e3, c20=300.0))
SPRING = 14890.0
CASES = {
    "quick": (1.0, 2.5, 94.5e3),
    "stops before the force has fallen to the weight": (12.0, 0.2, 101.325e3),
    "softly": (1.0, 0.4, 12e3),
    "without vacuum": (0.02, 0.3, 0.0),
}
RESULTS = ("slip", "peak_force", "end_speed", "heat", "stored")


def integrated(mass: float, speed: float, vacuum: float, brake: Brake) -> tuple[float, ...]:
    """Slip, time and peak force of the motion of the mass, by Runge and Kutta."""
    slip = brake.sheets.usable_travel * np.linspace(0, 1, 4001) ** 2
    table = np.asarray(brake_force(slip, vacuum, brake))
    place = slip + table / SPRING

    def pull(z: float) -> float:
        if z <= place[0]:
            return SPRING * z
        return float(np.interp(z, place, table))

    def still(_: float, state: np.ndarray) -> float:
        return float(state[1])

    still.terminal, still.direction = True, -1
    made = solve_ivp(
        lambda _, y: (y[1], G - pull(y[0]) / mass),
        (0, 5),
        (0.0, speed),
        events=still,
        rtol=1e-8,
        atol=1e-11,
        max_step=1e-3,
    )
    z = made.y[0]
    forces = [pull(x) for x in z]
    return float(np.interp(z[-1], place, slip)), float(made.t[-1]), max(forces)


@pytest.mark.parametrize("name", CASES)
def test_a_stop_is_the_motion_of_the_mass_and_its_energy_balances(name: str) -> None:
    mass, speed, vacuum = CASES[name]
    case = (mass, speed, vacuum, SPRING, G)
    made = stop(*case, SOFT)
    slip, time, peak = integrated(mass, speed, vacuum, SOFT)
    assert int(made.outcome) == STOPPED
    assert float(made.slip) == pytest.approx(slip, rel=2e-5)
    assert float(made.peak_force) == pytest.approx(peak, rel=2e-4)
    assert float(time_at_slip(made.slip, *case, SOFT)) == pytest.approx(time, rel=2e-4)
    resist = float(brake_force(made.slip, vacuum, SOFT))
    given = mass * speed**2 / 2 + mass * G * (float(made.slip) + resist / SPRING)
    assert float(made.heat + made.stored) == pytest.approx(given, rel=1e-9)
    assert float(made.heat) == pytest.approx(float(slip_heat(made.slip, vacuum, SOFT)), rel=1e-9)
    # a first loading knows of no softening but for what becomes heat
    firm = stop(*case, FIRM)
    assert float(firm.slip) == pytest.approx(float(made.slip), rel=1e-9)
    assert float(firm.heat) < float(made.heat)
    book = mass * float(speed_at_slip(made.slip / 2, *case, SOFT)) ** 2 / 2
    half = float(made.slip) / 2
    resist = float(brake_force(half, vacuum, SOFT))
    grid = half * np.linspace(0, 1, 4001) ** 2
    work = np.trapezoid(np.asarray(brake_force(grid, vacuum, SOFT)), grid)
    book += work + resist**2 / (2 * SPRING)
    due = mass * speed**2 / 2 + mass * G * (half + resist / SPRING)
    assert book == pytest.approx(due, rel=1e-5)


def test_other_ends() -> None:
    speeds, vacuums = np.array([0.01, 3.7, 3.7, 1.0]), np.array([94.5e3, 94.5e3, 2e3, -1.0])
    made = stop(1.0, speeds, vacuums, SPRING, G, SOFT)
    assert list(map(int, made.outcome)) == [NEVER_SLID, BOTTOMED_OUT, BOTTOMED_OUT, NOT_A_CASE]
    assert made.slip[0] == 0 and made.heat[0] == 0
    for i in (1, 2):
        assert float(made.slip[i]) == pytest.approx(SOFT.sheets.usable_travel)
        resist = float(brake_force(made.slip[i], vacuums[i], SOFT))
        left = speeds[i] ** 2 / 2 + G * (made.slip[i] + resist / SPRING)
        left -= made.heat[i] + made.stored[i]
        assert float(made.end_speed[i]) == pytest.approx(float(2 * left) ** 0.5, rel=1e-9)
    snapped = stop(1.0, 6.0, 94.5e3, 1500.0, G, SOFT)
    assert int(snapped.outcome) == SNAPS
    # there the force falls as fast as the spring gives
    near = float(snapped.slip) * np.array([1 - 1e-5, 1 + 1e-5])
    low, high = np.asarray(brake_force(near, 94.5e3, SOFT))
    assert (high - low) / (near[1] - near[0]) == pytest.approx(-1500.0, rel=1e-3)


def test_stiff_rubber_stops_as_one_modulus() -> None:
    stiff = replace(KAPTON, hyperelastic=Hyperelastic(strain=0.5, c10=1.5e8))
    one = replace(KAPTON, enclosure=replace(KAPTON.enclosure, modulus=9e8))
    case = (12.0, 0.1, 94.5e3, SPRING, G)
    ours, due = stop(*case, stiff), stop(*case, one)
    assert 1e-5 < float(due.slip) < 1e-3 and int(ours.outcome) == STOPPED
    for name in RESULTS:
        assert float(getattr(ours, name)) == pytest.approx(float(getattr(due, name)), rel=2e-3)


def test_gradients_are_those_of_differences() -> None:
    def slip(speed: float, c10: float) -> object:
        changed = replace(SOFT, hyperelastic=replace(SOFT.hyperelastic, c10=c10))
        return stop(1.0, speed, 94.5e3, SPRING, G, changed).slip

    at = (2.5, 11e3)
    with double_precision():
        slopes = jax.grad(slip, argnums=(0, 1))(*at)
        for i, slope in enumerate(slopes):
            up, down = ([v * (1 + s * 1e-5 * (i == j)) for j, v in enumerate(at)] for s in (1, -1))
            due = (float(slip(*up)) - float(slip(*down))) / (2e-5 * at[i])
            assert float(slope) == pytest.approx(due, rel=1e-5)


def test_a_drop_is_recorded_and_one_beyond_the_fitted_strain_refused() -> None:
    file = replace(load("choi2018-kapton"), brake=SOFT)
    found, record = drop(file, mass=1.0, speed=2.5, vacuum=94.5e3, rope_stiffness=16.8e3)
    assert record.slip[-1] == pytest.approx(found.slip) and record.time[-1] == found.time
    assert record.force.max() == pytest.approx(found.peak_force, rel=1e-9)
    assert record.dissipated_energy[-1] == pytest.approx(found.heat, rel=1e-9)
    assert (np.diff(record.time) > 0).all() and record.speed_of_mass[-1] == pytest.approx(
        0, abs=1e-4
    )
    short = replace(SOFT, hyperelastic=replace(SOFT.hyperelastic, strain=2.0))
    with pytest.raises(QuantityError, match="beyond the measured"):
        drop(replace(file, brake=short), mass=1.0, speed=2.5, vacuum=94.5e3)
