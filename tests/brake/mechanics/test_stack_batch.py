"""Many stacks at once give what one after another gives."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.kernel.stack import find_peaks, pull_stack
from layerjam.brake.mechanics.stack.solve import Stack
from layerjam.brake.simulate.stack_layout import make_stack
from strategies import KAPTON

FULL = 94.5e3
C = 175.4298


@pytest.mark.slow
def test_many_stacks_are_each_what_one_is():
    random = np.random.default_rng(2)
    for stack in (
        make_stack(KAPTON, FULL),
        make_stack(KAPTON, FULL, enclosure=False, mount=np.inf),
        make_stack(KAPTON, FULL, static=True),
    ):
        friction = stack.friction * np.exp(random.normal(0, 0.1, (6, 10)))
        friction[0] = stack.friction
        length = np.broadcast_to(stack.length, friction.shape)
        peaks = find_peaks(stack, friction, length, 0.06)
        for j in range(6):
            one = stack._replace(friction=friction[j])
            run = pull_stack(np.linspace(0, 1.1 * peaks.elongation[j], 30001), one)
            # breaks of static friction lie between the increments: the batch meets them exactly
            assert peaks.peak[j] == pytest.approx(run.force.max(), rel=5e-4)
            if stack.ratio[0] == 1:
                assert peaks.peak[j] == pytest.approx(run.force.max(), rel=1e-5)
                top = int(run.force.argmax())
                assert peaks.slip[j] == pytest.approx(run.slip[top].mean(), rel=2e-2)
            first = run.sliding.any(axis=1).argmax()
            assert peaks.onset[j] == pytest.approx(run.force[first - 1], rel=3e-3)
            low, high = (np.interp(s * run.force.max(), run.force[: run.force.argmax()],
                                   np.linspace(0, 1.1 * peaks.elongation[j], 30001)[
                                       : run.force.argmax()]) for s in (0.2, 0.8))  # fmt: skip
            if stack.ratio[0] == 1:
                slope = 0.6 * run.force.max() / (high - low)
                assert peaks.stiffness[j] == pytest.approx(slope, rel=5e-3)


def test_a_batch_keeps_what_could_not_be_followed_apart():
    stack = make_stack(KAPTON, FULL, mount=2000.0)
    friction = np.stack([stack.friction, stack.friction * 0.5])
    length = np.broadcast_to(stack.length, friction.shape)
    peaks = find_peaks(stack, friction, length, 0.2)
    assert np.isnan(peaks.peak[0])
    assert peaks.peak[1] == pytest.approx(C / 2, rel=3e-2)


def test_no_peak_within_the_travel_gives_the_end():
    stack = make_stack(KAPTON, 500.0)
    peaks = find_peaks(stack, stack.friction[None], stack.length[None], 0.03)
    run = pull_stack(np.linspace(0, 0.03, 500), stack)
    assert peaks.elongation[0] == pytest.approx(0.03)
    assert peaks.peak[0] == pytest.approx(run.force[-1], rel=1e-9)


def test_the_stiffness_is_that_of_three_sheets_by_hand() -> None:
    """The first interface slips at 4 N of 10 N, between the two forces of the secant."""
    spring, mount = 3e5, 1e5
    friction, length = np.array([[2.0, 8.0]]), np.full((1, 2), np.inf)
    stack = Stack(
        springs=np.full(3, spring),
        right=np.array([False, True, False]),
        friction=friction[0],
        ratio=np.ones(2),
        length=length[0],
        mount=mount,
        ends=np.array([0, 2]),
        face=np.array([0.0, 0.0, 1.0]),
    )
    peaks = find_peaks(stack, friction, length, 0.01)
    # at 2 N the outer sheets share the force; at 8 N the second one carries all but 2 N
    low, high = 1 / spring + 2 / spring + 2 / mount, 6 / spring + 8 / spring + 8 / mount
    assert float(peaks.stiffness[0]) == pytest.approx(6 / (high - low), rel=1e-9)
    assert float(peaks.onset[0]) == pytest.approx(4.0, rel=1e-9)
    assert float(peaks.peak[0]) == pytest.approx(10.0, rel=1e-9)
