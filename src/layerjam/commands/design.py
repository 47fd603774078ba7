"""`design`: from a specification to the best brake, with the reasons."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from layerjam.commands.declare import Input, Progress, command, precision
from layerjam.commands.quantities import Accept
from layerjam.commands.results import Figure, Judged, fact, number, result
from layerjam.errors import Notice, QuantityError
from layerjam.units import QuantitySpec, show
from layerjam.verdict import Acceptance, judge

if TYPE_CHECKING:
    from layerjam.design.bounds import Exclusion
    from layerjam.design.refine import RefinedDesign
    from layerjam.design.requirements import DesignSpecification
    from layerjam.design.search import Search, SweepResult
    from layerjam.device.file import BrakeFile

MOST_SHOWN = 500
"""Largest number of front designs in the result; `sweep` writes all of them."""
MOST_IN_MEMORY = 300_000_000
"""Largest number of designs; for more, use `sweep`, which can be stopped and resumed."""
NEAR_MISSES, SLOPES = 3, 4
"""Numbers of excluded designs and of sensitivities that are printed."""
DESIGN_NUMBER = QuantitySpec("1", "number of a design", whole=True)
Row = Mapping[str, Any]


@dataclass(frozen=True)
class Designed:
    """Data of a result: specification, search, and the best design between grid steps."""

    spec: DesignSpecification
    search: Search
    refined: RefinedDesign | None = None


@result
class DesignResult(Judged):
    """Best design, front, runner-up and why it lost; or the reason why no design is feasible.

    `record` is a Designed.
    """

    record: Designed
    name: str = fact("name of the specification")
    feasible: bool | None = fact("whether any design meets the specification")
    reason: str | None = fact("reason if none does")
    designs: int = number("1", "designs in the specification")
    examined: int | None = number("1", "designs computed")
    feasible_designs: int | None = number("1", "designs that meet the specification")
    killed_by: str | None = fact("constraint that rules out every design")
    reachable: float | None = fact("best value of that constraint's quantity", listed=False)
    excludes: Sequence[str] | None = fact("constraints that contradict it", listed=False)
    chosen: Row | None = fact("best design on the grid", listed=False)
    refined: Row | None = fact("best design between the grid steps", listed=False)
    runner_up: Row | None = fact("best design with a different film or sheets", listed=False)
    runner_up_lost: str | None = fact("reason why the runner-up lost", listed=False)
    binding: Sequence[str] | None = fact("constraints met with less than 2 % margin", listed=False)
    forbidden: Sequence[Row] | None = fact(
        "designs that would win but for one constraint", listed=False
    )
    front_size: int | None = number("1", "designs on the front")
    front: Sequence[Row] | None = fact("the front, at most 500 designs", listed=False)
    sensitivities: Mapping[str, Row] | None = fact(
        "relative sensitivity of each merit to each variable", listed=False
    )
    robustness: Mapping[str, Row] | None = fact(
        "probability that each constraint is met, given the scatter in friction", listed=False
    )

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of a design's variables and merits."""
        from layerjam.design.merit import MERITS, VARIABLES

        return {name: spec.unit for name, spec in {**VARIABLES, **MERITS}.items()}

    @property
    def has_curve(self) -> bool:
        """Whether there is a front to draw."""
        return self.feasible is True

    def draw(self) -> Figure:
        """Return the figure of the front for the first two objectives, with the chosen design."""
        from layerjam.report import design_figures

        if not self.has_curve:
            raise QuantityError("design: no design meets the specification; there is no front")
        return design_figures.draw_front(self)

    def lines(self) -> Iterator[str]:
        """Yield the design, the runner-up, constraints that exclude better designs, and margins."""
        if not self.feasible:
            return
        yield from self._choice_lines()
        if self.binding:
            yield from ("", "limited by: " + ", ".join(self.binding))
        by_shortfall = sorted(self.forbidden or (), key=lambda f: f["short"])
        yield from (f"forbidden: {f['reason']}" for f in by_shortfall[:NEAR_MISSES])
        yield from self._margin_lines()

    def _choice_lines(self) -> Iterator[str]:
        from layerjam.design.verdict import describe_design

        spec, units = self.record.spec, self.units
        names = [o.name for o in spec.objectives]
        names += [c.name for c in spec.constraints if c.name not in names]
        choice, refinement = self.chosen or {}, self.refined or {}
        yield from ("", f"chosen: {describe_design(choice)}")
        for name in names:
            text = show(choice[name], units[name])
            if name in refinement:
                text += f"   between the steps {show(refinement[name], units[name])}"
            yield f"  {name}: {text}"
        if refinement:
            values = ", ".join(f"{n} {show(refinement[n], units[n])}" for n in spec.grid.ranges)
            yield f"between the steps: {describe_design(refinement)} ({values})"
        if self.runner_up:
            second = describe_design(self.runner_up)
            yield from ("", f"runner-up: {second}", f"  {self.runner_up_lost}")

    def _margin_lines(self) -> Iterator[str]:
        if self.robustness:
            yield from ("", "probability that it is met, given the scatter in friction")
            for name, chance in self.robustness.items():
                yield f"  {chance['probability']:>6.1%}  {name}"
        first = self.record.spec.objectives[0].name
        slopes = (self.sensitivities or {}).get(first, {})
        strong = sorted(slopes.items(), key=lambda item: -abs(item[1]))[:SLOPES]
        words = ", ".join(f"{n} {v:+.2f}" for n, v in strong if abs(v) > 0.005)
        if strong:
            yield from ("", f"relative sensitivity of {first} to: {words}")


