"""Sheets that fan out of caps without spacers: the factor, and every law that it is in."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from layerjam import laws
from layerjam.brake.device.brake import fan_exponent, fan_factor
from layerjam.brake.device.load import load
from layerjam.brake.mechanics import fan as fans
from layerjam.brake.mechanics.fan import STEEPEST, fan_mean, fan_slope, make_fan, tension_ratio
from layerjam.brake.mechanics.stop.algebra import NEVER_SLID, STOPPED
from layerjam.brake.simulate.batch import batch
from layerjam.core.errors import QuantityError
from strategies import KAPTON, change, one, random_brakes

FULL = 94.5e3
FANS = random_brakes(11, 5, spacers=True)
THICK = KAPTON.with_(
    count=41, spacers=False, amplification_held=None, stiffness_measured="400 kN/m"
)
"""The paper's brake with 41 sheets, its scale factor taken for friction alone."""


def single_sheets(count, thickness, left, right, friction):
    """Tension of each sheet over mu P A, solved sheet by sheet: sheet, angle, both its faces."""
    is_left = np.arange(count) % 2 == 0
    angle = np.zeros(count)
    for side, free in ((is_left, left), (~is_left, right)):
        place = np.arange(side.sum())
        angle[side] = thickness * (place - place.mean()) / free
    # N_j = 1 + what the tension of the sheets above presses down, as those below press up
    system = np.eye(count - 1)
    for j in range(count - 1):
        for i in range(count):
            for face in (i - 1, i):
                if 0 <= face < count - 1:
                    system[j, face] -= (0.5 if i > j else -0.5) * angle[i] * friction
    pressed = np.linalg.solve(system, np.ones(count - 1))
    return np.append(pressed, 0) + np.insert(pressed, 0, 0)


def friction_of(brake):
    return brake.scale_factor / (brake.amplification_held or 1.0) * brake.film.kinetic


NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def plain_force(slip, vacuum, brake, strips=2):
    """Force of the sliding brake in plain Python; the factor from the tension along a fan."""
    s, e, film = brake.sheets, brake.enclosure, brake.film
    mu = friction_of(brake)
    if brake.pressure_exponent is not None:
        mu *= (vacuum / brake.test_pressure) ** brake.pressure_exponent
    alpha = mu * s.thickness * (s.count / 4) ** 2
    alpha *= 1 / (s.free_left + slip) + 1 / (s.free_right + slip)
    factor = 1.0
    if not brake.mount.spacers:
        depth = (NODES + 1) / 2
        factor = float((WEIGHTS / 2 * np.exp(alpha * (1 - depth**2))).sum())
    sheets = mu * (s.count - 1) * s.width * vacuum * max(s.overlap - slip, 0) * factor
    q, ea = film.friction_on_silicone * s.width * vacuum, e.modulus * s.width * e.wall
    reach = (s.free_left + s.overlap + s.free_right) / 2
    if slip < q * reach**2 / ea:
        return sheets + strips * np.sqrt(ea * q * slip)
    return sheets + strips * (ea * slip / reach + q * reach) / 2


def test_the_factor_is_that_of_single_sheets_and_of_the_tension_along_the_fan():
    """In two ways that know nothing of the closed form, and it converges as 1/n."""
    errors = []
    for count, thickness in ((41, 0.254e-3), (82, 0.0635e-3), (164, 0.015875e-3)):
        brake = change(THICK, sheets__count=count, sheets__thickness=thickness)
        tension = single_sheets(count, thickness, 0.011, 0.011, friction_of(brake))
        mean = tension.sum() / (2 * (count - 1))
        errors.append(float(laws.amplification(0.0, brake)) / mean - 1)
        assert float(tension_ratio(brake)) == pytest.approx(
            tension.max() / tension.mean(), rel=3 / count
        )
    assert errors[0] == pytest.approx(0.035, abs=0.002)
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.1)
    # dT/di = -2 mu T (1/L1 + 1/L3) i t from the middle to the outermost sheet of a half, n/4
    m, mu = 41 / 4, friction_of(THICK)
    run = solve_ivp(
        lambda i, y: [-2 * mu * y[0] * 2 / 0.011 * i * 0.254e-3, y[0]],
        (0, m),
        [1.0, 0.0],
        rtol=1e-11,
        atol=1e-13,
    )
    outer, total = run.y[:, -1]
    assert float(laws.amplification(0.0, THICK)) == pytest.approx(total / m / outer, rel=1e-9)
    assert float(tension_ratio(THICK)) == pytest.approx(m / total, rel=1e-9)


