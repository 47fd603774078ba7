"""Notices of `plan`: assumptions and neglected effects."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from layerjam.brake.commands.arguments import list_rope_notices
from layerjam.brake.commands.lines import ONLY_COMPLIANCE
from layerjam.brake.simulate.speed import list_stop_notices
from layerjam.core.errors import Notice
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.bench.control.plan import Plan
    from layerjam.bench.control.plan_build import Build


def list_plan_notices(plan: "Plan", build: "Build | None") -> Iterator[Notice]:
    """Yield the assumptions of a plan and the effects that it neglects."""
    from layerjam.brake.fluid.closed_forms import final_pressure
    from layerjam.brake.simulate.coupled import MATTERS
    from layerjam.brake.simulate.prediction import Prediction

    case, standby = plan.case, plan.standby
    line, tank = standby.line, standby.line.reservoir
    yield from Prediction(plan.brake).notices()
    yield from list_stop_notices(plan.brake)
    yield from list_rope_notices(plan.brake, case.rope_stiffness)
    yield Notice(
        "probabilities and expected peaks: exact stops at constant vacuum for independent, "
        "log-normal mass and speed and for brakes that scatter",
        "chances",
    )
    if tank is not None and tank.delay >= case.warning:
        late_note = (
            f"the reservoir valve opens after {show(tank.delay, 's')}, when the mass has "
            "already arrived"
        )
        yield Notice(late_note, "reservoir-late")
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
        decrease_note = (
            "the vacuum decreases during the warning: the leak exceeds the flow of the pump"
        )
        yield Notice(decrease_note, "vacuum-falls")
