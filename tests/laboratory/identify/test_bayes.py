"""The Bayesian fit against closed forms: likelihood, priors, limits, and what it says of itself."""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from counts import FULL, cases
from laboratory.campaigns import bench as virtual
from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.pull import force_at_elongation, peak, slip_at_elongation
from layerjam.core.errors import FitError, MissingExtraError
from layerjam.laboratory.figures import bayes_figures
from layerjam.laboratory.identify.bayes.fit import fit_bayes, prior_population
from layerjam.laboratory.identify.bayes.model import (
    FLOOR,
    RISE,
    SLIDE,
    CurveEstimates,
    Data,
    Guess,
    choose_start,
    log_jacobian,
    log_likelihood,
    pack_sites,
    prior_moments,
    priors,
    reduce_curves,
    unpack_sites,
)
from layerjam.laboratory.identify.bayes.posterior import BayesFit
from layerjam.laboratory.identify.bayes.predictive import peak_band, vacuum_band
from layerjam.laboratory.identify.bayes.sampler import WARMUP, evaluate_potential
from layerjam.laboratory.identify.bayes.sampler_checks import check_bayes_fit
from layerjam.laboratory.identify.curves import Curve, make_curves
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.shape import change_shape
from strategies import KAPTON, PTFE

numpyro = pytest.importorskip("numpyro")
VACUUM = 80e3
# far enough from the file's values that a fit which stays there shows
TRUTH = (0.80, 110e3, 1.3)


def pulls(
    count: int,
    seed: int = 1,
    *,
    truth: tuple[float, float, float] = TRUTH,
    scatter: float = 0.02,
    noise: float = 0.15,
    vacuum: float = VACUUM,
    speed: float = 0.013,
) -> tuple[tuple[Curve, ...], np.ndarray]:
    """Virtual pulls, each with its own factor and stiffness; and those, shape (count, 2)."""
    random = np.random.default_rng([seed, 8])
    own = np.exp(scatter * random.standard_normal((count, 2))) * truth[:2]
    machine = virtual.Machine(load_cell_noise=noise, seed=seed)
    made = []
    for repeat, (a, k) in enumerate(own, 1):
        brake = change_shape(KAPTON, float(a), float(k), truth[2])
        trace = virtual.pull(brake, vacuum, speed, 0.04, machine, repeat)
        made.append((trace, pull_features(trace), vacuum))
    return make_curves(made), own


CURVES, OWN = pulls(3)


@pytest.fixture(scope="module")
def fit() -> BayesFit:
    return fit_bayes(CURVES, KAPTON, draws=400)


def failed(found: BayesFit) -> set[str]:
    return {c.name for c in found.checks if not c.passed}


@pytest.mark.slow
def test_each_curve_and_the_sleeve_come_back(fit: BayesFit) -> None:
    own = np.median(fit.curve_scale_factor, axis=(0, 1))
    assert own == pytest.approx(OWN[:, 0], rel=1e-3)
    assert np.median(fit.curve_stiffness, axis=(0, 1)) == pytest.approx(OWN[:, 1], rel=5e-3)
    assert np.median(fit.enclosure_factor) == pytest.approx(TRUTH[2], rel=5e-3)
    assert np.abs(np.median(fit.slack, axis=(0, 1))).max() < 5e-6


@pytest.mark.slow
def test_the_brake_is_what_a_grid_says_of_three_repeats(fit: BayesFit) -> None:
    # curves are known far better than they scatter: the posterior of (ln a, ln sd) is a plain one
    y = np.log(np.median(fit.curve_scale_factor, axis=(0, 1)))
    known = priors(KAPTON)
    place = y.mean() + np.linspace(-0.25, 0.25, 1001)
    scatter = np.linspace(-9, 1, 500)
    dense = -0.5 * ((place[:, None] - known["scale_factor"].place) / known["scale_factor"].sd) ** 2
    dense = dense - 0.5 * ((scatter - known["scale_factor_sd"].place) / 2.0) ** 2
    square = ((y[:, None] - place) ** 2).sum(axis=0)[:, None]
    dense = dense - 3 * scatter - 0.5 * square * np.exp(-2 * scatter)
    share = np.exp(dense - dense.max())
    cumulated = np.cumsum(share.sum(axis=1)) / share.sum()
    for level in (0.1, 0.25, 0.5, 0.75, 0.9):
        expected = np.interp(level, cumulated, place)
        found = np.quantile(np.log(fit.scale_factor), level)
        # to a fraction of the inner half's width, as 800 draws allow
        width = np.interp(0.75, cumulated, place) - np.interp(0.25, cumulated, place)
        assert abs(found - expected) < 0.25 * width, level
    of_scatter = np.cumsum(share.sum(axis=0)) / share.sum()
    middle = np.interp(0.5, of_scatter, scatter)
    assert np.median(np.log(fit.scale_factor_sd)) == pytest.approx(middle, abs=0.15)


