"""Checks of a fit over whole curves: its parameters, and whether the law describes the curves.

The unit of a test is the curve, not the sample. Each curve yields one number, such as its own
parameter or its mean residual over a section. Student's t over the curves tests whether these
numbers drift. A significant deviation passes if it is too small to matter.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import devices, load
from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.errors import FitError, count_text
from layerjam.core.units import get_spec, show
from layerjam.core.verdict import Level
from layerjam.laboratory.identify.calibration.forward import LEAST_ENCLOSURE
from layerjam.laboratory.identify.calibration.influence import Influence, number_duplicates
from layerjam.laboratory.identify.calibration.intervals import quantile
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import (
    SMALL,
    Check,
    check,
    check_enclosure,
    check_plausibility,
    check_scatter,
    check_span,
    check_stiffness,
    warn_about_single_pull,
)
from layerjam.laboratory.identify.single_pulls import SinglePull
from layerjam.laboratory.identify.statistics import fit_line

WORDS = {
    "scale_factor": "scale factor",
    "stiffness": "stiffness",
    "enclosure_factor": "enclosure's factor",
    "pressure_exponent": "pressure exponent",
    "speed_slope": "speed slope",
}
TOLD = {
    "scale_factor": 0.05,
    "stiffness": 0.05,
    "enclosure_factor": 0.2,
    "pressure_exponent": 0.1,
    "speed_slope": 0.1,
}
"""Largest standard error from noise alone at which the curves determine a parameter."""
ENCLOSURE_DRIFT = 0.25
"""Change of the enclosure's factor over the vacuums from which on it is not an enclosure."""
SECTIONS = 6
MATTERS = 0.015
"""Largest consistent residual that passes, relative to the peak."""
SURE = 0.997
"""Two-sided level of Student's t for a drift over slip, vacuum or speed: 0.3 % false alarms in each
of four tests. All checks share a level of 5 %, most of which goes to the checks of single pulls."""
REFUSED = 0.1
"""Largest misfit at which a curve is fitted at all, relative to its peak."""
MISSES = 0.03
"""Largest accepted misfit of a curve with its own best parameters, relative to its peak."""
UNLIKE = 1.5
"""Largest ratio of a curve's own scale factor or stiffness to that of the others."""


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """Uncertainty from noise alone: condition number, most correlated pair, parameter errors."""

    condition_number: float
    least_apart: tuple[str, str] | None
    correlation: float
    errors_from_noise: Mapping[str, float]


def judge_identifiability(fit: JointFit) -> Identifiability:
    """Return the identifiability of the shared parameters from the information of all curves."""
    total = np.einsum("gki,gkl,glj->ij", fit.design, fit.own.information, fit.design)
    scale = np.sqrt(np.maximum(np.diag(total), 1e-300))
    unit_matrix = total / np.outer(scale, scale)
    condition = float(np.linalg.cond(unit_matrix))
    if not condition < 1e14:
        return Identifiability(
            condition_number=np.inf,
            errors_from_noise=dict.fromkeys(fit.names, np.inf),
            least_apart=None,
            correlation=1.0,
        )
    covariance = np.linalg.inv(unit_matrix)
    root = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    # the inverse is symmetric up to rounding, so half of it gives the pair in the same order always
    correlation = np.triu(covariance / np.outer(root, root), 1)
    first, second = divmod(int(np.abs(correlation).argmax()), len(root))
    return Identifiability(
        condition_number=condition,
        errors_from_noise=dict(zip(fit.names, (root / scale).tolist(), strict=True)),
        least_apart=(fit.names[first], fit.names[second]),
        correlation=float(correlation[first, second]),
    )


def note_parameter_products(brake: Brake) -> Check:
    """Note that forces determine only products of parameters."""
    return check(
        "identifiable",
        True,
        "force curves determine only two products, scale factor × kinetic friction (held at "
        f"{brake.film.kinetic:.4g}) and enclosure modulus × friction, not the individual "
        "factors",
    )


def check_parameters(limits: Identifiability) -> Check:
    """Check that the curves determine each parameter beyond their noise."""
    poor = [n for n, e in limits.errors_from_noise.items() if not e <= TOLD[n]]
    errors = ", ".join(f"{WORDS[n]} to ±{limits.errors_from_noise[n]:.2g}" for n in poor)
    sentence = "these curves do not distinguish the parameters at all"
    if limits.least_apart is not None:
        first, second = (WORDS[n] for n in limits.least_apart)
        sentence = (
            f"{first} and {second} are hardest to distinguish (correlation "
            f"{limits.correlation:+.3f}, condition number {limits.condition_number:.3g})"
        )
    advice = "only a combination is known; pull further, or at a different vacuum"
    return check("told apart", not poor, sentence, f"; noise alone leaves {errors}: {advice}")


