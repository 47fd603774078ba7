"""What a pull shows: slack, preload, onset, steady part, judder and the way back."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from hypothesis import assume, given, settings

from laboratory.campaigns import bench as virtual
from laboratory.campaigns.bench import FULL, curve
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.enclosure import saturation_slip
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.mechanics.pull import force_at_elongation, peak
from layerjam.brake.simulate.stick_slip import stick_slip
from layerjam.core.errors import FileError
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.pull.summary import STEADY, pull_summary
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON, PTFE, one, padded, random_brakes, seeds

BOTH = pytest.mark.parametrize("brake", [KAPTON, PTFE], ids=["kapton", "ptfe"])
ONE = pytest.mark.parametrize(
    "brake", [KAPTON, pytest.param(PTFE, marks=pytest.mark.slow)], ids=["kapton", "ptfe"]
)
"""Both brakes, of which the second takes long."""


def late(trace: Trace, slack: float, preload: float, noise: float, seed: int = 0) -> Trace:
    """The pull after a slack way, on a load cell that shows `preload` from the start, at 100 mm."""
    step = float(trace.elongation[1] - trace.elongation[0])
    before = np.arange(-round(slack / step), 0) * step
    force = np.concatenate([np.zeros(len(before)), trace.force]) + preload
    force = force + noise * np.random.default_rng(seed).standard_normal(len(force))
    u = np.concatenate([before, trace.elongation]) + 0.1
    return Trace(force, u, np.arange(len(u)) * 1e-3, "late.csv", "made")


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_slack_preload_and_onset_of_random_brakes_within_their_errors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    brake = one(random_brakes(seed, 1), 0)
    vacuum = brake.site.atmosphere * rng.uniform(0.4, 1)
    top = peak(vacuum, brake.sheets.usable_travel, brake)
    far = float(top.elongation) + 0.6 * (brake.sheets.usable_travel - float(top.slip))
    assume(bool(top.inside) and float(saturation_slip(vacuum, brake)) > brake.sheets.overlap)
    # beyond this the sleeve lifts the peak so far that onset lies below 80 % of it
    assume(float(top.slip) < 0.1 * brake.sheets.overlap)
    trace = curve(brake, vacuum, far, rows=6001)
    assume(trace.force[-1] < 0.95 * float(top.force) and float(top.elongation) > far / 100)
    step, height = far / 6000, float(top.force)
    slack = round(rng.uniform(0.02, 0.1) * far / step) * step
    preload = float(rng.uniform(-0.02, 0.02) * height)
    noise = height * 10 ** rng.uniform(-5, -2)
    found = pull_summary(late(trace, slack, preload, noise, seed))
    assert found.features.straight and found.start.seen and found.start.onset_se is not None
    # 6 standard errors, and what of the samples' spacing cannot be told
    assert found.start.onset == pytest.approx(0.1, abs=6 * found.start.onset_se + 1e-9)
    assert found.start.slack == pytest.approx(slack, abs=6 * found.start.onset_se + 1e-9)
    assert found.start.baseline_se is not None
    assert found.preload == pytest.approx(preload, abs=6 * found.start.baseline_se + 1e-9)
    assert found.features.stiffness == pytest.approx(
        brake.stiffness_measured, rel=1e-6, abs=6 * found.features.stiffness_se
    )
    assert found.teeth is None and found.unloading is None


@ONE
def test_standard_errors_of_onset_and_preload_are_what_they_say(brake) -> None:
    trace = curve(brake, FULL, rows=8001)
    onset, base = [], []
    for seed in range(120):
        found = pull_summary(late(trace, 1e-3, 0.5, 0.3, seed)).start
        onset.append((found.onset - 0.1) / found.onset_se)
        base.append((found.baseline - 0.5) / found.baseline_se)
    for z in (np.array(onset), np.array(base)):
        assert 0.8 < z.std(ddof=1) < 1.25 and abs(z.mean()) < 0.4


@BOTH
def test_tare_subtracts_on_request_only_and_says_so(brake) -> None:
    clean = pull_summary(late(curve(brake), 1e-3, 0.0, 0.02), tare=True)
    shifted = late(curve(brake), 1e-3, 2.0, 0.02)
    plain, tared = pull_summary(shifted), pull_summary(shifted, tare=True)
    assert plain.features.peak_force == pytest.approx(clean.features.peak_force + 2.0, rel=1e-3)
    assert plain.tared is None and any("preload, or the load cell's zero" in n for n in plain.notes)
    assert tared.features.peak_force == pytest.approx(clean.features.peak_force, rel=1e-9)
    assert tared.tared == pytest.approx(2.0, abs=0.01)
    assert any("was subtracted" in n for n in tared.notes) and abs(tared.preload) < 1e-9
    with pytest.raises(FileError, match="starts during its rise"):
        pull_summary(curve(brake), tare=True)


def test_a_record_that_begins_on_its_rise_has_no_slack() -> None:
    trace = curve(KAPTON)
    loaded = replace(trace, force=trace.force[5:], elongation=trace.elongation[5:], time=None)
    found = pull_summary(loaded)
    assert not found.start.seen and found.start.slack == 0.0
    assert found.preload == pytest.approx(131e3 * float(loaded.elongation[0]), rel=1e-9)
    assert found.start.onset == float(loaded.elongation[0])
    assert any("already at the first sample" in n for n in found.notes)


def test_the_preload_of_a_record_on_its_rise_is_the_mean_of_five_samples() -> None:
    trace = curve(KAPTON, FULL, rows=8001)
    later = replace(trace, force=trace.force[5:], elongation=trace.elongation[5:], time=None)
    start = pull_summary(late(later, 0.0, 0.0, 0.3)).start
    assert not start.seen and start.baseline_se is not None
    # 5 samples of independent noise, 0.3 N each, whose size is estimated to about 2 %
    assert start.baseline_se == pytest.approx(0.3 / np.sqrt(5), rel=0.05)
    due = 131e3 * float(later.elongation[0])
    assert start.baseline == pytest.approx(due, abs=4 * start.baseline_se)


def test_a_rest_before_the_pull_is_a_baseline() -> None:
    trace = late(curve(KAPTON), 0.0, 0.8, 0.05)
    force = np.concatenate([0.8 + 0.05 * np.random.default_rng(2).standard_normal(500),
                            trace.force])  # fmt: skip
    u = np.concatenate([np.full(500, 0.1), trace.elongation])
    found = pull_summary(Trace(force, u, None, "rest.csv", "made"))
    assert found.start.seen and found.preload == pytest.approx(0.8, abs=0.02)
    assert found.start.slack == pytest.approx(0.0, abs=2e-6)


def test_a_slow_growth_of_the_force_in_the_slack_is_not_the_rise() -> None:
    """A drag that grows at 2 % of the stiffness, on a preload: slack is less than preload/k."""
    stiffness, slack, preload = 1e5, 30e-6, 5.0
    moved = np.arange(0, 0.01, 1e-6)
    drag = preload + 0.02 * stiffness * np.minimum(moved, slack)
    force = np.minimum(drag + stiffness * np.maximum(moved - slack, 0), 150 - 500 * moved)
    rest = 50
    u = 0.1 + np.concatenate([np.zeros(rest), moved])
    force = np.concatenate([np.full(rest, preload), force])
    start = pull_summary(Trace(force, u, None, "drag.csv", "made")).start
    assert start.seen
    # the baseline is between the preload and the drag at the onset, 0.06 N more
    assert preload <= start.baseline <= preload + 0.06
    assert start.slack == pytest.approx(slack, abs=0.06 / stiffness)


def test_the_onset_of_a_rise_in_steps_has_the_error_of_its_line() -> None:
    """A load cell slower than the recorder: only three samples lie in the middle of the line."""
    u = np.arange(100) * 1e-4
    steps = np.array([0.21, 0.21, 0.79, 0.79, 0.79])
    force = np.concatenate([np.zeros(10), 150 * steps, 150 - 300 * u[:85]])
    summary = pull_summary(Trace(force, u, None, "steps.csv", "made"))
    # zero force at -b/k, of the line through the last zero and the steps
    (k, b), cov = np.polyfit(u[9:15], force[9:15], 1, cov=True)
    by_line = np.array([b / k**2, -1 / k])
    assert summary.features.stiffness == pytest.approx(k) and summary.preload == 0.0
    assert summary.start.onset == pytest.approx(-b / k)
    assert summary.start.onset_se == pytest.approx(np.sqrt(by_line @ cov @ by_line), rel=0.05)


@BOTH
@pytest.mark.parametrize("vacuum", [46.1e3, FULL])
def test_the_steady_slope_is_the_laws(brake, vacuum) -> None:
    found = pull_summary(curve(brake, vacuum, rows=8001)).steady
    top = peak(vacuum, 0.06, brake)
    ends = float(top.elongation) + np.array(STEADY) * (0.04 - float(top.elongation))
    assert (found.start, found.end) == pytest.approx(tuple(ends), abs=1e-7)
    u = np.linspace(*ends, 4001)
    slope = np.polyfit(u, np.asarray(force_at_elongation(u, vacuum, brake)), 1)[0]
    assert found.slope == pytest.approx(slope, rel=2e-3) and found.slope < 0
    rough = pull_summary(late(curve(brake, vacuum, rows=8001), 1e-3, 0.0, 0.3)).steady
    assert rough.slope == pytest.approx(slope, abs=6 * rough.slope_se)


@BOTH
def test_unloading_of_the_models_own_cycle(brake) -> None:
    u = np.concatenate([np.linspace(0, 0.04, 2001), np.linspace(0.04, 0.0, 2001)[1:]])
    long, vacuum, count = padded(u, FULL)
    cycle = jax.tree.map(lambda v: np.asarray(v)[:count], brake_cycle(long, vacuum, brake))
    trace = late(Trace(np.asarray(cycle.force), u, None, "", ""), 1e-3, 0.0, 0.05)
    found = pull_summary(trace).unloading
    assert found is not None and found.closed and found.stiffness is not None
    assert found.stiffness_se is not None and found.residual_elongation is not None
    assert found.stiffness == pytest.approx(brake.stiffness_measured, rel=5e-3)
    # the sheets stay where they slid to; the brake is slack from there on
    assert found.residual_elongation == pytest.approx(float(cycle.slip[2000]), abs=5e-6)
    assert found.residual_force == pytest.approx(0.0, abs=0.05)
    assert found.force_at_reversal == pytest.approx(float(cycle.force[2000]), abs=0.2)
    assert found.loop == pytest.approx(float(cycle.work[-1]), abs=6 * found.loop_se + 1e-4)
    spring = found.force_at_reversal**2 / (2 * brake.stiffness_measured)
    assert found.returned == pytest.approx(spring, rel=0.05)


def test_a_hold_before_the_way_back() -> None:
    """Out along the law, a rest, and back along k: the work kept is that of the sheets."""
    out = curve(KAPTON)
    back = np.linspace(0.04, 0.03, 4001)
    top = float(out.force[-1])
    force = np.concatenate([out.force, np.full(300, top),
                            np.maximum(top - 131e3 * (0.04 - back), 0.0)])  # fmt: skip
    u = np.concatenate([out.elongation, np.full(300, 0.04), back])
    found = pull_summary(Trace(force, u, None, "hold.csv", "made")).unloading
    assert found is not None and not found.closed
    assert found.stiffness == pytest.approx(131e3, rel=1e-6)
    work = float(np.trapezoid(out.force, out.elongation))
    assert found.work == pytest.approx(work, rel=1e-9)
    assert found.loop == pytest.approx(work - top**2 / (2 * 131e3), rel=1e-5)
    assert found.residual_elongation == pytest.approx(0.04 - top / 131e3, abs=1e-9)


@pytest.mark.parametrize("name", ["choi2018-kapton", "choi2018-ptfe"])
def test_a_pull_that_judders(name: str) -> None:
    """The truth is the simulation's own events."""
    run = stick_slip(load(name), vacuum=FULL, speed=5e-3, mass=0.5, damping=20.0, travel=0.03)
    time = np.arange(0, run.time[-1], 1e-3)
    force = np.interp(time, run.time, run.force)
    force = force + 0.15 * np.random.default_rng(3).standard_normal(len(time))
    found = pull_summary(Trace(force, 5e-3 * time, time, "saw.csv", "made"))
    assert found.teeth is not None
    events = run.events
    assert found.teeth.teeth == pytest.approx(len(events), abs=3)
    swing = float((events.force_high - events.force_low).mean())
    assert 2 * found.teeth.amplitude == pytest.approx(swing, rel=0.06)
    assert found.teeth.spacing == pytest.approx(float(np.median(events.slip)), rel=0.06)
    assert found.teeth.period == pytest.approx(found.teeth.spacing / 5e-3, rel=0.02)
    assert found.features.force[found.teeth.peaks].min() > float(events.force_high[-1]) - 2.0
    # its peak is the first slip, its rise the brake's stiffness
    assert found.features.peak_force == pytest.approx(float(events.force_high[0]), abs=1.0)
    assert found.features.stiffness == pytest.approx(run.stiffness, rel=5e-3)
    assert any("sticks and slips" in n for n in found.notes)


