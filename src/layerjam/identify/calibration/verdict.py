"""The verdict on a fit over whole curves: what they can tell, and whether the law describes them.

A test here counts curves, not samples: each curve gives one number (its own parameter, the mean of
its residual over a stretch), and Student's t over curves judges whether these drift. What is
significant but too small to matter passes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.device.brake import Brake
from layerjam.device.load import devices, load
from layerjam.errors import FitError, count_of
from layerjam.identify.calibration.forward import LEAST_ENCLOSURE
from layerjam.identify.calibration.influence import Influence, distinct
from layerjam.identify.calibration.intervals import Interval, quantile
from layerjam.identify.calibration.least_squares import JointFit
from layerjam.identify.checks import (
    SMALL,
    Check,
    check,
    one_pull_only,
    plausible,
    repeats,
    stiffness_possible,
    within,
)
from layerjam.identify.curves import Curve
from layerjam.identify.straight import straight_line
from layerjam.mechanics.stiffness import stiffness_before_slip
from layerjam.units import show, spec_of

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
"""Standard error from noise alone up to which a parameter counts as told by the curves."""
SLEEVE = (0.3, 3.0)
"""The enclosure's factor beyond this is suspect: moduli and frictions of silicone vary less."""
SECTIONS = 6
MATTERS = 0.015
"""Part of the peak that a consistent residual may reach before it counts."""
SURE = 0.997
"""Of Student's t for what drifts over slip, vacuum or speed, either way: 0.3 % of false alarms for
each of the four. Five of a hundred are for all checks together, and single pulls take most."""
REFUSED = 0.1
"""Part of its peak by which a curve may miss the law and still be fitted."""
MISSES = 0.03
"""Part of its peak by which a curve may miss the law at its own best numbers."""
UNLIKE = 1.5
"""How many times the others' a curve's own scale factor or stiffness may be, or they its."""


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """What the noise alone leaves open: condition number, strongest pair, errors by parameter."""

    condition_number: float
    least_apart: tuple[str, str] | None
    correlation: float
    errors_from_noise: Mapping[str, float]


def identifiability(fit: JointFit) -> Identifiability:
    """From all curves' information about the shared parameters, slack and offsets left open."""
    whole = np.einsum("gki,gkl,glj->ij", fit.design, fit.own.information, fit.design)
    scale = np.sqrt(np.maximum(np.diag(whole), 1e-300))
    alike = whole / np.outer(scale, scale)
    condition = float(np.linalg.cond(alike))
    if not condition < 1e14:
        return Identifiability(
            condition_number=np.inf,
            errors_from_noise=dict.fromkeys(fit.names, np.inf),
            least_apart=None,
            correlation=1.0,
        )
    covariance = np.linalg.inv(alike)
    root = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.outer(root, root) - np.eye(len(root))
    first, second = divmod(int(np.abs(correlation).argmax()), len(root))
    return Identifiability(
        condition_number=condition,
        errors_from_noise=dict(zip(fit.names, (root / scale).tolist(), strict=True)),
        least_apart=(fit.names[first], fit.names[second]),
        correlation=float(correlation[first, second]),
    )


def products(brake: Brake) -> Check:
    """Only products show in forces."""
    return check(
        "identifiable",
        True,
        "force curves fix the product of scale factor and kinetic friction (held at "
        f"{brake.film.kinetic:.4g}) and that of the enclosure's modulus and friction, never a "
        "factor of either",
    )


def told_apart(found: Identifiability) -> Check:
    """Each parameter is determined by the curves beyond their noise."""
    poor = [n for n, e in found.errors_from_noise.items() if not e <= TOLD[n]]
    errors = ", ".join(f"{WORDS[n]} to ±{found.errors_from_noise[n]:.2g}" for n in poor)
    sentence = "these curves do not tell the parameters apart at all"
    if found.least_apart is not None:
        one, other = (WORDS[n] for n in found.least_apart)
        sentence = (
            f"{one} and {other} are hardest to tell apart (correlation {found.correlation:+.3f}, "
            f"condition number {found.condition_number:.3g})"
        )
    advice = "only a combination is known, pull further or at another vacuum"
    return check("told apart", not poor, sentence, f"; noise alone leaves {errors}: {advice}")


def off_bounds(values: Mapping[str, float]) -> Check:
    """No parameter was stopped by a bound of its quantity."""
    bounds: dict[str, tuple[float | None, float | None]] = {}
    for field in ("scale_factor", "stiffness_measured", "pressure_exponent"):
        spec = spec_of(Brake, field)
        bounds[field.removesuffix("_measured")] = (spec.lo, spec.hi)
    bounds["enclosure_factor"] = (10 * LEAST_ENCLOSURE, 100.0)
    at = []
    for name, value in values.items():
        low, high = bounds.get(name, (None, None))
        if not (-np.inf if low is None else low) < value < (np.inf if high is None else high):
            at.append(WORDS[name])
    sentence = f"{', '.join(at)} ended at a bound" if at else "no parameter ended at a bound"
    return check("bounds", not at, sentence)