def check_bounds(values: Mapping[str, float]) -> Check:
    """Check that no parameter is at a bound of its quantity."""
    bounds: dict[str, tuple[float | None, float | None]] = {}
    for field in ("scale_factor", "stiffness_measured", "pressure_exponent"):
        spec = get_spec(Brake, field)
        bounds[field.removesuffix("_measured")] = (spec.lo, spec.hi)
    bounds["enclosure_factor"] = (10 * LEAST_ENCLOSURE, 100.0)
    at_bounds = []
    for name, value in values.items():
        low, high = bounds.get(name, (None, None))
        if not (-np.inf if low is None else low) < value < (np.inf if high is None else high):
            at_bounds.append(WORDS[name])
    sentence = (
        f"{', '.join(at_bounds)} ended at a bound" if at_bounds else "no parameter ended at a bound"
    )
    return check("bounds", not at_bounds, sentence)


def check_catalogue_range(product: float) -> Check:
    """Check that friction times scale factor is plausible for the films in the catalogue."""
    brakes = [load(name).brake for name in devices()]
    values = [b.scale_factor * b.film.kinetic for b in brakes]
    advice = "half the lowest and twice the highest in the catalogue"
    span = (min(values) / 2, max(values) * 2)
    return check_span("catalogue", product, span, "friction times scale factor", advice)


def check_repeats(fit: JointFit) -> Check:
    """Check that similar curves have scale factors within 5 % (SD) or three noise errors.

    A few repeats determine their scatter poorly: films that scatter by 4 % show more than 5 % in
    one of seven campaigns of six pairs. The check therefore fails only if all curves also scatter
    by over 5 % about the shared law. If no two curves have the same conditions, only the second
    criterion counts.
    """
    count = len(fit.reduced)
    if count < 2:
        return warn_about_single_pull()
    deviations = fit.own.own[:, 0] - (fit.design @ fit.population.estimate + fit.held)[:, 0]
    fitted_count = int(np.any(fit.design[:, 0] != 0, axis=0).sum())
    spread, basis = _pooled_sd(deviations, [range(count)], fitted_count), count_text(count, "pull")
    groups = [g for g in fit.groups if len(g) > 1]
    if groups:
        basis += " about the law they share"
        repeat_sd = _pooled_sd(deviations, groups)
        if repeat_sd <= spread:
            condition_count = count_text(len(groups), "condition")
            spread, basis = repeat_sd, f"{sum(map(len, groups))} pulls of {condition_count}"
    noise = np.sqrt(np.abs(np.linalg.pinv(fit.own.information)[:, 0, 0]))
    return check_scatter(spread, float(np.median(noise)), basis)


def _pooled_sd(values: np.ndarray, groups: Sequence[Sequence[int]], fitted_count: int = 1) -> float:
    """Return the SD about the group means, with `fitted_count` fitted parameters."""
    deviations = [values[list(g)] - values[list(g)].mean() for g in groups]
    degrees = max(sum(len(g) - fitted_count for g in groups), 1)
    return float(np.sqrt(sum(float(r @ r) for r in deviations) / degrees))


def curve_misfits(fit: JointFit) -> np.ndarray:
    """Return each curve's own misfit from the law, relative to its peak; shape (curves,).

    It is based on the mean product of neighbouring residuals, which is zero for white noise.
    """
    out = []
    for residual, weight in zip(fit.alone.residual, fit.reduced.weight, strict=True):
        residuals = residual[weight > 0]
        out.append(max(float((residuals[1:] * residuals[:-1]).mean()), 0.0) ** 0.5)
    return np.array(out) / fit.reduced.height


def require_law_match(fit: JointFit, names: Sequence[str]) -> None:
    """Raise FitError for a curve that the law cannot describe with any parameters."""
    misfits = curve_misfits(fit)
    worst = int(misfits.argmax())
    if misfits[worst] > REFUSED:
        raise FitError.of(
            names[worst],
            f"its curve deviates from the law by at least {misfits[worst]:.0%} of its "
            "peak, whatever the scale factor, stiffness and enclosure; at most "
            f"{REFUSED:.0%} is allowed. Check the units of force and elongation and "
            "the sheets' overlap, or leave the file out",
        )


