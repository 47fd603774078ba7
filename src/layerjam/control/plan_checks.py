"""Checks of a plan for a collision: a margin at its vacuums, and the strength of the sheets."""

import math
from collections.abc import Iterator

from layerjam.control.plan import MARGIN, Plan
from layerjam.mechanics.limits import sheet_stress
from layerjam.units import show, show_at_least
from layerjam.verdict import Check, check

MAX_CHANCE = 0.05
"""Probability of needing more slip than the travel above which a notice is given."""


def plan_checks(plan: Plan, chance: float) -> Iterator[Check]:
    """Return the checks of a plan; `chance` is that of needing more slip than the travel."""
    if plan.needed is not None:
        yield _knife_edge(plan, plan.needed)
    yield from _strength(plan)
    if plan.case.mass_sd or plan.case.speed_sd:
        sentence = f"the probability of needing more slip than the travel is {chance:.1%}"
        yield check("chance", chance <= MAX_CHANCE, sentence, f", more than {MAX_CHANCE:.0%}")


def _knife_edge(plan: Plan, least: float) -> Check:
    """Return the check that a little less than the vacuum needed still stops the mass."""
    atmosphere = plan.brake.brake.site.atmosphere
    vacuum = show_at_least(least, "Pa", atmosphere)
    if not plan.knife_edge:
        return check("knife edge", True, f"the stop hardly changes just below {vacuum}")
    sentence = f"at {vacuum} the mass barely comes to rest; with 1 ppm less it runs out of travel"
    if plan.safe_vacuum is None:
        advice = ", and no vacuum at the site leaves a margin"
    else:
        safe = show_at_least(plan.safe_vacuum, "Pa", atmosphere)
        advice = f". With {safe} it stops even if mass, speed and vacuum are each {MARGIN:.0%} off"
    return check("knife edge", False, sentence, advice, "failed")


def _strength(plan: Plan) -> Iterator[Check]:
    """Return the check of the sheets' stress at the peak force, if the film's strength is known."""
    brake, forces = plan.brake.brake, (plan.full.peak_force, plan.tuned.peak_force)
    peak = max((force for force in forces if math.isfinite(force)), default=None)
    if peak is None or brake.film.strength is None:
        return
    stress, limit = float(sheet_stress(peak, brake)), brake.film.strength
    sentence = (
        f"at {show(peak, 'N')} the stress in the sheets is {show(stress, 'Pa')}, with "
        f"{show(limit, 'Pa')} allowed"
    )
    yield check("sheet strength", stress <= limit, sentence, ": they stretch or tear", "failed")