def test_the_rise_is_the_first_one_though_a_later_tooth_is_higher() -> None:
    """Teeth that grow: the slope was once taken from the last tooth's foot to its tip."""
    u = np.linspace(0, 0.02, 8001)
    tops = np.array([100.0, 104, 108, 112, 116, 120])
    x, y = [0.0], [0.0]
    for top in tops:
        x.append(x[-1] + (top - y[-1]) / 1e5)
        y.append(top)
        x.append(x[-1] + 1e-5)
        y.append(0.4 * top)
    force = np.interp(u, x, y)
    found = pull_features(Trace(force, u, None, "grow", "made"))
    assert found.stiffness == pytest.approx(1e5, rel=1e-6) and found.origin == pytest.approx(0)


@BOTH
def test_a_noisy_low_vacuum_pull_keeps_its_stiffness(brake) -> None:
    """Noise of 5 % of the peak: levels are read from a smoothed rise."""
    trace = curve(brake, 30e3, rows=16001)
    height = float(trace.force.max())
    slopes = [
        pull_features(late(trace, 1e-3, 0.0, 0.05 * height, seed)).stiffness for seed in range(20)
    ]
    assert np.mean(slopes) == pytest.approx(brake.stiffness_measured, rel=0.03)


def test_bent_pulls_say_so() -> None:
    machine = virtual.Machine(load_cell_noise=0.05)
    found = pull_summary(virtual.pull(PTFE, 1e3, 0.013, 0.04, machine))
    assert not found.features.has_peak and found.steady is None
    assert any("rises to the end" in n for n in found.notes)


