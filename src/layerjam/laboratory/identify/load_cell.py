"""Faults of a load cell that a record shows: its zero and its resolution, and their checks.

A zero error and a real preload look the same. Neither is subtracted unless the user says so. The
zero of a vented pressure gauge is found in the same way.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from layerjam.core.verdict import Check, Level, check
from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.measure.noise import noise_sd, running_mean
from layerjam.laboratory.measure.trace import Array

FEWEST = 5
"""Minimum number of samples before the load for a zero."""
RISEN = 0.1
"""Part of the rise that ends the section before the load."""
CERTAIN = 4.0
"""Number of standard errors beyond which a zero differs from nothing."""
UNLOADED = 0.5
"""Largest force at the end of a record, relative to the load, if the specimen is unloaded again."""
STEADY = 0.02
"""Largest scatter of that force, relative to the load."""
NOTICED, LARGE = 0.02, 0.10
"""Relative effects of a zero error on a result above which its check warns and fails."""
COARSE, TOO_COARSE = 0.02, 0.05
"""Relative effects of the resolution on a result above which its check warns and fails."""
CAUSE = "a zero error, or a preload (--tare subtracts it)"
"""Causes of a force before the load, with the remedy."""


@dataclass(frozen=True, kw_only=True)
class Zero:
    """Force before the load, with its standard error [N]."""

    force: float
    error: float

    def effect(self, reading: float) -> float:
        """Return the relative change of a measured force [N]; 0 if it may be due to chance."""
        if abs(self.force) <= CERTAIN * self.error:
            return 0.0
        true = reading - self.force
        return self.force / true if true > 0 else float("inf")


def find_zero(force: Array, level: float) -> Zero | None:
    """Return the force before a load that rises to about `level` [N], or None.

    It is None if the record begins during the rise, or with fewer than `FEWEST` samples before it.
    """
    noise = noise_sd(force)
    first = float(np.median(force[:FEWEST]))
    rise = level - first
    if rise <= 0:
        return None
    smooth = running_mean(force, 3) - first
    risen = np.flatnonzero(smooth > max(RISEN * rise, FEWEST * noise))
    if not len(risen):
        return None
    count = int(risen[0]) - max(1, int(risen[0]) // 10)
    if count < FEWEST:
        return None
    quiet = force[:count]
    nearly_risen = np.flatnonzero(smooth > (1 - RISEN) * rise)
    steepness = rise / max(int(nearly_risen[0]) - int(risen[0]), 1) if len(nearly_risen) else rise
    line = fit_line(np.arange(count, dtype=float), quiet)
    if line is not None and line.slope - 3 * line.slope_se > RISEN * steepness:
        return None
    return Zero(force=float(quiet.mean()), error=float(quiet.std(ddof=1)) / count**0.5)


def find_released_force(after: Array, level: float) -> float | None:
    """Return the force [N] at the end of the samples after a test at about `level` [N].

    It is None if the force is not steady and much smaller there, as it is without a load.
    """
    if len(after) < FEWEST:
        return None
    end = after[-max(len(after) // 5, FEWEST) :]
    mean = float(end.mean())
    steady = float(end.std()) < max(STEADY * abs(level), 3 * noise_sd(end))
    return mean if steady and abs(mean) < UNLOADED * abs(level) else None


def check_zero(
    effects: Mapping[str, tuple[str, float]],
    result: str,
    quantity: str = "force",
    moment: str = "before the load rises",
    cause: str = CAUSE,
) -> Check:
    """Return the check that the zero of the load cell does not change a result.

    `effects` is {file: (force before the load as text, relative change of the result)} of the files
    that show it; the check is a note if none does. `result` names the result, `quantity` what the
    file contains, and `moment` when nothing is loaded.
    """
    if not effects:
        sentence = f"no record shows the {quantity} before its load, so the zero is unknown"
        return check("zero", False, sentence, level="note")
    effects_above = {name: row for name, row in effects.items() if abs(row[1]) > NOTICED}
    if not effects_above:
        sentence = f"the {quantity} {moment} changes {result} by {NOTICED:.0%} at most"
        return check("zero", True, sentence)
    worst = max(effects_above, key=lambda name: abs(effects_above[name][1]))
    force, effect = effects_above[worst]
    more_text = f" (and in {len(effects_above) - 1} more)" if len(effects_above) > 1 else ""
    sentence = f"the {quantity} in {worst}{more_text} is {force} {moment}"
    advice = f", which changes {result} by {effect:+.0%}: {cause}"
    return check("zero", False, sentence, advice, "failed" if abs(effect) > LARGE else "warning")


def check_drift(
    name: str, effect: float, result: str, cause: str, may_be_zero: bool = True
) -> Check:
    """Return the check that a drift of the force does not change a result.

    `effect` is the relative change in the file `name`, the largest of all. It fails only if it may
    be a drift of the zero.
    """
    if abs(effect) <= NOTICED:
        sentence = f"a drift of the force changes {result} by {NOTICED:.0%} at most"
        return check("drift", True, sentence)
    level: Level = "failed" if abs(effect) > LARGE and may_be_zero else "warning"
    sentence = f"the force in {name} drifts, which changes {result} by {effect:+.0%}"
    return check("drift", False, sentence, f": {cause}", level)


def check_resolution(effects: Mapping[str, float], step: str) -> Check:
    """Return the check that the load cell's resolution determines the results.

    `effects` is {quantity: largest relative error due to the resolution}; `step` is the resolution
    as text.
    """
    worst = max(effects, key=lambda name: effects[name])
    sentence = (
        f"the resolution of {step} changes {worst} by at most {max(effects[worst], 1e-3):.1%}"
    )
    level: Level = "failed" if effects[worst] > TOO_COARSE else "warning"
    advice = ": use a load cell with a smaller range"
    return check("resolution", effects[worst] <= COARSE, sentence, advice, level)
