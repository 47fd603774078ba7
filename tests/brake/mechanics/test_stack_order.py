"""The order in which uneven static interfaces break, against a stack solved by brute force."""

from __future__ import annotations

import numpy as np
import pytest

from brake.mechanics.brute_stack import BruteStack
from layerjam.brake.kernel.stack import pull_stack
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import Interfaces, make_stack
from layerjam.core.errors import QuantityError
from strategies import KAPTON, PTFE

FULL = 94.5e3
ORDERS = pytest.mark.parametrize("one_by_one", [False, True], ids=["together", "one by one"])


def uneven(seed: int, one_by_one: bool, mount: float | None) -> tuple[Stack, float]:
    """A stack whose interfaces and sheets scatter, and an elongation past its peak [m]."""
    random = np.random.default_rng(seed)
    brake = (KAPTON, PTFE)[seed % 2]
    each = Interfaces(
        friction=np.exp(random.normal(0, 0.3, 10)), extra_overlap=random.uniform(-5e-3, 5e-3, 10)
    )
    stack = make_stack(
        brake,
        FULL,
        interfaces=each,
        static=True,
        one_by_one=one_by_one,
        enclosure=False,
        mount=mount,
    )
    stack = stack._replace(
        springs=stack.springs * random.uniform(0.7, 1.4, 11), ratio=random.uniform(1.0, 2.5, 10)
    )
    soft = 4 / stack.springs.sum() + (0 if np.isinf(stack.mount) else 1 / stack.mount)
    return stack, 1.6 * float((stack.friction * stack.ratio).sum()) * soft


@ORDERS
@pytest.mark.parametrize("mount", [np.inf, None, 4e5], ids=["rigid", "measured", "stiff"])
def test_a_pull_is_that_of_the_brute_force_stack(mount: float | None, one_by_one: bool) -> None:
    for seed in range(6):
        stack, end = uneven(seed, one_by_one, mount)
        # up past the peak, unloaded by a few percent so that what slid rests, and up again
        path = np.concatenate([np.linspace(0, end, 41)[1:], end * np.linspace(0.99, 1.3, 20)])
        run = pull_stack(path, stack)
        assert not run.slack.any()
        brute = BruteStack(stack)
        assert run.force == pytest.approx(brute.pull(path), abs=1e-9 * run.force.max()), seed
        assert run.slip[-1] * brute.opening == pytest.approx(brute.rest, abs=1e-12), seed


@ORDERS
def test_increments_change_nothing_on_a_rigid_mount_either(one_by_one: bool) -> None:
    """Rounding once said at a jump whether what slid elsewhere had stopped: up to 44 % of F."""
    for seed in range(40):
        stack, end = uneven(seed, one_by_one, np.inf)
        coarse = pull_stack(np.linspace(0, end, 41), stack).force
        fine = pull_stack(np.linspace(0, end, 401), stack).force
        assert coarse == pytest.approx(fine[::10], abs=1e-9 * fine.max()), seed


def test_like_interfaces_break_in_pairs_in_either_order() -> None:
    path = np.linspace(0, 2e-4, 301)
    runs = [
        pull_stack(path, make_stack(KAPTON, FULL, static=True, one_by_one=alone, mount=np.inf))
        for alone in (False, True)
    ]
    for run in runs:
        assert run.slip == pytest.approx(run.slip[:, ::-1], abs=1e-15)
    assert runs[1].force == pytest.approx(runs[0].force, rel=1e-12)


def test_the_order_changes_the_peak() -> None:
    peaks = []
    for one_by_one in (False, True):
        stacks = (uneven(seed, one_by_one, None) for seed in range(20))
        peaks.append([pull_stack(np.linspace(0, end, 400), s).force.max() for s, end in stacks])
    apart = np.array(peaks[1]) / np.array(peaks[0]) - 1
    assert (abs(apart) > 1e-3).sum() >= 5


@ORDERS
def test_no_break_wins_energy(one_by_one: bool) -> None:
    for seed in range(20):
        stack, end = uneven(seed, one_by_one, (np.inf, None)[seed % 2])
        stack = stack._replace(face=make_stack(KAPTON, FULL).face)
        path = np.concatenate([np.linspace(0, end, 60), np.linspace(end, 0.2 * end, 40)[1:]])
        run = pull_stack(path, stack)
        assert (np.diff(run.heat) >= -1e-13 * run.work.max()).all()
        assert run.work - run.heat - run.stored == pytest.approx(0, abs=1e-12 * run.work.max())


def test_one_by_one_belongs_to_static_friction() -> None:
    with pytest.raises(QuantityError, match=r"one_by_one: .* set static too"):
        make_stack(KAPTON, FULL, one_by_one=True)
