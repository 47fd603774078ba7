"""`friction`, `calibrate` and `validate`: what the lab says of a brake."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from layerjam.cli import options as opt
from layerjam.cli.output import Answer
from layerjam.errors import FileError, FitError, LayerjamError, QuantityError
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.device.brake import Brake
    from layerjam.identify.trace import Trace

T = TypeVar("T")
Partial = Annotated[
    bool, typer.Option("--partial", help="Write the brake even if some files were refused.")
]
FileVacuum = Annotated[
    str | None, typer.Option(metavar="Q", help="Vacuum of files without a sidecar that says it.")
]


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command("friction")(friction)
    app.command("calibrate")(calibrate)
    app.command("validate")(validate)


def _each(files: Sequence[Path], use: Callable[[Trace], T]) -> tuple[list[T], dict[str, str]]:
    """`use` of every file that can be used, and {file: why} of those that cannot.

    A single file, or none that can be used, is an error of its own.
    """
    from layerjam.identify.readers import read_trace

    done: list[T] = []
    refused: dict[str, str] = {}
    for path in files:
        try:
            done.append(use(read_trace(path)))
        except LayerjamError as error:
            refused[str(path)] = str(error).removeprefix(f"{path}: ")
    if not done:
        first = next(iter(refused.items()))
        more = f" ({len(refused) - 1} more files were refused too)" if len(refused) > 1 else ""
        raise FileError(first[0], first[1] + more)
    return done, refused


def _refusals(refused: dict[str, str]) -> list[str]:
    if not refused:
        return []
    return ["", "refused:"] + [f"  {path}: {why}" for path, why in refused.items()]


def _vacuum(trace: Trace, given: str | None, brake: Brake) -> float:
    if trace.facts.vacuum is not None:
        if trace.facts.vacuum > brake.site.atmosphere:
            raise QuantityError(
                f"vacuum of its sidecar, {show(trace.facts.vacuum, 'Pa')}, is more than the "
                f"atmosphere, {show(brake.site.atmosphere, 'Pa')}"
            )
        return trace.facts.vacuum
    if given is None:
        raise FitError(
            f"nothing says at which vacuum it was pulled; give --vacuum, or write "
            f"{Path(trace.path).name}.toml beside it with a line such as vacuum = \"94.5 kPa\""
        )
    return opt.read_vacuum(given, brake)


def _write_brake(
    out: Path, text: str, force: bool, refused: dict[str, str], partial: bool
) -> str | None:
    """Write the brake's file; None where refused files forbid it."""
    from layerjam.device.file import read_brake
    from layerjam.device.load import materials, write_whole

    if refused and not partial:
        return None
    read_brake(text, out, materials())
    write_whole(out, lambda p: _fill(p, text), force)
    return str(out)


