"""The verdict on a fit over whole curves: what they can tell, and whether the law describes them.

A test here counts curves, not samples: each curve gives one number (its own parameter, the mean of
its residual over a stretch), and Student's t over curves judges whether these drift. What is
significant but too small to matter passes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from layerjam.device.brake import Brake
from layerjam.device.load import catalogue, load
from layerjam.identify.calibration.forward import LEAST_ENCLOSURE
from layerjam.identify.calibration.intervals import Interval, quantile
from layerjam.identify.calibration.least_squares import JointFit
from layerjam.identify.checks import Check, plausible, stiffness_possible
from layerjam.mechanics.stiffness import stiffness_before_slip
from layerjam.units import show, spec_of

WORDS = {
    "scale_factor": "scale factor",
    "stiffness": "stiffness",
    "enclosure_factor": "sleeve's factor",
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
"""The sleeve's factor beyond this is suspect: modulus and friction of a silicone vary by less."""
SECTIONS = 6
MATTERS = 0.015
"""Part of the peak that a consistent residual may reach before it counts."""
DRIFT = 0.05
"""Part by which a parameter may change over the range tested before it counts."""
REPEAT = 0.05
"""Scatter between repeats (SD, relative) beyond which they disagree."""
SURE = 0.99


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """What the noise alone leaves open: errors by parameter, condition number, strongest pair."""

    condition_number: float
    errors: Mapping[str, float]
    pair: tuple[str, str] | None
    correlation: float


def identifiability(fit: JointFit) -> Identifiability:
    """From all curves' information about the shared parameters, slack and offsets left open."""
    whole = np.einsum("gki,gkl,glj->ij", fit.design, fit.own.information, fit.design)
    scale = np.sqrt(np.maximum(np.diag(whole), 1e-300))
    alike = whole / np.outer(scale, scale)
    condition = float(np.linalg.cond(alike))
    if not condition < 1e14:
        return Identifiability(
            condition_number=np.inf,
            errors=dict.fromkeys(fit.names, np.inf),
            pair=None,
            correlation=1.0,
        )
    covariance = np.linalg.inv(alike)
    root = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    correlation = covariance / np.outer(root, root) - np.eye(len(root))
    first, second = divmod(int(np.abs(correlation).argmax()), len(root))
    return Identifiability(
        condition_number=condition,
        errors=dict(zip(fit.names, (root / scale).tolist(), strict=True)),
        pair=(fit.names[first], fit.names[second]),
        correlation=float(correlation[first, second]),
    )


def products(brake: Brake) -> Check:
    """Only products show in forces."""
    return Check(
        name="identifiable",
        passed=True,
        sentence="force curves fix the product of scale factor and kinetic friction (held at "
        f"{brake.film.kinetic:.4g}) and that of the sleeve's modulus and friction, never a factor "
        "of either",
    )


def told_apart(found: Identifiability) -> Check:
    """Each parameter is told by the curves beyond their noise."""
    poor = [n for n, e in found.errors.items() if not e <= TOLD[n]]
    if found.pair is None:
        sentence = "these curves do not tell the parameters apart at all"
    else:
        one, other = (WORDS[n] for n in found.pair)
        sentence = (
            f"{one} and {other} are told apart least (correlation {found.correlation:+.3f}, "
            f"condition number {found.condition_number:.3g})"
        )
    if poor:
        errors = ", ".join(f"{WORDS[n]} to ±{found.errors[n]:.2g}" for n in poor)
        sentence += f"; noise alone leaves {errors}: only a combination is known, pull further "
        sentence += "or at another vacuum"
    return Check(name="told apart", passed=not poor, sentence=sentence)


def off_bounds(values: Mapping[str, float]) -> Check:
    """No parameter was stopped by a bound of its quantity."""
    bounds = {
        "scale_factor": (
            spec_of(Brake, "scale_factor").lo,
            spec_of(Brake, "scale_factor").hi,
        ),
        "stiffness": (
            spec_of(Brake, "stiffness_measured").lo,
            spec_of(Brake, "stiffness_measured").hi,
        ),
        "pressure_exponent": (
            spec_of(Brake, "pressure_exponent").lo,
            spec_of(Brake, "pressure_exponent").hi,
        ),
        "enclosure_factor": (10 * LEAST_ENCLOSURE, 100.0),
    }
    at = [
        WORDS[n]
        for n, v in values.items()
        if n in bounds and not ((bounds[n][0] or -np.inf) < v < (bounds[n][1] or np.inf))
    ]
    sentence = f"{', '.join(at)} ended at a bound" if at else "no parameter ended at a bound"
    return Check(name="bounds", passed=not at, sentence=sentence)


def like_catalogue(product: float) -> Check:
    """Friction times scale factor lies about where the catalogue's films have it."""
    brakes = [load(name).brake for name in catalogue()]
    known = [b.scale_factor * b.film.kinetic for b in brakes]
    low, high = min(known) / 2, max(known) * 2
    fine = low <= product <= high
    return Check(
        name="catalogue",
        passed=fine,
        sentence=f"friction times scale factor is {product:.4g}, {'within' if fine else 'outside'} "
        f"{low:.2g} to {high:.2g}, half the least and twice the greatest of the catalogue",
    )


def sleeve_plausible(factor: float) -> Check:
    """The sleeve carries about what its modulus and friction say."""
    low, high = SLEEVE
    fine = low <= factor <= high
    sentence = f"the sleeve carries {factor:.3g} times what the file's modulus and friction give"
    if not fine:
        sentence += f", outside {low} to {high}: something else than the sleeve bends the curves"
    return Check(name="sleeve", passed=fine, sentence=sentence)


