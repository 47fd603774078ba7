"""One step of a mass that slides on a spring, against a general solver and its closed forms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layerjam.brake.mechanics.stick_slip.slide_step import (
    SLACK,
    TAUT,
    Slide,
    State,
    exact_step,
    hermite_range,
    runge_kutta,
)


def slide_case(**changes: float) -> Slide:
    """A mass of 2 kg on 1000 N/m: omega is 22.4 1/s; friction of 30 N that is constant."""
    zero = dict.fromkeys(Slide._fields, 0.0)
    zero |= {"mass": 2.0, "spring": 1000.0, "speed": 0.1, "ramp": 9.0, "end": 9.0, "level": 30.0}
    zero |= {"exponent": 1.0, "overlap": 1.0, "enclosure": None, "paced_brake": None}
    return Slide(**(zero | changes))  # type: ignore[arg-type]


def state_at(slip: float, velocity: float, mode: int) -> State:
    still = dict.fromkeys(State._fields, 0.0)
    return State(**(still | {"slip": slip, "velocity": velocity, "mode": mode, "time": 0.5}))


def solved(state: State, h: float, case: Slide, taut: bool = True) -> np.ndarray:
    """Travel, velocity, work and heat after a step, for friction linear in slip."""

    def rate(t: float, y: np.ndarray) -> list[float]:
        e = case.speed * t - (state.slip + y[0])
        pull = case.spring * e + case.damping * (case.speed - y[1]) if taut else 0.0
        resist = case.level - case.fall * (state.slip + y[0])
        loss = case.damping * (case.speed - y[1]) ** 2 if taut else 0.0
        return [y[1], (pull - resist) / case.mass, pull * case.speed, resist * y[1] + loss]

    start = [0.0, float(state.velocity), 0.0, 0.0]
    run = solve_ivp(rate, (0.5, 0.5 + h), start, rtol=1e-12, atol=1e-14, method="DOP853")
    return np.asarray(run.y[:, -1])


def test_a_step_with_friction_that_falls_with_slip_is_of_the_fifth_order() -> None:
    """Twice the step, 2**6 times its error; the error is estimated to the fifth power of it."""
    case, state = slide_case(fall=400.0, damping=20.0), state_at(0.01, 0.15, TAUT)
    steps, off, estimates = (0.012, 0.006), [], []
    for h in steps:
        with np.errstate(all="ignore"):
            step = runge_kutta(state, np.float64(h), case)
        off.append(np.abs(np.array(step[:2], float) - solved(state, h, case)[:2]).max())
        assert np.array(step[:4], float) == pytest.approx(solved(state, h, case), rel=1e-6)
        estimates.append(float(step.error))
    assert np.log2(off[0] / off[1]) == pytest.approx(6, abs=0.3)
    assert np.log2(estimates[0] / estimates[1]) == pytest.approx(5, abs=0.3)


@pytest.mark.parametrize("step_of", [exact_step, runge_kutta])
def test_a_spring_that_relaxes_into_its_damper_heats_it(step_of: Callable[..., Any]) -> None:
    """Stretched by 20 mm and without force: no work is done, and no energy is lost."""
    case, h = slide_case(damping=90.0), 0.01
    state = state_at(0.03, 1.0, SLACK)
    with np.errstate(all="ignore"):
        step = step_of(state, np.float64(h), case)
    speed = 1.0 - 30.0 / 2.0 * h
    travel = (1.0 + speed) / 2 * h
    before, after = 0.05 - 0.03, 0.05 + 0.1 * h - 0.03 - travel
    spring = 1000.0 / 2 * (before**2 - after**2)
    assert float(step.travel) == pytest.approx(travel, rel=1e-12)
    assert float(step.work) == 0.0
    assert float(step.heat) == pytest.approx(spring + 2.0 / 2 * (1.0 - speed**2), rel=1e-9)


@pytest.mark.parametrize(
    ("middle", "due"),
    # (t - middle)^2 + 1 on a step of 0.5, and its mirror image
    [(0.2, (1.0, 1.09)), (-0.1, (1.01, 1.36)), (0.7, (1.04, 1.49))],
)
def test_the_range_of_a_parabola_includes_its_vertex(
    middle: float, due: tuple[float, float]
) -> None:
    ends = [f for t in (0.0, 0.5) for f in ((t - middle) ** 2 + 1, 2 * (t - middle))]
    with np.errstate(all="ignore"):
        high, low = hermite_range(np.float64(0.5), *map(np.float64, ends))
        top, bottom = hermite_range(np.float64(0.5), *(-np.float64(end) for end in ends))
    assert (float(low), float(high)) == pytest.approx(due, rel=1e-12)
    assert (-float(top), -float(bottom)) == pytest.approx(due, rel=1e-12)


def test_a_slope_that_is_not_finite_leaves_the_range_of_the_ends() -> None:
    with np.errstate(all="ignore"):
        high, low = hermite_range(*map(np.float64, (0.5, 1.0, -np.inf, 2.0, 0.3)))
    assert (float(low), float(high)) == (1.0, 2.0)