@pytest.mark.slow
def test_the_next_pull_scatters_more_than_the_brake(fit: BayesFit) -> None:
    rows = fit.summary()
    assert rows["next_scale_factor"].sd > 1.3 * rows["scale_factor"].sd
    assert rows["next_scale_factor"].median == pytest.approx(rows["scale_factor"].median, rel=0.01)
    spread = np.var(np.log(fit.next_pull().scale_factor))
    expected = np.var(np.log(fit.scale_factor)) + np.mean(fit.scale_factor_sd**2)
    assert spread == pytest.approx(expected, rel=0.4)


@pytest.mark.slow
def test_same_seed_same_bits_and_ctrl_c_stops(fit: BayesFit) -> None:
    told: list[tuple[int, int]] = []
    part = fit_bayes(CURVES, KAPTON, draws=100, progress=lambda *pair: told.append(pair))
    assert part.scale_factor.shape == (2, 100)
    assert (part.scale_factor == fit.scale_factor[:, :100]).all()
    assert (part.residual == fit.residual[:, :100]).all()
    assert told[0] == (50, WARMUP + 100) and told[-1] == (WARMUP + 100, WARMUP + 100)

    def stop(done: int, whole: int) -> None:
        if done >= WARMUP + 100:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit_bayes(CURVES, KAPTON, draws=400, progress=stop)


@pytest.mark.slow
def test_verdicts(fit: BayesFit) -> None:
    data = reduce_curves(CURVES)
    assert failed(fit) <= {"draws", "chains agree"}, "few draws were taken"

    def found(**change: Any) -> set[str]:
        changed = replace(fit, **change)
        return {c.name for c in check_bayes_fit(changed, CURVES, data) if not c.passed}

    assert "divergences" in found(divergences=1)
    apart = fit.scale_factor * np.array([[1.0], [1.05]])
    assert "chains agree" in found(scale_factor=apart)
    assert "plausible" in found(scale_factor=3 * fit.scale_factor)
    assert "prior" in found(scale_factor=8 * fit.scale_factor)
    assert "stiffness" in found(stiffness=10 * fit.stiffness)
    assert "repeats" in found(paths=fit.paths[:2])
    assert "repeats" in found(scale_factor_sd=20 * fit.scale_factor_sd)
    vague = np.exp(0.4 * np.random.default_rng(1).standard_normal(fit.scale_factor.shape))
    assert "identifiable" in found(enclosure_factor=vague)
    assert "trend over slip" in found(enclosure_factor=2 * fit.enclosure_factor)


@pytest.mark.slow
def test_every_check_is_a_sentence(fit: BayesFit) -> None:
    for check in fit.checks:
        assert check.sentence and check.sentence[0] != " " and "_" not in check.sentence
    assert {"identifiable", "prior", "divergences", "repeats"} <= {c.name for c in fit.checks}


