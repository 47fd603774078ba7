"""Numbered designs of a specification, with conversion between design numbers and values."""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import Build
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.simulate.prediction import Deviations
from layerjam.workshop.design.bill import Draw, drawn_merits
from layerjam.workshop.design.merit import (
    DRAWN_MERITS,
    LATE_MERITS,
    LINE_MERITS,
    MERITS,
    STOP_MERITS,
    VARIABLES,
    Point,
    StickSlipPull,
    Stock,
    merits,
)
from layerjam.workshop.design.stopping import StopRequirement, run_stops

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
PIECE = 1 << 15
"""Largest number of designs computed in one call, so that they stay in the cache."""
AXES = tuple(n for n in VARIABLES if n != "thickness")
"""All axes except the first, which is the film with its thickness."""


@dataclass(frozen=True)
class Grid:
    """Values of every variable; their combinations are numbered, the last axis varying fastest.

    `stock` and `thickness` are rows of the same length: a film and a thickness in which it is sold.
    `axes` has a row for every other variable; `usable_travel` may be absent. `ranges` maps the
    continuous variables to their smallest and largest values. `fittings_length` and `link_gap` [m]
    are those of every Point.
    """

    stock: Stock
    names: tuple[str, ...]
    thickness: Array
    axes: dict[str, Array]
    ranges: dict[str, tuple[float, float]]
    fittings_length: float = Build().fittings_length
    link_gap: float = Build().gap

    @functools.cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis; the film axis is the first."""
        return (len(self.thickness), *(len(v) for v in self.axes.values()))

    @property
    def size(self) -> int:
        """Number of designs."""
        return math.prod(self.shape)

    @property
    def max_series(self) -> int:
        """Largest number of brakes in series."""
        return int(self.axes["series"].max())

    def digits(self, numbers: Any) -> tuple[Any, ...]:
        """Return the indices on every axis of designs; IndexError for a number outside the grid."""
        digits = []
        for length in self.shape[:0:-1]:  # np.unravel_index takes four times as long
            higher = numbers // length if length > 1 else numbers
            digits.append(numbers - higher * length)
            numbers = higher
        if np.size(numbers) and not 0 <= np.min(numbers) <= np.max(numbers) < self.shape[0]:
            raise IndexError(f"designs are numbered from 0 to {self.size - 1}")
        return (numbers, *digits[::-1])

    def number(self, digits: Any) -> Any:
        """Return the design numbers for indices on every axis."""
        return np.ravel_multi_index(tuple(digits), self.shape)

    def columns(self, numbers: Any) -> dict[str, Any]:
        """Return {variable: values} of designs, without `usable_travel` if it is not an axis."""
        return self._select_values(self.digits(numbers))

    def point(self, numbers: Any) -> Point:
        """Return the designs with these indices."""
        digits = self.digits(numbers)
        film = Stock(*(row[digits[0]] for row in self.stock))
        lengths = {"fittings_length": self.fittings_length, "link_gap": self.link_gap}
        return Point(
            stock=film, **{"usable_travel": None, **self._select_values(digits)}, **lengths
        )

    def _select_values(self, digits: Sequence[Any]) -> dict[str, Any]:
        first, *others = digits
        values = {n: row[d] for (n, row), d in zip(self.axes.items(), others, strict=True)}
        return {"thickness": self.thickness[first], **values}

    def values(self, number: int) -> dict[str, float | str]:
        """Return one design as text and SI values: `film`, `thickness` and every variable."""
        columns = self.columns(number).items()
        return {
            "film": self.names[self.digits(number)[0]],
            **{n: int(v) if VARIABLES[n].whole else float(v) for n, v in columns},
        }


@dataclass(frozen=True)
class Evaluation:
    """Inputs for the merits of every design: the base brake and the inputs of optional merits."""

    base: Brake
    stick_slip: StickSlipPull | None = None
    stop: StopRequirement | None = None
    line: Array | None = None
    """LINE_MERITS of one brake for every vacuum of the grid, shape (2, vacuums)."""
    draw: Draw | None = None
    """Function that draws a brake for DRAWN_MERITS."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the merits in the kernel's rows, in order."""
        out = [n for n in MERITS if n not in (*LINE_MERITS, *LATE_MERITS, "judder_margin")]
        out += ["judder_margin"] * (self.stick_slip is not None)
        return (*out, *(LINE_MERITS if self.line is not None else ()))

    @property
    def all_names(self) -> tuple[str, ...]:
        """Return `names` followed by the merits of the stop."""
        return (*self.names, *(STOP_MERITS if self.stop is not None else ()))


