"""`array`: equal brakes side by side and one behind the other, pulled once, slowly."""

from __future__ import annotations

from typing import Any

import numpy as np

from layerjam.commands.answer import TRAVEL, Answer, AnyBrake, Quantity, brake_at, vacuum_of
from layerjam.design import arrays
from layerjam.errors import QuantityError
from layerjam.units import QuantitySpec

PARALLEL = QuantitySpec("1", "equal brakes side by side", lo=1, hi=100, whole=True)
SERIES = QuantitySpec("1", "equal brakes one behind the other", lo=1, hi=100, whole=True)
MOST = 1000
"""Brakes of one array at most; `layerjam.Array` takes more, and unequal ones."""
UNITS = {
    "parallel": "1", "series": "1", "brakes": "1", "vacuum": "Pa", "until": "m", "peak_force": "N",
    "peak_elongation": "m", "force_at_end": "N", "end": "m", "work": "J", "mass": "kg",
    "travel": "m", "energy": "J", "stiffness": "N/m", "force_density": "N/kg",
}  # fmt: skip


def array(
    brake: AnyBrake,
    *,
    parallel: int | str = 1,
    series: int | str = 1,
    vacuum: Quantity | None = None,
    until: Quantity | None = None,
    atmosphere: Quantity | None = None,
) -> Answer:
    """`parallel` chains side by side, each of `series` of the brake: totals, and one slow pull.

    At the site's full vacuum unless another is given, to the elongation `until` or to the end of
    the travel. `outcome` is how the pull ends: FINISHED, BOTTOMED_OUT, or SNAPS where a slipping
    brake softens faster than those in series with it relax. `travel` and `energy` are by slip
    alone. An even share is assumed. `record` is a Pulled.
    """
    file = brake_at(brake, atmosphere)
    rows, row = _count(parallel, PARALLEL, "parallel"), _count(series, SERIES, "series")
    if rows * row > MOST:
        raise QuantityError(
            f"array: {rows} by {row} are {rows * row} brakes; at most {MOST} are allowed"
        )
    full = file.brake.site.atmosphere
    pressure = full if vacuum is None else vacuum_of(vacuum, file.brake)
    to = None if until is None else _length(until)
    member = arrays.Member(brake=file.brake, vacuum=pressure, name=file.name)
    made = arrays.grid(member, series=row, parallel=rows)
    whole, pulled = arrays.totals(made), arrays.pull(made, to)
    top = int(np.argmax(pulled.force))
    values: dict[str, Any] = {
        "brake": file.name, "parallel": rows, "series": row, "brakes": whole.brakes,
        "vacuum": pressure, "until": to, "peak_force": float(pulled.force[top]),
        "peak_elongation": float(pulled.elongation[top]),
        "force_at_end": float(pulled.force[-1]), "end": float(pulled.elongation[-1]),
        "work": float(pulled.work[-1]), "outcome": pulled.outcome.name,
        "travel": whole.travel, "energy": whole.energy, "mass": whole.mass,
        "stiffness": whole.stiffness, "force_density": float(pulled.force[top]) / whole.mass,
    }  # fmt: skip
    warnings = [*file.warnings(), *pulled.warnings]
    if whole.brakes > 1:
        warnings.append("equal brakes share the load evenly; real ones do not quite")
    return Answer(values=values, units=UNITS, warnings=warnings, record=pulled)


def _count(value: int | str, spec: QuantitySpec, name: str) -> int:
    if isinstance(value, str):
        return int(spec.read(value, name))
    return int(spec.check(value, name))


def _length(value: Quantity) -> float:
    if isinstance(value, str):
        return float(TRAVEL.read(value, "until"))
    return float(TRAVEL.check(float(value), "until"))
