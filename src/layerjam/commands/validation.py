"""`validate`: how far the model lies from measured pulls."""

from __future__ import annotations

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at
from layerjam.commands.files import Paths, Progress, pulls
from layerjam.errors import FitError
from layerjam.identify.curves import curves_of
from layerjam.identify.provenance import calibrated_on
from layerjam.identify.validation.metrics import Validation, compare, uncalibrated, validate_curves
from layerjam.identify.validation.table import UNITS, file_row, summary, validation_checks
from layerjam.measure.options import ReadingOptions
from layerjam.measure.trace import Trace


def validate(
    brake: AnyBrake,
    files: Paths,
    *,
    vacuum: Quantity | None = None,
    atmosphere: Quantity | None = None,
    choices: ReadingOptions | None = None,
    progress: Progress | None = None,
) -> Answer:
    """How far the brake's model lies from measured pulls.

    Over which window, identify.validation.metrics says.

    `uncalibrated` holds the same errors of the brake with a scale factor of 1 and the sheets' own
    stiffness. Says so where the brake was calibrated on one of the files. `record` is
    (BrakeFile, Validation).
    """
    answer, _, _ = validated(brake, files, vacuum, atmosphere, choices, progress)
    return answer


def validated(
    brake: AnyBrake,
    files: Paths,
    vacuum: Quantity | None,
    atmosphere: Quantity | None,
    choices: ReadingOptions | None,
    progress: Progress | None = None,
) -> tuple[Answer, Validation | None, list[Trace]]:
    """`validate`'s answer, the Validation before calibration, and the traces that were used."""
    file = brake_at(brake, atmosphere)
    used, refused, odd = pulls(files, file, vacuum, choices, compare, progress)
    curves = curves_of(used)
    result = validate_curves(curves, file.brake)
    warnings = file.warnings() + odd
    try:
        before: Validation | None = validate_curves(curves, uncalibrated(file.brake))
    except FitError as error:
        before = None
        warnings.append(f"before calibration there is nothing to compare: {error}")
    same = calibrated_on(file, [t.path for t, _, _ in used])
    if same:
        warnings.append(
            f"{', '.join(same)}: this brake was calibrated on it, which is no test of the model"
        )
    answer = Answer(
        values={
            **summary(result),
            "uncalibrated": None if before is None else summary(before),
            "checks": [
                {"name": c.name, "passed": c.passed, "sentence": c.sentence}
                for c in validation_checks(result, len(same))
            ],
            "files": [file_row(c) for c in result.curves],
            "refused": refused,
        },
        units=UNITS,
        warnings=warnings,
        refused=refused,
        record=(file, result),
    )
    return answer, before, [t for t, _, _ in used]
