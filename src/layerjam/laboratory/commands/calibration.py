"""`calibrate`: scale factor, stiffness and more from measured pulls, by one of three methods."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial as bound
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.brake.commands.arguments import (
    Accept,
    Atmosphere,
    BrakeInput,
    OutBrake,
    Overwrite,
    Tare,
)
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.spread import rate_enclosure
from layerjam.brake.simulate.quantities import SEED
from layerjam.core.command.declare import Help, Progress, command, options
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.drawing.folder import to_json
from layerjam.core.errors import FitError, Notice, count_text
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.files import FromFiles, describe_readings, read_pulls, write_brake
from layerjam.laboratory.commands.left_out import (
    LeftOut,
    exclusion_lines,
    exclusion_row,
    name_automatic,
)
from layerjam.laboratory.commands.pull_by_pull import (
    condition_notices,
    format_pull_table,
    make_pull_rows,
)
from layerjam.laboratory.commands.reading import FileOptions, Files, FileVacuum, Partial
from layerjam.laboratory.measure.trace import Trace

if TYPE_CHECKING:
    from layerjam.laboratory.identify.calibration.result import Calibration
    from layerjam.laboratory.identify.pull.features import PullFeatures


PRECISION = QuantitySpec(
    "1", "half-width of a 95 % interval, relative to the value", lo=1e-5, hi=1, example="1%"
)
ALIKE = 1.001
"""Largest ratio of the widest to the narrowest interval after one more pull, at which all
conditions count as equivalent.
"""
Within = Annotated[
    float | None,
    PRECISION,
    Help("Print how many more pulls would narrow each interval to ± this value."),
]


def predict_more_pulls(
    calibration: "Calibration", precision: float | None
) -> dict[str, Any] | None:
    """Return {value: (half-width now, after one more pull by condition, pulls needed)}.

    Returns None if not requested; a value is None if it has no interval yet. Widths are relative to
    the value.
    """
    if precision is None:
        return None
    rows: dict[str, Any] = {}
    for name, plan in (calibration.further or {}).items():
        rows[name] = plan and {
            "within": precision,
            "half_width": float(plan.half_width()),
            "after_one": plan.after_one(),
            **asdict(plan.required_pulls(precision)),
        }
    return rows


def format_more_pulls(further: Mapping[str, Any]) -> Iterator[str]:
    """Yield, for each value, its current interval and the number of pulls needed."""
    if further:
        yield ""
    for name, row in further.items():
        value = name.replace("_", " ")
        if row is None:
            yield f"{value}: the pulls so far determine no interval; repeat one of them first"
            continue
        yield f"{value} is known to ± {row['half_width']:.2%}; {_describe_pulls_needed(row)}"


def _describe_pulls_needed(row: Mapping[str, Any]) -> str:
    width, condition, widths = f"± {row['within']:.2%}", row["condition"], row["after_one"]
    if row["likely"] == 0:
        return f"already within {width}"
    if row["likely"] is None:
        return f"even 1000 further pulls would not narrow it to {width}"
    is_any_condition = max(widths.values()) <= ALIKE * widths[condition]
    place = "any of these vacuums" if is_any_condition and len(widths) > 1 else condition
    forecast = f"one more pull at {place}: ± {widths[condition]:.2%}"
    sure_count = "more than 1000" if row["sure"] is None else f"{row['sure']}"
    return (
        f"{forecast}; {row['likely']} more are expected to reach {width} at the same "
        f"scatter, {sure_count} to reach it in four of five cases"
    )


DRAWS = QuantitySpec("1", "draws per chain", lo=100, hi=100_000, whole=True)
CHAINS = QuantitySpec("1", "chains", lo=1, hi=64, whole=True)
SHEETS = ("scale_factor", "stiffness_measured")
ENCLOSURE = ("enclosure.modulus", "film.friction_on_silicone")
TABLES = ("intervals", "bootstrap", "leave_one_out", "identifiability", "covariance")
"""Keys of a calibration that contain records."""
Used = tuple["Trace", "PullFeatures", float]
"""A pull prepared for the fit: record, features and vacuum [Pa]."""
Depth = Annotated[
    Literal["exact", "curves", "bayesian"],
    Help("Method: fit each pull's peak and slope, fit whole curves, or sample a posterior."),
]


@options
class Sampling:
    """Settings for sampling the posterior."""

    draws: Annotated[int, DRAWS, Help("Draws per chain (depth bayesian).")] = 1000
    chains: Annotated[int, CHAINS, Help("Number of chains (depth bayesian).")] = 2
    seed: Annotated[int, SEED, Help("Random seed for the draws (depth bayesian).")] = 1


@result
class BrakeCalibration(FromFiles, Judged):
    """A brake calibrated on pulls; `record` is (BrakeFile, the fit).

    Numbers that the chosen depth does not determine are None. `traces` are the pulls that were
    used, thinned.
    """

    record: "tuple[BrakeFile, Calibration]"
    depth: str = fact("fitting method", shown=lambda depth: "" if depth == "exact" else depth)
    scale_factor: float = number("1", "calibration factor on the sheets' friction")
    stiffness: float = number("N/m", "stiffness of the brake and rig")
    scale_factor_eq8: float | None = number(
        "1", ("scale factor by the paper's eq. 8, from the peaks")
    )
    stiffness_eq9: float | None = number("N/m", "stiffness by the paper's eq. 9, from the peaks")
    peak_force: float | None = number("N", "peak force, mean over the pulls")
    peak_elongation: float | None = number("m", "elongation at the peak, mean over the pulls")
    enclosure_factor: float | None = number("1", "factor on the enclosure's force")
    pressure_exponent: float | None = number("1", "pressure exponent of friction")
    speed_slope: float | None = number("1", "change in friction with speed")
    reference_pressure: float | None = number("Pa", "reference pressure for that exponent")
    reference_speed: float | None = number("m/s", "reference speed for that change")
    standard_errors: Mapping[str, Any] = fact("standard errors and their basis", listed=False)
    intervals: Mapping[str, Any] = fact("95 % intervals", listed=False)
    not_included: Sequence[str] = fact(
        "instruments whose errors are not stated, and therefore not in the intervals",
        listed=False,
    )
    covariance: Mapping[str, Any] = fact(
        "covariance of each pair of values, in SI units; empty if no scatter is known", listed=False
    )
    bootstrap: Mapping[str, Any] | None = fact("intervals from resampled repeats", listed=False)
    leave_one_out: Mapping[str, Any] | None = fact("influence of each file", listed=False)
    identifiability: Mapping[str, Any] | None = fact("conditioning of the fit", listed=False)
    posterior: Mapping[str, Any] | None = fact("samples of the posterior", listed=False)
    pulls: Sequence[Mapping[str, Any]] = fact(
        "each pull, and how it differs from the others", listed=False
    )
    more_pulls: Mapping[str, Any] | None = fact(
        "effect of further pulls on each interval", listed=False
    )
    excluded: Sequence[Mapping[str, Any]] = fact(
        "files left out, with reasons; `automatic` if no user named them", listed=False
    )
    understood: Mapping[str, Any]
    made_from: Mapping[str, Any] = fact("SHA-256 of the brake and files", listed=False)
    refused: Mapping[str, str]
    file: str | None
    traces: Sequence[Trace] = ()

    def rows(self) -> list[tuple[str, str]]:
        """Yield the fitted numbers with their intervals, and the pulls left out automatically."""
        names_out = name_automatic(self.excluded)
        ending = f", without {names_out} (left out automatically)" if names_out else ""
        values = {
            name.replace("_", " "): self._format_number(name) + ending for name in self.intervals
        }
        return [(name, values.get(name, text)) for name, text in super().rows()]

    def _format_number(self, name: str) -> str:
        """Return a number with its interval or, if it has none, with its standard error."""
        unit, interval, error = self.units[name], self.intervals[name], self.standard_errors[name]

        number = getattr(self, name)

        def add_unit(value: float) -> str:
            return f"{value:.4f}" if unit == "1" else show(value, unit, like=number)

        value = add_unit(number)
        if interval is not None:
            return f"{value} (95 %: {add_unit(interval['low'])} to {add_unit(interval['high'])})"
        return value if error is None else f"{value} ± {show(error, unit, 2)} standard error"

    def lines(self) -> Iterator[str]:
        """Yield the basis of the errors, the most influential file, and the checks."""
        if self.not_included:
            yield f"not included: {', '.join(self.not_included)} (common to all pulls)"
        yield from ("", f"standard errors are based on {self.standard_errors['rests_on']}")
        found = (self.leave_one_out or {}).get("scale_factor") or {}
        file_name = found.get("most_influential")
        if file_name:
            change = found["files"][file_name]
            yield f"excluding {file_name} changes the scale factor most, by {change:+.2g}"
        yield from format_pull_table(self.pulls)
        yield from format_more_pulls(self.more_pulls or {})
        yield from exclusion_lines(self.excluded)

    def draw(self) -> Figure:
        """Return the figure of the pulls, the fitted law and the residuals."""
        from layerjam.laboratory.figures import calibration_figure

        file, fit = self.record
        return calibration_figure.draw_calibration(file, fit, any(t.synthetic for t in self.traces))


@command("test")
def calibrate(
    brake: BrakeInput,
    files: Files,
    *,
    depth: Depth = "exact",
    free: Annotated[
        Sequence[str],
        Help("Also fit these (depth curves).", metavar="pressure_exponent|speed|force_offset"),
    ] = (),
    vacuum: FileVacuum = None,
    out: OutBrake | None = None,
    partial: Partial = False,
    atmosphere: Atmosphere = None,
    left_out: LeftOut = LeftOut(),
    within: Within = None,
    tare: Tare = False,
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    sampling: Sampling = Sampling(),
    progress: Progress | None = None,
    overwrite: Overwrite = False,
) -> BrakeCalibration:
    """Calibrate the scale factor and stiffness of a brake from one or more pulls.

    `files` are one or more paths or traces. `depth` "exact" uses the peak and slope of each pull;
    "curves" fits all whole curves at once, including the enclosure's factor and any quantities in
    `free`: "pressure_exponent", "speed", "force_offset"; "bayesian" samples the same parameters
    (`draws` of each of `chains`, from `seed`). `vacuum` applies to files whose sidecar does not
    state it. With `out` the calibrated brake is written. `exclude` leaves out files or specimens,
    each with its reason in `because` (in Python also {file: reason}). Both are stored in the result
    and in the brake. `within` requests how many more pulls, at which conditions, would narrow each
    interval to ± this fraction of its value. `tare` subtracts the force before the rise. If a check
    fails, nothing is written; `accept` accepts failed checks by name, {check: reason}.
    """
    from layerjam.laboratory.identify.calibration.common import list_missing
    from layerjam.laboratory.identify.provenance import format_brake, list_inputs

    free = _select_free_parameters(free, depth)
    files, specimens_out, exclusions = left_out.split_excluded(files, options)
    used, refusals, file_warnings = read_pulls(
        files, brake, vacuum, options, _find_test(depth), progress, specimens_out, tare
    )
    used, outliers = _exclude_outliers(used, brake.brake)
    exclusions += outliers
    fit = _fit_brake(depth, used, rate_enclosure(brake), free, sampling, progress)
    fit, traces = _name_outliers(fit, outliers), [t for t, _, _ in used]
    source = list_inputs(brake, traces)
    verdict = judge(fit.checks, accept, list(fit.sources), out, files=len(used))
    facts = {"exclusions": exclusions, "files": source["files"], "verdict": verdict}
    text = bound(format_brake, brake, fit, depth, **facts)
    path, notices = write_brake(out, text, overwrite, bool(refusals), partial, verdict)
    return BrakeCalibration.create(
        fit.values,
        fit,
        verdict,
        **{name: to_json(getattr(fit, name)) for name in TABLES},
        depth=depth,
        standard_errors={**fit.standard_errors, "rests_on": fit.errors_rest_on},
        not_included=list_missing(fit.contributions),
        pulls=make_pull_rows(fit.pulls),
        more_pulls=predict_more_pulls(fit, within),
        understood=describe_readings(traces),
        made_from=source,
        excluded=exclusions,
        refused=refusals,
        file=path,
        warnings=[*_calibration_notices(brake, fit, depth), *file_warnings, *notices],
        record=(brake, fit),
        traces=traces,
    )


def _exclude_outliers(
    used: Sequence[Used], brake: Brake
) -> tuple[list[Used], list[dict[str, Any]]]:
    """Return the pulls to fit, and rows that list the excluded ones.

    A pull is excluded if no plausible scatter explains its scale factor or its stiffness.
    """
    from layerjam.laboratory.identify.calibration.gross import find_gross_pulls

    reasons = find_gross_pulls([(features, vacuum) for _, features, vacuum in used], brake)
    inliers = [pull for index, pull in enumerate(used) if index not in reasons]
    return inliers, [exclusion_row(used[index][0], reason) for index, reason in reasons.items()]


def _name_outliers(fit: "Calibration", outliers: Sequence[Mapping[str, Any]]) -> "Calibration":
    """Return the fit, whose basis of errors names the pulls that were left out automatically."""
    names = name_automatic(outliers)
    if not names:
        return fit
    return replace(fit, errors_rest_on=f"{fit.errors_rest_on}; left out automatically: {names}")


def _find_test(depth: str) -> "Callable[[PullFeatures, float, Brake], object]":
    """Return the function that raises FitError for a pull that the method cannot use."""
    from layerjam.laboratory.identify.calibration.peaks import fit_pull
    from layerjam.laboratory.identify.curves import require_usable_pull

    if depth == "exact":
        return fit_pull
    return lambda pull, pressure, _brake: require_usable_pull(pull, pressure)


def _select_free_parameters(free: Sequence[str] | str, depth: str) -> list[str]:
    """Return the additional parameters to fit, without duplicates.

    Raises FitError for a depth other than curves.
    """
    names = list(dict.fromkeys([free] if isinstance(free, str) else free))
    if names and depth != "curves":
        raise FitError(f"free: {', '.join(names)} can be fitted only at depth 'curves'")
    return names


def _calibration_notices(brake: BrakeFile, calibration: "Calibration", depth: str) -> Iterator[str]:
    """Yield notices about the brake's other numbers and about single pulls."""
    yield from brake.warnings(without=SHEETS if depth == "exact" else (*SHEETS, *ENCLOSURE))
    yield from _slope_notices(calibration)
    yield from condition_notices(calibration.pulls)


