"""Checks of a Bayesian fit: first the sampler, then the model."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.verdict import Level
from layerjam.laboratory.identify.bayes.model import Data, Sites, law_forces
from layerjam.laboratory.identify.bayes.posterior import BayesFit, chain_agreement
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import (
    GROSS,
    Check,
    check,
    check_no_trend,
    check_plausibility,
    check_stiffness,
)
from layerjam.laboratory.identify.shape import SHAPE

R_HAT = 1.01
"""R-hat above which the chains do not agree."""
FAR_APART = 1.1
"""R-hat above which the result depends on a chain's start (Gelman and Rubin 1992)."""
ESS = 400
"""Minimum effective number of draws for reliable ends of a 90 % interval."""
NARROWED = 0.5
"""Ratio of posterior width to prior width above which the data add little information."""
PRIOR_DISTANCE = 2.5
"""Largest acceptable distance of a posterior from its prior's centre, in prior SDs."""
BENT = 0.02
"""Largest acceptable mean residual of a section, relative to the maximum force."""
REPEATS = 3
Array = np.ndarray[Any, Any]


def check_bayes_fit(fit: BayesFit, curves: Sequence[Curve], data: Data) -> tuple[Check, ...]:
    """Return all checks of a Bayesian fit."""
    factor, stiffness = float(np.median(fit.scale_factor)), float(np.median(fit.stiffness))
    factors = np.median(fit.curve_scale_factor, axis=(0, 1))
    speeds = [c.speed for c in curves]
    checks = [
        _check_convergence(fit),
        _check_divergences(fit),
        _check_draws(fit),
        _check_repeats(fit),
        _check_identifiability(fit),
        _check_prior(fit),
        check_plausibility(factor),
        check_stiffness(stiffness, float(stiffness_before_slip(fit.brake))),
        check_no_trend(factors.tolist(), fit.vacuum, "vacuum", "Pa"),
        check_no_trend(factors.tolist(), [s for s in speeds if s is not None], "speed", "m/s")
        if None not in speeds
        else None,
        _check_slip_residuals(fit, data),
    ]
    return tuple(c for c in checks if c is not None)


def _stack_unknowns(fit: BayesFit) -> dict[str, Array]:
    """Return the draws of every unknown, each an array of shape (chains, draws)."""
    out = {}
    for name, (draws, _) in fit.columns().items():
        if draws.ndim == 2:
            out[name] = draws
        else:
            out |= {f"{name} of curve {i + 1}": draws[..., i] for i in range(draws.shape[-1])}
    return out


def _check_convergence(fit: BayesFit) -> Check:
    # the strict bound applies to values used in predictions; some of the others exceed it by chance
    hats = {n: chain_agreement(v)[0] for n, v in _stack_unknowns(fit).items()}
    worst = max((n for n in hats if "curve" not in n), key=lambda n: hats[n])
    worst_curve = max((n for n in hats if "curve" in n), key=lambda n: hats[n])
    strict, loose = hats[worst] <= R_HAT, hats[worst_curve] <= 1 + 3 * (R_HAT - 1)
    name = worst_curve if strict and not loose else worst
    value, word = hats[name], name.replace("_", " ")
    sentence = f"R-hat is at most {value:.4f} ({word}); chains agree below {R_HAT}"
    if not (strict and loose):
        sentence = f"R-hat is {value:.4f} for {word}: the chains do not agree; use more draws"
    level: Level = "failed" if hats[worst] > FAR_APART else "warning"
    return check("chains agree", strict and loose, sentence, level=level)


def _check_divergences(fit: BayesFit) -> Check:
    count, draws = fit.divergences, fit.scale_factor.size
    risk = ": part of the posterior may not have been reached, and intervals may be too narrow"
    return check("divergences", count == 0, f"{count} of {draws} draws diverged", risk)


def _check_draws(fit: BayesFit) -> Check:
    sizes = {n: chain_agreement(getattr(fit, n))[1] for n in (*SHAPE, "scale_factor_sd")}
    worst_name = min(sizes, key=lambda n: sizes[n])
    sentence = f"the effective sample size is at least {sizes[worst_name]:.0f}"
    advice = f" ({worst_name.replace('_', ' ')}); an interval needs {ESS}, so use more draws"
    return check("draws", sizes[worst_name] >= ESS, sentence, advice)


