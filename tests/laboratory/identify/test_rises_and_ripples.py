"""Records of real rigs: two rises in one record, and a machine's ripple beside stick-slip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from laboratory.identify.saw import GRAVITY, sled, teeth
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.laboratory.commands.friction import FrictionTest, friction
from layerjam.laboratory.commands.pull import pull
from layerjam.laboratory.identify.pull.strokes import find_second_rise
from layerjam.laboratory.identify.stick_slip import find_ripple, find_saw_teeth
from layerjam.laboratory.measure.trace import Trace

SPEED = 0.5e-3
FIRST, SECOND = 8e3, 12.6e3
"""Stiffness of the free slide and of the braked pull [N/m], as of a stepper-driven rig."""


def two_rises(free: float = 0.15, braked: float = 0.9, noise: float = 3e-3, seed: int = 0) -> Trace:
    """A free slide with the force `free`, from 1 mm on braked with `braked`; straight rises."""
    x = np.arange(0, 2.5e-3, 2e-7)
    end = 1e-3 + (braked - free) / SECOND
    force = np.interp(x, [0, free / FIRST, 1e-3, end], [0, free, free, braked])
    force = force + noise * np.random.default_rng(seed).standard_normal(len(x))
    return Trace(force, x, x / SPEED, "two.csv", "made")


def test_two_rises_fail_and_each_can_be_chosen() -> None:
    trace = two_rises(free=0.3)
    whole = pull(trace)
    (row,) = whole.pulls
    rises, zero = whole.checks
    assert (zero["name"], zero["level"]) == ("zero", "note")  # no sample before its load
    assert (whole.verdict, rises["name"], rises["level"]) == ("failed", "rises", "failed")
    assert "--from" in rises["sentence"] and "two.csv (second from 1.9" in rises["sentence"]
    assert row["second_rise_time"] == pytest.approx(1.95, abs=0.05)
    assert row["stiffness"] is None or abs(row["stiffness"] / SECOND - 1) > 0.5  # why it fails
    braked = pull(trace, start=1.95, tare=True)
    assert braked.verdict == "passed" and braked.checks[0]["level"] == "passed"
    assert braked.pulls[0]["stiffness"] == pytest.approx(SECOND, rel=0.01)
    assert braked.pulls[0]["second_rise_time"] is None
    assert braked.pulls[0]["tared"] == pytest.approx(0.3, abs=0.01)
    assert braked.pulls[0]["onset"] == pytest.approx(1e-3, rel=0.01)
    free = pull(trace, end=1.9)
    assert free.pulls[0]["stiffness"] == pytest.approx(FIRST, rel=0.05)
    assert pull(trace, accept={"rises": "the first slide is what I want"}).verdict == "accepted"


def test_a_part_is_chosen_by_time_and_in_order() -> None:
    trace = two_rises()
    with pytest.raises(QuantityError, match="from: 2 s is not below to, 1 s"):
        pull(trace, start=2.0, end=1.0)
    timeless = Trace(trace.force, trace.elongation, None, "bare.csv", "made")
    with pytest.raises(LayerjamError, match="has no time column for --from and --to"):
        pull(timeless, start=1.95)
    assert "second from" not in pull(timeless).checks[0]["sentence"]
    with pytest.raises(LayerjamError, match="samples"):
        pull(trace, start=90.0)


@given(st.floats(0.08, 0.7), st.floats(0.0, 0.01), st.integers(0, 9999))
@settings(max_examples=25, deadline=None)
def test_every_clear_second_rise_is_found(share: float, noise: float, seed: int) -> None:
    trace = two_rises(share * 0.9, 0.9, noise * 0.9, seed)
    found = find_second_rise(trace.elongation, trace.force)
    assert found is not None
    assert 0.94e-3 < found.start < 1.005e-3
    assert found.force_before == pytest.approx(share * 0.9, abs=0.05)
    assert trace.elongation[found.index] == found.start


@given(st.integers(0, 9999))
@settings(max_examples=60, deadline=None)
def test_one_rise_of_any_shape_is_not_two(seed: int) -> None:
    """Slack, preload, a rounded rise, a seat that yields, a plateau that climbs or falls."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0, 1, int(rng.integers(300, 20000)))
    at, length = rng.uniform(0, 0.4), 10 ** rng.uniform(-2, -0.3)
    ramp = np.clip((u - at) / length, 0, None)
    kind = seed % 4
    force = np.minimum(ramp, 1.0)
    if kind == 1:
        force = 1 - np.exp(-ramp)
    elif kind == 2:
        force = np.minimum(ramp ** rng.uniform(1.2, 3), 1.0)
    elif kind == 3:
        force = np.tanh(ramp)
    force = force + rng.uniform(-0.3, 0.5) * np.clip(u - at, 0, None) + rng.uniform(0, 0.3)
    force = force + 10 ** rng.uniform(-4, -1.5) * rng.standard_normal(len(u))
    assert find_second_rise(u, force) is None