def _slope_notices(calibration: "Calibration") -> Iterator[Notice]:
    """Yield notices about pulls used only for the scale factor, and about a speed-dependent fit."""
    from layerjam.laboratory.identify.calibration.speed_law import speed_notices

    yield from speed_notices(calibration)
    for entry in calibration.fits if calibration.fit is None else ():
        if entry.stiffness is None:
            samples = count_text(entry.pull.rise_samples, "sample")
            yield Notice(
                f"{Path(entry.pull.path).name}: only {samples} on its rise, too few to determine "
                "a stiffness; it is used only for the scale factor (pull more slowly, or "
                "sample faster)",
                "no-slope",
            )


def _fit_brake(
    depth: str,
    used: Sequence[Used],
    brake: Brake,
    free: Sequence[str],
    sampling: Sampling,
    progress: Progress | None,
) -> "Calibration":
    from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks
    from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
    from layerjam.laboratory.identify.curves import make_curves

    curves, tell = make_curves(used), progress or (lambda _what, _share: None)
    if depth == "exact":
        return calibrate_peaks(curves, brake)
    if depth == "curves":
        return calibrate_curves(curves, brake, free, tell)
    from layerjam.brake.mechanics.speed_effects import depends_on_speed
    from layerjam.laboratory.identify.bayes.fit import calibrate_bayesian

    if depends_on_speed(brake):
        raise FitError(
            "speed_law: depth 'bayesian' does not support speed-dependent friction; use "
            "'curves', or the brake without that table"
        )
    settings = (sampling.draws, sampling.chains, sampling.seed)
    return calibrate_bayesian(curves, brake, settings, tell)