def like_catalogue(product: float) -> Check:
    """Friction times scale factor lies about where the catalogue's films have it."""
    brakes = [load(name).brake for name in devices()]
    known = [b.scale_factor * b.film.kinetic for b in brakes]
    advice = "half the least and twice the greatest of the catalogue"
    span = (min(known) / 2, max(known) * 2)
    return within("catalogue", product, span, "friction times scale factor", advice)


def sleeve_plausible(factor: float) -> Check:
    """The enclosure carries about what its modulus and friction say."""
    advice = "something else than the enclosure bends the curves"
    return within("sleeve", factor, SLEEVE, "the factor on the enclosure's force", advice)


def repeats_agree(fit: JointFit) -> Check:
    """Curves pulled alike have scale factors within 5 % (SD), or three of their noise's errors.

    Few repeats of each condition tell their scatter badly: films that scatter by 4 % show more than
    5 % in one of seven campaigns of six pairs. So all curves about the law that they share must
    scatter by more, too. Where no two were pulled alike, that alone counts.
    """
    count = len(fit.reduced)
    if count < 2:
        return one_pull_only()
    away = fit.own.own[:, 0] - (fit.design @ fit.population.estimate + fit.held)[:, 0]
    shared = int(np.any(fit.design[:, 0] != 0, axis=0).sum())
    spread, told = _pooled(away, [range(count)], shared), count_of(count, "pull")
    groups = [g for g in fit.groups if len(g) > 1]
    if groups:
        told += " about the law they share"
        alike = _pooled(away, groups)
        if alike <= spread:
            many = count_of(len(groups), "condition")
            spread, told = alike, f"{sum(map(len, groups))} pulls of {many}"
    noise = np.sqrt(np.abs(np.linalg.pinv(fit.own.information)[:, 0, 0]))
    return repeats(spread, float(np.median(noise)), told)


def _pooled(values: np.ndarray, groups: Sequence[Sequence[int]], shared: int = 1) -> float:
    """Standard deviation about the means of groups, `shared` numbers fitted to each."""
    rest = [values[list(g)] - values[list(g)].mean() for g in groups]
    degrees = max(sum(len(g) - shared for g in groups), 1)
    return float(np.sqrt(sum(float(r @ r) for r in rest) / degrees))


def misses(fit: JointFit) -> np.ndarray:
    """By which part of its peak each curve, by itself, misses the law; shape (curves,).

    The mean product of neighbouring residuals: white noise, which tells nothing, leaves it zero.
    """
    out = []
    for residual, weight in zip(fit.alone.residual, fit.reduced.weight, strict=True):
        rest = residual[weight > 0]
        out.append(max(float((rest[1:] * rest[:-1]).mean()), 0.0) ** 0.5)
    return np.array(out) / fit.reduced.height


def follow_law(fit: JointFit, names: Sequence[str]) -> None:
    """Raise FitError for a curve that no numbers of the law describe: nothing in it can count."""
    missed = misses(fit)
    worst = int(missed.argmax())
    if missed[worst] > REFUSED:
        raise FitError.of(
            names[worst],
            f"its curve misses the law by {missed[worst]:.0%} of its peak, whatever scale factor, "
            f"stiffness and enclosure it is given; at most {REFUSED:.0%} can be fitted. Check the "
            "units of force and elongation and the sheets' overlap, or leave the file out",
        )


def single_curves(fit: JointFit, names: Sequence[str]) -> Check:
    """Each curve follows the law, with numbers that are not grossly unlike the others'."""
    missed = misses(fit)
    worst = int(missed.argmax())
    expected = fit.design @ fit.population.estimate + fit.held
    away = (fit.own.own - np.pad(expected, ((0, 0), (0, 2))))[:, :2]
    away = away - np.median(away, axis=0)
    odd, which = np.unravel_index(int(np.abs(away).argmax()), away.shape)
    farthest = float(away[odd, which])
    word = WORDS[fit.names[int(which)]]
    advice = "check its units of force and elongation and its vacuum, or leave the file out"
    follows = bool(missed[worst] <= MISSES)
    alike = abs(farthest) <= np.log(UNLIKE)
    if not follows:
        sentence = f"{names[worst]} misses the law by {missed[worst]:.1%} of its peak"
    elif not alike:
        sentence = f"the {word} of {names[int(odd)]} is {np.exp(farthest):.3g} times the others'"
    else:
        sentence = (
            f"every curve follows the law to {missed[worst]:.1%} of its peak, and none has a scale "
            f"factor or stiffness more than {abs(farthest):.1%} off the others'"
        )
    return check("single curves", follows and alike, sentence, f": {advice}")