def _teeth_of(spacing: float, swing: float, seed: int = 0):  # type: ignore[no-untyped-def]
    u, force = teeth(
        rows=20_000, spacing=spacing, swing=swing, middle=1.0, uneven=0.02, fall=0.2,
        far=80 * spacing, noise=0.005, seed=seed,
    )  # fmt: skip
    found, why = find_saw_teeth(u, force, u / SPEED)
    assert found is not None, why
    return found


def test_one_spacing_at_any_swing_is_a_ripple_and_stick_slip_is_not() -> None:
    """Two motor steps of 10 µm, and slips of drop over stiffness, 12.6 kN/m."""
    swings = [0.065, 0.075, 0.13, 0.15]
    motor = [_teeth_of(20e-6, swing, seed) for seed, swing in enumerate(swings)]
    slips = [_teeth_of(swing / SECOND / 0.8, swing, seed) for seed, swing in enumerate(swings)]
    assert find_ripple([*motor, None]) == [True] * 4 + [False]
    assert find_ripple(slips) == [False] * 4
    assert find_ripple([_teeth_of(20e-6, 0.15, seed) for seed in range(5)]) == [False] * 5
    assert find_ripple(motor[:3]) == [False] * 3  # too few to compare
    # the slope of the rises is the stiffness of the pull only if the sheets stick
    for tooth in slips:
        assert tooth.stiffness == pytest.approx(SECOND, rel=0.06)
    assert motor[0].stiffness == pytest.approx(0.065 / 16e-6, rel=0.06)


def test_one_record_shows_a_ripple_if_its_swings_differ() -> None:
    """Rises of stick-slip grow with their swings; those of motor steps do not."""
    swings = 0.12 * (1 + 0.3 * np.sin(np.arange(60) / 4))
    for stiff, is_ripple in ((None, True), (SECOND, False)):
        rises = np.full(60, 16e-6) if stiff is None else swings / stiff
        ends = np.cumsum(rises / 0.8)
        x = np.column_stack([ends - rises / 0.8, ends - 0.2 * rises / 0.8]).ravel()
        level = np.column_stack([1 - swings / 2, 1 + swings / 2]).ravel()
        u = np.linspace(0, ends[-1], 20_000)
        force = np.interp(u, x, level) + 0.002 * np.random.default_rng(1).standard_normal(len(u))
        found = find_saw_teeth(u, force, u / SPEED).teeth
        assert found is not None and found.growth is not None
        assert abs(found.growth - (not is_ripple)) < 0.15
        assert find_ripple([found]) == [is_ripple]


def _pull(spacing: float, swing: float, stiffness: float, seed: int = 0) -> Trace:
    """A straight rise to 1 N, then teeth."""
    u, force = teeth(
        rows=20_000, spacing=spacing, swing=swing, middle=1.0, uneven=0.02, fall=0.2,
        far=80 * spacing, noise=0.002, seed=seed,
    )  # fmt: skip
    rise = np.arange(0, 1.0 / stiffness, u[1] - u[0])
    x = np.concatenate([rise, u + 1.0 / stiffness])
    return Trace(
        np.concatenate([stiffness * rise, force]), x, x / SPEED, f"{seed}-{swing}.csv", "made"
    )


def test_teeth_softer_than_the_pull_are_a_ripple_in_one_record() -> None:
    (row,) = pull(_pull(20e-6, 0.1, SECOND)).pulls  # 0.1 N over 16 µm: 6.3 kN/m
    assert row["ripple"] is True and row["stick_slip"] is False
    assert row["ripple_spacing"] == pytest.approx(20e-6, rel=0.03)
    assert row["ripple_period"] == pytest.approx(0.04, rel=0.03)
    assert row["ripple_amplitude"] == pytest.approx(0.05, rel=0.1)
    assert "motor steps" in row["ripple_cause"]
    assert row["stick_slip_spacing"] is None and row["teeth"] is None
    (row,) = pull(_pull(0.2 / SECOND / 0.8, 0.2, SECOND)).pulls
    assert row["stick_slip"] is True and row["ripple"] is False and row["ripple_cause"] is None
    assert row["stick_slip_stiffness"] == pytest.approx(SECOND, rel=0.06)


