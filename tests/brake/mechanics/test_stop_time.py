"""The time of a stop that barely passes its slowest point, for every description of a brake."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.load import load
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, speed_at_slip, stop, time_at_slip
from layerjam.brake.mechanics.tracing import double_precision

KAPTON = replace(load("choi2018-kapton").brake, amplification_held=None)
SPACED = replace(KAPTON, mount=replace(KAPTON.mount, spacers=True))
FANNED = replace(KAPTON, mount=replace(KAPTON.mount, spacers=False))
G = 9.80665
SPRING = 1 / (1 / 131e3 + 1 / 16.8e3)


def barely_passing(mass: Any, vacuum: Any, brake: Brake, share: float) -> Any:
    """Speeds that exceed the fastest stop by a `share`, by halving on the outcome."""
    low, high = np.full(np.shape(mass), 0.05), np.full(np.shape(mass), 6.0)
    for _ in range(60):
        middle = (low + high) / 2
        passes = np.asarray(stop(mass, middle, vacuum, SPRING, G, brake).outcome) == BOTTOMED_OUT
        low, high = np.where(passes, low, middle), np.where(passes, middle, high)
    return high * (1 + share)


@pytest.mark.slow
def test_equal_brakes_take_equal_times() -> None:
    random = np.random.default_rng(4)
    mass, vacuum = random.uniform(0.5, 12, 400), random.uniform(2e4, 1e5, 400)
    speed = random.uniform(0.2, 4, 400)
    with double_precision():
        slip = np.asarray(stop(mass, speed, vacuum, SPRING, G, KAPTON).slip)
        plain, spaced = (
            np.asarray(time_at_slip(slip, mass, speed, vacuum, SPRING, G, brake))
            for brake in (KAPTON, SPACED)
        )
        heavy, pressed = random.uniform(6, 12, 60), random.uniform(4e4, 9e4, 60)
        fast = barely_passing(heavy, pressed, KAPTON, 1e-6)
        slow = [
            np.asarray(time_at_slip(0.06, heavy, fast, pressed, SPRING, G, brake))
            for brake in (KAPTON, SPACED)
        ]
    assert spaced == pytest.approx(plain, rel=1e-9)
    assert slow[1] == pytest.approx(slow[0], rel=1e-9)


def linear_rubber(modulus: float, strain: float) -> Hyperelastic:
    """A law whose stress is modulus * strain to 1e-10 of it, by least squares of its parts."""
    e = np.linspace(0.0, strain, 400)
    stretch, alphas = 1 + e, (1.0, -1.0)
    over = stretch**2 + 2 / stretch - 3
    lead = 2 * (stretch - stretch**-2)
    parts = [lead, lead / stretch, 2 * over * lead, 3 * over**2 * lead]
    parts += [stretch ** (a - 1) - stretch ** (-a / 2 - 1) for a in alphas]
    table = np.stack(parts, axis=1)
    size = np.abs(table).max(axis=0)
    share = np.linalg.lstsq(table / size, e, rcond=None)[0] / size
    assert np.abs(table @ share - e).max() < 1e-10
    c10, c01, c20, c30, *mus = (float(modulus * v) for v in share)
    ogden = dict(zip(("mu1", "alpha1", "mu2", "alpha2"), (mus[0], 1.0, mus[1], -1.0), strict=True))
    return Hyperelastic(strain=strain, c10=c10, c01=c01, c20=c20, c30=c30, **ogden)


@pytest.mark.slow
def test_every_description_of_one_brake_takes_its_time() -> None:
    """Spacers, rubber with a straight stress and effects that change nothing, against one modulus.

    Slips on both sides of the saturation, and both of the point where the weight is met.
    """
    film = replace(KAPTON.film, friction_on_silicone=0.04)
    one = replace(KAPTON, film=film, enclosure=replace(KAPTON.enclosure, modulus=1e6))
    spaced = replace(one, mount=replace(one.mount, spacers=True))
    rubbery = replace(one, hyperelastic=linear_rubber(1e6, 0.25))
    # a speed law, a pressure exponent and a share of the vacuum, all without effect
    still = SpeedLaw(power=0.0, test_speed=1e-3, rest_speed=1e-3)
    bare = replace(one, speed_law=still, pressure_exponent=0.0, test_pressure=5e4, vacuum_share=1.0)
    # two on their way to a standstill, and one that passes 12 mm with a force below its weight
    mass, speed = np.array([1.0, 1.0, 10.5]), np.array([1.6, 2.2, 2.0])
    slip, vacuum = np.array([0.002, 0.009, 0.012]), np.array([94.5e3, 94.5e3, 60e3])
    with double_precision():
        times = [
            np.asarray(time_at_slip(slip, mass, speed, vacuum, SPRING, G, brake))
            for brake in (one, spaced, rubbery, bare)
        ]
    assert np.isfinite(times[0]).all()
    for other in times[1:]:
        assert other == pytest.approx(times[0], rel=1e-9)


RUBBERY = replace(KAPTON, hyperelastic=Hyperelastic(strain=12.0, c10=11e3, c20=300.0))


@pytest.mark.parametrize(
    "brake",
    [
        pytest.param(KAPTON, id="plain"),
        pytest.param(SPACED, id="spaced", marks=pytest.mark.slow),
        pytest.param(FANNED, id="fanned", marks=pytest.mark.slow),
        pytest.param(RUBBERY, id="rubber", marks=pytest.mark.slow),
    ],
)
def test_a_stop_that_barely_passes_takes_its_time(brake: Brake) -> None:
    """Against Simpson's rule over dz/v with 2,500 pieces, dense at the start."""
    mass, vacuum, travel = 7.0, 80e3, KAPTON.sheets.usable_travel
    with double_precision():
        speed = float(barely_passing(mass, vacuum, brake, 1e-3))
        part = np.linspace(0.0, 1.0, 2501)
        slip = travel * part**4
        pace = np.asarray(speed_at_slip(slip, mass, speed, vacuum, SPRING, G, brake))
        way = slip + np.asarray(brake_force(slip, vacuum, brake)) / SPRING
        sliding = simpson(1 / pace, x=way)
        found = float(time_at_slip(travel, mass, speed, vacuum, SPRING, G, brake))
        start = float(time_at_slip(0.0, mass, speed, vacuum, SPRING, G, brake))
    assert pace.min() < 0.05 * pace.max()
    assert found - start == pytest.approx(sliding, rel=1e-10)
