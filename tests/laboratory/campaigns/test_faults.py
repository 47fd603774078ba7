"""Each fault of the virtual machine does what it says, by its size, and leaves the rest alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, peak
from layerjam.core.errors import QuantityError
from layerjam.laboratory.campaigns import faults
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.spec import Faults, FrictionTests, Pulls, Scatter, Spec, Truth
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON, change

VACUUM, SPEED, STIFFNESS = 70e3, 10e-3, 131e3
SPEC = Spec(
    brakes=(Truth(brake="choi2018-kapton"),),
    pulls=Pulls(vacuums=(VACUUM,), speeds=(SPEED,), repeats=1, travel=0.04),
    machine=Faults(sampling_rate=1000.0),
)


def shown(spec: Spec = SPEC, **machine: Any) -> Trace:
    """The one pull of the campaign, with some faults more."""
    return campaign(replace(spec, machine=replace(spec.machine, **machine))).traces()[0]


@pytest.fixture(scope="module")
def perfect() -> Trace:
    """The pull without any fault."""
    return shown()


def test_without_faults_the_law_itself(perfect: Trace) -> None:
    law = np.asarray(force_at_elongation(perfect.elongation, VACUUM, KAPTON))
    np.testing.assert_allclose(perfect.force, law, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(perfect.elongation, SPEED * perfect.time, rtol=0, atol=1e-15)
    assert perfect.elongation[-1] == pytest.approx(0.04, abs=1e-12)
    assert perfect.force.max() == pytest.approx(float(peak(VACUUM, 0.06, KAPTON).force), abs=1e-3)


def test_noise_is_white_and_of_its_size(perfect: Trace) -> None:
    noise = shown(force_noise=0.2).force - perfect.force
    assert noise.std() == pytest.approx(0.2, rel=0.03)
    assert abs(noise.mean()) < 4 * 0.2 / np.sqrt(len(noise))
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 4 / np.sqrt(len(noise))


def test_one_fault_more_leaves_the_others_numbers_alone(perfect: Trace) -> None:
    noise = shown(force_noise=0.2).force - perfect.force
    more = shown(force_noise=0.2, force_offset=3.0, dropped=0.1)
    plain = shown(dropped=0.1)
    at = np.searchsorted(perfect.time, plain.time)
    np.testing.assert_allclose(more.force - plain.force - 3.0, noise[at], atol=1e-9)
    np.testing.assert_array_equal(more.time, plain.time)


def test_zero_drift_and_warmth(perfect: Trace) -> None:
    np.testing.assert_allclose(shown(force_offset=-2.5).force, perfect.force - 2.5, atol=1e-12)
    drifted = shown(force_drift=0.4).force - perfect.force
    np.testing.assert_allclose(drifted, 0.4 * perfect.time, atol=1e-11)
    two = replace(SPEC, pulls=replace(SPEC.pulls, repeats=2), machine=replace(
        SPEC.machine, warming=8.0, zero_per_kelvin=0.1, span_per_kelvin=-1e-3))  # fmt: skip
    first, last = campaign(two).traces()
    np.testing.assert_array_equal(first.force, perfect.force)
    np.testing.assert_allclose(last.force, perfect.force * (1 - 8e-3) + 0.8, atol=1e-11)
    warm = replace(two, machine=replace(SPEC.machine, warming=8.0, friction_per_kelvin=-2e-3))
    softer = change(KAPTON, scale_factor=KAPTON.scale_factor * (1 - 0.016))
    law = np.asarray(force_at_elongation(perfect.elongation, VACUUM, softer))
    np.testing.assert_allclose(campaign(warm).traces()[1].force, law, atol=1e-8)


def test_a_saturated_cell_shows_its_end_and_no_more(perfect: Trace) -> None:
    cut = shown(load_cell_range=100.0, force_noise=0.2)
    assert cut.force.max() == 100.0
    over = perfect.force > 101.5
    assert over.sum() > 100 and (cut.force[over] == 100.0).all()


@given(step=st.floats(1e-6, 10.0), value=st.floats(-1e3, 1e3))
def test_steps(step: float, value: float) -> None:
    got = float(faults.round_to_step(np.array([value]), step)[0])
    assert abs(got - value) <= step / 2 * (1 + 1e-9) + 1e-12
    assert abs(got / step - round(got / step)) < 1e-6
    assert faults.round_to_step(np.array([value]), 0.0)[0] == value


def test_steps_in_the_record() -> None:
    trace = shown(force_step=0.05, travel_step=1e-5, force_noise=0.3)
    for values, step in ((trace.force, 0.05), (trace.elongation, 1e-5)):
        ratio = values / step
        assert np.abs(ratio - np.round(ratio)).max() < 1e-6


def test_slack_preload_and_start(perfect: Trace) -> None:
    loose = shown(slack=0.3e-3)
    assert loose.force[loose.elongation < 0.3e-3 - 1e-12].max() == 0.0
    at = loose.elongation - 0.3e-3 >= 0
    law = np.asarray(force_at_elongation(loose.elongation[at] - 0.3e-3, VACUUM, KAPTON))
    np.testing.assert_allclose(loose.force[at], law, atol=1e-7)
    assert loose.elongation[-1] == pytest.approx(0.0403, abs=1.1e-5)
    tight = shown(preload=5.0)
    assert tight.force[0] == pytest.approx(5.0, abs=1e-9) and tight.elongation[0] == 0
    law = np.asarray(force_at_elongation(tight.elongation + 5.0 / STIFFNESS, VACUUM, KAPTON))
    np.testing.assert_allclose(tight.force, law, atol=1e-7)
    early = shown(crosshead_start=-2.5e-3)
    np.testing.assert_array_equal(early.force, perfect.force)
    np.testing.assert_allclose(early.elongation, perfect.elongation - 2.5e-3, atol=1e-15)


def test_compliance_is_a_spring_in_series(perfect: Trace) -> None:
    soft = shown(compliance=2e-6)
    rise = soft.elongation < 0.5e-3
    seen = 1 / (1 / STIFFNESS + 2e-6)
    np.testing.assert_allclose(soft.force[rise], seen * soft.elongation[rise], rtol=1e-9)
    # the same forces at the brake's own elongation
    own = soft.elongation - 2e-6 * soft.force
    law = np.asarray(force_at_elongation(own, VACUUM, KAPTON))
    np.testing.assert_allclose(soft.force, law, atol=1e-6)


def test_lag_shifts_the_force_against_the_travel(perfect: Trace) -> None:
    late = shown(lag=0.05)
    np.testing.assert_allclose(late.force[50:], perfect.force[:-50], atol=1e-7)
    assert (late.force[:50] == 0).all()
    np.testing.assert_array_equal(late.elongation, perfect.elongation)


def test_lost_samples_and_repeated_stamps(perfect: Trace) -> None:
    holes = shown(dropped=0.1)
    lost = 1 - len(holes) / len(perfect)
    assert lost == pytest.approx(0.1, abs=4 * np.sqrt(0.09 / len(perfect)))
    at = np.searchsorted(perfect.time, holes.time)
    np.testing.assert_array_equal(holes.force, perfect.force[at])
    assert holes.time[0] == perfect.time[0] and holes.time[-1] == perfect.time[-1]
    again = shown(repeated_stamps=0.2)
    step = np.diff(again.time)
    assert (step >= 0).all()
    assert (step == 0).mean() == pytest.approx(0.2, abs=4 * np.sqrt(0.16 / len(step)))
    np.testing.assert_array_equal(again.force, perfect.force)


def test_jitter_moves_the_moment_and_what_is_seen_then(perfect: Trace) -> None:
    trace = shown(jitter=1e-4)
    assert (np.diff(trace.time) > 0).all()
    # a normal distribution cut at two standard deviations keeps 96 % of its own... with the ends
    assert (trace.time - perfect.time).std() == pytest.approx(0.96e-4, rel=0.03)
    np.testing.assert_allclose(trace.elongation, SPEED * trace.time, atol=1e-15)


def test_stick_slip_is_a_saw_about_the_mean(perfect: Trace) -> None:
    fast = replace(SPEC, machine=replace(SPEC.machine, sampling_rate=50_000.0))
    smooth, rough = shown(fast), shown(fast, stick_slip=8.0)
    saw = rough.force - smooth.force
    sliding = np.asarray(smooth.force - STIFFNESS * smooth.elongation < -1e-6)
    assert (saw[~sliding] == 0).all()
    assert saw[sliding].max() == pytest.approx(4.0, abs=0.1)
    assert saw[sliding].min() == pytest.approx(-4.0, abs=0.1)
    assert abs(saw[sliding].mean()) < 0.02
    # an event comes each amplitude / stiffness of slip: 61 micrometres
    slid = smooth.elongation[-1] - smooth.force[-1] / STIFFNESS
    events = int((np.diff(saw) < -6.0).sum())
    assert events == pytest.approx(slid * STIFFNESS / 8.0, abs=1.5)


def test_vacuum_error_and_loss(perfect: Trace) -> None:
    wrong = shown(vacuum_error=-3e3)
    law = np.asarray(force_at_elongation(perfect.elongation, VACUUM - 3e3, KAPTON))
    np.testing.assert_allclose(wrong.force, law, atol=1e-8)
    assert wrong.facts.vacuum == VACUUM
    leaky = shown(vacuum_loss=2e3)
    slip = leaky.elongation - leaky.force / STIFFNESS
    at = slip > 1e-3
    law = np.asarray(brake_force(slip[at], VACUUM - 2e3 * leaky.time[at], KAPTON))
    np.testing.assert_allclose(leaky.force[at], law, rtol=1e-9)


def test_the_way_back_is_the_spring_alone() -> None:
    spec = replace(SPEC, pulls=replace(SPEC.pulls, unload=2e-3))
    trace = shown(spec)
    top = int(trace.elongation.argmax())
    assert trace.elongation[top] == pytest.approx(0.04, abs=1e-12)
    assert trace.elongation[-1] == pytest.approx(0.038, abs=1.1e-5)
    back = slice(top, None)
    end = trace.elongation[top] - trace.force[top] / STIFFNESS
    want = np.maximum(STIFFNESS * (trace.elongation[back] - end), 0.0)
    np.testing.assert_allclose(trace.force[back], want, atol=1e-6)
    # at 2 kPa the sleeve is the stronger one at 40 mm, and would close the brake
    weak = replace(spec, pulls=replace(spec.pulls, vacuums=(2e3,)))
    assert float(enclosure_force(0.04, 2e3, KAPTON)) > float(sheet_friction(0.04, 2e3, KAPTON))
    with pytest.raises(QuantityError, match="would close the brake during unloading"):
        shown(weak)


def test_scatter_has_mean_one_and_its_size() -> None:
    spec = replace(
        SPEC,
        pulls=replace(SPEC.pulls, repeats=1000),
        scatter=Scatter(friction=0.1, stiffness=0.05, enclosure=0.2),
    )
    tests = campaign(spec).tests
    for name, size in (("friction", 0.1), ("stiffness", 0.05), ("enclosure", 0.2)):
        values = np.array([getattr(t, name) for t in tests])
        assert values.mean() == pytest.approx(1.0, abs=4 * size / np.sqrt(1000))
        assert values.std() == pytest.approx(size, rel=0.1) and values.min() > 0


def test_scatter_shared_by_the_pulls_of_a_repeat() -> None:
    spec = replace(
        SPEC,
        pulls=replace(SPEC.pulls, vacuums=(40e3, 70e3), repeats=3),
        scatter=Scatter(friction=0.1, stiffness=0.1, enclosure=0.1, per="repeat"),
    )
    drawn: dict[int, set[tuple[float, ...]]] = {}
    for t in campaign(spec).tests:
        drawn.setdefault(t.repeat, set()).add((t.friction, t.stiffness, t.enclosure))
    assert all(len(d) == 1 for d in drawn.values())
    assert len(set.union(*drawn.values())) == 3


def test_scatter_is_the_brakes_own() -> None:
    spec = replace(SPEC, scatter=Scatter(friction=0.1, stiffness=0.1, enclosure=0.3))
    test, trace = next(campaign(spec).records())
    own = change(
        KAPTON,
        scale_factor=KAPTON.scale_factor * test.friction,
        stiffness_measured=STIFFNESS * test.stiffness,
        enclosure__modulus=KAPTON.enclosure.modulus * test.enclosure,
        film__friction_on_silicone=KAPTON.film.friction_on_silicone * test.enclosure,
    )
    law = np.asarray(force_at_elongation(trace.elongation, VACUUM, own))
    np.testing.assert_allclose(trace.force, law, atol=1e-8)
    slip = np.linspace(1e-3, 0.06, 50)
    for vacuum in (1e3, 94.5e3):  # saturated too
        ratio = np.asarray(
            enclosure_force(slip, vacuum, own) / enclosure_force(slip, vacuum, KAPTON)
        )
        np.testing.assert_allclose(ratio, test.enclosure, rtol=1e-12)


def test_truth_of_speed_and_pressure() -> None:
    truth = Truth(
        brake="choi2018-kapton", speed_slope=0.1, speed_reference=1e-3, pressure_exponent=-0.05,
        test_pressure=50e3,
    )  # fmt: skip
    trace = shown(replace(SPEC, brakes=(truth,)))
    own = change(KAPTON, scale_factor=KAPTON.scale_factor * np.exp(0.1), pressure_exponent=-0.05,
                 test_pressure=50e3)  # fmt: skip
    law = np.asarray(force_at_elongation(trace.elongation, VACUUM, own))
    np.testing.assert_allclose(trace.force, law, atol=1e-8)


def test_friction_tests_show_their_coefficients() -> None:
    tests = FrictionTests(repeats=40, kinetic_scatter=0.1, static_scatter=0.2, texture=0.0,
                          normal_force=2.0)  # fmt: skip
    made = campaign(replace(SPEC, pulls=Pulls(), friction=tests))
    for test, trace in made.records():
        window = (trace.elongation > 0.04) & (trace.elongation < 0.1)
        kinetic = trace.force[window].mean() / 2.0
        assert kinetic == pytest.approx(0.24 * test.friction, rel=1e-12)
        # the string adds 300 N/m x 25 micrometres between two samples
        top = max(0.32 * test.static, 0.24 * test.friction)
        assert top - 0.004 <= trace.force.max() / 2.0 <= top + 1e-9
        assert trace.facts.normal_force == 2.0 and trace.facts.vacuum is None
    found = np.array([t.friction for t in made.tests])
    assert found.std() == pytest.approx(0.1, rel=0.4)


def test_contradictions_are_refused() -> None:
    for wrong, words in (
        ({"slack": 1e-3, "preload": 1.0}, "removes the slack"),
        ({"jitter": 1e-3}, "0.2 of the sampling period"),
        ({"force_noise": -1.0}, "machine.force_noise: -1 N is not allowed"),
        ({"vacuum_error": 5e4}, "at most 20 kPa"),
        ({"vacuum_loss": 5e4}, "is impossible"),
        ({"sampling_rate": 1.0}, "5 samples; 10 to"),
    ):
        with pytest.raises(QuantityError, match=words):
            shown(**wrong)
