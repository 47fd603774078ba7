"""Bill of materials of a design: film, plastic and mass as drawn, and the margin of `build`.

Drawing a brake belongs to a higher layer (`fabricate`), which passes a function that accepts brakes
whose sheets are arrays. Screws and nuts come in fixed sizes, so lengths in a drawn brake change in
steps, and its bill of materials is neither traced nor interpolated.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.limits import greatest_force
from layerjam.brake.simulate.prediction import Deviations, change_numbers
from layerjam.core.evolve import evolve
from layerjam.workshop.design.merit import DRAWN_MERITS, Point, is_buildable, make_brake

SHEETS = (
    "count",
    "width",
    "thickness",
    "length",
    "overlap",
    "free_left",
    "free_right",
    "usable_travel",
)
FILM = ("density", "strength")
"""Quantities of sheets and film on which the drawn parts and their checks depend."""


class Bill(NamedTuple):
    """Bill of many brakes, as arrays; NaN for a brake whose parts do not fit together."""

    film_area: Any
    """Area of sheets and spacers [m²]."""
    printed: Any
    """Volume of printed parts that stay in the brake [m³]."""
    tools: Any
    """Volume of mould and core, with which any number of brakes can be cast [m³]."""
    mass: Any
    """Mass as drawn [kg] of the parts with a known mass."""
    margin: Any
    """Smallest margin of all checks of `build`; below 1 a check fails or the brake is rejected."""


class Draw(Protocol):
    """Function that draws brakes."""

    def __call__(self, brake: Brake, force: Any) -> Bill:
        """Return the bills of brakes given as arrays (n,), at their maximum forces [N].

        Forces and kinetic friction may have a first axis for samples of each brake.
        """

    def reason(self, brake: Brake, force: float) -> str | None:
        """Return the reason why a brake cannot be built, or None."""


@compiled
def _bill_columns(point: Point, base: Brake, deviations: Deviations | None) -> tuple[Any, Any]:
    """Return one row per quantity in SHEETS and FILM and three more, and the loads, (2, ...).

    The three are the wall thickness, the number of brakes in the design, and whether the design can
    be built. The loads, which alone have deviations, are the kinetic friction and the maximum force
    of one brake at the site's full vacuum.
    """
    plain_brake = make_brake(point, base)
    brake = change_numbers(plain_brake, deviations)
    rows = [getattr(brake.sheets, name) for name in SHEETS]
    rows += [getattr(brake.film, name) for name in FILM]
    rows += [brake.enclosure.wall, point.series * point.parallel]
    geometry = xp.broadcast_arrays(*rows, is_buildable(point, plain_brake))
    loads = xp.broadcast_arrays(brake.film.kinetic, greatest_force(brake))
    return xp.stack(geometry), xp.stack(loads)


def drawn_merits(
    point: Point, base: Brake, draw: Draw, count: int, deviations: Deviations | None = None
) -> dict[str, npt.NDArray[np.float64]]:
    """Return DRAWN_MERITS of the first `count` designs of a row; NaN if one cannot be drawn.

    A design has `series` times `parallel` brakes, cast in one mould. The row may be longer, because
    each length is compiled separately. With deviations (samples, 1), the shape is (samples, count).
    """
    geometry, loads = map(np.asarray, _bill_columns(point, base, deviations))
    geometry = np.broadcast_to(
        geometry.reshape(len(geometry), -1).T, (loads.shape[-1], len(geometry))
    )
    geometry, loads = geometry[:count].T, loads[..., :count]
    valid = geometry[-1] > 0
    *sheets, density, strength, wall, brakes = geometry[:-1, valid]
    kinetic, force = loads[..., valid]
    designs = evolve(
        base,
        sheets=evolve(base.sheets, **dict(zip(SHEETS, sheets, strict=True))),
        film=evolve(base.film, density=density, kinetic=kinetic, strength=strength),
        enclosure=evolve(base.enclosure, wall=wall),
        weighed_mass=None,
    )
    merits = np.full((len(DRAWN_MERITS), *loads.shape[1:]), np.nan)
    if valid.any():
        bill = draw(designs, force)
        volume = bill.printed * brakes + bill.tools
        merits[..., valid] = bill.film_area * brakes, volume, bill.mass * brakes, bill.margin
    return dict(zip(DRAWN_MERITS, merits, strict=True))