def check_single_curves(fit: JointFit, names: Sequence[str]) -> Check:
    """Check that each curve follows the law, with parameters similar to those of the others."""
    misfits = curve_misfits(fit)
    worst = int(misfits.argmax())
    law = fit.design @ fit.population.estimate + fit.held
    deviations = (fit.own.own - np.pad(law, ((0, 0), (0, 2))))[:, :2]
    deviations = deviations - np.median(deviations, axis=0)
    curve, parameter = np.unravel_index(int(np.abs(deviations).argmax()), deviations.shape)
    farthest = float(deviations[curve, parameter])
    word = WORDS[fit.names[int(parameter)]]
    advice = "check its units of force and elongation and its vacuum, or leave the file out"
    follows = bool(misfits[worst] <= MISSES)
    is_ok = abs(farthest) <= np.log(UNLIKE)
    if not follows:
        sentence = f"{names[worst]} deviates from the law by {misfits[worst]:.1%} of its peak"
    elif not is_ok:
        sentence = (
            f"{word} of {names[int(curve)]} is {np.exp(farthest):.3g} times that of the others"
        )
    else:
        sentence = (
            f"every curve follows the law within {misfits[worst]:.1%} of its peak, and none "
            f"has a scale factor or stiffness that differs by more than "
            f"{abs(farthest):.1%} from the others"
        )
    return check("single curves", follows and is_ok, sentence, f": {advice}")


def check_slip_residuals(fit: JointFit) -> Check:
    """Check that no section of slip has the same deviation from the law in all curves."""
    means = mean_section_residuals(fit)
    count = len(means)
    middle = np.nanmean(means, axis=0)
    if count > 1:
        error = np.nanstd(means, axis=0, ddof=1) / np.sqrt(count)
        t_factor = special.stdtrit(count - 1, 1 - (1 - SURE) / (2 * SECTIONS))
        is_significant = (np.abs(middle) > MATTERS) & (np.abs(middle) > t_factor * error)
    else:
        is_significant = np.abs(middle) > MATTERS
    worst = int(
        np.nanargmax(
            np.abs(np.where(is_significant, middle, 0) if is_significant.any() else middle)
        )
    )
    part = f"{worst / SECTIONS:.0%} to {(worst + 1) / SECTIONS:.0%} of the slip"
    sentence = (
        f"from {part} the curves deviate by {middle[worst]:+.2%} of the peak from their own fit"
    )
    if not is_significant.any():
        sentence = f"no trend over slip: at most {abs(middle[worst]):.2%} of the peak remains"
    return check("residuals over slip", not is_significant.any(), sentence)


def mean_section_residuals(fit: JointFit) -> np.ndarray:
    """Return mean residuals over sections of slip, relative to the peak: (curves, sections)."""
    out = np.full((len(fit.reduced), SECTIONS), np.nan)
    for place, residual in enumerate(fit.own.residual):
        weight, u = fit.reduced.weight[place], fit.reduced.elongation[place]
        height = fit.reduced.height[place]
        stiffness = np.exp(fit.own.own[place, 1])
        slip = u - fit.own.own[place, 3] * fit.reduced.onset[place]
        slip = slip - fit.reduced.force[place] / stiffness
        sliding = (weight > 0) & (slip > 0.01 * slip[weight > 0].max())
        if sliding.sum() < SECTIONS:
            continue
        part = slip / slip[sliding].max() * SECTIONS
        part = np.clip(part.astype(int), 0, SECTIONS - 1)
        for section in range(SECTIONS):
            is_inside = sliding & (part == section)
            if is_inside.any():
                out[place, section] = (
                    np.average(residual[is_inside], weights=weight[is_inside]) / height
                )
    return out


def check_drift(
    values: np.ndarray,
    quantities: np.ndarray,
    word: str,
    quantity: str,
    unit: str,
    free: int = 0,
    impossible: float = np.inf,
) -> Check | None:
    """Check that the curves' own values of a parameter (relative) do not drift; None if too few.

    `free` is the number of slopes against the logarithm of this quantity that the fit removed; if
    it is 1, only a bend is tested. A change above `impossible` fails.
    """
    levels = len(np.unique(np.round(np.log(quantities), 2)))
    if levels < 2 + free or len(values) - 2 - free < 1:
        return None
    x = np.log(quantities) - np.log(quantities).mean()
    if free:
        values = values - np.polyval(np.polyfit(x, values, 1), x)
        x = x**2 - np.polyval(np.polyfit(x, x**2, 1), x)
    line = fit_line(x, values)
    if line is None:
        return None
    freedom = line.freedom - free
    error = line.slope_se * float(np.sqrt(line.freedom / freedom))
    change = line.slope * float(np.ptp(x))
    is_significant = abs(line.slope) > quantile(freedom, SURE) * error
    span = f"{show(float(quantities.min()), unit)} to {show(float(quantities.max()), unit)}"
    sentence = (
        f"over {quantity} from {span} the {word} {'bends' if free else 'changes'} by {change:+.1%}"
    )
    is_ok = not (is_significant and abs(change) > SMALL)
    level: Level = "failed" if abs(change) > impossible else "warning"
    return check(f"{word} over {quantity}", is_ok, sentence, level=level)


