"""Notices of `plan`: assumptions and neglected effects."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from layerjam.commands.lines import ONLY_COMPLIANCE
from layerjam.errors import Notice
from layerjam.simulate.speed import list_stop_notices
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.control.plan import Plan
    from layerjam.control.plan_build import Build


def list_plan_notices(plan: "Plan", build: "Build | None") -> Iterator[Notice]:
    """Yield the assumptions of a plan and the effects that it neglects."""
    from layerjam.control.plan_spread import SHIFTS
    from layerjam.fluid.closed_forms import final_pressure
    from layerjam.simulate.coupled import MATTERS

    case, standby = plan.case, plan.standby
    line, tank = standby.line, standby.line.reservoir
    yield from list_stop_notices(plan.brake)
    if case.mass_sd or case.speed_sd:
        yield Notice(
            "mass and speed: log-normal, independent; probabilities and peak by exact stops at "
            f"constant vacuum on a Fibonacci lattice with {SHIFTS} random shifts, whose scatter is "
            "the error",
            "chances",
        )
    if tank is not None and tank.delay >= case.warning:
        late = (
            f"the reservoir valve opens after {show(tank.delay, 's')}, when the mass has "
            "already arrived"
        )
        yield Notice(late, "reservoir-late")
    if (tank is not None or build is not None) and standby.stored is None and not standby.water:
        yield Notice(
            f"reservoir: evacuated to {show(final_pressure(line), 'Pa')} absolute before the "
            "warning, the lowest pressure that pump and leak allow",
            "reservoir-emptied",
        )
    if build is not None:
        yield from (Notice(sentence, "assumed-build") for sentence in build.assumed)
    if standby.water:
        yield ONLY_COMPLIANCE
    modes = {"full": plan.full} if plan.capped else {"full": plan.full, "tuned": plan.tuned}
    for name, mode in modes.items():
        if mode.coupled is not None and mode.coupled.is_significant:
            yield Notice(
                f"{name} vacuum: the enclosure's stretching changes slip or peak by more "
                f"than {MATTERS:.0%}; probabilities and sizes assume a constant vacuum",
                "coupling-matters",
            )
    if plan.needed is not None and plan.tuned.vacuum > plan.needed and not plan.capped:
        yield Notice(
            f"the idle vacuum cannot be released in time to the tuned {show(plan.needed, 'Pa')}; "
            f"{show(plan.tuned.vacuum, 'Pa')} remains",
            "idle-vacuum-left",
        )
    if plan.rising.vacuum[-1] < case.standing * (1 - 1e-9):
        falls = "the vacuum decreases during the warning: the leak exceeds the flow of the pump"
        yield Notice(falls, "vacuum-falls")
