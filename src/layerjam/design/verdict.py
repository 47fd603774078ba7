"""Verdict of a search: the chosen design, the runner-up, and constraints that exclude others."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.design.bounds import UNBUILDABLE, Exclusion, describe_shortfall
from layerjam.design.design_file import design_brake
from layerjam.design.merit import STOP_MERITS
from layerjam.design.requirements import (
    BUILDABLE,
    NAMEABLE,
    Constraint,
    DesignSpecification,
    Objective,
)
from layerjam.design.robust import Chance
from layerjam.design.search import Highlights, Search, SweepResult
from layerjam.device.file import BrakeFile
from layerjam.mechanics.limits import greatest_force, sheet_stress
from layerjam.mechanics.pull import peak
from layerjam.units import show
from layerjam.verdict import Check, check

LEAST_SHARE = 5e-5
"""Smallest fraction that is visible in a percentage with two decimals."""


def describe_design(design: Mapping[str, Any]) -> str:
    """Return a short description of a design: film, thickness, numbers of sheets and of brakes."""
    words = [
        f"{design['count']:.0f} sheets",
        f"{show(design['thickness'], 'm')} of {design['film']}",
    ]
    words.append(f"{show(design['width'], 'm')} wide, overlap {show(design['overlap'], 'm')}")
    words.append(f"at {show(design['vacuum'], 'Pa')}")
    for name in ("series", "parallel"):
        if design[name] > 1:
            words.append(f"{design[name]:.0f} in {name}")
    return ", ".join(words)


def explain_loss(
    winner: Mapping[str, Any], loser: Mapping[str, Any], objectives: Sequence[Objective]
) -> str:
    """Return the objectives in which the runner-up is worse or better, and the weighted result."""
    worse: list[str] = []
    better: list[str] = []
    total = 0.0
    for o in objectives:
        step = math.log(loser[o.name] / winner[o.name]) * o.sign
        total += o.weight * step
        if abs(step) < 1e-9:
            continue
        much = format_percent(loser[o.name] / winner[o.name] - 1)
        text = f"{o.name} {much} ({show(loser[o.name], NAMEABLE[o.name].unit)})"
        (worse if step > 0 else better).append(text)
    if not worse and not better:
        return "it ties in every objective; the first of several tied designs is chosen"
    losses = " and ".join(worse) or "nothing"
    if len(objectives) == 1:
        return f"it loses by {losses}"
    gain = f", offset by {' and '.join(better)}" if better else ""
    return f"it loses by {losses}{gain}; weighted loss {format_percent(math.expm1(total), sign='')}"


def format_percent(part: float, sign: str = "+") -> str:
    """Return a fraction in percent, or in words if two decimals would not show it."""
    return f"{part:{sign}.2%}" if abs(part) >= LEAST_SHARE else "by less than 0.01 %"


def near_winners(search: Search, result: SweepResult, picks: Highlights) -> list[dict[str, Any]]:
    """Return better designs that only one constraint excludes, and by how much."""
    rows = []
    score = picks.scores[picks.best[0]]
    for i, k in sorted(picks.obstacle.items(), key=lambda item: (picks.scores[item[1]], item[1])):
        if picks.scores[k] >= score:
            continue
        constraint = search.spec.constraints[i]
        design = search.design(result.numbers[k])
        value = float(design[constraint.name])
        gain = -math.expm1(picks.scores[k] - score)
        excess = build_refusal(search, constraint, result.numbers[k])
        excess = excess or f"{constraint.name} {show(value, constraint.unit)}"
        reason = (
            f"{constraint} excludes {describe_design(design)}: {excess}; without this "
            f"limit, the weighted result would be {format_percent(gain, sign='')} better"
        )
        row = {"constraint": str(constraint), "design": design, "value": value}
        rows.append({**row, "short": constraint.shortfall(value), "gain": gain, "reason": reason})
    return rows


def build_refusal(search: Search, c: Constraint, number: int) -> str:
    """Return the reason why `build` rejects a design; empty unless the constraint is BUILDABLE."""
    draw = search.spec.evaluation.draw
    if c.name != BUILDABLE.name or draw is None:
        return ""
    brake = design_brake(search.spec, search.spec.grid.point(int(number)))
    return draw.reason(brake, float(greatest_force(brake))) or ""


def binding_constraints(design: Mapping[str, Any], spec: DesignSpecification) -> list[str]:
    """Return the constraints that are met with a margin below 2 %."""
    out = []
    for c in spec.constraints:
        room = abs(design[c.name] - c.limit) / abs(c.limit) if c.limit else math.inf
        if room < 0.02:
            out.append(f"{c} ({room:.1%} margin)")
    return out


def explain_failure(search: Search, result: SweepResult, picks: Highlights) -> Exclusion:
    """Return the reason why a sweep found no design: a failing constraint and its best value."""
    constraints = search.spec.constraints
    if not result.built:
        return Exclusion(None, UNBUILDABLE)
    if result.feasible:
        objectives = " and ".join(o.name for o in search.spec.objectives)
        reason = f"of {result.feasible} designs that meet the constraints, none has a {objectives}"
        if search.spec.drawn_merits:
            reason += ": their parts would not fit together as `build` draws them"
        return Exclusion(None, reason)
    values = {i: float(result.asked[i, place]) for i, place in picks.reach.items()}
    if values:
        _, i, value = min(
            (constraints[i].shortfall(value), i, value) for i, value in values.items()
        )
        c = constraints[i]
        nearest = build_refusal(search, c, result.numbers[picks.reach[i]])
        reason = f"{c} is not met on this grid if the others are"
        reason += f"; nearest design: {nearest}" if nearest else describe_shortfall(c, value)
        return Exclusion(str(c), reason, value)
    worst = int(np.argmax(result.failed))
    c = constraints[worst]
    if c.name in STOP_MERITS and result.failed[worst] == result.built:
        others = any(o.name not in STOP_MERITS for o in constraints)
        extra = "meets the other constraints and " if others else ""
        reason = f"none of {result.built} designs {extra}stops the mass within its usable travel"
        return Exclusion(str(c), f"{c}: {reason}")
    reason = (
        f"no design meets all but one of the constraints; {c} alone excludes "
        f"{result.failed[worst]} of {result.built}"
    )
    return Exclusion(str(c), reason)


LIKELY = 0.5
"""Lowest acceptable probability of meeting all constraints, given the scatter in friction."""


def design_checks(file: BrakeFile, vacuum: float, chances: Mapping[str, Chance]) -> Iterator[Check]:
    """Return the checks of a design at its vacuum [Pa]; `chances` come from `robustness`."""
    brake, limit = file.brake, file.brake.film.strength
    force = float(peak(vacuum, brake.sheets.usable_travel, brake).force)
    stress = float(sheet_stress(force, brake))
    words = f"at {show(force, 'N')} the stress in the sheets is {show(stress, 'Pa')}"
    if limit is None:
        yield check("sheet strength", False, f"{words}; the film's strength is not known")
    else:
        words += f" of {show(limit, 'Pa')}"
        yield check("sheet strength", stress <= limit, words, ": they stretch or tear", "failed")
    if "all" in chances:
        share = chances["all"].probability
        words = f"with the scatter in friction, {share:.0%} of brakes meet all constraints"
        yield check("scatter", share >= LIKELY, words)
