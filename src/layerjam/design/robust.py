"""Effect of scatter in friction on a design: the probability that it meets each constraint."""

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.control.plan_spread import log_normal
from layerjam.design.merit import Point
from layerjam.design.requirements import DesignSpecification
from layerjam.design.stopping import all_merits


class Chance(NamedTuple):
    """Probability that a constraint is met."""

    probability: float
    error: float
    """Standard error of the probability, at least 1/samples."""
    low: float
    """5 % quantile of the quantity [SI]; NaN if more than 5 % of the samples have no value."""
    high: float
    """95 % quantile of the quantity [SI]."""


def robustness(spec: DesignSpecification, point: Point) -> dict[str, Chance]:
    """Return {constraint: Chance} and "all" for a design with log-normal friction.

    Static and kinetic friction vary independently around their stated values. Samples come from a
    counter-based generator (Philox), so a seed produces the same numbers on any machine.
    """
    scatter = spec.scatter
    if scatter is None:
        return {}
    rng = np.random.Generator(np.random.Philox(scatter.seed))
    shares = np.clip(rng.random((2, scatter.samples)), 2.0**-54, 1 - 2.0**-53)
    film = point.stock
    film_samples = film._replace(
        static=log_normal(shares[0], float(film.static), scatter.static * float(film.static)),
        kinetic=log_normal(shares[1], float(film.kinetic), scatter.kinetic * float(film.kinetic)),
    )
    point, evaluation = point._replace(stock=film_samples), spec.evaluation
    out = all_merits(
        point, evaluation.base, evaluation.stick_slip, evaluation.stop, spec.grid.max_series
    )
    all_hold = np.ones(scatter.samples, bool)
    chances: dict[str, Chance] = {}
    for c in spec.constraints:
        if c.name not in out:
            continue
        value = np.broadcast_to(np.asarray(out[c.name]), (scatter.samples,))
        holds = np.asarray(c.is_met(value))
        all_hold &= holds
        chances[str(c)] = Chance(*_estimate_chance(holds), *_value_range(value))
    if chances:
        chances["all"] = Chance(*_estimate_chance(all_hold), math.nan, math.nan)
    return chances


def _estimate_chance(holds: Any) -> tuple[float, float]:
    part, count = float(holds.mean()), len(holds)
    return part, max(math.sqrt(part * (1 - part) / count), 1 / count)


def _value_range(value: Any) -> tuple[float, float]:
    # if the mass does not stop, the slip is infinite, which exceeds every limit
    samples = np.sort(np.where(np.isnan(value), np.inf, value))
    low, high = (float(samples[int(part * len(samples))]) for part in (0.05, 0.95))
    return (low if math.isfinite(low) else math.nan, high if math.isfinite(high) else math.nan)
