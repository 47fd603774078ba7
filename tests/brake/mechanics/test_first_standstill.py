"""The first standstill and what lies beyond it, against `independent.stops`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest

from independent.stops import Drop
from layerjam.brake.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
)
from layerjam.brake.simulate.batch import batch
from layerjam.laws import brake_force, slip_heat, slip_work, speed_at_slip, stop, time_at_slip
from strategies import KAPTON, PTFE

G = 9.80665
SPACED = replace(KAPTON, mount=replace(KAPTON.mount, spacers=True), amplification_held=None)
Case = tuple[np.ndarray, ...]


def slow_drops(count: int, seed: int) -> Case:
    """Slow masses on a weak brake: the energy is tiny at first, and rises before it falls."""
    rng = np.random.default_rng(seed)
    mass, vacuum = 10 ** rng.uniform(-2.5, 1.5, count), 10 ** rng.uniform(0.5, 4.5, count)
    speed = 10 ** rng.uniform(-5, -1, count) * (rng.random(count) < 0.9)
    spring = rng.choice([14.9e3, 131e3, 1e6], count)
    return mass, speed, vacuum, spring, np.full(count, G)


def drops(count: int, seed: int) -> Case:
    rng = np.random.default_rng(seed)
    mass, speed = 10 ** rng.uniform(-2, 1.2, count), rng.uniform(0.0, 5.0, count)
    vacuum = 10 ** rng.uniform(2, 5, count)
    return mass, speed, vacuum, 10 ** rng.uniform(3.5, 6, count), rng.choice([0.0, G], count)


def same_stop(ours: Any, drop: Drop, right: np.ndarray) -> None:
    """Assert the outcome, and the slip to 1e-9 where the force at rest is not just the weight."""
    slides = drop.slides()
    outcome, slip = np.asarray(ours.outcome), np.asarray(ours.slip)
    assert np.array_equal(outcome == NEVER_SLID, ~slides)
    assert np.array_equal(outcome == STOPPED, np.isfinite(right))
    assert np.array_equal(outcome == BOTTOMED_OUT, np.isinf(right))
    assert np.array_equal(outcome == SNAPS, slides & np.isnan(right))
    stood = outcome == STOPPED
    root = np.where(stood, right, 0)
    firm = stood & (drop.force(root) - drop.mass * drop.gravity > drop.force(root) / 1000)
    assert stood.sum() > 100 and firm.sum() > 0.8 * stood.sum()
    assert slip[firm] == pytest.approx(right[firm].astype(float), rel=1e-9)


@pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
@pytest.mark.parametrize("make", [slow_drops, drops])
def test_stops_end_at_the_first_standstill_in_every_engine(make: Any, brake: Any) -> None:
    case = make(800, 7)
    drop = Drop(brake, *case)
    right = drop.standstill()
    same_stop(stop(*case, brake), drop, right)
    same_stop(stop(*map(jax.numpy.asarray, case), brake), drop, right)
    names = ("mass", "speed", "vacuum", "spring", "gravity")
    rows = batch(stop, {n: ("drop", v) for n, v in zip(names, case, strict=True)}, brake=brake)
    same_stop(rows, drop, right)


def test_a_slow_mass_on_a_weak_brake_is_not_stopped_at_once() -> None:
    ours = stop(0.02, 1e-3, 80.0, 131e3, G, KAPTON)
    assert float(ours.slip) == pytest.approx(1.2545e-3, rel=1e-4)


@pytest.mark.parametrize("engine", ["numpy", "jax", "kernel"])
def test_no_drop_changes_with_the_drops_around_it(engine: str) -> None:
    """Bit for bit: the drops of a block are exchanged for others that are harder to solve."""
    names = ("mass", "speed", "vacuum", "spring", "gravity")
    first, other = drops(800, 1), slow_drops(800, 2)
    kept = np.arange(800) % 3 == 0
    mixed = tuple(np.where(kept, *pair) for pair in zip(first, other, strict=True))

    def solve(case: Case) -> list[np.ndarray]:
        if engine == "kernel":
            axes: Any = {n: ("drop", v) for n, v in zip(names, case, strict=True)}
            rows = batch(stop, axes, brake=KAPTON)
            return [np.asarray(rows[n]) for n in ("slip", "peak_force", "heat", "outcome")]
        if engine == "jax":
            case = tuple(map(jax.numpy.asarray, case))
        ours = stop(*case, KAPTON)
        return [np.asarray(v) for v in (ours.slip, ours.peak_force, ours.heat, ours.outcome)]

    for alone, among in zip(solve(first), solve(mixed), strict=True):
        assert np.array_equal(alone[kept], among[kept], equal_nan=True)


@pytest.mark.parametrize("mass", [1e-3, 1.0, 1e3])
def test_without_speed_and_vacuum_a_mass_falls(mass: float) -> None:
    """The brake is then a spring: rope and enclosure in series, stretched to twice the sag."""
    sheets, wall = KAPTON.sheets, KAPTON.enclosure
    reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    face = wall.modulus * sheets.width * wall.wall / reach
    sag = mass * G / face
    # the energy balance of a mass on two springs in series: the force swings up to twice its weight
    for ours in (stop(mass, 0.0, 0.0, 131e3, G, KAPTON), one_of_a_batch(mass)):
        if 2 * sag < sheets.usable_travel:
            assert int(ours.outcome) == STOPPED
            assert float(ours.slip) == pytest.approx(2 * sag, rel=1e-9)
        else:
            assert int(ours.outcome) == BOTTOMED_OUT and float(ours.end_speed) > 0


def one_of_a_batch(mass: float) -> Any:
    axes: Any = {"mass": np.array([mass, 2 * mass]), "speed": 0.0, "vacuum": 0.0}
    return batch(stop, {**axes, "spring": 131e3, "gravity": G}, brake=KAPTON).isel(mass=0)


@pytest.mark.parametrize("place", range(5))
def test_an_infinite_quantity_is_not_a_case(place: int) -> None:
    case = [1.0, 2.0, 5e4, 131e3, G]
    case[place] = np.inf
    names = ("mass", "speed", "vacuum", "spring", "gravity")
    rows: Any = batch(
        stop, {n: np.array([v]) for n, v in zip(names, case, strict=True)}, brake=KAPTON
    )
    for ours in (stop(*case, KAPTON), rows, stop(*case, SPACED)):
        if names[place] == "spring":  # no rope, and a brake that does not stretch
            assert np.all(ours.outcome == STOPPED)
            continue
        assert np.all(ours.outcome == NOT_A_CASE)
        for field in ("slip", "peak_force", "end_speed", "heat", "stored"):
            assert np.isnan(np.asarray(getattr(ours, field))).all()


@pytest.mark.parametrize("brake", [KAPTON, SPACED], ids=["kapton", "with spacers"])
def test_beyond_the_first_standstill_there_is_neither_time_nor_speed(brake: Any) -> None:
    rng = np.random.default_rng(5)
    case = drops(400, 11)
    slip = rng.uniform(0, 0.06, 400)
    drop = Drop(KAPTON, *case)
    energy = drop.energy(slip)
    right = drop.standstill()
    path = np.linspace(0, 1, 400)[:, None] * slip
    falls = (np.diff(drop.place(path), axis=0) < 0).any(axis=0)
    reached = drop.slides() & (slip < np.where(np.isnan(right), np.inf, right)) & ~falls
    reached &= (drop.energy(path) > 0).all(axis=0)
    time = np.asarray(time_at_slip(slip, *case, brake))
    speed = np.asarray(speed_at_slip(slip, *case, brake))
    assert 50 < reached.sum() < 350
    assert np.array_equal(np.isnan(time), ~reached)
    assert np.array_equal(np.isnan(speed), ~reached)
    fast = reached & (energy > 1e-3 * drop.mass * drop.speed**2)
    pace = np.sqrt(2 * energy[fast] / drop.mass[fast])
    assert speed[fast] == pytest.approx(pace.astype(float), rel=1e-9)
    right = Drop(KAPTON, *(v[fast] for v in case)).time(slip[fast], 1000)
    assert time[fast] == pytest.approx(right.astype(float), rel=1e-4)


def test_at_a_standstill_there_is_still_a_time_and_beyond_it_none() -> None:
    case = drops(300, 21)
    ours = stop(*case, KAPTON)
    stood = np.asarray(ours.outcome) == STOPPED
    case, slip = tuple(v[stood] for v in case), np.asarray(ours.slip)[stood]
    time = np.asarray(time_at_slip(slip, *case, KAPTON))
    assert time == pytest.approx(Drop(KAPTON, *case).time(slip, 4000).astype(float), rel=1e-3)
    for law in (time_at_slip, speed_at_slip):
        assert np.isnan(law(slip * 1.001, *case, KAPTON)).all()


def test_beyond_the_overlap_sheets_that_are_apart_have_no_law() -> None:
    overlap = KAPTON.sheets.overlap
    for law in (brake_force, slip_work, slip_heat):
        assert np.isfinite(law(overlap, 5e4, KAPTON))
        assert np.isnan(law([overlap * 1.001, 0.1, 5e4], [5e4, 5e4, 0.02], KAPTON)).all()
