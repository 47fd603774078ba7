"""The law agrees with itself: compiled in different ways it gives the same force.

Histories with a changing vacuum reach equalities exactly (a loop that closes, a strip that just
slides, no friction at all). Where rounding decided what comes then, one history in a hundred
differed by up to 1.9 N between two ways of compiling the same function.
"""

from __future__ import annotations

import jax
import numpy as np
import pytest

from counts import cases
from layerjam.brake.mechanics.hysteresis import brake_cycle
from strategies import KAPTON, PTFE

LEVELS = np.array([0.0, 0.0, 2e3, 5e3, 20e3, 50e3, 94.5e3])
"""Vacuums that come back, as a person or a procedure sets them."""


def histories(seed: int, count: int, steps: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Elongations [m] and vacuums [Pa], shape (count, steps): rests, returns, vented and pumped."""
    rng = np.random.default_rng(seed)
    shape = (count, steps)
    vacuum = np.where(
        rng.random(shape) < 0.7, rng.choice(LEVELS, shape), rng.uniform(0, 95e3, shape)
    )
    elongation, kept = np.zeros(shape), rng.random(shape) > 0.35
    now = np.zeros(count)
    for j in range(steps):
        if j:
            vacuum[:, j] = np.where(kept[:, j], vacuum[:, j - 1], vacuum[:, j])
        moved = np.clip(
            now + rng.normal(size=count) * rng.choice([1e-4, 1e-3, 8e-3], count), 0, 0.05
        )
        returned = elongation[np.arange(count), rng.integers(0, j + 1, count)]
        what = rng.random(count)
        now = np.where(what < 0.25, now, np.where(what < 0.85, moved, returned))
        elongation[:, j] = now
    return elongation, vacuum


together = jax.jit(jax.vmap(lambda u, p, brake: brake_cycle(u, p, brake).force, (0, 0, None)))
apart = jax.jit(lambda u, p, brake: jax.lax.map(lambda h: brake_cycle(*h, brake).force, (u, p)))


def check(seed: int, count: int, steps: int = 40) -> None:
    case = (*histories(seed, count, steps), (KAPTON, PTFE)[seed % 2])
    assert np.asarray(together(*case)) == pytest.approx(np.asarray(apart(*case)), abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(cases(2, 1)))
def test_compiled_for_one_or_for_many_the_force_is_the_same(seed):
    check(seed, 2000)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(2, 2 + cases(5, 1)))
def test_thousands_of_histories(seed):
    check(seed, cases(20_000, 4000), steps=20)
