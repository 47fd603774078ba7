"""Stops with friction that grows with speed: against scipy, each other, and their limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import layerjam as lj
from counts import FULL
from layerjam.bench.control.plan import Arrival, needed_vacuum
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.fluid.network import Drive
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, STOPPED, stop
from layerjam.brake.mechanics.stop.rosenbrock import rosenbrock
from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from layerjam.brake.simulate.coupled import coupled_drop
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.drop_in_time import drop_in_time
from layerjam.brake.simulate.record import Outcome
from layerjam.brake.simulate.tuned import Case, tuning_vacuum
from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.errors import LayerjamError, QuantityError
from strategies import random_brakes

PTFE = load("choi2018-ptfe")
LAW = {"speed_law_power": 0.3, "speed_law_test_speed": 0.013, "speed_law_rest_speed": 1e-3}
FAST = PTFE.with_(**LAW)
CASE = {"mass": 1.0, "speed": 2.5, "rope_stiffness": 16.8e3}
G, SPRING = 9.80665, 1 / (1 / 55e3 + 1 / 16.8e3)


def integrated(
    brake: Brake, mass: float, speed: float, vacuum: Any, spring: float, gravity: float
) -> tuple[float, ...]:
    """Slip, peak force, end speed, time, last force by scipy's Radau, from the paper's formulas."""
    law, sheets, film = brake.speed_law, brake.sheets, brake.film
    assert law is not None
    at = vacuum if callable(vacuum) else lambda _: vacuum
    width, length = sheets.width, (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    ea = brake.enclosure.modulus * width * brake.enclosure.wall

    def enclosure(x: float, p: float) -> float:
        q = film.friction_on_silicone * width * p
        if x < q * length**2 / ea:
            return float(2 * np.sqrt(ea * q * max(x, 0.0)))
        return float(ea * x / length + q * length)

    def pace(t: float, z: float, x: float) -> float:
        c = brake.scale_factor * film.kinetic * (sheets.count - 1) * width * at(t)
        share = (spring * (z - x) - enclosure(x, at(t))) / (c * (sheets.overlap - x))
        with np.errstate(over="ignore"):  # in a trial step
            more = np.maximum(share, 0.0) ** (1 / law.power)
        sliding = (law.rest_speed + law.test_speed) * more
        return float(max(sliding - law.rest_speed, 0.0))

    def change(t: float, y: Any) -> list[float]:
        z, v, x = y
        return [v, gravity - spring * (z - x) / mass, pace(t, z, x)]

    def stands(_: float, y: Any) -> float:
        return float(y[1])

    def used(_: float, y: Any) -> float:
        return float(y[2] - sheets.usable_travel)

    stands.terminal, stands.direction, used.terminal = True, -1.0, True  # type: ignore[attr-defined]
    made: Any = solve_ivp(
        change,
        (0, 5),
        [0, speed, 0],
        "Radau",
        rtol=1e-9,
        atol=1e-12,
        events=[stands, used],
        dense_output=True,
    )
    time = np.linspace(0, made.t[-1], 20_001)
    z, v, x = made.sol(time)
    force = spring * (z - x)
    ends = float(time[-1]), float(force[-1])
    return float(x[-1]), float(force.max()), max(float(v[-1]), 0.0), *ends


@pytest.mark.parametrize(
    ("name", "exponent", "rest", "case"),
    [
        ("choi2018-ptfe", 0.3, 1e-4, (1.0, 2.5, 94.5e3, G)),
        ("choi2018-ptfe", 0.3, 1e-2, (3.0, 3.7, 30e3, G)),
        ("choi2018-kapton", 1.0, 0.1, (3.0, 3.7, 30e3, 0.0)),
        ("choi2018-kapton", 0.05, 1e-3, (1.0, 2.5, 50e3, 0.0)),
        ("choi2018-kapton", 0.002, 1e-2, (1.0, 2.5, 94.5e3, G)),
    ],
)
def test_a_stop_is_what_another_integrator_finds(
    name: str, exponent: float, rest: float, case: tuple[float, float, float, float]
) -> None:
    brake = load(name).with_(
        speed_law_power=exponent, speed_law_test_speed=0.013, speed_law_rest_speed=rest
    )
    mass, speed, vacuum, gravity = case
    made = stop(mass, speed, vacuum, 14.9e3, gravity, brake)
    slip, peak, end, _, force = integrated(brake.brake, mass, speed, vacuum, 14.9e3, gravity)
    assert float(made.slip) == pytest.approx(slip, rel=1e-6)
    assert float(made.peak_force) == pytest.approx(peak, rel=1e-6)
    assert float(made.end_speed) == pytest.approx(end, rel=1e-6, abs=1e-9)
    assert int(made.outcome) == (STOPPED if end < 1e-6 else BOTTOMED_OUT)
    in_enclosure = float(enclosure_law(vacuum, brake.brake).stored_energy(slip))
    assert float(made.stored) == pytest.approx(force**2 / 2 / 14.9e3 + in_enclosure, rel=1e-5)
    gained = mass * (speed**2 - end**2) / 2 + mass * gravity * (slip + force / 14.9e3)
    assert float(made.heat + made.stored) == pytest.approx(gained, rel=1e-6)


@pytest.mark.slow
def test_energy_is_kept_over_random_brakes_and_friction_at_rest_bounds_the_slip() -> None:
    rng, n = np.random.default_rng(5), 64
    plain = random_brakes(11, n, exponent=True)
    law = SpeedLaw(
        power=rng.uniform(0.01, 1, n),
        test_speed=rng.uniform(1e-3, 0.1, n),
        rest_speed=10 ** rng.uniform(-4, -1, n),
    )
    brakes = replace(plain, speed_law=law)
    vacuum = plain.site.atmosphere * rng.uniform(0.05, 1, n)
    spring = plain.stiffness_measured * rng.uniform(0.05, 1, n)
    mass, speed = 10 ** rng.uniform(-1, 1, n), rng.uniform(0.2, 4, n)
    made = stop(mass, speed, vacuum, spring, G, brakes)
    outcome = np.asarray(made.outcome)
    assert {STOPPED, BOTTOMED_OUT, NEVER_SLID} == set(outcome.tolist())
    slid = outcome != NEVER_SLID
    # on a rigid spring the least friction there is gives the longest slip
    least = (law.rest_speed / (law.rest_speed + law.test_speed)) ** law.power
    resting = replace(plain, scale_factor=plain.scale_factor * least)
    weakest = stop(mass, speed, vacuum, 1e9, G, resting)
    rigid = stop(mass, speed, vacuum, 1e9, G, brakes)
    assert (np.asarray(rigid.slip) <= np.asarray(weakest.slip) * (1 + 1e-6)).all()
    stands = slid & (outcome == STOPPED)
    # at a standstill all of it is heat, or held in spring and enclosure
    before = mass * speed**2 / 2
    after = np.asarray(made.heat + made.stored)
    force = _force_of(made, vacuum, spring, brakes)
    gained = mass * G * (np.asarray(made.slip) + force / spring)
    left = mass * np.asarray(made.end_speed) ** 2 / 2
    np.testing.assert_allclose((after + left)[stands], (before + gained)[stands], rtol=2e-6)


def _force_of(made: Any, vacuum: Any, spring: Any, brakes: Brake) -> Any:
    """Force at the end [N], from what the spring holds beside the enclosure."""
    enclosure = np.asarray(enclosure_law(vacuum, brakes).stored_energy(made.slip))
    return np.sqrt(2 * spring * np.maximum(np.asarray(made.stored) - enclosure, 0.0))


@pytest.mark.slow
def test_without_growth_it_is_the_present_answer_to_the_last_bit() -> None:
    flat = PTFE.with_(**{**LAW, "speed_law_power": 0.0})
    history = History(np.array([0.0, 0.01, 1.0]), np.array([80e3, 94e3, 94e3]))
    for vacuum, run in ((94.5e3, drop), (history, drop_in_time)):
        ours, theirs = (run(file, vacuum=vacuum, **CASE) for file in (flat, PTFE))  # type: ignore[operator]
        assert ours[0] == theirs[0]
        for column in ("time", "force", "slip", "dissipated_energy"):
            np.testing.assert_array_equal(getattr(ours[1], column), getattr(theirs[1], column))


@pytest.mark.slow
def test_the_solver_in_time_agrees_and_is_of_second_order() -> None:
    exact, record = drop(FAST, vacuum=94.5e3, **CASE)
    timed, _ = drop_in_time(FAST, vacuum=94.5e3, **CASE)
    numbers = [exact.slip, exact.peak_force, exact.heat, exact.stored, exact.time]
    ours = [timed.slip, timed.peak_force, timed.heat, timed.stored, timed.time]
    np.testing.assert_allclose(ours, numbers, rtol=2e-6)
    off = [
        abs(drop_in_time(FAST, vacuum=94.5e3, step=h, **CASE)[0].slip - exact.slip)
        for h in (1.6e-4, 8e-5, 4e-5)
    ]
    assert off[0] / off[1] == pytest.approx(4, rel=0.2)
    assert off[1] / off[2] == pytest.approx(4, rel=0.2)
    # the record is the motion itself: energy holds in every row, and the mass moves as it says
    moving = record.mass * record.speed_of_mass**2 / 2
    given = record.mass * record.speed**2 / 2 + record.mass * G * record.travel
    rows = record.slip == 0
    sprung = record.force**2 / (2 * SPRING)
    np.testing.assert_allclose((moving + sprung)[rows], given[rows], rtol=1e-9)
    np.testing.assert_allclose(
        np.gradient(record.travel, record.time)[150:-20], record.speed_of_mass[150:-20], rtol=2e-2
    )


@pytest.mark.slow
@pytest.mark.parametrize("end", [94.5e3, 40e3] if FULL else [40e3])
def test_a_vacuum_that_changes_is_what_another_integrator_finds(end: float) -> None:
    # an enclosure that hardly pulls, whose memory then does not matter
    brake = replace(
        FAST.brake,
        film=replace(FAST.brake.film, friction_on_silicone=1e-4),
        enclosure=replace(FAST.brake.enclosure, modulus=1e3),
    )
    history = History(np.array([0.0, 0.015, 1.0]), np.array([70e3, end, end]))
    timed, _ = drop_in_time(replace(FAST, brake=brake), vacuum=history, **CASE)

    def vacuum(time: float) -> float:
        return float(np.interp(time, history.time, history.vacuum))

    slip, peak, _, time, _ = integrated(brake, 1.0, 2.5, vacuum, SPRING, G)
    assert timed.slip == pytest.approx(slip, rel=3e-5)
    assert timed.peak_force == pytest.approx(peak, rel=3e-5)
    assert timed.time == pytest.approx(time, rel=3e-5)


@pytest.mark.slow
def test_after_the_standstill_the_sheets_creep_on_and_come_to_rest() -> None:
    timed, record = drop_in_time(FAST, vacuum=94.5e3, duration=0.15, **CASE)
    assert timed.outcome is Outcome.STOPPED
    # still pulled by more than friction at rest, they slide on while the mass is thrown back
    assert timed.slip * 1.001 < timed.slip_at_end < timed.slip * 1.5
    assert (np.diff(record.slip) >= 0).all()
    assert (np.diff(record.dissipated_energy) >= -1e-12).all()


@pytest.mark.slow
def test_tune_plan_drop_and_a_line_agree() -> None:
    found = lj.tune(FAST, mass=1.0, speed=2.5, travel=0.03, rope_stiffness=16.8e3)
    assert found.vacuum is not None
    there = drop(FAST, vacuum=found.vacuum, **CASE)[0]
    assert there.outcome is Outcome.STOPPED
    assert there.slip == pytest.approx(0.03, rel=2e-6)
    case = Arrival(mass=1.0, speed=2.5, warning=1.0, travel=0.03, rope_stiffness=16.8e3, gravity=G)
    assert needed_vacuum(FAST.brake, case) == pytest.approx(found.vacuum, rel=1e-6)
    low, high = found.least_speed, found.greatest_speed
    assert low is not None
    assert high is not None
    one = Case(brake=FAST.brake, mass=1.0, speed=high, travel=0.03, gravity=G, rope=16.8e3)
    assert tuning_vacuum(one) == pytest.approx(101325.0, rel=1e-4)
    assert tuning_vacuum(one.with_changes(speed=low)) is not None
    assert tuning_vacuum(one.with_changes(speed=high * 1.001)) is None
    assert tuning_vacuum(one.with_changes(speed=low * 0.99)) is None


@pytest.mark.campaign
def test_a_line_whose_vacuum_hardly_changes_gives_the_stop_at_constant_vacuum() -> None:
    line = load_line("choi2018").record
    line = replace(line, chamber=replace(line.chamber, volume_per_slip=1e-9))
    shut = Drive(pump=0.0)
    coupled = coupled_drop(FAST, line, start=94.5e3, drive=shut, **CASE)
    assert coupled.timed.slip == pytest.approx(coupled.constant.slip, rel=1e-4)
    assert coupled.timed.peak_force == pytest.approx(coupled.constant.peak_force, rel=1e-4)


@pytest.mark.slow
def test_answers_say_whether_friction_depends_on_speed() -> None:
    keys = {
        "none": [n.key for n in lj.drop(PTFE, vacuum=94.5e3, **CASE).warnings if hasattr(n, "key")],
        "law": [
            n.key
            for n in lj.drop(FAST.with_(speed_law_fastest=0.5), vacuum=94.5e3, **CASE).warnings
            if hasattr(n, "key")
        ],
    }
    assert "speed-law-unmeasured" in keys["none"]
    assert "speed-law" not in keys["none"]
    assert {"speed-law", "speed-law-beyond"} <= set(keys["law"])
    assert "speed-law-unmeasured" not in keys["law"]


def test_a_law_that_contradicts_itself_is_refused() -> None:
    with pytest.raises(
        (QuantityError, LayerjamError), match=r"speed_law\.fastest: 1 mm/s is below"
    ):
        FAST.with_(speed_law_fastest=1e-3)
    with pytest.raises(LayerjamError, match=r"speed_law\.power"):
        FAST.with_(speed_law_power=-0.1)


def test_the_rosenbrock_method_is_of_fourth_order_and_damps_what_is_stiff() -> None:
    def swing(y: Any) -> Any:
        return jnp.stack([y[1] * y[2], -y[0] * y[2], -0.5 * y[0] * y[1], y[0]])

    start = np.array([0.0, 1.0, 1.0, 0.0])[:, None]
    exact: Any = solve_ivp(
        lambda _, y: [y[1] * y[2], -y[0] * y[2], -0.5 * y[0] * y[1], y[0]],
        (0, 1),
        start[:, 0],
        "DOP853",
        rtol=1e-13,
        atol=1e-14,
    )
    step = jax.jit(lambda y, h: rosenbrock(swing, y, h).after)
    off = []
    for steps in (8, 16, 32):
        y: Any = start
        for _ in range(steps):
            y = step(y, np.full(1, 1 / steps))
        off.append(np.abs(np.asarray(y)[:, 0] - exact.y[:, -1]).max())
    assert np.log2(off[0] / off[1]) == pytest.approx(4, abs=0.4)
    assert np.log2(off[1] / off[2]) == pytest.approx(4, abs=0.4)

    def stiff(y: Any) -> Any:
        return jnp.stack([-1e9 * (y[0] - 1), -y[1], -y[2], y[0]])

    after = np.asarray(rosenbrock(stiff, np.zeros((4, 1)), np.full(1, 0.1)).after)
    assert after[0, 0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
def test_a_pull_is_that_of_a_brake_with_the_friction_of_its_speed() -> None:
    faster = replace(
        PTFE.brake,
        scale_factor=PTFE.brake.scale_factor * ((1e-3 + 0.1) / (1e-3 + 0.013)) ** 0.3,
    )
    one = lj.tensile(FAST, vacuum=50e3, speed=0.1, travel=0.02)
    two = lj.tensile(replace(PTFE, brake=faster), vacuum=50e3, speed=0.1, travel=0.02)
    np.testing.assert_allclose(one.record.force, two.record.force, rtol=1e-9)
    # and of the force at that speed, and slower pulls are weaker
    x = float(one.record.slip[-1])
    assert lj.force(FAST, slip=x, vacuum=50e3, sliding_speed=0.1).force == pytest.approx(
        one.force_at_end, rel=1e-6
    )
    steps = "evacuate to 50 kPa; pull at 100 mm/s until 10 mm; pull at 1 mm/s until 12 mm"
    slower = lj.tensile(FAST, procedure=steps)
    assert slower.force_at_end == pytest.approx(
        lj.force(FAST, slip=float(slower.record.slip[-1]), vacuum=50e3, sliding_speed=1e-3).force,
        rel=1e-2,
    )
    record = slower.record
    balance = record.work - record.dissipated_energy - record.stored_energy
    np.testing.assert_allclose(balance, 0.0, atol=1e-12)


@pytest.mark.slow
def test_steady_stick_slip_slides_at_the_force_of_its_speed() -> None:
    made = lj.stick_slip(FAST, vacuum=50e3, speed=0.02, damping=2000.0, travel=0.012, static=0.05)
    assert made.outcome == "STEADY_SLIDING"
    at = float(made.record.slip[-1])
    # the slip is faster than the crosshead, as the force falls
    there = lj.force(FAST, slip=at, vacuum=50e3, sliding_speed=float(made.record.speed_of_mass[-1]))
    assert float(made.record.force[-1]) == pytest.approx(there.force, rel=2e-3)
    assert made.stable_speed is None


@pytest.mark.slow
def test_a_batch_follows_the_law() -> None:
    sweep = {"mass": 1.0, "speed": np.array([1.0, 2.5]), "vacuum": 94.5e3}
    sweep |= {"spring": 14.9e3, "gravity": G}
    made = lj.batch(stop, sweep, brake=FAST)
    one = stop(1.0, 2.5, 94.5e3, 14.9e3, G, FAST)
    assert float(made.slip[1]) == pytest.approx(float(one.slip), rel=1e-9)
    assert float(made.slip[1]) < 0.5 * float(lj.batch(stop, sweep, brake=PTFE).slip[1])


@pytest.mark.slow
def test_the_tuned_vacuum_stops_where_another_integrator_says() -> None:
    speeds, slip = np.array([1.9, 2.5, 3.3, 9.0]), 0.03
    found = np.asarray(tuned_vacuum(1.0, speeds, slip, SPRING, G, FAST))
    for speed, vacuum in zip(speeds[:3].tolist(), found[:3].tolist(), strict=True):
        stops = integrated(FAST.brake, 1.0, speed, vacuum, SPRING, G)[0]
        assert stops == pytest.approx(slip, rel=1e-5)
    # 9 m/s is more than full vacuum stops so soon
    assert np.isnan(found[3])
    assert integrated(FAST.brake, 1.0, 9.0, 101325.0, SPRING, G)[0] > 0.031
    # without growth it is the balance
    flat = FAST.with_(speed_law_power=0.0)
    assert float(tuned_vacuum(1.0, 1.2, slip, SPRING, G, flat)) == pytest.approx(
        float(tuned_vacuum(1.0, 1.2, slip, SPRING, G, PTFE)), rel=1e-12
    )
    with pytest.raises(QuantityError, match="no gradient"):
        jax.grad(lambda v: tuned_vacuum(1.0, v, slip, SPRING, G, FAST.brake))(2.0)


@pytest.mark.campaign
def test_spacers_take_from_the_scale_factor_what_it_holds_of_a_fan() -> None:
    held = FAST.brake.amplification_held
    assert held is not None
    flat = replace(FAST.brake, amplification_held=None, scale_factor=FAST.brake.scale_factor / held)
    spaced = replace(FAST.brake, mount=replace(FAST.brake.mount, spacers=True))
    for vacuum in (94.5e3, 40e3):
        one, other = (stop(1.0, 2.0, vacuum, 15e3, 9.8, b) for b in (flat, spaced))
        assert [float(x) for x in one] == pytest.approx([float(x) for x in other], rel=1e-9)


@pytest.mark.slow
def test_a_stack_slides_with_the_friction_of_the_crosshead() -> None:
    pulled = lj.tensile(FAST, vacuum=50e3, speed=0.5, travel=0.02, model="stack")
    film, sheets, shell = PTFE.brake.film, PTFE.brake.sheets, PTFE.brake.enclosure
    grows = ((1e-3 + 0.5) / (1e-3 + 0.013)) ** 0.3
    x = float(pulled.record.slip[-1])
    per_contact = PTFE.brake.scale_factor * film.kinetic * (sheets.count - 1) * sheets.width * 50e3
    root = shell.modulus * shell.wall * film.friction_on_silicone * 50e3
    strips = 2 * sheets.width * np.sqrt(root * x)
    expected = grows * per_contact * (sheets.overlap - x) + strips
    assert pulled.force_at_end == pytest.approx(expected, rel=1e-3)
    keys = [n.key for n in pulled.warnings if hasattr(n, "key")]
    assert "speed-law" in keys
    # grown beyond the static friction there is no jump: nothing is held more than it slides
    static = lj.tensile(FAST, vacuum=50e3, speed=0.5, travel=0.02, model="stack", static=True)
    assert static.peak_force == pytest.approx(pulled.peak_force, rel=1e-9)


def test_the_vacuum_for_a_force_is_that_of_the_sliding_speed() -> None:
    wanted = lj.force(FAST, slip=0.02, vacuum=40e3, sliding_speed=0.5).force
    found = lj.vacuum(FAST, slip=0.02, force=wanted, sliding_speed=0.5)
    assert found.vacuum == pytest.approx(40e3, rel=1e-9)
    slow = lj.vacuum(FAST, slip=0.02, force=0.6 * wanted)
    fast = lj.vacuum(FAST, slip=0.02, force=0.6 * wanted, sliding_speed=0.5)
    assert slow.vacuum is None or slow.vacuum > 1.5 * fast.vacuum  # type: ignore[operator]
    assert "at-test-speed" in [getattr(n, "key", "") for n in slow.warnings]