def repeats_agree(fit: JointFit) -> Check:
    """Curves pulled alike have scale factors within 5 % (SD), or three of their noise's errors.

    Where no two were pulled alike, all are compared about the law that all share.
    """
    count = len(fit.reduced)
    if count < 2:
        return Check(
            name="repeats",
            passed=False,
            sentence="one pull only: nothing says how well it repeats",
        )
    away = fit.own.own[:, 0] - (fit.design @ fit.population.estimate + fit.held)[:, 0]
    groups = [list(g) for g in fit.groups if len(g) > 1]
    told = f"pulls of {len(groups)} condition{'s' * (len(groups) > 1)}" if groups else "pulls"
    groups = groups or [list(range(count))]
    rest = [away[g] - away[g].mean() for g in groups]
    degrees = sum(len(g) - 1 for g in groups)
    spread = float(np.sqrt(sum(float(r @ r) for r in rest) / degrees))
    noise = np.sqrt(np.abs(np.linalg.pinv(fit.own.information)[:, 0, 0]))
    used = sum(len(g) for g in groups)
    return Check(
        name="repeats",
        passed=spread <= max(REPEAT, 3 * float(np.median(noise))),
        sentence=f"scale factors of {used} {told} scatter by {spread:.1%} (SD)",
    )


def slip_residuals(fit: JointFit) -> Check:
    """No stretch of slip where the law lies off all curves the same way."""
    means = section_means(fit)
    count = len(means)
    middle = np.nanmean(means, axis=0)
    if count > 1:
        error = np.nanstd(means, axis=0, ddof=1) / np.sqrt(count)
        sure = stats.t.ppf(1 - (1 - SURE) / (2 * SECTIONS), count - 1)
        bad = (np.abs(middle) > MATTERS) & (np.abs(middle) > sure * error)
    else:
        bad = np.abs(middle) > MATTERS
    worst = int(np.nanargmax(np.abs(np.where(bad, middle, 0) if bad.any() else middle)))
    part = f"{worst / SECTIONS:.0%} to {(worst + 1) / SECTIONS:.0%} of the slip"
    sentence = f"from {part} the curves lie {middle[worst]:+.2%} of the peak off their own fit"
    if not bad.any():
        sentence = f"no trend over slip: at most {abs(middle[worst]):.2%} of the peak is left"
    return Check(name="residuals over slip", passed=not bad.any(), sentence=sentence)


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

    `free`: how many slopes over this quantity the fit itself has taken out.
    """
    levels = len(np.unique(np.round(np.log(over), 2)))
    degrees = len(values) - 2
    if levels < 2 + free or degrees < 1:
        return None
    x = np.log(over) - np.log(over).mean()
    if free:
        fitted = np.polyfit(x, values, 1)
        rest = values - np.polyval(fitted, x)
        x = x**2 - np.polyval(np.polyfit(x, x**2, 1), x)
        values, degrees = rest, degrees - 1
        if degrees < 1:
            return None
    slope = float((x @ values) / (x @ x))
    rest = values - values.mean() - slope * x
    error = float(np.sqrt(rest @ rest / degrees / (x @ x)))
    change = slope * float(np.ptp(x))
    sure = abs(slope) > quantile(degrees, SURE) * error
    passed = not (sure and abs(change) > DRIFT)
    bend = "bends" if free else "changes"
    span = f"{show(float(over.min()), unit)} to {show(float(over.max()), unit)}"
    return Check(
        name=f"{word} over {what}",
        passed=passed,
        sentence=f"over {what} from {span} the {word} {bend} by {change:+.1%}",
    )


def one_file(
    moves: Mapping[str, tuple[str, float]], intervals: Mapping[str, Interval | None]
) -> Check | None:
    """No single file moves an answer by more than its interval; `moves`: {name: (file, by)}."""
    parts = {
        n: abs(by) / ((i.high - i.low) / 2)
        for n, (_, by) in moves.items()
        if (i := intervals.get(n)) is not None and i.high > i.low
    }
    if not parts:
        return None
    worst = max(parts, key=lambda n: parts[n])
    file, fine = moves[worst][0], parts[worst] <= 1
    return Check(
        name="leave one out",
        passed=fine,
        sentence=f"leaving out {file} moves the {WORDS[worst]} most, by {parts[worst]:.2g} of its "
        "interval's half width",
    )


def curve_checks(
    fit: JointFit, brake: Brake, values: Mapping[str, float], speeds: Sequence[float | None]
) -> tuple[Check, ...]:
    """Everything but what needs intervals."""
    own, vacuum = fit.own.own, fit.reduced.vacuum
    expected = fit.design @ fit.population.estimate + fit.held
    with_exponent = int("pressure_exponent" in fit.free)
    checks: list[Check | None] = [
        products(brake),
        told_apart(identifiability(fit)),
        Check(
            name="settled",
            passed=fit.settled,
            sentence=f"least squares {'settled' if fit.settled else 'did not settle'} after "
            f"{fit.rounds} rounds",
        ),
        off_bounds(values),
        plausible(values["scale_factor"]),
        like_catalogue(values["scale_factor"] * brake.film.kinetic),
        stiffness_possible(values["stiffness"], float(stiffness_before_slip(brake))),
        sleeve_plausible(values["enclosure_factor"]),
        repeats_agree(fit),
        slip_residuals(fit),
        drift(own[:, 0] - expected[:, 0], vacuum, "scale factor", "vacuum", "Pa", with_exponent),
        drift(own[:, 2] / expected[:, 2] - 1, vacuum, "sleeve's factor", "vacuum", "Pa"),
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
