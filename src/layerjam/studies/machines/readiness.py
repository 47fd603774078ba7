"""Whether the vacuum is there when it is needed: standing beforehand, or made on a warning."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from layerjam.fluid.closed_forms import pumping_time, reachable
from layerjam.fluid.line import Line
from layerjam.studies.machines.scenario import Scenario, word
from layerjam.studies.machines.verdict import Limit
from layerjam.units import quantity, record, show


@record
class VacuumSupply:
    """When the vacuum is made, and the time there is for it."""

    mode: str = word(
        "whether the vacuum always stands or is made on a warning", "standing", "triggered"
    )
    warning: float = quantity("s", "time from the warning to the impact", hi=1e5, default=0.0)


class Ready(NamedTuple):
    """How long the vacuum takes, and the limit it meets or not."""

    time: float
    limits: list[Limit]
    said: list[str]


def line_for(line: Line, brakes: float) -> Line:
    """The line with the gas volume of so many brakes: the file's volume is that of one.

    Tubes between them are left out.
    """
    chamber = line.chamber
    water = None if chamber.compliance is None else chamber.compliance * brakes
    more = replace(
        chamber,
        volume=chamber.volume * brakes,
        compliance=water,
        volume_per_slip=chamber.volume_per_slip * brakes,
        shrink=chamber.shrink * brakes,
    )
    return replace(line, chamber=more)


def vacuum_time(vacuum: float, line: Line) -> float:
    """From the atmosphere to a vacuum [Pa], pump full on [s]; infinite where it is not reached."""
    a = line.site.atmosphere
    if vacuum >= reachable(line):
        return math.inf
    made = pumping_time(a, a - vacuum, line)
    return math.inf if made is None else made


def readiness(
    scenario: Scenario, supply: VacuumSupply, vacuum: float, *, tuned: bool = False
) -> Ready:
    """The limit on the vacuum's time, where it has to be made, and what to say of it."""
    line, brakes = scenario.line, scenario.brakes.count
    time = vacuum_time(vacuum, line_for(line.line, brakes))
    words = show(time, "s", 3) if math.isfinite(time) else "for ever"
    what = f"{line.name} takes {words} to {show(vacuum, 'Pa')} in {brakes} brakes"
    if supply.mode == "standing" and not tuned:
        return Ready(time, [], [f"the vacuum stands all the time; from none, {what}"])
    limit = Limit(name="time for the vacuum", value=time, limit=supply.warning, unit="s")
    said = [what]
    if supply.mode == "standing":
        said.append("a tuned vacuum cannot stand beforehand: it depends on the crash to come")
    return Ready(time, [limit], said)
