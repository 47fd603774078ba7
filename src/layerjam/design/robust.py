"""What the scatter of the friction does to a design: how likely each constraint holds."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.control.plan_spread import log_normal
from layerjam.design.merit import Point
from layerjam.design.requirements import DesignSpecification
from layerjam.design.stopping import judged


class Chance(NamedTuple):
    """How likely a constraint holds."""

    probability: float
    error: float
    """Standard error; never below one sample's weight."""
    low: float
    """5 % quantile of the quantity, SI; NaN where more of the samples have none."""
    high: float
    """95 % quantile."""


def robustness(spec: DesignSpecification, point: Point) -> dict[str, Chance]:
    """{constraint: Chance} and "all" for a design, friction log-normal around what is stated.

    Static and kinetic friction vary independently of each other; samples come from a counter-based
    generator (Philox), so that a seed gives the same numbers anywhere.
    """
    scatter = spec.scatter
    if scatter is None:
        return {}
    rng = np.random.Generator(np.random.Philox(scatter.seed))
    shares = np.clip(rng.random((2, scatter.samples)), 2.0**-54, 1 - 2.0**-53)
    film = point.stock
    drawn = film._replace(
        static=log_normal(shares[0], float(film.static), scatter.static * float(film.static)),
        kinetic=log_normal(shares[1], float(film.kinetic), scatter.kinetic * float(film.kinetic)),
    )
    at, asked = point._replace(stock=drawn), spec.evaluation
    out = judged(at, asked.base, asked.stick_slip, asked.stop, spec.grid.most_in_row)
    every = np.ones(scatter.samples, bool)
    found: dict[str, Chance] = {}
    for c in spec.constraints:
        if c.name not in out:
            continue
        value = np.broadcast_to(np.asarray(out[c.name]), (scatter.samples,))
        holds = np.asarray(c.holds(value))
        every &= holds
        found[str(c)] = Chance(*_share(holds), *_range(value))
    if found:
        found["all"] = Chance(*_share(every), math.nan, math.nan)
    return found


def _share(holds: Any) -> tuple[float, float]:
    part, count = float(holds.mean()), len(holds)
    return part, max(math.sqrt(part * (1 - part) / count), 1 / count)


def _range(value: Any) -> tuple[float, float]:
    # a design that does not stop has no finite slip: it counts as beyond every limit
    whole = np.sort(np.where(np.isnan(value), np.inf, value))
    low, high = (float(whole[int(part * len(whole))]) for part in (0.05, 0.95))
    return (low if math.isfinite(low) else math.nan, high if math.isfinite(high) else math.nan)
