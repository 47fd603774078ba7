"""`design`: from a specification to a brake, and why not another one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from layerjam.commands.answer import Answer
from layerjam.design.bounds import Exclusion, impossible
from layerjam.design.design_file import design_file, plain_name
from layerjam.design.merit import MERITS, VARIABLES
from layerjam.design.refine import Refined, changed, refine, sensitivities
from layerjam.design.requirements import DesignSpecification
from layerjam.design.robust import robustness
from layerjam.design.search import Search, SweepResult
from layerjam.design.specification import load_spec
from layerjam.design.verdict import binding, forbidden, named, why_lost, why_none
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.units import QuantitySpec

UNITS = {n: m.unit for n, m in {**VARIABLES, **MERITS}.items()}
MOST_SHOWN = 500
"""Designs of the front in the answer; `sweep` writes all of them."""
WHICH = QuantitySpec("1", "number of a design", whole=True)
SWEEP = 300_000_000
"""More designs than these are left to `sweep`, which can be stopped and goes on."""


@dataclass(frozen=True)
class Designed:
    """Everything behind an answer: specification, search, what it found."""

    spec: DesignSpecification
    search: Search
    found: SweepResult | None
    chosen: dict[str, Any] | None
    runner_up: dict[str, Any] | None
    refined: Refined | None


def design(
    spec: str | Path | DesignSpecification, *, progress: Callable[[str, float], None] | None = None
) -> Answer:
    """The best brake of a specification, the front, the runner-up and why it lost.

    `feasible` False with `reason`, `killed_by` and `reachable` where nothing meets the constraints;
    contradictions that follow from bounds are told before anything is swept. `chosen` is the best
    design of the grid, `refined` the best between its steps. `record` is a Designed.
    """
    asked = spec if isinstance(spec, DesignSpecification) else load_spec(spec)
    if asked.grid.size > SWEEP:
        raise QuantityError(
            f"designs: {asked.grid.size} are more than {SWEEP} in memory; use `layerjam sweep`"
        )
    search = Search(asked)
    killed = impossible(search, progress)
    if killed is not None:
        return cannot(search, None, killed)
    found = search.all(progress)
    return answer(search, found)


def brake_of(answer: Answer, number: int | None = None) -> BrakeFile:
    """One brake of an answer's design as a file: by the design's number, or the refined one.

    Of brakes in series and in parallel it is one. Numbers that were fitted or measured on the brake
    the design began from are said to be that one's. Raises QuantityError for a number that is none.
    """
    found: Designed = answer.record
    spec, grid = found.spec, found.spec.grid
    if number is None and found.refined is None:
        raise QuantityError("design: none was found between the steps; give a number")
    place = number if number is not None else found.refined.number  # type: ignore[union-attr]
    WHICH.check(place, "number")
    if place >= grid.size:
        raise QuantityError(f"number: {place} is none of the {grid.size} designs, from 0 on")
    point = grid.point(grid.digits(int(place)))
    if number is None and found.refined is not None:
        point = changed(point, found.refined.values)
    name = f"{plain_name(spec.name)}-{place}{'-refined' if number is None else ''}"
    return design_file(spec, point, grid.values(int(place)), name)


def cannot(search: Search, found: SweepResult | None, killed: Exclusion | None) -> Answer:
    """The answer where nothing meets the specification."""
    if killed is not None:
        reason, value = killed.reason, killed.reachable
        name: str | None = killed.constraint
    else:
        assert found is not None
        reason, name, value = why_none(search, found)
    values = {
        **_nothing(), "name": search.spec.name, "feasible": False, "reason": reason,
        "designs": search.spec.grid.size, "examined": 0 if found is None else found.examined,
        "feasible_designs": 0, "killed_by": name, "reachable": value,
        "excludes": [] if killed is None else list(killed.others),
    }  # fmt: skip
    record = Designed(search.spec, search, found, None, None, None)
    return Answer(values=values, units=UNITS, warnings=_notes(search.spec), record=record)


def answer(search: Search, found: SweepResult) -> Answer:
    """The answer from what a sweep found."""
    spec = search.spec
    if not found.best:
        return cannot(search, found, None)
    score, number, _ = found.best[0]
    chosen = search.design(number)
    runner = search.design(found.best[1][1]) if len(found.best) > 1 else None
    tried = [r for _, n, _ in found.best if (r := refine(spec, n)) is not None]
    refined = min(tried, key=lambda r: r.score, default=None)
    if refined is not None and refined.score > score:
        refined = None
    point = spec.grid.point(spec.grid.digits(number))
    told = {o.name for o in spec.objectives} | {c.name for c in spec.constraints}
    slopes = sensitivities(spec, point, tuple(sorted(told & set(MERITS))))
    chances = robustness(spec, point)
    values = {
        **_nothing(),
        "name": spec.name,
        "feasible": True,
        "designs": spec.grid.size,
        "examined": found.examined,
        "feasible_designs": found.feasible,
        "chosen": chosen,
        "refined": _refined(search, refined),
        "runner_up": runner,
        "runner_up_lost": None if runner is None else why_lost(chosen, runner, spec.objectives),
        "binding": binding(chosen, spec),
        "forbidden": forbidden(search, found, score),
        "front_size": len(found.numbers),
        "front": [search.design(int(n)) for n in found.numbers[:MOST_SHOWN]],
        "sensitivities": slopes,
        "robustness": {
            k: {**c._asdict()} for k, c in chances.items()
        },
    }  # fmt: skip
    notes = _notes(spec)
    if runner is None:
        notes.append("no runner-up: every other design that fits has the same film and sheets")
    if len(found.numbers) > MOST_SHOWN:
        notes.append(f"the front has {len(found.numbers)} designs; {MOST_SHOWN} are listed")
    if chances and spec.scatter is not None:
        notes.append(
            f"robustness: friction log-normal, SD {spec.scatter.static:.2%} static and "
            f"{spec.scatter.kinetic:.2%} kinetic, from {spec.scatter.source}"
        )
    record = Designed(spec, search, found, chosen, runner, refined)
    return Answer(values=values, units=UNITS, warnings=notes, record=record)


def _nothing() -> dict[str, Any]:
    """Every key, in order, before it is known."""
    return dict.fromkeys(
        ("name", "feasible", "reason", "designs", "examined", "feasible_designs", "killed_by",
         "reachable", "excludes", "chosen", "refined", "runner_up", "runner_up_lost", "binding",
         "forbidden", "front_size", "front", "sensitivities", "robustness")
    )  # fmt: skip


def _refined(search: Search, refined: Refined | None) -> dict[str, Any] | None:
    if refined is None:
        return None
    values = {**search.spec.grid.values(refined.number), **refined.values}
    found = {n: refined.merits.get(n, math.nan) for n in MERITS}
    return {**values, **found, "binding": list(refined.binding)}


def _notes(spec: DesignSpecification) -> list[str]:
    """What every design of this specification rests on."""
    out = [*spec.brake.warnings(), *spec.notes]
    if spec.line is not None:
        out += spec.line.warnings()
    if len(spec.grid.axes["fittings_mass"]) == 1:
        out.append("fittings_mass is the same for every width and height; vary it, or measure it")
    if spec.evaluation.stop is not None and spec.grid.axes["series"].max() > 1:
        out.append("brakes in series: the stop of rigid ones, used up one after another")
    return out


__all__ = ["Designed", "answer", "brake_of", "cannot", "design", "named"]
