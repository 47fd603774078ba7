"""Bayesian calibration over many pulls: a hierarchical model, sampled by NUTS (NumPyro).

`fit_bayes` has two results. The population describes the brake: the median of its scale factors and
stiffnesses. The next pull is one further pull, which scatters about the brake.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.errors import FitError, MissingExtraError, count_text
from layerjam.core.evolve import evolve
from layerjam.laboratory.identify.bayes.model import (
    choose_start,
    prior_moments,
    priors,
    reduce_curves,
)
from layerjam.laboratory.identify.bayes.posterior import BayesFit, Population, Posterior
from layerjam.laboratory.identify.bayes.sampler_checks import check_bayes_fit
from layerjam.laboratory.identify.calibration.budget import fitted_enclosure_line, scatter_line
from layerjam.laboratory.identify.calibration.common import (
    check_zero,
    combine_common,
    describe_basis,
    list_common_lines,
)
from layerjam.laboratory.identify.calibration.intervals import Interval
from layerjam.laboratory.identify.calibration.mountings import find_mountings
from layerjam.laboratory.identify.calibration.peaks import (
    calibrate_at_peaks,
    fit_curves,
    make_pull_table,
    scale_enclosure,
    stack_logarithms,
)
from layerjam.laboratory.identify.calibration.result import Calibration, make_shape_sources
from layerjam.laboratory.identify.calibration.whole_curves import WINDOW
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import check_enclosure, check_intervals
from layerjam.laboratory.identify.pull_checks import check_single_pulls
from layerjam.laboratory.identify.shape import SHAPE

Array = np.ndarray[Any, Any]


def prior_population(brake: Brake, draws: int = 1000, seed: int = 1) -> Population:
    """Return brakes drawn from the priors alone: the model's prediction before any pull."""
    random, prior_of = np.random.default_rng(seed), priors(brake)

    def draw_prior(name: str) -> Array:
        prior = prior_of[name]
        return np.exp(prior.place + prior.sd * random.standard_normal(draws))

    names = ("scale_factor", "stiffness", "enclosure_factor", "residual")
    return Population(brake=brake, **{name: draw_prior(name) for name in names})


def fit_bayes(
    curves: Sequence[Curve],
    brake: Brake,
    *,
    draws: int = 1000,
    chains: int = 2,
    seed: int = 1,
    mountings: Sequence[Sequence[int]] = (),
    progress: Callable[[int, int], None] | None = None,
) -> BayesFit:
    """Calibrate on curves: posterior of the scale factor, stiffness and enclosure factor.

    `draws` is the number per chain, after 300 draws for adaptation. `mountings` lists the indices
    of the curves of each mounting; these curves share its scatter. `progress` is called with (done,
    total), both per chain. The same seed produces bit-identical draws. Raises FitError for an
    unusable curve, MissingExtraError if NumPyro is not installed, PrecisionError if JAX is in
    single precision.
    """
    with MissingExtraError.raise_if_missing("Bayesian calibration (numpyro)", "bayes"):
        import numpyro  # type: ignore[import-untyped]  # noqa: F401
    from layerjam.laboratory.identify.bayes.sampler import sample_posterior

    if not curves:
        raise FitError("fit_bayes: no curve was given")
    for name, value, minimum in (("draws", draws, 4), ("chains", chains, 1)):
        if value < minimum:
            raise FitError(f"{name}: {value} is not allowed; it must be at least {minimum}")
    mounting = _mounting_matrix(mountings, len(curves))
    data, beliefs = reduce_curves(curves), prior_moments(brake, mounting is not None)
    sites, divergent = sample_posterior(
        choose_start(data, curves, brake),
        data,
        brake,
        beliefs,
        draws=draws,
        chains=chains,
        seed=seed,
        mounting=mounting,
        progress=progress,
    )
    mounted = sites.log_mounting_sd_a is not None
    prior_of = priors(brake, mounted)
    fit = BayesFit(
        synthetic=any(curve.synthetic for curve in curves),
        brake=brake,
        paths=tuple(c.path for c in curves),
        vacuum=tuple(c.vacuum for c in curves),
        scale_factor=np.exp(sites.log_a),
        stiffness=np.exp(sites.log_k),
        enclosure_factor=np.exp(sites.log_f),
        scale_factor_sd=np.exp(sites.log_sd_a),
        stiffness_sd=np.exp(sites.log_sd_k),
        correlation=1 / (1 + np.exp(-sites.logit)),
        curve_scale_factor=np.exp(sites.own_a),
        curve_stiffness=np.exp(sites.own_k),
        slack=prior_of["slack"].sd * sites.own_slack,
        residual=np.exp(sites.own_noise),
        scale_factor_mounting_sd=np.exp(sites.log_mounting_sd_a) if mounted else None,
        stiffness_mounting_sd=np.exp(sites.log_mounting_sd_k) if mounted else None,
        divergences=int(divergent.sum()),
        seed=seed,
        priors=prior_of,
    )
    return evolve(fit, checks=check_bayes_fit(fit, curves, data))


