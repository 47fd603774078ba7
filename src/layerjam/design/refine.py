"""From the best design of a grid to the best there is: continuous variables by their gradients.

The merits are differentiated by JAX, the search is SciPy's SLSQP on their logarithms. What stays:
film, thickness, whole numbers and whatever the specification gives as a list or one value.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from layerjam.design.bill import bills
from layerjam.design.merit import (
    DRAWN_MERITS,
    LINE_MERITS,
    MERITS,
    VARIABLES,
    Point,
    Stock,
    line_merits,
)
from layerjam.design.requirements import Constraint, DesignSpecification
from layerjam.design.stopping import judged

Array = npt.NDArray[np.float64]
LENGTHS = tuple(n for n, spec in VARIABLES.items() if not spec.whole and n != "usable_travel")
FILM = tuple(n for n in Stock._fields if n != "strength")
NEAR = 1e-5
"""Relative step for slopes of closed forms that are not traced: of the line, of a drawn brake."""
ACCURACY = 1e-9
ROUNDS, DRAWN_ROUNDS = 200, 40
"""Rounds of the search; fewer if drawn parts matter, whose steps it cannot follow to the end."""
BAD = 1e3
"""Cost of a design that is none; ln of a merit is never near."""


def changed(point: Point, values: dict[str, Any]) -> Point:
    """The design with other variables; names of FILM go to its stock."""
    film = {n: v for n, v in values.items() if n in FILM}
    rest = {n: v for n, v in values.items() if n not in FILM}
    if film:
        rest["stock"] = point.stock._replace(**film)
    return point._replace(**rest)


@functools.partial(jax.jit, static_argnames=("names", "row"))
def _values(x: Any, point: Point, more: Any, *, names: tuple[str, ...], row: int) -> Any:
    """ln of all merits at values `x` of the variables `names`; stop's last."""
    base, pulled, wanted = more
    at = changed(point, dict(zip(names, x, strict=True)))
    out = judged(at, base, pulled, wanted, row)
    return jnp.log(jnp.stack([jnp.asarray(out[n], float) for n in sorted(out)]))


_slopes = jax.jit(jax.jacfwd(_values), static_argnames=("names", "row"))


