"""`calibrate`: scale factor, stiffness and more from measured pulls, in three depths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at
from layerjam.commands.files import Paths, Progress, pulls, understood, write_brake
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError, UnknownNameError
from layerjam.identify.calibration.influence import Move
from layerjam.identify.calibration.intervals import Interval
from layerjam.identify.calibration.peaks import WINDOW as EXACT_WINDOW
from layerjam.identify.calibration.peaks import Calibration, fit_pull
from layerjam.identify.calibration.peaks import calibrate as fit
from layerjam.identify.calibration.whole_curves import WINDOW as CURVES_WINDOW
from layerjam.identify.calibration.whole_curves import CurvesCalibration, calibrate_curves
from layerjam.identify.checks import Check
from layerjam.identify.curves import curves_of, usable
from layerjam.identify.provenance import calibrated_text
from layerjam.identify.pull.features import PullFeatures
from layerjam.measure.options import ReadingOptions
from layerjam.measure.trace import Trace

if TYPE_CHECKING:
    from layerjam.commands.bayesian import BayesCalibration

DEPTHS = ("exact", "curves", "bayesian")
UNITS = {
    "scale_factor": "1",
    "stiffness": "N/m",
    "scale_factor_eq8": "1",
    "stiffness_eq9": "N/m",
    "peak_force": "N",
    "peak_elongation": "m",
    "enclosure_factor": "1",
    "pressure_exponent": "1",
    "speed_slope": "1",
    "reference_pressure": "Pa",
    "reference_speed": "m/s",
}
DEEPER = tuple(UNITS)[6:]
"""Keys that depth "exact" leaves null."""
SLEEVE = ("enclosure.modulus", "film.friction_on_silicone")
Used = Sequence[tuple[Trace, PullFeatures, float]]


def calibrate(
    brake: AnyBrake,
    files: Paths,
    *,
    depth: str = "exact",
    free: Sequence[str] = (),
    vacuum: Quantity | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    atmosphere: Quantity | None = None,
    choices: ReadingOptions | None = None,
    draws: int = 1000,
    chains: int = 2,
    seed: int = 1,
    progress: Progress | None = None,
    force: bool = False,
) -> Answer:
    """Scale factor and stiffness of a brake from one or several pulls.

    `depth` "exact" takes them from each pull's peak and slope; "curves" fits whole curves, all at
    once, and the sleeve's factor with them, and what `free` names: "pressure_exponent", "speed",
    "force_offset"; "bayesian" samples the same parameters (`draws` of each of `chains`, from
    `seed`). `vacuum` serves files without a sidecar that states it. With `out` the calibrated brake
    is written. `progress` is told (what, share done). `record` is (BrakeFile, the fit).
    """
    return calibrated(
        brake, files, depth, free, vacuum, out, partial, atmosphere, choices,
        (draws, chains, seed), progress, force,
    )[0]  # fmt: skip


def calibrated(
    brake: AnyBrake,
    files: Paths,
    depth: str,
    free: Sequence[str],
    vacuum: Quantity | None,
    out: str | Path | None,
    partial: bool,
    atmosphere: Quantity | None,
    choices: ReadingOptions | None,
    sampling: tuple[int, int, int],
    progress: Progress | None,
    force: bool,
) -> tuple[Answer, list[Trace]]:
    """`calibrate`'s answer and the traces that were used."""
    if depth not in DEPTHS:
        raise UnknownNameError("depth", depth, DEPTHS)
    if free and depth != "curves":
        raise FitError(f"free: {', '.join(free)} can be fitted at depth 'curves' only")
    file = brake_at(brake, atmosphere)
    test = fit_pull if depth == "exact" else _usable
    used, refused, odd = pulls(files, file, vacuum, choices, test, progress)
    tell = progress or (lambda what, share: None)
    result = _fit(depth, used, file, free, sampling, tell)
    window = EXACT_WINDOW if depth == "exact" else CURVES_WINDOW

    def text(name: str) -> str:
        return calibrated_text(
            file, name, result.sources(file), depth=depth, window=window, checks=result.checks,
            paths=result.files,
        )  # fmt: skip

    written, said = write_brake(out, text, force, bool(refused), partial)
    fitted = ("scale_factor", "stiffness_measured", *([] if depth == "exact" else SLEEVE))
    answer = Answer(
        values={
            "depth": depth,
            **_values(result, used, file),
            "understood": understood(t for t, _, _ in used),
            "refused": refused,
            "file": written,
        },
        units=UNITS,
        warnings=[*file.warnings(without=fitted), *odd, *said],
        refused=refused,
        record=(file, result),
    )
    return answer, [t for t, _, _ in used]