def test_a_fast_pull_with_few_samples_before_its_rise_has_slack_and_no_preload():
    """Six samples of slack: the line of the rise, drawn on to the first, lies far below zero."""
    u = np.linspace(0, 0.04, 1001)
    trace = late(Trace(np.asarray(force_at_elongation(u, FULL, KAPTON)), u, None, "", ""),
                 2.4e-4, 0.0, 0.05, 3)  # fmt: skip
    found = pull_summary(trace)
    assert found.start.seen
    assert found.start.slack == pytest.approx(2.4e-4, abs=6 * (found.start.onset_se or 0))
    assert abs(found.preload) < 5 * (found.start.baseline_se or 0)
    assert found.notes == ()


def test_a_thinned_record_has_the_same_features_and_means():
    u = np.linspace(0, 0.04, 50_001)
    trace = Trace(np.asarray(force_at_elongation(u, FULL, KAPTON)), u, u / 0.013, "", "")
    few = trace.thinned(1000)
    assert len(few) == 981
    assert few.time is not None
    assert few.force[:-1].mean() == pytest.approx(trace.force[: 980 * 51].mean(), rel=1e-12)
    assert np.diff(few.elongation).min() > 0
    assert trace.thinned(60_000).force is trace.force
    whole, thin = pull_features(trace), pull_features(trace).thinned(2000)
    assert (thin.peak_force, thin.stiffness) == (whole.peak_force, whole.stiffness)
    law = np.asarray(force_at_elongation(thin.elongation, FULL, KAPTON))
    assert np.abs(thin.force - law)[10:].max() < 2e-3 * whole.peak_force


