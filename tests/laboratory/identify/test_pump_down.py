"""Pump-downs: closed forms against integration, what is identifiable and what is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from layerjam.core.errors import FitError
from layerjam.laboratory.identify.logs import pump_down as d
from layerjam.laboratory.identify.logs.log_checks import check_pump_downs

A = 101325.0
V0, S, PU = 7.503e-6, 3.33e-6, 5e3
"""The paper's line (inferred), mechanics section 5."""


@pytest.mark.parametrize("shrink", [-0.8, -0.3, 0.0, 0.4, 0.9])
def test_closed_forms_solve_d_pv_dt(shrink):
    c, t = shrink / A, np.linspace(0, 8, 60)

    def slope(_, p):
        volume = 1 - c * (A - p[0])
        return [-0.44 * (p[0] - PU) / (volume + c * p[0])]

    made = solve_ivp(slope, (0, 8), [A], t_eval=t, rtol=1e-10, atol=1e-3)
    np.testing.assert_allclose(d.pressure(t, A, PU, 0.44, c), made.y[0], atol=0.05)


def test_the_paper_rises_in_its_time():
    """10 to 90 % of 94.5 kPa in 3.9 s for 7.503 mL at 3.33 mL/s, no ultimate pressure."""
    t = np.linspace(0, 12, 100_001)
    vacuum = A - d.pressure(t, A, 0.0, S / V0)
    low, high = (float(np.interp(f * 94.5e3, vacuum, t)) for f in (0.1, 0.9))
    assert high - low == pytest.approx(3.9, rel=1e-3)


def test_a_closing_chamber_has_no_answer():
    assert np.isnan(d.pressure(np.arange(3.0), A, 0.0, 1.0, 1.2 / A)).all()


@settings(max_examples=30, deadline=None)
@given(factor=st.floats(0.01, 100), shrink=st.floats(-0.5, 0.9))
def test_only_the_ratio_of_flow_and_volume_counts(factor, shrink):
    t = np.linspace(0, 5, 30)
    p = d.pressure(t, A, PU, 0.5, shrink / A)
    np.testing.assert_allclose(
        d.pressure(t * factor, A, PU, 0.5 / factor, shrink / A), p, rtol=1e-6
    )
    scaled = d.pressure(t, A * factor, PU * factor, 0.5, shrink / A / factor, A * factor)
    np.testing.assert_allclose(scaled, p * factor, rtol=1e-6)


def log_of(rate, seed, shrink=0.0, noise=60.0, before=1.0, end=12.0):
    rng = np.random.default_rng(seed)
    t = np.arange(-before, end, 0.01)
    p = np.where(t < 0, A, d.pressure(np.maximum(t, 0), A, PU, rate, shrink))
    return t + before, p + rng.normal(0, noise, len(t))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_truth_lies_in_the_intervals(seed):
    found = d.fit_pump_down(*log_of(S / V0, seed))
    for index, due in ((1, PU), (2, S / V0)):
        low, high = found.interval(index)
        assert low < due < high
    assert found.window[0] == pytest.approx(1.0, abs=0.1)
    flow, volume = d.pump_flow(found, V0), d.chamber_volume(found, S)
    assert flow.interval[0] < S < flow.interval[1]
    assert volume.interval[0] < V0 < volume.interval[1]
    assert flow.value / V0 == pytest.approx(S / volume.value)


def test_a_second_log_with_a_known_volume_settles_both():
    added = 10e-6
    alone = d.fit_pump_down(*log_of(S / V0, 4))
    more = d.fit_pump_down(*log_of(S / (V0 + added), 5, end=25.0))
    volume, flow = d.combine_logs(alone, more, added)
    assert volume.interval[0] < V0 < volume.interval[1]
    assert flow.interval[0] < S < flow.interval[1]
    assert volume.value == pytest.approx(V0, rel=0.01)
    with pytest.raises(FitError, match="swap the logs"):
        d.combine_logs(more, alone, added)
    with pytest.raises(FitError, match="do not differ"):
        d.combine_logs(alone, alone, added)


