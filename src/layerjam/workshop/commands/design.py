"""`design`: from a specification to the best brake, with the reasons."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from layerjam.brake.commands.arguments import Accept, Interval, OutBrake, Overwrite
from layerjam.brake.simulate.quantities import CONFIDENCE
from layerjam.core.brief import brief
from layerjam.core.command.declare import Help, Input, Progress, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.command.wording import format_interval
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.system import quote_word
from layerjam.core.toml_files.writer import format_tables
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import judge

if TYPE_CHECKING:
    from layerjam.brake.device.brake_file import BrakeFile
    from layerjam.workshop.design.bounds import Exclusion
    from layerjam.workshop.design.refine import RefinedDesign
    from layerjam.workshop.design.requirements import DesignSpecification
    from layerjam.workshop.design.robust import Assessment
    from layerjam.workshop.design.search import Search, SweepResult

MOST_SHOWN = 500
"""Largest number of front designs in the result; `sweep` writes all of them."""
MOST_IN_MEMORY = 300_000_000
"""Largest number of designs; for more, use `sweep`, which can be stopped and resumed."""
NEAR_MISSES, SLOPES = 3, 4
"""Numbers of excluded designs and of sensitivities that are printed."""
BrakeShare = Annotated[
    float | None, CONFIDENCE, Help("Share of brakes that should meet all constraints.")
]
DESIGN_NUMBER = QuantitySpec("1", "number of a design", whole=True)
Row = Mapping[str, Any]


@brief
@dataclass(frozen=True)
class Designed:
    """Data of a result: specification, search, and the best design between grid steps."""

    spec: DesignSpecification
    search: Search
    refined: RefinedDesign | None = None


@result
class DesignResult(Judged, PredictionResult):
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
    binding: Sequence[str] | None = fact(
        "constraints met with less than 2 % margin, and variables at an edge of the grid",
        listed=False,
    )
    forbidden: Sequence[Row] | None = fact(
        "designs that would win but for one constraint", listed=False
    )
    front_size: int | None = number("1", "designs on the front")
    front: Sequence[Row] | None = fact("the front, at most 500 designs", listed=False)
    sensitivities: Mapping[str, Row] | None = fact(
        "relative sensitivity of each merit to each variable", listed=False
    )
    confidence: float | None = number(
        "1",
        "share of brakes that should meet all constraints",
        shown=lambda share: f"{share * 100:.4g} %" if share else "",
        default=0.95,
    )
    robustness: Mapping[str, Row] | None = fact(
        "probability that each constraint is met by the next brake of the chosen design",
        listed=False,
    )
    surest: int | None = fact(
        "number of the design with the highest probability, if none reaches the confidence",
        listed=False,
    )
    file: str | None = fact("brake file that was written", default=None)

    @classmethod
    def table_units(cls) -> Mapping[str, str]:
        """Return the units of a design's variables and merits."""
        from layerjam.workshop.design.merit import MERITS, VARIABLES

        return {name: spec.unit for name, spec in {**VARIABLES, **MERITS}.items()}

    @property
    def has_curve(self) -> bool:
        """Whether there is a front to draw."""
        return self.feasible is True

    def draw(self) -> Figure:
        """Return the figure of the front for the first two objectives, with the chosen design."""
        from layerjam.workshop.figures import design_figures

        if not self.has_curve:
            raise QuantityError("design: no design meets the specification; there is no front")
        return design_figures.draw_front(self)

    def content(self) -> object:
        """Return the chosen design as a brake file; raises QuantityError if there is none."""
        if not self.feasible:
            raise QuantityError("design: no design meets the specification; there is no brake")
        return brake_of(self, (self.chosen or {})["number"])

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
        if self.file:
            yield from ("", f"  layerjam build {quote_word(self.file)} --out DIR")

    def _choice_lines(self) -> Iterator[str]:
        from layerjam.workshop.design.verdict import describe_design

        spec, units = self.record.spec, self.units
        names = [o.name for o in spec.objectives]
        names += [*(c.name for c in spec.constraints), "usable_travel"]
        choice, refinement = self.chosen or {}, self.refined or {}
        yield from ("", f"chosen: {describe_design(choice)}")
        for name in dict.fromkeys(names):
            text = show(choice[name], units[name])
            if name in (self.intervals or {}):
                text += format_interval(self.interval(name), units[name], choice[name])
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
            yield from ("", "probability that the next brake meets it")
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
    value: str | Path | Mapping[str, Any] | DesignSpecification, _: Mapping[str, Any]
) -> DesignSpecification:
    """Return the specification, with the function that draws brakes as in `build`.

    A mapping has the keys and texts of a file.
    """
    from layerjam.workshop.design.requirements import DesignSpecification
    from layerjam.workshop.design.specification import load_spec, read_spec
    from layerjam.workshop.fabricate.choices import resolve_choices
    from layerjam.workshop.fabricate.drawn_mass import Draws

    if isinstance(value, DesignSpecification):
        spec = value
    elif isinstance(value, Mapping):
        spec = read_spec(format_tables(value), "specification")
    else:
        spec = load_spec(value)
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
    spec: SpecInput,
    *,
    out: OutBrake | None = None,
    number: Annotated[
        int | None, DESIGN_NUMBER, Help("Design to write instead of the chosen one.")
    ] = None,
    accept: Accept = None,
    overwrite: Overwrite = False,
    confidence: BrakeShare = 0.95,
    interval: Interval = "next",
    progress: Progress | None = None,
) -> DesignResult:
    """Find the best brake for a set of requirements.

    Friction and mounting scatter, and handbook values may be far off. `chosen` is the best design
    of which the share `confidence` of brakes meets all constraints. If no design reaches it, a
    check warns, and `chosen` is the best one for the average brake; `robustness` has the
    probabilities and `surest` the number of the design with the highest one. With None instead of a
    confidence, the average brake alone decides.

    Also returns the front, the runner-up and why it lost, and the constraints that exclude better
    designs. If no design meets the constraints, `feasible` is False, with `reason`, `killed_by` and
    `reachable`; contradictions between bounds are found before the sweep. `chosen` is the best
    design on the grid, `refined` the best one between its steps. `out` receives the chosen design,
    or the one with a `number`, as a brake file that `build` accepts.
    """
    from layerjam.workshop.design.bounds import prove_impossible
    from layerjam.workshop.design.search import Search

    if number is not None and out is None:
        raise QuantityError.of("number", "only with out, the file to write")
    if spec.grid.size > MOST_IN_MEMORY:
        raise QuantityError(
            f"designs: {spec.grid.size} exceed the limit of {MOST_IN_MEMORY} in memory; use "
            "`layerjam sweep`"
        )
    search = Search(evolve(spec, confidence=confidence or 0.0))
    conflict = prove_impossible(search, progress)
    if conflict is not None:
        return infeasible_result(DesignResult.create, search, conflict)
    sweep = search.run_all(progress)
    result = best_result(DesignResult.create, search, sweep, accept, interval == "mean")
    if out is None or not result.feasible or result.failed_checks:
        return result
    best: int = (result.chosen or {})["number"]
    file = brake_of(result, best if number is None else number)
    return evolve(result, file=str(file.save(out, overwrite=overwrite)))


