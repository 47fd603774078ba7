"""Readiness of the vacuum: present beforehand, or built up after a warning."""

import math
from typing import NamedTuple

from layerjam.brake.fluid.closed_forms import pumping_time, reachable_vacuum
from layerjam.brake.fluid.line import Line
from layerjam.core.evolve import evolve
from layerjam.core.units import quantity, record, show
from layerjam.studies.machines.scenario import Scenario, word
from layerjam.studies.machines.verdict import Limit


@record
class VacuumSupply:
    """Mode of the vacuum supply, and the time available to build up the vacuum."""

    mode: str = word(
        "whether the vacuum is always present or built up after a warning", "standing", "triggered"
    )
    warning: float = quantity("s", "time from the warning to the impact", hi=1e5, default=0.0)


class Ready(NamedTuple):
    """Time to reach the vacuum, its limits, and notes."""

    time: float
    limits: list[Limit]
    notices: list[str]


def scale_line(line: Line, brakes: float) -> Line:
    """Return a brake's vacuum line with the gas volume of several, without tubes between them."""
    chamber = line.chamber
    water = None if chamber.compliance is None else chamber.compliance * brakes
    volume = evolve(
        chamber,
        volume=chamber.volume * brakes,
        compliance=water,
        volume_per_slip=chamber.volume_per_slip * brakes,
        shrink=chamber.shrink * brakes,
    )
    return evolve(line, chamber=volume)


def vacuum_time(vacuum: float, line: Line) -> float:
    """Return the time [s] to pump from zero to a vacuum [Pa]; infinity if it is out of reach."""
    a = line.site.atmosphere
    if vacuum >= reachable_vacuum(line):
        return math.inf
    time = pumping_time(a, a - vacuum, line)
    return math.inf if time is None else time


def check_readiness(
    scenario: Scenario, supply: VacuumSupply, vacuum: float, *, tuned: bool = False
) -> Ready:
    """Return the time to reach the vacuum, a limit on it if there is a warning first, and notes."""
    line, brakes = scenario.line, scenario.brakes.count
    time = vacuum_time(vacuum, scale_line(line.line, brakes))
    words = show(time, "s", 3) if math.isfinite(time) else "forever"
    note = f"{line.name} takes {words} to reach {show(vacuum, 'Pa')} in {brakes} brakes"
    if supply.mode == "standing" and not tuned:
        return Ready(time, [], [f"the vacuum is always present; from zero, {note}"])
    limit = Limit(name="time to reach the vacuum", value=time, limit=supply.warning, unit="s")
    notes = [note]
    if supply.mode == "standing":
        notes.append("a tuned vacuum cannot be present beforehand: it depends on the crash")
    return Ready(time, [limit], notes)
