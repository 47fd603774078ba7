"""Predictions of a Bayesian fit: bands for forces, for the vacuum of a force, and for a drop.

Each prediction is computed for every possible brake of a `Population`; its quantiles are those of
the results. If no vacuum gives the force, or the travel is used up, the draw counts as infinite,
and the probability of this is reported. A quantile is infinite if enough draws are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics import pull as law
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, SNAPS, STOPPED, stop
from layerjam.core.errors import QuantityError
from layerjam.core.units import show
from layerjam.laboratory.identify.bayes.posterior import Population

LEVELS = (0.025, 0.25, 0.5, 0.75, 0.975)
Array = np.ndarray[Any, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """Quantiles of one quantity, in SI units.

    `values` has shape (levels, n) and may be infinite; `chances` are {other outcome: (n,)}.
    """

    quantity: str
    unit: str
    levels: tuple[float, ...]
    values: Array
    chances: dict[str, Array] = field(default_factory=dict)

    def quantile_at(self, level: float) -> Array:
        """Return one of the quantiles, shape (n,); raises KeyError for any other level."""
        if level not in self.levels:
            raise KeyError(f"no quantile at {level:g}; available: {self.levels}")
        return np.asarray(self.values[self.levels.index(level)])

    at = quantile_at  # former name

    def sentence(self, place: int = 0) -> str:
        """Return the median, the outermost quantiles and every probability as text."""
        low, high = self.values[0, place], self.values[-1, place]
        middle = self.values[int(np.argmin(np.abs(np.array(self.levels) - 0.5))), place]
        text = f"{self.quantity} {_show_value(middle, self.unit)} ({self.levels[0]:.3g} to "
        ends = " to ".join(_show_value(end, self.unit) for end in (low, high))
        text += f"{self.levels[-1]:.3g}: {ends})"
        also = [f"{w} {c[place]:.1%}" for w, c in self.chances.items() if c[place] > 0]
        return "; ".join([text, *also])


def _show_value(value: float, unit: str) -> str:
    if np.isnan(value):
        return "not known"
    return show(float(value), unit) if np.isfinite(value) else ("none" if value > 0 else "below")


def _draw_quantiles(values: Array, levels: Sequence[float]) -> Array:
    """Return quantiles chosen among draws, because infinite ones cannot be interpolated."""
    is_known = ~np.isnan(values)
    sorted_values = np.sort(np.where(is_known, values, np.inf), axis=0)
    count = is_known.sum(axis=0)
    out = np.full((len(levels), values.shape[1]), np.nan)
    for row, level in enumerate(levels):
        place = np.clip(np.ceil(level * count).astype(int) - 1, 0, len(values) - 1)
        row_values = np.take_along_axis(sorted_values, place[None], axis=0)[0]
        out[row] = np.where(count > 0, row_values, np.nan)
    return out


def _make_band(
    quantity: str, unit: str, values: Array, levels: Sequence[float], chances: dict[str, Array]
) -> Band:
    for level in levels:
        if not 0 < level < 1:
            raise QuantityError(f"levels: {level:g} is not allowed; it must be between 0 and 1")
    quantiles = _draw_quantiles(values, levels)
    return Band(
        quantity=quantity, unit=unit, levels=tuple(levels), values=quantiles, chances=chances
    )


def _to_row(name: str, values: Any, unit: str, open_low: bool = False) -> Array:
    """Return SI numbers as (1, n); raises QuantityError if one is negative or not finite."""
    row = np.atleast_1d(np.asarray(values, float))
    wrong = ~np.isfinite(row) | (row < 0) | (open_low & (row == 0))
    if row.ndim != 1 or wrong.any():
        value = show(float(row[wrong].ravel()[0]), unit) if wrong.any() else "a table"
        expectation = "more than zero" if open_low else "zero or more"
        raise QuantityError(f"{name}: {value} is not allowed; it must be {expectation}")
    return row[None]


def force_band(
    draws: Population,
    elongation: Any,
    vacuum: float,
    *,
    levels: Sequence[float] = LEVELS,
    measured: bool = False,
    seed: int = 1,
) -> Band:
    """Return the force [N] of a pull at elongations [m], shape (n,), and one vacuum [Pa].

    `measured` adds the scatter of a measured curve about the law. A brake too soft for its friction
    snaps instead (probability "snaps"); quantiles are those of the draws that do not snap.
    """
    u, pressure = _to_row("elongation", elongation, "m"), _to_row("vacuum", vacuum, "Pa")
    force = np.asarray(law.force_at_elongation(u, pressure, draws.brakes()))
    snap_share = np.isnan(force).mean(axis=0)
    if measured:
        height = np.nanmax(np.asarray(law.peak(pressure, u.max(), draws.brakes()).force), axis=1)
        random = np.random.default_rng([seed, 3])
        noise = random.standard_normal((len(draws), u.shape[1]))
        force = force + noise * (draws.residual * height)[:, None]
    chances = {"snaps": snap_share} if snap_share.any() else {}
    return _make_band("force", "N", force, levels, chances)


def peak_band(
    draws: Population,
    vacuum: Any,
    travel: float | None = None,
    *,
    levels: Sequence[float] = LEVELS,
) -> Band:
    """Return the maximum force [N] of a slow pull at vacuums [Pa], (n,), over a slip `travel` [m].

    The default is the usable travel. If the force still rises at the end of the slip, its value
    there is used.
    """
    longest = (
        draws.brake.sheets.usable_travel
        if travel is None
        else float(_to_row("travel", travel, "m"))
    )
    peak = law.peak(_to_row("vacuum", vacuum, "Pa"), longest, draws.brakes())
    rising_share = 1 - np.asarray(peak.inside).mean(axis=0)
    return _make_band(
        "peak force", "N", np.asarray(peak.force), levels, {"rises to the end": rising_share}
    )


def vacuum_band(
    draws: Population, force: Any, slip: float, *, levels: Sequence[float] = LEVELS
) -> Band:
    """Return the vacuum [Pa] for brake forces [N], shape (n,), at one slip [m].

    Probabilities: "too strong" if the force needs more than the site's full vacuum (counts as
    +infinity); "enclosure alone" if the enclosure alone resists more (counts as -infinity).
    """
    forces, place = _to_row("force", force, "N"), _to_row("slip", slip, "m")
    overlap = draws.brake.sheets.overlap
    if place.max() > overlap:
        raise QuantityError(
            f"slip: {show(float(place.max()), 'm')} is not allowed; it must be at most the "
            f"overlap, {show(float(overlap), 'm')}"
        )
    brakes = draws.brakes()
    lowest_force, highest_force = (np.asarray(x) for x in law.force_limits(place, brakes))
    full_forces = np.broadcast_to(forces, (len(draws), forces.shape[1]))
    vacuum = np.array(law.vacuum_for_force(full_forces, place, brakes))
    above, below = forces > highest_force, forces < lowest_force
    vacuum[above], vacuum[below] = np.inf, -np.inf
    chances = {"too strong": above.mean(axis=0), "enclosure alone": below.mean(axis=0)}
    return _make_band("vacuum", "Pa", vacuum, levels, chances)


class DropBand(NamedTuple):
    """Prediction of a drop; every band has shape (levels, n), with n the number of speeds."""

    slip: Band
    """Slip at standstill [m]; infinite if the travel is used up earlier or the brake snaps."""
    peak_force: Band
    """Maximum force until standstill [N]; infinite if the slip is."""
    chances: dict[str, Array]
    """{"stopped", "never slid", "bottomed out", "snaps": probability}, shape (n,), summing to 1."""


def drop_band(
    draws: Population,
    *,
    mass: float,
    speed: Any,
    vacuum: Any,
    rope_stiffness: float | None = None,
    gravity: float | None = None,
    levels: Sequence[float] = LEVELS,
) -> DropBand:
    """Predict the drop of a mass [kg] with `speed` [m/s] onto the brake at `vacuum` [Pa].

    Speed and vacuum may each be one number or have shape (n,). `rope_stiffness` [N/m] is in series
    with each brake; None means no rope. `gravity` [m/s^2] acts along the pull; its default is that
    of the site.
    """
    heavy = _to_row("mass", mass, "kg", open_low=True)
    pace, pressure = np.broadcast_arrays(
        _to_row("speed", speed, "m/s"), _to_row("vacuum", vacuum, "Pa")
    )
    pull = (
        draws.brake.site.gravity if gravity is None else float(_to_row("gravity", gravity, "m/s^2"))
    )
    brakes = draws.brakes()
    spring = np.asarray(working_stiffness(brakes))
    if rope_stiffness is not None:
        spring = 1 / (1 / spring + 1 / _to_row("rope", rope_stiffness, "N/m", open_low=True))
    shape = (len(draws), pace.shape[1])
    case = [np.broadcast_to(v, shape) for v in (heavy, pace, pressure, spring, pull)]
    stops = stop(case[0], case[1], case[2], case[3], case[4], brakes)
    outcome = np.asarray(stops.outcome)
    names = {STOPPED: "stopped", NEVER_SLID: "never slid", BOTTOMED_OUT: "bottomed out"}
    names[SNAPS] = "snaps"
    chances = {word: (outcome == code).mean(axis=0) for code, word in names.items()}
    is_lost = (outcome == BOTTOMED_OUT) | (outcome == SNAPS)
    slip = np.where(is_lost, np.inf, np.asarray(stops.slip))
    peak = np.where(is_lost, np.inf, np.asarray(stops.peak_force))
    failures = {w: chances[w] for w in ("bottomed out", "snaps")}
    return DropBand(
        _make_band("slip", "m", slip, levels, failures),
        _make_band("peak force", "N", peak, levels, failures),
        chances,
    )
