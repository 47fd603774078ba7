"""`validate`: errors of the model against measured pulls."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from layerjam.brake.commands.arguments import Accept, Atmosphere, BrakeInput, Tare
from layerjam.core.command.declare import Progress, command
from layerjam.core.command.results import Figure, Judged, fact, number, result
from layerjam.core.errors import FitError, Notice
from layerjam.core.units import show
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.files import describe_readings, read_pulls
from layerjam.laboratory.commands.left_out import LeftOut, exclusion_lines
from layerjam.laboratory.commands.pull_by_pull import (
    condition_notices,
    format_pull_table,
    make_pull_rows,
)
from layerjam.laboratory.commands.reading import FileOptions, Files, FileVacuum
from layerjam.laboratory.measure.trace import Trace

if TYPE_CHECKING:
    from layerjam.brake.device.brake_file import BrakeFile
    from layerjam.laboratory.identify.validation.metrics import Validation


def _format_percent(part: float) -> str:
    return f"{part:.2%}"


@result
class ModelErrors(Judged):
    """Errors of the model relative to measured pulls; `record` is (BrakeFile, Validation).

    `before` is the Validation of the brake before calibration, None if there is nothing to
    compare; `traces` are the pulls that were used, thinned.
    """

    record: "tuple[BrakeFile, Validation]"
    mape: float = number("1", "relative mean absolute error of the force", shown=_format_percent)
    mape_sd: float | None = number("1", "SD between the pulls", shown=_format_percent)
    mape_conditions: float = number("1", "mean over the conditions", listed=False)
    mape_conditions_sd: float | None = number("1", "SD between the conditions", listed=False)
    rmse: float = number("N", "root mean square error")
    bias: float = number("N", "mean of model minus measured force")
    r_squared: float | None = number(
        "1", "fraction of the variance explained", shown="{:.4f}".format
    )
    scatter: Mapping[str, Any] | None = fact("fraction of the error due to scatter", listed=False)
    conditions: Sequence[Mapping[str, Any]] = fact("each vacuum and speed", listed=False)
    uncalibrated: Mapping[str, Any] | None = fact(
        "the same with a scale factor of 1 and the sheets' own stiffness", listed=False
    )
    pulls: Sequence[Mapping[str, Any]] = fact(
        "each pull, and how it differs from the others", listed=False
    )
    excluded: Sequence[Mapping[str, Any]] = fact(
        "files left out, with reasons; `automatic` if no user named them", listed=False
    )
    files: Sequence[Mapping[str, Any]] = fact("each pull", listed=False)
    understood: Mapping[str, Any] = fact("how each file was read", listed=False)
    refused: Mapping[str, str] = fact("files not used, with reasons", listed=False)
    before: Any = None
    calibrated_on: Sequence[str] = ()
    """Paths of the pulls that were also used to calibrate the brake."""
    traces: Sequence[Trace] = ()

    def lines(self) -> Iterator[str]:
        """Yield tables per file and per condition, and the fraction of error due to scatter."""
        yield from ("", "MAPE    RMSE      vacuum     file")
        for row in self.files:
            note = f" ({row['note']})" if row["note"] else ""
            yield (
                f"{row['mape']:<6.2%}  {show(row['rmse'], 'N', 3):<8}  "
                f"{show(row['vacuum'], 'Pa'):<9}  {row['path']}{note}"
            )
        yield from ("", "vacuum     speed      pulls  MAPE    before calibration  due to scatter")
        before = self.uncalibrated
        for index, row in enumerate(self.conditions):
            mape_before = _format_percent(before["conditions"][index]["mape"]) if before else "-"
            speed = "-" if row["speed"] is None else show(row["speed"], "m/s", 3)
            yield (
                f"{show(row['vacuum'], 'Pa'):<9}  {speed:<9}  {row['repeats']:<5}  "
                f"{row['mape']:<6.2%}  {mape_before:<18}  {_format_share(row['scatter'])}"
            )
        if before:
            yield from ("", f"before calibration: MAPE {before['mape']:.2%}")
        if self.scatter:
            yield _describe_scatter(self.scatter)
        yield from format_pull_table(self.pulls)
        yield from exclusion_lines(self.excluded)

    def draw(self) -> Figure:
        """Return the figure of measured and predicted curves, and the residuals."""
        from layerjam.laboratory.figures import pull_figures

        file, validation = self.record
        return pull_figures.draw_validation(file, validation, any(t.synthetic for t in self.traces))


def _format_share(scatter: Mapping[str, Any] | None) -> str:
    if scatter is None or scatter["share"] is None:
        return "-"
    return "all of it" if scatter["model_mse"] <= 0 else f"{scatter['share']:.0%}"


def _describe_scatter(scatter: Mapping[str, Any]) -> str:
    if scatter["share"] is None:
        return "the model matches every pull exactly"
    if scatter["model_mse"] <= 0:
        return "the model error is not distinguishable from zero: the repeats scatter as much"
    return (
        f"{scatter['share']:.0%} of the mean squared error is scatter between repeats, "
        "which no model can remove"
    )


@command("test")
def validate(
    brake: BrakeInput,
    files: Files,
    *,
    vacuum: FileVacuum = None,
    atmosphere: Atmosphere = None,
    left_out: LeftOut = LeftOut(),
    tare: Tare = False,
    accept: Accept = None,
    options: FileOptions = FileOptions(),
    progress: Progress | None = None,
) -> ModelErrors:
    """Compare the brake's model with measured pulls.

    `files` are one or more paths or traces. See identify.validation.metrics for the window.
    `uncalibrated` contains the same errors for the brake with a scale factor of 1 and the sheets'
    own stiffness. A warning names files that were also used for the calibration. `exclude` leaves
    out files, each with its reason in `because` (in Python also {file: reason}). `tare` subtracts
    the force before the rise.
    """
    from layerjam.laboratory.identify.curves import make_curves
    from layerjam.laboratory.identify.provenance import find_calibration_files
    from layerjam.laboratory.identify.validation.metrics import (
        compare_pull,
        uncalibrated,
        validate_curves,
    )
    from layerjam.laboratory.identify.validation.several import (
        FILE,
        add_pull_table,
        check_validation,
        make_error_row,
        make_error_rows,
    )

    files, specimens_out, exclusions = left_out.split_excluded(files, options)
    used, refusals, file_warnings = read_pulls(
        files, brake, vacuum, options, compare_pull, progress, specimens_out, tare
    )
    curves = make_curves(used)
    validation = add_pull_table(validate_curves(curves, brake.brake), curves, brake.brake)
    before = None
    warnings = [*brake.warnings(), *file_warnings, *condition_notices(validation.pulls)]
    try:
        before = validate_curves(curves, uncalibrated(brake.brake))
    except FitError as error:
        sentence = f"no comparison with the model before calibration: {error}"
        warnings.append(Notice(sentence, "uncalibrated"))
    names = find_calibration_files(brake, [t.path for t, _, _ in used])
    if names:
        sentence = (
            f"{', '.join(names)}: also used to calibrate this brake, so it does not test the model"
        )
        warnings.append(Notice(sentence, "calibrated-on"))
    return ModelErrors.create(
        make_error_rows(validation),
        judge(check_validation(validation, len(names)), accept),
        uncalibrated=before and make_error_rows(before),
        files=[make_error_row(c, FILE) for c in validation.curves],
        pulls=make_pull_rows(validation.pulls),
        excluded=exclusions,
        understood=describe_readings(t for t, _, _ in used),
        refused=refusals,
        warnings=warnings,
        record=(brake, validation),
        before=before,
        calibrated_on=names,
        traces=[t for t, _, _ in used],
    )
