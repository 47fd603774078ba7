"""`validate`: how far the model lies from measured pulls."""

from __future__ import annotations

from layerjam.identify.columns import Choices
from layerjam.identify.metrics import compare, validate_pulls
from layerjam.identify.provenance import calibrated_on
from layerjam.verbs.answer import Answer, AnyBrake, Quantity, brake_at
from layerjam.verbs.files import Paths, pulls


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
    used, refused, odd = pulls(files, file, vacuum, choices, compare)
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