class Smooth:
    """ln of one design's merits as a function of its lengths, vacuum and film, and the slopes.

    Always of all of them, so that every specification uses the same compiled function. Those of the
    drawn brake are not traced: their slopes are differences, and only where they are asked for.
    """

    def __init__(
        self, spec: DesignSpecification, point: Point, among: Collection[str] | None = None
    ) -> None:
        """`among`: the only variables whose slopes will be asked for; all of them without it."""
        self.spec = spec
        self.point = jax.tree.map(float, point)
        travel = () if point.usable_travel is None else ("usable_travel",)
        self.names = (*LENGTHS, *travel, *FILM)
        place = {n: self.point.stock if n in FILM else self.point for n in self.names}
        self.start = np.array([float(getattr(place[n], n)) for n in self.names])
        asked = spec.evaluation
        self.more = (asked.base, asked.stick_slip, asked.stop)
        self.row = spec.grid.most_in_row
        own = {n for n in asked.all_names if n not in LINE_MERITS}
        self.order = tuple(sorted(own))
        self.brakes = float(point.series) * float(point.parallel)
        self.among = [i for i, n in enumerate(self.names) if among is None or n in among]
        self.last: tuple[bytes, dict[str, Array]] = (b"", {})

    def at(self, x: Array) -> dict[str, float]:
        """ln of every merit and of every variable in `names`."""
        made = _values(jnp.asarray(x), self.point, self.more, names=self.names, row=self.row)
        out = dict(zip(self.order, np.asarray(made).tolist(), strict=True))
        out |= self._line(self._vacuum(x))
        if self.spec.drawn:
            out |= self._bill(x)
        return {**{n: _log(v) for n, v in zip(self.names, x, strict=True)}, **out}

    def drawn(self, x: Array) -> dict[str, Array]:
        """DRAWN_MERITS at values of `names`, shape (n, names)."""
        asked = self.spec.evaluation
        if asked.draw is None:
            return {n: np.full(len(x), math.nan) for n in DRAWN_MERITS}
        padded = np.pad(x, ((0, -len(x) % 32), (0, 0)), "edge")  # each length compiles once
        point = changed(self.point, dict(zip(self.names, padded.T, strict=True)))
        return {n: row[: len(x)] for n, row in bills(point, asked.base, asked.draw).items()}

    def _stencil(self, x: Array) -> dict[str, Array]:
        """DRAWN_MERITS at x, and a step of NEAR above and below it in each variable of `among`.

        Asked for several times at one place, and drawn once.
        """
        if self.last[0] != x.tobytes():
            step = (NEAR * np.diag(np.where(x > 0, x, 1e-3)))[self.among]
            places = np.concatenate([x[None, :], x + step, np.maximum(x - step, 0.0)])
            self.last = (x.tobytes(), self.drawn(places))
        return self.last[1]

    def _bill(self, x: Array) -> dict[str, float]:
        return {n: _log(float(row[0])) for n, row in self._stencil(x).items()}

    def _drawn_slopes(self, x: Array) -> dict[str, Array]:
        """d ln(merit)/d variable by differences of NEAR, to one side if the other is no brake."""
        near = x[self.among]
        step = NEAR * np.where(near > 0, near, 1e-3)
        out = {}
        for name, values in self._stencil(x).items():
            with np.errstate(invalid="ignore", divide="ignore"):
                here, *sides = np.split(np.log(values), [1, 1 + len(near)])
            over, under = (
                np.where(np.isfinite(side), size, 0.0)
                for side, size in zip(sides, (step, np.minimum(step, near)), strict=True)
            )
            rise = np.where(over > 0, sides[0], here) - np.where(under > 0, sides[1], here)
            out[name] = np.zeros(len(x))
            out[name][self.among] = rise / np.where(over + under > 0, over + under, math.nan)
        return out

    def slopes(self, x: Array) -> dict[str, Array]:
        """d ln(merit)/d variable for every merit and variable in `names`."""
        made = np.asarray(
            _slopes(jnp.asarray(x), self.point, self.more, names=self.names, row=self.row)
        )
        out = dict(zip(self.order, made, strict=True))
        unit = np.eye(len(self.names))
        if self.spec.line is not None:
            at = self._vacuum(x)
            up, down = self._line(at * (1 + NEAR)), self._line(at * (1 - NEAR))
            place = unit[self.names.index("vacuum")]
            out |= {n: place * (up[n] - down[n]) / (2 * NEAR * at) for n in LINE_MERITS}
        if self.spec.drawn:
            out |= self._drawn_slopes(x)
        own = {n: unit[i] / x[i] for i, n in enumerate(self.names) if x[i] > 0}
        return {**own, **out}

    def _vacuum(self, x: Array) -> float:
        return float(x[self.names.index("vacuum")])

    def _line(self, vacuum: float) -> dict[str, float]:
        if self.spec.line is None:
            return {}
        pair = line_merits(vacuum, self.spec.line.line, self.brakes)
        return {n: _log(v) for n, v in zip(LINE_MERITS, pair, strict=True)}


def _log(value: float) -> float:
    return math.log(value) if value > 0 else math.nan if value != 0 else -math.inf


@dataclass(frozen=True)
class Refined:
    """A design between the grid's steps."""

    number: int
    """The grid's design it started from."""
    values: dict[str, float]
    """The continuous variables [SI]."""
    score: float
    """Sum of weight times signed ln(objective); less is better."""
    design: dict[str, Any]
    """All variables and merits, and `binding`: what holds it where it is."""


def refine(spec: DesignSpecification, number: int) -> Refined | None:
    """The best design near one of the grid's, None where no variable is continuous or none fits."""
    if not spec.grid.ranges:
        return None
    point = spec.grid.point(number)
    free = {*spec.merits, *spec.grid.ranges}
    fixed = [c for c in spec.constraints if c.name not in free]
    if not all(c.holds(float(getattr(point, c.name))) for c in fixed):
        return None
    live = [c for c in spec.constraints if c.name in free and c.limit > 0]
    search = LocalSearch(Smooth(spec, point, spec.grid.ranges), live)
    y = search.best()
    if y is None or not search.cost(y) < BAD:
        return None
    found = search.smooth.at(search.full(y))
    binding = [str(c) for c in live if abs(found[c.name] - math.log(c.limit)) < 1e-6]
    for n, part in zip(spec.grid.ranges, y, strict=True):
        if min(part, 1 - part) < 1e-6:
            binding.append(f"{n} at its {'least' if part < 0.5 else 'greatest'}")
    values = dict(zip(spec.grid.ranges, search.moved(y).tolist(), strict=True))
    known = {n: math.exp(found[n]) if n in found else math.nan for n in MERITS}
    last = search.full(y)[None, :]
    known |= {n: float(row[0]) for n, row in search.smooth.drawn(last).items()}
    design = {**spec.grid.values(number), **values, **known, "binding": binding}
    return Refined(number, values, search.cost(y), design)