def test_it_is_105_for_the_papers_brake_and_206_for_41_sheets():
    paper = KAPTON.with_(spacers=False, amplification_held=None)
    assert float(laws.amplification(0.0, paper)) == pytest.approx(1.0503, abs=1e-4)
    assert float(laws.amplification(0.0, THICK)) == pytest.approx(2.0590, abs=1e-4)
    for brake in (paper, THICK):
        assert fan_factor(fan_exponent(brake)) == pytest.approx(
            float(laws.amplification(0.0, brake)), rel=1e-12
        )
    assert np.isnan(laws.amplification(0.0, KAPTON))


def test_a_scale_factor_holds_the_factor_of_the_brake_it_was_fitted_on():
    """Only the ratio counts: the paper's brake without spacers holds at rest what it held."""
    for name in ("choi2018-kapton", "choi2018-ptfe"):
        known = load(name).brake
        fans = known.with_(spacers=False)
        at_rest = float(laws.sheet_friction(0.0, FULL, known))
        assert float(laws.sheet_friction(0.0, FULL, fans)) == pytest.approx(at_rest, rel=5e-5)
        held = float(laws.amplification(0.0, fans))
        assert held == pytest.approx(known.amplification_held, abs=5e-5)
        flat = float(laws.sheet_friction(0.0, FULL, known.with_(spacers=True)))
        assert flat == pytest.approx(at_rest / held, rel=5e-5)
        more = known.with_(spacers=False, count=41, stiffness_measured="1 MN/m")
        ratio = float(laws.amplification(0.0, more)) / known.amplification_held
        assert float(laws.sheet_friction(0.0, FULL, more)) == pytest.approx(
            at_rest * 4 * ratio, rel=1e-12
        )


def test_with_spacers_or_a_long_free_length_nothing_is_amplified_and_slip_lets_it_fade():
    flat = KAPTON.with_(spacers=True, amplification_held=None)
    slips = np.array([0.0, 1e-4, 0.02, 0.06])
    np.testing.assert_allclose(
        laws.brake_force(slips, FULL, flat), laws.brake_force(slips, FULL, KAPTON), rtol=1e-13
    )
    for got, due in zip(laws.peak(FULL, 0.06, flat), laws.peak(FULL, 0.06, KAPTON), strict=True):
        assert float(got) == pytest.approx(float(due), rel=1e-5)
    case = (1.0, 2.5, FULL, 14889.7, 9.80665)
    for got, due in zip(laws.stop(*case, flat), laws.stop(*case, KAPTON), strict=True):
        assert float(got) == pytest.approx(float(due), rel=1e-9)
    free = change(THICK, sheets__free_left=1e4, sheets__free_right=1e4)
    assert float(laws.amplification(0.0, free)) == pytest.approx(1, abs=1e-6)
    factor = np.asarray(laws.amplification(slips, THICK))
    assert (np.diff(factor) < 0).all() and factor[-1] < 1.2


def test_forces_work_peaks_and_pulls_are_those_of_plain_python():
    slips = FANS.sheets.overlap * np.linspace(0.01, 0.9, 5)
    vacuum = FANS.site.atmosphere * np.linspace(0.9, 0.2, 5)
    force, work = laws.brake_force(slips, vacuum, FANS), laws.slip_work(slips, vacuum, FANS)
    travel = FANS.sheets.usable_travel
    peaks = laws.peak(vacuum, travel, FANS)
    reach = slips + np.asarray(force) / FANS.stiffness_measured
    pulled = laws.slip_at_elongation(reach, vacuum, FANS)
    limits, least = laws.force_limits(slips, FANS), laws.least_stiffness(vacuum, FANS)
    back = laws.vacuum_for_force(force, slips, FANS)
    closing = laws.self_closing_vacuum(slips, FANS)
    for i in range(5):
        brake, x, p = one(FANS, i), float(slips[i]), float(vacuum[i])
        assert float(force[i]) == pytest.approx(plain_force(x, p, brake), rel=1e-12)
        in_parts = quad(
            lambda s, p=p, b=brake: 2 * s * plain_force(s * s, p, b), 0, np.sqrt(x), epsabs=0
        )
        assert float(work[i]) == pytest.approx(in_parts[0], rel=1e-7)
        assert float(pulled[i]) == pytest.approx(x, rel=1e-9)
        assert float(back[i]) == pytest.approx(p, rel=1e-9)
        assert float(limits[1][i]) == pytest.approx(
            plain_force(x, brake.site.atmosphere, brake), rel=1e-12
        )
        grid = float(travel[i]) * np.linspace(0, 1, 801) ** 3
        along = [plain_force(s, p, brake) for s in grid]
        top = int(np.argmax(along))
        best = minimize_scalar(
            lambda s, p=p, b=brake: -plain_force(s, p, b),
            bounds=(grid[max(top - 1, 0)], grid[min(top + 1, 800)]),
            method="bounded",
            options={"xatol": 1e-14},
        )
        assert float(peaks.force[i]) == pytest.approx(max(-best.fun, along[top]), rel=1e-9)
        assert bool(peaks.inside[i]) == (top < 800)
        near = 1e-6 * brake.sheets.free_left
        falls = [plain_force(s, p, brake, strips=0) for s in (0.0, near)]
        assert float(least[i]) == pytest.approx((falls[0] - falls[1]) / near, rel=1e-4)
        if np.isfinite(closing[i]):
            loose = change(brake, scale_factor=1e-3)
            strip = float(laws.enclosure_force(x, float(closing[i]), loose))
            assert plain_force(x, float(closing[i]), brake) == pytest.approx(2 * strip, rel=1e-9)