def _mounting_matrix(mountings: Sequence[Sequence[int]], count: int) -> Array | None:
    """Return whether each pair of `count` curves shares a mounting; None if no pair does."""
    if all(len(group) < 2 for group in mountings):
        return None
    member = np.zeros((len(mountings), count))
    for number, group in enumerate(mountings):
        member[number, list(group)] = 1.0
    return np.asarray(member.T @ member)


def calibrate_bayesian(
    curves: Sequence[Curve],
    brake: Brake,
    sampling: tuple[int, int, int],
    tell: Callable[[str, float], None],
) -> Calibration:
    """Return the posterior in the format of the other methods: means, SDs, 95 % intervals.

    `sampling` is (draws per chain, chains, seed). Raises the same errors as `fit_bayes`.
    """
    draws, chains, seed = sampling
    single_fits = fit_curves(curves, brake)
    mounting = find_mountings(curves, stack_logarithms(single_fits))
    fit = fit_bayes(
        curves,
        brake,
        draws=draws,
        chains=chains,
        seed=seed,
        mountings=mounting.groups,
        progress=lambda done, of: tell("sampling", done / of),
    )
    summary, count = fit.summary(), len(curves)
    rows = {name: summary[name] for name in SHAPE}
    values = {name: row.mean for name, row in rows.items()}
    errors = {name: row.sd for name, row in rows.items()}
    text = f"mean of the Bayesian posterior over {count} whole pulls"
    pulls = make_pull_table(
        curves, *scale_enclosure(single_fits, brake, values["enclosure_factor"])
    )
    shared_lines = (fitted_enclosure_line(), *list_common_lines(curves, brake, mounting))
    common = combine_common(shared_lines, mounting)
    intervals = {name: _widen_interval(row, common[name]) for name, row in rows.items()}
    a = "scale_factor"
    half_width = intervals[a].half_width / values[a]
    spread = (errors[a], float("inf"))
    enclosure = values["enclosure_factor"], errors["enclosure_factor"]
    errors = {name: interval.standard_error for name, interval in intervals.items()}
    repeats = scatter_line(spread, values[a], "standard deviation of the posterior")
    return Calibration(
        values=values,
        standard_errors=errors,
        errors_rest_on=describe_basis(
            f"the posterior over {count_text(count, 'pull')}", shared_lines
        ),
        intervals=intervals,
        contributions=(repeats, *shared_lines),
        common_errors=common,
        mountings=mounting.groups,
        covariance=_shape_covariance(fit, errors),
        **calibrate_at_peaks(single_fits),
        pulls=pulls,
        checks=(
            *fit.checks,
            mounting.check,
            check_zero(curves),
            check_enclosure(*enclosure, brake.enclosure.force_sd),
            *check_intervals(values, intervals),
            *check_single_pulls(pulls, half_width),
        ),
        curves=tuple(curves),
        sources=make_shape_sources(brake, values, errors, text, "standard deviation"),
        window=WINDOW,
        posterior={name: row._asdict() for name, row in summary.items()},
        fit=fit,
    )


def _widen_interval(row: Posterior, common: float) -> Interval:
    """Return the central interval of a posterior, widened by a `common` relative uncertainty."""
    part = (row.high - row.low) / 2 / row.sd
    wider = math.hypot(1.0, common * row.mean / row.sd)
    return Interval(
        low=row.mean - wider * (row.mean - row.low),
        high=row.mean + wider * (row.high - row.mean),
        standard_error=wider * row.sd,
        degrees_of_freedom=float("inf"),
        coverage_factor=part,
        method="Bayesian posterior, central 95 %",
    )


def _shape_covariance(fit: BayesFit, errors: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return the posterior's covariance, with the squares of `errors` on its diagonal."""
    matrix = np.cov([np.ravel(getattr(fit, name)) for name in SHAPE])
    np.fill_diagonal(matrix, [errors[name] ** 2 for name in SHAPE])
    return {
        first: dict(zip(SHAPE, map(float, row), strict=True))
        for first, row in zip(SHAPE, matrix, strict=True)
    }