def _usable(pull: PullFeatures, vacuum: float, brake: object) -> None:
    usable(pull, vacuum)


def _fit(
    depth: str,
    used: Used,
    file: BrakeFile,
    free: Sequence[str],
    sampling: tuple[int, int, int],
    tell: Progress,
) -> Calibration | CurvesCalibration | BayesCalibration:
    if depth == "exact":
        return fit([(pull, pressure) for _, pull, pressure in used], file.brake)
    curves = curves_of(used)
    if depth == "curves":
        return calibrate_curves(curves, file.brake, free, tell)
    from layerjam.commands.bayesian import calibrate_bayesian

    return calibrate_bayesian(curves, file.brake, sampling, tell)


def _values(
    result: Calibration | CurvesCalibration | BayesCalibration, used: Used, file: BrakeFile
) -> dict[str, Any]:
    """All keys of the contract; null for what does not apply at this depth."""
    exact = result if isinstance(result, Calibration) else _peaks(used, file)
    shared = dict.fromkeys(UNITS, None) | {
        "scale_factor": result.scale_factor,
        "stiffness": result.stiffness,
        "scale_factor_eq8": exact and exact.scale_factor_eq8,
        "stiffness_eq9": exact and exact.stiffness_eq9,
        "peak_force": exact and exact.peak_force,
        "peak_elongation": exact and exact.peak_elongation,
    }
    if isinstance(result, Calibration):
        errors = {"scale_factor": result.scale_factor_se, "stiffness": result.stiffness_se}
    else:
        shared |= result.values
        errors = {name: result.standard_error(name) for name in result.values}
    more: dict[str, Any] = dict.fromkeys(
        ("bootstrap", "leave_one_out", "identifiability", "posterior")
    )
    if isinstance(result, Calibration | CurvesCalibration):
        more["bootstrap"] = _intervals(result.bootstrap)
        more["leave_one_out"] = {name: _moves(m) for name, m in result.leave_one_out.items()}
    if isinstance(result, CurvesCalibration):
        shared["reference_pressure"] = result.reference_pressure
        shared["reference_speed"] = result.reference_speed
        found = result.identifiability
        more["identifiability"] = {
            "condition_number": found.condition_number,
            "least_apart": None if found.pair is None else list(found.pair),
            "correlation": found.correlation,
            "errors_from_noise": dict(found.errors),
        }
    if not isinstance(result, Calibration | CurvesCalibration):
        more["posterior"] = result.posterior
    return {
        **shared,
        "standard_errors": {**errors, "rests_on": result.errors_rest_on},
        "intervals": _intervals(result.intervals),
        **more,
        "checks": [_check(c) for c in result.checks],
    }


def _peaks(used: Used, file: BrakeFile) -> Calibration | None:
    """The exact form beside a deeper one, from the pulls that have a peak; None if none has."""
    fine = []
    for _, pull, pressure in used:
        try:
            fit_pull(pull, pressure, file.brake)
        except FitError:
            continue
        fine.append((pull, pressure))
    return fit(fine, file.brake) if fine else None


def _intervals(found: Mapping[str, Interval | None]) -> dict[str, dict[str, Any] | None]:
    return {name: None if one is None else asdict(one) for name, one in found.items()}


def _moves(found: Sequence[Move]) -> dict[str, Any]:
    """The file, and the condition, without which a value moves most, and every move."""
    files = [m for m in found if not m.condition]
    rest = [m for m in found if m.condition]
    return {
        "most_influential": files[0].left_out if files else None,
        "files": {m.left_out: m.by for m in files},
        "conditions": {m.left_out: m.by for m in rest},
    }


def _check(check: Check) -> dict[str, Any]:
    return {"name": check.name, "passed": check.passed, "sentence": check.sentence}
