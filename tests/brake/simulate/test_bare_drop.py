"""The way of a mass on the bare rope, beside its force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.simulate.rope_alone import simulate_bare_drop, simulate_damped_rope

MASSES, SPEEDS, SPRINGS = st.floats(0.05, 20), st.floats(0.1, 10), st.floats(1e2, 1e6)


@pytest.mark.slow
@given(MASSES, SPEEDS, SPRINGS, st.sampled_from([0.0, 9.81]))
def test_an_undamped_rope_pulls_by_its_stretch(mass, speed, spring, gravity):
    made = simulate_bare_drop(mass, speed, spring, 0.0, gravity, 9.81)
    top = simulate_damped_rope(mass, speed, spring, 0.0, gravity)[0]
    assert made.force == pytest.approx(spring * made.travel, abs=1e-6 * top)
    assert made.deceleration == pytest.approx(made.force / mass - gravity)
    # energy: at the greatest stretch the mass stands still
    far = float(made.travel.max())
    taken = spring * far**2 / 2
    assert taken == pytest.approx(mass * speed**2 / 2 + mass * gravity * far, rel=1e-4)


@given(MASSES, SPEEDS, SPRINGS, st.floats(0.05, 3), st.sampled_from([0.0, 9.81]))
def test_a_damped_rope_pulls_by_stretch_and_speed(mass, speed, spring, ratio, gravity):
    damping = 2 * ratio * np.sqrt(spring * mass)
    made = simulate_bare_drop(mass, speed, spring, damping, gravity, 9.81)
    keep = made.time >= 0
    time, travel, force = made.time[keep], made.travel[keep], made.force[keep]
    gap = np.diff(time)
    # where the samples are neither crowded to rounding nor far apart
    scale = 1 / np.sqrt(spring / mass) / (1 + 2 * ratio)
    fine = (gap > 1e-6 * scale) & (gap < 2e-3 * scale)
    pace = np.diff(travel) / gap
    middle = (travel[1:] + travel[:-1]) / 2
    pull = (force[1:] + force[:-1]) / 2
    assert fine.any()
    own = spring * middle + damping * pace
    assert own[fine] == pytest.approx(pull[fine], abs=1e-4 * float(force.max()))
