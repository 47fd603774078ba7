"""Figures of merit: the laws' numbers, equal brakes together, and what rises with what."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.mechanics.arrays import map_leaves
from layerjam.brake.mechanics.energy import slip_work
from layerjam.brake.mechanics.stick_slip.laws import critical_speed
from layerjam.workshop.commands.show import show
from layerjam.workshop.design.arrays import Member, grid, totals
from layerjam.workshop.design.bounds import merit_direction
from layerjam.workshop.design.grid import AXES
from layerjam.workshop.design.merit import MERITS, StickSlipPull, line_merits, make_point, merits
from layerjam.workshop.design.stopping import StopRequirement, run_stops
from strategies import KAPTON, change, one, random_brakes

FILE = load("choi2018-kapton")
SHOWN = (
    "holding_force", "max_force", "usable_travel", "energy_capacity", "mass", "force_density",
    "sheet_stress", "clamp_stress", "buckling_force",
)  # fmt: skip


def in_numpy(function, *arguments):
    """By NumPy, which compiles nothing; `test_jax_computes_the_same` compares it with JAX."""
    with np.errstate(all="ignore"):
        return function(*map_leaves(lambda v: np.asarray(v, float)[()], arguments))


def batch(point, base, *more):
    return in_numpy(merits, point, base, *more)


def stopped(point, base, need, max_series):
    return in_numpy(partial(run_stops, max_series=max_series), point, base, need)


def file_of(brake) -> BrakeFile:
    return replace(FILE, brake=brake)


@pytest.mark.parametrize("measured", [True, False])
def test_a_brake_itself_has_the_merits_that_show_tells(measured):
    # the computed stiffness must lie above a measured one, as behind any mount
    brakes = random_brakes(7, 6, measured=measured)
    for i in range(6):
        brake = one(brakes, i)
        told, made = show(file_of(brake)), batch(make_point(brake), brake)
        for name in SHOWN:
            assert float(made[name]) == pytest.approx(told.values[name], rel=1e-12), name
        due = told.stiffness_measured if measured else told.stiffness_before_slip
        assert float(made["stiffness"]) == pytest.approx(due, rel=1e-9)


def test_a_weighed_brake_keeps_its_mass():
    brake = change(KAPTON, weighed_mass=0.0213)
    assert float(batch(make_point(brake), brake)["mass"]) == pytest.approx(0.0213, rel=1e-12)
    # twice the sheets add what they weigh
    more = make_point(brake)._replace(count=22)
    sheets = 11 * 0.085 * 0.013 * 0.254e-3 * 1420
    sleeve = 2 * 1e-3 * 11 * 0.254e-3 * 0.09 * brake.enclosure.density
    assert float(batch(more, brake)["mass"]) == pytest.approx(0.0213 + sheets + sleeve, rel=1e-9)


def test_jax_computes_the_same():
    point = make_point(KAPTON, 8e4)
    made = jax.jit(merits)(*jax.tree.map(np.float64, (point, KAPTON)))
    for name, value in batch(point, KAPTON).items():
        assert float(made[name]) == pytest.approx(float(value), rel=1e-12), name


@pytest.mark.slow
def test_jax_computes_the_same_stops():
    need = StopRequirement(mass=4.0, speed=2.9, horizontal=True)
    point = make_point(KAPTON, 94.5e3)._replace(series=3.0)
    made = jax.jit(run_stops, static_argnames="max_series")(point, KAPTON, need, max_series=3)
    for name, value in stopped(point, KAPTON, need, max_series=3).items():
        assert float(made[name]) == pytest.approx(float(value), rel=1e-12), name


def test_arrays_give_what_single_designs_give():
    width, count = jnp.linspace(0.01, 0.03, 5), jnp.arange(5.0, 10.0)
    point = make_point(KAPTON)._replace(width=width, count=count)
    many = batch(point, KAPTON)
    for i in range(5):
        alone = batch(make_point(KAPTON)._replace(width=width[i], count=count[i]), KAPTON)
        for name, values in many.items():
            np.testing.assert_allclose(np.broadcast_to(values, 5)[i], alone[name], rtol=1e-13)


def test_equal_brakes_share_and_add_up():
    point = make_point(KAPTON)
    single, both = batch(point, KAPTON), batch(point._replace(series=3.0, parallel=2.0), KAPTON)
    factors = {
        "holding_force": 2, "max_force": 2, "usable_travel": 3, "energy_capacity": 6, "mass": 6,
        "volume": 6, "clamped_length": 3, "stiffness": 2 / 3, "sheet_stress": 1,
        "force_density": 1 / 3,
    }  # fmt: skip
    for name, factor in factors.items():
        assert float(both[name]) == pytest.approx(factor * float(single[name]), rel=1e-12), name


def test_an_array_of_equal_brakes_weighs_and_does_the_same():
    array = grid(Member(brake=KAPTON, vacuum=80e3), series=2, parallel=3)
    told = totals(array, chamber=7.5e-6)
    made = batch(make_point(KAPTON, 80e3)._replace(series=2.0, parallel=3.0), KAPTON)
    for name, due in (("mass", told.mass), ("usable_travel", told.travel),
                      ("energy_capacity", told.energy), ("stiffness", told.stiffness)):  # fmt: skip
        assert float(made[name]) == pytest.approx(due, rel=1e-12), name


def test_an_offset_is_slip_taken_beforehand():
    # a brake set to a slip holds with what overlap is left, and has that much less travel
    point = make_point(KAPTON)._replace(offset=0.01)
    made = batch(point, KAPTON)
    assert float(made["usable_travel"]) == pytest.approx(0.05)
    ratio = float(made["holding_force"]) / float(batch(make_point(KAPTON), KAPTON)["holding_force"])
    assert ratio == pytest.approx(58 / 68, rel=1e-12)
    assert float(made["clamped_length"]) == pytest.approx(0.09 + 0.012 + 0.01)


def test_what_cannot_be_built_has_no_merits():
    for wrong in ({"width": 0.002}, {"vacuum": 2e5}, {"vacuum": 0.0}, {"usable_travel": 0.07}):
        made = batch(make_point(KAPTON)._replace(**wrong), KAPTON)
        assert all(np.isnan(v).all() for v in made.values()), wrong
    short = make_point(KAPTON)._replace(overlap=0.005, usable_travel=None)
    assert math.isnan(batch(short, KAPTON)["mass"])


def test_volume_and_box():
    made = batch(make_point(KAPTON), KAPTON)
    high = 11 * 0.254e-3 + 2e-3
    assert float(made["height"]) == pytest.approx(high)
    assert float(made["volume"]) == pytest.approx(0.015 * high * 0.102)


def test_judder_margin_is_one_at_the_critical_speed():
    point, zeta, mass = make_point(KAPTON), 0.03, 2.0
    made = batch(point, KAPTON)
    held, k = float(made["holding_force"]), float(made["stiffness"])
    slides = held * KAPTON.film.kinetic / KAPTON.film.static
    edge = float(critical_speed(held, slides, k, mass, 2 * zeta * math.sqrt(k * mass)))
    for factor, due in ((1.0, 1.0), (2.0, 4.0)):
        there = batch(
            point, KAPTON, StickSlipPull(speed=edge * factor, mass=mass, damping_ratio=zeta)
        )["judder_margin"]
        assert float(there) == pytest.approx(due, rel=1e-6)


def test_the_line_of_one_brake_is_that_of_rise_and_many_take_as_many_times():
    line = load_line("choi2018")
    told = rise("choi2018", target="80 kPa")
    time, work = line_merits(80e3, line.line, 1.0)
    assert time == pytest.approx(told.rise_time, rel=1e-3)
    assert work == pytest.approx(told.gas_work, rel=1e-12)
    assert line_merits(80e3, line.line, 3.0) == pytest.approx((3 * time, 3 * work), rel=1e-12)
    assert math.isnan(line_merits(2e5, line.line, 1.0)[0])


def test_a_stop_of_one_is_that_of_drop_and_two_share_it():
    need = StopRequirement(mass=1.0, speed=2.5, travel=0.06)
    point = make_point(KAPTON, 94.5e3)
    told = drop("choi2018-kapton", mass="1 kg", speed="2.5 m/s", vacuum="94.5 kPa")
    alone = stopped(point, KAPTON, need, max_series=3)
    assert float(alone["stop_slip"]) == pytest.approx(told.slip, rel=1e-12)
    assert float(alone["stop_peak"]) == pytest.approx(told.peak_force, rel=1e-12)
    both = stopped(point._replace(parallel=2.0), KAPTON, replace(need, mass=2.0), max_series=3)
    assert float(both["stop_slip"]) == pytest.approx(told.slip, rel=1e-12)
    assert float(both["stop_peak"]) == pytest.approx(2 * told.peak_force, rel=1e-12)


@pytest.mark.parametrize(("gravity", "speed"), [(0.0, 2.9), (KAPTON.site.gravity, 2.3)])
def test_brakes_in_series_take_the_energy_one_after_another(gravity, speed):
    point = make_point(KAPTON, 94.5e3)._replace(series=3.0)
    need = StopRequirement(mass=4.0, speed=speed, horizontal=not gravity)
    made = stopped(point, KAPTON, need, max_series=3)
    slip = float(made["stop_slip"])
    whole, rest = int(slip // 0.06), slip % 0.06
    taken = whole * float(slip_work(0.06, 94.5e3, KAPTON))
    taken += float(slip_work(rest, 94.5e3, KAPTON))
    assert whole == 2
    assert taken == pytest.approx(0.5 * 4 * speed**2 + 4 * gravity * slip, rel=1e-6)
    # one more joule than all three can take
    lost = stopped(point, KAPTON, replace(need, mass=6.0), max_series=3)
    assert math.isnan(lost["stop_slip"]) and math.isnan(lost["stop_peak"])


@pytest.mark.parametrize(("tied", "spacers"), [(True, False), (False, False), (False, True)])
def test_what_is_claimed_to_rise_rises(tied, spacers):
    """Proofs that nothing is feasible rest on these signs, over random brakes and both ways."""
    brakes, rng = random_brakes(3, 60, spacers=spacers), np.random.default_rng(5)
    point = make_point(brakes, brakes.site.atmosphere * rng.uniform(0.01, 0.9, 60))
    point = jax.tree.map(lambda v: jnp.asarray(v, float) + jnp.zeros(60), point)
    point = point._replace(offset=0.02 * point.overlap, wall=point.wall * rng.uniform(0.2, 5, 60))
    # each as its own base: the mount is left out, its pole belongs to one base
    base = change(brakes, stiffness_measured=None)
    point = point._replace(stock=point.stock._replace(strength=jnp.full(60, 5e7)))
    if tied:
        point = point._replace(usable_travel=None)
    start = batch(point, base)
    checked = 0
    for variable in AXES:
        value = getattr(point, variable)
        if value is None:
            continue
        whole = variable in ("count", "series", "parallel")
        for step in (1.0, 3.0) if whole else (1.01, 1.4):
            other = value + step if whole else value * step
            moved = batch(point._replace(**{variable: other}), base)
            for merit in start:
                sign = merit_direction(merit, variable, tied)
                if sign is None:
                    continue
                change_ = np.asarray(moved[merit] - start[merit])
                change_ = change_[np.isfinite(change_)]
                size = 1e-9 * np.nanmax(np.abs(start[merit]))
                if sign == 0:
                    assert (np.abs(change_) <= size).all(), (merit, variable)
                else:
                    assert (sign * change_ >= -size).all(), (merit, variable)
                checked += 1
    assert checked > 150


def test_every_merit_has_a_unit():
    made = batch(make_point(KAPTON), KAPTON, StickSlipPull(speed=0.01, mass=1.0, damping_ratio=0.1))
    assert set(made) <= set(MERITS)


def test_a_fan_holds_more_and_leaves_less_margin_and_one_too_steep_is_no_design():
    """The margin falls by the force and by what the middle sheets bear above the mean."""
    thick = KAPTON.with_(count=41, spacers=False, stiffness_measured=None, strength="69 MPa")
    even = thick.with_(spacers=True)
    fans, flat = (batch(make_point(b), b) for b in (thick, even))
    held = 1 / thick.amplification_held
    alpha = 2 * 0.875 * held * 0.24 * 0.254e-3 * (41 / 4) ** 2 / 0.011
    nodes = (np.arange(2000) + 0.5) / 2000
    factor = float(np.exp(alpha * (1 - nodes**2)).mean())
    assert float(fans["holding_force"] / flat["holding_force"]) > factor
    ratio = float(fans["stress_margin"] / flat["stress_margin"])
    assert ratio == pytest.approx(1 / np.exp(alpha), rel=5e-3)
    short = make_point(thick)._replace(free_left=2e-3)
    assert math.isnan(float(batch(short, thick)["mass"]))
    assert math.isfinite(float(batch(short, even)["mass"]))
