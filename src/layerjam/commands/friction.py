"""`friction`: static and kinetic friction from friction tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from layerjam.commands.answer import (
    NORMAL_FORCE,
    SLIP,
    TRAVEL,
    Answer,
    AnyBrake,
    Quantity,
    brake_at,
    si,
)
from layerjam.commands.files import PICTURE, Paths, Progress, each, understood, write_brake
from layerjam.device.mount import Site
from layerjam.errors import FitError, QuantityError
from layerjam.identify.friction.reduction import (
    GRAVITY,
    FrictionRepeat,
    FrictionResult,
    pooled,
    reduce_repeat,
    with_friction,
)
from layerjam.identify.friction.standards import Standard, standard_named
from layerjam.measure.options import ReadingOptions
from layerjam.measure.trace import Trace
from layerjam.units import QuantitySpec, show

AREA = QuantitySpec("m^2", "area under the sled", lo=1e-6, hi=1.0)
ALIKE = 1.5
"""Up to this ratio of pressures nothing is said."""
UNITS = {
    **dict.fromkeys(("static", "kinetic", "static_sd", "kinetic_sd", "repeats"), "1"),
    "window": "m",
    "pressure": "Pa",
}


def friction(
    files: Paths,
    *,
    normal_force: Quantity | None = None,
    window: tuple[Quantity | None, Quantity | None] | None = None,
    standard: str = "paper",
    area: Quantity | None = None,
    accept_judder: bool = False,
    brake: AnyBrake | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    choices: ReadingOptions | None = None,
    progress: Progress | None = None,
    force: bool = False,
) -> Answer:
    """Static and kinetic friction from friction tests.

    `standard` is "paper", "d1894" or "iso8295". `normal_force` may come from the files' sidecars,
    or from the 200 g of the two standards; `window` is the travel of the kinetic mean, counted
    from the record's first sample; `area` is that under the sled, for the pressure of the test.
    Where a record judders kinetic is None; `accept_judder` takes the middle of the stick-slip.
    With `brake` and `out` the result is written into a copy of the brake's file. `choices` answers
    what a file leaves open (sign, column, decimal sign). `progress` is told (what, share done).
    `record` is (traces, FrictionResult), traces thinned.
    """
    if (brake is None) != (out is None):
        raise QuantityError("brake and out: give both to write a brake, or neither")
    rule = standard_named(standard)
    target = brake_at(brake, None) if brake is not None else None
    span = _span(window, rule)
    given = None if normal_force is None else si(normal_force, NORMAL_FORCE, "normal force")
    under = rule.area if area is None else si(area, AREA, "area")
    by_rule = None if rule.sled_mass is None else rule.sled_mass * GRAVITY

    def use(trace: Trace) -> tuple[Trace, FrictionRepeat, float]:
        pressed = given if given is not None else trace.facts.normal_force or by_rule
        if pressed is None:
            raise FitError("nothing says how hard the films were pressed; give --normal-force")
        repeat = reduce_repeat(trace, pressed, span, rule, accept_judder)
        return trace.thinned(PICTURE), repeat, pressed

    used, refused = each(files, use, choices, progress)
    loads = sorted({pressed for _, _, pressed in used})
    if len(loads) > 1:
        raise FitError(f"the files' normal forces differ: {', '.join(show(v, 'N') for v in loads)}")
    traces = [trace for trace, _, _ in used]
    odd = [w for trace in traces for w in trace.warnings]
    result = pooled([r for _, r, _ in used], odd, loads[0], span, rule, accept_judder)
    warnings = [*result.warnings, *_odd_loads(traces, loads[0], given is None, rule)]
    warnings += _of_judder(result)
    atmosphere = target.brake.site.atmosphere if target is not None else Site().atmosphere
    pressure = _pressure(loads[0], under, atmosphere, area is None, rule)
    said = pressure.pop("sentence")
    warnings += [said] if pressure["ratio"] > ALIKE else []
    written = None
    if target is not None:
        text, more = with_friction(target, result, Path(str(out)).stem)
        written, why = write_brake(out, lambda _: text, force, bool(refused), partial)
        warnings += more if written else why
    intervals = {
        "static": result.over_static.as_dict(),
        "kinetic": None if result.over_kinetic is None else result.over_kinetic.as_dict(),
    }
    return Answer(
        values={
            "static": result.static,
            "kinetic": result.kinetic,
            "static_sd": result.static_sd,
            "kinetic_sd": result.kinetic_sd,
            "repeats": len(result.repeats),
            "standard": rule.name,
            "window": list(result.window),
            "intervals": intervals,
            "stick_slip": _stick_slip(result),
            "pressure": pressure,
            "repeats_table": [_row(r, loads[0]) for r in result.repeats],
            "understood": understood(traces),
            "refused": refused,
            "file": written,
        },
        units=UNITS,
        warnings=warnings,
        refused=refused,
        record=(traces, result),
    )


def _span(
    window: tuple[Quantity | None, Quantity | None] | None, rule: Standard
) -> tuple[float, float] | None:
    """The window asked for [m]; what is left open comes from the standard; None for the latter."""
    if window is None or window == (None, None):
        return None
    asked = [si(v, m, n) if v is not None else None
             for v, m, n in zip(window, (SLIP, TRAVEL), ("from", "to"), strict=True)]  # fmt: skip
    low, high = (rule.window[i] if v is None else v for i, v in enumerate(asked))
    if low >= high:
        raise QuantityError(f"from: {show(low, 'm')} is not below to, {show(high, 'm')}")
    return low, high


def _odd_loads(traces: Sequence[Trace], load: float, assumed: bool, rule: Standard) -> list[str]:
    """Normal forces that sidecars state otherwise, or that nobody stated."""
    out = []
    for trace in traces:
        stated = trace.facts.normal_force
        if stated is not None and abs(stated - load) > 1e-3 * load:
            out.append(
                f"{Path(trace.path).name}: its sidecar says {show(stated, 'N')}, the normal force "
                f"given is {show(load, 'N')}, which counts"
            )
        if stated is None and assumed:
            out.append(
                f"the normal force is that of the {show(rule.sled_mass, 'kg')} sled of "
                f"{rule.title}, {show(load, 'N')}; give --normal-force if yours differs"
            )
    return out


def _pressure(
    load: float, area: float, use: float, assumed: bool, rule: Standard
) -> dict[str, Any]:
    """How the pressure of the test lies to that of use."""
    test = load / area
    whose = f"the area of {rule.title}, another one: --area" if assumed else "the area given"
    return {
        "test": test,
        "use": use,
        "ratio": use / test,
        "area": area,
        "area_assumed": assumed,
        "sentence": f"the films were pressed with {show(test, 'Pa')} ({whose}), a brake presses "
        f"them with up to {show(use, 'Pa')}, {use / test:.0f} times that; friction changes with "
        "pressure, and only pulls of the brake tell by how much",
    }


def _of_judder(result: FrictionResult) -> list[str]:
    """What to say of stick-slip."""
    saw = _stick_slip(result)
    if saw is None:
        return []
    names = ", ".join(saw["files"])
    what = (
        f"the middle, {saw['middle']:.4g}, is taken as kinetic friction"
        if result.accepted
        else "there is no kinetic friction to average (--accept-judder takes the middle)"
    )
    said = [
        f"{names}: the films stick and slip between {saw['lower']:.4g} and {saw['upper']:.4g}, "
        f"every {show(saw['spacing'], 'm', 3)}; {what}"
    ]
    if not result.standard.first_maximum:
        said.append(
            "static is the greatest force, here the highest of many teeth, and so above what "
            "they end at on average; --standard d1894 takes the first maximum"
        )
    return said


def _stick_slip(result: FrictionResult) -> dict[str, Any] | None:
    """The envelope over the repeats that judder, as coefficients; None where none does."""
    found = [r.teeth for r in result.judders if r.teeth is not None]
    if not found:
        return None

    def mean(values: Sequence[float]) -> float:
        return sum(values) / len(values)

    upper = mean([t.upper for t in found]) / result.normal_force
    lower = mean([t.lower for t in found]) / result.normal_force
    periods = [t.period for t in found if t.period is not None]
    return {
        "upper": upper,
        "lower": lower,
        "amplitude": (upper - lower) / 2,
        "middle": (upper + lower) / 2,
        "relative_amplitude": (upper - lower) / (upper + lower),
        "period": mean(periods) if len(periods) == len(found) else None,
        "spacing": mean([t.spacing for t in found]),
        "files": [r.path for r in result.judders],
        "accepted": result.accepted,
        "reason": "stick-slip has no plain mean: kinetic is the middle of its envelope"
        if result.accepted
        else "stick-slip has no plain mean, so that kinetic is not reported",
    }


def _row(repeat: FrictionRepeat, load: float) -> dict[str, Any]:
    """One repeat for the table."""
    teeth, inertia = repeat.teeth, repeat.inertia
    return {
        "file": repeat.path,
        "static": repeat.static,
        "kinetic": repeat.kinetic,
        "static_at": repeat.static_at,
        "static_stands_out": repeat.distinct,
        "window": list(repeat.window),
        "samples": repeat.samples,
        "speed": repeat.speed,
        "stick_slip": teeth is not None,
        "upper": None if teeth is None else teeth.upper / load,
        "lower": None if teeth is None else teeth.lower / load,
        "period": None if teeth is None else teeth.period,
        "spacing": None if teeth is None else teeth.spacing,
        "inertial_force": None if inertia is None else inertia.most,
        "connection_stiffness": None if inertia is None else inertia.stiffness,
        "acceleration": None if inertia is None else inertia.acceleration,
    }
