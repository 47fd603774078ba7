"""`friction`, `calibrate` and `validate`: what the lab says of a brake."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile, read_brake
from layerjam.device.load import catalogue, materials, write_whole
from layerjam.errors import FileError, FitError, LayerjamError, QuantityError
from layerjam.identify.columns import Choices
from layerjam.identify.fit import calibrate as fit
from layerjam.identify.fit import calibrated_text, fit_pull
from layerjam.identify.friction_test import (
    WINDOW,
    reduce_friction,
    reduce_repeat,
    with_friction,
)
from layerjam.identify.metrics import compare, validate_pulls
from layerjam.identify.provenance import calibrated_on, sha256
from layerjam.identify.pull import PullFeatures, pull_features
from layerjam.identify.readers import read_trace
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
    vacuum_of,
)

T = TypeVar("T")
Paths = Sequence[str | Path]


def _each(
    files: Paths, use: Callable[[Trace], T], choices: Choices | None
) -> tuple[list[T], dict[str, str]]:
    """`use` of every file that can be used, and {file: why} of those that cannot.

    Where none can be used, the first one's reason is an error.
    """
    done: list[T] = []
    refused: dict[str, str] = {}
    seen: dict[str, str] = {}
    for path in files:
        try:
            trace = read_trace(path, choices)
            digest = sha256(trace.path)
            if digest in seen:
                raise FitError(f"holds the same measurement as {seen[digest]}, which counts once")
            seen[digest] = str(path)
            done.append(use(trace))
        except FileError as error:
            line = f"line {error.line}: " if error.line else ""
            own = error.path == str(path)  # else the sidecar beside it
            refused[str(path)] = line + error.reason if own else str(error)
        except LayerjamError as error:
            refused[str(path)] = str(error).removeprefix(f"{path}: ")
    if not done:
        if not refused:
            raise FitError("no file was given")
        path, why = next(iter(refused.items()))
        more = f" ({len(refused) - 1} more files were refused too)" if len(refused) > 1 else ""
        raise FileError(path, why + more)
    return done, refused


def _odd(trace: Trace, file: BrakeFile, vacuum: Quantity | None, pressure: float) -> Iterator[str]:
    """What the sidecar says against the command."""
    name = Path(trace.path).name
    if vacuum is not None and abs(vacuum_of(vacuum, file.brake) - pressure) > 1e-6 * pressure:
        yield f"{name}: its file or sidecar says {show(pressure, 'Pa')}, which counts, not --vacuum"
    known = catalogue()
    if trace.facts.brake in known and file.name in known and trace.facts.brake != file.name:
        yield f"{name}: its sidecar names the brake {trace.facts.brake}, this is {file.name}"


def _vacuum(trace: Trace, given: Quantity | None, brake: Brake) -> float:
    if trace.facts.vacuum is not None:
        return vacuum_of(trace.facts.vacuum, brake, "vacuum in its sidecar")
    if given is None:
        raise FitError(
            f"nothing says at which vacuum it was pulled; give --vacuum, or write "
            f'{Path(trace.path).name}.toml beside it with a line such as vacuum = "94.5 kPa"'
        )
    return vacuum_of(given, brake)


def _pulls(
    files: Paths,
    file: BrakeFile,
    vacuum: Quantity | None,
    choices: Choices | None,
    test: Callable[[PullFeatures, float, Brake], object],
) -> tuple[list[tuple[Trace, PullFeatures, float]], dict[str, str], list[str]]:
    """Pulls with their features and vacuums [Pa], refused files, and what is odd about the rest.

    `test` raises for a pull that cannot be used.
    """
    if vacuum is not None:
        vacuum_of(vacuum, file.brake)

    def use(trace: Trace) -> tuple[Trace, PullFeatures, float]:
        pressure = _vacuum(trace, vacuum, file.brake)
        pull = pull_features(trace)
        far, overlap = float(pull.elongation[-1]), file.brake.sheets.overlap
        if far > 2 * overlap:
            raise FitError(
                f"pulls to {show(far, 'm')}, but the sheets overlap by {show(overlap, 'm')}: is "
                "the unit of the elongation right?"
            )
        test(pull, pressure, file.brake)
        return trace, pull, pressure

    used, refused = _each(files, use, choices)
    odd = [w for t, _, _ in used for w in t.warnings]
    odd += [w for t, _, p in used for w in _odd(t, file, vacuum, p)]
    return used, refused, odd


def _write_brake(
    out: str | Path | None, text: Callable[[str], str], force: bool, refused: bool, partial: bool
) -> tuple[str | None, list[str]]:
    """Write a brake's file unless refused files forbid it; its path and what to say."""
    if out is None:
        return None, []
    if refused and not partial:
        return None, [f"{out} was not written because files were refused; --partial writes it"]
    content = text(Path(out).stem)
    read_brake(content, out, materials())
    write_whole(out, lambda p: _fill(p, content), force)
    return str(out), []


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


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

    used, refused = _each(files, use, choices)
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
        written, said = _write_brake(out, lambda _: text, force, bool(refused), partial)
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


