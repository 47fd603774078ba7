"""The designs of a specification as one long row: design number to values and back."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from layerjam.design.bill import Draw, bills
from layerjam.design.merit import (
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
from layerjam.design.stopping import StopRequirement, stops
from layerjam.device.brake import Brake

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
PIECE = 1 << 15
"""Most designs that are computed in one go; they stay in the cache."""
AXES = tuple(n for n in VARIABLES if n != "thickness")
"""Every axis but the first, which is the film with its thickness."""


@dataclass(frozen=True)
class Grid:
    """Values of every variable; the design's number counts through them, the last axis fastest.

    `stock` and `thickness` are rows of one length: a film together with a thickness it is sold in.
    `axes` has a row for every other variable; `usable_travel` may be absent. `ranges` maps the
    continuous variables to their least and greatest value.
    """

    stock: Stock
    names: tuple[str, ...]
    thickness: Array
    axes: dict[str, Array]
    ranges: dict[str, tuple[float, float]]

    @functools.cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values on the film's axis and on all others."""
        return (len(self.thickness), *(len(v) for v in self.axes.values()))

    @property
    def size(self) -> int:
        """Number of designs."""
        return math.prod(self.shape)

    @property
    def most_in_row(self) -> int:
        """The greatest number of brakes in series."""
        return int(self.axes["series"].max())

    def digits(self, numbers: Any) -> tuple[Any, ...]:
        """Place on every axis of designs by number."""
        return np.unravel_index(numbers, self.shape)

    def number(self, digits: Any) -> Any:
        """The inverse of `digits`."""
        return np.ravel_multi_index(tuple(digits), self.shape)

    def columns(self, numbers: Any) -> dict[str, Any]:
        """{variable: its values} of designs by number; without `usable_travel` where it is none."""
        first, *rest = self.digits(numbers)
        own = {n: row[d] for (n, row), d in zip(self.axes.items(), rest, strict=True)}
        return {"thickness": self.thickness[first], **own}

    def point(self, numbers: Any) -> Point:
        """The designs with these numbers."""
        first = self.digits(numbers)[0]
        film = Stock(*(row[first] for row in self.stock))
        return Point(stock=film, **{"usable_travel": None, **self.columns(numbers)})

    def values(self, number: int) -> dict[str, float | str]:
        """One design in words and SI: `film`, `thickness` and every variable."""
        known = self.columns(number).items()
        return {
            "film": self.names[self.digits(number)[0]],
            **{n: int(v) if VARIABLES[n].whole else float(v) for n, v in known},
        }


@dataclass(frozen=True)
class Evaluation:
    """What is computed of every design: the base brake, and what the optional merits need."""

    base: Brake
    stick_slip: StickSlipPull | None = None
    stop: StopRequirement | None = None
    line: Array | None = None
    """LINE_MERITS of one brake for every vacuum of the grid, shape (2, vacuums)."""
    draw: Draw | None = None
    """What draws a brake for DRAWN_MERITS."""

    @property
    def names(self) -> tuple[str, ...]:
        """The merits of the kernel's rows, in order."""
        out = [n for n in MERITS if n not in (*LINE_MERITS, *LATE_MERITS, "judder_margin")]
        out += ["judder_margin"] * (self.stick_slip is not None)
        return (*out, *(LINE_MERITS if self.line is not None else ()))

    @property
    def all_names(self) -> tuple[str, ...]:
        """`names` and those of the stop."""
        return (*self.names, *(STOP_MERITS if self.stop is not None else ()))


@functools.partial(jax.jit, static_argnames=("names",))
def _merits(
    point: Point, base: Brake, pulled: StickSlipPull | None, *, names: tuple[str, ...]
) -> Any:
    """Merits of a row of designs, (merits, n). Compiled once for all specifications."""
    out = merits(point, base, pulled)
    shape = jnp.shape(out["mass"])
    return jnp.stack([jnp.broadcast_to(out[n], shape) for n in names])


@functools.partial(jax.jit, static_argnames=("row",))
def _stops(point: Point, base: Brake, wanted: StopRequirement, *, row: int) -> Any:
    out = stops(point, base, wanted, row)
    return jnp.stack([out[n] for n in STOP_MERITS])


class Kernel:
    """Merits of designs by number."""

    def __init__(self, grid: Grid, evaluation: Evaluation) -> None:
        self.grid, self.evaluation = grid, evaluation
        self.names = tuple(n for n in evaluation.names if n not in LINE_MERITS)
        self.vacuums = 1 + list(grid.axes).index("vacuum")

    def merits(self, numbers: Numbers) -> Array:
        """Merits without those of the stop, shape (merits, n)."""
        padded, asked = _padded(numbers), self.evaluation
        point = self.grid.point(padded)
        made = np.asarray(_merits(point, asked.base, asked.stick_slip, names=self.names))
        if asked.line is not None:
            line = (
                asked.line[:, self.grid.digits(padded)[self.vacuums]]
                * point.series
                * point.parallel
            )
            # what cannot be built has no line either
            line[:, np.isnan(made[self.names.index("mass")])] = np.nan
            made = np.concatenate([made, line])
        return made[:, : len(numbers)]

    def stops(self, numbers: Numbers) -> Array:
        """`stop_slip` and `stop_peak` of the designs with these numbers, shape (2, n)."""
        if len(numbers) == 0 or self.evaluation.stop is None:
            return np.full((len(STOP_MERITS), len(numbers)), math.nan)
        point, asked = self.grid.point(_padded(numbers)), self.evaluation
        made = _stops(point, asked.base, asked.stop, row=self.grid.most_in_row)
        return np.asarray(made)[:, : len(numbers)]

    def drawn(self, numbers: Numbers) -> dict[str, Array]:
        """DRAWN_MERITS of the designs with these numbers; NaN without what draws them."""
        asked = self.evaluation
        if asked.draw is None or len(numbers) == 0:
            return {name: np.full(len(numbers), math.nan) for name in DRAWN_MERITS}
        made = []
        for start in range(0, len(numbers), PIECE):
            part = numbers[start : start + PIECE]
            found = bills(self.grid.point(_padded(part)), asked.base, asked.draw)
            made.append([found[name][: len(part)] for name in DRAWN_MERITS])
        return dict(zip(DRAWN_MERITS, np.concatenate(made, axis=1), strict=True))

    def at(self, numbers: Numbers, stop: bool = True) -> Array:
        """All merits of any number of designs, in the order of `asked.all_names`."""
        parts = [numbers[i : i + PIECE] for i in range(0, max(len(numbers), 1), PIECE)]
        made = [self.merits(part) for part in parts]
        if stop and self.evaluation.stop is not None:
            made = [np.concatenate([m, self.stops(p)]) for m, p in zip(made, parts, strict=True)]
        return np.concatenate(made, axis=1)


def _padded(numbers: Numbers) -> Numbers:
    """To one of few lengths, as each length compiles once."""
    size = next(n for n in (256, 4096, PIECE) if n >= len(numbers))
    return np.pad(np.asarray(numbers, np.int64), (0, size - len(numbers)), "edge")
