"""What a search says: which design, why the next one lost, what forbids better ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.design.bounds import UNBUILDABLE, Exclusion, by
from layerjam.design.design_file import design_brake
from layerjam.design.merit import STOP_MERITS
from layerjam.design.requirements import (
    BUILDABLE,
    NAMEABLE,
    Constraint,
    DesignSpecification,
    Objective,
)
from layerjam.design.search import Search, SweepResult, Told
from layerjam.mechanics.limits import greatest_force
from layerjam.units import show

SHOWN = 5e-5
"""Least part that two digits behind the point of a percentage show."""


def named(design: Mapping[str, Any]) -> str:
    """A design in a few words: film, thickness, sheets, how many brakes."""
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


def why_lost(
    winner: Mapping[str, Any], loser: Mapping[str, Any], objectives: Sequence[Objective]
) -> str:
    """Which objectives the runner-up loses and wins by, and what that makes together."""
    worse: list[str] = []
    better: list[str] = []
    total = 0.0
    for o in objectives:
        step = math.log(loser[o.name] / winner[o.name]) * o.sign
        total += o.weight * step
        if abs(step) < 1e-9:
            continue
        much = percent(loser[o.name] / winner[o.name] - 1)
        text = f"{o.name} {much} ({show(loser[o.name], NAMEABLE[o.name].unit)})"
        (worse if step > 0 else better).append(text)
    if not worse and not better:
        return "it ties in every objective; of equals the first of the list is chosen"
    lost = " and ".join(worse) or "nothing"
    if len(objectives) == 1:
        return f"it loses by {lost}"
    won = f"; against that {' and '.join(better)}" if better else ""
    return f"it loses by {lost}{won}; weighted, {percent(math.expm1(total), sign='')} behind"


def percent(part: float, sign: str = "+") -> str:
    """A part in percent; one that two digits behind the point would not show in words."""
    return f"{part:{sign}.2%}" if abs(part) >= SHOWN else "by less than 0.01 %"


def forbidden(search: Search, found: SweepResult, told: Told) -> list[dict[str, Any]]:
    """Designs that would have won but for one constraint, and by how much they break it."""
    out = []
    score = told.scores[told.best[0]]
    for i, at in sorted(told.alone.items(), key=lambda item: (told.scores[item[1]], item[1])):
        if told.scores[at] >= score:
            continue
        constraint = search.spec.constraints[i]
        design = search.design(found.numbers[at])
        value = float(design[constraint.name])
        gain = -math.expm1(told.scores[at] - score)
        said = refusal(search, constraint, found.numbers[at])
        said = said or f"{constraint.name} {show(value, constraint.unit)}"
        reason = (
            f"{constraint} keeps out {named(design)}: {said}; weighted, it would be "
            f"{percent(gain, sign='')} better"
        )
        row = {"constraint": str(constraint), "design": design, "value": value}
        out.append({**row, "short": constraint.short(value), "gain": gain, "reason": reason})
    return out


def refusal(search: Search, c: Constraint, number: int) -> str:
    """Return why `build` refuses a design, empty for another constraint than `BUILDABLE`."""
    draw = search.spec.evaluation.draw
    if c.name != BUILDABLE.name or draw is None:
        return ""
    brake = design_brake(search.spec, search.spec.grid.point(int(number)))
    return draw.reason(brake, float(greatest_force(brake))) or ""


def binding(design: Mapping[str, Any], spec: DesignSpecification) -> list[str]:
    """Constraints met with less than 2 % to spare."""
    out = []
    for c in spec.constraints:
        room = abs(design[c.name] - c.limit) / abs(c.limit) if c.limit else math.inf
        if room < 0.02:
            out.append(f"{c} ({room:.1%} to spare)")
    return out


def why_none(search: Search, found: SweepResult, told: Told) -> Exclusion:
    """Why a sweep found no design: the constraint that fails, and its best value."""
    constraints = search.spec.constraints
    if not found.built:
        return Exclusion(None, UNBUILDABLE)
    if found.feasible:
        wanted = " and ".join(o.name for o in search.spec.objectives)
        reason = f"of {found.feasible} designs that meet the constraints none has a {wanted}"
        if search.spec.drawn:
            reason += ": their parts would not fit together as `build` draws them"
        return Exclusion(None, reason)
    reached = {i: float(found.asked[i, at]) for i, at in told.reach.items()}
    if reached:
        _, i, value = min((constraints[i].short(value), i, value) for i, value in reached.items())
        c = constraints[i]
        nearest = refusal(search, c, found.numbers[told.reach[i]])
        reason = f"{c} is not met on this grid while the others hold"
        reason += f"; of the nearest design {nearest}" if nearest else by(c, value)
        return Exclusion(str(c), reason, value)
    worst = int(np.argmax(found.failed))
    c = constraints[worst]
    if c.name in STOP_MERITS and found.failed[worst] == found.built:
        others = any(o.name not in STOP_MERITS for o in constraints)
        rest = "meets the other constraints and " if others else ""
        reason = f"of {found.built} designs none {rest}stops the mass within its usable travel"
        return Exclusion(str(c), f"{c}: {reason}")
    reason = (
        f"no design meets all but one of the constraints; {c} alone shuts out "
        f"{found.failed[worst]} of {found.built}"
    )
    return Exclusion(str(c), reason)