@compiled(static=("names",))
def _merits(
    point: Point,
    base: Brake,
    stick_slip: StickSlipPull | None,
    *,
    names: tuple[str, ...],
) -> Any:
    """Return merits of a row of designs, (merits, n); compiled once for all specifications."""
    out = merits(point, base, stick_slip)
    shape = xp.shape(out["mass"])
    return xp.stack([xp.broadcast_to(out[n], shape) for n in names])


@compiled(static=("row",))
def _stop_rows(
    point: Point,
    base: Brake,
    requirement: StopRequirement,
    deviations: Deviations | None,
    *,
    row: int,
) -> Any:
    out = run_stops(point, base, requirement, row, deviations)
    return xp.stack([out[n] for n in STOP_MERITS])


class Kernel:
    """Merits of designs, given their design numbers, and the deviations of each from its file."""

    def __init__(self, grid: Grid, evaluation: Evaluation) -> None:
        self.grid, self.evaluation = grid, evaluation
        self.names = tuple(n for n in evaluation.names if n not in LINE_MERITS)
        self.vacuums = 1 + list(grid.axes).index("vacuum")
        vacuums = grid.axes["vacuum"]
        is_valid = (vacuums > 0) & (vacuums <= evaluation.base.site.atmosphere)
        self._drawn_vacuums = np.where(is_valid, np.argmax(is_valid), np.arange(len(vacuums)))
        """Index, for each vacuum, of the vacuum whose designs are drawn in its place."""

    def merits(self, numbers: Numbers) -> Array:
        """Return merits except those of the stop, shape (merits, n)."""
        evaluation = self.evaluation
        batch = pad(numbers)
        point = self.grid.point(batch)
        base, stick_slip = evaluation.base, evaluation.stick_slip
        rows = np.asarray(_merits(point, base, stick_slip, names=self.names))
        if evaluation.line is not None:
            line = evaluation.line[:, self.grid.digits(batch)[self.vacuums]]
            line = line * point.series * point.parallel
            # designs that cannot be built do not have the merits of the line either
            line[:, np.isnan(rows[self.names.index("mass")])] = np.nan
            rows = np.concatenate([rows, line])
        return rows[:, : len(numbers)]

    def stops(self, numbers: Numbers, deviations: Deviations | None = None) -> Array:
        """Return `stop_slip` and `stop_peak` of the designs, shape (2, n)."""
        evaluation = self.evaluation
        if len(numbers) == 0 or evaluation.stop is None:
            return np.full((len(STOP_MERITS), len(numbers)), math.nan)
        base, stop = evaluation.base, evaluation.stop
        point = self.grid.point(pad(numbers))
        logs = None if deviations is None else Deviations(*map(pad, deviations))
        rows = _stop_rows(point, base, stop, logs, row=self.grid.max_series)
        return np.asarray(rows)[:, : len(numbers)]

    def drawn_merits(
        self, numbers: Numbers, deviations: Deviations | None = None
    ) -> dict[str, Array]:
        """Return DRAWN_MERITS of the designs; NaN if no function draws them.

        With deviations (samples, 1), the shape of each merit is (samples, n). A drawing does not
        depend on the vacuum, so designs that differ only in it are drawn once.
        """
        evaluation = self.evaluation
        if evaluation.draw is None or len(numbers) == 0:
            return {name: np.full(len(numbers), math.nan) for name in DRAWN_MERITS}
        digits = list(self.grid.digits(numbers))
        digits[self.vacuums] = self._drawn_vacuums[digits[self.vacuums]]
        drawing_numbers, places = np.unique(self.grid.number(digits), return_inverse=True)
        rows = []
        for start in range(0, len(drawing_numbers), PIECE):
            piece = drawing_numbers[start : start + PIECE]
            point, base = self.grid.point(pad(piece)), evaluation.base
            merits = drawn_merits(point, base, evaluation.draw, len(piece), deviations)
            rows.append([merits[name] for name in DRAWN_MERITS])
        return dict(zip(DRAWN_MERITS, np.concatenate(rows, axis=-1)[..., places], strict=True))

    def all_merits(self, numbers: Numbers, stop: bool = True) -> Array:
        """Return all merits of any number of designs, in the order of `Evaluation.all_names`."""
        parts = [numbers[i : i + PIECE] for i in range(0, max(len(numbers), 1), PIECE)]
        rows = [self.merits(part) for part in parts]
        if stop and self.evaluation.stop is not None:
            rows = [np.concatenate([m, self.stops(p)]) for m, p in zip(rows, parts, strict=True)]
        return np.concatenate(rows, axis=1)


def pad(row: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a row of one of a few lengths, because each length is compiled separately."""
    size = next(n for n in (256, 4096, PIECE) if n >= len(row))
    return np.pad(row, (0, size - len(row)), "edge")
