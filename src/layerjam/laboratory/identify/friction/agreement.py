"""Checks of friction tests: each repeat against the others, and all against the catalogue.

A wrong unit changes static and kinetic friction alike, so their ratio does not reveal it. Each is
therefore compared with its own repeats. Grubbs' test detects a small error in repeats that scatter
little. It has little power with few repeats, so a limit on the distance from the median detects
gross errors.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.spread import REPEAT_SD, film_friction_range
from layerjam.core.evolve import evolve
from layerjam.core.verdict import WIDEST, Check, Level, check, interval_check
from layerjam.laboratory.identify.friction.stribeck import USUAL
from layerjam.laboratory.identify.odd import find_outliers
from layerjam.laboratory.identify.statistics import OverRepeats

SPOKEN = {"static": "static friction", "kinetic": "kinetic friction", "speed": "speed"}
ALARMS = 0.01
"""Probability that Grubbs' test reports an outlier in one quantity of fault-free repeats."""
LEAST, LIMIT = 1.2, 1.5
"""Ratio to the others below which a repeat is never an outlier, and above which it always is. Choi
2018, table I: static friction scatters by 8 % (SD), kinetic friction by 3 %."""
RATIO = (0.9, 4.0)
"""Plausible ratio of static to kinetic friction. Table I: 1.3 (Kapton) and 2.4 (PTFE)."""
LEVELS: Mapping[Level, tuple[float, float]] = {"warning": (1.1, 2.5), "failed": (1.2, 3.0)}
"""{level: (ratio to the brake's own measured value, number of standard uncertainties) beyond which
a friction has that level}; both must be exceeded."""
LEVELS_BY_SEVERITY: tuple[Level, ...] = ("passed", *LEVELS)
WIDE, UNKNOWN = WIDEST, 1.0
"""Relative widths of the interval of static friction above which its check warns and fails. Three
repeats that scatter by 8 % have a width of 0.4 on average, and often more than 0.5."""


@dataclass(frozen=True, kw_only=True)
class Reference:
    """Friction with which new tests are compared: `span` of kinetic friction, or earlier values.

    `earlier` is {"static" or "kinetic": (value, relative SD)}, as measured before on the same
    brake, and is used first. `span` is None if the film is unknown.
    """

    span: tuple[float, float] | None = None
    earlier: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def basis(self) -> str:
        """Short name of the comparison."""
        if self.earlier:
            return "own measurement"
        return "catalogue" if self.span else "usual range of films"


def find_reference(file: BrakeFile) -> Reference:
    """Return the friction that a brake's own tests should have."""
    values = {}
    for name in ("static", "kinetic"):
        source = file.sources.get(f"film.{name}")
        if source is not None and source.kind in ("measured", "synthetic"):
            sd = REPEAT_SD[name] if source.sd is None else source.sd
            values[name] = (float(getattr(file.brake.film, name)), sd)
    return Reference(span=film_friction_range(file), earlier=values)


def check_friction(
    files: Sequence[str],
    values: Mapping[str, Sequence[float | None]],
    means: Mapping[str, OverRepeats | None],
    reference: Reference | None = None,
) -> tuple[Check, ...]:
    """Return the checks of friction tests, one for each of `files`.

    `values` has static and kinetic friction [-] and speed [m/s] of each test, None if unknown, and
    `means` the means over them. `reference` is from `find_reference`, None if the film is unknown.
    """
    names = [Path(file).name or f"repeat {place}" for place, file in enumerate(files, 1)]
    quantities = {SPOKEN[name]: value for name, value in values.items()}
    advice = "check its unit, normal force and film"
    checks = [check_repeats(names, quantities, "films normally vary", advice)]
    for name, mean in means.items():
        if mean is not None and mean.low is not None and mean.high is not None:
            # as wide as the interval about the mean; a log scale would reject more campaigns
            half_width = mean.mean * math.log(mean.high / mean.mean)
            low = max(mean.mean - half_width, mean.low)
            interval = interval_check(f"{name} friction", mean.mean, low, mean.mean + half_width)
            checks.append(_relax_check(interval) if name == "static" else interval)
    pairs = zip(values["static"], values["kinetic"], names, strict=True)
    ratios = {name: static / kinetic for static, kinetic, name in pairs if static and kinetic}
    if ratios:
        checks.append(_check_ratio(ratios))
    if (film := _check_film(means, reference or Reference())) is not None:
        checks.append(film)
    return tuple(checks)


