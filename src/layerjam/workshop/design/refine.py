"""Local search that starts from the best design of a grid and uses gradients.

JAX differentiates the merits; the search is SciPy's SLSQP on their logarithms. Film, thickness,
whole numbers and variables with a list or a single value in the specification stay fixed.
"""

import functools
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.mechanics.arrays import map_leaves, xp
from layerjam.brake.mechanics.law import compiled
from layerjam.workshop.design.bill import drawn_merits
from layerjam.workshop.design.merit import (
    DRAWN_MERITS,
    LINE_MERITS,
    MERITS,
    VARIABLES,
    Point,
    Stock,
    line_merits,
)
from layerjam.workshop.design.requirements import Constraint, DesignSpecification
from layerjam.workshop.design.stopping import all_merits

Array = npt.NDArray[np.float64]
LENGTHS = tuple(n for n, spec in VARIABLES.items() if not spec.whole and n != "usable_travel")
FILM = tuple(n for n in Stock._fields if n != "strength")
SLOPE_STEP = 1e-5
"""Relative step for slopes of merits that are not traced: those of the line and the drawn brake."""
ACCURACY = 1e-9
ROUNDS, DRAWN_ROUNDS = 200, 40
"""Maximum number of iterations; fewer with drawn parts, whose steps prevent convergence."""
BAD = 1e3
"""Cost of an invalid design, larger than the ln of any merit."""


def replace_values(point: Point, values: dict[str, Any]) -> Point:
    """Return the design with changed variables; names in FILM change its stock."""
    film = {n: v for n, v in values.items() if n in FILM}
    others = {n: v for n, v in values.items() if n not in FILM}
    if film:
        others["stock"] = point.stock._replace(**film)
    return point._replace(**others)


def _ln_merits(x: Any, point: Point, inputs: Any, *, names: tuple[str, ...], row: int) -> Any:
    """Return ln of all merits at values `x` of the variables `names`, in alphabetical order."""
    base, stick_slip, requirement = inputs
    design = replace_values(point, dict(zip(names, x, strict=True)))
    out = all_merits(design, base, stick_slip, requirement, row)
    return xp.log(xp.stack([xp.asarray(out[n], float) for n in sorted(out)]))


@compiled(static=("names", "row"))
def _slopes(x: Any, point: Point, inputs: Any, *, names: tuple[str, ...], row: int) -> Any:
    """Return the derivatives of `_ln_merits`, shape (merits, names)."""
    import jax

    return jax.jacfwd(functools.partial(_ln_merits, names=names, row=row))(x, point, inputs)


