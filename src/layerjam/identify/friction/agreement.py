"""Checks of friction tests: each repeat against the others, and all against the catalogue.

A wrong unit changes static and kinetic friction alike, so their ratio does not reveal it. Each is
therefore compared with its own repeats. Grubbs' test detects a small error in repeats that scatter
little. It has little power with few repeats, so a limit on the distance from the median detects
gross errors.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from layerjam.device.file import BrakeFile, materials
from layerjam.device.load import devices, load
from layerjam.identify.friction.stribeck import USUAL
from layerjam.identify.odd import find_outliers
from layerjam.identify.statistics import OverRepeats
from layerjam.toml_files.toml import parse_toml
from layerjam.verdict import Check, check, interval_check

SPOKEN = {"static": "static friction", "kinetic": "kinetic friction", "speed": "speed"}
ALARMS = 0.01
"""Probability that Grubbs' test reports an outlier in one quantity of fault-free repeats."""
LEAST, LIMIT = 1.2, 1.5
"""Ratio to the others below which a repeat is never an outlier, and above which it always is. Choi
2018, table I: static friction scatters by 8 % (SD), kinetic friction by 3 %."""
RATIO = (0.9, 4.0)
"""Plausible ratio of static to kinetic friction. Table I: 1.3 (Kapton) and 2.4 (PTFE)."""
MARGIN = 2.0
"""Factor by which the catalogue's range of a film's friction is widened at both ends."""


def film_friction_range(file: BrakeFile) -> tuple[float, float]:
    """Return the plausible range of kinetic friction [-] for a brake's film.

    It spans the brake's own value and all values of that film in the catalogue, widened by
    `MARGIN`.
    """
    product = file.known_values.get("film.product")
    values = [file.brake.film.kinetic]
    for name, text in materials()["films"].items():
        film = parse_toml(text, name)
        if film["name"] == product:
            values.append(film["kinetic"]["value"])
    files = [f for f in map(load, devices()) if f.known_values.get("film.product") == product]
    values += [device.brake.film.kinetic for device in files]
    return min(values) / MARGIN, max(values) * MARGIN


def check_friction(
    files: Sequence[str],
    values: Mapping[str, Sequence[float | None]],
    means: Mapping[str, OverRepeats | None],
    span: tuple[float, float] | None = None,
) -> tuple[Check, ...]:
    """Return the checks of friction tests, one for each of `files`.

    `values` has static and kinetic friction [-] and speed [m/s] of each test, None if unknown, and
    `means` the means over them. `span` is from `film_friction_range`, None if the film is unknown.
    """
    names = [Path(file).name or f"repeat {place}" for place, file in enumerate(files, 1)]
    quantities = {SPOKEN[name]: value for name, value in values.items()}
    advice = "check its unit, normal force and film"
    checks = [check_repeats(names, quantities, "films normally vary", advice)]
    for name, mean in means.items():
        if mean is not None and mean.low is not None and mean.high is not None:
            # as wide as the interval about the mean; a log scale would reject more campaigns
            reach = mean.mean * math.log(mean.high / mean.mean)
            low = max(mean.mean - reach, mean.low)
            checks.append(interval_check(f"{name} friction", mean.mean, low, mean.mean + reach))
    both = zip(values["static"], values["kinetic"], names, strict=True)
    ratios = {name: static / kinetic for static, kinetic, name in both if static and kinetic}
    if ratios:
        checks.append(_check_ratio(ratios))
    if (mean := means["kinetic"]) is not None:
        checks.append(_check_plausibility(mean.mean, span))
    return tuple(checks)


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
        others = np.delete(logs, outliers) if len(outliers) < len(logs) else logs
        for place in outliers:
            ratio = float(np.exp(logs[place] - np.median(others)))
            outlier_texts.append(
                f"{quantity} of {numbers[place][1]} is {ratio:.3g} times that of the others"
            )
    if len(names) < 2:
        return check("repeats", False, "only one repeat: its repeatability is unknown")
    fine = f"none of the {len(names)} repeats differs from the others by more than {scatter}"
    otherwise = f": {advice}, or leave the file out"
    return check(
        "repeats", not outlier_texts, "; ".join(outlier_texts) or fine, otherwise, "failed"
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
    least, greatest = min(ratios.values()), max(ratios.values())
    sentence = f"the ratio of static to kinetic friction is {least:.3g} to {greatest:.3g}"
    wrong = f", outside {low:g} to {high:g} in {', '.join(outside)}: check the window and the zero"
    return check("static over kinetic", not outside, sentence, wrong, "failed")


def _check_plausibility(kinetic: float, span: tuple[float, float] | None) -> Check:
    low, high = span or USUAL
    fine = low <= kinetic <= high
    whose = "the catalogue's range for this film" if span else "the usual range for films"
    sentence = f"a kinetic friction of {kinetic:.3g} is {'in' if fine else 'outside'} {whose}, "
    sentence += f"{low:.3g} to {high:.3g}"
    advice = ": check the unit of force, the normal force and the film"
    return check("film", fine, sentence, advice, "failed")
