"""The bill of a design: film, plastic and mass as the parts would be drawn, one brake at a time.

How a brake is drawn stands on a higher floor (`fabricate`); it is handed over as a function. Its
lengths go in steps (screws, nuts), so it is called for every design, and neither traced nor
interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.design.merit import DRAWN_MERITS, Point, brake_of, can_be_built
from layerjam.device.brake import Brake

SHAPE = ("count", "width", "thickness", "length", "overlap", "free_left", "free_right")
"""What of the sheets the drawn parts depend on."""


class Bill(NamedTuple):
    """What one brake is made of."""

    film_area: float
    """Sheets and spacers [m²]."""
    printed: float
    """Printed parts that stay in it [m³]."""
    tools: float
    """Mould and core, which serve any number of brakes [m³]."""
    mass: float
    """As drawn, of what has a mass before it is weighed [kg]."""


Draw = Callable[[Brake], Bill | None]
"""What draws a brake; None where its parts would not fit together."""


def bills(point: Point, base: Brake, draw: Draw) -> dict[str, npt.NDArray[np.float64]]:
    """DRAWN_MERITS of designs, in the broadcast shape of the point; NaN where none can be drawn.

    `series` times `parallel` brakes, cast in one mould. Designs of one shape are drawn once.
    """
    made = brake_of(point, base)
    known = [getattr(made.sheets, name) for name in SHAPE]
    known += [made.film.density, made.enclosure.wall, point.series * point.parallel]
    rows = np.broadcast_arrays(*(np.asarray(v, float) for v in known), can_be_built(point, made))
    table = np.stack([row.ravel() for row in rows])
    fine, brakes = table[-1] > 0, table[-2]
    shapes, place = np.unique(table[:-2, fine].T, axis=0, return_inverse=True)
    nothing = Bill(math.nan, math.nan, math.nan, math.nan)
    drawn = [draw(_brake(shape.tolist(), base)) or nothing for shape in shapes]
    each = np.array(drawn, float).reshape(len(shapes), len(Bill._fields)).T[:, place.ravel()]
    area, printed, tools, mass = each
    found = np.full((len(DRAWN_MERITS), table.shape[1]), math.nan)
    found[:, fine] = (area * brakes[fine], printed * brakes[fine] + tools, mass * brakes[fine])
    return {n: row.reshape(rows[0].shape) for n, row in zip(DRAWN_MERITS, found, strict=True)}


def _brake(shape: Any, base: Brake) -> Brake:
    """One brake of plain numbers; what the shape does not say is the base's."""
    *lengths, density, wall = shape
    return replace(
        base,
        sheets=replace(base.sheets, **dict(zip(SHAPE, lengths, strict=True))),
        film=replace(base.film, density=density),
        enclosure=replace(base.enclosure, wall=wall),
    )
