"""Curves that share a mounting, in the Bayesian fit: against scipy's densities and a grid."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from laboratory.campaigns import bench as virtual
from laboratory.identify.test_bayes import CURVES, PAIR, TRUTH, VACUUM, guessed
from layerjam.laboratory.identify.bayes.fit import fit_bayes
from layerjam.laboratory.identify.bayes.model import (
    Data,
    log_jacobian,
    pack_sites,
    potential,
    priors,
    reduce_curves,
    unpack_sites,
)
from layerjam.laboratory.identify.curves import make_curves
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.shape import change_shape
from strategies import KAPTON

pytest.importorskip("numpyro")


@pytest.mark.slow
def test_curves_of_one_mounting_are_correlated() -> None:
    """The potential's change with the curves' own values is that of scipy's normal density."""
    flat, guess, known = guessed(PAIR)
    data = Data(*map(jnp.asarray, reduce_curves(CURVES)))
    sites = jax.tree.map(np.asarray, unpack_sites(flat, guess, known))

    def density(own: np.ndarray, mounting: np.ndarray | None) -> float:
        moved = pack_sites(sites._replace(own_a=own), guess._replace(mounting=PAIR), known)
        there = guess._replace(mounting=mounting)
        if mounting is None:  # the same place in the unknowns of the other model
            bare = sites._replace(own_a=own, log_mounting_sd_a=None, log_mounting_sd_k=None)
            moved = pack_sites(bare, there, known)
        stretch = float(log_jacobian(moved, there, known))
        return -float(potential(moved, there, data, KAPTON, known)) - stretch

    here, there = sites.own_a, sites.own_a + np.array([0.01, -0.02, 0.005])
    own, shared = np.exp(2 * sites.log_sd_a), np.exp(2 * sites.log_mounting_sd_a)
    mean = np.full(3, sites.log_a)
    change = [
        stats.multivariate_normal(mean, own * np.eye(3) + shared * PAIR).logpdf(x)
        - stats.norm(mean, np.sqrt(own)).logpdf(x).sum()
        for x in (there, here)
    ]
    found = [density(x, PAIR) - density(x, None) for x in (there, here)]
    assert found[0] - found[1] == pytest.approx(change[0] - change[1], rel=1e-6, abs=1e-6)


@pytest.mark.campaign
def test_mountings_widen_the_posterior_as_a_grid_says() -> None:
    """Three mountings of two pulls that hardly differ: about Student's t of three means."""
    random = np.random.default_rng(3)
    own = np.repeat(TRUTH[0] * np.exp(0.03 * random.standard_normal(3)), 2)
    machine = virtual.Machine(load_cell_noise=0.05)
    made = []
    for a in own:
        trace = virtual.pull(change_shape(KAPTON, a, *TRUTH[1:]), VACUUM, 0.013, 0.04, machine)
        made.append((trace, pull_features(trace), VACUUM))
    curves, groups = make_curves(made), [(0, 1), (2, 3), (4, 5)]
    found = fit_bayes(curves, KAPTON, draws=500, mountings=groups)
    y = np.log(np.median(found.curve_scale_factor, axis=(0, 1))).reshape(3, 2)
    prior = priors(KAPTON, True)
    place = (y.mean() + np.linspace(-0.3, 0.3, 401))[:, None, None]
    inner, outer = np.linspace(-11, 0, 111)[:, None], np.linspace(-11, 0, 111)
    log = -0.5 * ((place - prior["scale_factor"].place) / prior["scale_factor"].sd) ** 2
    for scatter in (inner, outer):
        log = log - 0.5 * ((scatter - prior["scale_factor_sd"].place) / 2.0) ** 2
    own_square, both = np.exp(2 * inner), np.exp(2 * inner) + 2 * np.exp(2 * outer)
    within = float(((y - y.mean(axis=1, keepdims=True)) ** 2).sum())
    between = sum(2 * (mean - place) ** 2 for mean in y.mean(axis=1))
    log = log - 1.5 * np.log(own_square) - 1.5 * np.log(both)
    log = log - 0.5 * within / own_square - 0.5 * between / both
    share = np.exp(log - log.max()).sum(axis=(1, 2))
    cumulated = np.cumsum(share) / share.sum()
    expected = [np.interp(level, cumulated, place[:, 0, 0]) for level in (0.1, 0.5, 0.9)]
    quantiles = np.quantile(np.log(found.scale_factor), (0.1, 0.5, 0.9))
    assert quantiles == pytest.approx(expected, abs=0.2 * (expected[2] - expected[0]))
    alone = fit_bayes(curves, KAPTON, draws=500)
    assert np.log(found.scale_factor).std() > 1.4 * np.log(alone.scale_factor).std()
