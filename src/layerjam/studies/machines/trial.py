"""A body in a pulse, held by a scenario's brakes or by others: what a search asks."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas

from layerjam.mechanics.fan import straight
from layerjam.simulate.speed import counted
from layerjam.studies.machines.restraint import Body, Strap, extremes, snaps, strap_of
from layerjam.studies.machines.scenario import Array, Scenario

COARSE = 4
"""A search takes every fourth step of the drive."""


class Trial(NamedTuple):
    """A body that a drive [m/s^2] at steps of `dt` [s] throws into brakes behind webbing [N/m]."""

    scenario: Scenario
    body: Body
    webbing: float
    drive: Array
    dt: float

    def strap(self, **instead: Any) -> Strap:
        """The scenario's strap, or with `parallel`, `series`, `vacuum`, `webbing` instead."""
        brakes = self.scenario.brakes
        brake = straight(counted(self.scenario.brake.brake), "the restraint")
        own = {"parallel": brakes.parallel, "series": brakes.series, "vacuum": brakes.vacuum}
        made: Strap = strap_of(**(own | {"webbing": self.webbing} | instead), brake=brake)
        return made

    def tried(self, **grid: Any) -> pandas.DataFrame:
        """One row for each combination of `webbing`, `series`, `parallel` and `vacuum`.

        What `grid` leaves out is the scenario's own. The further columns are those of Extremes, and
        `count` of brakes, `mass` [kg], `as_built` (the webbing that is there), `sound` (the brakes
        do not snap) and `stops` (the body has stopped, on travel left).
        """
        brakes = self.scenario.brakes
        axes = {
            "webbing": self.webbing,
            "series": brakes.series,
            "parallel": brakes.parallel,
            "vacuum": brakes.vacuum,
        } | grid
        crossed = np.meshgrid(*axes.values(), indexing="ij")
        lanes = dict(zip(axes, (axis.ravel() for axis in crossed), strict=True))
        strap = self.strap(**lanes)
        most = extremes(self.drive[::COARSE], COARSE * self.dt, self.body, strap)
        rows = pandas.DataFrame(lanes | most._asdict())
        rows["count"] = rows.series * rows.parallel
        rows["mass"] = rows["count"] * self.scenario.mass
        rows["as_built"] = rows.webbing == self.webbing
        rows["sound"] = ~np.asarray(snaps(strap))
        left = rows.slip < rows.series * self.scenario.brake.brake.sheets.usable_travel * (1 - 1e-9)
        rows["stops"] = (rows.end_speed <= 0) & left
        return rows


def first(rows: pandas.DataFrame, *order: str) -> dict[str, Any]:
    """The row that is least in the columns of `order`; raises IndexError where there is none."""
    made: dict[str, Any] = rows.sort_values(list(order)).to_dict("records")[0]
    return made