def slip_residuals(fit: JointFit) -> Check:
    """No stretch of slip where the law lies off all curves the same way."""
    means = section_means(fit)
    count = len(means)
    middle = np.nanmean(means, axis=0)
    if count > 1:
        error = np.nanstd(means, axis=0, ddof=1) / np.sqrt(count)
        sure = special.stdtrit(count - 1, 1 - (1 - SURE) / (2 * SECTIONS))
        bad = (np.abs(middle) > MATTERS) & (np.abs(middle) > sure * error)
    else:
        bad = np.abs(middle) > MATTERS
    worst = int(np.nanargmax(np.abs(np.where(bad, middle, 0) if bad.any() else middle)))
    part = f"{worst / SECTIONS:.0%} to {(worst + 1) / SECTIONS:.0%} of the slip"
    sentence = f"from {part} the curves lie {middle[worst]:+.2%} of the peak off their own fit"
    if not bad.any():
        sentence = f"no trend over slip: at most {abs(middle[worst]):.2%} of the peak is left"
    return check("residuals over slip", not bad.any(), sentence)


def section_means(fit: JointFit) -> np.ndarray:
    """Mean residual over equal sections of slip, part of the peak: (curves, sections)."""
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
            here = sliding & (part == section)
            if here.any():
                out[place, section] = np.average(residual[here], weights=weight[here]) / height
    return out


def drift(
    values: np.ndarray, over: np.ndarray, word: str, what: str, unit: str, free: int = 0
) -> Check | None:
    """A parameter's own values (relative) do not drift; None where nothing varies or too few tell.

    `free`: how many slopes over the logarithm of this quantity the fit itself has taken out; what
    is then left to see is a bend.
    """
    levels = len(np.unique(np.round(np.log(over), 2)))
    if levels < 2 + free or len(values) - 2 - free < 1:
        return None
    x = np.log(over) - np.log(over).mean()
    if free:
        values = values - np.polyval(np.polyfit(x, values, 1), x)
        x = x**2 - np.polyval(np.polyfit(x, x**2, 1), x)
    line = straight_line(x, values)
    if line is None:
        return None
    freedom = line.freedom - free
    error = line.slope_se * float(np.sqrt(line.freedom / freedom))
    change = line.slope * float(np.ptp(x))
    sure = abs(line.slope) > quantile(freedom, SURE) * error
    span = f"{show(float(over.min()), unit)} to {show(float(over.max()), unit)}"
    sentence = (
        f"over {what} from {span} the {word} {'bends' if free else 'changes'} by {change:+.1%}"
    )
    return check(f"{word} over {what}", not (sure and abs(change) > SMALL), sentence)


def one_file(
    influence: Mapping[str, Influence], intervals: Mapping[str, Interval | None]
) -> Check | None:
    """No single file moves a value by more than its interval."""
    parts = {
        n: abs(moved.files[moved.most_influential]) / i.half_width
        for n, moved in influence.items()
        if moved.most_influential and (i := intervals[n]) is not None and i.high > i.low
    }
    if not parts:
        return None
    worst = max(parts, key=lambda n: parts[n])
    sentence = (
        f"leaving out {influence[worst].most_influential} moves the {WORDS[worst]} most, by "
        f"{parts[worst]:.2g} of its interval's half width"
    )
    return check("leave one out", parts[worst] <= 1, sentence)


def curve_checks(
    fit: JointFit, brake: Brake, values: Mapping[str, float], curves: Sequence[Curve]
) -> tuple[Check, ...]:
    """Everything but what needs intervals."""
    names, speeds = distinct([c.name for c in curves]), [c.speed for c in curves]
    own, vacuum = fit.own.own, fit.reduced.vacuum
    expected = fit.design @ fit.population.estimate + fit.held
    with_exponent = int("pressure_exponent" in fit.free)
    settled = "settled" if fit.settled else "did not settle"
    checks: list[Check | None] = [
        products(brake),
        told_apart(identifiability(fit)),
        check("settled", fit.settled, f"least squares {settled} after {fit.rounds} rounds"),
        off_bounds(values),
        plausible(values["scale_factor"]),
        like_catalogue(values["scale_factor"] * brake.film.kinetic),
        stiffness_possible(values["stiffness"], float(stiffness_before_slip(brake))),
        sleeve_plausible(values["enclosure_factor"]),
        repeats_agree(fit),
        single_curves(fit, names),
        slip_residuals(fit),
        drift(own[:, 0] - expected[:, 0], vacuum, "scale factor", "vacuum", "Pa", with_exponent),
        drift(own[:, 2] / expected[:, 2] - 1, vacuum, "enclosure's factor", "vacuum", "Pa"),
    ]
    if all(s is not None for s in speeds):
        known = np.array([s for s in speeds if s is not None])
        checks.append(
            drift(
                own[:, 0] - expected[:, 0],
                known,
                "scale factor",
                "speed",
                "m/s",
                int("speed" in fit.free),
            )
        )
    return tuple(c for c in checks if c is not None)