@pytest.mark.slow
def test_draws_are_written(fit: BayesFit, tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    import xarray

    lines = fit.to_csv(tmp_path / "draws.csv").read_text().splitlines()
    head = [line for line in lines if line.startswith("#")]
    assert any("prior of scale_factor: 0.875" in line for line in head)
    assert any("check repeats: passed" in line for line in head)
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(table) == fit.scale_factor.size
    assert float(table[-1]["stiffness [N/m]"]) == fit.stiffness[-1, -1]
    with xarray.open_dataset(fit.to_netcdf(tmp_path / "draws.nc"), engine="scipy") as back:
        assert back["curve_scale_factor"].dims == ("chain", "draw", "curve")
        assert (back["slack"].values == fit.slack).all()


@pytest.mark.slow
def test_figures_say_what_they_show(fit: BayesFit) -> None:
    pytest.importorskip("matplotlib")
    texts = {}
    for name, figure in (
        ("posterior", bayes_figures.posterior(fit)),
        ("bands", bayes_figures.bands(fit, CURVES)),
        ("deviations", bayes_figures.deviations(fit, CURVES)),
        ("vacuum", bayes_figures.vacuum_for_force(fit, 0.02, 60.0)),
    ):
        axes = figure.axes
        texts[name] = " ".join(
            [t.get_text() for a in axes for t in a.texts]
            + [a.get_title(loc="left") + a.get_xlabel() + a.get_ylabel() for a in axes]
        )
    assert "prior" in texts["posterior"] and "kN/m" in texts["posterior"]
    assert "80 kPa, 3 curves" in texts["bands"] and "elongation [mm]" in texts["bands"]
    assert "% of the maximum force" in texts["deviations"]
    answer = vacuum_band(fit.next_pull(), 60.0, 0.02).quantile_at(0.5)[0] / 1e3
    assert f"60 N: {answer:.4g} kPa" in texts["vacuum"]


def test_reduction_keeps_the_law_and_leaves_the_onset_out() -> None:
    quiet, _ = pulls(1, noise=0.0, scatter=0.0)
    data = reduce_curves(quiet)
    brake = change_shape(KAPTON, *TRUTH)
    law = np.asarray(force_at_elongation(data.elongation, VACUUM, brake))
    assert data.real.sum() <= RISE + SLIDE
    off = np.abs(np.where(data.real, law - data.force, 0.0))
    # the sleeve's root bends within the first sliding bin: less than the floor of the residuals
    assert off.max() < FLOOR * data.height[0] and np.median(off) < 1e-4
    slip = np.asarray(slip_at_elongation(data.elongation, VACUUM, brake))
    onset = float(peak(VACUUM, 0.04, brake).slip)
    assert not (data.real & (slip > 0) & (slip < onset)).any()
    assert data.first[0, [0, RISE]].all() and data.first[0].sum() == 2 + (~data.real).sum()


def test_the_search_starts_at_the_law_of_exact_curves() -> None:
    """With the file's sleeve and no noise, each sliding part gives its own factor back."""
    quiet, own = pulls(2, noise=0.0, scatter=0.2, truth=(*TRUTH[:2], 1.0))
    start = choose_start(reduce_curves(quiet), quiet, KAPTON)
    assert np.exp(start.own_a) == pytest.approx(own[:, 0], rel=1e-5)
    assert np.exp(start.own_k) == pytest.approx(own[:, 1], rel=1e-5)


def test_without_a_measured_stiffness_half_that_of_the_stuck_sheets_is_expected() -> None:
    sheets, film = KAPTON.sheets, KAPTON.film
    left, right = np.ceil(sheets.count / 2), sheets.count // 2
    # three springs in series: the free sheets of each side, and the overlap with all sheets
    lengths = sheets.free_left / left + sheets.overlap / sheets.count + sheets.free_right / right
    own = film.modulus * sheets.width * sheets.thickness / lengths
    unmeasured = priors(replace(KAPTON, stiffness_measured=None))["stiffness"]
    assert unmeasured.center == pytest.approx(own / 2)
    assert priors(KAPTON)["stiffness"].center == pytest.approx(KAPTON.stiffness_measured)


def test_many_samples_are_not_many_measurements() -> None:
    machine = virtual.Machine(seed=1, sampling_rate=13_000.0)
    trace = virtual.pull(KAPTON, VACUUM, 0.013, 0.04, machine)
    one = make_curves([(trace, pull_features(trace), VACUUM)])
    assert len(trace) > 39_000
    assert reduce_curves(one).force.shape == (1, RISE + SLIDE)
    assert reduce_curves(one).white.max() < 0.15


def test_likelihood_is_that_of_a_correlated_normal() -> None:
    random = np.random.default_rng(3)
    rest, size, phi = random.standard_normal((2, 9)), np.array([0.5, 2.0]), 0.7
    first = np.zeros((2, 9), bool)
    first[:, [0, 4]] = True
    real = np.ones((2, 9), bool)
    real[1, 7:] = False
    data = Data(rest, rest, np.zeros((2, 9)), first, real, np.ones(2), np.ones(2))
    found = float(jax.jit(log_likelihood)(rest, size, phi, data))

    def exact(values: np.ndarray, sd: float) -> float:
        n = len(values)
        lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
        logpdf = stats.multivariate_normal(np.zeros(n), sd**2 * phi**lag).logpdf(values)
        return float(logpdf) + n / 2 * np.log(2 * np.pi)

    whole = sum(exact(rest[0, s], 0.5) for s in (slice(0, 4), slice(4, 9)))
    whole += sum(exact(rest[1, s], 2.0) for s in (slice(0, 4), slice(4, 7)))
    assert found == pytest.approx(whole, rel=1e-12)


def guessed(
    mounting: np.ndarray | None = None,
) -> tuple[np.ndarray, Guess, dict[str, tuple[float, float]]]:
    """A flat vector away from the mode, and what it is relative to."""
    mounted = mounting is not None
    first, known = (
        choose_start(reduce_curves(CURVES), CURVES, KAPTON),
        prior_moments(KAPTON, mounted),
    )
    told = (
        CurveEstimates(first.own_a, np.array([0.01, 0.02, 0.03])),
        CurveEstimates(first.own_k, np.full(3, 0.05)),
    )
    first = first._replace(log_sd_a=np.log(0.02), log_sd_k=np.log(0.04))
    if mounted:
        first = first._replace(log_mounting_sd_a=np.log(0.03), log_mounting_sd_k=np.log(0.01))
    guess = Guess(*told, mounting)
    return pack_sites(first, guess, known) + 0.3, guess, known


PAIR = np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 1]])
"""The first two curves share a mounting."""


