"""`tensile`: a pull of the brake in a simulated test machine."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import (
    Atmosphere,
    BrakeInput,
    CrossheadSpeed,
    Interval,
    LeakTime,
    OtherFilm,
    PullElongation,
    Vacuum,
    VacuumShare,
    apply_share,
    check_vacuum,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.procedure import Procedure, Pull, Return, parse_procedure, simple_pull
from layerjam.brake.simulate.quantities import SEED
from layerjam.core.command.declare import Help, Progress, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import Notice, ProcedureError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.brake.simulate.record import TensileRecord
    from layerjam.brake.simulate.sheet_motion import SheetMotion
    from layerjam.brake.simulate.stack_layout import Housing, Interfaces
    from layerjam.core.drawing.chart import Pane

SCATTER = QuantitySpec("1", "relative SD of the interfaces' friction", hi=2, example="10%")
SAMPLES = QuantitySpec(
    "1", "stacks pulled to estimate the scatter", lo=2, hi=10_000_000, whole=True
)
LUMPED = "only valid with the model 'lumped'; the stack keeps its initial vacuum"
STACK = "only valid with the model 'stack'; the lumped brake has one friction force"


@result
class Tensile(PredictionResult):
    """Simulated pull; `record` is the TensileRecord.

    For the "stack" model, `motion` states which sheets move and which interfaces slide, at a few
    hundred elongations. It is None for the lumped brake, which has a single friction force.
    """

    record: "TensileRecord"
    peak_force: float = number("N", "maximum force of the pull")
    peak_elongation: float = number("m", "elongation at the maximum force")
    force_at_end: float = number("N", "force at the end of the pull")
    work: float = number("J", "work done by the test machine")
    dissipated_energy: float = number("J", "work minus the energy stored at the end")
    outcome: str = fact("outcome of the pull")
    procedure: str = fact("steps that were run")
    samples: int | None = number("1", "number of stacks pulled", default=None)
    seed: int | None = number("1", "random seed for the scatter", default=None)
    scatter: float | None = number("1", "relative SD of the interfaces' friction", default=None)
    peak_mean: float | None = number("N", "mean of the stacks' peaks", default=None)
    peak_sd: float | None = number("N", "SD of the stacks' peaks", default=None)
    stiffness_mean: float | None = number("N/m", "mean of the stacks' stiffness", default=None)
    stiffness_sd: float | None = number("N/m", "SD of the stacks' stiffness", default=None)
    onset_mean: float | None = number("N", "mean force at the first slip", default=None)
    onset_sd: float | None = number("N", "SD of the force at the first slip", default=None)
    motion: "SheetMotion | None" = None

    def panes(self) -> "Sequence[Pane]":
        """Return the pane of force versus elongation."""
        from layerjam.brake.figures import force_figures

        return force_figures.tensile_panes(self.record)

    curve_kind = "pull"

    @classmethod
    def can_overlay(cls, kind: type[Result]) -> bool:
        """Return whether `kind` is also a pull, computed or measured."""
        return kind.curve_kind == cls.curve_kind


@command("predict", record=(".csv", ".nc"))
def tensile(
    brake: BrakeInput,
    *,
    vacuum: Vacuum | None = None,
    speed: CrossheadSpeed | None = None,
    elongation: PullElongation | None = None,
    procedure: Annotated[
        str | Procedure | None,
        Help(
            "Steps instead, e.g. 'evacuate to 50 kPa; pull at 1 mm/s until 20 mm; return at 1 mm/s "
            "to 0 mm'.",
            metavar="TEXT",
        ),
    ] = None,
    model: Annotated[
        Literal["lumped", "stack"], Help("A single friction force, or a sheet-by-sheet stack.")
    ] = "lumped",
    static: Annotated[bool, Help("Stack: use static friction until an interface slides.")] = False,
    one_by_one: Annotated[
        bool, Help("Stack, with --static: interfaces that a slip overloads slip one at a time.")
    ] = False,
    interfaces: "Interfaces | None" = None,
    housing: "Housing | None" = None,
    scatter: Annotated[float | None, SCATTER, Help("Stack: relative SD of the friction.")] = None,
    samples: Annotated[int | None, SAMPLES, Help("Stack: number of stacks pulled (1000).")] = None,
    seed: Annotated[int | None, SEED, Help("Stack: random seed for the scatter (1).")] = None,
    vacuum_share: VacuumShare | None = None,
    leak_time: LeakTime | None = None,
    progress: Progress | None = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
) -> Tensile:
    """Pull a brake in a simulated test machine.

    Give either vacuum, speed and elongation (of the crosshead), or a procedure. The
    following options are for the "stack" model. `static` uses static friction before an interface
    slides. With `one_by_one`, overloaded interfaces slip one at a time, the most overloaded first.
    `interfaces` may differ, and a `housing` may rub. `scatter` is the relative SD of the
    interfaces' friction: `samples` (1000) stacks, drawn from `seed` (1), then yield the mean and SD
    of peak, stiffness and onset; if interrupted, those of the stacks done so far. The fraction
    `vacuum_share` of the gauge's reading presses the sheets. With `leak_time` the line is shut off
    after every evacuation and the vacuum leaks away from then on, except in the "stack" model,
    which keeps its initial vacuum. Intervals are those of the brake's uncertain numbers, without
    the `scatter` of single interfaces. Raises ProcedureError or QuantityError for contradictions.
    """
    brake = apply_share(brake, vacuum_share)
    steps = _make_procedure(brake, vacuum, speed, elongation, procedure)
    layout: dict[str, Any] = {"static": static, "one_by_one": one_by_one}
    layout |= {"interfaces": interfaces, "housing": housing}
    scatter_options: dict[str, Any] = {"scatter": scatter, "samples": samples, "seed": seed}
    if model == "stack":
        if leak_time is not None:
            raise QuantityError.of("leak_time", LUMPED)
        return _pull_stack(
            *(brake, steps, layout, interval == "mean"),
            **scatter_options,
            tell=progress or (lambda *_: None),
        )
    for name, value in {**layout, **scatter_options}.items():
        if value is not None and value is not False:
            raise QuantityError(f"{name}: {STACK}")
    from layerjam.brake.simulate.pull_spread import spread_pull
    from layerjam.brake.simulate.tensile import tensile as pull_lumped

    record = pull_lumped(brake, steps, leak_time=leak_time)
    prediction, scatter_found = spread_pull(
        brake, steps, record, leak_time=leak_time, of_mean=interval == "mean"
    )
    return _tensile_result(record, prediction.notices(), **prediction.state(**scatter_found))


def _tensile_result(
    record: "TensileRecord", notices: Sequence[Notice] = (), **more: Any
) -> Tensile:
    from layerjam.brake.simulate.pull_spread import pull_numbers

    return Tensile(
        **pull_numbers(record),
        outcome=str(record.outcome),
        procedure=record.procedure,
        warnings=[*record.warnings, *notices],
        record=record,
        **more,
    )


def _pull_stack(
    brake: BrakeFile,
    steps: Procedure,
    layout: dict[str, Any],
    of_mean: bool,
    *,
    scatter: float | None,
    samples: int | None,
    seed: int | None,
    tell: Progress,
) -> Tensile:
    """Return the sheet-by-sheet pull, and its spread over stacks with scattered interfaces."""
    import numpy as np

    # use compiled loops only if requested
    from layerjam.brake.simulate.pull_spread import spread_pull
    from layerjam.brake.simulate.sheet_motion import sheet_motion
    from layerjam.brake.simulate.stack import fix_sliding_speed, tensile_stack
    from layerjam.brake.simulate.stack_spread import peak_spread

    if scatter is None and (samples is not None or seed is not None):
        raise QuantityError("samples and seed: only valid with scatter")
    highest = check_vacuum(steps.highest_vacuum(), brake.brake)
    tell("pull", 0.0)
    record, pull = tensile_stack(brake, steps, **layout, progress=lambda p: tell("pull", p))
    motion = sheet_motion(record, pull)
    prediction, ends = spread_pull(
        *(brake, steps, record),
        of_mean=of_mean,
        pull=lambda file: tensile_stack(file, steps, **layout)[0],
        has_static=layout["static"],
    )
    notices, state = prediction.notices(), prediction.state(**ends)
    if scatter is None:
        return _tensile_result(record, notices, motion=motion, **state)
    count, start = 1000 if samples is None else samples, 1 if seed is None else seed
    tell("scatter", 0.0)

    def report_progress(count: int, total: int) -> None:
        tell("scatter", count / total)

    pace = next(step.speed for step in steps.steps if isinstance(step, Pull | Return))
    brake_at_speed = evolve(brake, brake=fix_sliding_speed(pace, brake.brake))
    spread = peak_spread(
        brake_at_speed, highest, scatter, count, start, **layout, progress=report_progress
    )
    if count_lost := int((~np.isfinite(spread.peak)).sum()):
        sentence = f"{count_lost} of {count} stacks could not be followed to their peak"
        notices.append(Notice(sentence, "lost-stacks"))
    numbers: dict[str, Any] = {"samples": count, "seed": start, "scatter": scatter}
    for name in ("peak", "stiffness", "onset"):
        samples_found = getattr(spread, name)
        samples_found = samples_found[np.isfinite(samples_found)]
        numbers[f"{name}_mean"] = float(samples_found.mean()) if len(samples_found) else None
        numbers[f"{name}_sd"] = float(samples_found.std(ddof=1)) if len(samples_found) > 1 else None
    return _tensile_result(record, notices, motion=motion, **numbers, **state)


def _make_procedure(
    brake: BrakeFile, vacuum: Any, speed: Any, elongation: Any, procedure: str | Procedure | None
) -> Procedure:
    numbers = {"vacuum": vacuum, "speed": speed, "elongation": elongation}
    if procedure is not None:
        both = [name for name, value in numbers.items() if value is not None]
        if both:
            raise ProcedureError(f"give a procedure or {', '.join(both)}, not both")
        return procedure if isinstance(procedure, Procedure) else parse_procedure(procedure)
    missing = [name for name, value in numbers.items() if value is None]
    if missing:
        them = "it" if len(missing) == 1 else "them"
        raise ProcedureError(f"{', '.join(missing)}: missing; state {them} or a procedure")
    return simple_pull(check_vacuum(vacuum, brake.brake), speed, elongation)
