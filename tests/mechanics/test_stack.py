"""Sheet by sheet: the exact increment, its check values, and the physics of whole pulls."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.device.load import load
from layerjam.errors import LayerjamError, ProcedureError
from layerjam.mechanics.pull import force_at_elongation, peak
from layerjam.mechanics.stack import Stack, fused_lasso, pull_stack
from layerjam.simulate.procedure import parse_procedure, simple_pull
from layerjam.simulate.stack import Interfaces, peak_spread, stack_of, tensile_stack
from strategies import KAPTON

FULL = 94.5e3


def rigid(static: bool = False) -> Stack:
    return stack_of(KAPTON, FULL, static=static, sleeve=False, mount=np.inf)


def solved(d: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    z = np.zeros(len(d))
    fused_lasso(d, b, c, z, np.zeros((4, 2 * len(d))))
    return z


@pytest.mark.parametrize("n", [2, 3, 11, 200])
def test_the_increment_meets_the_conditions_of_its_minimum(n):
    random = np.random.default_rng(n)
    for _ in range(300):
        d = np.exp(random.normal(0, 1, n))
        b = random.normal(0, 1, n) * random.choice([0.1, 1, 10])
        c = np.exp(random.normal(-1, 1.5, n - 1))
        z = solved(d, b, c)
        carried = np.cumsum(d * (z - b))
        assert abs(carried[-1]) < 1e-9 * np.abs(d * b).max()
        force = carried[:-1]
        assert (np.abs(force) <= c * (1 + 1e-9) + 1e-9).all()
        slides = np.diff(z) != 0
        # friction pulls the left sheet after the right one
        ahead = np.sign(np.diff(z))[slides]
        assert force[slides] == pytest.approx((c * 1.0)[slides] * ahead, rel=1e-8, abs=1e-8)


def test_two_sheets_by_hand():
    z = solved(np.array([2.0, 3.0]), np.array([0.0, 1.0]), np.array([0.5]))
    assert z == pytest.approx([0.25, 1 - 0.5 / 3])
    z = solved(np.array([2.0, 3.0]), np.array([0.0, 1.0]), np.array([5.0]))
    assert z == pytest.approx([0.6, 0.6])


def test_rigid_mount_identical_interfaces_no_sleeve():
    path = np.linspace(0, 3e-4, 6001)
    result = pull_stack(path, rigid())
    assert result.force[1] / path[1] == pytest.approx(2046694.2, rel=1e-7)
    # the outer sheets carry one interface only, so the outer interfaces slide first, at 6 c
    c = rigid().kinetic[0] * KAPTON.sheets.overlap
    first = int(result.sliding.any(axis=1).argmax())
    assert result.sliding[first].tolist() == [True] + [False] * 8 + [True]
    assert result.force[first] == pytest.approx(6 * c, rel=2e-3)
    # 2 slope^2/spring below c n: the outer pair has slipped when the last ones let go
    slope = rigid().kinetic[0]
    top = 10 * c - 2 * slope * c / rigid().springs[0]
    assert result.force.max() == pytest.approx(top, abs=5e-4)
    assert result.force.max() == pytest.approx(175.416, abs=3e-3)


def test_static_friction_breaks_with_a_drop_at_a_fixed_cap():
    result = pull_stack(np.linspace(0, 1.2e-4, 24001), rigid(static=True))
    drop = int(np.flatnonzero(np.diff(result.force) < -1)[0])
    assert result.force[drop] == pytest.approx(140.34, abs=0.01)
    assert result.force[drop + 1] == pytest.approx(133.85, abs=0.02)


def test_a_load_held_moves_nothing():
    path = np.concatenate([np.linspace(0, 5e-5, 500), np.full(2000, 5e-5)])
    result = pull_stack(path, rigid())
    assert (result.slip[-1] == result.slip[499]).all()
    assert (result.sheets[-1] == result.sheets[499]).all()


def test_unloading_and_reloading_without_sleeve_gives_no_energy():
    up = np.linspace(0, 5e-3, 2001)
    path = np.concatenate([up, up[::-1], up, up[::-1]])
    result = pull_stack(path, rigid())
    work = ((result.force[1:] + result.force[:-1]) / 2 * np.diff(path)).cumsum()
    assert work[-1] > 0
    assert work[len(up) * 2 - 2] > 0
    sign = np.where(rigid().right[:-1], -1.0, 1.0)
    heat = (result.interface[1:] * sign * np.diff(result.slip, axis=0)).sum(axis=1)
    assert heat.min() > -1e-9


def test_whole_pull_meets_the_lumped_brake_after_onset_and_its_energy_closes():
    record, result = tensile_stack(load("choi2018-kapton"), simple_pull(FULL, 0.013, 0.040))
    late = record.elongation > 5e-3
    lumped = np.asarray(force_at_elongation(record.elongation, FULL, KAPTON))
    assert record.force[late] == pytest.approx(lumped[late], rel=1e-3)
    assert record.force.max() == pytest.approx(float(peak(FULL, 0.06, KAPTON).force), rel=2e-3)
    # the sleeve's root adds to the very first micrometres; past them the slope is the measured one
    rise = (record.force > 30) & (record.force < 70) & (record.elongation < 1e-3)
    slope = np.polyfit(record.elongation[rise], record.force[rise], 1)[0]
    assert slope == pytest.approx(KAPTON.stiffness_measured, rel=2e-3)
    left = record.work - record.dissipated_energy - record.stored_energy
    assert np.abs(left).max() < 1e-5 * record.work[-1]
    assert (np.diff(record.dissipated_energy) >= -1e-12).all()
    onset = result.sliding.argmax(axis=0)
    assert len(set(onset.tolist())) > 1, "all interfaces let go at once"


def test_a_missing_vacuum_in_the_middle_weakens_those_interfaces_only():
    vacuum = np.ones(10)
    vacuum[4:6] = 0.5
    stack = stack_of(KAPTON, FULL, interfaces=Interfaces(vacuum=vacuum), sleeve=False)
    result = pull_stack(np.linspace(0, 0.01, 2001), stack)
    assert np.abs(result.interface[-1]) == pytest.approx(
        stack.kinetic * (KAPTON.sheets.overlap - result.slip[-1]), rel=1e-9
    )
    assert result.force.max() == pytest.approx(175.4298 * 0.9, rel=2e-3)


def test_scatter_lowers_nothing_on_average_but_spreads_the_peak():
    tops, springs = peak_spread(load("choi2018-kapton"), FULL, 0.10, samples=60)
    assert tops.mean() == pytest.approx(175.9, rel=0.02)
    assert tops.std(ddof=1) == pytest.approx(175.4 * 0.10 / 10**0.5, rel=0.4)
    assert springs.mean() == pytest.approx(131e3, rel=0.01)


def test_past_the_overlap_it_separates_and_other_procedures_are_refused():
    file = load("choi2018-kapton")
    record, _ = tensile_stack(file, simple_pull(FULL, 0.013, 0.090))
    assert str(record.outcome) == "SEPARATED"
    with pytest.raises(ProcedureError, match="one pull"):
        tensile_stack(file, parse_procedure("evacuate to 9 kPa; cycle 2 times between 1 mm and "
                                            "2 mm at 1 mm/s"))  # fmt: skip
    with pytest.raises(LayerjamError, match="interfaces"):
        pull_stack(np.zeros(3), rigid()._replace(extra=np.zeros(3)))
