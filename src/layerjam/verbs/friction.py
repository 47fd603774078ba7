"""`friction`: static and kinetic friction from friction tests."""

from __future__ import annotations

from pathlib import Path

from layerjam.errors import FitError, QuantityError
from layerjam.identify.columns import Choices
from layerjam.identify.friction_test import (
    WINDOW,
    reduce_friction,
    reduce_repeat,
    with_friction,
)
from layerjam.identify.trace import Trace
from layerjam.units import show
from layerjam.verbs.answer import (
    NORMAL_FORCE,
    SLIP,
    TRAVEL,
    Answer,
    AnyBrake,
    Quantity,
    brake_at,
    si,
)
from layerjam.verbs.files import Paths, each, write_brake


def friction(
    files: Paths,
    *,
    normal_force: Quantity | None = None,
    window: tuple[Quantity, Quantity] = WINDOW,
    brake: AnyBrake | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    choices: Choices | None = None,
    force: bool = False,
) -> Answer:
    """Static and kinetic friction from friction tests, as the paper reduces them.

    `normal_force` may come from the files' sidecars; `window` is the travel of the kinetic mean.
    With `brake` and `out` the result is written into a copy of the brake's file. `choices` answers
    what a file leaves open (sign, column, decimal sign). `record` is (traces, FrictionResult).
    """
    if (brake is None) != (out is None):
        raise QuantityError("brake and out: give both to write a brake, or neither")
    target = brake_at(brake, None) if brake is not None else None
    span = si(window[0], SLIP, "from"), si(window[1], TRAVEL, "to")
    if span[0] >= span[1]:
        raise QuantityError(f"from: {show(span[0], 'm')} is not below to, {show(span[1], 'm')}")
    given = None if normal_force is None else si(normal_force, NORMAL_FORCE, "normal force")

    def use(trace: Trace) -> tuple[Trace, float]:
        pressed = given if given is not None else trace.facts.normal_force
        if pressed is None:
            raise FitError("nothing says how hard the films were pressed; give --normal-force")
        reduce_repeat(trace, pressed, span)
        return trace, pressed

    used, refused = each(files, use, choices)
    loads = sorted({pressed for _, pressed in used})
    if len(loads) > 1:
        raise FitError(f"the files' normal forces differ: {', '.join(show(v, 'N') for v in loads)}")
    traces = [trace for trace, _ in used]
    result = reduce_friction(traces, loads[0], span)
    warnings = list(result.warnings)
    for trace in traces:
        stated = trace.facts.normal_force
        if stated is not None and abs(stated - loads[0]) > 1e-3 * loads[0]:
            warnings.append(
                f"{Path(trace.path).name}: its sidecar says {show(stated, 'N')}, the normal force "
                f"given is {show(loads[0], 'N')}, which counts"
            )
    written = None
    if target is not None:
        text, more = with_friction(target, result, Path(str(out)).stem)
        written, said = write_brake(out, lambda _: text, force, bool(refused), partial)
        warnings += more if written else said
    return Answer(
        values={
            "static": result.static,
            "kinetic": result.kinetic,
            "static_sd": result.static_sd,
            "kinetic_sd": result.kinetic_sd,
            "repeats": len(result.repeats),
            "understood": {t.path: list(t.understood) for t in traces},
            "refused": refused,
            "file": written,
        },
        units=dict.fromkeys(("static", "kinetic", "static_sd", "kinetic_sd", "repeats"), "1"),
        warnings=warnings,
        refused=refused,
        record=(traces, result),
    )