R = TypeVar("R", bound=DesignResult)


def _read_spec(
    value: str | Path | DesignSpecification, _: Mapping[str, Any]
) -> DesignSpecification:
    """Return the specification, with the function that draws brakes as in `build`."""
    from layerjam.design.requirements import DesignSpecification
    from layerjam.design.specification import load_spec
    from layerjam.fabricate.choices import resolve_choices
    from layerjam.fabricate.drawn_mass import Draws

    spec = value if isinstance(value, DesignSpecification) else load_spec(value)
    return spec.set_drawing(Draws(resolve_choices(spec.brake).build, spec.brake.making.enclosure))


SpecInput = Annotated[
    "DesignSpecification",
    Input(
        "Requirements: a TOML file, or the built-in example wrist or stop.",
        metavar="SPEC.toml",
        convert=_read_spec,
    ),
]


@command("design")
def design(
    spec: SpecInput, *, accept: Accept = None, progress: Progress | None = None
) -> DesignResult:
    """Find the best brake for a set of requirements.

    Also returns the front, the runner-up and why it lost, and the constraints that exclude better
    designs. If no design meets the constraints, `feasible` is False, with `reason`, `killed_by` and
    `reachable`; contradictions between bounds are found before the sweep. `chosen` is the best
    design on the grid, `refined` the best one between its steps.
    """
    from layerjam.design.bounds import prove_impossible
    from layerjam.design.search import Search

    if spec.grid.size > MOST_IN_MEMORY:
        raise QuantityError(
            f"designs: {spec.grid.size} exceed the limit of {MOST_IN_MEMORY} in memory; use "
            "`layerjam sweep`"
        )
    search = Search(spec)
    conflict = prove_impossible(search, progress)
    if conflict is not None:
        return infeasible_result(DesignResult.create, search, conflict)
    return best_result(DesignResult.create, search, search.run_all(progress), accept)


def brake_of(result: DesignResult, number: int | None = None) -> BrakeFile:
    """Return one brake of a design as a file, by the design's number, or of the refined design.

    If the design has several brakes, the file describes one of them. Numbers that were fitted or
    measured on the base brake of the design are labelled as belonging to it. Raises QuantityError
    if no design has the number, and for a brake whose checks fail unless `design` accepted them.
    """
    from layerjam.design.design_file import make_design_file, plain_name
    from layerjam.design.refine import replace_values
    from layerjam.design.verdict import design_checks

    source: Designed = result.record
    spec, grid, refinement = source.spec, source.spec.grid, source.refined
    if number is None:
        if refinement is None:
            raise QuantityError("design: none was found between the steps; give a number")
        number, values, row = refinement.number, refinement.values, refinement.design
    else:
        DESIGN_NUMBER.check(number, "number")
        if number >= grid.size:
            raise QuantityError(
                f"number: {number} is not one of the {grid.size} designs, numbered from 0"
            )
        refinement, values, row = None, {}, source.search.design(int(number))
    point = replace_values(grid.point(int(number)), values)
    name = f"{plain_name(spec.name)}-{number}{'-refined' if refinement is not None else ''}"
    acceptances = [Acceptance.of_row(acceptance) for acceptance in result.accepted]
    with precision():
        file = make_design_file(spec, point, grid.values(int(number)), name, acceptances)
        verdict = judge(design_checks(file, row["vacuum"], {}))
    accepted_names = {acceptance.check for acceptance in acceptances}
    for failed_row in verdict.failed_checks:
        if failed_row["name"] not in accepted_names:
            raise QuantityError(
                f"{name}: check '{failed_row['name']}' failed: {failed_row['reason']}"
            )
    return file