class Smooth:
    """Logarithms of one design's merits as functions of lengths, vacuum and film, with slopes.

    It always evaluates all merits, so that every specification uses the same compiled function.
    Drawn merits are not traced: their slopes are difference quotients, calculated only when needed.
    """

    def __init__(
        self, spec: DesignSpecification, point: Point, variables: Collection[str] | None = None
    ) -> None:
        """Store the inputs; `variables` are the variables whose slopes are needed, all if None."""
        self.spec = spec
        self.point = map_leaves(float, point)
        travel = () if point.usable_travel is None else ("usable_travel",)
        self.names = (*LENGTHS, *travel, *FILM)
        place = {n: self.point.stock if n in FILM else self.point for n in self.names}
        self.start = np.array([float(getattr(place[n], n)) for n in self.names])
        evaluation = spec.evaluation
        self.more = (evaluation.base, evaluation.stick_slip, evaluation.stop)
        self.row = spec.grid.max_series
        merits = {n for n in evaluation.all_names if n not in LINE_MERITS}
        self.order = tuple(sorted(merits))
        self.brakes = float(point.series) * float(point.parallel)
        self.among = [i for i, n in enumerate(self.names) if variables is None or n in variables]
        self.last: tuple[bytes, dict[str, Array]] = (b"", {})

    def log_merits(self, x: Array) -> dict[str, float]:
        """Return the ln of every merit and of every variable in `names`."""
        values = _ln_merits(xp.asarray(x), self.point, self.more, names=self.names, row=self.row)
        out = dict(zip(self.order, np.asarray(values).tolist(), strict=True))
        out |= self._line_merits(self._vacuum(x))
        if self.spec.drawn_merits:
            out |= self._drawn_merits(x)
        return {**{n: _safe_ln(v) for n, v in zip(self.names, x, strict=True)}, **out}

    def drawn_merits(self, x: Array) -> dict[str, Array]:
        """Return DRAWN_MERITS at values of `names`, shape (n, names)."""
        source = self.spec.evaluation
        if source.draw is None:
            return {n: np.full(len(x), math.nan) for n in DRAWN_MERITS}
        batch = np.pad(x, ((0, -len(x) % 32), (0, 0)), "edge")  # each length compiles once
        point = replace_values(self.point, dict(zip(self.names, batch.T, strict=True)))
        return drawn_merits(point, source.base, source.draw, len(x))

    def _stencil_merits(self, x: Array) -> dict[str, Array]:
        """Return DRAWN_MERITS at x, and at one SLOPE_STEP above and below x for each of `among`.

        The last result is cached, because several callers need the same point.
        """
        if self.last[0] != x.tobytes():
            step = (SLOPE_STEP * np.diag(np.where(x > 0, x, 1e-3)))[self.among]
            places = np.concatenate([x[None, :], x + step, np.maximum(x - step, 0.0)])
            self.last = (x.tobytes(), self.drawn_merits(places))
        return self.last[1]

    def _drawn_merits(self, x: Array) -> dict[str, float]:
        return {n: _safe_ln(float(row[0])) for n, row in self._stencil_merits(x).items()}

    def _drawn_slopes(self, x: Array) -> dict[str, Array]:
        """Return d ln(merit)/d variable by differences, one-sided if one side cannot be built."""
        place = x[self.among]
        step = SLOPE_STEP * np.where(place > 0, place, 1e-3)
        out = {}
        for name, values in self._stencil_merits(x).items():
            with np.errstate(invalid="ignore", divide="ignore"):
                centre, *sides = np.split(np.log(values), [1, 1 + len(place)])
            up, down = (
                np.where(np.isfinite(side), size, 0.0)
                for side, size in zip(sides, (step, np.minimum(step, place)), strict=True)
            )
            rise = np.where(up > 0, sides[0], centre) - np.where(down > 0, sides[1], centre)
            out[name] = np.zeros(len(x))
            out[name][self.among] = rise / np.where(up + down > 0, up + down, math.nan)
        return out

    def slopes(self, x: Array) -> dict[str, Array]:
        """Return d ln(merit)/d variable for every merit and variable in `names`."""
        rows = np.asarray(
            _slopes(xp.asarray(x), self.point, self.more, names=self.names, row=self.row)
        )
        out = dict(zip(self.order, rows, strict=True))
        unit = np.eye(len(self.names))
        if self.spec.line is not None:
            vacuum = self._vacuum(x)
            up = self._line_merits(vacuum * (1 + SLOPE_STEP))
            down = self._line_merits(vacuum * (1 - SLOPE_STEP))
            place = unit[self.names.index("vacuum")]
            out |= {n: place * (up[n] - down[n]) / (2 * SLOPE_STEP * vacuum) for n in LINE_MERITS}
        if self.spec.drawn_merits:
            out |= self._drawn_slopes(x)
        variables = {n: unit[i] / x[i] for i, n in enumerate(self.names) if x[i] > 0}
        return {**variables, **out}

    def _vacuum(self, x: Array) -> float:
        return float(x[self.names.index("vacuum")])

    def _line_merits(self, vacuum: float) -> dict[str, float]:
        if self.spec.line is None:
            return {}
        pair = line_merits(vacuum, self.spec.line.line, self.brakes)
        return {n: _safe_ln(v) for n, v in zip(LINE_MERITS, pair, strict=True)}


def _safe_ln(value: float) -> float:
    return math.log(value) if value > 0 else math.nan if value != 0 else -math.inf


@dataclass(frozen=True)
class RefinedDesign:
    """Design between the steps of the grid."""

    number: int
    """Number of the grid design from which the search started."""
    values: dict[str, float]
    """Values of the continuous variables [SI]."""
    score: float
    """Sum of weight times signed ln(objective); a smaller sum is better."""
    design: dict[str, Any]
    """All variables and merits, and the active limits under `binding`."""


def refine(
    spec: DesignSpecification, number: int, margins: Mapping[str, float] = MappingProxyType({})
) -> RefinedDesign | None:
    """Return the best design near one of the grid; None if none fits or nothing is continuous.

    The average brake must be better than the limit of each constraint by its factor in `margins`.
    """
    if not spec.grid.ranges:
        return None
    point = spec.grid.point(number)
    free = {*spec.merits, *spec.grid.ranges}
    constant = [c for c in spec.constraints if c.name not in free]
    if not all(c.is_met(float(getattr(point, c.name))) for c in constant):
        return None
    live = [c for c in spec.constraints if c.name in free and c.limit > 0]
    search = LocalSearch(Smooth(spec, point, spec.grid.ranges), live, margins)
    y = search.find_best_point()
    if y is None or not search.cost(y) < BAD:
        return None
    logs = search.smooth.log_merits(search.all_values(y))
    ends = dict(zip(map(str, live), search.limits, strict=True))
    binding = [str(c) for c in live if abs(logs[c.name] - ends[str(c)]) < 1e-6]
    for n, part in zip(spec.grid.ranges, y, strict=True):
        if min(part, 1 - part) < 1e-6:
            binding.append(f"{n} at its {'minimum' if part < 0.5 else 'maximum'}")
    values = dict(zip(spec.grid.ranges, search.to_values(y).tolist(), strict=True))
    merits = {n: math.exp(logs[n]) if n in logs else math.nan for n in MERITS}
    last = search.all_values(y)[None, :]
    merits |= {n: float(row[0]) for n, row in search.smooth.drawn_merits(last).items()}
    design = {**spec.grid.values(number), **values, **merits, "binding": binding}
    return RefinedDesign(number, values, search.cost(y), design)


