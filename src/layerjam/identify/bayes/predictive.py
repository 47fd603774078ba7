"""What a Bayesian fit says of forces, of the vacuum for a force and of a drop: bands and chances.

Every prediction is made for each of the possible brakes of a `Population`, and its quantiles are
taken over them. "Cannot" is an answer: where no vacuum gives the force, or the travel is used up,
that draw counts as infinite, and the chance of it is given. A quantile that is infinite says just
that: with that probability or more there is no such number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from layerjam.errors import QuantityError
from layerjam.identify.bayes.posterior import Population
from layerjam.mechanics import pull as law
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, SNAPS, STOPPED, stop
from layerjam.units import show

LEVELS = (0.025, 0.25, 0.5, 0.75, 0.975)
Array = np.ndarray[Any, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """Quantiles of one quantity, SI units.

    `values` has shape (levels, n) and may be infinite; `chances` {what else happened: (n,)}.
    """

    quantity: str
    unit: str
    levels: tuple[float, ...]
    values: Array
    chances: dict[str, Array] = field(default_factory=dict)

    def at(self, level: float) -> Array:
        """One of the quantiles, shape (n,); KeyError for a level that was not asked for."""
        if level not in self.levels:
            raise KeyError(f"no quantile at {level:g}; there are {self.levels}")
        return np.asarray(self.values[self.levels.index(level)])

    def sentence(self, place: int = 0) -> str:
        """The median, the outermost quantiles and every chance, in words."""
        low, high = self.values[0, place], self.values[-1, place]
        middle = self.values[int(np.argmin(np.abs(np.array(self.levels) - 0.5))), place]
        told = f"{self.quantity} {_told(middle, self.unit)} ({self.levels[0]:.3g} to "
        told += f"{self.levels[-1]:.3g}: {_told(low, self.unit)} to {_told(high, self.unit)})"
        also = [f"{w} {c[place]:.1%}" for w, c in self.chances.items() if c[place] > 0]
        return "; ".join([told, *also])


def _told(value: float, unit: str) -> str:
    if np.isnan(value):
        return "not known"
    return show(float(value), unit) if np.isfinite(value) else ("none" if value > 0 else "below")


def _quantiles(values: Array, levels: Sequence[float]) -> Array:
    """Order statistics over the draws, so that infinite ones do not spread; NaN where all are."""
    known = ~np.isnan(values)
    ranked = np.sort(np.where(known, values, np.inf), axis=0)
    count = known.sum(axis=0)
    out = np.full((len(levels), values.shape[1]), np.nan)
    for row, level in enumerate(levels):
        place = np.clip(np.ceil(level * count).astype(int) - 1, 0, len(values) - 1)
        found = np.take_along_axis(ranked, place[None], axis=0)[0]
        out[row] = np.where(count > 0, found, np.nan)
    return out


def _band(
    quantity: str, unit: str, values: Array, levels: Sequence[float], chances: dict[str, Array]
) -> Band:
    for level in levels:
        if not 0 < level < 1:
            raise QuantityError(f"levels: {level:g} is not allowed; it lies between 0 and 1")
    found = _quantiles(values, levels)
    return Band(quantity=quantity, unit=unit, levels=tuple(levels), values=found, chances=chances)


def _row(name: str, values: Any, unit: str, open_low: bool = False) -> Array:
    """One or more SI numbers as (1, n); QuantityError below zero or not finite."""
    row = np.atleast_1d(np.asarray(values, float))
    wrong = ~np.isfinite(row) | (row < 0) | (open_low & (row == 0))
    if row.ndim != 1 or wrong.any():
        shown = show(float(row[wrong].ravel()[0]), unit) if wrong.any() else "a table"
        allowed = "more than zero" if open_low else "zero or more"
        raise QuantityError(f"{name}: {shown} is not allowed; it is {allowed}")
    return row[None]


def force_band(
    of: Population,
    elongation: Any,
    vacuum: float,
    *,
    levels: Sequence[float] = LEVELS,
    measured: bool = False,
    seed: int = 1,
) -> Band:
    """Force [N] of a pull at elongations [m], shape (n,), and one vacuum [Pa].

    With `measured` the scatter of a measured curve about the law comes on top. A brake too soft for
    its friction snaps instead (chance "snaps"); quantiles are of those that do not.
    """
    u, pressure = _row("elongation", elongation, "m"), _row("vacuum", vacuum, "Pa")
    force = np.asarray(law.force_at_elongation(u, pressure, of.brakes()))
    snaps = np.isnan(force).mean(axis=0)
    if measured:
        height = np.nanmax(np.asarray(law.peak(pressure, u.max(), of.brakes()).force), axis=1)
        random = np.random.default_rng([seed, 3])
        noise = random.standard_normal((len(of), u.shape[1]))
        force = force + noise * (of.residual * height)[:, None]
    chances = {"snaps": snaps} if snaps.any() else {}
    return _band("force", "N", force, levels, chances)


def peak_band(
    of: Population, vacuum: Any, travel: float | None = None, *, levels: Sequence[float] = LEVELS
) -> Band:
    """Greatest force [N] of a slow pull at vacuums [Pa], shape (n,), over a slip `travel` [m].

    The usable travel unless given. Where the force rises to the end of travel, that end counts.
    """
    way = of.brake.sheets.usable_travel if travel is None else float(_row("travel", travel, "m"))
    found = law.peak(_row("vacuum", vacuum, "Pa"), way, of.brakes())
    rises = 1 - np.asarray(found.inside).mean(axis=0)
    return _band("peak force", "N", np.asarray(found.force), levels, {"rises to the end": rises})


def vacuum_band(
    of: Population, force: Any, slip: float, *, levels: Sequence[float] = LEVELS
) -> Band:
    """Vacuum [Pa] at which the brake resists with forces [N], shape (n,), at one slip [m].

    Chances: "too strong", more than the site's full vacuum gives (counts as +infinity), and
    "enclosure alone", the enclosure alone resists more (counts as -infinity).
    """
    asked, place = _row("force", force, "N"), _row("slip", slip, "m")
    overlap = of.brake.sheets.overlap
    if place.max() > overlap:
        raise QuantityError(
            f"slip: {show(float(place.max()), 'm')} is not allowed; it is at most the overlap, "
            f"{show(float(overlap), 'm')}"
        )
    brakes = of.brakes()
    least, most = (np.asarray(x) for x in law.force_limits(place, brakes))
    full = np.broadcast_to(asked, (len(of), asked.shape[1]))
    vacuum = np.array(law.vacuum_for_force(full, place, brakes))
    above, below = asked > most, asked < least
    vacuum[above], vacuum[below] = np.inf, -np.inf
    chances = {"too strong": above.mean(axis=0), "enclosure alone": below.mean(axis=0)}
    return _band("vacuum", "Pa", vacuum, levels, chances)


class DropBand(NamedTuple):
    """A drop, predicted: every band has shape (levels, n); speeds vary along n."""

    slip: Band
    """At standstill [m]; infinite where the travel is used up before or the brake snaps."""
    peak_force: Band
    """Greatest force until the standstill [N]; infinite as the slip is."""
    chances: dict[str, Array]
    """{"stopped", "never slid", "bottomed out", "snaps"}, shape (n,); they add up to 1."""


def drop_band(
    of: Population,
    *,
    mass: float,
    speed: Any,
    vacuum: Any,
    rope_stiffness: float | None = None,
    gravity: float | None = None,
    levels: Sequence[float] = LEVELS,
) -> DropBand:
    """A mass [kg] that arrives with `speed` [m/s] on the brake at `vacuum` [Pa]; these two pair up.

    One of them may have shape (n,), or both. `rope_stiffness` [N/m], None for no rope, in series
    with each draw's brake; `gravity` [m/s^2] along the pull, the site's unless given.
    """
    heavy = _row("mass", mass, "kg", open_low=True)
    pace, pressure = np.broadcast_arrays(_row("speed", speed, "m/s"), _row("vacuum", vacuum, "Pa"))
    pull = of.brake.site.gravity if gravity is None else float(_row("gravity", gravity, "m/s^2"))
    brakes = of.brakes()
    spring = np.asarray(working_stiffness(brakes))
    if rope_stiffness is not None:
        spring = 1 / (1 / spring + 1 / _row("rope", rope_stiffness, "N/m", open_low=True))
    full = (len(of), pace.shape[1])
    case = [np.broadcast_to(v, full) for v in (heavy, pace, pressure, spring, pull)]
    found = stop(case[0], case[1], case[2], case[3], case[4], brakes)
    outcome = np.asarray(found.outcome)
    names = {STOPPED: "stopped", NEVER_SLID: "never slid", BOTTOMED_OUT: "bottomed out"}
    names[SNAPS] = "snaps"
    chances = {word: (outcome == code).mean(axis=0) for code, word in names.items()}
    lost = (outcome == BOTTOMED_OUT) | (outcome == SNAPS)
    slip = np.where(lost, np.inf, np.asarray(found.slip))
    peak = np.where(lost, np.inf, np.asarray(found.peak_force))
    missed = {w: chances[w] for w in ("bottomed out", "snaps")}
    return DropBand(
        _band("slip", "m", slip, levels, missed),
        _band("peak force", "N", peak, levels, missed),
        chances,
    )