def infeasible_result(
    make: Callable[..., R], search: Search, exclusion: Exclusion, sweep: SweepResult | None = None
) -> R:
    """Return the result if bounds or a full sweep prove that no design meets the specification."""
    return make(
        name=search.spec.name,
        feasible=False,
        reason=exclusion.reason,
        designs=search.spec.grid.size,
        examined=0 if sweep is None else sweep.examined,
        feasible_designs=0,
        killed_by=exclusion.constraint,
        reachable=exclusion.reachable,
        excludes=list(exclusion.others),
        warnings=list(_spec_notices(search.spec)),
        record=Designed(search.spec, search),
    )


def best_result(
    make: Callable[..., R], search: Search, sweep: SweepResult, accept: Mapping[str, str] | None
) -> R:
    """Return the result of a search; `accept` is {check: reason}."""
    from layerjam.design.design_file import make_design_file
    from layerjam.design.merit import MERITS
    from layerjam.design.refine import refine, sensitivities
    from layerjam.design.robust import robustness
    from layerjam.design.verdict import (
        binding_constraints,
        design_checks,
        explain_failure,
        explain_loss,
        near_winners,
    )

    highlights = search.find_highlights(sweep)
    if not highlights.best:
        return infeasible_result(make, search, explain_failure(search, sweep, highlights), sweep)
    spec = search.spec
    numbers, front = sweep.numbers[highlights.best], sweep.numbers[highlights.front]
    best_design, *others = (search.design(number) for number in numbers[:2])
    runner = others[0] if others else None
    refinements = [r for number in numbers if (r := refine(spec, int(number))) is not None]
    refinement = min(refinements, key=lambda r: r.score, default=None)
    if refinement is not None and refinement.score > highlights.scores[highlights.best[0]]:
        refinement = None
    point = spec.grid.point(numbers[0])
    chances = robustness(spec, point)
    number = int(numbers[0])
    with precision():
        file = make_design_file(spec, point, spec.grid.values(number), "the design")
        checks = [*design_checks(file, best_design["vacuum"], chances)]
    return make(
        judge(checks, accept),
        name=spec.name,
        feasible=True,
        designs=spec.grid.size,
        examined=sweep.examined,
        feasible_designs=sweep.feasible,
        chosen=best_design,
        refined=None if refinement is None else refinement.design,
        runner_up=runner,
        runner_up_lost=None
        if runner is None
        else explain_loss(best_design, runner, spec.objectives),
        binding=binding_constraints(best_design, spec),
        forbidden=near_winners(search, sweep, highlights),
        front_size=len(front),
        front=search.designs(front[:MOST_SHOWN]),
        sensitivities=sensitivities(spec, point, tuple(sorted({*search.wanted} & {*MERITS}))),
        robustness={k: chance._asdict() for k, chance in chances.items()},
        warnings=[
            *_spec_notices(spec),
            *_chosen_brake_notices(spec, file),
            *_list_design_notices(spec, len(front), runner is None, bool(chances)),
        ],
        record=Designed(spec, search, refinement),
    )


def _chosen_brake_notices(spec: DesignSpecification, file: BrakeFile) -> Iterator[Notice]:
    """Return notices about the spacers of the chosen brake and the gauges of its film."""
    from layerjam.device.gauge import gauge_notices

    keys = {notice.key for notice in spec.brake.spacer_notices()}
    yield from (notice for notice in file.spacer_notices() if notice.key not in keys)
    yield from gauge_notices(file)


def _list_design_notices(
    spec: DesignSpecification, on_front: int, is_local: bool, scattered: bool
) -> Iterator[Notice]:
    if is_local:
        yield Notice(
            "no runner-up: every other feasible design has the same film and sheets",
            "no-runner-up",
        )
    if on_front > MOST_SHOWN:
        yield Notice(f"the front has {on_front} designs; {MOST_SHOWN} are listed", "front-cut")
    if scattered and spec.scatter is not None:
        yield Notice(
            f"robustness: log-normal friction, SD {spec.scatter.static:.2%} static and "
            f"{spec.scatter.kinetic:.2%} kinetic, from {spec.scatter.source}",
            "scatter",
        )


def _spec_notices(spec: DesignSpecification) -> Iterator[str]:
    yield from (*spec.brake.warnings(), *spec.notes)
    if spec.line is not None:
        yield from spec.line.warnings()
    if len(spec.grid.axes["fittings_mass"]) == 1:
        yield Notice(
            "fittings_mass is the same for every width and height; vary it, or measure it",
            "fittings-mass",
        )
    if spec.evaluation.stop is not None and spec.grid.max_series > 1:
        yield Notice(
            "brakes in series are assumed rigid, each using up its travel before the next",
            "rigid-series",
        )
