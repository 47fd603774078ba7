"""`friction`: static and kinetic friction from friction tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial as bound
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import Accept, OutBrake, Overwrite, TargetBrake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.device.mount import Site
from layerjam.brake.simulate.quantities import AREA
from layerjam.core.command.declare import Help, Progress, command, options
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.drawing.folder import to_json
from layerjam.core.errors import FitError, Notice, QuantityError
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.files import (
    PICTURE,
    FromFiles,
    describe_readings,
    read_each,
    write_brake,
)
from layerjam.laboratory.commands.reading import NORMAL_FORCE, FileOptions, Files, Partial

if TYPE_CHECKING:
    from layerjam.laboratory.identify.friction.agreement import Reference
    from layerjam.laboratory.identify.friction.outward import FrictionRepeat
    from layerjam.laboratory.identify.friction.reduction import FrictionResult
    from layerjam.laboratory.identify.friction.standards import Standard
    from layerjam.laboratory.measure.trace import Trace

DISPLACEMENT = QuantitySpec("m", "displacement of the sled", hi=10)
ALIKE = 1.5
"""Largest ratio of pressures that causes no notice."""


@options
class FrictionTest:
    """Conditions of friction tests, and options for their evaluation."""

    normal_force: Annotated[
        float | None, NORMAL_FORCE, Help("Force that presses the films together.")
    ] = None
    standard: Annotated[Literal["paper", "d1894", "iso8295"], Help("Evaluation standard.")] = (
        "paper"
    )
    start: Annotated[
        float | None,
        DISPLACEMENT,
        Help("Displacement where the kinetic window starts (paper: 40 mm).", option="--from"),
    ] = None
    end: Annotated[
        float | None,
        DISPLACEMENT,
        Help("Displacement where the kinetic window ends (paper: 100 mm).", option="--to"),
    ] = None
    area: Annotated[float | None, AREA, Help("Area under the sled.")] = None
    tare: Annotated[bool, Help("Subtract the force before the load rise.")] = False
    accept_stick_slip: Annotated[
        bool,
        Help("Use the midpoint of the stick–slip as kinetic friction.", old=("--accept-judder",)),
    ] = False

    def kinetic_window(self, rule: Standard) -> tuple[float, float] | None:
        """Return the window of the kinetic mean [m] or, if neither end is given, None."""
        if self.start is None and self.end is None:
            return None
        low, high = (
            default if limit is None else float(limit)
            for limit, default in zip((self.start, self.end), rule.window, strict=True)
        )
        if low >= high:
            raise QuantityError(f"from: {show(low, 'm')} is not below to, {show(high, 'm')}")
        return low, high

    window = kinetic_window  # former name


@result
class Friction(FromFiles, Judged):
    """Static and kinetic friction; `record` is (traces, FrictionResult), the traces thinned."""

    record: tuple[list[Trace], FrictionResult]
    static: float = number("1", "static friction, mean over the repeats")
    kinetic: float | None = number("1", "kinetic friction; null if the films stick and slip")
    static_sd: float | None = number("1", "SD between the repeats")
    kinetic_sd: float | None = number("1", "SD between the repeats")
    repeats: int = number("1", "repeats used")
    standard: str = fact("evaluation standard", listed=False)
    window: list[float] = number("m", "displacement range of the kinetic mean", listed=False)
    intervals: Mapping[str, Any] = fact("95 % intervals of the means", listed=False)
    stick_slip: Mapping[str, Any] | None = fact("envelope of the stick–slip", listed=False)
    pressure: Mapping[str, Any] = number("Pa", "pressures in test and brake", listed=False)
    reference: Mapping[str, Any] = fact("friction for comparison", listed=False)
    repeats_table: Sequence[Mapping[str, Any]] = fact("each repeat", listed=False)

    def lines(self) -> Iterator[str]:
        """Yield intervals of the means, the stick–slip, and one line per repeat."""
        yield ""
        for name, interval in self.intervals.items():
            if interval is not None and interval["low"] is not None:
                yield (
                    f"{name} {interval['mean']:.4f}, 95 % interval {interval['low']:.4f} to "
                    f"{interval['high']:.4f} (Student's t, {interval['repeats']} repeats)"
                )
        teeth = self.stick_slip
        if teeth is not None:
            every = show(teeth["spacing"], "m", 3)
            if teeth["period"] is not None:
                every += f", {show(teeth['period'], 's', 3)}"
            yield f"stick–slip between {teeth['lower']:.4f} and {teeth['upper']:.4f}, every {every}"
        yield "file: static, kinetic, displacement range of the kinetic mean"
        for row in self.repeats_table:
            kinetic = "stick–slip" if row["kinetic"] is None else f"{row['kinetic']:.4f}"
            start, end = (show(w, "m") for w in row["window"])
            yield f"  {Path(row['file']).name}: {row['static']:.4f}, {kinetic}, {start} to {end}"

    def draw(self) -> Figure:
        """Return the figure of the friction coefficient versus displacement for every repeat."""
        from layerjam.laboratory.figures import friction_figures

        return friction_figures.draw_friction(*self.record)


@command("test")
def friction(
    files: Files,
    *,
    test: FrictionTest = FrictionTest(),
    brake: TargetBrake | None = None,
    out: OutBrake | None = None,
    partial: Partial = False,
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    progress: Progress | None = None,
    overwrite: Overwrite = False,
) -> Friction:
    """Determine friction from friction tests, as in the paper, ASTM D1894 or ISO 8295.

    `files` are one or more paths or traces. `normal_force` may come from the files' sidecars, or
    from the 200 g of the two standards; `start` and `end` bound the displacement of the kinetic
    mean, counted from the record's first sample; `area` is the contact area of the sled, which sets
    the pressure. If a record shows stick–slip, `kinetic` is None; `accept_stick_slip` uses the
    midpoint of the stick–slip. With `tare` the force before the load rise is subtracted. With
    `brake` and `out` the result is written into a copy of the brake's file. If a check fails,
    nothing is written; `accept` accepts failed checks by name, {check: reason}.
    """
    from layerjam.laboratory.identify.friction.reduction import add_friction, pool
    from layerjam.laboratory.identify.friction.standards import find_standard

    if (brake is None) != (out is None):
        raise QuantityError("brake and out: give both to write a brake, or neither")
    rule = find_standard(test.standard)
    span, accept_envelope = test.kinetic_window(rule), test.accept_stick_slip
    used, refusals = read_each(files, bound(_reduce_trace, test, rule), options, progress)
    normal = _common_load({trace.path: load for trace, _, load in used})
    traces = [trace for trace, _, _ in used]
    file_warnings = [w for trace in traces for w in trace.warnings]
    film = _find_film_reference(traces, brake)
    result = pool([r for _, r, _ in used], file_warnings, normal, span, rule, accept_envelope, film)
    verdict = judge(result.checks, accept, list_numbers(result), out, files=len(used))
    warnings = [*result.warnings, *_load_notices(traces, normal, test.normal_force is None, rule)]
    pressure, notices = _compute_pressures(
        normal, test, traces, brake.brake.site if brake else Site(), rule
    )
    warnings += [*_stick_slip_notices(result), *notices, *_film_notices(traces, brake)]
    path = None
    if brake is not None:
        text, effects = add_friction(brake, result, Path(str(out)).stem, verdict)
        path, lines = write_brake(out, lambda _: text, overwrite, bool(refusals), partial, verdict)
        warnings += effects if path else lines
    return Friction.create(
        result,
        verdict,
        repeats=len(result.repeats),
        standard=rule.name,
        window=list(result.window),
        intervals={name: values and values.as_dict() for name, values in result.over.items()},
        stick_slip=to_json(result.stick_slip),
        pressure=pressure,
        reference={"basis": result.reference.basis, **to_json(result.reference)},
        repeats_table=[_make_repeat_row(r, normal) for r in result.repeats],
        understood=describe_readings(traces),
        refused=refusals,
        file=path,
        warnings=warnings,
        record=(traces, result),
    )


def _reduce_trace(
    test: FrictionTest, rule: Standard, trace: Trace
) -> tuple[Trace, FrictionRepeat, float]:
    """Return a trace, thinned, its evaluation and its normal force [N].

    Raises FitError if the normal force is unknown, or if the trace cannot be evaluated.
    """
    from layerjam.laboratory.identify.friction.reduction import GRAVITY, reduce_repeat

    by_rule = None if rule.sled_mass is None else rule.sled_mass * GRAVITY
    load = test.normal_force or trace.facts.normal_force or by_rule
    if load is None:
        raise FitError("the normal force on the films is unknown; give --normal-force")
    span = test.kinetic_window(rule)
    repeat = reduce_repeat(trace, load, span, rule, test.accept_stick_slip, test.tare)
    return trace.thinned(PICTURE), repeat, float(load)


def list_numbers(result: FrictionResult) -> list[str]:
    """Return the dotted paths of the numbers that friction tests determine."""
    return [f"film.{name}" for name in result.means]


def _common_load(forces: Mapping[str, float]) -> float:
    """Return the normal force [N] of all tests, {path: force}; FitError if they differ."""
    files = {load: path for path, load in forces.items()}
    if len(files) > 1:
        loads = (f"{show(v, 'N')} in {Path(path).name}" for v, path in sorted(files.items()))
        raise FitError(f"the files' normal forces differ: {', '.join(loads)}")
    return next(iter(files))


def _find_film_reference(traces: Sequence[Trace], brake: BrakeFile | None) -> Reference | None:
    """Return the friction to compare with; None if the film is unknown.

    It is that of `brake`, or that of the catalogue brake that all files name.
    """
    from layerjam.laboratory.identify.friction.agreement import find_reference

    names = {trace.facts.brake for trace in traces}
    if brake is None and len(names) == 1 and (name := names.pop()) in catalogue():
        brake = load(str(name))
    return None if brake is None else find_reference(brake)


def _film_notices(traces: Sequence[Trace], brake: BrakeFile | None) -> Iterator[Notice]:
    """Yield one notice about files whose sidecar names a brake with another film than `brake`."""
    product = None if brake is None else brake.known_values.get("film.product")
    others = {}
    for trace in traces:
        name = trace.facts.brake
        if name in catalogue() and product is not None:
            film = load(str(name)).known_values.get("film.product")
            if film not in (None, product):
                others[name] = film
    for name, film in others.items():
        yield Notice(
            f"sidecars name the brake {name}, whose film is {film}; the brake given has {product}",
            "other-film",
        )


def _load_notices(
    traces: Sequence[Trace], load: float, assumed: bool, rule: Standard
) -> Iterator[Notice]:
    """Yield notices about normal forces that are not stated or that sidecars contradict."""
    for trace in traces:
        own_load = trace.facts.normal_force
        if own_load is not None and abs(own_load - load) > 1e-3 * load:
            yield Notice(
                f"{Path(trace.path).name}: its sidecar states {show(own_load, 'N')}, but "
                f"the normal force given, {show(load, 'N')}, takes precedence",
                "normal-force-stated",
            )
        if own_load is None and assumed:
            yield Notice(
                f"the normal force of {show(load, 'N')} is that of the "
                f"{show(rule.sled_mass, 'kg')} sled of {rule.title}; give --normal-force "
                "if yours differs",
                "normal-force-assumed",
            )


def _compute_pressures(
    load: float, test: FrictionTest, traces: Sequence[Trace], site: Site, rule: Standard
) -> tuple[dict[str, Any], list[Notice]]:
    """Return the pressures in the test and in the brake, and a notice if they differ.

    The area of the sled is the given one, otherwise that in a sidecar, otherwise that of the
    standard.
    """
    area: Any = test.area or next((t.facts.area for t in traces if t.facts.area), None)
    sled_area, use = area or rule.area, site.atmosphere
    stress = load / sled_area
    whose = "the given area" if area else f"the area of {rule.title}; set --area to change it"
    sentence = (
        f"the films were pressed with {show(stress, 'Pa')} ({whose}), but a brake presses "
        f"them with up to {show(use, 'Pa')}, {use / stress:.0f} times as much. "
        "Friction changes with pressure; only pulls of the brake show by how much"
    )
    ratio = use / stress
    pressures = {"test": stress, "use": use, "ratio": ratio, "area": sled_area}
    notices = [Notice(sentence, "pressure")] if ratio > ALIKE else []
    return pressures | {"area_assumed": area is None}, notices


def _stick_slip_notices(friction: FrictionResult) -> Iterator[Notice]:
    envelope = friction.stick_slip
    if envelope is None:
        return
    consequence = (
        f"its midpoint, {envelope.middle:.4g}, is used as kinetic friction"
        if envelope.accepted
        else "no steady kinetic friction can be averaged (--accept-stick-slip uses the midpoint)"
    )
    yield Notice(
        f"{', '.join(envelope.files)}: the films stick and slip between "
        f"{envelope.lower:.4g} and {envelope.upper:.4g}, every "
        f"{show(envelope.spacing, 'm', 3)}; {consequence}",
        "stick-slip" if envelope.accepted else "no-kinetic-friction",
    )
    if not friction.standard.first_maximum:
        yield Notice(
            "static friction is taken from the maximum force, here the highest of many "
            "stick–slip peaks and therefore above their mean; --standard d1894 uses the "
            "first maximum",
            "static-of-teeth",
        )


def _make_repeat_row(repeat: FrictionRepeat, load: float) -> dict[str, Any]:
    teeth, inertia, zero = repeat.teeth, repeat.inertia, repeat.record.zero
    return {
        "file": repeat.path,
        "static": repeat.static,
        "kinetic": repeat.kinetic,
        "static_at": repeat.static_at,
        "static_stands_out": repeat.distinct,
        "window": list(repeat.window),
        "samples": repeat.samples,
        "tared": repeat.record.tare_force,
        "zero": zero and zero.force,
        "zero_se": zero and zero.error,
        "spikes": len(repeat.record.spikes),
        "resolution": repeat.record.quantum,
        "speed": repeat.speed,
        "stick_slip": teeth is not None,
        "ripple": repeat.ripple is not None,
        "upper": teeth and teeth.upper / load,
        "lower": teeth and teeth.lower / load,
        "period": teeth and teeth.period,
        "spacing": teeth and teeth.spacing,
        "inertial_force": inertia and inertia.bound,
        "connection_stiffness": inertia and inertia.stiffness,
        "acceleration": inertia and inertia.acceleration,
    }