def test_a_chamber_that_vacuum_draws_together_is_recognised():
    t, p = log_of(0.44, 7, shrink=0.6 / A)
    constant = d.fit_pump_down(t, p)
    shrinking = d.fit_pump_down(t, p, shrink=None)
    assert d.is_flexible_better(constant, shrinking)
    low, high = shrinking.interval(3)
    assert low < 0.6 / A < high
    law, *_ = check_pump_downs([constant], {})
    assert law.level == "warning" and "--compliance" in law.sentence
    known = d.fit_pump_down(t, p, shrink=0.6 / A)
    assert known.interval(2)[0] < 0.44 < known.interval(2)[1]
    t, p = log_of(0.44, 8)
    assert not d.is_flexible_better(d.fit_pump_down(t, p), d.fit_pump_down(t, p, shrink=None))


@pytest.mark.parametrize("shrink", [-0.8, -0.3, 0.3, 0.8])
def test_the_compliance_of_a_log_without_noise_is_exact(shrink: float) -> None:
    """The chamber stretches (below zero) or contracts; V0 is its volume at the atmosphere."""
    t, p = log_of(0.44, 0, shrink=shrink / A, noise=0.0)
    fit = d.fit_pump_down(t, p, window=(1.0, None), shrink=None)
    assert fit.shrink * A == pytest.approx(shrink, rel=1e-6)
    assert fit.rate == pytest.approx(0.44, rel=1e-6)
    assert fit.ultimate == pytest.approx(PU, rel=1e-6)


def test_a_compliance_that_closes_the_chamber():
    found = d.fit_pump_down(*log_of(S / V0, 4))
    assert d.compliance_ratio(V0, None, 0.01e-9, found) == pytest.approx(0.01e-9 / V0)
    with pytest.raises(FitError, match="would reduce"):
        d.compliance_ratio(V0, None, 0.1e-9, found)


def test_an_early_end_is_said_and_widens_the_interval():
    t, p = log_of(S / V0, 9)
    short = d.fit_pump_down(t, p, window=(1.0, 4.0))
    whole = d.fit_pump_down(t, p, window=(1.0, None))
    _, end = check_pump_downs([short], {})
    assert end.level == "warning" and "extrapolation" in end.sentence
    width = [i[1] - i[0] for i in (short.interval(1), whole.interval(1))]
    assert width[0] > 3 * width[1]


def test_a_fall_within_one_section_of_the_fit_is_rejected() -> None:
    t = np.arange(3001) * 0.01
    p = d.pressure(t, A, 5e3, 80.0, 0.0, A)
    # 150 sections of 0.2 s: after the first, exp(-16) of the difference is left
    with pytest.raises(FitError, match=r"first of 150 sections .*\(0\.2 s\): end the window"):
        d.fit_pump_down(t, p)
    assert d.fit_pump_down(t, p, window=(0.0, 1.0)).rate == pytest.approx(80.0, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_an_ultimate_pressure_is_at_most_the_atmosphere(seed):
    """A fifth of a time constant, noise of 200 Pa: the log hardly tells where the fall ends."""
    time = np.linspace(0, 0.2, 60)
    noise = np.random.default_rng(seed).normal(0, 200, len(time))
    short = d.fit_pump_down(time, 5e3 + (A - 5e3) * np.exp(-time) + noise, window=(0.0, None))
    low, high = short.interval(1)
    assert 0 <= low <= short.ultimate <= high <= A
    ends = {"ultimate pressure": (short.ultimate, low, high)}
    levels = {one.name: one.level for one in check_pump_downs([short], ends)}
    assert levels["ultimate pressure interval"] == "failed"


@pytest.mark.parametrize(
    ("p", "words"),
    [
        (np.full(100, A), "falls by"),
        (np.linspace(A, -2e3, 100), "not an absolute pressure"),
        (np.linspace(A, 5e4, 15), "20 are needed"),
    ],
)
def test_what_is_no_pump_down(p, words):
    with pytest.raises(FitError, match=words):
        d.fit_pump_down(np.arange(len(p)) * 0.1, p, window=(0, None))