@pytest.mark.slow
def test_a_history_of_the_crosshead_meets_the_pull_and_keeps_its_energy():
    path = np.concatenate([np.linspace(0, 0.03, 60), np.linspace(0.03, 0.024, 40)])
    path = np.concatenate([path, np.linspace(0.024, 0.04, 60)])
    cycle = laws.brake_cycle(path, FULL, THICK)
    np.testing.assert_allclose(
        cycle.force[:60], laws.force_at_elongation(path[:60], FULL, THICK), rtol=1e-10, atol=1e-9
    )
    assert float(cycle.force[-1]) == pytest.approx(
        float(laws.force_at_elongation(0.04, FULL, THICK)), rel=1e-9
    )
    balance = np.asarray(cycle.work) - cycle.heat - cycle.stored
    assert np.abs(balance).max() < 1e-11
    # the work of the crosshead, summed from its force alone
    summed = np.trapezoid(cycle.force, path)
    assert float(cycle.work[-1]) == pytest.approx(summed, rel=2e-3)
    soft = THICK.with_(stiffness_measured=0.9 * float(laws.least_stiffness(FULL, THICK)))
    assert bool(laws.brake_cycle(path, FULL, soft).snapped[-1])


def plain_stop(mass, speed, vacuum, spring, gravity, brake):
    """Slip and time of a stop, marched: the mass on its spring, then with the sliding brake."""
    onset = plain_force(0.0, vacuum, brake)
    omega = np.sqrt(spring / mass)
    sag = mass * gravity / spring

    def stretch(t):
        return sag * (1 - np.cos(omega * t)) + speed / omega * np.sin(omega * t)

    times = np.linspace(0, np.pi / omega, 2001)
    first = int(np.argmax(spring * stretch(times) > onset))
    start = brentq(lambda t: spring * stretch(t) - onset, times[first - 1], times[first])
    pace = sag * omega * np.sin(omega * start) + speed * np.cos(omega * start)

    def steep(w):  # dY/dw in w = sqrt(slip), smooth at the start
        at = [plain_force((w + h) ** 2, vacuum, brake) for h in (-1e-6, 1e-6)]
        return (at[1] - at[0]) / 2e-6 if w > 1e-6 else at[1] / 1e-6 - at[0] / 1e-6

    def rates(w, state):
        v, _ = state
        way = 2 * w + steep(w) / spring  # of the mass, over w
        return [(gravity - plain_force(w * w, vacuum, brake) / mass) * way / v, way / v]

    def stands(w, state):
        return state[0] - 1e-3 * pace

    stands.terminal = True
    run = solve_ivp(rates, (1e-5, 1.0), [pace, start], events=stands, rtol=1e-9, atol=1e-12)
    w, (v, time) = run.t[-1], run.y[:, -1]
    # the last thousandth of the speed at a constant force
    brakes = plain_force(w * w, vacuum, brake) / mass - gravity
    way = v * v / (2 * brakes)
    return w * w + way / (1 + steep(w) / (2 * w) / spring), time + v / brakes