def brake_of(result: DesignResult, number: int | None = None) -> BrakeFile:
    """Return one brake of a design as a file, by the design's number, or of the refined design.

    If the design has several brakes, the file describes one of them. Numbers that were fitted or
    measured on the base brake of the design are labelled as belonging to it. Raises QuantityError
    if no design has the number, and for a brake whose checks fail unless `design` accepted them.
    """
    from layerjam.workshop.design.design_file import make_design_file, plain_name
    from layerjam.workshop.design.refine import replace_values
    from layerjam.workshop.design.verdict import design_checks

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
    acceptances = () if result.new_verdict is None else result.new_verdict.decisions
    file = make_design_file(spec, point, row["film"], name, acceptances)
    verdict = judge(design_checks(file, row["vacuum"]))
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
    make: Callable[..., R],
    search: Search,
    sweep: SweepResult,
    accept: Mapping[str, str] | None,
    of_mean: bool = False,
) -> R:
    """Return the result of a search; `accept` is {check: reason}, `of_mean` is for intervals."""
    from layerjam.workshop.design.design_file import make_design_file
    from layerjam.workshop.design.merit import MERITS
    from layerjam.workshop.design.refine import sensitivities
    from layerjam.workshop.design.robust import assess
    from layerjam.workshop.design.verdict import (
        binding_constraints,
        confidence_check,
        design_checks,
        explain_failure,
        explain_loss,
        find_likely,
        list_surer_losses,
        near_winners,
    )

    highlights = search.find_highlights(sweep)
    if not highlights.best:
        return infeasible_result(make, search, explain_failure(search, sweep, highlights), sweep)
    spec = search.spec
    front = sweep.numbers[highlights.front]
    places, assessments = find_likely(search, sweep, highlights)
    numbers = [int(sweep.numbers[k]) for k in places]
    number, chances = numbers[0], assessments[0]
    best_design, *others = (search.design(n) for n in numbers[:2])
    runner = others[0] if others else None
    surest = None
    if not chances.reaches(spec.confidence) and highlights.surest is not None:
        surest = search.assess(int(sweep.numbers[highlights.surest]))
    refinement = _refine_best(spec, numbers, assessments, float(highlights.scores[places[0]]))
    point = spec.grid.point(number)
    file = make_design_file(spec, point, best_design["film"], "the design")
    checks = *design_checks(file, best_design["vacuum"]), *confidence_check(spec, chances, surest)
    return make(
        judge(checks, accept),
        assess(spec, point, best_design, of_mean).state() if of_mean else chances.state(),
        name=spec.name,
        feasible=True,
        designs=spec.grid.size,
        examined=sweep.examined,
        feasible_designs=sweep.feasible,
        chosen=best_design,
        refined=None if refinement is None else refinement.design,
        runner_up=runner,
        runner_up_lost=runner and explain_loss(best_design, runner, spec.objectives),
        binding=binding_constraints(best_design, spec),
        forbidden=[
            *list_surer_losses(search, sweep, highlights, best_design, chances),
            *near_winners(search, sweep, highlights),
        ],
        front_size=len(front),
        front=search.designs(front[:MOST_SHOWN]),
        sensitivities=sensitivities(spec, point, tuple(sorted({*search.wanted} & {*MERITS}))),
        confidence=spec.confidence or None,
        robustness={k: chance._asdict() for k, chance in chances.chances.items()},
        surest=None if surest is None else surest.design["number"],
        warnings=[
            *_spec_notices(spec),
            *_chosen_brake_notices(spec, file),
            *_list_design_notices(len(front), runner is None),
        ],
        record=Designed(spec, search, refinement),
    )