class LocalSearch:
    """The search among the continuous variables of one design, each from 0 to 1 of its range."""

    def __init__(self, smooth: Smooth, live: list[Constraint]) -> None:
        self.smooth, goals = smooth, smooth.spec.objectives
        ranges = smooth.spec.grid.ranges
        self.places = [smooth.names.index(n) for n in ranges]
        self.low, self.high = np.array(list(ranges.values())).T
        self.goals, self.live = [o.name for o in goals], [c.name for c in live]
        self.weights = np.array([o.weight * o.sign for o in goals])
        self.signs = np.array([1.0 if c.most else -1.0 for c in live])
        self.limits = np.log([c.limit for c in live])

    def moved(self, y: Array) -> Array:
        """The continuous variables at a place within their ranges."""
        return np.asarray(self.low + y * (self.high - self.low))

    def full(self, y: Array) -> Array:
        """All variables at a place within the ranges."""
        x = self.smooth.start.copy()
        x[self.places] = self.moved(y)
        return x

    def cost(self, y: Array) -> float:
        """Sum of weight times signed ln(objective)."""
        at = self.smooth.at(self.full(y))
        value = float(self.weights @ [at[n] for n in self.goals])
        return value if math.isfinite(value) else BAD

    def room(self, y: Array) -> Array:
        """ln of what is left to each limit, negative where it is broken."""
        at = self.smooth.at(self.full(y))
        left = (self.limits - [at[n] for n in self.live]) * self.signs
        return np.nan_to_num(left, nan=-BAD, posinf=BAD, neginf=-BAD)

    def slopes(self, y: Array, names: list[str]) -> Array:
        """Gradients of ln of some quantities, (quantities, variables)."""
        at = self.smooth.slopes(self.full(y))
        made = np.array([at[n][self.places] for n in names])
        return np.asarray(np.nan_to_num(made * (self.high - self.low)))

    def best(self) -> Array | None:
        """The best place found; None where none meets the constraints."""
        from scipy.optimize import minimize

        spec = self.smooth.spec
        first = (self.smooth.start[self.places] - self.low) / (self.high - self.low)
        first = np.clip(first, 0.0, 1.0)
        kept = {
            "type": "ineq",
            "fun": self.room,
            "jac": lambda y: -self.signs[:, None] * self.slopes(y, self.live),
        }
        made = minimize(
            self.cost,
            first,
            jac=lambda y: self.weights @ self.slopes(y, self.goals),
            method="SLSQP",
            constraints=[kept] if self.live else [],
            bounds=[(0.0, 1.0)] * len(first),
            options={"ftol": ACCURACY, "maxiter": DRAWN_ROUNDS if spec.drawn else ROUNDS},
        )
        y = np.clip(made.x, 0.0, 1.0)
        # SLSQP ends a rounding outside, or beyond a step of the drawn parts: back to the start
        for share in (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.03, 0.1, 0.3, 1.0):
            back = y + share * (first - y)
            if (self.room(back) >= -ACCURACY).all():
                return np.asarray(back)
        return None


def sensitivities(
    spec: DesignSpecification, point: Point, names: tuple[str, ...]
) -> dict[str, dict[str, float]]:
    """{merit: {parameter: d ln(merit)/d ln(parameter)}} at a design, for merits `names`.

    Parameters are lengths, vacuum and the film's numbers; the travel follows the overlap unless it
    is varied by itself.
    """
    smooth = Smooth(spec, point)
    slopes = smooth.slopes(smooth.start)
    able = [(i, n, x) for i, (n, x) in enumerate(zip(smooth.names, smooth.start, strict=True)) if x]
    return {m: {n: float(slopes[m][i] * x) for i, n, x in able} for m in names if m in slopes}