@pytest.mark.parametrize("seed", range(40))
def test_a_peak_is_nowhere_above_what_was_measured(seed: int) -> None:
    """Static friction that breaks: the force falls as no law of the brake does."""
    rng = np.random.default_rng(seed)
    u = np.arange(0, 0.03, rng.uniform(2e-5, 2e-4))
    length, share = rng.uniform(1e-4, 3e-3), rng.uniform(0.1, 0.6)
    onset = 150 / 1e5
    sliding = 150 * (1 - share + share * np.exp(-np.maximum(u - onset, 0) / length)) - 500 * u
    force = np.minimum(1e5 * u, sliding) + rng.normal(0, 0.05, len(u))
    found = pull_features(Trace(force, u, None, "x.csv", "made"))
    assert found.peak_force <= 1.01 * force.max()


def test_the_force_at_the_first_sample_is_one_that_was_measured() -> None:
    """A toe: the rise is soft at first, so that its line, carried back, is far below zero."""
    u = np.arange(0, 0.02, 1e-5)
    force = np.minimum(1e5 * np.maximum(u - 3e-5, 0) + 2000 * u + 5, 150 - 500 * u)
    found = pull_summary(Trace(force, u + 0.1, None, "x.csv", "made"))
    if not found.start.seen:
        assert found.preload == pytest.approx(force[0], abs=0.5)
    for u0 in (0.0, 1e-4, 3e-4):
        kept = u >= u0
        found = pull_summary(Trace(force[kept], u[kept], None, "x.csv", "made"))
        near = force[kept][:5]
        assert near.min() - 0.5 <= found.preload <= near.max() + 0.5


def test_what_follows_the_greatest_travel_is_said() -> None:
    out = np.linspace(0, 0.02, 1001)
    force = np.minimum(1e5 * out, 150 - 500 * out)
    for back, text in (
        (np.full(40, 0.0199), "40 samples after its maximum elongation, 20 mm, are not used"),
        (np.r_[out[::-1][1:800], out[201:900]], "699 samples after the first return"),
    ):
        u = np.r_[out, back]
        whole = np.r_[force, np.interp(back, out, force) * 0.1]
        notes = pull_summary(Trace(whole, u, None, "x.csv", "made")).notes
        assert any(text in note for note in notes), notes
    assert not any("not used" in n for n in pull_summary(Trace(force, out, None, "x", "")).notes)