def check_enclosures(pulls: Sequence[SinglePull], sd: float) -> Iterator[Check]:
    """Yield the checks of the enclosure that the pulls need after their peaks.

    `sd` is the relative standard deviation of the enclosure's force in the brake file.
    """
    pairs = [(p.enclosure, p.vacuum) for p in pulls if p.enclosure is not None]
    if not pairs:
        return
    factors, vacuums = np.array(pairs).T
    error = float(np.std(factors, ddof=1)) / len(factors) ** 0.5 if len(factors) > 1 else 0.0
    yield check_enclosure(float(np.mean(factors)), error, sd)
    drift = _check_enclosure_drift(factors / abs(factors.mean()), vacuums)
    if drift is not None:
        yield drift


def _check_enclosure_drift(factors: np.ndarray, vacuums: np.ndarray) -> Check | None:
    word, limit = "enclosure's factor", ENCLOSURE_DRIFT
    return check_drift(factors - 1, vacuums, word, "vacuum", "Pa", impossible=limit)


def check_single_file(
    influence: Mapping[str, Influence], scatter: Mapping[str, tuple[float, float] | None]
) -> Check | None:
    """Check that no single file moves a value by more than the interval from the scatter.

    `scatter` {value: (standard error, degrees of freedom)} excludes what all pulls share.
    """
    parts = {
        n: abs(item.files[item.most_influential]) / (error[0] * quantile(error[1]))
        for n, item in influence.items()
        if item.most_influential and (error := scatter[n]) is not None and error[0] > 0
    }
    if not parts:
        return None
    worst = max(parts, key=lambda n: parts[n])
    sentence = (
        f"leaving out {influence[worst].most_influential} changes the {WORDS[worst]} most, by "
        f"{parts[worst]:.2g} of the half-width of its interval"
    )
    return check("leave one out", parts[worst] <= 1, sentence)


def check_curves(
    fit: JointFit, brake: Brake, values: Mapping[str, float], curves: Sequence[Curve]
) -> tuple[Check, ...]:
    """Return all checks that do not use intervals."""
    names, speeds = number_duplicates([c.name for c in curves]), [c.speed for c in curves]
    parameters, vacuum = fit.own.own, fit.reduced.vacuum
    law = fit.design @ fit.population.estimate + fit.held
    with_exponent = int("pressure_exponent" in fit.free)
    error = fit.population.standard_error(np.eye(len(fit.names))[2])
    enclosure_error = 0.0 if error is None else error[0]
    result = "converged" if fit.settled else "did not converge"
    checks: list[Check | None] = [
        note_parameter_products(brake),
        check_parameters(judge_identifiability(fit)),
        check("settled", fit.settled, f"least squares {result} after {fit.rounds} iterations"),
        check_bounds(values),
        check_plausibility(values["scale_factor"]),
        check_catalogue_range(values["scale_factor"] * brake.film.kinetic),
        check_stiffness(values["stiffness"], float(stiffness_before_slip(brake))),
        check_enclosure(values["enclosure_factor"], enclosure_error, brake.enclosure.force_sd),
        check_repeats(fit),
        check_single_curves(fit, names),
        check_slip_residuals(fit),
        check_drift(
            parameters[:, 0] - law[:, 0], vacuum, "scale factor", "vacuum", "Pa", with_exponent
        ),
        _check_enclosure_drift(parameters[:, 2] / law[:, 2], vacuum),
    ]
    if all(s is not None for s in speeds):
        values_known = np.array([s for s in speeds if s is not None])
        checks.append(
            check_drift(
                parameters[:, 0] - law[:, 0],
                values_known,
                "scale factor",
                "speed",
                "m/s",
                int("speed" in fit.free),
            )
        )
    return tuple(c for c in checks if c is not None)
