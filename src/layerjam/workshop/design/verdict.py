"""Verdict of a search: the chosen design, the runner-up, and constraints that exclude others."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.limits import greatest_force, sheet_stress
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.simulate.quantities import CONFIDENCE
from layerjam.core.units import show
from layerjam.core.verdict import Check, check
from layerjam.workshop.design.bounds import UNBUILDABLE, Exclusion, describe_shortfall
from layerjam.workshop.design.design_file import design_brake
from layerjam.workshop.design.merit import STOP_MERITS, VARIABLES
from layerjam.workshop.design.requirements import (
    BUILDABLE,
    NAMEABLE,
    Constraint,
    DesignSpecification,
    Objective,
)
from layerjam.workshop.design.robust import Assessment
from layerjam.workshop.design.search import FAMILIES, Highlights, Search, SweepResult

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


def find_likely(
    search: Search, result: SweepResult, picks: Highlights
) -> tuple[list[int], list[Assessment]]:
    """Return the best designs that reach the confidence, one per family, with all samples.

    They are indices into the `numbers` of the result. If none reaches it, it is that of all the
    best designs.
    """
    numbers = result.numbers[picks.best]
    assessments = [search.assess(int(number)) for number in numbers]
    likely = [
        k for k, assessment in enumerate(assessments) if assessment.reaches(search.spec.confidence)
    ]
    families = search.families(numbers)
    first: dict[int, int] = {}
    for k in likely or range(len(assessments)):
        first.setdefault(int(families[k]), k)
    winners = [*first.values()][:FAMILIES]
    return [picks.best[k] for k in winners], [assessments[k] for k in winners]


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
    score = picks.scores[picks.best[0] if picks.average is None else picks.average]
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


def list_surer_losses(
    search: Search,
    result: SweepResult,
    picks: Highlights,
    best: Mapping[str, Any],
    assessment: Assessment,
) -> Iterator[dict[str, Any]]:
    """Yield the best design of the average brake, if only the confidence excludes it."""
    spec = search.spec
    if picks.average is None or not assessment.reaches(spec.confidence):
        return
    design = search.design(int(result.numbers[picks.average]))
    value = search.assess(design["number"]).probability
    gain = -math.expm1(
        sum(o.weight * o.sign * math.log(design[o.name] / best[o.name]) for o in spec.objectives)
    )
    if gain <= 0 or value >= spec.confidence:
        return
    reason = (
        f"the confidence of {format_share(spec.confidence)} excludes {describe_design(design)}: "
        f"{format_share(value)} of such brakes meet all constraints; without it, the weighted "
        f"result would be {format_percent(gain, sign='')} better"
    )
    row = {"constraint": "confidence", "design": design, "value": value}
    yield {**row, "short": 1 - value / spec.confidence, "gain": gain, "reason": reason}


def build_refusal(search: Search, c: Constraint, number: int) -> str:
    """Return the reason why `build` rejects a design; empty unless the constraint is BUILDABLE."""
    draw = search.spec.evaluation.draw
    if c.name != BUILDABLE.name or draw is None:
        return ""
    brake = design_brake(search.spec, search.spec.grid.point(int(number)))
    return draw.reason(brake, float(greatest_force(brake))) or ""


def binding_constraints(design: Mapping[str, Any], spec: DesignSpecification) -> list[str]:
    """Return the constraints met with a margin below 2 %, and the variables at the grid's edges."""
    out = []
    for c in spec.constraints:
        margin = abs(design[c.name] - c.limit) / abs(c.limit) if c.limit else math.inf
        if margin < 0.02:
            out.append(f"{c} ({margin:.1%} margin)")
    return [*out, *_edge_values(design, spec)]


def _edge_values(design: Mapping[str, Any], spec: DesignSpecification) -> Iterator[str]:
    """Yield the variables that a wider grid could still change."""
    grid = spec.grid
    of_film = np.array([name == design["film"] for name in grid.names])
    vacuums = grid.axes["vacuum"]
    axes = {
        **grid.axes,
        "thickness": np.unique(grid.thickness[of_film]),
        "vacuum": vacuums[vacuums <= spec.evaluation.base.site.atmosphere],
    }
    for name, values in axes.items():
        variable, value = VARIABLES[name], design[name]
        ends = {"smallest": values[0], "largest": values[-1]}
        limits = {"smallest": variable.lo, "largest": variable.hi}
        if name == "vacuum":
            limits["largest"] = spec.evaluation.base.site.atmosphere
        for word, end in ends.items():
            # a value that is at its own limit, such as one brake, is not limited by the grid
            if len(values) > 1 and value == end != limits[word]:
                yield f"{name} {show(value, variable.unit)} ({word} of the grid)"


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
        has_other_limits = any(o.name not in STOP_MERITS for o in constraints)
        limits_text = "meets the other constraints and " if has_other_limits else ""
        reason = (
            f"none of {result.built} designs {limits_text}stops the mass within its usable travel"
        )
        return Exclusion(str(c), f"{c}: {reason}")
    reason = (
        f"no design meets all but one of the constraints; {c} alone excludes "
        f"{result.failed[worst]} of {result.built}"
    )
    return Exclusion(str(c), reason)


def design_checks(file: BrakeFile, vacuum: float) -> Iterator[Check]:
    """Yield the checks of the stress of a design at its vacuum [Pa]."""
    brake, limit = file.brake, file.brake.film.strength
    force = float(peak(vacuum, brake.sheets.usable_travel, brake).force)
    stress = float(sheet_stress(force, brake))
    words = f"at {show(force, 'N')} the stress in the sheets is {show(stress, 'Pa')}"
    if limit is None:
        yield check("sheet strength", False, f"{words}; the film's strength is not known")
    else:
        words += f" of {show(limit, 'Pa')}"
        yield check("sheet strength", stress <= limit, words, ": they stretch or tear", "failed")


def confidence_check(
    spec: DesignSpecification, assessment: Assessment, surest: Assessment | None
) -> Iterator[Check]:
    """Yield the check that enough brakes of the chosen design meet all constraints.

    `surest` is the surest design of the grid.
    """
    if not assessment.chances or not spec.confidence:
        return
    basis = assessment.prediction.basis.word
    start = "with handbook values, " if basis == "handbook" else ""
    words = f"{start}{format_share(assessment.probability)} of such brakes meet all constraints"
    otherwise = f"; {format_share(spec.confidence)} are required"
    advice = ["calibrate a first brake"] if basis == "handbook" else []
    highest = assessment.probability
    if surest is not None and surest.probability > highest:
        highest = surest.probability
        name = f"number {surest.design['number']}"
        otherwise += f", and the surest design, {name}, has {format_share(highest)}"
    reachable = math.floor(highest * 100) / 100
    if CONFIDENCE.lo <= reachable < spec.confidence:
        advice.append(f"ask for --confidence {reachable:g}")
    otherwise += f": {' or '.join(advice)}" if advice else ""
    yield check("confidence", assessment.reaches(spec.confidence), words, otherwise)


def format_share(share: float) -> str:
    """Return a probability in percent, never rounded up."""
    return f"{math.floor(share * 1000 + 1e-9) / 10:g} %"