class LocalSearch:
    """Search over the continuous variables of one design, each scaled to the range from 0 to 1."""

    def __init__(
        self, smooth: Smooth, live: list[Constraint], margins: Mapping[str, float]
    ) -> None:
        self.smooth, goals = smooth, smooth.spec.objectives
        ranges = smooth.spec.grid.ranges
        self.places = [smooth.names.index(n) for n in ranges]
        self.low, self.high = np.array(list(ranges.values())).T
        self.goals, self.live = [o.name for o in goals], [c.name for c in live]
        self.weights = np.array([o.weight * o.sign for o in goals])
        self.signs = np.array([1.0 if c.most else -1.0 for c in live])
        self.limits = np.log([c.limit for c in live])
        self.limits -= self.signs * np.log([margins.get(str(c), 1.0) for c in live])

    def to_values(self, y: Array) -> Array:
        """Return the values of the continuous variables at a point of the scaled ranges."""
        return np.asarray(self.low + y * (self.high - self.low))

    def all_values(self, y: Array) -> Array:
        """Return the values of all variables at a point of the scaled ranges."""
        x = self.smooth.start.copy()
        x[self.places] = self.to_values(y)
        return x

    def cost(self, y: Array) -> float:
        """Return the sum of weight times signed ln(objective)."""
        logs = self.smooth.log_merits(self.all_values(y))
        value = float(self.weights @ [logs[n] for n in self.goals])
        return value if math.isfinite(value) else BAD

    def constraint_margins(self, y: Array) -> Array:
        """Return the ln of the margin to each limit, which is negative if the limit is exceeded."""
        logs = self.smooth.log_merits(self.all_values(y))
        margins = (self.limits - [logs[n] for n in self.live]) * self.signs
        return np.nan_to_num(margins, nan=-BAD, posinf=BAD, neginf=-BAD)

    def slopes(self, y: Array, names: list[str]) -> Array:
        """Return the gradients of the ln of some quantities, shape (quantities, variables)."""
        gradients = self.smooth.slopes(self.all_values(y))
        rows = np.array([gradients[n][self.places] for n in names])
        return np.asarray(np.nan_to_num(rows * (self.high - self.low)))

    def find_best_point(self) -> Array | None:
        """Return the best point, or None if none meets the constraints."""
        from scipy.optimize import minimize

        spec = self.smooth.spec
        first = (self.smooth.start[self.places] - self.low) / (self.high - self.low)
        first = np.clip(first, 0.0, 1.0)
        limits = {
            "type": "ineq",
            "fun": self.constraint_margins,
            "jac": lambda y: -self.signs[:, None] * self.slopes(y, self.live),
        }
        result = minimize(
            self.cost,
            first,
            jac=lambda y: self.weights @ self.slopes(y, self.goals),
            method="SLSQP",
            constraints=[limits] if self.live else [],
            bounds=[(0.0, 1.0)] * len(first),
            options={"ftol": ACCURACY, "maxiter": DRAWN_ROUNDS if spec.drawn_merits else ROUNDS},
        )
        y = np.clip(result.x, 0.0, 1.0)
        # SLSQP may end just outside a limit, or past a step of the drawn parts: move towards the
        # start
        for share in (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.03, 0.1, 0.3, 1.0):
            nearer = y + share * (first - y)
            if (self.constraint_margins(nearer) >= -ACCURACY).all():
                return np.asarray(nearer)
        return None


def sensitivities(
    spec: DesignSpecification, point: Point, names: tuple[str, ...]
) -> dict[str, dict[str, float]]:
    """Return {merit: {parameter: d ln(merit)/d ln(parameter)}} of a design for some merits.

    The parameters are lengths, vacuum and properties of the film; the travel follows the overlap
    unless it is itself a variable.
    """
    smooth = Smooth(spec, point)
    slopes = smooth.slopes(smooth.start)
    able = [(i, n, x) for i, (n, x) in enumerate(zip(smooth.names, smooth.start, strict=True)) if x]
    return {m: {n: float(slopes[m][i] * x) for i, n, x in able} for m in names if m in slopes}