def _refine_best(
    spec: DesignSpecification,
    numbers: Sequence[int],
    assessments: Sequence[Assessment],
    score: float,
) -> RefinedDesign | None:
    """Return the best design between the grid steps, with the confidence if the first has it."""
    from layerjam.workshop.design.refine import refine, replace_values
    from layerjam.workshop.design.robust import assess

    is_likely = spec.confidence > 0 and assessments[0].reaches(spec.confidence)
    refinements = []
    for place, assessment in zip(numbers, assessments, strict=True):
        margins = assessment.find_margins(spec) if is_likely else {}
        refinements.append(refine(spec, place, margins))
    for design in sorted(filter(None, refinements), key=lambda r: r.score):
        point = replace_values(spec.grid.point(design.number), design.values)
        if design.score > score:
            return None
        if not is_likely or assess(spec, point, design.design).reaches(spec.confidence):
            return design
    return None


def _chosen_brake_notices(spec: DesignSpecification, file: BrakeFile) -> Iterator[Notice]:
    """Return notices about the spacers of the chosen brake and the gauges of its film."""
    from layerjam.brake.device.gauge import gauge_notices

    keys = {notice.key for notice in spec.brake.spacer_notices()}
    yield from (notice for notice in file.spacer_notices() if notice.key not in keys)
    yield from gauge_notices(file)


def _list_design_notices(on_front: int, is_local: bool) -> Iterator[Notice]:
    if is_local:
        yield Notice(
            "no runner-up: every other feasible design has the same film and sheets",
            "no-runner-up",
        )
    if on_front > MOST_SHOWN:
        yield Notice(f"the front has {on_front} designs; {MOST_SHOWN} are listed", "front-cut")


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