@pytest.mark.parametrize(
    "mounting",
    [pytest.param(None, marks=pytest.mark.slow), PAIR],
    ids=["alone", "mounted"],
)
def test_flat_vector_and_its_stretch(mounting: np.ndarray | None) -> None:
    flat, guess, known = guessed(mounting)
    sites = jax.tree.map(np.asarray, unpack_sites(flat, guess, known))
    assert pack_sites(sites, guess, known) == pytest.approx(flat, abs=1e-9)

    def natural(v: Any) -> Any:
        there = [x for x in unpack_sites(v, guess, known) if x is not None]
        return jnp.concatenate([jnp.atleast_1d(x) for x in there])

    _, size = np.linalg.slogdet(np.asarray(jax.jit(jax.jacfwd(natural))(flat)))
    assert size == pytest.approx(float(log_jacobian(flat, guess, known)), rel=1e-9)


def test_flat_vector_is_standard_where_errors_are_normal() -> None:
    """At a scatter, unit normals become what a linear normal hierarchy gives in closed form."""
    flat, guess, known = guessed()
    scatter, (center, sd) = float(np.exp(flat[3])), known["scale_factor"]
    # precision of (ln a, ln a_1, ..., ln a_3): prior, hierarchy, and what the curves tell
    precision, push = np.zeros((4, 4)), np.zeros(4)
    precision[0, 0], push[0] = sd**-2 + 3 * scatter**-2, center * sd**-2
    for i in range(3):
        weight = guess.a.error[i] ** -2
        precision[i + 1, i + 1], push[i + 1] = scatter**-2 + weight, guess.a.place[i] * weight
        precision[0, i + 1] = precision[i + 1, 0] = -(scatter**-2)

    def natural(v: Any) -> Any:
        sites = unpack_sites(v, guess, known)
        return jnp.concatenate([jnp.atleast_1d(sites.log_a), sites.own_a])

    zero = np.where(np.arange(len(flat)) == 3, flat[3], 0.0)
    unit = np.delete(np.asarray(jax.jit(jax.jacfwd(natural))(zero)), 3, axis=1)
    exact = np.linalg.inv(precision)
    assert np.asarray(natural(zero)) == pytest.approx(exact @ push, rel=1e-9)
    assert unit @ unit.T == pytest.approx(exact, rel=1e-9, abs=1e-15)


def test_gradient_also_where_a_bin_lies_on_the_onset() -> None:
    data = Data(*map(jnp.asarray, reduce_curves(CURVES)))
    flat, guess, known = guessed()
    sites = unpack_sites(flat, guess, known)
    brake = change_shape(
        KAPTON, *(float(np.exp(x)) for x in (sites.own_a[0], sites.own_k[0], sites.log_f))
    )
    c = float(sheet_friction(0.0, VACUUM, brake))
    place = c / float(np.exp(sites.own_k[0])) + 1e-4 * float(sites.own_slack[0])
    data = data._replace(elongation=data.elongation.at[0, RISE].set(place))
    steps = 1e-6 * np.eye(len(flat))
    points = np.concatenate([flat[None], flat + steps, flat - steps])
    value, slope = evaluate_potential(points, guess, data, KAPTON, known)
    assert np.isfinite(slope[0]).all()
    found = (value[1 : 1 + len(flat)] - value[1 + len(flat) :]) / 2e-6
    assert slope[0] == pytest.approx(found, rel=2e-4, abs=2e-2)


