"""Leaks: closed forms against a stepwise integration, truth within the interval, real holds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from counts import cases
from laboratory.measure.layouts import REAL
from layerjam.core.errors import FitError, UnknownNameError
from layerjam.laboratory.identify.logs import leak as k
from layerjam.laboratory.identify.logs.correlated import fit_series
from layerjam.laboratory.measure.log import PRESSURE, TIME, read_log
from layerjam.laboratory.measure.options import ReadingOptions

A = 101325.0


@pytest.mark.parametrize("model", k.MODELS)
@pytest.mark.parametrize("start", [8e5, 1.5e5, 1.03e5, 9e4, 3e4, 2e3])
def test_closed_forms_solve_their_equation(model, start):
    """dp/dt = -q/V; 3 of the unit C/V = 0.4 takes an orifice through its choked range and out."""
    t, rate = np.linspace(0, 3, 40), 0.4
    made = solve_ivp(
        lambda _, p: [-k.flow(model, p[0], rate, A)], (0, 3), [start], t_eval=t, rtol=1e-9,
        atol=1e-4, max_step=0.02,
    )  # fmt: skip
    np.testing.assert_allclose(k.pressure(model, t, start, rate, A), made.y[0], atol=0.05)


@pytest.mark.parametrize("model", ["linear", "laminar"])
def test_small_differences_decay_with_v_over_c(model):
    t = np.linspace(0, 5, 20)
    for start in (A + 10, A - 10):
        made = k.pressure(model, t, start, 0.7, A) - A
        np.testing.assert_allclose(made, (start - A) * np.exp(-0.7 * t), rtol=2e-4)


def test_an_orifice_is_choked_far_off_and_a_root_near_the_atmosphere():
    assert k.flow("orifice", 9e5, 2.0, A) == pytest.approx(2.0 * 9e5)
    assert k.flow("orifice", 1e4, 2.0, A) == pytest.approx(-2.0 * A)
    near = k.flow("orifice", A + 4.0, 1.0, A) / k.flow("orifice", A + 1.0, 1.0, A)
    assert near == pytest.approx(2.0, rel=1e-3)  # four times the difference, twice the flow
    end = k.pressure("orifice", np.array([1e3]), 5e4, 1.0, A)
    assert end[0] == A  # it gets there in finite time and stays


@settings(max_examples=40, deadline=None)
@given(
    model=st.sampled_from(k.MODELS), start=st.floats(1e3, 1e6), rate=st.floats(1e-6, 10),
    factor=st.floats(1e-3, 1e3),
)  # fmt: skip
def test_dimensions_and_direction(model, start, rate, factor):
    """Another unit of time or pressure changes nothing; it ends at the atmosphere."""
    t = np.linspace(0, 3 / rate, 30)
    p = k.pressure(model, t, start, rate, A)
    np.testing.assert_allclose(k.pressure(model, t * factor, start, rate / factor, A), p, rtol=1e-6)
    scaled = k.pressure(model, t, start * factor, rate, A * factor)
    np.testing.assert_allclose(scaled, p * factor, rtol=1e-6)
    gap = np.abs(p - A)
    assert np.all(np.diff(gap) <= 1e-6 * A)
    assert np.all((p - A) * (start - A) >= -1e-3)


def wander(rng, count, spread, keep=0.98):
    """White noise and a wander of the first order, [Pa]."""
    made = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.normal(0, spread, count))
    return rng.normal(0, spread, count) + made


@pytest.mark.parametrize("start", [8e5, 6.8e3])
@pytest.mark.parametrize("model", k.MODELS)
def test_truth_lies_in_the_interval_and_the_law_is_recognised(model, start):
    rng = np.random.default_rng(11)
    t = np.arange(0, 60, 0.05)
    clean = k.pressure(model, t, start, 0.05, A)
    found = k.fit_leak(t, clean + wander(rng, len(t), 60.0), window=(0, None))
    assert found.best == model and found.distinct
    low, high = found.fits[model].series.interval(lambda v: float(v[1]))
    assert low < 0.05 < high
    assert high - low < 0.01


@pytest.mark.parametrize("start", [3e5, 3e4])
def test_a_hold_begins_where_the_pressure_differs_most_from_the_atmosphere(start: float) -> None:
    """5 s of filling or pumping at a constant rate, then a leak: only the leak is fitted."""
    t = np.arange(0, 30, 0.05)
    leak = k.pressure("linear", np.maximum(t - 5, 0), start, 0.05, A)
    log = k.fit_leak(t, np.where(t < 5, A + (start - A) * t / 5, leak))
    assert log.window == (5.0, t[-1])
    assert log.fits["linear"].rate == pytest.approx(0.05, rel=1e-6)
    assert log.fits["linear"].start == pytest.approx(start, rel=1e-6)
    assert any("earlier samples are not used" in w for w in log.warnings)


@pytest.mark.slow
def test_coverage_of_the_interval_with_wandering_noise():
    rng = np.random.default_rng(5)
    t = np.arange(0, 30, 0.05)
    clean = k.pressure("linear", t, 3e4, 0.05, A)
    hits = 0
    for _ in range(count := cases(120, 50)):
        fit = k.fit_leak(t, clean + wander(rng, len(t), 100.0), window=(0, None)).fits["linear"]
        low, high = fit.series.interval(lambda v: float(v[1]))
        hits += low < 0.05 < high
    assert hits >= 0.92 * count


def test_correlated_noise_widens_the_interval():
    """The mean of a wander has (1 + ρ)/(1 - ρ) times the variance of white noise."""
    rng = np.random.default_rng(2)
    count, keep = 3000, 0.95
    white = rng.normal(0, 1, count)
    slow = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.normal(0, 1, count))
    errors = []
    for values in (white, slow):
        found = fit_series(lambda v: np.full(count, v[0]), values, [0.0], [1.0])
        errors.append(found.standard_errors[0])
    # never too small; too large by up to three where a slow wander cannot be ruled out
    assert 0.9 < errors[0] * np.sqrt(count) < 4
    assert 0.8 < errors[1] * np.sqrt(count * (1 - keep) / (1 + keep)) < 3


def test_a_short_hold_tells_the_leak_but_not_the_law():
    rng = np.random.default_rng(3)
    t = np.arange(0, 60, 0.1)
    p = k.pressure("laminar", t, 5e4, 1e-4, A) + rng.normal(0, 20, len(t))
    found = k.fit_leak(t, p, window=(0, None))
    assert not found.distinct
    due = k.flow("laminar", found.mean, 1e-4, A)
    for fit in found.fits.values():
        value, low, high = fit.flow_interval(found.mean, A)
        assert low < due < high
        assert value == pytest.approx(due, rel=0.05)
    full = [k.flow(m, 0.0, f.rate, A) for m, f in found.fits.items()]
    assert max(full) / min(full) < 0.8  # what they say elsewhere differs


def test_temperature_is_taken_out_where_it_is_known():
    rng = np.random.default_rng(6)
    t = np.arange(0, 300, 0.5)
    warm = 293.0 + 2.0 * np.exp(-t / 60)
    p = k.pressure("linear", t, 3e5, 1e-5, A) * warm / warm.mean() + rng.normal(0, 20, len(t))
    blind = k.fit_leak(t, p, window=(0, None))
    seeing = k.fit_leak(t, p, window=(0, None), temperature=warm)
    assert seeing.fits["linear"].rate == pytest.approx(1e-5, rel=0.1)
    assert blind.fits["linear"].rate > 1.5e-5
    assert blind.heat == pytest.approx(293 * (p[-15:].mean() / p[:15].mean() - 1), rel=0.1)


def test_the_sensor_zero_is_fitted_where_the_record_shows_it():
    t = np.arange(0, 60, 0.05)
    p = k.pressure("linear", t, 4e5, 0.2, A) + 2500 + np.random.default_rng(1).normal(0, 50, len(t))
    found = k.fit_leak(t, p, window=(0, None))
    assert found.fits["linear"].zero == pytest.approx(2500, abs=30)
    assert any("zero is fitted" in w for w in found.warnings)


@pytest.mark.parametrize(
    ("p", "window", "words"),
    [
        (np.full(100, A), (0, None), "from atmospheric pressure"),
        (np.linspace(1.5e5, 0.5e5, 100), (0, None), "crosses atmospheric"),
        (
            np.linspace(1.5e5, 1.4e5, 100),
            (0.0, 0.5),
            "only 6 samples lie between 0 s and 0.5 s; a hold needs 20",
        ),
    ],
)
def test_what_is_no_hold(p, window, words):
    with pytest.raises(FitError, match=words):
        k.fit_leak(np.arange(100) * 0.1, p, window=window)


def test_a_fall_within_one_section_of_the_fit_is_rejected() -> None:
    t = np.arange(3001) * 0.01
    p = k.pressure("linear", t, 3e4, 80.0, A)
    # 150 sections of 0.2 s: after the first, exp(-16) of the difference is left
    with pytest.raises(FitError, match=r"first of 150 sections .*\(0\.2 s\): end the window"):
        k.fit_leak(t, p, atmosphere=A)
    fit = k.fit_leak(t, p, atmosphere=A, window=(0.0, 1.0)).fits["linear"]
    assert fit.rate == pytest.approx(80.0, rel=1e-6)


def test_sccm_by_its_definition():
    assert k.to_sccm(101325e-6 / 60, 273.15) == pytest.approx(1.0)
    assert k.to_sccm(101325e-6 / 60, 2 * 273.15) == pytest.approx(0.5)
    with pytest.raises(UnknownNameError):
        k.flow("molecular", 1e5, 1.0, A)


HOLDS = REAL / "pneumatic_friction_leak"


@pytest.mark.skipif(not HOLDS.is_dir(), reason="no real files here")
def test_real_holds_are_told_apart():
    rates = {}
    said = ReadingOptions(columns="time:ms,skip,pressure:bar")
    for name in ("Aluminium", "Prusa", "Ultimaker_020"):
        log = read_log(HOLDS / f"airchamber_{name}.csv", (TIME, PRESSURE), said)
        start = 5.0 if name == "Ultimaker_020" else None  # the fall begins there
        found = k.fit_leak(log["time"], log["pressure"] + A, window=(start, None))
        rates[name] = found.fits["linear"].rate
        if name != "Ultimaker_020":
            assert not found.distinct
            assert -5 < found.heat < 0
    assert rates["Aluminium"] < rates["Prusa"] < 1e-3 < rates["Ultimaker_020"]
    # by hand: 7.315 to 7.284 bar in 150 s, and 7.646 to 7.548 bar in 143 s, of gauge pressure
    assert rates["Aluminium"] == pytest.approx(np.log(7.315 / 7.284) / 150, rel=0.35)
    assert rates["Prusa"] == pytest.approx(np.log(7.646 / 7.548) / 143, rel=0.15)