def _fill(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _not_written(out: Path | None, written: str | None) -> list[str]:
    if out is None or written is not None:
        return []
    return [f"{out} was not written because files were refused; --partial writes it all the same"]


def friction(
    files: opt.Files,
    normal_force: Annotated[
        str | None, typer.Option(metavar="Q", help="Force pressing the films together, 2.45N.")
    ] = None,
    start: Annotated[
        str, typer.Option("--from", metavar="Q", help="Travel where the kinetic window starts.")
    ] = "40 mm",
    end: Annotated[
        str, typer.Option("--to", metavar="Q", help="Travel where the kinetic window ends.")
    ] = "100 mm",
    brake: Annotated[
        str | None, typer.Option(metavar="BRAKE", help="Brake to write the friction into.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="File for that brake.")
    ] = None,
    partial: Partial = False,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Static and kinetic friction from friction tests, as the paper reduces them."""
    from layerjam.device.load import load
    from layerjam.identify.friction_test import reduce_friction, reduce_repeat, with_friction

    opt.check_figure(figure, force)
    opt.check_target(out, force)
    if (brake is None) != (out is None):
        raise QuantityError("--brake and --out: give both to write a brake, or neither")
    target = load(brake) if brake else None
    window = opt.SLIP.read(start, "--from"), opt.TRAVEL.read(end, "--to")
    if window[0] >= window[1]:
        raise QuantityError(f"--from {start} is not below --to {end}")
    given = opt.NORMAL_FORCE.read(normal_force, "--normal-force") if normal_force else None

    def use(trace: Trace) -> tuple[Trace, float]:
        load_ = given if given is not None else trace.facts.normal_force
        if load_ is None:
            raise FitError("nothing says how hard the films were pressed; give --normal-force")
        reduce_repeat(trace, load_, window)
        return trace, load_

    used, refused = _each(files, use)
    loads = {load_ for _, load_ in used}
    if len(loads) > 1:
        raise FitError(f"the files' normal forces differ: {', '.join(show(v, 'N') for v in loads)}")
    result = reduce_friction([t for t, _ in used], loads.pop(), window)
    warnings = list(result.warnings)
    written = None
    if target is not None and out is not None:
        text, more = with_friction(target, result, out.stem)
        written = _write_brake(out, text, force, refused, partial)
        warnings += more if written else _not_written(out, written)
    if figure:
        from layerjam.report import figures

        figures.save(figures.friction([t for t, _ in used], result), figure, force)
    values: dict[str, Any] = {
        "static": result.static,
        "kinetic": result.kinetic,
        "static_sd": result.static_sd,
        "kinetic_sd": result.kinetic_sd,
        "repeats": len(result.repeats),
        "understood": {t.path: list(t.understood) for t, _ in used},
        "refused": refused,
        "file": written,
    }
    Answer(
        values=values,
        units=dict.fromkeys(("static", "kinetic", "static_sd", "kinetic_sd", "repeats"), "1"),
        warnings=warnings,
        lines=_refusals(refused),
        hidden=("understood", "refused"),
    ).print(as_json)
    return 3 if refused else 0


def calibrate(
    brake: opt.BrakeName,
    files: opt.Files,
    vacuum: FileVacuum = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Write the calibrated brake.")
    ] = None,
    partial: Partial = False,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """Scale factor and stiffness of a brake from one or several pulls."""
    opt.check_figure(figure, force)
    opt.check_target(out, force)
    file = opt.brake_at(brake, atmosphere)
    if vacuum is not None:
        opt.read_vacuum(vacuum, file.brake)
    opt.engine()
    from layerjam.identify.fit import calibrate as fit
    from layerjam.identify.fit import calibrated_text, fit_pull
    from layerjam.identify.pull import pull_features

    def use(trace: Trace) -> tuple[Trace, Any, float]:
        pressure = _vacuum(trace, vacuum, file.brake)
        pull = pull_features(trace)
        fit_pull(pull, pressure, file.brake)
        return trace, pull, pressure

    used, refused = _each(files, use)
    result = fit([(pull, pressure) for _, pull, pressure in used], file.brake)
    traces = [trace for trace, _, _ in used]
    warnings = file.warnings() + [w for t in traces for w in t.warnings]
    written = None
    if out is not None:
        text = calibrated_text(file, result, out.stem)
        written = _write_brake(out, text, force, refused, partial)
        warnings += _not_written(out, written)
    if figure:
        from layerjam.report import figures

        figures.save(figures.calibration(file, result), figure, force)
    errors = {"scale_factor": result.scale_factor_se, "stiffness": result.stiffness_se}
    values: dict[str, Any] = {
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
    }
    lines = ["", "standard errors (from " + result.errors_rest_on + "):"]
    lines += [f"  scale factor {_error(errors['scale_factor'], '1')}"]
    lines += [f"  stiffness {_error(errors['stiffness'], 'N/m')}", "", "checks"]
    lines += [f"  {'ok  ' if c.passed else 'LOOK'} {c.name}: {c.sentence}" for c in result.checks]
    Answer(
        values=values,
        units={
            "scale_factor": "1", "stiffness": "N/m", "scale_factor_eq8": "1",
            "stiffness_eq9": "N/m", "peak_force": "N", "peak_elongation": "m",
        },  # fmt: skip
        warnings=warnings,
        lines=lines + _refusals(refused),
        hidden=("standard_errors", "checks", "understood", "refused"),
    ).print(as_json)
    return 3 if refused else 0


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.2%}"


def _error(value: float | None, unit: str) -> str:
    return "not known" if value is None else show(value, unit, 2)


def validate(
    brake: opt.BrakeName,
    files: opt.Files,
    vacuum: FileVacuum = None,
    atmosphere: opt.Atmosphere = None,
    figure: opt.Figure = None,
    as_json: opt.AsJson = False,
    force: opt.Force = False,
) -> int:
    """How far the brake's model lies from measured pulls."""
    opt.check_figure(figure, force)
    file = opt.brake_at(brake, atmosphere)
    if vacuum is not None:
        opt.read_vacuum(vacuum, file.brake)
    opt.engine()
    from layerjam.identify.metrics import compare, validate_pulls
    from layerjam.identify.provenance import calibrated_on
    from layerjam.identify.pull import pull_features

    def use(trace: Trace) -> tuple[Trace, Any, float]:
        pressure = _vacuum(trace, vacuum, file.brake)
        pull = pull_features(trace)
        compare(pull, pressure, file.brake)
        return trace, pull, pressure

    used, refused = _each(files, use)
    result = validate_pulls([(pull, pressure) for _, pull, pressure in used], file.brake)
    warnings = file.warnings() + [w for t, _, _ in used for w in t.warnings]
    same = calibrated_on(file, [t.path for t, _, _ in used])
    if same:
        warnings.append(
            f"{', '.join(same)}: this brake was calibrated on it, which is no test of the model"
        )
    if figure:
        from layerjam.report import figures

        figures.save(figures.validation(file, result), figure, force)
    rows = [
        {"path": c.path, "vacuum": c.vacuum, "mape": c.mape, "rmse": c.rmse, "bias": c.bias,
         "points": len(c.elongation), "note": c.note}
        for c in result.curves
    ]  # fmt: skip
    lines = ["", "MAPE      RMSE        vacuum      file"]
    lines += [
        f"{c.mape:<8.2%}  {show(c.rmse, 'N', 3):<10}  {show(c.vacuum, 'Pa'):<10}  {c.path}"
        + (f" ({c.note})" if c.note else "")
        for c in result.curves
    ]
    Answer(
        values={
            "mape": result.mape, "mape_sd": result.mape_sd, "rmse": result.rmse, "files": rows,
            "refused": refused,
        },  # fmt: skip
        shown={"mape": _percent(result.mape), "mape_sd": _percent(result.mape_sd)},
        units={"mape": "1", "mape_sd": "1", "rmse": "N"},
        warnings=warnings,
        lines=lines + _refusals(refused),
        hidden=("files", "refused"),
    ).print(as_json)
    return 3 if refused else 0