def _check_repeats(fit: BayesFit) -> Check:
    count = len(fit.paths)
    scatter = float(np.median(fit.scatter("scale_factor")))
    if count < REPEATS:
        word = "one curve reveals" if count == 1 else f"{count} curves reveal"
        sentence = (
            f"{word} almost nothing about the scatter between repeats: the intervals rest "
            f"on its prior ({fit.priors['scale_factor_sd'].text()})"
        )
        return check("repeats", False, sentence)
    sentence = f"scale factors of {count} curves scatter by {scatter:.1%}"
    cause = ": more than films usually do; one curve may be from a different brake or vacuum"
    level: Level = "failed" if scatter > GROSS else "warning"
    return check("repeats", scatter < 0.15, sentence, cause, level)


def _check_identifiability(fit: BayesFit) -> Check:
    widths = {n: float(np.log(getattr(fit, n)).std() / fit.priors[n].sd) for n in SHAPE}
    logs = [np.log(v).ravel() for v in (fit.scale_factor, fit.enclosure_factor)]
    together = float(np.corrcoef(logs[0], logs[1])[0, 1])
    vague = [n.replace("_", " ") for n in SHAPE if widths[n] > NARROWED]
    parts = ", ".join(f"{n.replace('_', ' ')} {widths[n]:.1%}" for n in SHAPE)
    sentence = (
        f"posterior width relative to the prior: {parts}; scale factor and enclosure have "
        f"a correlation of {together:+.2f}; only the products of scale factor and kinetic "
        f"friction ({fit.brake.film.kinetic:.4g}) and of the enclosure's modulus and "
        "friction are determined"
    )
    little = f"; the curves reveal little about {' and '.join(vague)}: the prior determines it"
    return check("identifiable", not vague, sentence, little)


def _check_prior(fit: BayesFit) -> Check:
    distance = {
        n: (float(np.log(np.median(getattr(fit, n)))) - fit.priors[n].place) / fit.priors[n].sd
        for n in SHAPE
    }
    worst = max(distance, key=lambda n: abs(distance[n]))
    sentence = (
        f"{worst.replace('_', ' ')} is {distance[worst]:+.2g} prior SDs from the prior's centre"
    )
    cause = ": the brake that was pulled is not the one in the file; check film, sheets and vacuum"
    return check("prior", abs(distance[worst]) <= PRIOR_DISTANCE, sentence, cause)


def _check_slip_residuals(fit: BayesFit, data: Data) -> Check:
    """Check whether the curves share a deviation from the law that varies along the slip."""
    middle = {
        n: np.median(getattr(fit, n), axis=(0, 1))
        for n in ("curve_scale_factor", "curve_stiffness", "slack", "residual")
    }
    sites = Sites(
        0.0,
        0.0,
        np.log(np.median(fit.enclosure_factor)),
        0.0,
        0.0,
        0.0,
        np.log(middle["curve_scale_factor"]),
        np.log(middle["curve_stiffness"]),
        middle["slack"],
        0.0,
    )
    law = np.asarray(law_forces(sites, 1.0, data, fit.brake))
    residuals = np.where(data.real, (data.force - law) / data.height[:, None], np.nan)
    slip = data.elongation - data.force / middle["curve_stiffness"][:, None]
    part = slip / max(float(np.nanmax(np.where(data.real, slip, np.nan))), 1e-12)
    parts = []
    for low in (0.05, 0.25, 0.5, 0.75):
        is_inside = data.real & (part >= low) & (part < (0.25 if low == 0.05 else low + 0.2501))
        parts.append(float(residuals[is_inside].mean()) if is_inside.any() else 0.0)
    percents = ", ".join(f"{p:+.2%}" for p in parts)
    sentence = f"mean residual in the quarters of the slip: {percents} of the maximum force"
    effect = ": the force does not fall as the law predicts, so intervals are too narrow"
    return check("trend over slip", max(abs(p) for p in parts) <= BENT, sentence, effect)