@pytest.mark.parametrize(
    "brake",
    [THICK, pytest.param(KAPTON.with_(spacers=False), marks=pytest.mark.slow)],
    ids=["41", "11"],
)
def test_a_stop_is_the_marched_one_and_keeps_its_energy(brake):
    mass, speed, spring, gravity = 6.0, 2.9, 300e3, 9.80665
    if brake.sheets.count == 11:
        mass, speed, spring = 1.0, 2.5, 14890.0
    case = (mass, speed, FULL, spring, gravity, brake)
    found = laws.stop(*case)
    slip, time = plain_stop(*case)
    assert int(found.outcome) == STOPPED
    assert float(found.slip) == pytest.approx(slip, rel=1e-5)
    assert float(laws.time_at_slip(float(found.slip), *case)) == pytest.approx(time, rel=1e-5)
    resist = float(laws.brake_force(found.slip, FULL, brake))
    fallen = float(found.slip) + resist / spring
    brought = mass * speed**2 / 2 + mass * gravity * fallen
    assert float(found.heat + found.stored) == pytest.approx(brought, rel=1e-9)
    assert float(laws.speed_at_slip(0.5 * found.slip, *case)) > 0
    assert float(found.peak_force) == pytest.approx(
        float(laws.peak(FULL, found.slip, brake).force), rel=1e-12
    )


@pytest.mark.slow
def test_tuned_vacuum_stop_and_batch_say_the_same():
    mass, gravity, rope = 6.0, 9.80665, 1.2e6
    spring = 1 / (1 / 400e3 + 1 / rope)
    speeds = np.array([1.8, 2.2, 2.6])
    tuned = laws.tuned_vacuum(mass, speeds, 0.03, spring, gravity, THICK)
    found = laws.stop(mass, speeds, tuned, spring, gravity, THICK)
    np.testing.assert_allclose(found.slip, 0.03, rtol=1e-9)
    many = batch(
        laws.stop,
        {"mass": mass, "speed": ("case", speeds), "vacuum": ("case", np.asarray(tuned)),
         "spring": spring, "gravity": gravity},
        brake=THICK,
    )  # fmt: skip
    np.testing.assert_allclose(many.slip, found.slip, rtol=1e-12)
    # and a law may be swept over spacers
    flat = batch(
        laws.brake_force,
        {"slip": 0.01, "vacuum": FULL, "brake.mount.spacers": np.array([1.0, 0.0])},
        brake=THICK,
    )
    here = [float(laws.brake_force(0.01, FULL, THICK.with_(spacers=s))) for s in (True, False)]
    np.testing.assert_allclose(flat.brake_force, here, rtol=1e-13)


@pytest.mark.slow
def test_a_march_in_time_is_the_exact_stop():
    mass, gravity, rope = 6.0, 9.80665, 1.2e6
    spring = 1 / (1 / 400e3 + 1 / rope)
    speeds, vacuum = np.array([1.8, 2.2, 2.6]), 8e4
    found = laws.stop(mass, speeds, vacuum, spring, gravity, THICK)
    step = 0.02 * np.sqrt(mass / spring)
    case = (None, rope, None, gravity, step, 4000, THICK)
    march = laws.stop_in_time(mass, speeds, vacuum, *case)
    np.testing.assert_allclose(march.slip, found.slip, rtol=1e-6)
    np.testing.assert_allclose(march.peak, found.peak_force, rtol=1e-6)
    np.testing.assert_allclose(march.heat, found.heat, rtol=1e-6)


@pytest.mark.campaign
def test_a_history_that_stands_is_a_constant_vacuum():
    mass, gravity, rope = 6.0, 9.80665, 1.2e6
    spring, vacuum = 1 / (1 / 400e3 + 1 / rope), 8e4
    found = laws.stop(mass, 2.2, vacuum, spring, gravity, THICK)
    step = 0.02 * np.sqrt(mass / spring)
    case = (None, rope, None, gravity, step, 4000, THICK)
    history = np.full(2, vacuum)
    in_time = laws.stop_in_time(mass, 2.2, history, np.array([0.0, 1.0]), *case[1:])
    assert float(in_time.slip) == pytest.approx(float(found.slip), rel=1e-4)


def test_a_pull_too_weak_to_slide_and_a_spring_too_soft_are_told():
    assert int(laws.stop(1.0, 0.1, FULL, 300e3, 9.8, THICK).outcome) == NEVER_SLID
    least = float(laws.least_stiffness(FULL, THICK))
    soft = laws.stop(40.0, 6.0, FULL, 0.5 * least, 9.8, THICK)
    assert int(soft.outcome) == 3 and 0 < float(soft.slip) < 0.02
    x = float(soft.slip)
    slope = (plain_force(x + 1e-10, FULL, THICK) - plain_force(x - 1e-10, FULL, THICK)) / 2e-10
    assert slope == pytest.approx(-0.5 * least, rel=1e-4)