@pytest.mark.parametrize("brake", [KAPTON, PTFE, replace(KAPTON, stiffness_measured=None)])
def test_priors_allow_what_brakes_do_and_not_much_else(brake: Brake) -> None:
    of = prior_population(brake, 4000)
    force = peak_band(of, 94.5e3, levels=(0.025, 0.5, 0.975))
    nominal = float(peak(94.5e3, 0.06, brake).force)
    low, middle, high = force.values[:, 0]
    # a handbook's friction is twice the paper's: possible; ten times it is not
    assert low < nominal / 2 and nominal * 2 < high < nominal * 5
    assert middle == pytest.approx(nominal, rel=0.1)
    assert np.quantile(of.stiffness, 0.001) > 20 * float(peak(94.5e3, 0.06, brake).force)
    # the caption's stiffness of Fig. 8 is nothing special
    rank = (of.stiffness < (107e3 if brake.film.kinetic > 0.1 else 42e3)).mean()
    assert 0.05 < rank < 0.95


def test_bad_curves_are_named() -> None:
    with pytest.raises(FitError, match="no curve"):
        fit_bayes([], KAPTON)
    with pytest.raises(FitError, match="jams no sheet"):
        fit_bayes([replace(CURVES[0], vacuum=0.0)], KAPTON)
    with pytest.raises(FitError, match="chains: 0"):
        fit_bayes(CURVES, KAPTON, chains=0)
    short = CURVES[0].elongation < 2.0e-3
    cut = replace(CURVES[0], elongation=CURVES[0].elongation[short], force=CURVES[0].force[short])
    late = replace(cut, elongation=cut.elongation[:125], force=cut.force[:125])
    with pytest.raises(FitError, match="pull further"):
        fit_bayes([late], KAPTON)


def test_without_numpyro(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numpyro", None)
    with pytest.raises(MissingExtraError, match=r"\[bayes\]"):
        fit_bayes(CURVES, KAPTON)


@pytest.mark.campaign
def test_many_repeats_meet_the_plain_mean() -> None:
    curves, own = pulls(24, 5, scatter=0.03)
    found = fit_bayes(curves, KAPTON, draws=cases(1000, 500))
    logs = np.log(own[:, 0])
    row = np.log(found.scale_factor)
    error = logs.std(ddof=1) / 24**0.5
    assert row.mean() == pytest.approx(logs.mean(), abs=0.15 * error)
    assert row.std() == pytest.approx(error, rel=0.15)
    assert np.median(found.scale_factor_sd) == pytest.approx(logs.std(ddof=1), rel=0.15)
    assert found.is_trusted, [c.sentence for c in found.checks if not c.passed]


@pytest.mark.campaign
@pytest.mark.parametrize("vacuum", [94.5e3, 5e3, 1.5e3])
def test_one_curve_at_any_vacuum(vacuum: float) -> None:
    curves, own = pulls(1, 1, vacuum=vacuum, noise=0.02, speed=1.3e-3)
    found = fit_bayes(curves, KAPTON, draws=1000)
    low, high = np.quantile(found.curve_scale_factor, [0.001, 0.999])
    assert low < own[0, 0] < high
    assert "repeats" in failed(found)


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.01, 0.03] if FULL else [0.03])
def test_intervals_of_three_repeats_contain_the_truth(scatter: float) -> None:
    """90 % intervals: the bounds are where a binomial of 0.9 goes in one case of two hundred."""
    ranks = []
    for seed in range(count := cases(40, 16)):
        random = np.random.default_rng([11, seed])
        draw = np.exp(random.standard_normal(3) * (0.2, 0.3, 0.3))
        truth = (0.875 * draw[0], 131e3 * draw[1], draw[2])
        curves, _ = pulls(3, 100 + seed, truth=truth, scatter=scatter)
        found = fit_bayes(curves, KAPTON, draws=cases(1000, 400))
        own = change_shape(
            KAPTON, truth[0] * np.exp(scatter * random.standard_normal()), *truth[1:]
        )
        after = np.asarray(peak(VACUUM, 0.06, found.next_pull().brakes()).force)
        ranks.append([
            (found.scale_factor < truth[0]).mean(), (found.stiffness < truth[1]).mean(),
            (found.enclosure_factor < truth[2]).mean(),
            (after < float(peak(VACUUM, 0.06, own).force)).mean(),
        ])  # fmt: skip
    inside = ((np.array(ranks) > 0.05) & (np.array(ranks) < 0.95)).sum(axis=0)
    assert (inside >= cases(31, 11)).all(), inside
    halves = (np.array(ranks) < 0.5).sum(axis=0)
    assert (np.abs(halves - count / 2) <= cases(11, 6)).all(), halves