def calibrate(
    brake: AnyBrake,
    files: Paths,
    *,
    vacuum: Quantity | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    atmosphere: Quantity | None = None,
    choices: Choices | None = None,
    force: bool = False,
) -> Answer:
    """Scale factor and stiffness of a brake from one or several pulls.

    `vacuum` serves files without a sidecar that states it. With `out` the calibrated brake is
    written. `record` is the Calibration.
    """
    file = brake_at(brake, atmosphere)
    used, refused, odd = _pulls(files, file, vacuum, choices, fit_pull)
    result = fit([(pull, pressure) for _, pull, pressure in used], file.brake)
    traces = [trace for trace, _, _ in used]
    written, said = _write_brake(
        out, lambda name: calibrated_text(file, result, name), force, bool(refused), partial
    )
    errors = {"scale_factor": result.scale_factor_se, "stiffness": result.stiffness_se}
    return Answer(
        values={
            "scale_factor": result.scale_factor,
            "stiffness": result.stiffness,
            "scale_factor_eq8": result.scale_factor_eq8,
            "stiffness_eq9": result.stiffness_eq9,
            "peak_force": result.peak_force,
            "peak_elongation": result.peak_elongation,
            "standard_errors": {**errors, "rests_on": result.errors_rest_on},
            "checks": [
                {"name": c.name, "passed": c.passed, "sentence": c.sentence} for c in result.checks
            ],
            "understood": {t.path: list(t.understood) for t in traces},
            "refused": refused,
            "file": written,
        },
        units={
            "scale_factor": "1",
            "stiffness": "N/m",
            "scale_factor_eq8": "1",
            "stiffness_eq9": "N/m",
            "peak_force": "N",
            "peak_elongation": "m",
        },
        warnings=[
            *file.warnings(without=("scale_factor", "stiffness_measured")),
            *odd,
            *said,
        ],
        refused=refused,
        record=(file, result),
    )


def validate(
    brake: AnyBrake,
    files: Paths,
    *,
    vacuum: Quantity | None = None,
    atmosphere: Quantity | None = None,
    choices: Choices | None = None,
) -> Answer:
    """How far the brake's model lies from measured pulls (identify.metrics says over which window).

    Says so where the brake was calibrated on one of the files. `record` is the Validation.
    """
    file = brake_at(brake, atmosphere)
    used, refused, odd = _pulls(files, file, vacuum, choices, compare)
    result = validate_pulls([(pull, pressure) for _, pull, pressure in used], file.brake)
    warnings = file.warnings() + odd
    same = calibrated_on(file, [t.path for t, _, _ in used])
    if same:
        warnings.append(
            f"{', '.join(same)}: this brake was calibrated on it, which is no test of the model"
        )
    rows = [
        {"path": c.path, "vacuum": c.vacuum, "mape": c.mape, "rmse": c.rmse, "bias": c.bias,
         "points": len(c.elongation), "note": c.note}
        for c in result.curves
    ]  # fmt: skip
    return Answer(
        values={
            "mape": result.mape,
            "mape_sd": result.mape_sd,
            "rmse": result.rmse,
            "files": rows,
            "refused": refused,
        },
        units={"mape": "1", "mape_sd": "1", "rmse": "N"},
        warnings=warnings,
        refused=refused,
        record=(file, result),
    )