def _relax_check(interval: Check) -> Check:
    """Return the check of static friction's interval, which fails only above `UNKNOWN`."""
    if interval.value is None or not WIDE < interval.value <= UNKNOWN:
        return interval
    return evolve(interval, level="warning")


def check_repeats(
    names: Sequence[str],
    quantities: Mapping[str, Sequence[float | None]],
    scatter: str,
    advice: str,
) -> Check:
    """Return the check that no repeat differs from the others by more than a plausible scatter.

    `scatter` completes "by more than ..."; `advice` names what to examine in an outlier.
    """
    outlier_texts = []
    for quantity, values in quantities.items():
        numbers = [(v, n) for v, n in zip(values, names, strict=True) if v is not None and v > 0]
        logs = np.log([value for value, _ in numbers])
        outliers = _outlier_indices(logs)
        other_logs = np.delete(logs, outliers) if len(outliers) < len(logs) else logs
        for place in outliers:
            ratio = float(np.exp(logs[place] - np.median(other_logs)))
            outlier_texts.append(
                f"{quantity} of {numbers[place][1]} is {ratio:.3g} times that of the others"
            )
    if len(names) < 2:
        return check("repeats", False, "only one repeat: its repeatability is unknown")
    ok_sentence = f"none of the {len(names)} repeats differs from the others by more than {scatter}"
    otherwise = f": {advice}, or leave the file out"
    return check(
        "repeats", not outlier_texts, "; ".join(outlier_texts) or ok_sentence, otherwise, "failed"
    )


def _outlier_indices(logs: np.ndarray) -> list[int]:
    """Return the indices of outliers; both if the only two values differ too much."""
    if len(logs) == 2 and abs(logs[0] - logs[1]) > np.log(LIMIT):
        return [0, 1]
    return list(find_outliers(logs, ALARMS, float(np.log(LEAST)), float(np.log(LIMIT))))


def _check_ratio(ratios: Mapping[str, float]) -> Check:
    """Return the check that static friction exceeds kinetic friction by a plausible factor."""
    low, high = RATIO
    outside = [f"{name} {ratio:.3g}" for name, ratio in ratios.items() if not low <= ratio <= high]
    lowest, highest = min(ratios.values()), max(ratios.values())
    sentence = f"the ratio of static to kinetic friction is {lowest:.3g} to {highest:.3g}"
    wrong = f", outside {low:g} to {high:g} in {', '.join(outside)}: check the window and the zero"
    return check("static over kinetic", not outside, sentence, wrong, "failed")


def _check_film(means: Mapping[str, OverRepeats | None], reference: Reference) -> Check | None:
    """Return the comparison with the brake's own friction or, if unknown, with its film's."""
    means_known = {name: mean for name, mean in means.items() if mean is not None}
    comparable = {name: mean for name, mean in means_known.items() if name in reference.earlier}
    if not comparable:
        kinetic = means_known.get("kinetic")
        return None if kinetic is None else _check_plausibility(kinetic.mean, reference.span)
    rows = [
        _compare_with_own(name, mean, *reference.earlier[name]) for name, mean in comparable.items()
    ]
    worst = max((level for level, _ in rows), key=LEVELS_BY_SEVERITY.index)
    advice = ": check the unit of force, the lever arm, the normal force and the film"
    return check("film", worst == "passed", "; ".join(text for _, text in rows), advice, worst)


def _compare_with_own(
    name: str, mean: OverRepeats, previous: float, sd: float
) -> tuple[Level, str]:
    """Return the level of a difference from the brake's own value, and a sentence."""
    ratio = mean.mean / previous
    uncertainty = math.hypot(sd, (mean.standard_error or sd * mean.mean) / mean.mean)
    level: Level = "passed"
    for worse, (factor, times) in LEVELS.items():
        if abs(math.log(ratio)) > max(math.log(factor), times * uncertainty):
            level = worse
    return level, (
        f"{name} friction is {ratio:.3g} times the brake's own measured value, {previous:.3g} "
        f"(SD {sd:.1%})"
    )


def _check_plausibility(kinetic: float, span: tuple[float, float] | None) -> Check:
    low, high = span or USUAL
    is_plausible = low <= kinetic <= high
    whose = "the catalogue's range for this film" if span else "the usual range for films"
    sentence = (
        f"a kinetic friction of {kinetic:.3g} is {'in' if is_plausible else 'outside'} {whose}, "
    )
    sentence += f"{low:.3g} to {high:.3g}"
    advice = ": check the unit of force, the normal force and the film"
    return check("film", is_plausible, sentence, advice, "failed")