def test_several_files_show_a_ripple_that_one_does_not() -> None:
    """The rise bends (no stiffness is known), and only the swings together show the machine."""

    def bent(swing: float, seed: int) -> Trace:
        trace = _pull(20e-6, swing, SECOND, seed)
        lead = np.linspace(0, 1, 4000)
        x = np.concatenate([lead * 5e-4, trace.elongation[1:] + 5e-4])
        force = np.concatenate([0.7 * lead**0.5, np.maximum(trace.force[1:], 0.7)])
        return Trace(force, x, x / SPEED, f"bent-{seed}.csv", "made")

    traces = [bent(swing, seed) for seed, swing in enumerate((0.06, 0.07, 0.13, 0.15))]
    alone = pull(traces[0]).pulls[0]
    assert alone["stick_slip"] is True
    answer = pull(traces)
    assert [row["ripple"] for row in answer.pulls] == [True] * 4
    assert not any(row["stick_slip"] for row in answer.pulls)
    assert sum("likely cause: motor steps" in w for w in answer.warnings) == 4
    assert any("ripple ± " in line for line in answer.lines())


def test_a_sled_on_a_spring_still_sticks_and_slips() -> None:
    """A slow pull drops by 2 (F_s - F_k) every drop/k + V pi sqrt(m/k); teeth rise at k."""
    normal, spring = 2.45, 300.0
    runs = [sled(s, 0.25, normal=normal, spring=spring, travel=0.06, seed=i)
            for i, s in enumerate((0.30, 0.32, 0.34, 0.36))]  # fmt: skip
    slip = 2.5e-3 * np.pi * np.sqrt(normal / GRAVITY / spring)
    rows = pull(runs).pulls
    for row, static in zip(rows, (0.30, 0.32, 0.34, 0.36), strict=True):
        assert row["stick_slip"] is True and row["ripple"] is False
        drop = 2 * (static - 0.25) * normal
        assert 2 * row["stick_slip_amplitude"] == pytest.approx(drop, rel=0.12)
        assert row["stick_slip_spacing"] == pytest.approx(drop / spring + slip, rel=0.04)
        assert row["stick_slip_stiffness"] == pytest.approx(spring, rel=0.12)


def test_friction_averages_over_a_machine_s_ripple() -> None:
    """Four repeats with teeth of one spacing: their mean is the kinetic friction."""

    def repeat(swing: float, seed: int) -> Trace:
        u, force = teeth(
            rows=30_000, spacing=1e-3, swing=swing, middle=0.6, uneven=0.02, fall=0.2, far=0.11,
            noise=0.002, seed=seed,
        )  # fmt: skip
        return Trace(force, u, u / 2.5e-3, f"friction-{seed}.csv", "made")

    traces = [repeat(swing, seed) for seed, swing in enumerate((0.06, 0.07, 0.13, 0.15))]
    test = FrictionTest(normal_force=2.45)
    found = friction(traces, test=test)
    assert found.kinetic == pytest.approx(0.6 / 2.45, rel=0.01) and found.stick_slip is None
    assert [row["ripple"] for row in found.repeats_table] == [True] * 4
    assert any("likely cause: motor steps" in w for w in found.warnings)
    slips = [repeat(0.12, seed) for seed in range(4)]
    assert friction(slips, test=test).kinetic is None


def test_the_figure_of_a_long_record_with_teeth(tmp_path: Path) -> None:
    """Indices of the teeth once pointed beyond the thinned curve."""
    trace = _pull(0.2 / SECOND / 0.8, 0.2, SECOND)
    answer = pull(trace)
    ((_, summary),) = answer.record
    assert summary.teeth is not None
    assert summary.teeth.peaks.max() < len(summary.features.force) <= 10_000
    tips = summary.features.force[summary.teeth.peaks]
    assert np.median(tips) == pytest.approx(1.1, abs=0.02)
    answer.plot(tmp_path / "teeth.png")
    assert (tmp_path / "teeth.png").stat().st_size > 10_000