@pytest.mark.slow
def test_gradients_are_those_of_differences():
    def of(law, *case):
        def value(x, thickness, free):
            brake = change(THICK, sheets__thickness=thickness, sheets__free_left=free)
            return law(x, *case, brake)

        return value

    laws_of = {
        "force": (of(laws.brake_force, FULL), 0.012),
        "pull": (of(laws.slip_at_elongation, FULL), 0.02),
        "work": (of(laws.slip_work, FULL), 0.03),
        "peak": (of(lambda p, b: laws.peak(p, 0.06, b).force), 7e4),
        "inverse": (of(laws.vacuum_for_force, 0.02), 500.0),
        "stop": (of(lambda m, *c: laws.stop(m, *c).slip, 4.0, FULL, 3e5, 9.8), 6.0),
        "stress": (of(laws.clamp_stress), 500.0),
    }
    for name, (value, x) in laws_of.items():
        at = (x, THICK.sheets.thickness, THICK.sheets.free_left)
        with jax.enable_x64(True):
            slopes = jax.grad(value, argnums=(0, 1, 2))(*at)
        for k, slope in enumerate(slopes):
            ends = [
                value(*(a * (1 + d * (i == k)) for i, a in enumerate(at))) for d in (-1e-5, 1e-5)
            ]
            due = (float(ends[1]) - float(ends[0])) / (2e-5 * at[k])
            assert float(slope) == pytest.approx(due, rel=2e-4, abs=1e-9), (name, k)


def test_with_a_pressure_exponent_the_fan_follows_the_friction():
    brake = replace(THICK, pressure_exponent=-0.3, test_pressure=2e4, lowest_pressure=1.5e4)
    force = laws.brake_force(0.01, np.array([2e4, 8e4]), brake)
    for got, p in zip(force, (2e4, 8e4), strict=True):
        assert float(got) == pytest.approx(plain_force(0.01, p, brake), rel=1e-12)
    assert float(laws.vacuum_for_force(float(force[1]), 0.01, brake)) == pytest.approx(
        8e4, rel=1e-9
    )


def test_the_scale_factor_of_a_peak_comes_back():
    top = laws.peak(FULL, THICK.sheets.overlap, THICK).force
    blind = replace(THICK, scale_factor=1.0)
    assert float(laws.scale_factor_of_peak(top, FULL, blind)) == pytest.approx(0.875, rel=1e-9)


def test_static_friction_is_amplified_more():
    ratio = THICK.film.static / THICK.film.kinetic
    still = change(THICK, film__kinetic=THICK.film.static)
    assert float(laws.holding_force(FULL, THICK)) == pytest.approx(
        float(laws.sheet_friction(0.0, FULL, still)), rel=1e-12
    )
    kinetic = float(laws.sheet_friction(0.0, FULL, THICK))
    assert float(laws.holding_force(FULL, THICK)) > 1.2 * ratio * kinetic


def test_the_middle_sheet_bears_most_and_a_fan_that_is_too_steep_is_refused():
    even = THICK.with_(spacers=True)
    share = float(laws.sheet_stress(1.0, THICK)) / float(laws.sheet_stress(1.0, even))
    assert share == pytest.approx(float(tension_ratio(THICK)), rel=1e-12) and share > 1.3
    clamp = float(laws.clamp_stress(1.0, THICK)) / float(laws.clamp_stress(1.0, even))
    assert clamp == pytest.approx(share, rel=1e-12)
    steep = 41 * 0.254e-3 / (4 * 2e-3)
    assert float(fan_slope(change(THICK, sheets__free_left=2e-3))) == pytest.approx(steep)
    assert steep > STEEPEST
    with pytest.raises(QuantityError, match=r"spacers: .* at 52 degrees; at most 45"):
        THICK.with_(free_left="2 mm")
    assert np.isnan(laws.amplification(0.0, change(THICK, sheets__free_left=2e-3)))


@pytest.mark.parametrize("count", [2, 9, 30])
@pytest.mark.parametrize("slip", [0.0, 0.004])
def test_the_factors_of_the_interfaces_are_symmetric_and_have_the_mean_of_the_law(
    count: int, slip: float
) -> None:
    brake = change(KAPTON, sheets__count=count, mount__spacers=0.0, amplification_held=1.2)
    fan = make_fan(brake)
    assert fan is not None
    factors, falls = fan.interface_factors(np.full(count - 1, slip))
    assert factors == pytest.approx(factors[::-1], rel=1e-12)
    assert factors.mean() == pytest.approx(fan_mean(fans.fan_exponent(slip, fan)) / 1.2, rel=1e-9)
    assert np.all(np.diff(factors[: count // 2]) > 0)  # the middle has the highest pressure
    ahead, behind = (fan.interface_factors(np.full(count - 1, slip + h))[0] for h in (1e-6, -1e-6))
    assert falls == pytest.approx((behind - ahead) / 2e-6, rel=1e-6)
